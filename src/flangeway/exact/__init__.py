"""Solutions in closed form."""

from flangeway.exact.half_space import half_space_blocks, half_space_influence
from flangeway.exact.hertz import LineContact, PointContact, contact_modulus
from flangeway.exact.hole import PlateWithHole

__all__ = [
    "LineContact",
    "PlateWithHole",
    "PointContact",
    "contact_modulus",
    "half_space_blocks",
    "half_space_influence",
]
