"""Meshes of polygons: dual cells of a triangulation, cells joined, and Voronoi cells."""

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from heapq import heapify, heappop, heappush

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from flangeway.checks import as_numbers, check_integer
from flangeway.errors import InputError, short
from flangeway.geometry import Line, Outline
from flangeway.geometry.arrays import IntArray, angles_of, chords_of, cross_product, extent, point_text, sides_of
from flangeway.mesh.connectivity import first_connected, next_in_row, offsets_of, places_among, row_numbers
from flangeway.mesh.curved import Curves, curved, with_names
from flangeway.mesh.insertion import divided
from flangeway.mesh.mesh_checks import check
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Floats, Ints, floats

# --- Polygons made of several cells of a mesh, each without holes.


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
    rows, left = _joined(mesh, cells)
    kept = np.unique(np.concatenate(list(rows.values())))
    number = places_among(kept, mesh.n_points)
    whole = PolyMesh.from_cells(mesh.points[kept], [number[row].tolist() for row in rows.values()])
    for name, members in mesh.cell_sets.items():
        whole = whole.with_cell_set(name, np.isin(list(rows), members))
    for name, pairs in mesh.edge_sets.items():
        whole = whole.with_edge_set(name, number[pairs])
    if mesh.curves is not None:
        sides = mesh.curves.pairs.tolist()
        left_over = np.array([(a, b) in left or (b, a) in left for a, b in sides])
        whole = replace(whole, curves=mesh.curves.taken(left_over, number))
    return whole


def _joined(mesh: PolyMesh, n_cells: int) -> tuple[dict[int, list[int]], dict[tuple[int, int], int]]:
    """Points of each polygon in order, and the polygon on the left of each side, where so many are left."""
    start, end = mesh.cell_points, mesh.cell_points[next_in_row(mesh.cell_offsets)]
    owners = row_numbers(mesh.cell_offsets)
    left = dict(zip(zip(start.tolist(), end.tolist(), strict=True), owners.tolist(), strict=True))
    rows = dict(enumerate(row.tolist() for row in np.split(mesh.cell_points, mesh.cell_offsets[1:-1])))
    areas = dict(enumerate(mesh.cell_areas.tolist()))
    signs = np.zeros((mesh.n_cells, len(mesh.cell_sets) + 1), dtype=bool)
    for column, members in enumerate(mesh.cell_sets.values()):
        signs[members, column] = True
    kind = np.unique(signs, axis=0, return_inverse=True)[1].ravel()

    def neighbours(cell: int) -> set[int]:
        """Polygons of the same sets on the other side of a polygon's sides."""
        across = {left.get((end, start)) for start, end in sides_of(rows[cell])}
        return {other for other in across if other is not None and kind[other] == kind[cell]} - {cell}

    def options(cell: int) -> Iterator[tuple[float, int, list[int]]]:
        """Perimeter squared by area of the unions with neighbours, these, and the points of the unions."""
        for other in neighbours(cell):
            shared = [left.get((b, a)) == other for a, b in sides_of(rows[cell])]
            row = _united(rows[cell], rows[other], shared)
            if row is not None:
                perimeter = shapely.length(shapely.linearrings(mesh.points[row]))
                yield perimeter**2 / (areas[cell] + areas[other]), other, row

    heap = [(area, cell) for cell, area in areas.items()]
    heapify(heap)
    while len(rows) > n_cells and heap:
        area, cell = heappop(heap)
        if areas.get(cell) != area or (roundest := min(options(cell), default=None)) is None:
            continue
        _, other, row = roundest
        for former in (rows.pop(cell), rows[other]):
            for side in sides_of(former):
                del left[side]
        rows[other] = row
        left |= dict.fromkeys(sides_of(row), other)
        areas[other] += areas.pop(cell)
        # a smaller neighbour may have had none to join, and has now
        for changed in (other, *neighbours(other)):
            heappush(heap, (areas[changed], changed))
    return rows, left


def _united(row: list[int], other_row: list[int], shared: list[bool]) -> list[int] | None:
    """Points of two polygons in order, by the sides of the first that they share; None if these are not one piece."""
    starts = [index for index in range(len(row)) if shared[index] and not shared[index - 1]]
    if len(starts) != 1 or len(set(row) & set(other_row)) != sum(shared) + 1:
        return None
    row = row[starts[0] :] + row[: starts[0]]
    first, last = row[0], row[sum(shared)]
    row = row[sum(shared) :]  # from the last shared point to the point before the first
    index = other_row.index(first)
    other_row = other_row[index:] + other_row[:index]
    return [*row, *other_row[: other_row.index(last)]]


# --- Dual polygons of a triangulation, one cell about every point, and those of a section of several parts.


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
    entries = np.arange(len(ring_points)) + np.repeat(offsets[:-1] + 2 * on_rim - rings[:-1], counts)
    cell_points[entries] = ring_points
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
    edges = chords_of(mesh.points[rim])
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


# --- Voronoi polygons in any outline, made even or graded by Lloyd's iterations.


BYTES_A_CELL = 10_000  # measured at the peak, with the clipped cells
ONE_POINT = 1e-9  # distance relative to the outline's size below which two vertices are one
CHORD_ANGLE = 0.02
"""Angle in radians of an arc's chords that clip the cells: their sagitta is 5e-5 of the radius."""
ENCLOSING = 20.0
"""Distance of four points around everything, relative to the outline's size, that make all Voronoi cells bounded."""
MAX_PIECES = 20
"""Rounds in which pieces of cells that the outline cuts in two get points of their own."""

Size = Callable[[Floats], ArrayLike]


def voronoi(
    outline: Outline, cells: int | ArrayLike, *, iterations: int = 10, seed: int = 0, size: Size | None = None
) -> PolyMesh:
    """Return the Voronoi polygons of points in an outline.

    Each cell holds what is nearer to its point than to the others, clipped along the outline, which may have reentrant
    corners and arcs. On an arc vertices lie on it and edges are chords; `flangeway.mesh.curved` bends them. Where the
    outline cuts a cell in two, each further piece gets a point of its own.

    Parameters
    ----------
    outline
        Any outline; its names become edge sets.
    cells
        Number of cells, whose points are random at first, or the points (n, 2) inside the outline.
    iterations
        Lloyd's iterations: each moves the points to the centroids of their cells, which makes the cells rounder (Lloyd,
        1982, "Least squares quantization in PCM"). With 0 some edges are very short.
    seed
        Of the random points.
    size
        Function of points (n, 2) that gives positive sizes (n,), of which the ratios count: cells are graded like them.
        Centroids are taken with the density ``size^-4``, with which Lloyd's cells get this size (Du, Faber and
        Gunzburger, 1999, "Centroidal Voronoi tessellations", section 6).

    Returns
    -------
    PolyMesh
        Cell i belongs to point i; cells of pieces follow.

    Raises
    ------
    InputError
        If points lie outside or on each other, or a size is not positive.
    """
    domain = _domain(outline)
    check_integer("voronoi", "iterations", iterations, 0)
    if np.ndim(cells) == 0:
        number = check_integer("voronoi", "cells", cells, 1, advice="give the number of cells, or points (n, 2)")
        refuse_large_mesh(f"{number:,} Voronoi cells", BYTES_A_CELL * number)
        points = _random_points(outline, domain, number, seed, size)
    else:
        points = as_numbers("the points of Voronoi cells", cells)
        if points.ndim != 2 or points.shape[1] != 2 or not shapely.contains_xy(domain, points).all():
            raise InputError(f"points {short(points)}", "rows of x and y inside the outline", "leave out the others")
    for _ in range(iterations):
        points = _Cells(points, domain, outline).centroids(size)
    for _ in range(MAX_PIECES):
        clipped = _Cells(points, domain, outline)
        if not len(clipped.further):
            break
        points = np.vstack((points, clipped.further))
    return with_names(clipped.mesh(outline), [outline])


def _domain(outline: Outline) -> shapely.Polygon:
    """The region as a polygon, with chords in the place of arcs."""
    corners = []
    for segment in outline.segments:
        n = 1 if isinstance(segment, Line) else int(np.ceil(abs(segment.length * segment.curvature) / CHORD_ANGLE))
        corners.append(segment.point(np.arange(n) / n))
    polygon = shapely.Polygon(np.concatenate(corners))
    shapely.prepare(polygon)
    return polygon


def _sizes(size: Size | None, points: Floats) -> Floats:
    if size is None:
        return np.ones(len(points))
    values = floats(size(points))
    if values.shape != (len(points),) or not (np.isfinite(values) & (values > 0.0)).all():
        raise InputError(
            f"sizes of shape {values.shape} for {len(points)} points, or one that is not positive",
            "a positive number for each point",
            "write the function for points of shape (n, 2)",
        )
    return values


def _random_points(outline: Outline, domain: shapely.Polygon, number: int, seed: int, size: Size | None) -> Floats:
    """Random points inside, with the density ``size^-2``, by rejection."""
    random = np.random.default_rng(seed)
    low, high = outline.bounds()
    points, smallest = np.empty((0, 2)), np.inf
    while len(points) < number:
        more = low + random.random((2 * number, 2)) * (high - low)
        more = more[shapely.contains_xy(domain, more)]
        if size is not None:
            sizes = _sizes(size, more)
            smallest = min(smallest, float(sizes.min(initial=np.inf)))
            more = more[random.random(len(more)) < (smallest / sizes) ** 2]
        points = np.vstack((points, more))
    return points[:number]


class _Cells:
    """Voronoi cells of points, clipped along the outline: polygons, and points in the pieces without a point."""

    def __init__(self, points: Floats, domain: shapely.Polygon, outline: Outline) -> None:
        self.points, self.tolerance = points, ONE_POINT * outline.size
        if len(cKDTree(points).query_pairs(self.tolerance)):
            raise InputError("two points of Voronoi cells at one place", "points that differ", "remove one")
        corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        around = outline.bounds().mean(axis=0) + ENCLOSING * outline.size * corners
        cells = shapely.voronoi_polygons(shapely.linestrings(np.vstack((points, around))), ordered=True)
        self.cells = shapely.get_parts(cells)[: len(points)]
        self.cut = np.flatnonzero(~shapely.contains_properly(domain, self.cells))
        pieces, owner = shapely.get_parts(shapely.intersection(self.cells[self.cut], domain), return_index=True)
        large = shapely.area(pieces) > self.tolerance**2
        pieces, owner = pieces[large], owner[large]
        # the piece that holds the cell's point stays, others want a point of their own
        away = shapely.distance(pieces, shapely.points(points[self.cut[owner]]))
        order = np.lexsort((-shapely.area(pieces), away, owner))
        first = np.diff(owner[order], prepend=-1) != 0
        self.cells[self.cut] = pieces[order[first]]
        self.further = shapely.get_coordinates(shapely.point_on_surface(pieces[order[~first]]))

    def centroids(self, size: Size | None) -> Floats:
        """Centroids (n, 2) of the cells, with the density ``size^-4``; points inside where a centroid is outside."""
        ring, owner = shapely.get_coordinates(self.cells, return_index=True)
        sides = np.flatnonzero(owner[1:] == owner[:-1])  # rings end with their first point
        owner = owner[sides]
        # signed triangles from the cell's point to its sides: exact for constants, also where it does not see them
        base = self.points[owner]
        a, b = ring[sides] - base, ring[sides + 1] - base
        middles = base + (a + b) / 3.0
        weights = 0.5 * cross_product(a, b) * (1.0 if size is None else _sizes(size, middles) ** -4.0)
        sums = np.stack([np.bincount(owner, weights * part) for part in (1.0, *middles.T)])
        result = (sums[1:] / sums[0]).T
        lost = self.cut[~shapely.contains_xy(self.cells[self.cut], *result[self.cut].T)]
        result[lost] = shapely.get_coordinates(shapely.point_on_surface(self.cells[lost]))
        return result

    def mesh(self, outline: Outline) -> PolyMesh:
        """The cells with common vertices; chords of an arc inside a cell become one."""
        points, owner = shapely.get_coordinates(shapely.orient_polygons(self.cells), return_index=True)
        start = np.diff(owner, prepend=-1) != 0
        points, owner = points[~start], owner[~start]
        joints = np.array([segment.start for segment in outline.segments])
        near, joint = cKDTree(joints).query(points)
        points = np.where((near < self.tolerance)[:, None], joints[joint], points)
        number, _, distance = outline.closest(points)
        straight = np.array([isinstance(segment, Line) for segment in outline.segments])
        chords = _domain(outline).exterior
        on_arc = (distance < CHORD_ANGLE * outline.size) & ~straight[number]
        on_arc[on_arc] = shapely.distance(shapely.points(points[on_arc]), chords) < self.tolerance
        of_chords = cKDTree(shapely.get_coordinates(chords)).query(points)[0] < self.tolerance
        kept = ~(on_arc & of_chords) | (near < self.tolerance)
        points, owner, on_arc, number = (array[kept] for array in (points, owner, on_arc, number))
        for which in np.flatnonzero(~straight):
            rows = np.flatnonzero(on_arc & (number == which))
            if len(rows):
                points[rows] = outline.segments[which].point(outline.segments[which].closest(points[rows])[0])
        pairs = cKDTree(points).query_pairs(self.tolerance, output_type="ndarray")
        kept, vertices = np.unique(first_connected(pairs, len(points)), return_inverse=True)
        cells = np.split(vertices, np.cumsum(np.bincount(owner))[:-1])
        return PolyMesh.from_cells(points[kept], [list(dict.fromkeys(cell.tolist())) for cell in cells])
