"""Gap and slip between a node and an edge with their derivatives, by truncated Taylor series."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss_lobatto
from flangeway.geometry.arrays import root_parameters
from flangeway.types import Bools, Complex, Floats, Ints

# --- Arrays with their derivatives: truncated Taylor series, by which the gaps' formulas are written once.
#
# Operations on values carry the first and second derivatives along by the rules of sums, products and chains (forward
# automatic differentiation; A. Griewank and A. Walther, 2008, "Evaluating Derivatives"; for contact J. Korelc and P.
# Wriggers, 2016, "Automation of Finite Element Methods"). Vectors of the plane are complex numbers x + i y: the real
# part of ``conj(a) b`` is the dot product of two, the imaginary part a's cross b. Variables are always real.


Array = NDArray[Any]
Factor = Union["Taylor", Array, complex]


@dataclass(frozen=True, eq=False)
class Taylor:
    """Real or complex functions of d variables, about one point of these.

    Parameters
    ----------
    value
        Values, shape (...).
    first
        First derivatives, shape (d, ...), or one that is broadcast to it: NumPy's loops are then over many values.
    second
        Second derivatives, shape (d, d, ...), or one that is broadcast to it; None where they are not wanted.

    """

    value: Array
    first: Array
    second: Array | None = None

    __array_ufunc__ = None  # an array on the left leaves the operation to this class

    @classmethod
    def of_points(cls, points: Floats, *, second: bool, slots: Ints | None = None) -> "Taylor":
        """Complex positions of points (p, n, 2) whose d = 2 n components, point by point, are the variables: (p, n).

        With ``slots`` only those points, in each row others, shape (p, k).
        """
        n = points.shape[1]
        value, first = as_complex(points), np.kron(np.eye(n), [[1.0], [1.0j]])
        if slots is not None:
            value = np.take_along_axis(value, slots, axis=1)
        first = first[:, None] if slots is None else first[:, slots]
        return cls(value, first, np.zeros((1, 1, 1, 1)) if second else None)

    def constant(self, value: Array) -> "Taylor":
        """Constants as functions of the same variables, derivatives of the same order."""
        ones = (1,) * value.ndim
        return Taylor(value, np.zeros((1, *ones)), None if self.second is None else np.zeros((1, 1, *ones)))

    def weighted(self, weights: Floats) -> "Taylor":
        """Sums (p,) of points (p, n) times weights (n,)."""
        return (self * weights).sum()

    def _each(self, function: Callable[[Array], Array]) -> "Taylor":
        """A function that is linear over the reals, of values and derivatives."""
        return Taylor(
            function(self.value), function(self.first), None if self.second is None else function(self.second)
        )

    def __getitem__(self, index: Any) -> "Taylor":
        """Some of the functions, by all axes, along which derivatives are not broadcast."""
        return self._each(lambda array: np.asarray(array[..., *index]))

    @property
    def real(self) -> "Taylor":
        """Real parts."""
        return self._each(np.real)

    @property
    def conj(self) -> "Taylor":
        """Complex conjugates."""
        return self._each(np.conj)

    def __neg__(self) -> "Taylor":
        """Return the negative."""
        return self._each(np.negative)

    def __add__(self, other: Factor) -> "Taylor":
        """Return the sum with functions or with constants."""
        if not isinstance(other, Taylor):
            return Taylor(self.value + other, self.first, self.second)
        second = None if self.second is None or other.second is None else self.second + other.second
        return Taylor(self.value + other.value, self.first + other.first, second)

    def __rsub__(self, other: Factor) -> "Taylor":
        """Return the difference from constants."""
        return -self + other

    def __sub__(self, other: Factor) -> "Taylor":
        """Return the difference."""
        return self + (-other)

    def __mul__(self, other: Factor) -> "Taylor":
        """Return the product."""
        if not isinstance(other, Taylor):
            second = None if self.second is None else other * self.second
            return Taylor(other * self.value, other * self.first, second)
        one, two = self.value, other.value
        first, second = one * other.first + two * self.first, None
        if self.second is not None and other.second is not None:
            both = _outer(self.first, other.first)
            second = one * other.second + two * self.second + both + both.swapaxes(0, 1)
        return Taylor(one * two, first, second)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Factor) -> "Taylor":
        """Return the quotient."""
        if not isinstance(other, Taylor):
            return self * (1.0 / np.asarray(other))
        inverse = 1.0 / other.value
        return self * other.chained(inverse, -(inverse**2), 2.0 * inverse**3)

    @property
    def abs(self) -> "Taylor":
        """Lengths of vectors, none of which is zero."""
        length = np.abs(self.value)
        return dot(self, self).chained(length, 0.5 / length, -0.25 / length**3)

    def chained(self, value: Array, first: Array, second: Array | None = None) -> "Taylor":
        """A function of these, by its value and its derivatives by them; the second one where it is wanted."""
        seconds = None
        if self.second is not None and second is not None:
            seconds = first * self.second + second * _outer(self.first, self.first)
        return Taylor(value, first * self.first, seconds)

    def sum(self, axis: int = -1) -> "Taylor":
        """Sums along an axis of the values, counted from the last; it is not broadcast in the derivatives."""
        return self._each(lambda array: array.sum(axis=axis))


def dot(one: Taylor, other: Taylor) -> Taylor:
    """Dot products of vectors."""
    return (one.conj * other).real


def cross(one: Taylor, other: Taylor) -> Taylor:
    """Cross products of vectors: positive where the other one is to the left."""
    return (one.conj * other * -1.0j).real


def implicit(function: Callable[[Taylor], Taylor], root: Taylor, slope: Floats) -> Taylor:
    """Root of a function, with derivatives, from its value.

    Each step of Newton's method from the value makes the next derivatives right.

    Parameters
    ----------
    function
        The function of the unknown.
    root
        Its root, a constant.
    slope
        Derivative by the unknown there; infinite where the root is to stay a constant.

    """
    for _ in range(1 if root.second is None else 2):
        root = root - function(root) / slope
    return root


def _outer(one: Array, other: Array) -> Array:
    return one[:, None] * other


def as_complex(vectors: Floats) -> Complex:
    """Vectors (..., 2) as complex numbers, shape (...)."""
    return np.ascontiguousarray(vectors).view(np.complex128)[..., 0]


def as_vectors(numbers: Complex) -> Floats:
    """Complex numbers (...) as vectors (..., 2)."""
    return np.stack((numbers.real, numbers.imag), axis=-1)


# --- Shape functions on an edge, and the gap between a node and an edge with its derivatives.
#
# With the closest point ``x_m(xi)``, the edge's tangent ``t = x_m,xi`` and its unit normal n, which points out of the
# primary body, the gap is ``g = n . (x_s - x_m)``: open where positive (Moherdaui 2021, 3.5.1 to 3.5.6). Derivatives
# are those of this formula, see `flangeway.contact.kinematics`.
#
# Where an edge is evaluated many times its points are a power series in the parameter. Vectors of the plane are complex
# numbers there, x + i y.


PARAMETER_STEP = 1e-9
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

    return root_parameters(change, xi, 0.5, PARAMETER_STEP)


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
    return root_parameters(lambda eta: np.asarray(horner(along, eta) / horner(slopes, eta)), eta, 0.5, PARAMETER_STEP)


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


# --- Slip between two surfaces since an earlier position, and the directions of their tangential forces.
#
# The slip of a point is measured where the bodies were before. With the edge's point ``x(xi)`` that faces it now and
# the edge's unit tangent e, both at the earlier position, it is ``s = -e . (x_s - x(xi))``: the way of the point along
# the edge. It does not change with rigid motions of both bodies together, is the way along the surface on straight
# edges whichever of them the point has passed, and needs no partner at the earlier position. The tangential force is
# the one whose power with any velocities is that with the slip's rate, ``|x'| xi_dot`` (T. A. Laursen, 2002,
# "Computational Contact and Impact Mechanics", 4.2): it is in equilibrium on both bodies.


@dataclass(frozen=True, eq=False)
class Slides:
    """Slips of m constraints since an earlier position, of p terms with w points each; see `Pairs`.

    Parameters
    ----------
    slips
        How far the secondary has moved along the primary's direction, shape (m,).
    rates
        What each term adds to the derivatives of the slips by the positions of its points, shape (p, r, w, 2).
    directions
        What it adds to the forces on its points for a unit of tangential force, shape (p, r, w, 2).
    turns
        Called with tangential forces (m,): terms under load (q,), and the derivatives of their forces on the points by
        the points' positions, not symmetric, shape (q, 2 w, 2 w).

    """

    slips: Floats
    rates: Floats
    directions: Floats
    turns: Callable[[Floats], tuple[Ints, Floats]]


def node_edge_slips(points: Taylor, parameters: Floats, before: Floats) -> tuple[Taylor, Floats]:
    """Slips of nodes along edges since an earlier position, and unit tangential forces.

    Parameters
    ----------
    points
        Current positions of each node and of the nodes of its edge, shape (p, order + 2), with derivatives.
    parameters
        Those of the feet, shape (p,).
    before
        Earlier positions, shape (p, order + 2, 2).

    Returns
    -------
    tuple
        Slips (p,), and the forces on the points by their d variables, shape (p, d).

    """
    xi, _, length = gaps_over(points, parameters)
    series = edge_series(before[:, 1:])
    slope = horner(derivative(series), xi)
    slips = dot(slope, horner(series, xi) - as_complex(before[:, 0])) / slope.abs
    return slips, (length.value * xi.first).T


def node_edge_turns(points: Taylor, parameters: Floats) -> Floats:
    """Derivatives (p, d, d) of unit tangential forces ``|x'| dxi/du``; points with second ones."""
    xi, _, length = gaps_over(points, parameters)
    assert xi.second is not None
    turns: Floats = xi.first[:, None] * length.first + length.value * xi.second
    return np.moveaxis(turns, -1, 0)
