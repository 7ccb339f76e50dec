"""Connections of cells and points of a mesh, and the curves that its edges lie on."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flangeway.checks import as_numbers
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray, chords_of, cross_product, diagonal, frozen, norms
from flangeway.geometry.placement import Placement
from flangeway.types import Bools, Floats, Indices, Ints, floats

# --- Connections of cells and points: ragged rows, numbers of edges, and directed pairs in order along chains.


def next_in_row(offsets: IntArray) -> Ints:
    """Return for every entry the position of the entry after it in its row, cyclically."""
    following = np.arange(1, offsets[-1] + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return following


def row_numbers(offsets: Indices) -> Ints:
    """Return for every entry the number of its row."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def rows_reversed(offsets: IntArray) -> Ints:
    """Return positions that turn every row backwards."""
    rows = row_numbers(offsets)
    return offsets[rows].astype(np.int64) + offsets[rows + 1] - 1 - np.arange(offsets[-1])


def offsets_of(counts: Ints) -> IntArray:
    """Return the offsets (n + 1,) of rows with the given lengths (n,)."""
    offsets = np.zeros(len(counts) + 1, dtype=np.int32)
    np.cumsum(counts, out=offsets[1:])
    return offsets


def entries_of(offsets: IntArray, rows: Indices) -> tuple[Ints, IntArray]:
    """Return the positions of the entries of some rows, one row after the other, and the offsets of these rows."""
    counts = np.diff(offsets)[rows]
    taken = offsets_of(counts)
    return np.arange(taken[-1]) + np.repeat(offsets[rows] - taken[:-1], counts), taken


def places_among(kept: Indices, n: int) -> Ints:
    """Return the place of each of n numbers among some of them, -1 where it is none, (n,)."""
    indices = np.full(n, -1, dtype=np.int64)
    indices[kept] = np.arange(len(kept))
    return indices


def connected(pairs: Indices, n: int) -> Ints:
    """Return the group of each of n numbers that pairs (m, 2) connect, from 0, (n,)."""
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    return connected_components(links, directed=False)[1].astype(np.int64)


def first_connected(pairs: Indices, n: int) -> Ints:
    """Return for each of n numbers the lowest one that pairs (m, 2) connect it with, or itself, (n,)."""
    groups = connected(pairs, n)
    return np.unique(groups, return_index=True)[1][groups]


def places_in(keys: Ints, wanted: Ints) -> tuple[Ints, Bools]:
    """Return the places of wanted numbers (n,) among different keys (m,), one or more, and which are there, (n,)."""
    order = np.argsort(keys)
    rows = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)]
    return rows, keys[rows] == wanted


@dataclass(frozen=True, eq=False)
class EdgeNumbers:
    """Numbers of the edges that cells travel.

    The keys ``low * n_points + high`` of the edges' points (n_edges,), rising; the edge of each side of a cell
    (n_sides,); the sides that are alone at their edge, rising; and the edges that two cells travel in the same
    direction, or more than two cells.
    """

    keys: Ints
    numbers: IntArray
    single: Ints
    doubled: Ints


def number_edges(start: IntArray, end: IntArray, n_points: int) -> EdgeNumbers:
    """Number the edges of sides given by their start and end (n_sides,)."""
    keys = np.minimum(start, end).astype(np.int64) * n_points + np.maximum(start, end)
    keys, first, numbers, counts = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    edges: IntArray = frozen(numbers.astype(np.int32))
    # two cells that fit together travel their edge in both directions
    net = np.bincount(numbers, np.where(start < end, 1, -1))
    doubled = np.flatnonzero((counts > 2) | ((counts == 2) & (net != 0)))
    return EdgeNumbers(keys, edges, np.sort(first[counts == 1]), doubled)


def edge_places(edges: Indices, others: Indices, n_points: int) -> tuple[Ints, Bools]:
    """Places among other edges (m, 2) of edges (n, 2) in either direction, and whether each is there, both (n,)."""
    wanted, keys = (pairs.min(axis=1).astype(np.int64) * n_points + pairs.max(axis=1) for pairs in (edges, others))
    return places_in(keys, wanted)


def shortest_edges(points: Floats, edges: Indices) -> Floats:
    """Return the length of the shortest of some edges (m, 2) at each point, infinite where none is, (n_points,)."""
    lengths = norms(chords_of(points[edges]))
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, edges, lengths[:, None])
    return shortest


def pairs_divided(pairs: Indices, rows: Indices, added: Indices) -> IntArray:
    """Return pairs (m, 2) divided at added points (k,), each in the pair of its row (k,), rows rising."""
    starts, ends = pairs.astype(np.int32).T
    return np.column_stack((np.insert(starts, rows + 1, added), np.insert(ends, rows, added)))


def chain_starts(pairs: IntArray) -> Ints:
    """Return the rows of ordered pairs (m, 2) at which a chain starts."""
    breaks = np.ones(len(pairs), dtype=bool)
    breaks[1:] = pairs[1:, 0] != pairs[:-1, 1]
    return np.flatnonzero(breaks)


ON_LINE = 1e-6  # distance relative to the size of the body up to which a point is on a line or in a box


@dataclass(frozen=True, eq=False)
class NamedEdges:
    """Edges of a body's boundary and their names: what `edges_at` chooses from.

    Parameters
    ----------
    points
        Points, shape (n, 2).
    boundary
        Ends of all edges of the boundary, shape (m, 2).
    sets
        Ends of those that have a name.

    """

    points: Floats
    boundary: IntArray
    sets: Mapping[str, IntArray]

    def chosen(
        self,
        names: str | Sequence[str] | None = None,
        *,
        within: Sequence[float] | None = None,
        at_x: float | None = None,
        at_y: float | None = None,
    ) -> IntArray:
        """Return the edges that all arguments allow, as `flangeway.mesh.PolyMesh.edge_set` does."""
        pairs = self.boundary if names is None else self._named([names] if isinstance(names, str) else [*names])
        if within is None and at_x is None and at_y is None:
            return pairs
        box = (-np.inf, -np.inf, np.inf, np.inf) if within is None else within
        corners = as_numbers("within", box, allowed := "four numbers: x_min, y_min, x_max, y_max")
        if corners.shape != (4,):
            raise InputError(f"within = {short(within)}", allowed, "correct it")
        # a line is a box without width
        low = np.maximum(corners[:2], [-np.inf if at is None else at for at in (at_x, at_y)])
        high = np.minimum(corners[2:], [np.inf if at is None else at for at in (at_x, at_y)])
        slack = ON_LINE * diagonal(self.points)
        ends = self.points[pairs]
        inside = ((ends >= low - slack) & (ends <= high + slack)).all(axis=(1, 2))
        if not inside.any():
            (x0, y0), (x1, y1) = self.points.min(axis=0), self.points.max(axis=0)
            raise InputError(
                "no edge of the boundary is there",
                f"positions on the boundary, which reaches from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
                "correct the numbers; a box must contain whole edges",
            )
        return pairs[inside]

    def _named(self, names: list[str]) -> IntArray:
        known = sorted(self.sets)
        for name in names:
            if name not in known:
                similar = difflib.get_close_matches(str(name), known, n=1)
                advice = f"did you mean {similar[0]}?" if similar else "correct the name"
                raise InputError(f"edge set {name!r}", f"one of: {', '.join(known) or 'none'}", advice)
        if not names:
            raise InputError("no edge set", f"names of {', '.join(known) or 'none'}", "give a name")
        return self.sets[names[0]] if len(names) == 1 else np.vstack([self.sets[name] for name in names])


def ordered_pairs(pairs: IntArray, name: str) -> IntArray:
    """Return directed pairs (m, 2) in order along their chains; an `InputError` names the edge set where they branch.

    Open chains come first, in the order in which their first pairs are given, then closed ones, each from its first
    given pair. Pairs that are in order stay as they are.
    """
    for column, what in ((0, "leave"), (1, "reach")):
        values, counts = np.unique(pairs[:, column], return_counts=True)
        if np.any(counts > 1):
            raise InputError(
                f"edge set '{name}': {counts.max()} edges {what} point {values[counts.argmax()]}",
                "chains that do not branch",
                "give each edge once, with the body on its left",
            )
    starts = chain_starts(pairs)
    ends = pairs[np.append(starts[1:], len(pairs)) - 1, 1]
    by_start = np.argsort(pairs[:, 0])
    rows = np.minimum(np.searchsorted(pairs[by_start, 0], ends), len(pairs) - 1)
    following = by_start[rows]
    # in order if nothing leaves the end of a chain but, where it is closed, its own first pair
    if np.all((pairs[following, 0] != ends) | (following == starts)):
        return pairs
    return pairs[_order(pairs.tolist())]


def _order(pairs: list[list[int]]) -> list[int]:
    """Return the rows of the pairs in order along the chains."""
    leaving = {pair[0]: row for row, pair in enumerate(pairs)}
    reached = {pair[1] for pair in pairs}
    open_first = sorted(range(len(pairs)), key=lambda row: pairs[row][0] in reached)
    order: list[int] = []
    seen = [False] * len(pairs)
    for first in open_first:
        row: int | None = first
        while row is not None and not seen[row]:
            seen[row] = True
            order.append(row)
            row = leaving.get(pairs[row][1])
    return order


# --- Curves that edges of a mesh lie on: which edge on which curve, and from where to where.


class EdgeCurve(Protocol):
    """What edges can lie on: an `Arc`, a `Spline`, or an object with these methods."""

    def point(self, s: ArrayLike) -> Floats:
        """Points (n, 2) at parameters (n,) from 0 to 1."""

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Parameters (n,) and distances (n,) of the closest points."""

    def transformed(self, placement: Placement) -> "EdgeCurve":
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
    curves: tuple[EdgeCurve, ...]
    number: Ints
    ends: Floats

    def points(self, positions: ArrayLike, rows: Ints | slice = slice(None)) -> Floats:
        """Points (m, n, 2) of the edges, or of some, at positions (n,) from 0 at their first point to 1."""
        at = np.atleast_1d(floats(positions))
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
    curves: list[EdgeCurve] = []
    row_of_pair: dict[int, int] = {}
    numbers = []
    for table in several:
        for curve in table.curves:
            if id(curve) not in row_of_pair:
                row_of_pair[id(curve)] = len(curves)
                curves.append(curve)
        numbers.append(np.array([row_of_pair[id(curve)] for curve in table.curves])[table.number])
    pairs, ends = (np.concatenate([getattr(table, name) for table in several]) for name in ("pairs", "ends"))
    return EdgeCurves(pairs.astype(np.int32), tuple(curves), np.concatenate(numbers), ends)
