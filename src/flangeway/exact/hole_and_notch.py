"""Plane elasticity in closed form: thick cylinders, a plate with a hole, a re-entrant corner."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import are_finite, check_finite, check_positive
from flangeway.errors import InputError, short
from flangeway.types import Floats, floats

# --- Thick cylinders and a plate with a hole in closed form.


@dataclass(frozen=True)
class ThickCylinder:
    """Isotropic cylinder under internal and external pressure (Lame, 1852; Timoshenko and Goodier, 1970, art. 28).

    Parameters
    ----------
    inner_radius, outer_radius
        Radii, 0 < inner < outer.
    inner_pressure, outer_pressure
        Pressures, positive in compression.

    """

    inner_radius: float
    outer_radius: float
    inner_pressure: float
    outer_pressure: float = 0.0

    def __post_init__(self) -> None:
        radii = self.inner_radius, self.outer_radius
        if not (are_finite(radii, 2) and 0.0 < radii[0] < radii[1]):
            raise InputError(
                f"ThickCylinder(inner_radius={short(radii[0])}, outer_radius={short(radii[1])})",
                "0 < inner_radius < outer_radius",
                "give both radii",
            )
        for name in ("inner_pressure", "outer_pressure"):
            check_finite("ThickCylinder", name, getattr(self, name))

    @property
    def _constants(self) -> tuple[float, float]:
        """Constants A and B of ``A -+ B / r^2``."""
        inner, outer = self.inner_radius**2, self.outer_radius**2
        mean = (self.inner_pressure * inner - self.outer_pressure * outer) / (outer - inner)
        varying = (self.inner_pressure - self.outer_pressure) * inner * outer / (outer - inner)
        return mean, varying

    def radial_stress(self, radius: Floats) -> Floats:
        """Radial stress at radii (n,)."""
        mean, varying = self._constants
        return mean - varying / np.asarray(radius) ** 2

    def hoop_stress(self, radius: Floats) -> Floats:
        """Hoop stress at radii (n,)."""
        mean, varying = self._constants
        return mean + varying / np.asarray(radius) ** 2

    def radial_displacement(self, radius: Floats, young: float, poisson: float, *, plane_strain: bool = True) -> Floats:
        """Radial displacement at radii (n,), with no strain or no stress along the axis."""
        mean, varying = self._constants
        r = np.asarray(radius)
        if plane_strain:
            return (1.0 + poisson) / young * ((1.0 - 2.0 * poisson) * mean * r + varying / r)
        return ((1.0 - poisson) * mean * r + (1.0 + poisson) * varying / r) / young


@dataclass(frozen=True)
class PlateWithHole:
    """Infinite plate with a circular hole at the origin under tension along x (Kirsch, 1898).

    Parameters
    ----------
    radius
        Radius of the hole, > 0.
    tension
        Stress xx far away.

    """

    radius: float
    tension: float

    def __post_init__(self) -> None:
        check_positive("PlateWithHole", "radius", self.radius, "a positive length", "give the hole's radius")
        check_finite("PlateWithHole", "tension", self.tension)

    def stresses(self, points: Floats) -> Floats:
        """Stresses xx, yy, xy at points (n, 2) outside of the hole, shape (n, 3)."""
        x, y = np.asarray(points).T
        square = (self.radius / np.hypot(x, y)) ** 2
        angle = np.arctan2(y, x)
        two, four = np.cos(2.0 * angle), np.cos(4.0 * angle)
        xx = 1.0 - square * (1.5 * two + four) + 1.5 * square**2 * four
        yy = -square * (0.5 * two - four) - 1.5 * square**2 * four
        xy = -square * (0.5 * np.sin(2.0 * angle) + np.sin(4.0 * angle)) + 1.5 * square**2 * np.sin(4.0 * angle)
        return self.tension * np.stack((xx, yy, xy), axis=1)

    def displacements(self, points: Floats, shear_modulus: float, kolosov: float) -> Floats:
        """Displacements (n, 2) at points (n, 2), none at the origin's image.

        Parameters
        ----------
        points
            Points outside of the hole.
        shear_modulus
            Shear modulus G.
        kolosov
            ``3 - 4 nu`` in plane strain, ``(3 - nu) / (1 + nu)`` in plane stress.

        """
        x, y = np.asarray(points).T
        relative, angle = np.hypot(x, y) / self.radius, np.arctan2(y, x)
        ux = relative * (kolosov + 1.0) * np.cos(angle)
        ux += 2.0 / relative * ((1.0 + kolosov) * np.cos(angle) + np.cos(3.0 * angle))
        ux -= 2.0 / relative**3 * np.cos(3.0 * angle)
        uy = relative * (kolosov - 3.0) * np.sin(angle)
        uy += 2.0 / relative * ((1.0 - kolosov) * np.sin(angle) + np.sin(3.0 * angle))
        uy -= 2.0 / relative**3 * np.sin(3.0 * angle)
        return self.tension * self.radius / (8.0 * shear_modulus) * np.stack((ux, uy), axis=1)


# --- Singular stresses at the re-entrant corner of an L-shaped body in closed form.


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

    def __post_init__(self) -> None:
        for name in ("shear_modulus", "kolosov"):
            check_positive("Notch", name, getattr(self, name))

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
