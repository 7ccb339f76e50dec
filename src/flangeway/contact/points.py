"""Integrals of the gap over pieces of edges of any order by quadrature, with exact first and second derivatives.

At a parameter xi of the secondary edge, with its point x, unit tangent t, outward normal n and ``m = |dx/dxi|``, the
gap g and the opposite point y(eta) of the primary satisfy ``y(eta) = x + g n``. A dot is the rate of change when the
nodes move, xi with them (points of quadrature are fixed parts of a piece, whose ends are feet that move); with
``D = t . y'``, ``k = n . y' / D`` and ``P(a) = (n - k t) . a``, which is blind to changes of eta,

    omega = n . x_dot' / m,      lambda = t . x_dot' / m        (the tangent's turn and stretch)
    eta_dot = -(t . (y_dot - x_dot) + g omega) / D,   g_dot = n . (y_dot - x_dot) + D k eta_dot,
    g_ddot = 2 P(y_dot') eta_dot + P(y'') eta_dot^2 - P(x_ddot) - 2 k omega g_dot + g omega^2 + 2 g k omega lambda
             - g k n . x_ddot' / m,

where y_dot is the rate at fixed eta and x_dot that of the moving point. Second derivatives are sums of products of two
rates, so that those of a piece are one product of two matrices with few rows: the rates and their factors.

Vectors of the plane are complex numbers; see `flangeway.contact.edge_shapes`. Derivatives by nodes' positions are
complex as well, their parts those by x and by y: the rate is the real part of ``conj(derivative) velocity``.
"""

from copy import copy
from typing import Self

import numpy as np

from flangeway.contact.edge_shapes import as_complex, derivative, edge_series, horner, shape_functions
from flangeway.contact.kinematics import ENOUGH
from flangeway.elements.quadrature import gauss
from flangeway.types import Bools, Complex, Floats, Ints


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

    def __init__(self, parameters: Floats, moving: Bools, own: _Edges, other: _Edges, place: int) -> None:
        point, slope, bend, twist = (own.values(number, parameters) for number in range(4))
        self.m = np.abs(slope)
        self.t: Complex = slope / self.m
        self.n: Complex = -1j * self.t
        self.distance = _dot(self.n, other.nodes[:, place] - point)
        self.bend_t, self.bend_n, self.twist_n = _dot(self.t, bend), _dot(self.n, bend), _dot(self.n, twist)
        values, slopes, bends = shape_functions(own.order, parameters)
        onto = np.zeros((len(parameters), other.order + 1))
        self.slopes, self.bends = _beside(slopes, onto), _beside(bends, onto)
        onto[:, place] = 1.0
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
    """Gaps at q points of quadrature on each of p pieces; for the letters see the head of the file.

    Parameters
    ----------
    limits
        Parameters of the pieces' starts and ends on the secondary edges, each (p,).
    feet
        Whether a start is the foot of the primary edge's end, and an end that of its start, each (p,).
    secondary, primary
        Positions of the nodes of each piece's edges, shapes (p, order + 1, 2).
    edge_lengths
        Undeformed lengths of the secondary edges, shape (p,).

    """

    def __init__(
        self,
        limits: tuple[Floats, Floats],
        feet: tuple[Bools, Bools],
        secondary: Floats,
        primary: Floats,
        edge_lengths: Floats,
    ) -> None:
        own, other = _Edges(secondary), _Edges(primary)
        parts, weights = gauss(max(own.order, other.order) + 1)
        self.parts = np.broadcast_to(parts, (len(secondary), len(parts)))
        self.start = _Ends(limits[0], feet[0], own, other, -1)
        self.end = _Ends(limits[1], feet[1], own, other, 0)
        self.width = (limits[1] - limits[0])[:, None]
        self.xi = limits[0][:, None] + self.width * parts
        self.weights = edge_lengths[:, None] * weights  # of the undeformed length by parts of an edge
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
        apart = _beside(-values, self.other_values)
        self.moved = (1.0 - parts)[:, None] * self.start.rate[:, None] + parts[:, None] * self.end.rate[:, None]
        self.turn = self.slopes * (self.n / self.m)[..., None] + (self.bend_n / self.m)[..., None] * self.moved
        self.slide = apart * (-self.t / reach)[..., None] + (self.m / reach)[..., None] * self.moved
        self.slide -= (self.gap / reach)[..., None] * self.turn
        self.rate = apart * self.n[..., None] + rise[..., None] * self.slide

    @property
    def hats(self) -> Floats:
        """The two hat functions at the points, times their weights, shape (p, 2, q)."""
        measure = self.weights * self.width
        return np.stack(((1.0 - self.xi) * measure, self.xi * measure), axis=1)

    def gaps(self) -> tuple[Floats, Floats]:
        """Integrals of the gap with the hats (p, 2), and their derivatives by the components of the nodes (p, 2, 2 d).

        The derivatives are those of the gap, of the hats, which the points' moves change, and of the pieces' widths.
        """
        hats = self.hats
        values = (hats * self.gap[:, None]).sum(axis=-1)
        share = self.weights * self.gap
        by_width = np.stack(((share * (1.0 - self.xi)).sum(axis=-1), (share * self.xi).sum(axis=-1)), axis=1)
        to_end = self.width * np.stack(
            ((share * (1.0 - self.parts)).sum(axis=-1), (share * self.parts).sum(axis=-1)), 1
        )
        slopes = np.array([-1.0, 1.0])
        gradients = hats @ _components(self.rate)
        gradients += (slopes * to_end[:, :1] - by_width)[..., None] * _components(self.start.rate)[:, None]
        gradients += (slopes * to_end[:, 1:] + by_width)[..., None] * _components(self.end.rate)[:, None]
        return values, gradients

    def hessians(self, factors: Floats) -> Floats:
        """Second derivatives of the sums of factors (p, 2) times the two integrals of the gap, shape (p, 2 d, 2 d)."""
        shape = factors[:, :1] * (1.0 - self.xi) + factors[:, 1:] * self.xi
        slope = factors[:, 1:] - factors[:, :1]
        weights = self.weights * shape
        measure = weights * self.width
        g, k, m = self.gap, self.lean, self.m
        blind: Complex = self.n - k * self.t  # P
        moved, turn, slide, rate = self.moved, self.turn, self.slide, self.rate
        stretch = self.slopes * (self.t / m)[..., None] + (_dot(self.t, self.bend) / m)[..., None] * moved

        by_slide = self.other_slopes * (2.0 * measure * blind)[..., None]
        by_slide += (measure * _dot(blind, self.other_bend))[..., None] * slide
        by_turn = (-2.0 * measure * k)[..., None] * rate + (measure * g)[..., None] * turn
        by_turn += (2.0 * measure * g * k)[..., None] * stretch
        by_moved = self.slopes * (-2.0 * measure * blind)[..., None]
        by_moved -= self.bends * (2.0 * measure * g * k / m * self.n)[..., None]
        by_moved -= (measure * (_dot(blind, self.bend) + g * k * self.twist_n / m))[..., None] * moved
        by_moved += (2.0 * self.weights * self.width * slope)[..., None] * rate
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
        result: Floats = (product + product.swapaxes(1, 2)) / 2.0
        return result


def _dot(one: Complex, other: Complex) -> Floats:
    """Dot products of vectors."""
    return one.real * other.real + one.imag * other.imag


def _beside(secondary: Floats, primary: Floats) -> Floats:
    """What depends on the nodes of the secondary, then of the primary edge: along the last axis."""
    return np.concatenate((secondary, primary), axis=-1)


def _components(derivatives: Complex) -> Floats:
    """Derivatives by the components x and y of the nodes in turn, shape (..., 2 d), from complex ones (..., d)."""
    return np.ascontiguousarray(derivatives).view(np.float64)
