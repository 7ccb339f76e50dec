"""What ``flangeway reproduce`` can compute, in the order of the page of validation."""

from collections.abc import Callable, Iterator
from typing import Any

from studies.conicity import CONICITY
from studies.contact_patch.contact_patch_reproduced import reproduce_contact_patch
from studies.curved.curved_reproduced import reproduce_curved
from studies.elasticity.elasticity_reproduced import reproduce_elasticity
from studies.forms import FORMS
from studies.friction.friction_reproduced import reproduce_friction
from studies.hertz.hertz_reproduced import reproduce_hertz
from studies.rolling.rolling_reproduced import reproduce_rolling
from studies.spatial.spatial_reproduced import reproduce_spatial
from studies.study import Limit, Row, Run, Study
from studies.torsion import TORSION
from studies.vem_contact.vem_contact_reproduced import reproduce_vem_contact
from studies.wheel_rail.wheel_rail_reproduced import reproduce_wheel_rail
from studies.wheelset3d.wheelset3d_reproduced import reproduce_wheelset3d


def adapted(name: str, compute: Callable[..., Any], *, brief: bool = True) -> Study:
    """Return a study of what still returns a `Reproduced`."""

    def rows(run: Run) -> Iterator[Row]:
        computed = compute(quick=run.quick and not brief, progress=run.progress)
        run.failures.extend(computed.failures)
        for n in computed.numbers:
            limit = Limit(n.limit, n.within) if n.required else None
            yield Row(n.table, n.code, n.quantity, n.unit, n.computed, n.published, limit, n.note)

    return Study(name, rows)


STUDIES: dict[str, Study] = {
    study.name: study
    for study in (
        TORSION,
        adapted("elasticity", reproduce_elasticity),
        adapted("hertz", reproduce_hertz, brief=False),
        adapted("contact-patch", reproduce_contact_patch),
        adapted("wheel-rail", reproduce_wheel_rail, brief=False),
        adapted("spatial", reproduce_spatial, brief=False),
        adapted("rolling", reproduce_rolling),
        adapted("wheelset3d", reproduce_wheelset3d, brief=False),
        CONICITY,
        adapted("curved", reproduce_curved),
        adapted("friction", reproduce_friction),
        adapted("vem-contact", reproduce_vem_contact),
        FORMS,
    )
}
