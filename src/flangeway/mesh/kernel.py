"""Points from which a polygon is seen whole, and the cutting of polygons that have none."""

import numpy as np
from scipy.optimize import linprog

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, cross_product, point_text
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats

GOOD_DISTANCE = 0.1  # distance from all sides, over area by diameter, with which a centroid is taken as the centre

SMALLEST_KERNEL = 1e-3
"""Radius of the kernel, over area by diameter, below which a polygon counts as one that no point sees whole."""


def visible_distances(mesh: PolyMesh, cells: IntArray, centres: Floats) -> Floats:
    """Least distance (n,) of centres (n, 2) to the left of the lines through the sides of their cells.

    Where it is positive the centre sees the whole cell.
    """
    distances = np.empty(len(cells))
    sizes = mesh.cell_sizes[cells]
    for n_vertices in np.unique(sizes):
        mine = np.flatnonzero(sizes == n_vertices)
        corners = mesh.points[mesh.batch_points(int(n_vertices), cells[mine])]
        steps = np.roll(corners, -1, axis=1) - corners
        rays = centres[mine][:, None] - corners
        distances[mine] = (cross_product(steps, rays) / np.hypot(steps[..., 0], steps[..., 1])).min(axis=1)
    return distances


def cell_centres(mesh: PolyMesh, cells: IntArray) -> tuple[Floats, Bools]:
    """Points (n, 2) well inside of cells that see them whole, and which cells have one (n,).

    The centroid if it is far enough from all sides; if not, the point of the kernel that is most distant from them.
    """
    centres = mesh.cell_centroids[cells].copy()
    widths = mesh.cell_areas[cells] / mesh.cell_diameters[cells]
    distances = visible_distances(mesh, cells, centres)
    for row in np.flatnonzero(distances < GOOD_DISTANCE * widths):
        start, end = mesh.cell_offsets[cells[row] : cells[row] + 2]
        centres[row], distances[row] = kernel_centre(mesh.points[mesh.cell_points[start:end]])
    return centres, distances > SMALLEST_KERNEL * widths


def kernel_centre(polygon: Floats) -> tuple[Floats, float]:
    """Point (2,) with the maximum distance to the left of the lines through a polygon's sides, and that distance.

    The kernel is the set of points that see the whole polygon, the intersection of the half planes to the left of its
    sides; its centre is found by linear programming. A distance of zero or less means that there is no kernel.
    """
    origin, size = polygon.mean(axis=0), float(np.ptp(polygon, axis=0).max())
    local = (polygon - origin) / size
    steps = np.roll(local, -1, axis=0) - local
    normals = np.column_stack([-steps[:, 1], steps[:, 0]]) / np.hypot(*steps.T)[:, None]
    found = linprog(
        [0.0, 0.0, -1.0],
        A_ub=np.column_stack([-normals, np.ones(len(local))]),
        b_ub=-np.sum(normals * local, axis=1),
        bounds=[(-1.0, 1.0), (-1.0, 1.0), (-2.0, 2.0)],
    )
    if not found.success:
        return origin, -size
    return origin + size * found.x[:2], size * float(found.x[2])


def star_parts(polygon: IntArray, points: Floats) -> list[IntArray]:
    """Cut a simple counter-clockwise polygon, numbers of points, along diagonals into star-shaped parts.

    An `InputError` if no diagonal is inside, as when the polygon crosses itself.
    """
    corners = points[polygon]
    steps = np.roll(corners, -1, axis=0) - corners
    area = 0.5 * float(np.sum(cross_product(corners, steps)))
    diameter = float(np.hypot(*(corners[:, None] - corners).T).max())
    if kernel_centre(corners)[1] > SMALLEST_KERNEL * area / diameter:
        return [polygon]
    first, second = _best_diagonal(corners)
    inner, outer = polygon[first : second + 1], np.concatenate([polygon[second:], polygon[: first + 1]])
    return [*star_parts(inner, points), *star_parts(outer, points)]


def _best_diagonal(corners: Floats) -> tuple[int, int]:
    """Inner diagonal from a reflex corner with the largest minimum angle at its ends."""
    n = len(corners)
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    turns = cross_product(corners - before, after - corners)
    best, widest = None, 0.0
    for i in np.flatnonzero(turns < 0.0).tolist():
        for j in range(n):
            if (j - i) % n in (0, 1, n - 1):
                continue
            angle = min(_opening(corners, i, j), _opening(corners, j, i))
            if angle > widest and _clear(corners, i, j):
                best, widest = (min(i, j), max(i, j)), angle
    if best is None:
        raise InputError(
            f"a cell near {point_text(corners.mean(axis=0))} that no diagonal divides",
            "polygons that do not cross themselves",
            "check the mesh with flangeway.mesh.check",
        )
    return best


def _opening(corners: Floats, i: int, j: int) -> float:
    """Least angle between the diagonal from i to j and the sides at i; zero if it leaves the polygon there."""
    n = len(corners)
    ray = corners[j] - corners[i]
    forward, back = corners[(i + 1) % n] - corners[i], corners[i - 1] - corners[i]

    def angle(side: Floats) -> float:
        return float(np.mod(np.arctan2(*side[::-1]) - np.arctan2(*forward[::-1]), 2.0 * np.pi))

    whole, mine = angle(back), angle(ray)
    return max(min(mine, whole - mine), 0.0)


def _clear(corners: Floats, i: int, j: int) -> bool:
    """Whether the diagonal from i to j meets no side but those at its ends."""
    n = len(corners)
    starts = np.array([k for k in range(n) if k not in (i, j, (i - 1) % n, (j - 1) % n)])
    if not len(starts):
        return True
    a, b, p, q = corners[i], corners[j], corners[starts], corners[(starts + 1) % n]
    ray = b - a
    of_p, of_q = cross_product(ray, p - a), cross_product(ray, q - a)
    of_a, of_b = cross_product(q - p, a - p), cross_product(q - p, b - p)
    return not bool(((of_p * of_q <= 0.0) & (of_a * of_b <= 0.0)).any())
