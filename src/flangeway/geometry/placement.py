"""Rigid placement of a local frame in space, with an optional mirror."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_finite, check_kind
from flangeway.geometry.arrays import Point, as_point, as_points
from flangeway.types import Floats


@dataclass(frozen=True)
class Placement:
    """Position of a local frame: ``x = R(rotation) M X + translation``.

    ``M = diag(-1, 1)`` if mirrored, else the identity; the mirror acts first. One placement serves
    points, outlines and meshes, so that the left wheel is the right one mirrored.

    Parameters
    ----------
    rotation_rad
        Counter-clockwise rotation in radians.
    translation
        Place of the local origin in space (2,).
    mirrored
        Whether the local x is reflected before the rotation.

    Raises
    ------
    InputError
        If a number is not finite.
    """

    rotation_rad: float = 0.0
    translation: Point = (0.0, 0.0)
    mirrored: bool = False

    def __post_init__(self) -> None:
        """Check the numbers and store the translation as a pair of floats."""
        check_finite("Placement", "rotation_rad", self.rotation_rad, "a finite angle", "give it in radians")
        check_kind("Placement", "mirrored", self.mirrored, bool | np.bool_, "True or False", "choose one")
        object.__setattr__(self, "translation", as_point(self.translation, "translation"))

    @classmethod
    def about(cls, centre: ArrayLike, rotation_rad: float) -> Self:
        """Return the rotation about a point of space that stays where it is."""
        fixed = as_points(centre, "centre")[0]
        moved = cls(rotation_rad).matrix @ fixed
        return cls(rotation_rad, (float(fixed[0] - moved[0]), float(fixed[1] - moved[1])))

    @property
    def matrix(self) -> Floats:
        """Linear part ``R M`` (2, 2); its determinant is -1 if mirrored."""
        cosine, sine = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        first = -1.0 if self.mirrored else 1.0
        return np.array([[first * cosine, -sine], [first * sine, cosine]])

    def points(self, local_points: ArrayLike) -> Floats:
        """Return local points (n, 2) in space (n, 2)."""
        return as_points(local_points) @ self.matrix.T + np.array(self.translation)

    def vectors(self, local_vectors: ArrayLike) -> Floats:
        """Return local vectors (n, 2) in space (n, 2), without the translation."""
        return as_points(local_vectors, "vectors") @ self.matrix.T

    def part(self, fraction: float) -> "Placement":
        """Return the placement that turns and shifts by a fraction of this one."""
        x, y = self.translation
        return Placement(fraction * self.rotation_rad, (fraction * x, fraction * y))

    def inverse(self) -> "Placement":
        """Return the placement that brings space back to the local frame."""
        back = -(self.matrix.T @ np.array(self.translation))
        # M R(-a) = R(a) M: a mirrored placement keeps its angle
        angle = self.rotation_rad if self.mirrored else -self.rotation_rad
        return Placement(angle, (float(back[0]), float(back[1])), self.mirrored)

    def after(self, other: "Placement") -> "Placement":
        """Return the composition: first `other`, then this placement."""
        turn = -other.rotation_rad if self.mirrored else other.rotation_rad
        moved = self.points([other.translation])[0]
        return Placement(self.rotation_rad + turn, (float(moved[0]), float(moved[1])), self.mirrored != other.mirrored)
