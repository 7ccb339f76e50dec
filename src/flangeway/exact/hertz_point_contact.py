"""Contact of two curved bodies in an ellipse by Hertz (Johnson, 1985, "Contact Mechanics", 4.2)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, elliprd

from flangeway.checks import check_positive

NEARLY_ONE = 1.0 - 1e-14


@dataclass(frozen=True)
class PointContact:
    """Contact of two bodies whose gap is ``(x^2 / R_x + z^2 / R_z) / 2``.

    Parameters
    ----------
    force
        Force P > 0.
    radius_x, radius_z
        Relative radii of curvature, of both bodies together, > 0.
    modulus
        Contact modulus E*, with ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``.

    """

    force: float
    radius_x: float
    radius_z: float
    modulus: float

    def __post_init__(self) -> None:
        for name in ("force", "radius_x", "radius_z", "modulus"):
            advice = "check the sign of the load and of the curvatures: convex is positive"
            check_positive("PointContact", name, getattr(self, name), advice=advice)

    @cached_property
    def _square(self) -> float:
        """Square m of the ellipse's eccentricity, ``B / A = (E(m) / (1 - m) - K(m)) / (K(m) - E(m))``."""
        ratio = max(self.radius_x, self.radius_z) / min(self.radius_x, self.radius_z)
        return float(brentq(lambda m: elliprd(0.0, 1.0, 1.0 - m) - ratio * elliprd(0.0, 1.0 - m, 1.0), 0.0, NEARLY_ONE))

    @cached_property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes of the ellipse along x and z."""
        m, curvatures = self._square, (1.0 / self.radius_x + 1.0 / self.radius_z) / 2.0
        long = float(np.cbrt(1.5 * self.force * ellipe(m) / (np.pi * self.modulus * (1.0 - m) * curvatures)))
        short = long * float(np.sqrt(1.0 - m))
        return (long, short) if self.radius_x > self.radius_z else (short, long)

    @property
    def max_pressure(self) -> float:
        """Maximum pressure ``p0 = 3 P / (2 pi a b)``."""
        return 1.5 * self.force / (np.pi * float(np.prod(self.semi_axes)))

    @property
    def approach(self) -> float:
        """Approach of distant points of half-spaces, ``p0 b K(m) / E*`` with the smaller semi-axis b."""
        return self.max_pressure / self.modulus * min(self.semi_axes) * float(ellipk(self._square))
