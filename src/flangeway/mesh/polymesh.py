"""Mesh of polygons in the plane: points, ragged cells, named sets of cells and boundary edges."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from flangeway.checks import values_at
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, as_points, chain_points, cross_product, frozen, point_text
from flangeway.geometry.placement import Placement
from flangeway.mesh.cell_mesh import CellMesh, index_array, row_starts
from flangeway.mesh.connectivity import (
    EdgeCurves,
    EdgeNumbers,
    NamedEdges,
    chain_starts,
    edge_places,
    entries_of,
    next_in_row,
    number_edges,
    ordered_pairs,
    places_among,
    row_numbers,
    rows_reversed,
    united,
)
from flangeway.types import Bools, Floats, Indices, Ints


def _with_the_body_on_the_left(pairs: IntArray, cell_points: IntArray, offsets: IntArray) -> IntArray:
    """Pairs (m, 2) turned where a cell passes them from the second point to the first, and none the other way."""
    near = np.zeros(max(int(cell_points.max()), int(pairs.max())) + 1, dtype=bool)
    near[pairs] = True
    entries = np.flatnonzero(near[cell_points])
    after = entries + 1
    rows = np.searchsorted(offsets, entries, side="right") - 1
    after = np.where(after == offsets[rows + 1], offsets[rows], after)
    sides = cell_points[entries].astype(np.int64) * len(near) + cell_points[after]
    ahead, back = (np.isin(a.astype(np.int64) * len(near) + b, sides) for a, b in (pairs.T, pairs.T[::-1]))
    return np.where((back & ~ahead)[:, None], pairs[:, ::-1], pairs)


@dataclass(frozen=True, eq=False)
class PolyMesh(CellMesh):
    """Polygons with any number of sides; a triangle is a polygon with three points.

    All arrays are copied and read-only; a change returns a new mesh. The constructor checks shapes
    and index ranges only; a `Space` checks the geometry, as `flangeway.mesh.check` does.

    Parameters
    ----------
    points
        Coordinates (n_points, 2).
    cell_offsets
        Start of every cell in `cell_points` (n_cells + 1,), from 0.
    cell_points
        Point numbers of the cells one after the other, each counter-clockwise.
    cell_sets
        Cell numbers by name; they are stored in rising order, each once.
    edge_sets
        Pairs of points (m, 2) by name: boundary edges in either direction. They are stored with the body on the left,
        in order along the boundary.
    curves
        Edges that are curved, see `EdgeCurves` and `flangeway.mesh.curved`. None: all are straight.

    Raises
    ------
    InputError
        If a shape, an index or the order of an edge set is wrong.
    """

    points: Floats
    cell_offsets: IntArray
    cell_points: IntArray
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    edge_sets: Mapping[str, IntArray] = field(default_factory=dict)
    curves: EdgeCurves | None = None

    def __post_init__(self) -> None:
        """Check shapes and ranges; store read-only copies."""
        points = frozen(as_points(self.points).copy())
        cell_points = index_array(self.cell_points, "cell_points", len(points)).ravel()
        offsets = row_starts(self.cell_offsets, "cell_offsets", len(cell_points), 3)
        cell_sets = {
            name: frozen(np.unique(index_array(values, f"cell set '{name}'", len(offsets) - 1)))
            for name, values in self.cell_sets.items()
        }
        edge_sets = {}
        for name, values in self.edge_sets.items():
            pairs = index_array(values, f"edge set '{name}'", len(points))
            if pairs.ndim != 2 or pairs.shape[1] != 2 or not len(pairs):
                raise InputError(
                    f"edge set '{name}' of shape {pairs.shape}",
                    "pairs of points (m, 2), one or more",
                    "give start and end of every edge",
                )
            try:
                ordered = ordered_pairs(_with_the_body_on_the_left(pairs, cell_points, offsets), name)
            except InputError:  # as where a cell is clockwise, which is for a check of the mesh to say
                ordered = ordered_pairs(pairs, name)
            edge_sets[name] = frozen(ordered)
        for name, value in (
            ("points", points),
            ("cell_offsets", offsets),
            ("cell_points", cell_points),
            ("cell_sets", MappingProxyType(cell_sets)),
            ("edge_sets", MappingProxyType(edge_sets)),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def from_cells(cls, points: ArrayLike, cells: Iterable[Sequence[int]] | NDArray[Any], **named: Any) -> "PolyMesh":
        """Return the mesh of points (n_points, 2) and of cells, each the numbers of its points counter-clockwise.

        - `cells`: an array (n_cells, n) where all have n points.
        - `named`: sets and curves, as of the class.
        """
        if isinstance(cells, np.ndarray):
            return cls(np.asarray(points), cells.shape[1] * np.arange(len(cells) + 1), cells.ravel(), **named)
        rows = [list(cell) for cell in cells]
        numbers = [number for row in rows for number in row]
        return cls(np.asarray(points), np.cumsum([0, *map(len, rows)]), np.asarray(numbers), **named)

    def __reduce__(self) -> tuple[Any, ...]:
        sets = (dict(self.cell_sets), dict(self.edge_sets))  # read-only views cannot be pickled
        return PolyMesh, (self.points, self.cell_offsets, self.cell_points, *sets, self.curves)

    # counts and connections

    def __repr__(self) -> str:
        sets = f"cell_sets={sorted(self.cell_sets)}, edge_sets={sorted(self.edge_sets)}"
        return f"PolyMesh(n_points={self.n_points}, n_cells={self.n_cells}, {sets})"

    @property
    def n_edges(self) -> int:
        """Number of edges."""
        return len(self._numbered.keys)

    @cached_property
    def _following(self) -> Ints:
        """Position in `cell_points` of the point after each one in its cell."""
        return next_in_row(self.cell_offsets)

    def _keys(self, pairs: IntArray) -> Ints:
        low, high = np.sort(pairs.astype(np.int64), axis=1).T
        return low * self.n_points + high

    @cached_property
    def _numbered(self) -> EdgeNumbers:
        return number_edges(self.cell_points, self.cell_points[self._following], self.n_points)

    @cached_property
    def edges(self) -> IntArray:
        """Pairs of points (n_edges, 2), the lower number first, in sorted order."""
        low, high = np.divmod(self._numbered.keys, self.n_points)
        return frozen(np.column_stack([low, high]).astype(np.int32))

    @property
    def cell_edges(self) -> IntArray:
        """Edge numbers, ragged like `cell_points`: from its point to the next one of the cell."""
        return self._numbered.numbers

    @cached_property
    def edge_cells(self) -> IntArray:
        """Cells on both sides of every edge (n_edges, 2), the lower number first; -1 for outside.

        Raises
        ------
        InputError
            If an edge has more than two cells.
        """
        order = np.argsort(self.cell_edges, kind="stable")
        counts = np.bincount(self.cell_edges, minlength=self.n_edges)
        if counts.max() > 2:
            a, b = self.edges[counts.argmax()]
            raise InputError(
                f"edge ({a}, {b}) near {point_text(self.points[a])} with {counts.max()} cells",
                "one or two cells at an edge",
                "remove the cells that overlap",
            )
        cells = row_numbers(self.cell_offsets)[order]
        first = np.cumsum(counts) - counts
        pairs = np.full((self.n_edges, 2), -1, dtype=np.int32)
        pairs[:, 0] = cells[first]
        inner = counts == 2
        pairs[inner, 1] = cells[first[inner] + 1]
        return frozen(pairs)

    @property
    def cell_neighbours(self) -> IntArray:
        """Pairs of cells (m, 2) with a common edge."""
        return self.edge_cells[self.edge_cells[:, 1] >= 0]

    @cached_property
    def boundary_edges(self) -> IntArray:
        """Edges with one cell, as pairs of points (m, 2) with the body on the left."""
        return frozen(self.cell_points[self.rim_entries])

    @property
    def rim_entries(self) -> Ints:
        """Positions in `cell_points` of the ends of `boundary_edges` (m, 2)."""
        entries = self._numbered.single
        return np.column_stack((entries, self._following[entries]))

    @property
    def doubled_edges(self) -> Ints:
        """Numbers of the edges that two cells travel in the same direction, or more than two cells: none if sound."""
        return self._numbered.doubled

    def edge_numbers(self, pairs: ArrayLike) -> IntArray:
        """Return the numbers (m,) of the edges with the given ends (m, 2), in either direction.

        Raises
        ------
        InputError
            If a pair is not an edge.
        """
        given = index_array(pairs, "pairs", self.n_points).reshape(-1, 2)
        keys, wanted = self._numbered.keys, self._keys(given)
        numbers = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        missing = keys[numbers] != wanted
        if missing.any():
            a, b = given[missing.argmax()]
            raise InputError(
                f"points {a} and {b}, near {point_text(self.points[a])}", "the ends of an edge", "correct them"
            )
        return numbers.astype(np.int32)

    def boundary_rows(self, pairs: ArrayLike, what: str) -> Ints:
        """Return the rows (m,) of `boundary_edges` that have the given ends (m, 2), in either direction.

        - `what`: what the edges are, for the `InputError` if a pair is no edge, or one inside the body.
        """
        given = self.edges[self.edge_numbers(pairs)]
        rows, outer = edge_places(given, self.boundary_edges, self.n_points)
        if not outer.all():
            a, b = given[outer.argmin()]
            raise InputError(
                f"{what} ({a}, {b}) near {point_text(self.points[a])}, which is inside the body",
                "edges of the boundary",
                "choose among boundary_edges",
            )
        return rows

    # geometry

    @cached_property
    def _local_corners(self) -> Floats:
        # about the first point of the cell: areas keep their digits far from the origin
        first = self.cell_points[self.cell_offsets[:-1]]
        corners: Floats = self.points[self.cell_points]
        corners -= np.repeat(self.points[first], self.cell_sizes, axis=0)
        return corners

    @cached_property
    def _cross(self) -> Floats:
        """Twice the signed areas of the triangles of every edge with the cell's first point."""
        a = self._local_corners
        b = a[self._following]
        return cross_product(a, b)

    @cached_property
    def cell_areas(self) -> Floats:
        """Areas (n_cells,), negative for clockwise cells."""
        areas = 0.5 * np.add.reduceat(self._cross, self.cell_offsets[:-1])
        if self.curves is not None:
            cells, signs, _, beside, _ = self._beside
            np.add.at(areas, cells, signs * beside)
        return frozen(areas)

    @cached_property
    def _beside(self) -> tuple[Ints, Floats, Ints, Floats, Floats]:
        """Sides of cells with curved edges: cell, sign, row in `curves`; and what `EdgeCurves.beside` gives them."""
        assert self.curves is not None
        row = self.curve_rows[self.cell_edges]
        entries = np.flatnonzero(row >= 0)
        rows = row[entries]
        areas, moments = self.curves.beside(self.points)
        signs = np.where(self.cell_points[entries] == self.curves.pairs[rows, 0], 1.0, -1.0)
        return row_numbers(self.cell_offsets)[entries], signs, rows, areas[rows], moments[rows]

    @cached_property
    def curve_rows(self) -> Ints:
        """Row in `curves` of each edge, -1 for straight ones (n_edges,)."""
        curved: Indices = np.empty(0, dtype=np.int64)
        if self.curves is not None:
            curved = self.edge_numbers(self.curves.pairs)
        return places_among(curved, self.n_edges)

    def edge_middles(self, edges: Indices) -> Floats:
        """Middles (m, 2) of edges given by their numbers, on curved edges in the middle of the curve."""
        middles: Floats = self.points[self.edges[edges]].mean(axis=1)
        rows = self.curve_rows[edges]
        if self.curves is not None and (rows >= 0).any():
            middles[rows >= 0] = self.curves.points([0.5], rows[rows >= 0])[:, 0]
        return middles

    def straight(self) -> "PolyMesh":
        """Return the mesh with the same points and straight edges."""
        return replace(self, curves=None)

    @cached_property
    def cell_centroids(self) -> Floats:
        """Centroids (n_cells, 2)."""
        a = self._local_corners
        weighted = (a + a[self._following]) * self._cross[:, None]
        sums = np.add.reduceat(weighted, self.cell_offsets[:-1], axis=0)
        first = self.points[self.cell_points[self.cell_offsets[:-1]]]
        if self.curves is not None:
            cells, signs, rows, areas, moments = self._beside
            offset = self.points[self.curves.pairs[rows, 0]] - first[cells]
            np.add.at(sums, cells, 6.0 * signs[:, None] * (moments + areas[:, None] * offset))
        return frozen(first + sums / (6.0 * self.cell_areas[:, None]))

    @cached_property
    def cell_diameters(self) -> Floats:
        """Maximum distance of two points of every cell (n_cells,)."""
        diameters = np.zeros(self.n_cells)
        for n_vertices, cells in self.batches():
            corners = self.points[self.batch_points(n_vertices, cells)]
            for shift in range(1, n_vertices // 2 + 1):
                apart = corners - np.roll(corners, shift, axis=1)
                squares = np.einsum("cvx,cvx->cv", apart, apart).max(axis=1)
                diameters[cells] = np.maximum(diameters[cells], squares)
        return frozen(np.sqrt(diameters))

    def polygons(self, cells: Indices) -> NDArray[np.object_]:
        """Return cells (n,) as polygons of shapely, of which a curved edge is its chord."""
        entries, offsets = entries_of(self.cell_offsets, cells)
        closed = np.insert(entries, offsets[1:], entries[offsets[:-1]])
        rows = np.arange(len(offsets))
        rings = self.points[self.cell_points[closed]], (offsets + rows, rows)
        return shapely.from_ragged_array(shapely.GeometryType.POLYGON, *rings)

    @cached_property
    def cell_tree(self) -> shapely.STRtree:
        """Search tree of the cells' `polygons`."""
        return shapely.STRtree(self.polygons(np.arange(self.n_cells)))

    # named sets

    @property
    def named_edges(self) -> NamedEdges:
        """Edges of the boundary and their names."""
        return NamedEdges(self.points, self.boundary_edges, self.edge_sets)

    def edge_set(
        self,
        names: str | Sequence[str] | None = None,
        *,
        within: Sequence[float] | None = None,
        at_x: float | None = None,
        at_y: float | None = None,
    ) -> IntArray:
        """Return the edges of the boundary that all arguments allow, pairs of points (m, 2).

        Parameters
        ----------
        names
            Edge set, or several one after the other; None: the whole boundary.
        within
            Box x_min, y_min, x_max, y_max that contains both ends; a side that is infinite is open.
        at_x, at_y
            Line on which both ends are.

        Raises
        ------
        InputError
            If a name is unknown, or no edge is there.
        """
        return self.named_edges.chosen(names, within=within, at_x=at_x, at_y=at_y)

    def chain(self, *names: str) -> IntArray:
        """Return the points (m + 1,) along the edges of one or more edge sets, body on the left.

        The first point of a closed chain is repeated at its end, so that neighbours are edges.

        Raises
        ------
        InputError
            If a name is unknown or the edges are not one chain.
        """
        return frozen(chain_points(self._joined_sets(names)))

    def _joined_sets(self, names: tuple[str, ...]) -> IntArray:
        pairs = self.edge_set(names)
        if len(names) > 1:
            pairs = ordered_pairs(pairs, " + ".join(names))
        starts = chain_starts(pairs)
        if len(starts) != 1:
            points = ", ".join(point_text(self.points[p]) for p in pairs[starts, 0][:4])
            raise InputError(
                f"edge set {' + '.join(names)} is {len(starts)} chains, from {points}",
                "edges that follow each other without a gap",
                "give neighbouring parts their own name",
            )
        return pairs

    def with_edge_set(self, name: str, pairs: ArrayLike | Callable[[Floats], Bools]) -> "PolyMesh":
        """Return the mesh with a further (or replaced) edge set.

        Parameters
        ----------
        name
            Name of the set.
        pairs
            Ends (m, 2) of boundary edges in either direction; they are turned so that the body is
            on the left, and ordered. Or a function that says of points (n, 2) which it takes, (n,): the set then has
            the boundary edges with both ends there, such as ``lambda p: p[:, 0] < 1e-9``.

        Raises
        ------
        InputError
            If a pair is not a boundary edge, or a function takes none.
        """
        if callable(pairs):
            taken = values_at(pairs, self.points)
            if taken.shape != (self.n_points,) or taken.dtype != bool:
                raise InputError(
                    f"edge set '{name}': a function with values of shape {taken.shape} and type {taken.dtype}",
                    f"a truth value for each of {self.n_points} points",
                    "write it for points of shape (n, 2), such as lambda p: p[:, 0] < 1e-9",
                )
            pairs = self.boundary_edges[taken[self.boundary_edges].all(axis=1)]
        rows = self.boundary_rows(pairs, f"edge set '{name}': edge")
        return replace(self, edge_sets={**self.edge_sets, name: self.boundary_edges[rows]})

    # changes

    def placed(self, placement: Placement) -> "PolyMesh":
        """Return the mesh in the placed frame; a mirrored one keeps counter-clockwise cells.

        Points and cells keep their numbers.
        """
        changes: dict[str, Any] = {"points": placement.points(self.points)}
        if placement.mirrored:
            changes["cell_points"] = self.cell_points[rows_reversed(self.cell_offsets)]
            changes["edge_sets"] = {n: e[::-1, ::-1] for n, e in self.edge_sets.items()}
        if self.curves is not None:
            changes["curves"] = self.curves.transformed(placement)
        return replace(self, **changes)

    def part(self, cells: Indices) -> "PolyMesh":
        """Return some cells with what is left of the sets and curves; edges to the other cells become boundary."""
        cells = np.unique(cells)
        entries, offsets = entries_of(self.cell_offsets, cells)
        points, corners = np.unique(self.cell_points[entries], return_inverse=True)
        number = places_among(points, self.n_points)
        bare = PolyMesh(self.points[points], offsets, corners.astype(np.int32))
        edge_sets: dict[str, Any] = {}
        for name, pairs in self.edge_sets.items():
            outer = edge_places(number[pairs], bare.boundary_edges, bare.n_points)[1]
            if outer.any():
                edge_sets[name] = number[pairs[outer]]
        inside: dict[str, Any] = {
            name: np.flatnonzero(np.isin(cells, members)) for name, members in self.cell_sets.items()
        }
        cell_sets = {name: members for name, members in inside.items() if len(members)}
        curves = self.curves
        if curves is not None:
            curves = curves.taken(np.isin(self.edge_numbers(curves.pairs), self.cell_edges[entries]), number)
        return replace(bare, cell_sets=cell_sets, edge_sets=edge_sets, curves=curves)

    def apart(self) -> "PolyMesh":
        """Return the cells with points of their own, in the order of `cell_points`, without sets."""
        return PolyMesh(
            self.points[self.cell_points], self.cell_offsets, np.arange(len(self.cell_points), dtype=np.int32)
        )

    def merged(self, other: "PolyMesh") -> "PolyMesh":
        """Return both meshes as one, without gluing: points and cells of `other` are added behind.

        Sets with the same name are united.
        """
        n_points, n_cells, n_corners = self.n_points, self.n_cells, len(self.cell_points)
        curves = [] if self.curves is None else [self.curves]
        if other.curves is not None:
            curves.append(other.curves.renumbered(n_points + np.arange(other.n_points)))
        return PolyMesh(
            np.vstack([self.points, other.points]),
            np.append(self.cell_offsets, other.cell_offsets[1:] + n_corners),
            np.append(self.cell_points, other.cell_points + n_points),
            _united(self.cell_sets, {n: c + n_cells for n, c in other.cell_sets.items()}),
            _united(self.edge_sets, {n: e + n_points for n, e in other.edge_sets.items()}),
            united(curves) if curves else None,
        )


def _united(first: Mapping[str, IntArray], second: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    sets: dict[str, NDArray[Any]] = dict(first)
    for name, values in second.items():
        sets[name] = np.concatenate([sets[name], values]) if name in sets else values
    return sets
