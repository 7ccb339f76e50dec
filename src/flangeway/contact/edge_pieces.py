"""Pieces of the secondary surface that face one primary edge, and the integrals of the gap over them.

The gap at a secondary point is measured along the secondary's own normal: it is continuous over the primary's corners,
where the closest point would jump. Integrals are over the undeformed length of the secondary, whose edges are straight,
so that pressure on an open or penetrated gap does no work on the surface's stretching, and in bodies of revolution
they are weighted with its undeformed radius, linear along an edge as the hats. Their derivatives are exact,
those of the pieces' ends included. The sum over the pieces is invariant to rigid motions, so the forces on both sides
are in equilibrium to round-off.

At a parameter xi of the secondary edge, with its point x, unit tangent t, outward
normal n and ``m = |dx/dxi|``, the gap g and the opposite point y(eta) of the primary satisfy ``y(eta) = x + g n``. A
dot is the rate of change when the nodes move, xi with them (points of quadrature are fixed parts of a piece, whose ends
are feet that move); with ``D = t . y'``, ``k = n . y' / D`` and ``P(a) = (n - k t) . a``, which does not depend on the
rate of eta,

    omega = n . x_dot' / m,      lambda = t . x_dot' / m        (the tangent's turn and stretch)
    eta_dot = -(t . (y_dot - x_dot) + g omega) / D,   g_dot = n . (y_dot - x_dot) + D k eta_dot,
    g_ddot = 2 P(y_dot') eta_dot + P(y'') eta_dot^2 - P(x_ddot) - 2 k omega g_dot + g omega^2 + 2 g k omega lambda
             - g k n . x_ddot' / m,

where y_dot is the rate at fixed eta and x_dot that of the moving point. Second derivatives are sums of products of two
rates. Those of a piece are one product of two matrices with few rows: the rates and their factors. Derivatives by
nodes' positions are complex numbers, their parts those by x and by y: the rate is the real part of
``conj(derivative) velocity``.
"""

from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np

from flangeway.contact.kinematics import (
    as_complex,
    closest_parameters,
    derivative,
    edge_series,
    horner,
    ray_parameters,
    shape_functions,
)
from flangeway.elements.quadrature import gauss
from flangeway.types import Bools, Complex, Floats, Ints

Pair = tuple[Floats, Floats]

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
        Parameters of the piece on the secondary edge, shape (p,).
    start_is_foot, end_is_foot
        Whether that is the foot of a node of the primary edge (else an end of the secondary edge), shape (p,).

    """

    edges: Ints
    partners: Ints
    starts: Floats
    ends: Floats
    start_is_foot: Bools
    end_is_foot: Bools

    def __len__(self) -> int:
        """Return the number of pieces."""
        return len(self.edges)

    def take(self, chosen: Ints | Bools) -> "Pieces":
        """Some of the pieces."""
        return Pieces(
            self.edges[chosen], self.partners[chosen], self.starts[chosen], self.ends[chosen],
            self.start_is_foot[chosen], self.end_is_foot[chosen],
        )  # fmt: skip


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
    edges, partners, feet = _over_chords(secondary, primary, candidates)
    straight = secondary.shape[1] == primary.shape[1] == 2
    if straight:
        high, low = feet.real
    else:
        ends = np.concatenate((primary[partners, 0], primary[partners, -1]))
        high, low = closest_parameters(ends, secondary[np.tile(edges, 2)]).reshape(2, -1)
    start_is_foot, end_is_foot = low > SNAP, high < 1.0 - SNAP
    starts, stops = np.where(start_is_foot, low, 0.0), np.where(end_is_foot, high, 1.0)
    pieces = Pieces(edges, partners, starts, stops, start_is_foot, end_is_foot)
    middle = (starts + stops) / 2.0
    if straight:
        across = feet[0] + (middle - high) / (low - high) * (feet[1] - feet[0])
        chords = secondary[:, 1] - secondary[:, 0]
        distance = -across.imag * np.hypot(chords[:, 0], chords[:, 1])[edges]
    else:
        distance = _distances(secondary[edges], primary[partners], middle)
    return pieces.take(np.flatnonzero((stops - starts > SNAP) & (distance < reach) & (distance > -depth)))


def _over_chords(secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints]) -> tuple[Ints, Ints, Complex]:
    """Candidates that face each other, the primary over the secondary's chord or near it.

    The third array (2, c) has the primary edge's start and end as numbers: the real part along the chord, 0 at its
    start and 1 at its end, the imaginary part to its left. Curved edges are near enough to their chords to leave out
    what is far.
    """
    edges, partners = candidates
    start, other_start = as_complex(secondary[:, 0]), as_complex(primary[:, 0])
    chord, other = as_complex(secondary[:, -1]) - start, as_complex(primary[:, -1]) - other_start
    scale = (1.0 / chord)[edges]
    high, along = (other_start[partners] - start[edges]) * scale, other[partners] * scale
    # the two sides run against each other
    over = np.flatnonzero((along.real < 0.0) & (high.real > -FAR) & (high.real + along.real < 1.0 + FAR))
    high, along = high[over], along[over]
    facing = along.real < -LEAST_FACING * np.abs(along)
    over = over[facing]
    return edges[over], partners[over], np.stack((high, high + along))[:, facing]


@dataclass(frozen=True, eq=False)
class PieceIntegrals:
    """Integrals over pieces with the two hat functions of each piece's edge, linear between its ends.

    Parameters
    ----------
    gaps
        ``int phi_r g ds`` over the undeformed length, shape (p, 2).
    gradients
        First derivatives by the components of the secondary edge's nodes, then of the primary's, shape (p, 2, d).
    lengths
        ``int phi_r ds``, shape (p, 2).
    primary_shapes
        ``int phi_r N_a ds`` with the primary edge's functions at the opposite point, shape (p, 2, order + 1).
    points
        The points of quadrature, for second derivatives.

    """

    gaps: Floats
    gradients: Floats
    lengths: Floats
    primary_shapes: Floats
    points: "PiecePoints"


def integrate(
    pieces: Pieces, secondary: Floats, primary: Floats, edge_lengths: Floats, radii: Floats | None = None
) -> PieceIntegrals:
    """Integrate the gap over pieces.

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
    limits, feet = (pieces.starts, pieces.ends), (pieces.start_is_foot, pieces.end_is_foot)
    points = PiecePoints(limits, feet, secondary, primary, edge_lengths, radii)
    hats = points.hats
    return PieceIntegrals(*points.gaps(), hats.sum(axis=-1), hats @ points.other_values, points)


def _distances(secondary: Floats, primary: Floats, xi: Floats) -> Floats:
    """Distances along the secondary's normal from its points at parameters ``xi`` (p,) to the primary edges."""
    own, other = edge_series(secondary), edge_series(primary)
    at, tangent = horner(own, xi), horner(derivative(own), xi)
    apart = horner(other, ray_parameters(other, at, tangent)) - at
    return -(np.conj(tangent) * apart).imag / np.abs(tangent)


class _Arrays:
    """Arrays of p pieces, the first axis of each, of which some can be taken together."""

    def take(self, chosen: Ints) -> Self:
        """The same of some pieces."""
        part = copy(self)
        for name, value in vars(self).items():
            setattr(part, name, value[chosen] if isinstance(value, np.ndarray) else value.take(chosen))
        return part


class _Edges:
    """Edges with nodes (p, order + 1, 2) as power series of their parameters."""

    def __init__(self, positions: Floats) -> None:
        self.nodes = as_complex(positions)
        self.order = positions.shape[1] - 1
        self.series = [edge_series(positions)]
        for _ in range(3):
            self.series.append(derivative(self.series[-1]))

    def values(self, number: int, parameters: Floats) -> Complex:
        """Points, or their derivatives of a number, at parameters (p,) or (p, q)."""
        series = self.series[number]
        return horner(series[..., None] if parameters.ndim == 2 else series, parameters)


class _Ends(_Arrays):
    """Starts or ends of pieces on secondary edges, and the rates of their parameters, which only feet have.

    With the distance d of the primary's node from its foot, ``(m^2 - d n . x'') rate = m t . (y_dot - x_dot) +
    d n . x_dot'`` at fixed parameter.
    """

    def __init__(self, parameters: Floats, moving: Bools, own: _Edges, other: _Edges, end: int) -> None:
        point, slope, bend, twist = (own.values(number, parameters) for number in range(4))
        self.m = np.abs(slope)
        self.t: Complex = slope / self.m
        self.n: Complex = -1j * self.t
        self.distance = _dot(self.n, other.nodes[:, end] - point)
        self.bend_t, self.bend_n, self.twist_n = _dot(self.t, bend), _dot(self.n, bend), _dot(self.n, twist)
        values, slopes, bends = shape_functions(own.order, parameters)
        onto = np.zeros((len(parameters), other.order + 1))
        self.slopes, self.bends = _beside(slopes, onto), _beside(bends, onto)
        onto[:, end] = 1.0
        self.apart = _beside(-values, onto)
        self.inverse = np.where(moving, 1.0 / (self.m**2 - self.distance * self.bend_n), 0.0)
        self.rate: Complex = (
            self.apart * (self.inverse * self.m * self.t)[:, None]
            + self.slopes * (self.inverse * self.distance * self.n)[:, None]
        )

    def second(self) -> tuple[Complex, Complex, Complex]:
        """Factors of the second derivative ``rate f0 + f1 f2``, each (p, d)."""
        turn = self.slopes * self.n[:, None] + self.bend_n[:, None] * self.rate
        along = self.slopes * self.t[:, None] + self.bend_t[:, None] * self.rate
        by_rate = (
            self.slopes * (-2.0 * self.m * self.t)[:, None]
            + self.bends * (2.0 * self.distance * self.n)[:, None]
            + (self.distance * self.twist_n - self.m * self.bend_t)[:, None] * self.rate
        )
        by_turn = 2.0 * (self.apart * self.n[:, None] - (self.distance / self.m)[:, None] * along)
        return self.inverse[:, None] * by_rate, turn, self.inverse[:, None] * by_turn


class PiecePoints(_Arrays):
    """Gaps at q points of quadrature on each of p pieces; the head of the file explains the letters.

    ``limits`` are the starts and ends of the pieces, of which ``feet`` are those of the primary edge's end and
    start, each (p,); the other arguments are those of `integrate`.
    """

    def __init__(
        self,
        limits: Pair,
        feet: tuple[Bools, Bools],
        secondary: Floats,
        primary: Floats,
        edge_lengths: Floats,
        radii: Floats | None = None,
    ) -> None:
        own, other = _Edges(secondary), _Edges(primary)
        parts, weights = gauss(max(own.order, other.order) + 1)
        self.parts = np.broadcast_to(parts, (len(secondary), len(parts)))
        self.start = _Ends(limits[0], feet[0], own, other, -1)
        self.end = _Ends(limits[1], feet[1], own, other, 0)
        self.width = (limits[1] - limits[0])[:, None]
        self.xi = limits[0][:, None] + self.width * parts
        self.weights = edge_lengths[:, None] * weights  # of the undeformed length by parts of an edge
        self.radii = np.ones((len(secondary), 2)) if radii is None else radii
        point, slope, bend, twist = (own.values(number, self.xi) for number in range(4))
        self.m = np.abs(slope)
        self.t: Complex = slope / self.m
        self.n: Complex = -1j * self.t
        eta = ray_parameters(other.series[0][..., None], point, self.t)
        there, along, self.other_bend = (other.values(number, eta) for number in range(3))
        self.gap = _dot(self.n, there - point)
        reach, rise = _dot(self.t, along), _dot(self.n, along)
        self.lean = rise / reach  # k
        self.bend, self.bend_n, self.twist_n = bend, _dot(self.n, bend), _dot(self.n, twist)

        values, slopes, bends = shape_functions(own.order, self.xi)
        self.other_values, other_slopes = shape_functions(other.order, eta, 1)
        nothing = np.zeros_like(other_slopes)
        self.slopes, self.bends = _beside(slopes, nothing), _beside(bends, nothing)
        self.other_slopes = _beside(np.zeros_like(values), other_slopes)
        self.eta, self.apart = eta, _beside(-values, self.other_values)
        self.moved = (1.0 - parts)[:, None] * self.start.rate[:, None] + parts[:, None] * self.end.rate[:, None]
        self.turn = self.slopes * (self.n / self.m)[..., None] + (self.bend_n / self.m)[..., None] * self.moved
        self.slide = self.apart * (-self.t / reach)[..., None] + (self.m / reach)[..., None] * self.moved
        self.slide -= (self.gap / reach)[..., None] * self.turn
        self.rate = self.apart * self.n[..., None] + rise[..., None] * self.slide

    @property
    def hats(self) -> Floats:
        """The two hat functions at the points, times their weights, shape (p, 2, q)."""
        return self._functions[0] * (self.weights * self.width)[:, None]

    @property
    def _functions(self) -> tuple[Floats, Floats, Floats]:
        """The two hats times the radius, their first and second derivatives by xi, each (p, 2, q) or (p, 2, 1)."""
        xi, start, slope = self.xi, self.radii[:, :1], self.radii[:, 1:] - self.radii[:, :1]
        radius, hats = start + slope * xi, np.stack((1.0 - xi, xi), axis=1)
        signs = np.array([-1.0, 1.0])[:, None]
        bends = 2.0 * signs * slope[:, None]
        return hats * radius[:, None], signs * radius[:, None] + hats * slope[:, None], bends

    def _shape(self, factors: Floats) -> tuple[Floats, Floats, Floats]:
        """Sums of factors (p, 2) times the functions, and their derivatives by xi, each (p, q) or (p, 1)."""
        value, slope, bend = (np.einsum("ps,psq->pq", factors, each) for each in self._functions)
        return value, slope, bend

    def gaps(self) -> tuple[Floats, Floats]:
        """Integrals of the gap with the hats (p, 2), and their derivatives by the components of the nodes (p, 2, 2 d).

        These include the changes of the hats at the moving points and of the pieces' widths.
        """
        return self._integrals(self.gap, self.rate)

    def slips(self, secondary: Floats, primary: Floats) -> tuple[Floats, Floats, Floats]:
        """Integrals of the slip since earlier positions of the edges' nodes, each (p, order + 1, 2), see `Slides`.

        The second and third result are as those of `gaps`: derivatives of the first, and unit tangential forces.
        """
        own, other = _Edges(secondary), _Edges(primary)
        point, slope, bend = (own.values(number, self.xi) for number in range(3))
        m = np.abs(slope)
        t = slope / m
        apart, across = point - other.values(0, self.eta), _dot(-1j * t, bend) / m
        by_xi, by_eta = m + across * _dot(-1j * t, apart), -_dot(t, other.values(1, self.eta))
        rates = by_xi[..., None] * self.moved + by_eta[..., None] * self.slide
        return *self._integrals(_dot(t, apart), rates), self.hats @ _components(self.directions)

    @property
    def directions(self) -> Complex:
        """Derivatives of the rate of slip by the nodes' velocities at fixed points of the secondary, (p, q, d)."""
        turned = (self.gap / self.m * self.n)[..., None] * self.slopes
        return self.apart * self.t[..., None] + turned

    def turns(self, factors: Floats) -> Floats:
        """Derivatives of the sums of factors (p, 2) times the two unit tangential forces, shape (p, 2 d, 2 d)."""
        shape, slope, _ = self._shape(factors)
        weights = self.weights * shape
        measure, g, directions = weights * self.width, self.gap / self.m, self.directions
        stretch = (
            self.slopes * (self.t / self.m)[..., None] + (_dot(self.t, self.bend) / self.m)[..., None] * self.moved
        )
        by_moved = (measure * g * self.n)[..., None] * self.bends - (measure * self.t)[..., None] * self.slopes
        by_moved += (self.weights * self.width * slope)[..., None] * directions
        by_turn = (measure * self.n)[..., None] * self.apart - (measure * g * self.t)[..., None] * self.slopes
        along = (measure * self.n / self.m)[..., None] * self.slopes
        by_slide = (measure * self.t)[..., None] * self.other_slopes
        by_width = (weights[..., None] * directions).sum(axis=1, keepdims=True)
        left = by_moved, by_turn, along, -self.gap[..., None] * along, by_slide, by_width
        widening = (self.end.rate - self.start.rate)[:, None]
        right = self.moved, self.turn, self.rate, stretch, self.slide, widening
        one, other = (_components(np.concatenate(each, axis=1)) for each in (left, right))
        return one.swapaxes(1, 2) @ other

    def _integrals(self, points: Floats, rates: Complex) -> tuple[Floats, Floats]:
        """Integrals with the hats of values at the points (p, q), and their derivatives, by the values' rates."""
        hats, (functions, slopes, _) = self.hats, self._functions
        values = (hats * points[:, None]).sum(axis=-1)
        share = (self.weights * points)[:, None]
        by_width = (share * functions).sum(axis=-1)
        gradients = hats @ _components(rates)
        for end, sign, parts in ((self.start, -1.0, 1.0 - self.parts), (self.end, 1.0, self.parts)):
            by_end = self.width * (share * slopes * parts[:, None]).sum(axis=-1) + sign * by_width
            gradients += by_end[..., None] * _components(end.rate)[:, None]
        return values, gradients

    def hessians(self, factors: Floats) -> Floats:
        """Second derivatives of the sums of factors (p, 2) times the two integrals of the gap, shape (p, 2 d, 2 d)."""
        shape, slope, bend = self._shape(factors)
        weights = self.weights * shape
        measure = weights * self.width
        g, k, m = self.gap, self.lean, self.m
        across: Complex = self.n - k * self.t  # P
        moved, turn, slide, rate = self.moved, self.turn, self.slide, self.rate
        stretch = self.slopes * (self.t / m)[..., None] + (_dot(self.t, self.bend) / m)[..., None] * moved

        by_slide = self.other_slopes * (2.0 * measure * across)[..., None]
        by_slide += (measure * _dot(across, self.other_bend))[..., None] * slide
        by_turn = (-2.0 * measure * k)[..., None] * rate + (measure * g)[..., None] * turn
        by_turn += (2.0 * measure * g * k)[..., None] * stretch
        by_moved = self.slopes * (-2.0 * measure * across)[..., None]
        by_moved -= self.bends * (2.0 * measure * g * k / m * self.n)[..., None]
        by_moved -= (measure * (_dot(across, self.bend) + g * k * self.twist_n / m))[..., None] * moved
        by_moved += (2.0 * self.weights * self.width * slope)[..., None] * rate
        by_moved += (self.weights * self.width * bend * g)[..., None] * moved
        widening = self.end.rate - self.start.rate
        by_moved += (2.0 * self.weights * g * slope)[..., None] * widening[:, None]
        by_width = 2.0 * (weights[..., None] * rate).sum(axis=1)
        # what multiplies the second derivatives of the pieces' ends
        by_xi = self.weights * self.width * slope * g + measure * k * (m - g * self.bend_n / m)
        of_width = (weights * g).sum(axis=1)
        ends = (
            (self.start, -1.0, ((1.0 - self.parts) * by_xi).sum(axis=1) - of_width, 1.0 - self.parts),
            (self.end, 1.0, (self.parts * by_xi).sum(axis=1) + of_width, self.parts),
        )
        left, right = [slide, turn], [by_slide, by_turn]
        for end, sign, factor, parts in ends:
            first, end_turn, second = (each[:, None] for each in end.second())
            through = (parts[..., None] * by_moved).sum(axis=1) + sign * by_width
            left += [end.rate[:, None], end_turn]
            right += [through[:, None] + factor[:, None, None] * first, factor[:, None, None] * second]
        product = _components(np.concatenate(left, axis=1)).swapaxes(1, 2) @ _components(np.concatenate(right, axis=1))
        return (product + product.swapaxes(1, 2)) / 2.0


def _dot(one: Complex, other: Complex) -> Floats:
    """Dot products of vectors."""
    return one.real * other.real + one.imag * other.imag


def _beside(secondary: Floats, primary: Floats) -> Floats:
    """What depends on the nodes of the secondary, then of the primary edge: along the last axis."""
    return np.concatenate((secondary, primary), axis=-1)


def _components(derivatives: Complex) -> Floats:
    """Derivatives by the components x and y of the nodes in turn, shape (..., 2 d), from complex ones (..., d)."""
    return np.ascontiguousarray(derivatives).view(np.float64)
