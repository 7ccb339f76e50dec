"""Polygons made of several cells of a mesh, each without holes."""

from dataclasses import replace
from heapq import heapify, heappop, heappush

import numpy as np
import shapely

from flangeway.checks import check_integer
from flangeway.geometry.arrays import sides_of
from flangeway.mesh.connectivity import next_in_row, places_among, row_numbers
from flangeway.mesh.polymesh import PolyMesh


def agglomerated(mesh: PolyMesh, cells: int) -> PolyMesh:
    """Return the mesh with cells joined to polygons until so many are left.

    The smallest polygon is joined to the neighbour with which it is roundest, again and again. Two polygons are joined
    only if they meet in one piece, so that each stays simple, without holes; and only if they belong to the same cell
    sets. Points inside a polygon vanish; the others stay, so that polygons have many short sides and are not convex.

    Parameters
    ----------
    mesh
        Cells of any kind, that fit together.
    cells
        Number of polygons that are wanted; there are more if no two of those left can be joined.

    Returns
    -------
    PolyMesh
        With the cell sets, edge sets and curved edges of the mesh.

    Raises
    ------
    InputError
        If the number of cells is not from 1 to that of the mesh.
    """
    check_integer("agglomerated", "cells", cells, 1, mesh.n_cells)
    joining = _Joining(mesh)
    heap = [(area, cell) for cell, area in joining.areas.items()]
    heapify(heap)
    while len(joining.rows) > cells and heap:
        area, cell = heappop(heap)
        if joining.areas.get(cell) == area and (other := joining.best_neighbour(cell)) is not None:
            joining.join(cell, other)
            heappush(heap, (joining.areas[other], other))
            # a smaller neighbour may have had none to join, and has now
            for near in joining.neighbours(other):
                heappush(heap, (joining.areas[near], near))
    kept = np.unique(np.concatenate(list(joining.rows.values())))
    number = places_among(kept, mesh.n_points)
    whole = PolyMesh.from_cells(mesh.points[kept], [number[row].tolist() for row in joining.rows.values()])
    left = list(joining.rows)
    for name, members in mesh.cell_sets.items():
        whole = whole.with_cell_set(name, np.isin(left, members))
    for name, pairs in mesh.edge_sets.items():
        whole = whole.with_edge_set(name, number[pairs])
    if mesh.curves is not None:
        sides = mesh.curves.pairs.tolist()
        left_over = np.array([(a, b) in joining.left or (b, a) in joining.left for a, b in sides])
        whole = replace(whole, curves=mesh.curves.taken(left_over, number))
    return whole


class _Joining:
    """Polygons that become fewer: their points in order, their areas, and the polygon on the left of each side."""

    def __init__(self, mesh: PolyMesh) -> None:
        self.points = mesh.points
        start, end = mesh.cell_points, mesh.cell_points[next_in_row(mesh.cell_offsets)]
        owners = row_numbers(mesh.cell_offsets)
        self.left = dict(zip(zip(start.tolist(), end.tolist(), strict=True), owners.tolist(), strict=True))
        self.rows = dict(enumerate(row.tolist() for row in np.split(mesh.cell_points, mesh.cell_offsets[1:-1])))
        self.areas = dict(enumerate(mesh.cell_areas.tolist()))
        signs = np.zeros((mesh.n_cells, len(mesh.cell_sets) + 1), dtype=bool)
        for column, members in enumerate(mesh.cell_sets.values()):
            signs[members, column] = True
        self.kind = np.unique(signs, axis=0, return_inverse=True)[1].ravel()

    def neighbours(self, cell: int) -> set[int]:
        """Polygons on the other side of a polygon's sides."""
        row = self.rows[cell]
        across = {self.left.get((end, start)) for start, end in sides_of(row)}
        return {other for other in across if other is not None and self.kind[other] == self.kind[cell]} - {cell}

    def united(self, cell: int, other: int) -> list[int] | None:
        """Points of both polygons in order; None if they do not meet in one piece."""
        row = self.rows[cell]
        shared = [self.left.get((b, a)) == other for a, b in sides_of(row)]
        starts = [place for place in range(len(row)) if shared[place] and not shared[place - 1]]
        if len(starts) != 1 or len(set(row) & set(self.rows[other])) != sum(shared) + 1:
            return None
        row = row[starts[0] :] + row[: starts[0]]
        first, last = row[0], row[sum(shared)]
        row = row[sum(shared) :]  # from the last shared point to the point before the first
        theirs = self.rows[other]
        place = theirs.index(first)
        theirs = theirs[place:] + theirs[:place]
        return [*row, *theirs[: theirs.index(last)]]

    def best_neighbour(self, cell: int) -> int | None:
        """Neighbour with which it has the least perimeter for the root of its area."""
        options = []
        for other in self.neighbours(cell):
            row = self.united(cell, other)
            if row is not None:
                perimeter = shapely.length(shapely.linearrings(self.points[row]))
                options.append((perimeter**2 / (self.areas[cell] + self.areas[other]), other))
        return min(options)[1] if options else None

    def join(self, cell: int, other: int) -> None:
        """Make one polygon of two, with the number of the other."""
        row = self.united(cell, other)
        assert row is not None
        for gone in (self.rows.pop(cell), self.rows[other]):
            for side in sides_of(gone):
                del self.left[side]
        self.rows[other] = row
        self.left |= dict.fromkeys(sides_of(row), other)
        self.areas[other] += self.areas.pop(cell)
