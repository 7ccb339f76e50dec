"""Voronoi polygons in any outline, made even or graded by Lloyd's iterations."""

from collections.abc import Callable

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from flangeway.checks import as_numbers, check_integer
from flangeway.errors import InputError, short
from flangeway.geometry import Line, Outline
from flangeway.geometry.arrays import cross_product
from flangeway.mesh.connectivity import first_connected
from flangeway.mesh.curved import with_names
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Floats, floats

BYTES_A_CELL = 10_000  # measured at the peak, with the clipped cells
ONE_POINT = 1e-9  # distance over the outline's size below which two vertices are one
CHORD_ANGLE = 0.02
"""Angle in radians of an arc's chords that clip the cells: their sagitta is 5e-5 of the radius."""
ENCLOSING = 20.0
"""Distance of four points around everything, over the outline's size, that make all Voronoi cells bounded."""
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
        places, owner = shapely.get_coordinates(shapely.orient_polygons(self.cells), return_index=True)
        start = np.diff(owner, prepend=-1) != 0
        places, owner = places[~start], owner[~start]
        joints = np.array([segment.start for segment in outline.segments])
        near, joint = cKDTree(joints).query(places)
        places = np.where((near < self.tolerance)[:, None], joints[joint], places)
        number, _, distance = outline.closest(places)
        straight = np.array([isinstance(segment, Line) for segment in outline.segments])
        chords = _domain(outline).exterior
        on_arc = (distance < CHORD_ANGLE * outline.size) & ~straight[number]
        on_arc[on_arc] = shapely.distance(shapely.points(places[on_arc]), chords) < self.tolerance
        of_chords = cKDTree(shapely.get_coordinates(chords)).query(places)[0] < self.tolerance
        kept = ~(on_arc & of_chords) | (near < self.tolerance)
        places, owner, on_arc, number = (array[kept] for array in (places, owner, on_arc, number))
        for which in np.flatnonzero(~straight):
            rows = np.flatnonzero(on_arc & (number == which))
            if len(rows):
                places[rows] = outline.segments[which].point(outline.segments[which].closest(places[rows])[0])
        pairs = cKDTree(places).query_pairs(self.tolerance, output_type="ndarray")
        kept, vertices = np.unique(first_connected(pairs, len(places)), return_inverse=True)
        cells = np.split(vertices, np.cumsum(np.bincount(owner))[:-1])
        return PolyMesh.from_cells(places[kept], [list(dict.fromkeys(cell.tolist())) for cell in cells])
