"""What meshes of polygons and of polyhedra have alike: points, cells with any number of them, and named sets."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, frozen
from flangeway.results import Shown
from flangeway.types import Floats, Indices, Ints


def index_array(values: ArrayLike, name: str, upper: int) -> IntArray:
    """Return a read-only int32 array of indices in [0, upper)."""
    given = np.asarray(values)
    if given.size and given.dtype.kind not in "iu":
        raise InputError(f"{name} of type {given.dtype}", "integers", "convert it to int32")
    if given.size and (given.min() < 0 or given.max() >= upper):
        raise InputError(
            f"{name} from {given.min()} to {given.max()}",
            f"numbers from 0 to {upper - 1}",
            "number points and cells from zero",
        )
    return frozen(given.astype(np.int32))


def row_starts(values: ArrayLike, name: str, total: int, least: int) -> IntArray:
    """Return the checked starts (n + 1,) of rows of a total number of entries, each with a least number of them."""
    offsets = index_array(values, name, total + 1)
    if offsets.ndim != 1 or len(offsets) < 2 or offsets[0] or offsets[-1] != total:
        raise InputError(
            f"{name} of shape {offsets.shape}",
            f"n + 1 numbers from 0 to {total}, for one row or more",
            "give the start of each row and the end of the last",
        )
    counts = np.diff(offsets)
    if counts.min() < least:
        row = int(counts.argmin())
        raise InputError(f"{name}: row {row} with {counts[row]} entries", f"{least} or more", "remove it")
    return offsets


def known(names: Mapping[str, IntArray], name: str, what: str) -> IntArray:
    """Numbers of a named set; an InputError for an unknown name."""
    if name not in names:
        raise InputError(f"{what} set '{name}'", f"one of: {', '.join(sorted(names)) or 'none'}", "correct the name")
    return names[name]


class CellMesh(Shown):
    """Points, and cells that are numbers of points one cell after the other.

    The subclasses, `PolyMesh` and `PolyhedralMesh`, are final and have ``points`` (n_points, d), ``cell_offsets``
    (n_cells + 1,), ``cell_points`` and ``cell_sets``.
    """

    points: Floats
    cell_sets: Mapping[str, IntArray]
    cell_offsets: IntArray
    cell_points: IntArray

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return int(self.points.shape[1])

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points)

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.cell_offsets) - 1

    @cached_property
    def cell_sizes(self) -> IntArray:
        """Number of points of every cell (n_cells,)."""
        return frozen(np.diff(self.cell_offsets))

    @cached_property
    def _batches(self) -> tuple[tuple[int, IntArray], ...]:
        if self.cell_sizes.min() == self.cell_sizes.max():
            return ((int(self.cell_sizes[0]), frozen(np.arange(self.n_cells, dtype=np.int32))),)
        order = np.argsort(self.cell_sizes, kind="stable").astype(np.int32)
        sizes, starts = np.unique(self.cell_sizes[order], return_index=True)
        groups = np.split(order, starts[1:])
        return tuple((int(n), frozen(cells)) for n, cells in zip(sizes, groups, strict=True))

    def batches(self) -> tuple[tuple[int, IntArray], ...]:
        """Return (n_vertices, cell numbers) for the cells of each number of vertices, ascending."""
        return self._batches

    def corners(self, cell: int) -> IntArray:
        """Return the numbers of the points of one cell."""
        return self.cell_points[self.cell_offsets[cell] : self.cell_offsets[cell + 1]]

    def batch_points(self, n_vertices: int, cells: IntArray) -> IntArray:
        """Return the point numbers (len(cells), n_vertices) of cells of one batch."""
        return self.cell_points[self.batch_places(n_vertices, cells)]

    def batch_places(self, n_vertices: int, cells: Indices) -> Ints:
        """Return where the points of cells of one batch are in `cell_points`, shape (len(cells), n_vertices)."""
        return self.cell_offsets[cells].astype(np.int64)[:, None] + np.arange(n_vertices)

    def cell_set(self, name: str) -> IntArray:
        """Return the cell numbers of a cell set; an unknown name is an InputError."""
        return known(self.cell_sets, name, "cell")

    def with_cell_set(self, name: str, cells: ArrayLike) -> Self:
        """Return the mesh with a further (or replaced) cell set: numbers, or a mask (n_cells,)."""
        given = np.asarray(cells)
        numbers: Any = np.flatnonzero(given) if given.dtype == bool else given
        return replace(self, cell_sets={**self.cell_sets, name: numbers})  # type: ignore[type-var]
