"""Curves that edges of a mesh lie on: which edge on which curve, and from where to where."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from flangeway.geometry.arrays import IntArray, cross_product
from flangeway.geometry.placement import Placement
from flangeway.types import Bools, Floats, Indices, Ints, floats


class Curve(Protocol):
    """What edges can lie on: an `Arc`, a `Spline`, or an object with these methods."""

    def point(self, s: ArrayLike) -> Floats:
        """Points (n, 2) at parameters (n,) from 0 to 1."""

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Parameters (n,) and distances (n,) of the closest points."""

    def transformed(self, placement: Placement) -> "Curve":
        """The curve in the placed frame, with the same parameters."""


@dataclass(frozen=True, eq=False)
class EdgeCurves:
    """The curved edges of a mesh; all others are straight.

    Parameters
    ----------
    pairs
        Ends of the edges, points of the mesh (m, 2); each edge once, in either direction.
    curves
        The curves.
    number
        Which of them each edge lies on (m,).
    ends
        Parameters at the ends of each edge (m, 2).
    """

    pairs: IntArray
    curves: tuple[Curve, ...]
    number: Ints
    ends: Floats

    def points(self, places: ArrayLike, rows: Ints | slice = slice(None)) -> Floats:
        """Points (m, n, 2) of the edges, or of some, at places (n,) from 0 at their first point to 1."""
        at = np.atleast_1d(floats(places))
        number, ends = self.number[rows], self.ends[rows]
        parameters = ends[:, :1] + at * (ends[:, 1:] - ends[:, :1])
        points = np.empty((*parameters.shape, 2))
        for curve in np.unique(number).tolist():
            on_curve = number == curve
            points[on_curve] = self.curves[curve].point(parameters[on_curve].ravel()).reshape(-1, len(at), 2)
        return points

    def beside(self, points: Floats) -> tuple[Floats, Floats]:
        """Areas between chords and edges (m,), positive to the right, and first moments (m, 2) about the first points.

        Those of polygons with 8, 16 and 32 sides, extrapolated twice.

        - `points`: of the mesh.
        """
        start, end = (points[column] for column in self.pairs.T)
        fine = self.points(np.arange(1, 32) / 32) - start[:, None]
        fine = np.concatenate((np.zeros((len(start), 1, 2)), fine, (end - start)[:, None]), axis=1)
        sums = []
        for step in (4, 2, 1):
            a, b = fine[:, :-step:step], fine[:, step::step]
            cross = cross_product(a, b)
            moments = np.einsum("mn,mni->mi", cross, a + b) / 6.0
            sums.append(np.column_stack((cross.sum(axis=1) / 2.0, moments)))
        coarse, middle, best = sums
        middle, best = middle + (middle - coarse) / 3.0, best + (best - middle) / 3.0
        best = best + (best - middle) / 15.0
        return best[:, 0], best[:, 1:]

    def taken(self, rows: Bools | Ints, numbers: Indices | None = None) -> "EdgeCurves | None":
        """Some of the edges, or None if there is none; with other numbers of the points, if given for the old ones."""
        pairs = self.pairs[rows]
        if not len(pairs):
            return None
        some = replace(self, pairs=pairs, number=self.number[rows], ends=self.ends[rows])
        return some if numbers is None else some.renumbered(numbers)

    def halved(self, middles: Ints) -> "EdgeCurves":
        """Edges divided at new points in their middles, -1 where an edge is whole."""
        split = middles >= 0
        halves = [self.taken(~split)] if not split.all() else []
        half = self.ends[split].mean(axis=1)
        for end in (0, 1):
            pairs, ends = self.pairs[split].copy(), self.ends[split].copy()
            pairs[:, 1 - end], ends[:, 1 - end] = middles[split], half
            halves.append(EdgeCurves(pairs, self.curves, self.number[split], ends))
        return united([part for part in halves if part is not None])

    def renumbered(self, numbers: Indices) -> "EdgeCurves":
        """With other numbers of the points, given for the old ones."""
        return replace(self, pairs=numbers[self.pairs].astype(np.int32))

    def transformed(self, placement: Placement) -> "EdgeCurves":
        """In the placed frame."""
        return replace(self, curves=tuple(curve.transformed(placement) for curve in self.curves))


def united(several: Sequence[EdgeCurves]) -> EdgeCurves:
    """Curved edges of several tables as one; those of the same curves keep them once."""
    curves: list[Curve] = []
    places: dict[int, int] = {}
    numbers = []
    for table in several:
        for curve in table.curves:
            if id(curve) not in places:
                places[id(curve)] = len(curves)
                curves.append(curve)
        numbers.append(np.array([places[id(curve)] for curve in table.curves])[table.number])
    pairs, ends = (np.concatenate([getattr(table, name) for table in several]) for name in ("pairs", "ends"))
    return EdgeCurves(pairs.astype(np.int32), tuple(curves), np.concatenate(numbers), ends)
