"""Numbers of contact patches in three dimensions: of wheels on rails, and of any two bodies."""

import math
from typing import Any, Protocol

from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.exact import PointContact
from flangeway.quantities import Quantity

SEMI_AXES = ("a", "b")
ON_SURFACE = ("across", "along")


class EllipticPatch(Protocol):
    """A patch with its equivalent ellipse."""

    @property
    def ellipse(self) -> ContactEllipse:
        """Resultant, and the ellipse with the same second moments of pressure as Hertz's."""

    @property
    def hertz(self) -> PointContact | None:
        """Hertz's contact for the same force and curvatures; None where these vary too much within the patch."""

    @property
    def remark(self) -> str:
        """What limits the maximum pressure, empty if nothing does."""


MAX_PRESSURE: Quantity[EllipticPatch] = Quantity(
    "max_pressure", "maximum pressure", "ellipse.max_pressure", "MPa", ".1f", remark=lambda p: p.remark
)
HERTZ_PRESSURE: Quantity[EllipticPatch] = Quantity(
    "hertz_pressure",
    "  Hertz",
    "hertz.max_pressure",
    "MPa",
    ".1f",
    meaning="maximum pressure of half-spaces with the same force and curvatures; none where these vary too much",
)
AXES: Quantity[EllipticPatch] = Quantity(
    "semi_axes",
    "semi-axis",
    "ellipse.semi_axes",
    "mm",
    ".3f",
    SEMI_AXES,
    "a is the longer one, of the ellipse with the same second moments of pressure as Hertz's",
)
HERTZ_AXES: Quantity[EllipticPatch] = Quantity(
    "hertz_semi_axes", "  Hertz", "hertz.semi_axes", "mm", ".3f", SEMI_AXES, "as Hertz's pressure"
)
ANGLE: Quantity[EllipticPatch] = Quantity(
    "angle",
    "orientation of the major axis",
    lambda p: math.degrees(p.ellipse.angle_rad),
    "deg",
    "z.1f",
    meaning="from z to the major axis",
)
AREA: Quantity[EllipticPatch] = Quantity("area", "area", "ellipse.area", "mm²", ".2f")
CELLS: Quantity[Any] = Quantity("cells", "cells", "ellipse.cells", "", "d", ON_SURFACE)
