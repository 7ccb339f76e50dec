"""Contact by Hertz: of parallel cylinders in a line, and of two curved bodies in an ellipse."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, elliprd

from flangeway.checks import check_positive
from flangeway.errors import InputError
from flangeway.types import Floats, floats

# --- Contact of parallel cylinders by Hertz (Johnson, 1985, "Contact Mechanics", 4.2; Moherdaui 2021, Table 2).


DEPTH_OF_MAX_SHEAR = 0.7861513777574233
"""Depth relative to the half width where the shear stress on the axis is greatest, the root of ``(sqrt(5) - 1) /
2``."""


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
            advice = "check the sign of the load and of the curvatures: convex is positive"
            check_positive("LineContact", name, getattr(self, name), advice=advice)

    @classmethod
    def of_max_pressure(cls, max_pressure: float, relative_curvature: float, modulus: float) -> Self:
        """Contact with a given maximum pressure, ``P = pi R p0^2 / E*``."""
        return cls(
            np.pi * max_pressure * abs(max_pressure) / (relative_curvature * modulus), relative_curvature, modulus
        )

    @property
    def half_width(self) -> float:
        """Half width a of the contact, ``a^2 = 4 P R / (pi E*)``."""
        radius = 1.0 / self.relative_curvature
        return float(np.sqrt(4.0 * self.force_per_length * radius / (np.pi * self.modulus)))

    @property
    def max_pressure(self) -> float:
        """Maximum pressure ``p0 = 2 P / (pi a)``."""
        return 2.0 * self.force_per_length / (np.pi * self.half_width)

    @property
    def max_shear(self) -> float:
        """Maximum in-plane shear stress, ``0.3003 p0`` at `DEPTH_OF_MAX_SHEAR` below it (Moherdaui 2021, 2.75)."""
        depth = DEPTH_OF_MAX_SHEAR
        return self.max_pressure * (depth - depth**2 / float(np.hypot(1.0, depth)))

    def pressure(self, x: ArrayLike) -> Floats:
        """Pressure at distances x from the middle, ``p0 sqrt(1 - x^2 / a^2)``, zero outside."""
        relative = 1.0 - (floats(x) / self.half_width) ** 2
        return self.max_pressure * np.sqrt(np.maximum(relative, 0.0))

    @property
    def curve(self) -> tuple[Floats, Floats]:
        """Distances from the middle, from one end to the other and closer at both, and the pressures there."""
        x = self.half_width * np.sin(np.linspace(-np.pi / 2.0, np.pi / 2.0, 181))
        return x, self.pressure(x)

    def stresses(self, x: ArrayLike, depth: ArrayLike) -> Floats:
        """Stresses in a half plane (McEwen, 1949; Johnson, 1985, eq. 4.49; on the axis Moherdaui (2021) 2.73 to 2.75).

        Parameters
        ----------
        x
            Distances from the middle along the surface, of a shape that fits that of `depth`.
        depth
            Depths z >= 0 below the surface.

        Returns
        -------
        Floats
            Normal stress along the surface, normal stress across it and their shear ``xz`` with z pointing into the
            body, tension positive, shape (..., 3).

        Raises
        ------
        InputError
            If a depth is negative.

        """
        along, z = np.broadcast_arrays(floats(x), floats(depth))
        if (z < 0.0).any():
            raise InputError(f"a depth of {z.min():g}", "depths >= 0", "measure them from the surface into the body")
        a = self.half_width
        difference = a**2 - along**2 + z**2
        root = np.hypot(difference, 2.0 * along * z)
        # the smaller of the two squares from their product, which loses no digits
        larger = (root + np.abs(difference)) / 2.0
        smaller = np.where(larger > 0.0, (along * z) ** 2 / np.where(larger > 0.0, larger, 1.0), 0.0)
        m = np.sqrt(np.where(difference > 0.0, larger, smaller))
        n = np.copysign(np.sqrt(np.where(difference > 0.0, smaller, larger)), along)
        total = np.maximum(root, np.finfo(np.float64).tiny)
        share = (z**2 + n**2) / total
        along_surface = m * (1.0 + share) - 2.0 * z
        across = m * (1.0 - share)
        shear = n * (m**2 - z**2) / total
        return -(self.max_pressure / a) * np.stack((along_surface, across, shear), axis=-1)


def contact_modulus(plane_modulus_1: float, plane_modulus_2: float) -> float:
    """Contact modulus E* of two bodies with plane moduli ``E / (1 - nu^2)``."""
    return 1.0 / (1.0 / plane_modulus_1 + 1.0 / plane_modulus_2)


# --- Contact of two curved bodies in an ellipse by Hertz (Johnson, 1985, "Contact Mechanics", 4.2).


BELOW_ONE = 1.0 - 1e-14


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
        return float(brentq(lambda m: elliprd(0.0, 1.0, 1.0 - m) - ratio * elliprd(0.0, 1.0 - m, 1.0), 0.0, BELOW_ONE))

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
