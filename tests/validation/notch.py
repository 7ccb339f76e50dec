"""A re-entrant corner in closed form."""

from dataclasses import dataclass

import numpy as np

from flangeway.types import Floats, floats

HALF_OPENING = 0.75 * np.pi
"""Half of the angle that the body fills at the corner."""

EXPONENT = 0.5444837367824622
"""Exponent of the symmetric mode: the least positive root of ``sin(1.5 pi e) + e sin(1.5 pi) = 0``."""


@dataclass(frozen=True)
class Notch:
    """Symmetric mode at a corner of 270 degrees at the origin with free sides along -x and -y (Williams, 1952).

    Displacements grow as the radius to the power of `EXPONENT`, stresses as its power less one. Written as in Szabo and
    Babuska, 1991, "Finite element analysis", section 10.1, about the bisector of the body.

    Parameters
    ----------
    shear_modulus
        Shear modulus G.
    kolosov
        ``3 - 4 nu`` in plane strain, ``(3 - nu) / (1 + nu)`` in plane stress.

    """

    shear_modulus: float
    kolosov: float

    @property
    def _mixture(self) -> float:
        e = EXPONENT
        return float((1.0 - e) / (1.0 + e) * np.sin((e - 1.0) * HALF_OPENING) / np.sin((e + 1.0) * HALF_OPENING))

    def displacements(self, points: Floats) -> Floats:
        """Displacements (n, 2) at points (n, 2), none at the corner."""
        radius, angle = _polar(points)
        e, q = EXPONENT, self._mixture * (EXPONENT + 1.0)
        along = (self.kolosov - q) * np.cos(e * angle) - e * np.cos((e - 2.0) * angle)
        across = (self.kolosov + q) * np.sin(e * angle) + e * np.sin((e - 2.0) * angle)
        scale = radius**e / (2.0 * self.shear_modulus) / np.sqrt(2.0)
        return np.stack((scale * (along - across), scale * (along + across)), axis=1)

    def stresses(self, points: Floats) -> Floats:
        """Stresses xx, yy, xy at points (n, 2) other than the corner, shape (n, 3)."""
        radius, angle = _polar(points)
        e, q = EXPONENT, self._mixture * (EXPONENT + 1.0)
        first, third = (e - 1.0) * angle, (e - 3.0) * angle
        scale = e * radius ** (e - 1.0)
        along = (2.0 - q) * np.cos(first) - (e - 1.0) * np.cos(third)
        across = (2.0 + q) * np.cos(first) + (e - 1.0) * np.cos(third)
        shear = (e - 1.0) * np.sin(third) + q * np.sin(first)
        middle, half = (along + across) / 2.0, (along - across) / 2.0
        return np.stack((scale * (middle - shear), scale * (middle + shear), scale * half), axis=1)


def _polar(points: Floats) -> tuple[Floats, Floats]:
    """Radius and angle about the corner, from the bisector of the body along x = y."""
    x, y = floats(points).T
    return np.hypot(x, y), np.arctan2(y - x, x + y)
