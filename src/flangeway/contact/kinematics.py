"""Shape functions on an edge, and the gap between a node and an edge with its derivatives.

With the closest point ``x_m(xi)``, the edge's tangent ``t = x_m,xi`` and its unit normal n, which points out of the
primary body, the gap is ``g = n . (x_s - x_m)``: open where positive (Moherdaui 2021, 3.5.1 to 3.5.6). Derivatives are
those of this formula, see `flangeway.contact.taylor`.

Where an edge is evaluated many times its points are a power series in the parameter. Vectors of the plane are complex
numbers there, x + i y.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.taylor import Taylor, as_complex, as_vectors, cross, dot, implicit
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.types import Bools, Complex, Floats

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


def edge_series(edges: Floats) -> list[Complex]:
    """Coefficients of the powers of the parameter for points of edges (..., order + 1, 2), each (...)."""
    coefficients = _coefficients(edges.shape[-2] - 1)
    return list(np.ascontiguousarray(np.moveaxis(as_complex(edges) @ coefficients.T, -1, 0)))


def taylor_series(points: Taylor, start: int, stop: int) -> list[Taylor]:
    """The same, each (p,), for edges whose nodes are columns from ``start`` to ``stop`` of points (p, n)."""
    weights = np.zeros((stop - start, points.value.shape[1]))
    weights[:, start:stop] = _coefficients(stop - start - 1)
    return [points.weighted(row) for row in weights]


def derivative(series: Sequence[Any]) -> list[Any]:
    """Coefficients of the derivative by the parameter of power series, one power less."""
    return [power * coefficient for power, coefficient in enumerate(series)][1:]


def horner(series: Sequence[Any], xi: Any) -> Any:
    """Values of power series at parameters, whose shape goes with that of each coefficient."""
    value = series[-1] if len(series) > 1 else 0.0 * xi + (series[0] if series else 0.0)
    for coefficient in series[-2::-1]:
        value = value * xi + coefficient
    return value


def foot(series: Sequence[Taylor], node: Taylor, parameters: Floats, moves: Bools | None = None) -> Taylor:
    """Parameters of the closest points of edges to nodes, with derivatives.

    Parameters
    ----------
    series
        The edges, see `taylor_series`.
    node
        The nodes, shape (p,).
    parameters
        Values, shape (p,), from `closest_parameters`.
    moves
        Which are feet, shape (p,); others stay as they are. Left out: all.

    """
    slopes = derivative(series)
    values = [coefficient.value for coefficient in series]
    slope = horner(derivative(values), parameters)
    bend = horner(derivative(derivative(values)), parameters)
    rate = np.abs(slope) ** 2 + (np.conj(horner(values, parameters) - node.value) * bend).real
    rate = rate if moves is None else np.where(moves, rate, np.inf)
    return implicit(lambda xi: dot(horner(series, xi) - node, horner(slopes, xi)), node.constant(parameters), rate)


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
    chord = sum(series[1:])
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


def ray_parameters(series: Sequence[Complex], points: Complex, tangents: Complex) -> Floats:
    """Parameters of edges where normals to tangents through points meet them.

    Parameters
    ----------
    series
        Power series of the edges.
    points, tangents
        Of the secondary, of a shape that goes with the series'.

    """
    along = [(np.conj(tangents) * coefficient).real for coefficient in series]
    along[0] = along[0] - (np.conj(tangents) * points).real
    eta: Floats = -along[0] / sum(along[1:])
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
    points = Taylor.of_points(np.concatenate((nodes[:, None], edges), axis=1), second=True)
    n_points = points.value.shape[1]
    node, series = points.weighted(np.eye(n_points)[0]), taylor_series(points, 1, n_points)
    xi = foot(series, node, closest_parameters(nodes, edges))
    slope = horner(derivative(series), xi)
    gap = -cross(slope, node - horner(series, xi)) / slope.abs
    normals = as_vectors(-1j * slope.value / np.abs(slope.value))
    assert gap.second is not None
    return NodeEdgeGaps(xi.value, gap.value, normals, gap.first.reshape(-1, n_points, 2), gap.second)
