"""Plane elasticity in closed form: a plate with a hole."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import check_finite, check_positive
from flangeway.types import Floats


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
