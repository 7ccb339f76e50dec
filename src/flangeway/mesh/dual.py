"""Dual polygons of a triangulation, one cell about every point, and those of a section of several parts."""

import functools
from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, point_text
from flangeway.mesh.connectivity import next_in_row, offsets_of, row_numbers
from flangeway.mesh.curved import Curves, curved
from flangeway.mesh.edge_curves import EdgeCurves
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Floats, Ints

BYTES_A_TRIANGLE = 420  # of the construction; measured 170 to 450


def dual(mesh: PolyMesh, *, outline: Curves | None = None) -> PolyMesh:
    """Return the polygons about the points of a mesh of triangles.

    The polygon of a point is made of the centroids of its triangles and, on the boundary, of the
    middles of its two boundary edges and the point itself, so that the outline is kept. Cell i of
    the dual belongs to point i of `mesh`. The dual's points are the centroids, then the middles
    of the boundary edges, then the boundary points, each in the order of `mesh`. A boundary edge
    (a, b) becomes (a, m), (m, b) in its edge sets. A cell set is carried along if every point has
    either all or none of its triangles in it. Curved edges stay on their curves.

    Source: Moherdaui (2021), section 3.3.6, with the order of the points by angle.

    Parameters
    ----------
    mesh
        Counter-clockwise triangles.
    outline
        All curves of the boundary: edges on its arcs become curved first, see `flangeway.mesh.curved`.

    Returns
    -------
    PolyMesh
        With ``mesh.n_points`` cells.

    Raises
    ------
    InputError
        If a cell is not a triangle or is clockwise, a point has no triangle, the boundary touches
        itself at a point, a cell set divides the triangles of a point, or two neighbouring
        triangles are so flat that the polygon would fold over.
    OutOfMemoryError
        If there is no memory for it.
    """
    refuse_large_mesh(f"the dual polygons of {mesh.n_cells:,} triangles", BYTES_A_TRIANGLE * mesh.n_cells)
    _refuse_unfit(mesh)
    if outline is not None:
        mesh = curved(mesh, outline)
    n_triangles, n_points = mesh.n_cells, mesh.n_points
    centroids = mesh.points[mesh.cell_points.reshape(-1, 3)].mean(axis=1)
    rim = _sorted_rim(mesh)
    n_rim = len(rim)
    middles = mesh.points[rim].mean(axis=1) if mesh.curves is None else mesh.edge_middles(mesh.edge_numbers(rim))
    points = np.vstack([centroids, middles, mesh.points[rim[:, 0]]])
    leaving = np.full(n_points, -1, dtype=np.int64)
    reaching = np.full(n_points, -1, dtype=np.int64)
    leaving[rim[:, 0]] = np.arange(n_rim)
    reaching[rim[:, 1]] = np.arange(n_rim)

    rings, ring_points = _rings(mesh, centroids, rim, leaving)
    counts = np.diff(rings).astype(np.int64)
    on_rim = leaving >= 0
    # a boundary point adds itself and the middle of the leaving edge before, of the reaching after
    offsets = offsets_of(counts + 3 * on_rim)
    cell_points = np.empty(offsets[-1], dtype=np.int32)
    places = np.arange(len(ring_points)) + np.repeat(offsets[:-1] + 2 * on_rim - rings[:-1], counts)
    cell_points[places] = ring_points
    start, end = offsets[:-1][on_rim], offsets[1:][on_rim]
    cell_points[start] = n_triangles + n_rim + leaving[on_rim]
    cell_points[start + 1] = n_triangles + leaving[on_rim]
    cell_points[end - 1] = n_triangles + reaching[on_rim]
    edge_sets = {name: _halved_edges(pairs, leaving, n_triangles, n_rim) for name, pairs in mesh.edge_sets.items()}
    curves = None if mesh.curves is None else _halved_curves(mesh.curves, rim, leaving, n_triangles)
    return PolyMesh(points, offsets, cell_points, _carried_sets(mesh), edge_sets, curves)


def _halved_curves(curves: EdgeCurves, rim: IntArray, leaving: Ints, n_triangles: int) -> EdgeCurves | None:
    """Return the curved edges of the boundary in halves, as points of the dual; those inside are none of its edges."""
    n_points = len(leaving)
    rows = {low * n_points + high: row for row, (low, high) in enumerate(np.sort(rim, axis=1).tolist())}
    middles = np.array([rows.get(low * n_points + high, -1) for low, high in np.sort(curves.pairs, axis=1).tolist()])
    outer = curves.taken(middles >= 0)
    if outer is None:
        return None
    corners = np.append(n_triangles + len(rim) + leaving, n_triangles + np.arange(len(rim))).astype(np.int32)
    return outer.halved(n_points + middles[middles >= 0]).renumbered(corners)


def _refuse_unfit(mesh: PolyMesh) -> None:
    if np.any(mesh.cell_sizes != 3):
        cell = int(np.argmax(mesh.cell_sizes != 3))
        raise InputError(
            f"cell {cell} with {mesh.cell_sizes[cell]} points at {point_text(mesh.cell_centroids[cell])}",
            "triangles only",
            "take the dual of the triangulation",
        )
    if mesh.cell_areas.min() <= 0.0:
        cell = int(mesh.cell_areas.argmin())
        place = point_text(mesh.points[mesh.cell_points[3 * cell]])
        raise InputError(
            f"triangle {cell} at {place} with area {mesh.cell_areas[cell]:.3g}",
            "counter-clockwise triangles with positive areas",
            "check the mesh first",
        )
    used = np.bincount(mesh.cell_points, minlength=mesh.n_points)
    if used.min() == 0:
        raise InputError(f"point {int(used.argmin())} of no triangle", "points that are used", "remove it")


def _sorted_rim(mesh: PolyMesh) -> IntArray:
    """Return the directed boundary edges in the order of their first points."""
    rim = mesh.boundary_edges
    rim = rim[np.argsort(rim[:, 0], kind="stable")]
    twice = np.flatnonzero(rim[1:, 0] == rim[:-1, 0])
    if len(twice):
        point = int(rim[twice[0], 0])
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])}, where the boundary touches itself",
            "a boundary that passes every point once",
            "separate the parts that touch, or take duals of the parts",
        )
    return rim


def _rings(mesh: PolyMesh, centroids: Floats, rim: IntArray, leaving: Ints) -> tuple[IntArray, Ints]:
    """Return offsets (n_points + 1,) and triangles about every point, by rising angle."""
    about = mesh.cell_points.astype(np.int64)
    triangles = row_numbers(mesh.cell_offsets)
    rays = centroids[triangles] - mesh.points[about]
    angles = np.arctan2(rays[:, 1], rays[:, 0])
    edges = mesh.points[rim[:, 1]] - mesh.points[rim[:, 0]]
    first = np.zeros(mesh.n_points)
    first[rim[:, 0]] = np.arctan2(edges[:, 1], edges[:, 0])
    order = np.lexsort((np.mod(angles - first[about], 2.0 * np.pi), about))
    rings = offsets_of(np.bincount(about, minlength=mesh.n_points))
    rays = rays[order]
    following = next_in_row(rings)
    turns = rays[:, 0] * rays[following, 1] - rays[:, 1] * rays[following, 0]
    closing = np.zeros(len(order), dtype=bool)
    closing[rings[1:][leaving >= 0] - 1] = True
    folded = (turns <= 0.0) & ~closing
    if folded.any():
        point = int(about[order[folded.argmax()]])
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])}: two neighbouring triangles are so flat that "
            "their centroids lie half a turn or more apart",
            "triangles that make a simple polygon about every point",
            "refine the mesh there",
        )
    return rings, triangles[order]


def _halved_edges(pairs: IntArray, leaving: Ints, n_triangles: int, n_rim: int) -> IntArray:
    """Return the two halves of every edge of a set, in order, as points of the dual."""
    starts, middles = leaving[pairs[:, 0]], n_triangles + leaving[pairs[:, 0]]
    ends = leaving[pairs[:, 1]]
    corners = n_triangles + n_rim
    halves = np.column_stack([corners + starts, middles, middles, corners + ends])
    return halves.reshape(-1, 2).astype(np.int32)


def _carried_sets(mesh: PolyMesh) -> Mapping[str, IntArray]:
    """Return the cell sets of the dual: the points with all their triangles in the set."""
    total = np.bincount(mesh.cell_points, minlength=mesh.n_points)
    carried = {}
    for name, cells in mesh.cell_sets.items():
        corners = mesh.cell_points.reshape(-1, 3)[cells].ravel()
        inside = np.bincount(corners, minlength=mesh.n_points)
        divided = (inside > 0) & (inside < total)
        if divided.any():
            point = int(divided.argmax())
            raise InputError(
                f"cell set '{name}' with {inside[point]} of the {total[point]} triangles of point "
                f"{point} at {point_text(mesh.points[point])}",
                "sets with all or none of the triangles of a point",
                "take the duals of the parts, or name the cells of the dual",
            )
        carried[name] = np.flatnonzero(inside).astype(np.int32)
    return carried


def dual_section(mesh: PolyMesh) -> PolyMesh:
    """Return the dual polygons of every cell set apart, glued where the sets touch.

    So that each polygon lies in one part; see `dual`. The cell sets must cover the mesh once. Returned: with the same
    cell sets and edge sets.

    - `mesh`: triangles, as from `triangulate_section`.
    """
    if len(mesh.cell_sets) == 1:
        return dual(mesh)
    parts = [dual(_extracted(mesh, name, cells)) for name, cells in mesh.cell_sets.items()]
    glued = _glued(functools.reduce(PolyMesh.merged, parts), 1e-9 * float(np.ptp(mesh.points, axis=0).max()))
    middles = glued.points[glued.boundary_edges].mean(axis=1)
    for name, pairs in mesh.edge_sets.items():
        start, end = mesh.points[pairs].swapaxes(0, 1)
        middle = mesh.edge_middles(mesh.edge_numbers(pairs))
        halves = np.vstack([start + middle, end + middle]) / 2.0
        glued = glued.with_edge_set(name, glued.boundary_edges[cKDTree(middles).query(halves)[1]])
    return glued


def _extracted(mesh: PolyMesh, name: str, cells: IntArray) -> PolyMesh:
    """Return the triangles of one cell set as a separate mesh."""
    used, corners = np.unique(mesh.cell_points.reshape(-1, 3)[cells], return_inverse=True)
    offsets = np.arange(len(cells) + 1, dtype=np.int32) * 3
    curves = mesh.curves
    if curves is not None:
        # an edge belongs to the part if a triangle of it has it
        own = np.isin(mesh.edge_numbers(curves.pairs), mesh.cell_edges.reshape(-1, 3)[cells])
        curves = curves.taken(own)
    return PolyMesh(
        mesh.points[used], offsets, corners.astype(np.int32).ravel(), {name: np.arange(len(cells), dtype=np.int32)},
        curves=None if curves is None else curves.renumbered(np.searchsorted(used, np.arange(mesh.n_points))),
    )  # fmt: skip


def _glued(mesh: PolyMesh, tolerance: float) -> PolyMesh:
    """Return the mesh with points nearer than a tolerance made one."""
    pairs = cKDTree(mesh.points).query_pairs(tolerance, output_type="ndarray")
    first = np.arange(mesh.n_points)
    # each group of coinciding points has one of every part, so that its lowest is paired with all others
    for low, high in sorted(pairs.tolist(), reverse=True):
        first[high] = low
    kept, numbers = np.unique(first, return_inverse=True)
    curves = None if mesh.curves is None else mesh.curves.renumbered(numbers)
    if curves is not None:  # of an interface both parts have the edges
        curves = curves.taken(np.unique(np.sort(curves.pairs, axis=1), axis=0, return_index=True)[1])
    corners = numbers[mesh.cell_points].astype(np.int32)
    return PolyMesh(mesh.points[kept], mesh.cell_offsets, corners, mesh.cell_sets, curves=curves)
