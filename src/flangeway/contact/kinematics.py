"""Shape functions on an edge, and the gap between a node and an edge with its derivatives.

With the closest point ``x_m(xi)``, the edge's tangent ``t = x_m,xi`` and its unit normal n, which points out of the
primary body, the gap is ``g = n . (x_s - x_m)``: open where positive (Moherdaui 2021, 3.5.1 to 3.5.6).

Where an edge is evaluated many times its points are a power series in the parameter. Vectors of the plane are complex
numbers there, x + i y: the real part of ``conj(a) b`` is the dot product of two, the imaginary part a's cross b.
"""

from dataclasses import dataclass
from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss_lobatto
from flangeway.types import Complex, Floats

Number = TypeVar("Number", np.float64, np.complex128)

ENOUGH = 1e-9
"""Change of a parameter after which another of Newton's, of the size of its square, is round-off."""


@cache
def _coefficients(order: int) -> Floats:
    """Power series of the functions, shape (power, node)."""
    nodes = gauss_lobatto(order + 1)[0]
    values: Floats = nodes[:, None] ** np.arange(order + 1)
    return np.asarray(np.linalg.inv(values), dtype=np.float64)


def shape_functions(order: int, xi: Floats, highest: int = 2) -> tuple[Floats, ...]:
    """Values and derivatives at parameters.

    Parameters
    ----------
    order
        Polynomial degree of the edge.
    xi
        Parameters along the edge, 0 at its start and 1 at its end, any shape.
    highest
        Highest derivative.

    Returns
    -------
    tuple of Floats
        ``highest + 1`` arrays of shape (*xi.shape, order + 1), nodes in the direction of the edge (Moherdaui 2021,
        3.122 and 3.131 with its middle node in the middle).

    """
    coefficients = _coefficients(order)
    results = []
    for _ in range(highest + 1):
        value = np.zeros((*xi.shape, order + 1))
        for power in coefficients[::-1]:
            value *= xi[..., None]
            value += power
        results.append(value)
        coefficients = np.arange(1.0, len(coefficients))[:, None] * coefficients[1:]
    return tuple(results)


def as_complex(vectors: Floats) -> Complex:
    """Vectors (..., 2) as complex numbers, shape (...)."""
    return np.ascontiguousarray(vectors).view(np.complex128)[..., 0]


def as_vectors(numbers: Complex) -> Floats:
    """Complex numbers (...) as vectors (..., 2)."""
    return np.stack((numbers.real, numbers.imag), axis=-1)


def edge_series(edges: Floats) -> Complex:
    """Coefficients of the powers of the parameter for points of edges (..., order + 1, 2), shape (order + 1, ...)."""
    coefficients = _coefficients(edges.shape[-2] - 1)
    return np.ascontiguousarray(np.moveaxis(as_complex(edges) @ coefficients.T, -1, 0))


def derivative(series: NDArray[Number]) -> NDArray[Number]:
    """Coefficients of the derivative by the parameter of power series (n_powers, ...), one power less."""
    powers = np.arange(1.0, len(series)).reshape(-1, *[1] * (series.ndim - 1))
    return powers * series[1:]


def horner(series: NDArray[Number], xi: Floats) -> NDArray[Number]:
    """Values of power series (n_powers, ...) at parameters, whose shape goes with that of each coefficient."""
    if len(series) == 0:
        return np.zeros(xi.shape, dtype=series.dtype)
    value = series[-1] + 0.0 * xi
    for coefficient in series[-2::-1]:
        value = value * xi + coefficient
    return value


@dataclass(frozen=True, eq=False)
class NodeEdgeGaps:
    """Gaps of n pairs of a node and an edge of some order.

    Parameters
    ----------
    parameters
        Closest points' parameters xi, shape (n,).
    gaps
        Shape (n,).
    normals
        Unit normals out of the primary side, shape (n, 2).
    gradients
        First derivatives by the positions of the node and then the edge's nodes, shape (n, 2 + order, 2).
    hessians
        Second derivatives, shape (n, 2 (2 + order), 2 (2 + order)).

    """

    parameters: Floats
    gaps: Floats
    normals: Floats
    gradients: Floats
    hessians: Floats

    def take(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> "NodeEdgeGaps":
        """Some of the pairs."""
        return NodeEdgeGaps(
            self.parameters[chosen],
            self.gaps[chosen],
            self.normals[chosen],
            self.gradients[chosen],
            self.hessians[chosen],
        )


def closest_parameters(nodes: Floats, edges: Floats) -> Floats:
    """Parameter of the point of each edge (extended beyond its ends) that is closest to a node.

    Straight edges have the closed form of Moherdaui (2021, 3.125), which is also the first guess of the Newton
    iteration for curved ones (Moherdaui 2021, 3.135).

    Parameters
    ----------
    nodes
        Shape (n, 2).
    edges
        Nodes of the edges in direction, shape (n, order + 1, 2).

    """
    series, points = edge_series(edges), as_complex(nodes)
    chord = series[1:].sum(axis=0)
    xi: Floats = (np.conj(chord) * (points - series[0])).real / (chord * np.conj(chord)).real
    slopes = derivative(series)
    bends = derivative(slopes)
    for _ in range(20 if len(series) > 2 else 0):
        apart, tangent = points - horner(series, xi), horner(slopes, xi)
        slope = (np.conj(apart) * horner(bends, xi)).real - (tangent * np.conj(tangent)).real
        change = np.clip((np.conj(apart) * tangent).real / slope, -0.5, 0.5)
        xi = xi - change
        if np.abs(change).max(initial=0.0) < ENOUGH:
            break
    return xi


def ray_parameters(series: Complex, points: Complex, tangents: Complex) -> Floats:
    """Parameters of edges where normals to tangents through points meet them.

    Parameters
    ----------
    series
        Power series of the edges, shape (order + 1, ...).
    points, tangents
        Of the secondary, of a shape that goes with the series'.

    """
    along = (np.conj(tangents) * series).real
    along[0] -= (np.conj(tangents) * points).real
    eta: Floats = -along[0] / along[1:].sum(axis=0)
    if len(along) == 2:
        return eta
    slopes = derivative(along)
    for _ in range(20):
        change = np.clip(horner(along, eta) / horner(slopes, eta), -0.5, 0.5)
        eta = eta - change
        if np.abs(change).max(initial=0.0) < ENOUGH:
            break
    return eta


def node_edge_gaps(nodes: Floats, edges: Floats) -> NodeEdgeGaps:
    """Gaps of nodes over edges whose body lies on the left of their direction.

    Parameters
    ----------
    nodes
        Current positions, shape (n, 2).
    edges
        Current positions of the edges' nodes in direction, shape (n, order + 1, 2).

    """
    order = edges.shape[1] - 1
    xi = closest_parameters(nodes, edges)
    value, first, second = shape_functions(order, xi)
    tangent = np.einsum("na,nai->ni", first, edges)
    metric = np.einsum("ni,ni->n", tangent, tangent)
    unit = tangent / np.sqrt(metric)[:, None]
    normal = np.stack((unit[:, 1], -unit[:, 0]), axis=1)
    gap = np.einsum("ni,ni->n", nodes - np.einsum("na,nai->ni", value, edges), normal)
    curvature = np.einsum("ni,na,nai->n", normal, second, edges)

    ones, zeros = np.ones((len(xi), 1)), np.zeros((len(xi), 1))
    apart = np.concatenate((ones, -value), axis=1)
    slope = np.concatenate((zeros, first), axis=1)
    gradient = apart[:, :, None] * normal[:, None, :]
    turning = slope[:, :, None] * normal[:, None, :]
    sliding = apart[:, :, None] * tangent[:, None, :] + gap[:, None, None] * turning
    sliding /= (metric - gap * curvature)[:, None, None]

    n_local = 2 * apart.shape[1]
    turn, slide = turning.reshape(-1, n_local), sliding.reshape(-1, n_local)
    rotation = turn + curvature[:, None] * slide
    hessian = (gap / metric)[:, None, None] * rotation[:, :, None] * rotation[:, None, :]
    cross = turn[:, :, None] * slide[:, None, :]
    hessian -= cross + cross.swapaxes(1, 2)
    hessian -= curvature[:, None, None] * slide[:, :, None] * slide[:, None, :]
    return NodeEdgeGaps(xi, gap, normal, gradient, hessian)
