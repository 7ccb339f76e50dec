"""Checks of a mesh's geometry, each with a message that names the place."""

from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import BoolArray, FloatArray, IntArray, point_text
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.ragged import IndexArray, row_numbers

TOUCHING = 1e-9
"""Distance, relative to the size of mesh or edge, below which points count as touching."""


def check(
    mesh: PolyMesh,
    *,
    region_area: float | None = None,
    area_tolerance: float = 1e-9,
    allow_hanging: bool = False,
    allow_coincident: bool = False,
) -> None:
    """Check that cells are simple, positive, and fit together without gap or overlap.

    Parameters
    ----------
    mesh
        What to check.
    region_area
        Area that the cells must fill, if known.
    area_tolerance
        Largest relative difference from it. Where the region has arcs, cells with straight edges
        miss some of it.
    allow_hanging
        Whether points may lie inside edges of other cells.
    allow_coincident
        Whether several points may be at the same place, as where bodies touch or a crack is closed.

    Raises
    ------
    InputError
        If a point is unused or there twice; a cell passes a point twice, crosses itself or has no
        positive area; an edge has two cells on one side; the areas do not sum up; a point hangs on
        an edge; or an edge set leaves the boundary. The message names the cell or point and where
        it is.

    """
    _check_points(mesh, allow_coincident=allow_coincident)
    _check_cells(mesh)
    _check_sides(mesh)
    if region_area is not None:
        _check_sum(mesh, region_area, area_tolerance)
    if not allow_hanging:
        _check_hanging(mesh)
    _check_edge_sets(mesh)


def _cell(mesh: PolyMesh, cell: int) -> str:
    middle = mesh.points[mesh.cell_points[mesh.cell_offsets[cell] : mesh.cell_offsets[cell + 1]]]
    return f"cell {cell} near {point_text(middle.mean(axis=0))}"


def _check_points(mesh: PolyMesh, *, allow_coincident: bool) -> None:
    used = np.bincount(mesh.cell_points, minlength=mesh.n_points)
    if used.min() == 0:
        point = int(used.argmin())
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])} of no cell",
            "points that a cell uses",
            "remove it",
        )
    if allow_coincident:
        return
    size = float(np.hypot(*np.ptp(mesh.points, axis=0)))
    distances, nearest = cKDTree(mesh.points).query(mesh.points, k=2)
    if distances[:, 1].min() <= TOUCHING * size:
        point = int(distances[:, 1].argmin())
        other = next(int(p) for p in nearest[point] if p != point)
        raise InputError(
            f"points {point} and {other} at the same place {point_text(mesh.points[point])}",
            "points that differ",
            "use one point for both",
        )


def _check_cells(mesh: PolyMesh) -> None:
    rows = row_numbers(mesh.cell_offsets)
    order = np.lexsort((mesh.cell_points, rows))
    twice = (np.diff(rows[order]) == 0) & (np.diff(mesh.cell_points[order]) == 0)
    if twice.any():
        where = order[twice.argmax()]
        raise InputError(
            f"{_cell(mesh, int(rows[where]))} passes point {mesh.cell_points[where]} twice",
            "polygons that pass a point once",
            "divide the cell there",
        )
    least = 1e-14 * mesh.cell_diameters**2
    if np.any(mesh.cell_areas <= least):
        cell = int(np.argmax(mesh.cell_areas <= least))
        raise InputError(
            f"{_cell(mesh, cell)} with area {mesh.cell_areas[cell]:.3g}",
            "counter-clockwise cells with positive areas",
            "reverse its points, or remove it if it is flat",
        )
    for n_vertices, cells in mesh.batches():
        corners = mesh.points[mesh.batch_points(n_vertices, cells)]
        for i, j in combinations(range(n_vertices), 2):
            if j - i in (1, n_vertices - 1):
                continue
            crossed = _cross(corners, i, j)
            if crossed.any():
                raise InputError(
                    f"{_cell(mesh, int(cells[crossed.argmax()]))}: its sides {i} and {j} cross",
                    "polygons that do not cross themselves",
                    "reorder its points",
                )


def _cross(corners: FloatArray, i: int, j: int) -> BoolArray:
    """Return whether the sides i and j of polygons (n, n_vertices, 2) have a point in common."""
    n = corners.shape[1]
    a, b, c, d = (corners[:, k % n] for k in (i, i + 1, j, j + 1))

    def side(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        u, v = q - p, r - p
        turn: FloatArray = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        return turn

    apart = (side(a, b, c) * side(a, b, d) > 0.0) | (side(c, d, a) * side(c, d, b) > 0.0)
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    crossed: BoolArray = ~apart & np.all(low <= high, axis=1)
    return crossed


def _check_sides(mesh: PolyMesh) -> None:
    """Refuse an edge that two cells travel in the same direction: they overlap."""
    directed = mesh.edges[mesh.cell_edges][:, 0] == mesh.cell_points
    counts = np.bincount(2 * mesh.cell_edges.astype(np.int64) + directed)
    if counts.max() > 1:
        edge = int(counts.argmax()) // 2
        cells = row_numbers(mesh.cell_offsets)[mesh.cell_edges == edge]
        a, b = mesh.edges[edge]
        raise InputError(
            f"cells {cells.tolist()} on the same side of edge ({a}, {b}) near {point_text(mesh.points[a])}",
            "one cell on each side of an edge",
            "remove the cell that overlaps",
        )


def _check_sum(mesh: PolyMesh, region_area: float, tolerance: float) -> None:
    total = float(mesh.cell_areas.sum())
    if not abs(total - region_area) <= tolerance * abs(region_area):
        raise InputError(
            f"cells with {total:.12g} of area in a region of {region_area:.12g}",
            f"a relative difference up to {tolerance:g}",
            "look for gaps and overlaps; allow for arcs that straight edges cut short",
        )


def _check_hanging(mesh: PolyMesh) -> None:
    edges, points = hanging_points(mesh)
    if len(points):
        start, end = mesh.boundary_edges[edges[0]]
        raise InputError(
            f"point {points[0]} at {point_text(mesh.points[points[0]])} hangs on the edge ({start}, {end})",
            "points at the ends of edges",
            "add the point to the cell of that edge, which may be a polygon with one side more; see `conforming`",
        )


def hanging_points(mesh: PolyMesh) -> tuple[IndexArray, IndexArray]:
    """Return rows of ``mesh.boundary_edges`` and the points (n,) that lie inside them.

    Of two cells that meet along an edge with a hanging point, both have edges with one cell only:
    so it is enough to look at boundary edges and their points.
    """
    pairs = mesh.boundary_edges
    rim = np.unique(pairs)
    a, b = mesh.points[pairs[:, 0]], mesh.points[pairs[:, 1]]
    lengths = np.hypot(*(b - a).T)
    near = cKDTree(mesh.points[rim]).query_ball_point(0.5 * (a + b), 0.5 * lengths)
    counts = np.array([len(found) for found in near])
    edges = np.repeat(np.arange(len(pairs)), counts)
    points = rim[np.concatenate([np.asarray(found, dtype=np.int64) for found in near])].astype(np.int64)
    rays = mesh.points[points] - a[edges]
    steps = (b - a)[edges]
    off = np.abs(steps[:, 0] * rays[:, 1] - steps[:, 1] * rays[:, 0]) / lengths[edges]
    own = (points == pairs[edges, 0]) | (points == pairs[edges, 1])
    hanging = ~own & (off <= TOUCHING * lengths[edges])
    return edges[hanging], points[hanging]


def _check_edge_sets(mesh: PolyMesh) -> None:
    def keys(pairs: IntArray) -> IntArray:
        joined: IntArray = pairs[:, 0].astype(np.int64) * mesh.n_points + pairs[:, 1]
        return joined

    allowed = keys(mesh.boundary_edges)
    for name, pairs in mesh.edge_sets.items():
        wrong = ~np.isin(keys(pairs), allowed)
        if wrong.any():
            a, b = pairs[wrong.argmax()]
            raise InputError(
                f"edge set '{name}': ({a}, {b}) near {point_text(mesh.points[a])}",
                "edges of the boundary, with the body on the left",
                "choose among boundary_edges, or use with_edge_set, which turns them",
            )
