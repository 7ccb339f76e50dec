"""A sound mesh from what a file gives: small faults are repaired with a notice, the rest is refused."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, as_point, circle_centres, cross_product, extent, norms
from flangeway.geometry.segments import Arc
from flangeway.mesh.connectivity import (
    EdgeCurves,
    edge_places,
    first_connected,
    next_in_row,
    offsets_of,
    places_among,
    row_numbers,
    rows_reversed,
)
from flangeway.mesh.mesh_checks import check, conforming, hanging_points, touching_distance
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Floats, Indices, Ints, floats

MIN_SAGITTA = 1e-5  # distance of the middle of a side from its chord, relative to this, above which it is curved
MAX_HEIGHT = 1e-9  # range of the third coordinate, relative to the size of the mesh, up to which a mesh is plane


@dataclass(frozen=True, eq=False)
class DrawnMesh:
    """A mesh as a file gives it: not checked yet.

    Points (n, 2) or (n, 3), the points of each cell, sets of cells, of pairs of points and of points by name (the last
    ones are the boundary edges with both ends among them), what reading left out or changed, the numbers of the points
    inside edges and cells of second or higher order, and ends and middle of sides of second order (m, 3).
    """

    points: Floats
    cells: list[Ints]
    cell_sets: Mapping[str, Indices] = field(default_factory=dict)
    edge_sets: Mapping[str, Indices] = field(default_factory=dict)
    point_sets: Mapping[str, Indices] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    middles: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    sides: Ints = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))


def second_order_sides(rows: Indices, n_corners: int) -> Ints:
    """Ends and middles (m, 3) of the sides of cells of second order, rows of corners and then middles; else none."""
    n_sides = n_corners if n_corners > 2 else 1
    if rows.shape[1] - n_corners not in (n_sides, n_sides + (n_corners > 2)):
        return np.zeros((0, 3), dtype=np.int64)
    ends = np.arange(n_sides)
    columns = np.column_stack((ends, (ends + 1) % n_corners, n_corners + ends))
    return rows[:, columns].reshape(-1, 3).astype(np.int64)


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh that was read.

    - `notices`: a sentence for each thing that was repaired or left out.
    """

    mesh: PolyMesh
    notices: tuple[str, ...] = ()

    def part(self, *cell_sets: str) -> "MeshFile":
        """Return the cells of some sets as a mesh of their own, as of one body in a file of several.

        Its points at one place become one, its edge sets are what is left of those of the file. Read the file with
        ``merge_points=False``, so that bodies that touch stay apart. An `InputError` for an unknown set.
        """
        mesh = self.mesh.part(np.concatenate([self.mesh.cell_set(name) for name in cell_sets]))
        cells = np.split(mesh.cell_points.astype(np.int64), mesh.cell_offsets[1:-1])
        drawn = DrawnMesh(mesh.points, cells, mesh.cell_sets, mesh.edge_sets)
        if mesh.curves is not None:
            middles = mesh.n_points + np.arange(len(mesh.curves.pairs))
            points = np.vstack((mesh.points, mesh.curves.points([0.5])[:, 0]))
            drawn = replace(drawn, points=points, middles=middles, sides=np.column_stack((mesh.curves.pairs, middles)))
        return repaired_mesh(drawn)


def repaired_mesh(drawn: DrawnMesh, *, merge_points: bool = True) -> MeshFile:
    """Return the mesh in the plane with counter-clockwise cells, each once, and points that are used, each once.

    With `merge_points`, points nearer than `touching_distance` of the longest side at either become one, and points
    that hang on edges of cells are added to these. An `InputError` if there is no cell, the mesh is not plane, or
    `check` refuses what cannot be repaired.
    """
    notices = list(drawn.notices)
    if not drawn.cells:
        raise InputError("a file without plane cells", "triangles, quadrilaterals or polygons", "export them")
    points = _plane(floats(drawn.points), notices)
    numbers = _first_of_equal(points, drawn.cells, notices) if merge_points else np.arange(len(points))
    cells, kept = _sound_cells(points, [numbers[cell] for cell in drawn.cells], notices)
    used, flat = np.unique(np.concatenate(cells), return_inverse=True)
    spare = numbers == np.arange(len(points))
    spare[used] = False
    spare[drawn.middles] = False
    n_left_out = int(spare.sum())
    if n_left_out:
        notices.append(f"{_many(n_left_out, 'point')} of no cell left out.")
    mesh = PolyMesh(
        points[used],
        offsets_of(np.array([len(cell) for cell in cells])),
        flat.astype(np.int32),
        {name: _int32(kept[members][kept[members] >= 0]) for name, members in drawn.cell_sets.items()},
    )
    if merge_points:
        check(mesh, allow_hanging=True)
        n_hanging = len(np.unique(hanging_points(mesh)[1]))
        if n_hanging:
            notices.append(f"{_many(n_hanging, 'point')} hanging on edges: made points of the cells there too.")
        mesh = conforming(mesh)
    apart = not merge_points
    check(mesh, allow_hanging=apart, allow_coincident=apart, bodies_alone=apart)
    new = places_among(used, len(points))[numbers]
    mesh = with_arcs(mesh, new[drawn.sides[:, :2]], points[drawn.sides[:, 2]])
    if len(drawn.middles):
        curved = 0 if mesh.curves is None else len(mesh.curves.pairs)
        notices.append(
            f"Cells of second or higher order are read as the polygons of their corners; {_many(curved, 'side')} of "
            "second order became arcs through their three points. Elements here make their own nodes inside edges."
        )
    for name, pairs in drawn.edge_sets.items():
        mesh = _with_edges(mesh, name, new[np.asarray(pairs)], notices)
    for name, members in drawn.point_sets.items():
        inside = np.zeros(mesh.n_points + 1, dtype=bool)
        inside[new[members]] = True  # the last place takes points that are left out
        rim = mesh.boundary_edges[inside[mesh.boundary_edges].all(axis=1)]
        if name in mesh.edge_sets:
            continue
        if len(rim):
            mesh = mesh.with_edge_set(name, rim)
        else:
            notices.append(f"Node set '{name}': no boundary edge has both ends in it; left out.")
    return MeshFile(mesh, tuple(notices))


def with_arcs(mesh: PolyMesh, pairs: Indices, middles: Floats) -> PolyMesh:
    """Put edges on arcs through their ends (m, 2), -1 where one is left out, and middles (m, 2), unless straight."""
    rows = np.flatnonzero((pairs >= 0).all(axis=1))
    number, known = edge_places(pairs[rows], mesh.edges, mesh.n_points)
    rows = rows[known][np.unique(number[known], return_index=True)[1]]
    start = mesh.points[pairs[rows, 0]]
    across, chord = middles[rows] - start, mesh.points[pairs[rows, 1]] - start
    cross = cross_product(across, chord)
    bent = np.abs(cross) > MIN_SAGITTA * (chord**2).sum(axis=1)
    if not bent.any():
        return mesh
    rows, centres = rows[bent], start[bent] + circle_centres(across[bent], chord[bent])
    ends = mesh.points[pairs[rows]]
    arcs = tuple(
        Arc(as_point(a), as_point(b), as_point(c), bool(left))
        for (a, b), c, left in zip(ends, centres, cross[bent] > 0.0, strict=True)
    )
    n = len(rows)
    return replace(
        mesh, curves=EdgeCurves(pairs[rows].astype(np.int32), arcs, np.arange(n), np.tile([0.0, 1.0], (n, 1)))
    )


def _int32(values: Ints) -> IntArray:
    return values.astype(np.int32)


def _many(count: int, what: str) -> str:
    return f"1 {what}" if count == 1 else f"{count} {what}s"


def _plane(points: Floats, notices: list[str]) -> Floats:
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise InputError(f"points of shape {points.shape}", "(n, 2) or (n, 3), one or more", "export the points")
    if not np.isfinite(points).all():
        row = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise InputError(f"point {row} at {points[row].tolist()}", "finite coordinates", "repair the file")
    if points.shape[1] == 3:
        height = points[:, 2]
        if np.ptp(height) > MAX_HEIGHT * extent(points):
            raise InputError(
                f"a mesh with z from {height.min():.6g} to {height.max():.6g}",
                "a plane mesh in x and y, with one z for all points",
                "export the section in the plane of x and y",
            )
        if height[0] != 0.0:
            notices.append(f"The mesh lies at z = {height[0]:.6g}, which is left out.")
    return np.ascontiguousarray(points[:, :2])


def _first_of_equal(points: Floats, cells: list[Ints], notices: list[str]) -> Ints:
    """For each point the first one at its place, as `check` sees it; only points of cells count."""
    flat = np.concatenate(cells)
    following = flat[next_in_row(offsets_of(np.array([len(cell) for cell in cells])))]
    lengths = norms(points[following] - points[flat])
    reach = np.zeros(len(points))
    for ends in (flat, following):
        np.maximum.at(reach, ends, touching_distance(lengths, points[flat]))
    used = np.unique(flat)
    near = used[cKDTree(points[used]).query(points[used], k=2)[0][:, 1] <= reach[used]]
    pairs = np.zeros((0, 2), dtype=np.int64)
    if len(near):
        pairs = near[cKDTree(points[near]).query_pairs(reach[near].max(), output_type="ndarray")]
        pairs = pairs[norms(points[pairs[:, 0]] - points[pairs[:, 1]]) <= reach[pairs].min(axis=1)]
    first = first_connected(pairs, len(points))
    if len(pairs):
        x, y = points[pairs[0, 0]]
        notices.append(
            f"{_many(int((first != np.arange(len(first))).sum()), 'point')} at the place of another one, as at "
            f"({x:.6g}, {y:.6g}), made one with it: what touches there is joined."
        )
    return first


def _sound_cells(points: Floats, cells: list[Ints], notices: list[str]) -> tuple[list[Ints], Ints]:
    """Counter-clockwise cells without repeated points, each once; and the new number of each cell."""
    lengths = np.array([len(cell) for cell in cells])
    given, offsets = np.concatenate(cells), offsets_of(lengths)
    single, owner = given != given[next_in_row(offsets)], row_numbers(offsets)
    sizes = np.bincount(owner[single], minlength=len(cells))
    sound = np.flatnonzero(sizes >= 3)
    if not len(sound):
        raise InputError("cells without area", "triangles, quadrilaterals or polygons", "look at the file")
    corners, offsets = given[single & (sizes >= 3)[owner]], offsets_of(sizes[sound])
    corner_offsets = points[corners] - np.repeat(points[corners[offsets[:-1]]], sizes[sound], axis=0)
    clockwise = np.add.reduceat(cross_product(corner_offsets, corner_offsets[next_in_row(offsets)]), offsets[:-1]) < 0.0
    corners = np.where(np.repeat(clockwise, sizes[sound]), corners[rows_reversed(offsets)], corners)
    result: list[Ints] = []
    known: dict[tuple[int, ...], int] = {}
    numbers = np.full(len(cells), -1, dtype=np.int64)
    for number, cell in zip(sound.tolist(), np.split(corners, offsets[1:-1]), strict=True):
        row = cell.tolist()
        first = row.index(min(row))  # a cell may be given from any of its points on
        numbers[number] = known.setdefault((*row[first:], *row[:first]), len(result))
        if numbers[number] == len(result):
            result.append(cell)
    faults = {
        "with one point several times in a row: the repetitions are left out": int((sizes < lengths)[sound].sum()),
        "with fewer than three different points left out": len(cells) - len(sound),
        "clockwise: turned": int(clockwise.sum()),
        "given a second time: left out, its sets kept": len(sound) - len(result),
    }
    notices += [f"{_many(count, 'cell')} {fault}." for fault, count in faults.items() if count]
    return result, numbers


def _with_edges(mesh: PolyMesh, name: str, pairs: Ints, notices: list[str]) -> PolyMesh:
    """Name those of the pairs that are boundary edges."""
    low, high = np.sort(pairs, axis=1).T
    rim = np.sort(mesh.boundary_edges.astype(np.int64), axis=1)
    outer = np.isin(low * mesh.n_points + high, rim[:, 0] * mesh.n_points + rim[:, 1]) & (low >= 0)
    if not outer.all():
        notices.append(
            f"Edge set '{name}': {_many(int((~outer).sum()), 'edge')} that the boundary does not have, left out."
        )
    return mesh.with_edge_set(name, np.unique(pairs[outer], axis=0)) if outer.any() else mesh
