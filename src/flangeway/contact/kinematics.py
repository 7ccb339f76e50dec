"""Shape functions on an edge, and the gap between a node and an edge with its derivatives.

With the closest point ``x_m(xi)``, the edge's tangent ``t = x_m,xi`` and its unit normal n, which points out of the
primary body, the gap is ``g = n . (x_s - x_m)``: open where positive (Moherdaui 2021, 3.5.1 to 3.5.6). Derivatives are
those of this formula, see `flangeway.contact.taylor`.

Where an edge is evaluated many times its points are a power series in the parameter. Vectors of the plane are complex
numbers there, x + i y.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.taylor import Taylor, as_complex, as_vectors, cross, dot, implicit
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.types import Bools, Complex, Floats

MAX_STEPS = 20
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
    if len(series) == 2:
        return xi
    slopes = derivative(series)
    bends = derivative(slopes)

    def change(xi: Floats) -> Floats:
        apart, tangent = points - horner(series, xi), horner(slopes, xi)
        slope = (np.conj(apart) * horner(bends, xi)).real - np.abs(tangent) ** 2
        return np.asarray((np.conj(apart) * tangent).real / slope)

    return _newton(change, xi)


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
    return _newton(lambda eta: np.asarray(horner(along, eta) / horner(slopes, eta)), eta)


def _newton(change: Callable[[Floats], Floats], parameters: Floats) -> Floats:
    """Parameters after Newton's method, by what is to be taken from them, at most half an edge at a time."""
    for _ in range(MAX_STEPS):
        step = np.clip(change(parameters), -0.5, 0.5)
        parameters = parameters - step
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
    return parameters


def gaps_over(points: Taylor, parameters: Floats) -> tuple[Taylor, Taylor, Taylor]:
    """Feet of nodes on edges, the gaps, and the lengths of the edges' tangents there, each (p,).

    Points are a node and then the nodes of the edge that it faces, shape (p, order + 2); parameters those of the feet.
    """
    n_points = points.value.shape[1]
    series = taylor_series(points, 1, n_points)
    node = points.weighted(np.eye(n_points)[0])
    xi = foot(series, node, parameters)
    slope = horner(derivative(series), xi)
    length = slope.abs
    return xi, -cross(slope, node - horner(series, xi)) / length, length


@dataclass(frozen=True, eq=False)
class NodeEdgeGaps:
    """Gaps of n pairs of a node and an edge of some order.

    Parameters
    ----------
    nodes, edges
        Positions, shapes (n, 2) and (n, order + 1, 2).
    parameters
        Closest points' parameters xi, shape (n,).

    """

    nodes: Floats
    edges: Floats
    parameters: Floats

    @cached_property
    def normals(self) -> Floats:
        """Unit normals out of the primary side, shape (n, 2)."""
        slope = horner(derivative(edge_series(self.edges)), self.parameters)
        return as_vectors(-1j * slope / np.abs(slope))

    @cached_property
    def gaps(self) -> Floats:
        """The gaps, shape (n,)."""
        apart = as_complex(self.nodes) - horner(edge_series(self.edges), self.parameters)
        return (np.conj(as_complex(self.normals)) * apart).real

    @cached_property
    def _gaps(self) -> Taylor:
        points = np.concatenate((self.nodes[:, None], self.edges), axis=1)
        return gaps_over(Taylor.of_points(points, second=True), self.parameters)[1]

    @property
    def gradients(self) -> Floats:
        """First derivatives by the positions of the node and then the edge's nodes, shape (n, 2 + order, 2)."""
        return self._gaps.first.T.reshape(len(self.nodes), -1, 2)

    @property
    def hessians(self) -> Floats:
        """Second derivatives, shape (n, 2 (2 + order), 2 (2 + order))."""
        assert self._gaps.second is not None
        return np.moveaxis(self._gaps.second, -1, 0)

    def take(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> "NodeEdgeGaps":
        """Some of the pairs."""
        return NodeEdgeGaps(self.nodes[chosen], self.edges[chosen], self.parameters[chosen])


def node_edge_gaps(nodes: Floats, edges: Floats) -> NodeEdgeGaps:
    """Gaps of nodes over edges whose body lies on the left of their direction.

    Parameters
    ----------
    nodes
        Current positions, shape (n, 2).
    edges
        Current positions of the edges' nodes in direction, shape (n, order + 1, 2).

    """
    return NodeEdgeGaps(nodes, edges, closest_parameters(nodes, edges))
