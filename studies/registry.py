"""What ``flangeway reproduce`` can compute, write and print, by name."""

from typing import get_type_hints

from matplotlib.figure import Figure

from flangeway.errors import InputError
from flangeway.report.figures.plots import plot_result
from studies.contact_patch.contact_patch_page import CONTACT_PATCH
from studies.curved.curved_chapter import CURVED
from studies.elasticity.elasticity_page import ELASTICITY
from studies.en15302.en15302_chapter import CONICITY
from studies.friction.friction_chapter import FRICTION
from studies.hertz.hertz_page import HERTZ
from studies.published_numbers import Reproduced
from studies.reproduction import Reproduction
from studies.rolling.rolling_chapter import ROLLING
from studies.spatial.spatial_chapter import SPATIAL
from studies.torsion.torsion_page import TORSION
from studies.vem_contact.vem_contact_chapter import VEM_CONTACT
from studies.wheel_rail.wheel_rail_page import WHEEL_RAIL
from studies.wheelset3d.wheelset3d_chapter import WHEELSET3D

REPRODUCTIONS: dict[str, Reproduction] = {
    "torsion": TORSION,
    "elasticity": ELASTICITY,
    "hertz": HERTZ,
    "contact-patch": CONTACT_PATCH,
    "wheel-rail": WHEEL_RAIL,
    "spatial": SPATIAL,
    "rolling": ROLLING,
    "wheelset3d": WHEELSET3D,
    "conicity": CONICITY,
    "curved": CURVED,
    "friction": FRICTION,
    "vem-contact": VEM_CONTACT,
}


@plot_result.register
def _(result: Reproduced) -> Figure:
    for each in REPRODUCTIONS.values():
        if isinstance(result, get_type_hints(each.compute)["return"]):
            return each.chapter.pictures[0].draw(result)
    raise InputError(f"a picture of {type(result).__name__}", "a study of `flangeway reproduce`", "draw its table")
