"""What ``flangeway reproduce`` can compute, in the order of the page of validation."""

from flangeway_studies import (
    conicity,
    contact_patch,
    curved,
    damage,
    elasticity,
    forms,
    hertz,
    polyhedra,
    rolling_study,
    spatial_study,
    torsion,
    vem_contact,
    wheel_rail_study,
    wheelset3d_study,
)
from flangeway_studies.friction import friction_study
from flangeway_studies.study import Study

STUDIES = {
    name: Study(name, module.rows)
    for name, module in {
        "torsion": torsion,
        "elasticity": elasticity,
        "polyhedra": polyhedra,
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
