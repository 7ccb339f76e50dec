"""Solutions in closed form."""

from flangeway.exact.cylinder_and_hole import PlateWithHole, ThickCylinder
from flangeway.exact.half_space import half_space_blocks, half_space_influence
from flangeway.exact.hertz_line_contact import LineContact, contact_modulus
from flangeway.exact.hertz_point_contact import PointContact
from flangeway.exact.notch import Notch
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
