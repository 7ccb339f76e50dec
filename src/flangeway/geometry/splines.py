"""Smooth curve through points, which edges of a mesh can follow."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import as_points, chain_lengths, norms, step_lengths
from flangeway.geometry.placement import Placement
from flangeway.types import Floats, floats

SAMPLES = 16  # between two points, to start the search of the closest place
CLOSED = 1e-12  # distance of the ends relative to the coordinates, below which it is round-off
STEPS = 20  # of Newton's method, at most


@dataclass(frozen=True, eq=False)
class Spline:
    """Cubic spline through points, with continuous curvature; parameters in proportion to the lengths of the chords.

    Without a condition on the slope at open ends ("not a knot"). Closed if the first point is repeated at the end, up
    to `CLOSED` of the coordinates.

    Parameters
    ----------
    points
        Points (n, 2) in order, 4 or more.

    Raises
    ------
    InputError
        If there are fewer points, one is not finite, or two neighbours coincide.
    """

    points: Floats

    def __post_init__(self) -> None:
        """Check the points and keep a read-only copy."""
        points = as_points(self.points, "points of a spline").copy()
        if len(points) < 4:
            raise InputError(f"a spline through {len(points)} points", "4 points or more", "add points, or take an Arc")
        if (step_lengths(points) <= 1e-14 * np.abs(points).max()).any():
            raise InputError("a spline that has a point twice in a row", "neighbours that differ", "remove one")
        if np.abs(points[-1] - points[0]).max() <= CLOSED * np.abs(points).max():
            points[-1] = points[0]
        points.setflags(write=False)
        object.__setattr__(self, "points", points)

    @property
    def closed(self) -> bool:
        """Whether the curve ends where it starts, smoothly."""
        return bool((self.points[0] == self.points[-1]).all())

    @cached_property
    def _curve(self) -> CubicSpline:
        along = chain_lengths(self.points)
        return CubicSpline(along / along[-1], self.points, bc_type="periodic" if self.closed else "not-a-knot")

    @cached_property
    def _samples(self) -> tuple[Floats, cKDTree]:
        knots = self._curve.x
        places = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(SAMPLES) / SAMPLES).ravel(), 1.0)
        return places, cKDTree(self._curve(places))

    def _inside(self, s: Floats) -> Floats:
        return np.mod(s, 1.0) if self.closed else np.clip(s, 0.0, 1.0)

    def point(self, s: ArrayLike) -> Floats:
        """Return the points (n, 2) at parameters (n,) from 0 to 1; on a closed curve they go around."""
        return self._curve(self._inside(np.atleast_1d(floats(s))))

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Return parameters (n,) and distances (n,) of the closest points, by Newton's method from the best sample."""
        given = as_points(points)
        places, tree = self._samples
        s = places[tree.query(given)[1]]
        step = 1.0 / (SAMPLES * (len(self.points) - 1))
        for _ in range(STEPS):
            off, slope, bend = self.point(s) - given, self._curve(s, 1), self._curve(s, 2)
            change = (off * slope).sum(axis=1) / np.maximum(
                (slope**2 + off * bend).sum(axis=1), 0.1 * (slope**2).sum(axis=1)
            )
            s = self._inside(s - np.clip(change, -step, step))
            if np.abs(change).max(initial=0.0) < 1e-15:
                break
        return s, norms(given - self.point(s))

    def transformed(self, placement: Placement) -> "Spline":
        """Return the curve in the placed frame, with the same parameters."""
        return Spline(placement.points(self.points))
