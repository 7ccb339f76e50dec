"""The case of a wheelset in a curve."""

from typing import ClassVar, Literal

from pydantic import Field

from flangeway.cases.wheelset.wheelset_case import WheelsetCase

PUBLISHED_CM = {
    ("fem", 1): (-3.122e-1, 7.025e-1, 3.273e-4),
    ("fem", 2): (-3.126e-1, 7.330e-1, 3.404e-4),
    ("vem", 1): (-3.122e-1, 7.073e-1, 3.291e-4),
    ("vem", 2): (-3.125e-1, 7.309e-1, 3.395e-4),
}
"""Vertical and horizontal translation in cm and rotation in rad by method and order (Moherdaui 2021, Table 16)."""


class WheelsetCurveCase(WheelsetCase):
    """A wheelset in a curve to the left, radius 400 m at 70 km/h, superelevation 3 cm (Moherdaui 2021, Figure 90b)."""

    name: ClassVar[str] = "wheelset-curve"
    title: ClassVar[str] = "A wheelset runs through a curve, pressed to its outer rail"

    lateral_force_kN: float = Field(  # noqa: N815
        28.4,
        description="horizontal force at the centre of gravity, to the right: centrifugal force of 400 m at 70 km/h",
    )
    superelevation_mm: float | Literal["from-speed"] = Field(
        30.0,
        description="height of the right rail over the left one, of the outer rail if left out; "
        "from-speed: what balances speed and radius",
    )
