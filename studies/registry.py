"""What ``flangeway reproduce`` can compute, in the order of the page of validation."""

from collections.abc import Callable, Iterator
from typing import Any

from studies.conicity import CONICITY
from studies.contact_patch import CONTACT_PATCH
from studies.curved import CURVED
from studies.elasticity import ELASTICITY
from studies.forms import FORMS
from studies.friction.friction_reproduced import reproduce_friction
from studies.hertz import HERTZ
from studies.rolling.rolling_reproduced import reproduce_rolling
from studies.spatial.spatial_reproduced import reproduce_spatial
from studies.study import Limit, Row, Run, Study
from studies.torsion import TORSION
from studies.vem_contact import VEM_CONTACT
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
        ELASTICITY,
        HERTZ,
        CONTACT_PATCH,
        adapted("wheel-rail", reproduce_wheel_rail, brief=False),
        adapted("spatial", reproduce_spatial, brief=False),
        adapted("rolling", reproduce_rolling),
        adapted("wheelset3d", reproduce_wheelset3d, brief=False),
        CONICITY,
        CURVED,
        adapted("friction", reproduce_friction),
        VEM_CONTACT,
        FORMS,
    )
}
