"""Pieces of the secondary surface that face one primary edge, and the integrals of the gap over them.

The gap at a secondary point is measured along the secondary's own normal: it is continuous over the primary's corners,
where the closest point would jump. Integrals are over the undeformed length of the secondary, whose edges are straight,
so that pressure on an open or penetrated gap does no work on the surface's stretching, and in bodies of revolution
they are weighted with its undeformed radius, linear along an edge as the hats. Their derivatives are exact,
those of the pieces' ends included. The sum over the pieces is invariant to rigid motions, so the forces on both sides
are in equilibrium to round-off.

At a parameter xi of the secondary edge, with its point x, unit tangent t and outward normal n, the gap g and the
opposite point y(eta) of the primary satisfy ``y(eta) = x + g n``. The points of quadrature are fixed parts of a piece,
whose ends are feet that move with the nodes. Derivatives by the positions of the nodes are those of these formulas, see
`flangeway.contact.taylor`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from flangeway.contact.kinematics import (
    closest_parameters,
    derivative,
    edge_series,
    foot,
    horner,
    ray_parameters,
    shape_functions,
    taylor_series,
)
from flangeway.contact.taylor import Array, Taylor, as_complex, cross, dot, implicit
from flangeway.elements.quadrature import gauss
from flangeway.types import Bools, Floats, Ints

SNAP = 1e-8  # parts of an edge within which the ends of two pieces are one
FAR = 0.5  # parts of an edge beyond its ends where a foot on its chord is not one on the edge itself
LEAST_FACING = 0.2  # cosine between the normals of two edges above which they do not face each other


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of secondary edges between nodes and feet of primary nodes; p of them.

    Parameters
    ----------
    edges, partners
        Secondary and primary edge, each of shape (p,).
    starts, ends
        Parameters of the piece on the secondary edge, shape (p,): 0 and 1 at its ends, else the foot of a node of the
        primary edge.

    """

    edges: Ints
    partners: Ints
    starts: Floats
    ends: Floats

    def __len__(self) -> int:
        """Return the number of pieces."""
        return len(self.edges)

    def take(self, chosen: Ints | Bools) -> "Pieces":
        """Some of the pieces."""
        return Pieces(self.edges[chosen], self.partners[chosen], self.starts[chosen], self.ends[chosen])


def find_pieces(
    secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints], reach: float, depth: float
) -> Pieces:
    """Cut secondary edges at the feet of the primary edges' ends.

    Parameters
    ----------
    secondary, primary
        Current positions of the edges' nodes, their bodies on the left, shapes (n, order + 1, 2).
    candidates
        Secondary and primary edges that may face each other, each of shape (c,).
    reach, depth
        Maximum gap and maximum penetration along the secondary's normal at the middle of a piece.

    """
    edges, partners = _over_chords(secondary, primary, candidates)
    own, other = secondary[edges], primary[partners]
    high, low = (closest_parameters(other[:, end], own) for end in (0, -1))
    starts, stops = np.where(low > SNAP, low, 0.0), np.where(high < 1.0 - SNAP, high, 1.0)
    pieces = Pieces(edges, partners, starts, stops)
    distance = _distances(own, other, (starts + stops) / 2.0)
    return pieces.take(np.flatnonzero((stops - starts > SNAP) & (distance < reach) & (distance > -depth)))


def _over_chords(secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints]) -> tuple[Ints, Ints]:
    """Candidates that face each other, the primary over the secondary's chord or near it.

    Curved edges are near enough to their chords to leave out what is far.
    """
    edges, partners = candidates
    start, other_start = as_complex(secondary[:, 0]), as_complex(primary[:, 0])
    chord, other = as_complex(secondary[:, -1]) - start, as_complex(primary[:, -1]) - other_start
    # the primary's start, and its chord: parts along the secondary's chord, and to its left
    high, along = (other_start[partners] - start[edges]) / chord[edges], other[partners] / chord[edges]
    over = (high.real > -FAR) & (high.real + along.real < 1.0 + FAR)
    over &= along.real < -LEAST_FACING * np.abs(along)  # the two sides run against each other
    return edges[over], partners[over]


class _Points(NamedTuple):
    """What is measured at q points of quadrature on each of p pieces, shape (p, q), with derivatives by d components.

    - `xi`, `eta`: parameters of the points and of the opposite ones on the primary edges.
    - `tangent`, `length`: unit tangent of the secondary and length of its derivative by xi.
    - `gap`: the gap.
    - `measure`: weights of the points in integrals over the undeformed surface.
    """

    xi: Taylor
    eta: Taylor
    tangent: Taylor
    length: Taylor
    gap: Taylor
    measure: Taylor

    @property
    def hats(self) -> tuple[Taylor, Taylor]:
        """The two hat functions of the edge, times the weights."""
        return self.measure * (1.0 - self.xi), self.measure * self.xi

    @property
    def hat_values(self) -> Floats:
        """Their values, shape (p, 2, q)."""
        return np.stack([hat.value for hat in self.hats], axis=1)


@dataclass(frozen=True, eq=False)
class PieceIntegrals:
    """Integrals over pieces with the two hat functions of each piece's edge, linear between its ends.

    Derivatives are by the d components of the positions of the secondary edge's nodes, then of the primary's.

    Parameters
    ----------
    pieces
        From `find_pieces`.
    secondary, primary
        Current positions of each piece's edges' nodes, shapes (p, order + 1, 2).
    edge_lengths
        Undeformed length of each piece's secondary edge, shape (p,).
    radii
        Undeformed radius of the ends of each piece's secondary edge, with which all integrals of bodies of revolution
        are weighted, shape (p, 2); None in the plane.

    """

    pieces: Pieces
    secondary: Floats
    primary: Floats
    edge_lengths: Floats
    radii: Floats | None = None

    def take(self, chosen: Ints) -> Self:
        """The same of some pieces."""
        radii = None if self.radii is None else self.radii[chosen]
        arrays = self.secondary[chosen], self.primary[chosen], self.edge_lengths[chosen], radii
        return type(self)(self.pieces.take(chosen), *arrays)

    @property
    def _orders(self) -> tuple[int, int]:
        return self.secondary.shape[1] - 1, self.primary.shape[1] - 1

    def _points(self, *, second: bool) -> _Points:
        """Points of quadrature with first derivatives, or with second ones too."""
        points = np.concatenate((self.secondary, self.primary), axis=1)
        # translations change nothing: the first node is the origin, see `_by_all`
        nodes = Taylor.of_points(points - points[:, :1], second=second)
        nodes = Taylor(nodes.value, nodes.first[2:], nodes.second)
        n_nodes, n_own, pieces = nodes.value.shape[1], self.secondary.shape[1], self.pieces
        own, other = taylor_series(nodes, 0, n_own), taylor_series(nodes, n_own, n_nodes)
        units = np.eye(n_nodes)
        # the primary runs against the secondary
        start = foot(own, nodes.weighted(units[-1]), pieces.starts, pieces.starts > 0.0)
        end = foot(own, nodes.weighted(units[n_own]), pieces.ends, pieces.ends < 1.0)
        own, other = ([coefficient[:, None] for coefficient in series] for series in (own, other))
        parts, weights = gauss(max(self._orders) + 1)
        width = (end - start)[:, None]
        xi = width * parts + start[:, None]
        point, slope = horner(own, xi), horner(derivative(own), xi)
        values = [coefficient.value for coefficient in other]
        eta = ray_parameters(values, point.value, slope.value)
        rate = (np.conj(slope.value) * horner(derivative(values), eta)).real
        opposite = implicit(lambda at: dot(slope, horner(other, at) - point), xi.constant(eta), rate)
        length = slope.abs
        gap = -cross(slope, horner(other, opposite) - point) / length
        measure = width * (self.edge_lengths[:, None] * weights)
        if self.radii is not None:
            measure = measure * (self.radii[:, :1] + (self.radii[:, 1:] - self.radii[:, :1]) * xi)
        return _Points(xi, opposite, slope / length, length, gap, measure)

    @cached_property
    def _at(self) -> _Points:
        return self._points(second=False)

    def _integral(self, values: Taylor) -> tuple[Floats, Floats]:
        """Integrals with the hats (p, 2) of values at the points, and their derivatives (p, 2, d)."""
        found = [(hat * values).sum() for hat in self._at.hats]
        firsts = np.stack([each.first for each in found])
        return np.stack([each.value for each in found], axis=1), _by_all(np.moveaxis(firsts, -1, 0))

    @cached_property
    def gaps(self) -> tuple[Floats, Floats]:
        """Integrals of the gap ``int phi_r g ds`` over the undeformed length (p, 2), and derivatives (p, 2, d)."""
        return self._integral(self._at.gap)

    @cached_property
    def lengths(self) -> Floats:
        """``int phi_r ds``, shape (p, 2)."""
        return np.asarray(self._at.hat_values.sum(axis=-1))

    @property
    def primary_shapes(self) -> Floats:
        """``int phi_r N_a ds`` with the primary edge's functions at the opposite point, shape (p, 2, order + 1)."""
        return np.asarray(self._at.hat_values @ shape_functions(self._orders[1], self._at.eta.value, 0)[0])

    def hessians(self, factors: Floats) -> Floats:
        """Second derivatives of the sums of factors (p, 2) times the two integrals of the gap, shape (p, d, d)."""
        at = self._points(second=True)
        total = (_weighted(at, factors) * at.gap).sum().second
        assert total is not None
        return _by_all(_by_all(np.moveaxis(total, -1, 0)).swapaxes(1, 2))

    def slips(self, secondary: Floats, primary: Floats) -> tuple[Floats, Floats, Floats]:
        """Integrals of the slip since earlier positions of the edges' nodes, each (p, order + 1, 2), see `Slides`.

        With the hats (p, 2); their derivatives, and unit tangential forces, each (p, 2, d).
        """
        own, other = ([each[:, None] for each in edge_series(edges)] for edges in (secondary, primary))
        at, slope = self._at, horner(derivative(own), self._at.xi)
        slips = dot(slope, horner(own, at.xi) - horner(other, at.eta)) / slope.abs
        directions = np.concatenate([each.value for each in self._directions], axis=-1)
        return *self._integral(slips), _components(at.hat_values @ directions)

    @cached_property
    def _directions(self) -> tuple[Taylor, Taylor]:
        """Unit tangential forces at the points on the nodes of both edges, (p, q, order + 1) each.

        They are the derivatives of the rate of slip by the nodes' velocities at fixed points of the secondary,
        ``t . (y_dot - x_dot) + g n . x_dot' / |x'|``.
        """
        at, (own, other) = self._at, self._orders
        shapes, slopes, bends = shape_functions(own, at.xi.value)
        onto, moving, _ = shape_functions(other, at.eta.value)
        xi, eta, tangent = (each[:, :, None] for each in (at.xi, at.eta, at.tangent))
        turning = (at.gap / at.length * at.tangent * -1.0j)[:, :, None]
        on_secondary = turning * xi.chained(slopes, bends) - tangent * xi.chained(shapes, slopes)
        return on_secondary, tangent * eta.chained(onto, moving)

    def turns(self, factors: Floats) -> Floats:
        """Derivatives of the sums of factors (p, 2) times the two unit tangential forces, shape (p, d, d)."""
        weights = _weighted(self._at, factors)[:, :, None]
        sums = [(weights * each).sum(axis=-2).first for each in self._directions]
        return _by_all(np.moveaxis(_components(np.concatenate(sums, axis=-1)), 0, -1))


def _weighted(at: _Points, factors: Floats) -> Taylor:
    """Weights of the points in the sums of factors (p, 2) times integrals with the hats."""
    first, second = factors[:, :1], factors[:, 1:]
    return at.measure * ((second - first) * at.xi + first)


def _by_all(derivatives: Floats) -> Floats:
    """Derivatives by the components of all points (..., 2 n) from those without the first point's (..., 2 n - 2)."""
    by_first = np.stack([-derivatives[..., axis::2].sum(axis=-1) for axis in (0, 1)], axis=-1)
    return np.concatenate((by_first, derivatives), axis=-1)


def _components(vectors: Array) -> Floats:
    """Components x and y of complex vectors (..., n) in turn, shape (..., 2 n)."""
    return np.ascontiguousarray(vectors).view(np.float64)


def _distances(secondary: Floats, primary: Floats, xi: Floats) -> Floats:
    """Distances along the secondary's normal from its points at parameters ``xi`` (p,) to the primary edges."""
    own, other = edge_series(secondary), edge_series(primary)
    at, tangent = horner(own, xi), horner(derivative(own), xi)
    apart = horner(other, ray_parameters(other, at, tangent)) - at
    return -(np.conj(tangent) * apart).imag / np.abs(tangent)
