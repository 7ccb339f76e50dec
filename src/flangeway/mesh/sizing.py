"""Target size of triangles: one size, and refinements along polylines."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_positive, is_finite
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import FloatArray, as_points
from flangeway.geometry.outline import Outline


@dataclass(frozen=True, eq=False)
class Refinement:
    """Finer triangles about a polyline: ``size + growth * distance to the polyline``.

    Parameters
    ----------
    points
        Polyline (n, 2); one point refines about that point.
    size
        Length of edges on the polyline.
    growth
        Growth of the edges per distance, positive; about 0.1 to 0.3.

    Raises
    ------
    InputError
        If a number is not positive or a point is not finite.

    """

    points: FloatArray
    size: float
    growth: float = 0.15

    def __post_init__(self) -> None:
        """Check the numbers and keep a read-only copy of the points."""
        points = as_points(self.points, "points of a refinement").copy()
        if not len(points):
            raise InputError("a refinement without points", "one point or more", "add points")
        points.setflags(write=False)
        object.__setattr__(self, "points", points)
        for name, value in (("size", self.size), ("growth", self.growth)):
            check_positive("Refinement", name, value)

    @property
    def length(self) -> float:
        """Length of the polyline, zero for one point."""
        return float(np.sum(np.hypot(*np.diff(self.points, axis=0).T)))

    def distances(self, points: ArrayLike) -> FloatArray:
        """Return the distances (n,) of points (n, 2) from the polyline."""
        given = as_points(points)
        a = self.points[:-1] if len(self.points) > 1 else self.points
        steps = np.diff(self.points, axis=0) if len(self.points) > 1 else np.zeros((1, 2))
        squares = np.maximum(np.sum(steps**2, axis=1), np.finfo(float).tiny)
        nearest = np.full(len(given), np.inf)
        for start, step, square in zip(a, steps, squares, strict=True):
            rays = given - start
            along = np.clip(rays @ step / square, 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(*(rays - along[:, None] * step).T))
        return nearest

    @property
    def _seed_spacing(self) -> float:
        return self.size * min(1.0, 0.04 / self.growth)

    @property
    def n_seeds(self) -> int:
        """Number of `seeds`, counted without making them."""
        lengths = np.hypot(*np.diff(self.points, axis=0).T)
        return int(np.sum(np.maximum(np.ceil(lengths / self._seed_spacing), 1.0))) + 1

    def seeds(self) -> FloatArray:
        """Return points of the polyline so dense that their distance field errs below 2 % of size.

        Between neighbours the distance to the nearest is at most half their spacing.
        """
        return self.sampled(self._seed_spacing)

    def sampled(self, spacing: float) -> FloatArray:
        """Return points (n, 2) of the polyline, its corners among them, with neighbours up to `spacing` apart."""
        rows = []
        for a, b in zip(self.points[:-1], self.points[1:], strict=True):
            n_pieces = max(math.ceil(math.dist(a, b) / spacing), 1)
            rows.append(a + (b - a) * (np.arange(n_pieces) / n_pieces)[:, None])
        return np.vstack([*rows, self.points[-1:]])


def local_sizes(points: ArrayLike, size: float, refinements: Sequence[Refinement] = ()) -> FloatArray:
    """Return the target sizes (n,) at points (n, 2): the least of `size` and all refinements'."""
    given = as_points(points)
    sizes = np.full(len(given), float(size))
    for refinement in refinements:
        near = refinement.size + refinement.growth * refinement.distances(given)
        sizes = np.minimum(sizes, near)
    return sizes


def refuse_size(outline: Outline, size: float) -> None:
    """Refuse a size that makes no mesh.

    Raises
    ------
    InputError
        If the size is not positive, or larger than the region.

    """
    extent = float(np.max(outline.bounds()[1] - outline.bounds()[0]))
    if not (is_finite(size) and 0.0 < size <= extent):
        raise InputError(
            f"size = {short(size)}",
            f"a positive length up to the extent {extent:.6g} of the region",
            "give the length of a triangle's edge",
        )
