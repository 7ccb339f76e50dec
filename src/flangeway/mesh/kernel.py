"""Points from which a polygon is seen whole, and the cutting of polygons that have none."""

import numpy as np
import shapely
from scipy.optimize import linprog

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, cross_product, extent, norms, point_text, steps_around
from flangeway.mesh.cutting import best_chord, diameter
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats

GOOD_DISTANCE = 0.1  # distance from all sides, over area by diameter, with which a centroid is taken as the centre

MIN_KERNEL = 1e-3
"""Radius of the kernel, over area by diameter, below which a polygon counts as one that no point sees whole."""


def visible_distances(mesh: PolyMesh, cells: IntArray, centres: Floats) -> Floats:
    """Least distance (n,) of centres (n, 2) to the left of the lines through the sides of their cells.

    Where it is positive the centre sees the whole cell.
    """
    distances = np.empty(len(cells))
    sizes = mesh.cell_sizes[cells]
    for n_vertices in np.unique(sizes):
        rows = np.flatnonzero(sizes == n_vertices)
        corners = mesh.points[mesh.batch_points(int(n_vertices), cells[rows])]
        steps = np.roll(corners, -1, axis=1) - corners
        rays = centres[rows][:, None] - corners
        distances[rows] = (cross_product(steps, rays) / norms(steps)).min(axis=1)
    return distances


def cell_centres(mesh: PolyMesh, cells: IntArray) -> tuple[Floats, Bools]:
    """Points (n, 2) well inside of cells that see them whole, and which cells have one (n,).

    The centroid if it is far enough from all sides; if not, the point of the kernel that is most distant from them.
    """
    centres = mesh.cell_centroids[cells].copy()
    widths = mesh.cell_areas[cells] / mesh.cell_diameters[cells]
    distances = visible_distances(mesh, cells, centres)
    for row in np.flatnonzero(distances < GOOD_DISTANCE * widths):
        centres[row], distances[row] = kernel_centre(mesh.points[mesh.corners(cells[row])])
    return centres, distances > MIN_KERNEL * widths


def kernel_centre(polygon: Floats) -> tuple[Floats, float]:
    """Point (2,) with the maximum distance to the left of the lines through a polygon's sides, and that distance.

    The kernel is the set of points that see the whole polygon, the intersection of the half planes to the left of its
    sides; its centre is found by linear programming. A distance of zero or less means that there is no kernel.
    """
    origin, size = polygon.mean(axis=0), extent(polygon)
    local = (polygon - origin) / size
    steps = steps_around(local)
    normals = np.column_stack([-steps[:, 1], steps[:, 0]]) / norms(steps)[:, None]
    solution = linprog(
        [0.0, 0.0, -1.0],
        A_ub=np.column_stack([-normals, np.ones(len(local))]),
        b_ub=-np.sum(normals * local, axis=1),
        bounds=[(-1.0, 1.0), (-1.0, 1.0), (-2.0, 2.0)],
    )
    if not solution.success:
        return origin, -size
    return origin + size * solution.x[:2], size * float(solution.x[2])


def star_parts(polygon: IntArray, points: Floats) -> list[IntArray]:
    """Cut a simple counter-clockwise polygon, numbers of points, along diagonals into star-shaped parts.

    An `InputError` if no diagonal is inside, as when the polygon crosses itself.
    """
    corners = points[polygon]
    if kernel_centre(corners)[1] > MIN_KERNEL * shapely.area(shapely.Polygon(corners)) / diameter(corners):
        return [polygon]
    steps = steps_around(corners)
    chord = best_chord(corners, cross_product(np.roll(steps, 1, axis=0), steps) < 0.0)
    if chord is None:
        raise InputError(
            f"a cell near {point_text(corners.mean(axis=0))} that no diagonal divides",
            "polygons that do not cross themselves",
            "check the mesh with flangeway.mesh.check",
        )
    first, second = chord
    inner, outer = polygon[first : second + 1], np.concatenate([polygon[second:], polygon[: first + 1]])
    return [*star_parts(inner, points), *star_parts(outer, points)]
