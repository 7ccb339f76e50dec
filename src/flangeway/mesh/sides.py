"""Sides of polygons: runs of edges that go on almost straight, as along hanging points."""

from dataclasses import dataclass

import numpy as np

from flangeway.mesh.connectivity import next_in_row, row_numbers
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats, Ints

STRAIGHT = np.deg2rad(15.0)
"""Turn at a point below which both edges belong to one side."""

HANGING = 1e-6
"""Turn in radians below which a point of a cell counts as one that hangs on its side."""

MIDDLE = 0.25
"""Distance from the middle of a side, over its length, within which a point of it divides the side."""


@dataclass(frozen=True, eq=False)
class Sides:
    """Sides of all cells; the points of each cell are listed from one of its corners on.

    Entries are positions in ``mesh.cell_points``. For each entry its side (the entry's point starts it or lies inside
    it), and whether the point hangs on a side inside the body; for each side (n_sides,) its cell, the entry whose point
    divides it or -1, and the entry whose edge is to be halved to divide it, or -1 where a point does.
    """

    entries: Ints
    side: Ints
    cell: Ints
    hanging: Bools
    at_point: Ints
    in_edge: Ints


def cell_sides(mesh: PolyMesh) -> Sides:
    """Find the sides of every cell, and where each is to be divided.

    A side is divided at its point nearest to the middle if that is within a quarter of its length, otherwise at the
    middle of its edge that holds the middle. So the points that hang on a cell are used when it is refined, and both
    cells at an edge divide it at the same place.
    """
    offsets, rows = mesh.cell_offsets.astype(np.int64), row_numbers(mesh.cell_offsets)
    following = next_in_row(mesh.cell_offsets)
    steps = mesh.points[mesh.cell_points[following]] - mesh.points[mesh.cell_points]
    turn = np.empty(len(rows))
    turn[following] = np.abs(
        np.arctan2(
            steps[:, 0] * steps[following, 1] - steps[:, 1] * steps[following, 0],
            np.einsum("ni,ni->n", steps, steps[following]),
        )
    )
    corner = turn > STRAIGHT
    few = np.add.reduceat(corner, offsets[:-1], dtype=np.int64) < 3
    corner |= few[rows]
    first = np.full(mesh.n_cells, len(rows))
    np.minimum.at(first, rows[corner], np.flatnonzero(corner))
    within = np.arange(len(rows)) - offsets[rows]
    around = (first[rows] - offsets[rows] + within) % mesh.cell_sizes[rows]
    entries = (offsets[rows] + around).astype(np.int64)
    starts = corner[entries]
    side = np.cumsum(starts) - 1
    outer = (mesh.edge_cells[mesh.cell_edges] < 0).any(axis=1)
    lengths = np.hypot(*steps.T)[entries]
    at_point, in_edge = _divisions(lengths, side, starts)
    return Sides(entries, side, rows[starts], ((turn < HANGING) & ~outer)[entries] & ~starts, at_point, in_edge)


def _divisions(lengths: Floats, side: Ints, starts: Bools) -> tuple[Ints, Ints]:
    """Entry whose point divides each side, and entry whose edge does, -1 for none."""
    first = np.flatnonzero(starts)
    total = np.add.reduceat(lengths, first)
    ends = np.cumsum(lengths)
    begin = ends - lengths
    share = (begin - begin[first][side]) / total[side]  # of each entry's point
    off = np.where(starts, np.inf, np.abs(share - 0.5))
    order = np.lexsort((off, side))
    at_point = order[first]  # sides are in order, so each one's nearest point is at its first place
    at_point = np.where(off[at_point] <= MIDDLE, at_point, -1)
    below = np.where(share <= 0.5, np.arange(len(side)), -1)
    in_edge = np.maximum.reduceat(below, first)
    return at_point, np.where(at_point >= 0, -1, in_edge)
