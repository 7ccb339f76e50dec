"""What ``flangeway reproduce`` can compute, in the order of the page of validation."""

from studies import conicity, contact_patch, curved, damage, elasticity, forms, hertz, torsion, vem_contact
from studies.friction import friction_study
from studies.rolling import rolling_study
from studies.spatial import spatial_study
from studies.study import Study
from studies.wheel_rail import wheel_rail_study
from studies.wheelset3d import wheelset3d_study

STUDIES = {
    name: Study(name, module.rows)
    for name, module in {
        "torsion": torsion,
        "elasticity": elasticity,
        "hertz": hertz,
        "contact-patch": contact_patch,
        "wheel-rail": wheel_rail_study,
        "spatial": spatial_study,
        "rolling": rolling_study,
        "wheelset3d": wheelset3d_study,
        "conicity": conicity,
        "curved": curved,
        "friction": friction_study,
        "vem-contact": vem_contact,
        "forms": forms,
        "damage": damage,
    }.items()
}
