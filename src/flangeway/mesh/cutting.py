"""Cutting of polygons of any shape along chords, and the points from which a polygon is seen whole."""

import numpy as np
import shapely
from scipy.optimize import linprog

from flangeway.errors import InputError
from flangeway.geometry.arrays import (
    IntArray,
    angles_of,
    chain_lengths,
    cross_product,
    extent,
    norms,
    point_text,
    sides_of,
    steps_around,
    vectors_at,
)
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats

# --- Cutting of polygons of any shape along chords, until their diameters are halved and their notches are gone.


HALVED_DIAMETER = 0.55
"""Diameter of a part, relative to that of the whole polygon, that counts as half of it."""
NOTCH_REACH = 0.25
"""Length of the boundary beside a corner, relative to the diameter, whose chords make the angle of a notch."""
NOTCH_ANGLE = np.deg2rad(210.0)
"""Interior angle of these chords above which a corner is a notch: smaller ones are ragged boundaries."""
MIN_PART = 0.25
"""Diameter of a part relative to the whole below which it is not cut further."""
GOOD_ANGLE = np.deg2rad(40.0)
"""Angle between a chord and the boundary below which the chord counts as worse."""
MIN_AREA = 0.02
"""Area of the smaller part relative to the polygon below which a chord is not taken."""


def cut_polygon(corners: Floats, divisible: Bools) -> tuple[list[list[int]], Floats]:
    """Cut a simple counter-clockwise polygon into parts of about half its diameter, without notches.

    Every cut is the chord between two corners or middles of edges that leaves the rounder parts: area over squared
    diameter of the worse one, times the balance of areas and the angles with the boundary. At notches it begins there.

    Parameters
    ----------
    corners
        Shape (n, 2).
    divisible
        Edges, from each corner to the next one, whose middle may be an end of a chord, (n,).

    Returns
    -------
    tuple
        Parts as numbers of points in order, and all points: n corners, n middles of edges, then middles of chords.

    """
    points = np.vstack((corners, 0.5 * (corners + np.roll(corners, -1, axis=0))))
    n, whole = len(corners), diameter(corners)
    # middle of each edge (a, b), a < b, that may be divided
    middles = {tuple(sorted((i, (i + 1) % n))): n + i for i in np.flatnonzero(divisible).tolist()}
    middles = {edge: middle for edge, middle in middles.items() if _length(points, edge) > MIN_PART * whole}
    chords: dict[tuple[int, ...], int] = {}
    used: set[int] = set()
    open_parts, parts = [list(range(n))], []
    while open_parts:
        ring = open_parts.pop()
        size, notches = diameter(points[ring]), _notches(points[ring])
        if size <= MIN_PART * whole or (size <= HALVED_DIAMETER * whole and not notches.any()):
            parts.append(ring)
            continue
        candidates: list[int] = []
        for a, b in sides_of(ring):
            middle = middles.get((min(a, b), max(a, b)))
            candidates += [a] if middle is None else [a, middle]
        at_notch = np.isin(candidates, np.array(ring)[notches])
        chord = best_chord(points[candidates], at_notch)
        if chord is None:
            parts.append(ring)
            continue
        first, last = chord
        kept = set(ring) | {candidates[first], candidates[last]}
        used |= {candidates[first], candidates[last]}
        for piece in (candidates[first : last + 1], candidates[last:] + candidates[: first + 1]):
            open_parts.append([point for point in piece if point in kept])  # noqa: PERF401 (a list for each part)
        edge = tuple(sorted((candidates[first], candidates[last])))
        if _length(points, edge) > MIN_PART * whole:
            middles[edge] = chords[edge] = len(points)
            points = np.vstack((points, points[list(edge)].mean(axis=0)))
    # a chord whose middle one of its parts has used has it in both
    for part in parts:
        for a, b in list(sides_of(part)):
            middle = chords.get((min(a, b), max(a, b)))
            if middle in used:
                part.insert(part.index(a) + 1, middle)
    return parts, points


def _length(points: Floats, edge: tuple[int, ...]) -> float:
    return float(norms(points[edge[0]] - points[edge[1]]))


def diameter(corners: Floats) -> float:
    """Maximum distance of two corners (n, 2)."""
    return float(norms(corners[:, None] - corners).max())


def has_notch(corners: Floats) -> bool:
    """Whether a polygon has a corner that must be cut."""
    return bool(_notches(corners).any())


def _notches(corners: Floats) -> Bools:
    """Corners with an interior angle that is reflex also at the scale of the polygon, (n,)."""
    steps = steps_around(corners)
    reflex = cross_product(np.roll(steps, 1, axis=0), steps) < 0.0
    result = np.zeros(len(corners), dtype=bool)
    if not reflex.any():
        return result
    closed, reach = np.vstack((corners, corners[:1])), NOTCH_REACH * diameter(corners)
    along = chain_lengths(closed)
    for i in np.flatnonzero(reflex):
        sides = []
        for shift in (reach, -reach):
            at = (along[i] + shift) % along[-1]
            sides.append(vectors_at(at, along, closed) - corners[i])
        result[i] = _angle(*sides) > NOTCH_ANGLE
    return result


def _angle(forward: Floats, back: Floats) -> Floats:
    """Counter-clockwise angle from one direction to another, 0 to 2 pi."""
    turn = angles_of(back) - angles_of(forward)
    return np.mod(turn, 2.0 * np.pi)


def best_chord(x: Floats, at_notch: Bools) -> tuple[int, int] | None:
    """The chord (i, j), i < j, inside a polygon with the highest score; None if there is none."""
    n = len(x)
    i, j = np.triu_indices(n, 2)
    terms = cross_product(x, np.roll(x, -1, axis=0))
    sums = np.concatenate(([0.0], np.cumsum(terms)))
    area = 0.5 * sums[-1]
    first = 0.5 * (sums[j] - sums[i] + cross_product(x[j], x[i]))
    small = np.minimum(first, area - first)
    forward, back = steps_around(x), np.roll(x, 1, axis=0) - x
    total, opening = _angle(forward, back), np.full(len(i), np.inf)
    cuts_notch = np.zeros(len(i), dtype=bool)
    for start, end in ((i, j), (j, i)):
        part = _angle(forward[start], x[end] - x[start])
        opening = np.minimum(opening, np.minimum(part, total[start] - part))
        widest = np.maximum(part, total[start] - part)
        cuts_notch |= at_notch[start] & (widest < NOTCH_ANGLE - 0.2)
    diameters = _part_diameters(x)
    round_first = first / diameters[i, j - i] ** 2
    round_second = (area - first) / diameters[j, n - (j - i)] ** 2
    score = np.minimum(round_first, round_second) * np.sqrt(np.maximum(small, 0.0) / area)
    score = score * np.clip(opening / GOOD_ANGLE, 0.0, 1.0)
    score[small <= MIN_AREA * area] = 0.0
    score = np.where(cuts_notch, score + 1.0, score) * (score > 0.0)
    ring = shapely.linearrings(x)
    shapely.prepare(ring)
    for pair in np.argsort(-score, kind="stable"):
        if score[pair] <= 0.0:
            break
        ends = int(i[pair]), int(j[pair])
        # the inside of the chord meets no point of the boundary
        if shapely.relate_pattern(shapely.linestrings(x[list(ends)]), ring, "F********"):
            return ends
    return None


def _part_diameters(x: Floats) -> Floats:
    """Diameters (n, n) of the points i to i + l, cyclically: that of the longest of both shorter runs, or its ends."""
    n = len(x)
    distances = norms(x[:, None] - x)
    every, result = np.arange(n), np.zeros((n, n))
    for length in range(1, n):
        shorter = result[:, length - 1]
        ends = distances[every, (every + length) % n]
        result[:, length] = np.maximum(np.maximum(shorter, np.roll(shorter, -1)), ends)
    return result


# --- Points from which a polygon is seen whole, and the cutting of polygons that have none.


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
