"""Voronoi polygons in a convex outline, made even by Lloyd's iterations."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import QhullError, Voronoi, cKDTree

from flangeway.checks import as_numbers, check_integer
from flangeway.errors import InputError, short
from flangeway.geometry import Line, Outline
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Floats

BYTES_A_CELL = 10_000  # of the cells and their images
ONE_POINT = 1e-9  # distance over the outline's size below which two vertices are one


def voronoi(outline: Outline, cells: int | ArrayLike, *, iterations: int = 10, seed: int = 0) -> PolyMesh:
    """Return the Voronoi polygons of points in a convex outline.

    Each cell holds what is nearer to its point than to the others. Images of the points in the straight sides cut the
    cells exactly along the outline.

    Parameters
    ----------
    outline
        Convex, of straight lines; its names become edge sets.
    cells
        Number of cells, whose points are random at first, or the points (n, 2) inside the outline.
    iterations
        Lloyd's iterations: each moves the points to the centroids of their cells, which makes the cells rounder (Lloyd,
        1982, "Least squares quantization in PCM"). With 0 some edges are very short.
    seed
        Of the random points.

    Returns
    -------
    PolyMesh
        Cell i belongs to point i.

    Raises
    ------
    InputError
        If the outline is not convex or has arcs, or points lie outside or on each other.
    """
    lines = _lines(outline)
    check_integer("voronoi", "iterations", iterations, 0)
    if np.ndim(cells) == 0:
        number = check_integer("voronoi", "cells", cells, 1, advice="give the number of cells, or points (n, 2)")
        refuse_large_mesh(f"{number:,} Voronoi cells", BYTES_A_CELL * number)
        points = _random_points(outline, number, seed)
    else:
        points = as_numbers("the points of Voronoi cells", cells)
        if points.ndim != 2 or points.shape[1] != 2 or not (points @ lines[:, :2].T < lines[:, 2]).all():
            raise InputError(f"points {short(points)}", "rows of x and y inside the outline", "leave out the others")
    for _ in range(iterations):
        points = _cells(points, lines, outline).cell_centroids
    mesh = _cells(points, lines, outline)
    middles = mesh.points[mesh.boundary_edges].mean(axis=1)
    nearest = outline.closest(middles)[0]
    for name in dict.fromkeys(outline.names):
        own = [number for number, other in enumerate(outline.names) if other == name]
        mesh = mesh.with_edge_set(name, mesh.boundary_edges[np.isin(nearest, own)])
    return mesh


def _lines(outline: Outline) -> Floats:
    """Lines of the sides, each once: outward unit normal and its product with the points on the line, (n, 3)."""
    corners = np.array([segment.start for segment in outline.segments])
    along = np.roll(corners, -1, axis=0) - corners
    after = np.roll(along, -1, axis=0)
    turns = along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]
    if not all(isinstance(segment, Line) for segment in outline.segments) or turns.min() < -ONE_POINT * outline.size**2:
        raise InputError(
            "voronoi in an outline with arcs or reentrant corners",
            "a convex outline of straight lines",
            "take dual(triangulate(outline, ...)), or agglomerated cells",
        )
    normals = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
    lines = np.column_stack((normals, (normals * corners).sum(axis=1)))
    new = np.abs(np.roll(normals, 1, axis=0) - normals).max(axis=1) > ONE_POINT
    return lines[new]


def _random_points(outline: Outline, number: int, seed: int) -> Floats:
    random = np.random.default_rng(seed)
    low, high = outline.bounds()
    points = np.empty((0, 2))
    while len(points) < number:
        more = low + random.random((2 * number, 2)) * (high - low)
        points = np.vstack((points, more[outline.contains(more)]))
    return points[:number]


def _cells(points: Floats, lines: Floats, outline: Outline) -> PolyMesh:
    n, tolerance = len(points), ONE_POINT * outline.size
    if len(cKDTree(points).query_pairs(tolerance)):
        raise InputError("two points of Voronoi cells at one place", "points that differ", "remove one")
    images = [points - 2.0 * (points @ line[:2] - line[2])[:, None] * line[:2] for line in lines]
    try:
        found = Voronoi(np.vstack((points, *images)))
    except QhullError as reason:
        raise InputError(f"points without Voronoi cells: {short(reason)}", "points apart", "move them") from reason
    rows = [found.regions[region] for region in found.point_region[:n]]
    used = np.unique(np.concatenate(rows))
    vertices = found.vertices[used]
    # on a side four points lie on one circle: vertices that round-off has parted become one
    first = np.arange(len(used))
    for low, high in sorted(cKDTree(vertices).query_pairs(tolerance), reverse=True):
        first[high] = low
    kept, numbers = np.unique(first, return_inverse=True)
    vertices = vertices[kept]
    for normal_x, normal_y, offset in lines:
        normal = np.array([normal_x, normal_y])
        above = vertices @ normal - offset
        near = np.abs(above) < tolerance
        vertices[near] -= above[near, None] * normal
    corners = np.array([segment.start for segment in outline.segments])
    distances, nearest = cKDTree(vertices).query(corners)
    vertices[nearest[distances < tolerance]] = corners[distances < tolerance]
    joints = corners[distances >= tolerance]  # between sides in one line
    joint_of = cKDTree(points).query(joints)[1] if len(joints) else np.empty(0)
    n_found, vertices = len(vertices), np.vstack((vertices, joints))
    cells = []
    for cell, (row, point) in enumerate(zip(rows, points, strict=True)):
        own = np.append(np.unique(numbers[np.searchsorted(used, row)]), n_found + np.flatnonzero(joint_of == cell))
        rays = vertices[own] - point
        cells.append(own[np.argsort(np.arctan2(rays[:, 1], rays[:, 0]))].tolist())
    return PolyMesh.from_cells(vertices, cells)
