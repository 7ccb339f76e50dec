"""Dual polygons of a triangulation, one cell about every point, and those of a section of several parts."""

import functools
from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, angles_of, cross_product, extent, point_text
from flangeway.mesh.connectivity import first_connected, next_in_row, offsets_of, places_among, row_numbers
from flangeway.mesh.curved import Curves, curved
from flangeway.mesh.insertion import divided
from flangeway.mesh.mesh_checks import check
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
    order, n_rim = _order_of_rim(mesh), len(mesh.boundary_edges)
    rim, halved = mesh.boundary_edges[order], divided(mesh, order, np.full(n_rim, 0.5))
    points = np.vstack([centroids, halved.points[n_points:], mesh.points[rim[:, 0]]])
    leaving, reaching = (places_among(ends, n_points) for ends in rim.T)

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
    number = np.append(n_triangles + n_rim + leaving, n_triangles + np.arange(n_rim)).astype(np.int32)
    edge_sets = {name: number[pairs] for name, pairs in halved.edge_sets.items()}
    curves = halved.curves  # those inside are no edges of the dual
    if curves is not None:
        curves = curves.taken(curves.pairs.max(axis=1) >= n_points, number)
    return PolyMesh(points, offsets, cell_points, _carried_sets(mesh), edge_sets, curves)


def _refuse_unfit(mesh: PolyMesh) -> None:
    if np.any(mesh.cell_sizes != 3):
        cell = int(np.argmax(mesh.cell_sizes != 3))
        raise InputError(
            f"cell {cell} with {mesh.cell_sizes[cell]} points at {point_text(mesh.cell_centroids[cell])}",
            "triangles only",
            "take the dual of the triangulation",
        )
    check(mesh, allow_hanging=True, allow_coincident=True)


def _order_of_rim(mesh: PolyMesh) -> Ints:
    """Return the order of the boundary edges by their first points, none of which is that of two."""
    first = mesh.boundary_edges[:, 0]
    order = np.argsort(first, kind="stable")
    twice = np.flatnonzero(np.diff(first[order]) == 0)
    if len(twice):
        point = int(first[order[twice[0]]])
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])}, where the boundary touches itself",
            "a boundary that passes every point once",
            "separate the parts that touch, or take duals of the parts",
        )
    return order


def _rings(mesh: PolyMesh, centroids: Floats, rim: IntArray, leaving: Ints) -> tuple[IntArray, Ints]:
    """Return offsets (n_points + 1,) and triangles about every point, by rising angle."""
    about = mesh.cell_points.astype(np.int64)
    triangles = row_numbers(mesh.cell_offsets)
    rays = centroids[triangles] - mesh.points[about]
    angles = angles_of(rays)
    edges = mesh.points[rim[:, 1]] - mesh.points[rim[:, 0]]
    first = np.zeros(mesh.n_points)
    first[rim[:, 0]] = angles_of(edges)
    order = np.lexsort((np.mod(angles - first[about], 2.0 * np.pi), about))
    rings = offsets_of(np.bincount(about, minlength=mesh.n_points))
    rays = rays[order]
    following = next_in_row(rings)
    turns = cross_product(rays, rays[following])
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
    parts = [dual(mesh.part(cells)) for cells in mesh.cell_sets.values()]
    glued = _glued(functools.reduce(PolyMesh.merged, parts), 1e-9 * extent(mesh.points))
    middles = glued.points[glued.boundary_edges].mean(axis=1)
    for name, pairs in mesh.edge_sets.items():
        start, end = mesh.points[pairs].swapaxes(0, 1)
        middle = mesh.edge_middles(mesh.edge_numbers(pairs))
        halves = np.vstack([start + middle, end + middle]) / 2.0
        glued = glued.with_edge_set(name, glued.boundary_edges[cKDTree(middles).query(halves)[1]])
    return glued


def _glued(mesh: PolyMesh, tolerance: float) -> PolyMesh:
    """Return the mesh with points nearer than a tolerance made one."""
    pairs = cKDTree(mesh.points).query_pairs(tolerance, output_type="ndarray")
    kept, numbers = np.unique(first_connected(pairs, mesh.n_points), return_inverse=True)
    curves = mesh.curves
    if curves is not None:  # of an interface both parts have the edges
        curves = curves.renumbered(numbers)
        curves = curves.taken(np.unique(np.sort(curves.pairs, axis=1), axis=0, return_index=True)[1])
    corners = numbers[mesh.cell_points].astype(np.int32)
    return PolyMesh(mesh.points[kept], mesh.cell_offsets, corners, mesh.cell_sets, curves=curves)
