"""Contact of parallel cylinders by Hertz (Johnson, 1985, "Contact Mechanics", 4.2; seed Table 2 as corrected)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LineContact:
    """Contact of two cylinders with parallel axes under a force per length.

    Parameters
    ----------
    force_per_length
        Force P per length out of the plane, > 0.
    relative_curvature
        Sum of the two curvatures at the contact, ``1/R = 1/R1 + 1/R2 > 0``; a concave side counts negative.
    modulus
        Contact modulus E*, with ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``.

    """

    force_per_length: float
    relative_curvature: float
    modulus: float

    def __post_init__(self) -> None:
        for name in ("force_per_length", "relative_curvature", "modulus"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(
                    f"LineContact({name}={value})",
                    "a positive number",
                    "check the sign of the load and of the curvatures: convex is positive",
                )

    @property
    def half_width(self) -> float:
        """Half width a of the contact, ``a^2 = 4 P R / (pi E*)``."""
        radius = 1.0 / self.relative_curvature
        return float(np.sqrt(4.0 * self.force_per_length * radius / (np.pi * self.modulus)))

    @property
    def max_pressure(self) -> float:
        """Largest pressure ``p0 = 2 P / (pi a)``."""
        return 2.0 * self.force_per_length / (np.pi * self.half_width)

    def pressure(self, x: ArrayLike) -> Floats:
        """Pressure at distances x from the middle, ``p0 sqrt(1 - x^2 / a^2)``, zero outside."""
        relative = 1.0 - (np.asarray(x, dtype=np.float64) / self.half_width) ** 2
        return self.max_pressure * np.sqrt(np.maximum(relative, 0.0))


def contact_modulus(plane_modulus_1: float, plane_modulus_2: float) -> float:
    """Contact modulus E* of two bodies with plane moduli ``E / (1 - nu^2)``."""
    return 1.0 / (1.0 / plane_modulus_1 + 1.0 / plane_modulus_2)
