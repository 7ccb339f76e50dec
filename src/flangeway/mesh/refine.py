"""Refinement of triangles and polygons, of all cells or of some."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, check_integer, is_finite, refused
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray, cross_product, norms, point_text
from flangeway.mesh.connectivity import EdgeCurves, entries_of, next_in_row, offsets_of, pairs_divided, row_numbers
from flangeway.mesh.curved import Curves, snapped_points
from flangeway.mesh.cutting import GOOD_DISTANCE, HALVED_DIAMETER, cut_polygon, has_notch, visible_distances
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Bools, Floats, Ints

BYTES_A_TRIANGLE = 740
BYTES_A_POLYGON = 2400  # of the construction, for each cell that is refined; measured
MAX_SIDE_TURN = np.deg2rad(15.0)  # turn at a point below which both edges belong to one side
MAX_HANGING_TURN = 1e-6  # turn in radians below which a point of a cell counts as one that hangs on its side
MAX_DIVIDED_SIDES = 8  # above, the corners at the centre become sharp
MAX_MIDDLE_DISTANCE = 0.25
"""Distance from the middle of a side, relative to its length, within which a point of it divides the side."""


def refined(
    mesh: PolyMesh, cells: ArrayLike | None = None, *, most_hanging: int | None = None, outline: Curves | None = None
) -> PolyMesh:
    """Return the mesh with all cells, or some, cut into smaller ones.

    A triangle is cut into four at the middles of its sides, other polygons into quadrilaterals from the centroid to the
    middles of their sides. A polygon that this does not halve, since its centroid is not in the middle or it has many
    sides, and one with a notch is cut along chords between corners and middles of edges, from notches first, into round
    parts of about half its diameter. So diameters of all cells fall by 0.55 or less at each refinement or soon after.

    Neighbours of refined cells only get the new points, which hang on their sides: they become polygons with a point
    more, and neither shape nor solution need anything else. A cell that is refined later is divided at the points that
    hang on it. Cells and edges of named sets hand their names down.

    A mesh of triangles of which all are refined stays one: points keep their numbers, the middles follow in the order
    of ``mesh.edges``, and triangle i becomes the triangles 4 i to 4 i + 3.

    Parameters
    ----------
    mesh
        Any mesh whose cells fit together.
    cells
        Cells to refine: numbers, or a mask (n_cells,); all by default.
    most_hanging
        Refine also the cells with a side on which more points would hang, until there is none. No limit by default.
    outline
        All curves of the boundary: its points near an arc, new ones and old ones, are moved onto it. Without it new
        points lie on the edges: curved ones stay on their curves (see `flangeway.mesh.curved`), then without this.

    Raises
    ------
    InputError
        If a cell number is wrong, the limit is below one, or a cell folds over.
    OutOfMemoryError
        If there is no memory for it.
    """
    marked = _mask(mesh, cells)
    n_marked = int(np.count_nonzero(marked))
    alike = n_marked == mesh.n_cells and bool(np.all(mesh.cell_sizes == 3))
    refuse_large_mesh(
        f"the refinement of {n_marked:,} cells", (BYTES_A_TRIANGLE if alike else BYTES_A_POLYGON) * n_marked
    )
    if most_hanging is not None:
        check_integer("refined", "most_hanging", most_hanging, 1, advice="leave it out for no limit")
    if alike:
        return _finished(_refined_triangles(mesh), outline)
    fine = _finished(_divided(*_cut(mesh, marked)), outline)
    if most_hanging is None:
        return fine
    crowded = _crowded(fine, most_hanging)
    return refined(fine, crowded, most_hanging=most_hanging, outline=outline) if crowded.any() else fine


def _cut(mesh: PolyMesh, marked: Bools) -> tuple[PolyMesh, Bools]:
    """Mesh in which the marked cells are cut that no division from a centre halves, and which are still to divide."""
    chosen = np.flatnonzero(marked & ~_divisible(mesh, marked))
    if not len(chosen):
        return mesh, marked
    parts: dict[int, tuple[Pieces, Floats]] = {}
    for cell in chosen.tolist():
        corners = mesh.points[mesh.corners(cell)]
        pieces, points = cut_polygon(corners, np.ones(len(corners), dtype=bool))
        parts[cell] = pieces, points[2 * len(corners) :]
    still = marked.copy()
    still[chosen] = False
    fine, owner = _with_parts(mesh, parts)
    return fine, still[owner]


def _divided(mesh: PolyMesh, marked: Bools) -> PolyMesh:
    """Mesh in which the marked cells are divided about their centroids, triangles at the middles of their sides."""
    sides, parts = cell_sides(mesh), {}
    at_point = sides.at_point >= 0
    # divisions of sides as places in the ring: 2 i at corner i, 2 i + 1 in the middle of the edge behind it
    entries = sides.entries[np.where(at_point, sides.at_point, sides.in_edge)]
    rows = 2 * (entries - mesh.cell_offsets[sides.cell]) + ~at_point
    first = np.searchsorted(sides.cell, np.arange(mesh.n_cells + 1))
    for cell in np.flatnonzero(marked).tolist():
        n, around = int(mesh.cell_sizes[cell]), rows[first[cell] : first[cell + 1]].tolist()
        ends = [index // 2 + n * (index % 2) for index in around]
        centre = [2 * n] if len(ends) > 3 else []
        pieces = []
        for i, end in enumerate(ends):
            last = around[i] + 2 * n * (around[i] <= around[i - 1])
            between = [corner % n for corner in range(around[i - 1] // 2 + 1, (last + 1) // 2)]
            pieces.append([ends[i - 1], *between, end, *centre])
        parts[cell] = (pieces if centre else [*pieces, ends]), mesh.cell_centroids[[cell] * len(centre)]
    return _with_parts(mesh, parts)[0]


Pieces = list[list[int]]
"""Parts of a cell of n points: of its points (below n), the middles of the edges behind them (from n), inner points."""


def _with_parts(mesh: PolyMesh, parts: Mapping[int, tuple[Pieces, Floats]]) -> tuple[PolyMesh, Ints]:
    """Mesh with cells replaced by pieces with inner points (k, 2), and the old cell of each new one.

    Points keep their numbers; the middles of edges that a piece uses follow in the order of the edges, and are points
    of the neighbours too; then the inner points.
    """
    cells = np.array(list(parts), dtype=np.int64)
    pieces = [piece for pieces, _ in parts.values() for piece in pieces]
    inner = [points for _, points in parts.values()]
    first_inner = np.zeros(mesh.n_cells, dtype=np.int64)
    first_inner[cells] = offsets_of(np.array(list(map(len, inner)), dtype=np.int64))[:-1]
    # pieces as numbers of points; new ones are numbered with the middles of edges that stay whole
    owner, counts = np.repeat(cells, [len(rows) for rows, _ in parts.values()]), list(map(len, pieces))
    local, cell = np.fromiter(itertools.chain.from_iterable(pieces), np.int64), np.repeat(owner, counts)
    n = mesh.cell_sizes[cell]
    at, on_edge = mesh.cell_offsets[cell] + local % n, (local >= n) & (local < 2 * n)
    number = np.where(on_edge, mesh.n_points + mesh.cell_edges[at], mesh.cell_points[at])
    number = np.where(local < 2 * n, number, mesh.n_points + mesh.n_edges + first_inner[cell] + local - 2 * n)
    split = np.zeros(mesh.n_edges, dtype=bool)
    split[mesh.cell_edges[at[on_edge]]] = True
    # with the other cells, in the order of the cells
    others = np.flatnonzero(~np.isin(np.arange(mesh.n_cells), cells))
    owner = np.concatenate((owner, others))
    order = np.argsort(owner, kind="stable")
    rows = offsets_of(np.concatenate((counts, mesh.cell_sizes[others])).astype(np.int64))
    entries, offsets = entries_of(rows, order)
    owner, ring = owner[order], np.append(number, mesh.cell_points[entries_of(mesh.cell_offsets, others)[0]])[entries]
    # middles of divided edges go between their ends
    after, base, cut = ring[next_in_row(offsets)], mesh.n_points + mesh.n_edges + len(local), np.flatnonzero(split)
    keys = np.append(mesh.edges[cut].astype(np.int64) @ [base, 1], -1)
    wanted = np.minimum(ring, after) * base + np.maximum(ring, after)
    edge = np.searchsorted(keys[:-1], wanted)
    halved = keys[edge] == wanted
    sizes = np.diff(offsets) + np.add.reduceat(halved, offsets[:-1], dtype=np.int64)
    ring = np.insert(ring, np.flatnonzero(halved) + 1, mesh.n_points + cut[edge[halved]])
    taken = np.unique(np.append(ring, np.arange(mesh.n_points)))  # a cut may have points that no piece uses
    fine = PolyMesh(
        np.vstack([mesh.points, mesh.edge_middles(np.arange(mesh.n_edges)), *inner])[taken],
        offsets_of(sizes),
        np.searchsorted(taken, ring).astype(np.int32),
        {name: np.flatnonzero(np.isin(owner, members)).astype(np.int32) for name, members in mesh.cell_sets.items()},
        _halved_sets(mesh, split),
        _halved_curves(mesh, split),
    )
    return fine, owner


def _divisible(mesh: PolyMesh, marked: Bools) -> Bools:
    """Which cells a division from the centroid to the middles of sides makes cells of half the diameter of, (n_cells,).

    The centroid sees the whole cell well and lies near its middle, and the cell has few sides and no notch.
    """
    cells = np.flatnonzero(marked).astype(np.int32)
    widths = mesh.cell_areas[cells] / mesh.cell_diameters[cells]
    centres = mesh.cell_centroids[cells]
    good = visible_distances(mesh, cells, centres) >= GOOD_DISTANCE * widths
    sides = cell_sides(mesh)
    n_sides = np.bincount(sides.cell, minlength=mesh.n_cells)[cells]
    away = norms(mesh.points[mesh.cell_points] - mesh.cell_centroids[row_numbers(mesh.cell_offsets)])
    radius = np.maximum.reduceat(away, mesh.cell_offsets[:-1])[cells]
    good &= (n_sides <= MAX_DIVIDED_SIDES) & ((n_sides == 3) | (radius <= HALVED_DIAMETER * mesh.cell_diameters[cells]))
    # sides are divided at points that they have, which may be far from the middle
    starts = mesh.points[mesh.cell_points[sides.entries[np.flatnonzero(np.diff(sides.side, prepend=-1))]]]
    middles = mesh.points[mesh.cell_points[sides.entries[sides.at_point]]]
    without = sides.at_point < 0
    middles[without] = mesh.edge_middles(mesh.cell_edges[sides.entries[sides.in_edge[without]]])
    after, longest = next_in_row(offsets_of(np.bincount(sides.cell))), np.zeros(mesh.n_cells)
    for one, other in ((starts, middles), (starts[after], middles), (middles[after], middles)):
        np.maximum.at(longest, sides.cell, norms(one - other))
    good &= longest[cells] <= HALVED_DIAMETER * mesh.cell_diameters[cells]
    for row in np.flatnonzero(good & (mesh.cell_sizes[cells] > 3)):
        good[row] = not has_notch(mesh.points[mesh.corners(cells[row])])
    result = np.zeros(mesh.n_cells, dtype=bool)
    result[cells[good]] = True
    return result


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
        np.arctan2(cross_product(steps, steps[following]), np.einsum("ni,ni->n", steps, steps[following]))
    )
    corner = turn > MAX_SIDE_TURN
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
    lengths = norms(steps)[entries]
    at_point, in_edge = _divisions(lengths, side, starts)
    return Sides(
        entries, side, rows[starts], ((turn < MAX_HANGING_TURN) & ~outer)[entries] & ~starts, at_point, in_edge
    )


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
    at_point = np.where(off[at_point] <= MAX_MIDDLE_DISTANCE, at_point, -1)
    below = np.where(share <= 0.5, np.arange(len(side)), -1)
    in_edge = np.maximum.reduceat(below, first)
    return at_point, np.where(at_point >= 0, -1, in_edge)


def _mask(mesh: PolyMesh, cells: ArrayLike | None) -> Bools:
    if cells is None:
        return np.ones(mesh.n_cells, dtype=bool)
    given = np.asarray(cells)
    if given.dtype == bool and given.shape == (mesh.n_cells,):
        return given
    mask = np.zeros(mesh.n_cells, dtype=bool)
    if given.size:
        if given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= mesh.n_cells:
            raise InputError(
                f"cells to refine of type {given.dtype}: {short(given)}",
                f"cell numbers from 0 to {mesh.n_cells - 1}, or a mask of {mesh.n_cells}",
                "number the cells from zero",
            )
        mask[given] = True
    return mask


def _crowded(mesh: PolyMesh, most_hanging: int) -> Bools:
    """Which cells have a side with more hanging points than allowed, (n_cells,)."""
    sides = cell_sides(mesh)
    crowded = np.zeros(mesh.n_cells, dtype=bool)
    crowded[sides.cell[np.bincount(sides.side, sides.hanging) > most_hanging]] = True
    return crowded


def _finished(mesh: PolyMesh, outline: Curves | None) -> PolyMesh:
    if outline is not None:
        mesh = replace(mesh, points=snapped_points(mesh, outline))
    if mesh.cell_areas.min() <= 0.0:
        point = mesh.points[mesh.cell_points[mesh.cell_offsets[mesh.cell_areas.argmin()]]]
        raise InputError(
            f"a cell near {point_text(point)} that folds over when it is refined",
            "cells that stay simple" + ("" if outline is None else " with their new points on the outline"),
            "check the mesh" if outline is None else "refine the cells at the boundary first, or leave out the outline",
        )
    return mesh


def _halved_sets(mesh: PolyMesh, split: Bools) -> dict[str, IntArray]:
    """Edge sets with the new points, which are numbered behind the mesh's own in the order of the edges."""
    number = mesh.n_points + np.cumsum(split) - 1
    sets = {}
    for name, pairs in mesh.edge_sets.items():
        edges = mesh.edge_numbers(pairs)
        rows = np.flatnonzero(split[edges])
        sets[name] = pairs_divided(pairs, rows, number[edges[rows]])
    return sets


def _halved_curves(mesh: PolyMesh, split: Bools) -> EdgeCurves | None:
    """Curved edges with the new points."""
    if mesh.curves is None:
        return None
    edges = mesh.edge_numbers(mesh.curves.pairs)
    return mesh.curves.halved(np.where(split[edges], (mesh.n_points + np.cumsum(split) - 1)[edges], -1))


def _refined_triangles(mesh: PolyMesh) -> PolyMesh:
    corners = mesh.cell_points.reshape(-1, 3)
    middles = mesh.n_points + mesh.cell_edges.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = corners.T, middles.T
    triangles = np.column_stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]).reshape(-1, 3)
    split = np.ones(mesh.n_edges, dtype=bool)
    return PolyMesh.from_cells(
        np.vstack([mesh.points, mesh.edge_middles(np.arange(mesh.n_edges))]),
        triangles,
        cell_sets={name: np.add.outer(4 * cells, np.arange(4)).ravel() for name, cells in mesh.cell_sets.items()},
        edge_sets=_halved_sets(mesh, split),
        curves=_halved_curves(mesh, split),
    )


def doerfler_marking(cell_errors: ArrayLike, share: float = 0.5) -> IntArray:
    """Return the fewest cells that hold a share of the sum of the squared errors, in rising order.

    Source: Doerfler, 1996, SIAM J. Numer. Anal. 33, with the share of the squares (theta squared there).

    Parameters
    ----------
    cell_errors
        Estimated error of each cell (n_cells,), zero or more.
    share
        Between 0 and 1: a small one refines few cells a step, 1 all cells with an error.

    Raises
    ------
    InputError
        If an error is negative or not finite, or the share is out of its range.
    """
    errors = as_numbers("cell errors", cell_errors)
    if errors.ndim != 1 or not len(errors) or not (np.isfinite(errors).all() and (errors >= 0.0).all()):
        raise InputError(
            f"cell errors of shape {errors.shape}, or with one below zero or not finite",
            "one number for each cell, zero or more",
            "look at the estimate",
        )
    if not (is_finite(share) and 0.0 < share <= 1.0):
        raise refused("doerfler_marking", "share", share, "a number above 0, up to 1", "leave 0.5")
    order = np.argsort(-errors, kind="stable")
    sums = np.cumsum(errors[order] ** 2)
    if not sums[-1] > 0.0:
        return np.zeros(0, dtype=np.int32)
    n_marked = int(np.searchsorted(sums, share * sums[-1] * (1.0 - 1e-12))) + 1
    n_marked = min(n_marked, int(np.count_nonzero(errors)))
    return np.sort(order[:n_marked]).astype(np.int32)
