"""Quadrature on the unit interval, on triangles, on simple polygons and on cells with curved edges."""

from functools import cache

import numpy as np
import shapely
from scipy.special import roots_jacobi

from flangeway.elements.batched import cross
from flangeway.geometry.arrays import frozen
from flangeway.types import Floats, Ints

# --- Quadrature on the unit interval and on triangles.


def _from_zero_to_one(points: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Read-only points and weights of a rule on [-1, 1], taken to [0, 1]."""
    return frozen((points + 1.0) / 2.0), frozen(weights / 2.0)


@cache
def gauss(n_points: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre points and weights on [0, 1], exact to degree ``2 n_points - 1``."""
    return _from_zero_to_one(*np.polynomial.legendre.leggauss(n_points))


@cache
def gauss_lobatto(n_points: int) -> tuple[Floats, Floats]:
    """Gauss-Lobatto points and weights on [0, 1], both ends included.

    Exact to degree ``2 n_points - 3``. The inner points are the zeros of the derivative of
    Legendre's polynomial, which are those of Jacobi's polynomial with both parameters one.
    """
    if n_points < 2:
        raise ValueError(f"Gauss-Lobatto quadrature has at least 2 points, not {n_points}")
    inner = roots_jacobi(n_points - 2, 1.0, 1.0)[0] if n_points > 2 else np.empty(0)
    points = np.concatenate(([-1.0], inner, [1.0]))
    legendre = np.polynomial.legendre.Legendre.basis(n_points - 1)(points)
    return _from_zero_to_one(points, 2.0 / (n_points * (n_points - 1) * legendre**2))


@cache
def triangle(degree: int) -> tuple[Floats, Floats]:
    """Points and weights on the triangle (0,0) (1,0) (0,1), exact to a degree.

    A tensor rule of Gauss and Gauss-Jacobi points (Stroud, 1971, conical product).

    Returns
    -------
    tuple of Floats
        Points (n_points, 2) and weights (n_points,) that sum to 1/2.

    """
    n_points = degree // 2 + 1
    u, u_weights = gauss(n_points)
    v, v_weights = roots_jacobi(n_points, 1.0, 0.0)
    v, v_weights = (v + 1.0) / 2.0, v_weights / 4.0
    points = np.stack((np.outer(u, 1.0 - v).ravel(), np.broadcast_to(v, (n_points, n_points)).ravel()), axis=1)
    return frozen(points), frozen(np.outer(u_weights, v_weights).ravel())


def edge_unknowns(order: int, n_vertices: int) -> Ints:
    """Local unknowns of each edge of a cell from its start to its end, shape (n_vertices, order + 1).

    The vertices are numbered first, then the points inside each edge in turn.
    """
    vertices = np.arange(n_vertices)
    inside = n_vertices + np.arange(n_vertices * (order - 1)).reshape(n_vertices, order - 1)
    return np.column_stack((vertices, inside, np.roll(vertices, -1)))


def edge_shapes(order: int, parameters: Floats) -> Floats:
    """Lagrange's polynomials of the Gauss-Lobatto points at places (n,) in [0, 1], shape (n, order + 1)."""
    nodes = gauss_lobatto(order + 1)[0]
    diagonal = np.eye(order + 1, dtype=bool)
    apart = np.where(diagonal, 1.0, nodes[:, None] - nodes)
    factors = np.where(diagonal, 1.0, (parameters[:, None, None] - nodes) / apart)
    return factors.prod(axis=2)


@cache
def edge_rule(order: int, n_points: int) -> tuple[Floats, Floats, Floats]:
    """Gauss weights (n_points,), and there `edge_shapes` and their derivatives, (n_points, order + 1) each."""
    abscissae, weights = gauss(n_points)
    shapes, nodes = edge_shapes(order, abscissae), gauss_lobatto(order + 1)[0]
    # derivatives at the nodes by barycentric weights (Berrut and Trefethen, 2004, eq. 9.4), interpolated
    apart = nodes[:, None] - nodes + np.eye(order + 1)
    factors = 1.0 / apart.prod(axis=1)
    derivatives = factors / factors[:, None] / apart
    np.fill_diagonal(derivatives, 0.0)
    np.fill_diagonal(derivatives, -derivatives.sum(axis=1))
    return weights, frozen(shapes), frozen(shapes @ derivatives)


# --- Quadrature on simple polygons, convex or not, and on cells with curved edges.


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
        (n_vertices, order, 2, n_cells); see `flangeway.elements.projection`.
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
    return _by_cells(at, weighted)


def _by_cells(points: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Points (..., 2, n_cells) and weights (..., n_cells) one after the other, (n, 2, n_cells) and (n, n_cells)."""
    return points.reshape(-1, *points.shape[-2:]), weights.reshape(-1, weights.shape[-1])


def edge_points(outline: Floats) -> Floats:
    """Points of each edge of an outline from its start to its end, (n_vertices, order + 1, 2, n_cells)."""
    return np.concatenate((outline, np.roll(outline[:, :1], -1, axis=0)), axis=1)


def _curved_quadrature(outline: Floats, degree: int) -> tuple[Floats, Floats]:
    nodes = edge_points(outline)
    centre = outline[:, 0].mean(axis=0)
    points, weights = _between(np.broadcast_to(centre, nodes.shape), nodes, degree)
    if weights.min() > 0.0:
        return points, weights
    abscissae = gauss_lobatto(nodes.shape[1])[0][:, None, None]
    chords = (1.0 - abscissae) * nodes[:, :1] + abscissae * nodes[:, -1:]
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
    return _by_cells(points, areas)


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
