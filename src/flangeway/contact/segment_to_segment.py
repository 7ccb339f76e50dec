"""Segment-to-segment contact: gaps averaged over the secondary surface (mortar method)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import ClassVar, Literal, NamedTuple, Self

import numpy as np

from flangeway.checks import check_positive
from flangeway.contact.kinematics import (
    Array,
    Slides,
    Taylor,
    as_complex,
    closest_parameters,
    cross,
    derivative,
    dot,
    edge_series,
    foot,
    horner,
    implicit,
    ray_parameters,
    shape_functions,
    taylor_series,
)
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.search import candidate_pairs, leads_out
from flangeway.contact.surface import Surface
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import chords_of, cross_product, diagonal, norms, sums_at, turned_right
from flangeway.types import Bools, Floats, Ints

# --- Pieces of the secondary surface that face one primary edge, and the integrals of the gap over them.
#
# The gap at a secondary point is measured along the secondary's own normal: it is continuous over the primary's
# corners, where the closest point would jump. Integrals are over the undeformed length of the secondary, whose edges
# are straight, so that pressure on an open or penetrated gap does no work on the surface's stretching, and in bodies of
# revolution they are weighted with its undeformed radius, linear along an edge as the hats. Their derivatives are
# exact, those of the pieces' ends included. The sum over the pieces is invariant to rigid motions, so the forces on
# both sides are in equilibrium to round-off.
#
# At a parameter xi of the secondary edge, with its point x, unit tangent t and outward normal n, the gap g and the
# opposite point y(eta) of the primary satisfy ``y(eta) = x + g n``. The points of quadrature are fixed parts of a
# piece, whose ends are feet that move with the nodes. Derivatives by the positions of the nodes are those of these
# formulas, see `flangeway.contact.kinematics`.


SNAP = 1e-8  # parts of an edge within which the ends of two pieces are one
MAX_FOOT_DISTANCE = 0.5  # parts of an edge beyond its ends where a foot on its chord is not one on the edge itself
MIN_FACING = 0.2  # cosine between the normals of two edges above which they do not face each other


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
    secondary_edges, other = secondary[edges], primary[partners]
    high, low = (closest_parameters(other[:, end], secondary_edges) for end in (0, -1))
    starts, stops = np.where(low > SNAP, low, 0.0), np.where(high < 1.0 - SNAP, high, 1.0)
    pieces = Pieces(edges, partners, starts, stops)
    distance = _distances(secondary_edges, other, (starts + stops) / 2.0)
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
    over = (high.real > -MAX_FOOT_DISTANCE) & (high.real + along.real < 1.0 + MAX_FOOT_DISTANCE)
    over &= along.real < -MIN_FACING * np.abs(along)  # the two sides run against each other
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
        secondary_series, other = taylor_series(nodes, 0, n_own), taylor_series(nodes, n_own, n_nodes)
        units = np.eye(n_nodes)
        # the primary runs against the secondary
        start = foot(secondary_series, nodes.weighted(units[-1]), pieces.starts, pieces.starts > 0.0)
        end = foot(secondary_series, nodes.weighted(units[n_own]), pieces.ends, pieces.ends < 1.0)
        secondary_series, other = (
            [coefficient[:, None] for coefficient in series] for series in (secondary_series, other)
        )
        parts, weights = gauss(max(self._orders) + 1)
        width = (end - start)[:, None]
        xi = width * parts + start[:, None]
        point, slope = horner(secondary_series, xi), horner(derivative(secondary_series), xi)
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
        integrals = [(hat * values).sum() for hat in self._at.hats]
        firsts = np.stack([integral.first for integral in integrals])
        return np.stack([integral.value for integral in integrals], axis=1), _by_all(np.moveaxis(firsts, -1, 0))

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
        secondary_series, other = ([series[:, None] for series in edge_series(edges)] for edges in (secondary, primary))
        at, slope = self._at, horner(derivative(secondary_series), self._at.xi)
        slips = dot(slope, horner(secondary_series, at.xi) - horner(other, at.eta)) / slope.abs
        directions = np.concatenate([direction.value for direction in self._directions], axis=-1)
        return *self._integral(slips), _components(at.hat_values @ directions)

    @cached_property
    def _directions(self) -> tuple[Taylor, Taylor]:
        """Unit tangential forces at the points on the nodes of both edges, (p, q, order + 1) each.

        They are the derivatives of the rate of slip by the nodes' velocities at fixed points of the secondary,
        ``t . (y_dot - x_dot) + g n . x_dot' / |x'|``.
        """
        at, (secondary_order, other) = self._at, self._orders
        shapes, slopes, bends = shape_functions(secondary_order, at.xi.value)
        onto, moving, _ = shape_functions(other, at.eta.value)
        xi, eta, tangent = (values[:, :, None] for values in (at.xi, at.eta, at.tangent))
        turning = (at.gap / at.length * at.tangent * -1.0j)[:, :, None]
        on_secondary = turning * xi.chained(slopes, bends) - tangent * xi.chained(shapes, slopes)
        return on_secondary, tangent * eta.chained(onto, moving)

    def turns(self, factors: Floats) -> Floats:
        """Derivatives of the sums of factors (p, 2) times the two unit tangential forces, shape (p, d, d)."""
        weights = _weighted(self._at, factors)[:, :, None]
        sums = [(weights * direction).sum(axis=-2).first for direction in self._directions]
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
    secondary_series, other = edge_series(secondary), edge_series(primary)
    at, tangent = horner(secondary_series, xi), horner(derivative(secondary_series), xi)
    apart = horner(other, ray_parameters(other, at, tangent)) - at
    return -(np.conj(tangent) * apart).imag / np.abs(tangent)


# --- Segment-to-segment contact: gaps averaged over the secondary surface (mortar method).
#
# Each end of a secondary edge carries a hat function, linear over the edges. On edges of order 2 and more this is one
# order less than the displacements, which keeps multipliers free of oscillations (as Taylor and Hood's pair does for
# fluids; with a hat at every node they oscillate), and pressures of values >= 0 are >= 0 everywhere. The constraint of
# a hat is the mean of the gap weighted with it (Puso and Laursen, 2004, Comput. Methods Appl. Mech. Eng. 193), or with
# the biorthogonal function of the same edge (Wohlmuth, 2000, SIAM J. Numer. Anal. 38).


MIN_COVERED = 1e-6
"""Part of a hat function's area that must face the primary, and part of an edge that may be left uncovered."""

SETTLED_COVERED = 1e-9
"""The same where an iteration cycles: a node opposite a corner of the primary covers it or not by the slightest slide,
and the constraint of such a sliver is the whole gap of the corner."""

MAX_FLAT_ANGLE = np.deg2rad(20.0)
"""Angle up to which a secondary edge lies flat on primary ones: far above that of the chords of coarse curves, which it
meets in turn, and below that of the sides of a sharp corner."""

DUAL = np.array([[2.0, -1.0], [-1.0, 2.0]])
"""Biorthogonal functions of an edge as combinations of its two hats."""


@dataclass(frozen=True, eq=False)
class SegmentPairs(Pairs):
    """Constraints of the hat functions that face the primary.

    Parameters
    ----------
    pieces
        Pieces of the secondary surface.
    integrals
        Integrals over the pieces, with their derivatives.
    weights
        What the integrals with a piece's two hats add to the gaps of its two constraints, shape (p, 2, 2).

    """

    pieces: Pieces
    integrals: PieceIntegrals
    weights: Floats

    @cached_property
    def gradients(self) -> Floats:
        """See `Pairs.gradients`."""
        return self._on_points(self.integrals.gaps[1])

    def _on_points(self, integrals: Floats) -> Floats:
        """What the derivatives of the integrals with the hats (p, 2, d) add to those of the constraints."""
        gradients: Floats = np.einsum("prs,psd->prd", self.weights, integrals)
        return gradients.reshape(*gradients.shape[:2], gradients.shape[2] // 2, 2)

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `Pairs.curvatures`."""
        return self._on_terms(forces, PieceIntegrals.hessians)

    def _on_terms(self, forces: Floats, second: Callable[[PieceIntegrals, Floats], Floats]) -> tuple[Ints, Floats]:
        """Pieces under load, and their second derivatives by forces on the two hats."""
        on_hats = np.einsum("pr,prs->ps", forces[self.rows], self.weights)
        loaded = np.flatnonzero(on_hats.any(axis=1))
        return loaded, second(self.integrals.take(loaded), on_hats[loaded])

    def slides(self, points: Floats, before: Floats) -> Slides:  # noqa: ARG002 (the pieces know where they are)
        """See `Pairs.slides`."""
        n_secondary = self.secondary_members.shape[1]
        values, rates, directions = self.integrals.slips(before[:, :n_secondary], before[:, n_secondary:])
        slips = sums_at(self.rows, np.einsum("prs,ps->pr", self.weights, values), len(self.keys))
        turns = partial(self._on_terms, second=PieceIntegrals.turns)
        return Slides(slips, self._on_points(rates), self._on_points(directions), turns)

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Pairs.opposite_points`."""
        moments = np.einsum("pra,pai->pri", self.integrals.primary_shapes, edges[self.pieces.partners])
        total, covered = (sums_at(self.rows, of, len(self.keys)) for of in (moments, self.integrals.lengths))
        return total / covered[:, None]


@dataclass(frozen=True)
class SegmentToSegment(Pairing):
    """Average the gap over the pieces between the nodes of both surfaces.

    A uniform pressure passes from one surface to the other exactly, whatever their meshes, where both are straight.
    The order of quadrature follows the edges'. Where a node's function is covered by the primary in part only, its
    constraint is the mean over that part; the tangent of a penalty then leaves out the change of the covered area.

    Parameters
    ----------
    depth
        Pieces that penetrate deeper are ignored; None: half the extent of the smaller surface. A step that moves a
        surface deeper than this into the other loses the contact.
    weighting
        ``"standard"``: gaps weighted with the hat functions. ``"dual"``: with their biorthogonal functions, on edges
        that lie flat on the primary as a whole; these oscillate less.

    """

    averages: ClassVar[bool] = True
    depth: float | None = None
    weighting: Literal["standard", "dual"] = "standard"

    def __post_init__(self) -> None:
        if self.depth is not None:
            check_positive("SegmentToSegment", "depth", self.depth, "a positive length or None", "leave it out")
        if self.weighting not in ("standard", "dual"):
            raise InputError(
                f"SegmentToSegment(weighting={short(self.weighting)})", "'standard' or 'dual'", "choose one of these"
            )

    def node_areas(self, secondary: Surface) -> Floats:
        """See `Pairing.node_areas`."""
        hats = secondary.hats
        return sums_at(hats.nodes, hats.areas, len(secondary.nodes))

    def key_nodes(self, secondary: Surface) -> Ints:
        """See `Pairing.key_nodes`."""
        return secondary.hats.nodes

    def pair(
        self,
        secondary: Surface,
        primary: Surface,  # noqa: ARG002 (its edges are enough)
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,  # noqa: ARG002 (gaps are continuous: no constraint has a partner)
        *,
        settle: bool = False,
    ) -> SegmentPairs:
        """Find the pieces that are open by less than two mean primary edges; see `Pairing.pair`.

        ``settle``: hat functions have a constraint down to `SETTLED_COVERED`.
        """
        hats = secondary.hats
        chords = chords_of(primary_edges)
        reach = 2.0 * float(norms(chords).mean())
        edges = positions[secondary.contact_places]
        depth = self.depth or min(diagonal(side) for side in (edges, primary_edges)) / 2.0
        candidates = candidate_pairs(_swept(edges, reach, depth), primary_edges, secondary.edge_lengths)
        pieces = find_pieces(edges, primary_edges, candidates, reach, depth)
        pieces = pieces.take(~_through_itself(pieces, edges, primary_edges))
        integrals = _integrals(pieces, edges, primary_edges, secondary)

        of_piece = hats.of_edge[pieces.edges]
        covered = sums_at(of_piece, integrals.lengths, len(hats.nodes))
        thickness = secondary.part.body.depth
        keys = np.flatnonzero(covered * thickness > (SETTLED_COVERED if settle else MIN_COVERED) * hats.areas)
        if len(keys) == 0:  # at most slivers, which carry nothing
            pieces = pieces.take(np.empty(0, dtype=np.int64))
            integrals = _integrals(pieces, edges, primary_edges, secondary)
            of_piece = of_piece[:0]
        # pieces add nothing to a hat that is almost uncovered: their weight is zero
        row_of = np.zeros(len(hats.nodes), dtype=np.int64)
        row_of[keys] = np.arange(len(keys))
        inverse = np.zeros(len(hats.nodes))
        inverse[keys] = 1.0 / covered[keys]
        weights = self._functions(pieces, integrals, secondary, edges, primary_edges) * inverse[of_piece][:, :, None]
        rows = row_of[of_piece]
        gaps = sums_at(rows, np.einsum("prs,ps->pr", weights, integrals.gaps[0]), len(keys))
        return SegmentPairs(
            keys, np.full(len(keys), -1), hats.nodes[keys], gaps, covered[keys] * thickness, hats.areas[keys],
            secondary.contact_places[pieces.edges], pieces.partners, rows, pieces, integrals, weights,
        )  # fmt: skip

    def _functions(
        self, pieces: Pieces, integrals: PieceIntegrals, secondary: Surface, edges: Floats, primary_edges: Floats
    ) -> Floats:
        """Weighting functions as combinations of the two hats of each piece's edge, shape (p, 2, 2).

        Biorthogonal functions have both signs. Where the gap is far from linear, as of an edge that a corner of the
        primary meets, their mean may be negative although the surfaces are apart.
        """
        functions = np.zeros((len(pieces), 2, 2))
        functions[:] = np.eye(2)
        if self.weighting == "dual":
            covered = sums_at(pieces.edges, integrals.lengths.sum(axis=1), len(edges))
            flat = covered > (1.0 - MIN_COVERED) * secondary.edge_lengths
            along, opposite = (
                chords_of(edge_points) for edge_points in (edges[pieces.edges], primary_edges[pieces.partners])
            )
            cosines = -(along * opposite).sum(axis=1) / norms(along) / norms(opposite)
            flat[pieces.edges[cosines < np.cos(MAX_FLAT_ANGLE)]] = False
            functions[flat[pieces.edges]] = DUAL
        return functions


def _integrals(pieces: Pieces, edges: Floats, primary_edges: Floats, secondary: Surface) -> PieceIntegrals:
    """Integrals over pieces of a surface between positions of its edges and of the primary's."""
    lengths = secondary.edge_lengths[pieces.edges]
    radii = None if secondary.radii is None else secondary.radii[pieces.edges]
    both = edges[pieces.edges], primary_edges[pieces.partners]
    return PieceIntegrals(pieces, *both, lengths, radii)


def _swept(edges: Floats, reach: float, depth: float) -> Floats:
    """Points of edges (n, order + 1, 2) moved outwards by a reach and inwards by a depth, beside each other."""
    outwards = turned_right(chords_of(edges))
    outwards /= np.hypot(*outwards.T)[:, None]
    return np.concatenate((edges + reach * outwards[:, None], edges - depth * outwards[:, None]), axis=1)


def _through_itself(pieces: Pieces, edges: Floats, primary_edges: Floats) -> Bools:
    """Pieces that face the primary through their own body, see `leads_out`."""
    middle = ((pieces.starts + pieces.ends) / 2.0)[:, None]
    start, along = edges[pieces.edges, 0], edges[pieces.edges, -1] - edges[pieces.edges, 0]
    other = primary_edges[pieces.partners, 0]
    chord = primary_edges[pieces.partners, -1] - other
    at = start + middle * along
    share = ((at - other) * along).sum(axis=1) / (chord * along).sum(axis=1)
    way = other + share[:, None] * chord - at
    result = np.zeros(len(pieces), dtype=np.bool_)
    behind = np.flatnonzero(cross_product(along, way) > 0.0)
    sizes = (pieces.ends - pieces.starts) * norms(along)
    secondary_edges = edges, pieces.edges[behind, None] == np.arange(len(edges))
    faced_edges = primary_edges, pieces.partners[behind, None] == np.arange(len(primary_edges))
    result[behind] = leads_out(at[behind], way[behind], sizes[behind], secondary_edges, faced_edges)
    return result
