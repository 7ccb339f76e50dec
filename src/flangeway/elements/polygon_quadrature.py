"""Quadrature on simple polygons, convex or not, and on cells with curved edges."""

import numpy as np
import shapely

from flangeway.elements.batched import cross
from flangeway.elements.quadrature import edge_rule, gauss, gauss_lobatto, triangle
from flangeway.types import Floats


def polygon_quadrature(vertices: Floats, degree: int) -> tuple[Floats, Floats]:
    """Points and weights on polygons with the same number of vertices.

    A polygon that sees all of its boundary from the mean of its vertices is divided into triangles about
    that point, any other one by a Delaunay triangulation with its edges: all points are inside, all
    weights positive. Triangles about that point have one curved side where edges are curved; if one folds over, points
    between the chords and the edges are added to those of the polygon, with negative weights outside of the cell.

    Parameters
    ----------
    vertices
        Counter-clockwise vertices, shape (n_vertices, 2, n_cells), or outlines with the points inside curved edges,
        (n_vertices, order, 2, n_cells); see `flangeway.elements.curved_cells`.
    degree
        Polynomials of this degree are integrated exactly.

    Returns
    -------
    tuple of Floats
        Points (n_points, 2, n_cells) and weights (n_points, n_cells).

    """
    if vertices.ndim == 4:
        return _curved_quadrature(vertices, degree)
    if len(vertices) == 3:
        corners = vertices[None]
    else:
        middle = vertices.mean(axis=0)
        following = np.roll(vertices, -1, axis=0)
        corners = np.stack((np.broadcast_to(middle, vertices.shape), vertices, following), axis=1)
        for cell in np.flatnonzero((_doubled_areas(corners) <= 0.0).any(axis=0)):
            corners[:, :, :, cell] = _triangles(vertices[:, :, cell])
    points, weights = triangle(degree)
    barycentric = np.column_stack((1.0 - points.sum(axis=1), points))
    at = np.einsum("qc,tcie->tqie", barycentric, corners)
    weighted = weights[:, None] * _doubled_areas(corners)[:, None]
    n_cells = vertices.shape[-1]
    return at.reshape(-1, 2, n_cells), weighted.reshape(-1, n_cells)


def edge_points(outline: Floats) -> Floats:
    """Points of each edge of an outline from its start to its end, (n_vertices, order + 1, 2, n_cells)."""
    return np.concatenate((outline, np.roll(outline[:, :1], -1, axis=0)), axis=1)


def _curved_quadrature(outline: Floats, degree: int) -> tuple[Floats, Floats]:
    nodes = edge_points(outline)
    centre = outline[:, 0].mean(axis=0)
    points, weights = _between(np.broadcast_to(centre, nodes.shape), nodes, degree)
    if weights.min() > 0.0:
        return points, weights
    places = gauss_lobatto(nodes.shape[1])[0][:, None, None]
    chords = (1.0 - places) * nodes[:, :1] + places * nodes[:, -1:]
    inside, beside = polygon_quadrature(outline[:, 0], degree), _between(chords, nodes, degree)
    return np.concatenate((inside[0], beside[0])), np.concatenate((inside[1], beside[1]))


def _between(base: Floats, nodes: Floats, degree: int) -> tuple[Floats, Floats]:
    """Points and signed weights between curves on the left and on the right, both given as `edge_points`."""
    order = nodes.shape[1] - 1
    across, across_weights = gauss((degree + 3) // 2)
    weights, shapes, slopes = edge_rule(order, (order * (degree + 2) + 1) // 2)
    (start, end), (start_along, end_along) = (
        [np.einsum("qj,vjie->vqie", table, curve) for curve in (base, nodes)] for table in (shapes, slopes)
    )
    r = across[:, None, None, None, None]
    points, along, step = start + r * (end - start), start_along + r * (end_along - start_along), end - start
    areas = cross(step, along) * across_weights[:, None, None, None] * weights[:, None]
    n_cells = nodes.shape[-1]
    return points.reshape(-1, 2, n_cells), areas.reshape(-1, n_cells)


def _doubled_areas(corners: Floats) -> Floats:
    """Twice the signed areas of triangles (..., 3, 2, n_cells), shape (..., n_cells)."""
    first = corners[..., 1, :, :] - corners[..., 0, :, :]
    second = corners[..., 2, :, :] - corners[..., 0, :, :]
    return cross(first, second)


def _triangles(polygon: Floats) -> Floats:
    """Counter-clockwise triangles of a simple polygon (n, 2); those without area fill up to n: (n, 3, 2)."""
    cut = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(polygon)))
    result = np.broadcast_to(polygon[0], (len(polygon), 3, 2)).copy()
    result[: len(cut)] = shapely.get_coordinates(shapely.orient_polygons(cut)).reshape(-1, 4, 2)[:, :3]
    return result
