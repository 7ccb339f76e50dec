"""Quadrature on the unit interval and on triangles."""

from functools import cache

import numpy as np
from scipy.special import roots_jacobi

from flangeway.types import Floats, Ints


def _read_only(*arrays: Floats) -> tuple[Floats, ...]:
    for array in arrays:
        array.setflags(write=False)
    return arrays


@cache
def gauss(n_points: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre points and weights on [0, 1], exact to degree ``2 n_points - 1``."""
    points, weights = np.polynomial.legendre.leggauss(n_points)
    points, weights = _read_only((points + 1.0) / 2.0, weights / 2.0)
    return points, weights


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
    weights = 2.0 / (n_points * (n_points - 1) * legendre**2)
    points, weights = _read_only((points + 1.0) / 2.0, weights / 2.0)
    return points, weights


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
    weights = np.outer(u_weights, v_weights).ravel()
    points, weights = _read_only(points, weights)
    return points, weights


def edge_unknowns(order: int, n_vertices: int) -> Ints:
    """Local unknowns of each edge of a cell from its start to its end, shape (n_vertices, order + 1).

    The vertices are numbered first, then the points inside each edge in turn.
    """
    vertices = np.arange(n_vertices)
    inside = n_vertices + np.arange(n_vertices * (order - 1)).reshape(n_vertices, order - 1)
    return np.column_stack((vertices, inside, np.roll(vertices, -1)))


def edge_shapes(order: int, places: Floats) -> Floats:
    """Lagrange's polynomials of the Gauss-Lobatto points at places (n,) in [0, 1], shape (n, order + 1)."""
    nodes = gauss_lobatto(order + 1)[0]
    own = np.eye(order + 1, dtype=bool)
    apart = np.where(own, 1.0, nodes[:, None] - nodes)
    factors = np.where(own, 1.0, (places[:, None, None] - nodes) / apart)
    return factors.prod(axis=2)


@cache
def edge_rule(order: int, n_points: int) -> tuple[Floats, Floats, Floats]:
    """Gauss weights (n_points,), and there `edge_shapes` and their derivatives, (n_points, order + 1) each."""
    places, weights = gauss(n_points)
    shapes, nodes = edge_shapes(order, places), gauss_lobatto(order + 1)[0]
    # derivatives at the nodes by barycentric weights (Berrut and Trefethen, 2004, eq. 9.4), interpolated
    apart = nodes[:, None] - nodes + np.eye(order + 1)
    factors = 1.0 / apart.prod(axis=1)
    derivatives = factors / factors[:, None] / apart
    np.fill_diagonal(derivatives, 0.0)
    np.fill_diagonal(derivatives, -derivatives.sum(axis=1))
    weights, shapes, slopes = _read_only(weights, shapes, shapes @ derivatives)
    return weights, shapes, slopes
