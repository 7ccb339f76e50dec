"""Solutions in closed form."""

from flangeway.exact.half_space import half_space_blocks, half_space_influence
from flangeway.exact.hertz import LineContact, PointContact, contact_modulus

__all__ = [
    "LineContact",
    "PointContact",
    "contact_modulus",
    "half_space_blocks",
    "half_space_influence",
]
