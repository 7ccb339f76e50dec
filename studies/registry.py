"""What ``flangeway reproduce`` can compute, in the order of the page of validation."""

from studies.conicity import CONICITY
from studies.contact_patch import CONTACT_PATCH
from studies.curved import CURVED
from studies.damage import DAMAGE
from studies.elasticity import ELASTICITY
from studies.forms import FORMS
from studies.friction.friction_study import FRICTION
from studies.hertz import HERTZ
from studies.rolling.rolling_study import ROLLING
from studies.spatial.spatial_study import SPATIAL
from studies.study import Study
from studies.torsion import TORSION
from studies.vem_contact import VEM_CONTACT
from studies.wheel_rail.wheel_rail_study import WHEEL_RAIL
from studies.wheelset3d.wheelset3d_study import WHEELSET3D

STUDIES: dict[str, Study] = {
    study.name: study
    for study in (
        TORSION,
        ELASTICITY,
        HERTZ,
        CONTACT_PATCH,
        WHEEL_RAIL,
        SPATIAL,
        ROLLING,
        WHEELSET3D,
        CONICITY,
        CURVED,
        FRICTION,
        VEM_CONTACT,
        FORMS,
        DAMAGE,
    )
}
