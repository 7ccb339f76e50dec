"""Solutions in closed form."""

from flangeway.exact.half_space import half_space_blocks, half_space_influence
from flangeway.exact.hertz import LineContact, PointContact, contact_modulus
from flangeway.exact.hole_and_notch import Notch, PlateWithHole, ThickCylinder
from flangeway.exact.torsion_bars import (
    CircularSector,
    Ellipse,
    EquilateralTriangle,
    Rectangle,
    TorsionSection,
    thin_closed_torsion_constant,
    thin_open_torsion_constant,
)

__all__ = [
    "CircularSector",
    "Ellipse",
    "EquilateralTriangle",
    "LineContact",
    "Notch",
    "PlateWithHole",
    "PointContact",
    "Rectangle",
    "ThickCylinder",
    "TorsionSection",
    "contact_modulus",
    "half_space_blocks",
    "half_space_influence",
    "thin_closed_torsion_constant",
    "thin_open_torsion_constant",
]
