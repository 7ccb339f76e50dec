"""Contact of nodes: each against one edge of the other surface, or against the node opposite it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar
from weakref import WeakKeyDictionary

import numpy as np

from flangeway.checks import is_finite
from flangeway.contact.kinematics import (
    NodeEdgeGaps,
    Slides,
    Taylor,
    closest_parameters,
    derivative,
    edge_series,
    gaps_over,
    horner,
    node_edge_gaps,
    node_edge_slips,
    node_edge_turns,
    shape_functions,
)
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.search import leads_out, nearest_edges
from flangeway.contact.surface import Surface, node_normals, pressing_cosines
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import chords_of, cross_product, norms, point_text, sums_at, turned_right, units_of
from flangeway.mesh.connectivity import places_in
from flangeway.mesh.insertion import opposite_places
from flangeway.types import Bools, Floats, Ints

# --- Node-to-segment contact: each secondary node against one primary edge (Moherdaui 2021, 3.5).


FOOT_SLACK, OPEN_SLACK = 1e-3, 0.1
"""Parts of an edge beyond its ends within which the foot of a node behind it may be, and that of an open node: the
latter bridges the dead angle at convex corners, where an open node is beyond the ends of both edges."""
CONCAVE_SLACK = 0.5
"""The same at a concave joint, behind which points are beyond the ends of both edges."""


@dataclass(frozen=True, eq=False)
class NodePairs(Pairs):
    """Nodes of either side and the edges of the other one that they face: a constraint and a term each.

    Parameters
    ----------
    points
        Current positions of the nodes of the secondary and of the primary edge, shape (m, w, 2).
    slots
        The node, then the nodes of the edge that it faces, among these, shape (m, order + 2).
    parameters
        Closest points of the edges, shape (m,).

    """

    points: Floats
    slots: Ints
    parameters: Floats

    @cached_property
    def gradients(self) -> Floats:
        """See `Pairs.gradients`."""
        every = np.arange(len(self.points))
        gaps = gaps_over(self._variables(every, second=False), self.parameters)[1]
        return gaps.first.T.reshape(self.points.shape)[:, None]

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `Pairs.curvatures`."""
        loaded = np.flatnonzero(forces)
        second = gaps_over(self._variables(loaded, second=True), self.parameters[loaded])[1].second
        assert second is not None
        return loaded, np.moveaxis(forces[loaded] * second, -1, 0)

    def slides(self, points: Floats, before: Floats) -> Slides:  # noqa: ARG002 (the pairs know where they are)
        """See `Pairs.slides`."""
        now = self._variables(np.arange(len(self.points)), second=False)
        slips, directions = node_edge_slips(now, self.parameters, self._at_slots(before))
        at_points = (len(directions), 1, *self.points.shape[1:])
        return Slides(slips.value, slips.first.T.reshape(at_points), directions.reshape(at_points), self._turns)

    def _at_slots(self, points: Floats) -> Floats:
        """The node and the edge's nodes among points (m, w, 2) of each term, shape (m, order + 2, 2)."""
        return np.take_along_axis(points, self.slots[..., None], axis=1)

    def _turns(self, forces: Floats) -> tuple[Ints, Floats]:
        loaded = np.flatnonzero(forces)
        turns = node_edge_turns(self._variables(loaded, second=True), self.parameters[loaded])
        return loaded, forces[loaded, None, None] * turns

    def _variables(self, chosen: Ints, *, second: bool) -> Taylor:
        """Nodes and edges of some pairs (q,) by the positions of all their points, shape (q, order + 2)."""
        return Taylor.of_points(self.points[chosen], second=second, slots=self.slots[chosen])

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Pairs.opposite_points`."""
        shapes = shape_functions(edges.shape[1] - 1, self.parameters, 0)[0]
        points: Floats = np.einsum("na,nai->ni", shapes, edges[self.primary_edges])
        node = self.slots[:, 0] - self.secondary_members.shape[1]
        primary = node >= 0
        points[primary] = edges[self.primary_edges[primary], node[primary]]
        return points


def node_terms(
    contact_nodes: Ints, edges: tuple[Floats, Floats], nodes: Ints, faced: Ints, side: int = 0
) -> tuple[Floats, Ints, Ints, Ints]:
    """Points and slots of `NodePairs`, and their secondary and primary edges, each (m,).

    Of two edges that meet at a node the one of the higher number is taken.

    Parameters
    ----------
    contact_nodes
        `Surface.contact_places` of the nodes' own side.
    edges
        Positions of the nodes of both sides' edges, each (n_edges, order + 1, 2).
    nodes, faced
        Nodes, and edges of the other side, each (m,).
    side
        Side of the nodes: 0 for the secondary, 1 for the primary.

    """
    owner, column = np.zeros((2, contact_nodes.max() + 1), dtype=np.int64)
    for number in range(contact_nodes.shape[1]):
        owner[contact_nodes[:, number]] = np.arange(len(contact_nodes))
        column[contact_nodes[:, number]] = number
    secondary_edges, primary_edges = (owner[nodes], faced)[:: 1 - 2 * side]
    n_secondary, n_faced = edges[0].shape[1], edges[1 - side].shape[1]
    columns = np.arange(n_faced) + (1 - side) * n_secondary
    slots = np.column_stack((column[nodes] + side * n_secondary, np.tile(columns, (len(nodes), 1))))
    points = np.concatenate((edges[0][secondary_edges], edges[1][primary_edges]), axis=1)
    return points, slots, secondary_edges, primary_edges


@dataclass(frozen=True)
class NodeToSegment(Pairing):
    """Pair every secondary node with the primary edge it faces.

    Parameters
    ----------
    slack
        How far beyond its edge, in parts of the edge, a node stays paired with the edge it faced before. It prevents
        nodes from changing between two edges; within this width the answer depends on the path.

    """

    averages: ClassVar[bool] = False
    slack: float = FOOT_SLACK

    def __post_init__(self) -> None:
        if not (is_finite(self.slack) and 0.0 < self.slack <= OPEN_SLACK):
            raise InputError(f"NodeToSegment(slack={short(self.slack)})", f"0 < slack <= {OPEN_SLACK}", "leave it out")

    def pair(
        self,
        secondary: Surface,
        primary: Surface,
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,
        *,
        settle: bool = False,
    ) -> NodePairs:
        """See `Pairing.pair`; ``settle``: pairs are kept within `OPEN_SLACK` of their edge, not within ``slack``."""
        contact_nodes = secondary.contact_places
        given = positions[: len(secondary.nodes)], secondary.edge_places, primary_edges, kept
        nodes, faced, gaps = self.find(*given, primary.corners, settle=settle)
        points, slots, secondary_edges, _ = node_terms(
            contact_nodes, (positions[contact_nodes], primary_edges), nodes, faced
        )
        areas, rows = self.node_areas(secondary)[nodes], np.arange(len(nodes))[:, None]
        return NodePairs(
            nodes,
            faced,
            nodes,
            gaps.gaps,
            areas,
            areas,
            contact_nodes[secondary_edges],
            faced,
            rows,
            points,
            slots,
            gaps.parameters,
        )

    def find(
        self,
        positions: Floats,
        edge_places: Ints,
        primary_edges: Floats,
        kept: Ints,
        corners: Bools,
        *,
        settle: bool,
    ) -> tuple[Ints, Ints, NodeEdgeGaps]:
        """Nodes, the edges they face, and the gaps; else as `pair`.

        ``edge_places`` is the secondary surface's, ``corners`` the primary's `Surface.corners`.
        """
        stay = OPEN_SLACK if settle else self.slack
        at_end = np.where(corners, FOOT_SLACK, OPEN_SLACK)
        margins = np.stack((np.roll(at_end, 1), at_end), axis=1)
        normals, every = node_normals(positions, edge_places), np.arange(len(positions))
        given = positions, edge_places, primary_edges, every, normals, kept
        nodes, edges, gaps = facing_pairs(*given, stay, margins, OPEN_SLACK)
        reach = 2.0 * float(norms(chords_of(primary_edges)).mean())
        near = gaps.gaps < reach
        return nodes[near], edges[near], gaps.take(near)


def facing_pairs(
    positions: Floats, edge_places: Ints, edges: Floats, wanted: Ints, directions: Floats, kept: Ints, stay: float,
    margins: Floats, overhang: float, explained: Callable[[Ints, Ints], Floats] | None = None,
) -> tuple[Ints, Ints, NodeEdgeGaps]:  # fmt: skip
    """Nodes, of those wanted, that face an edge of another surface, those edges, and the gaps.

    The outward directions, and the edges that were ``kept`` (-1 for none), are those of all nodes. A node stays with
    the latter up to parts ``stay`` of the edge beyond it. An open one may be beyond any edge by ``overhang``; one
    behind an edge by the ``margins`` of its ends (n_edges, 2), unless it `leads_out`. With depths ``explained`` of
    nodes and edges only nodes that are deeper.
    """
    points, opposition = positions[wanted], pressing_cosines(positions, edge_places)[wanted]
    partners = nearest_edges(points, directions[wanted], edges, opposition)
    stays = kept[wanted] >= 0
    faced, outwards = edges[kept[wanted[stays]]], directions[wanted[stays]]
    chords = chords_of(faced)
    opposite = cross_product(chords, outwards) > opposition[stays] * norms(chords) * norms(outwards)
    stays[stays] = opposite & (np.abs(closest_parameters(points[stays], faced) - 0.5) <= 0.5 + stay)
    partners[stays] = kept[wanted[stays]]
    has_partner = partners >= 0
    nodes, partners = wanted[has_partner], partners[has_partner]
    gaps = node_edge_gaps(positions[nodes], edges[partners])
    beyond = margins[partners]
    beyond[gaps.gaps >= 0.0] = np.maximum(beyond[gaps.gaps >= 0.0], overhang)
    near = stays[has_partner] | ((gaps.parameters >= -beyond[:, 0]) & (gaps.parameters <= 1.0 + beyond[:, 1]))
    if explained is not None:
        near &= gaps.gaps < -explained(nodes, partners)
    behind = np.flatnonzero(near & (gaps.gaps < 0.0))
    vectors = -gaps.gaps[behind, None] * gaps.normals[behind]
    secondary_edges, on = positions[edge_places], (edge_places == nodes[behind, None, None]).any(axis=2)
    sizes = np.where(on, norms(chords_of(secondary_edges)), 0.0).max(axis=1)
    faced = partners[behind, None] == np.arange(len(edges))
    near[behind] = ~leads_out(positions[nodes[behind]], vectors, sizes, (secondary_edges, on), (edges, faced))
    return nodes[near], partners[near], gaps.take(near)


def guarded_margins(edges: Floats) -> Floats:
    """How far beyond the start and the end of each edge of a chain the foot of a guarded node behind it may lie.

    In parts of the edge, shape (n, 2): `CONCAVE_SLACK` at a concave joint, else `FOOT_SLACK`; beyond, the node is
    outside. Behind a joint of smooth curves, or of two edges that turn by so little that points as deep as an edge are
    within the latter, one edge has them.
    """
    slopes = derivative(edge_series(edges))
    turns = np.angle(np.roll(horner(slopes, 0.0), -1) / horner(slopes, 1.0))
    concave = (turns < -2.0 * FOOT_SLACK) & (edges[:, -1] == np.roll(edges[:, 0], -1, axis=0)).all(axis=1)
    at_end = np.where(concave, CONCAVE_SLACK, FOOT_SLACK)
    return np.stack((np.roll(at_end, 1), at_end), axis=1)


# --- Node-to-node contact: each node against the one opposite it, on boundaries whose nodes match.


MAX_MATCH_DISTANCE = 0.25
"""Distance along the primary of nodes that match, relative to the shorter edge there: on curves they are not quite
opposite each other."""


@dataclass(frozen=True, eq=False)
class MatchingNodes:
    """Nodes of two surfaces that are opposite each other before the deformation; n of them.

    Parameters
    ----------
    nodes
        Positions in `Surface.nodes` of the secondary, shape (n,).
    edges, columns
        Primary edge with the opposite node, and which of the edge's nodes it is, each (n,).
    lengths
        Length of the secondary that belongs to each, where the primary faces it, shape (n,).
    normals
        Mean of the surfaces' normals, out of the primary, shape (n, 2).

    """

    nodes: Ints
    edges: Ints
    columns: Ints
    lengths: Floats
    normals: Floats


@dataclass(frozen=True, eq=False)
class MatchedPairs(NodePairs):
    """Nodes and the nodes opposite them: gaps along the normals before the deformation, which turn with the primary.

    Parameters
    ----------
    normals
        The normals now, shape (n, 2).
    opposite
        The node opposite each among the points of its term, shape (n,).
    shifts
        Distance along the surface of each node from the one opposite it, in the mesh's unit of length, shape (n,).
    longest
        Longest edge at each node, shape (n,).

    """

    normals: Floats
    opposite: Ints
    shifts: Floats
    longest: Floats

    @cached_property
    def gradients(self) -> Floats:
        """See `Pairs.gradients`."""
        return self._apart(self.normals)

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `Pairs.curvatures`: none."""
        loaded = np.flatnonzero(forces)
        n_local = 2 * self.points.shape[1]
        return loaded, np.zeros((len(loaded), n_local, n_local))

    def slides(self, points: Floats, before: Floats) -> Slides:
        """See `Pairs.slides`."""
        gradients = self._apart(-turned_right(self.normals))
        slips = np.einsum("npi,npi->n", gradients[:, 0], points - before)
        return Slides(slips, gradients, gradients, self.curvatures)

    def _apart(self, directions: Floats) -> Floats:
        """Derivatives of the distances of nodes from those opposite them along directions (n, 2)."""
        result, rows = np.zeros((len(directions), 1, *self.points.shape[1:])), np.arange(len(directions))
        result[rows, 0, self.slots[:, 0]], result[rows, 0, self.opposite] = directions, -directions
        return result


_matched: WeakKeyDictionary[Surface, tuple[Surface, MatchingNodes]] = WeakKeyDictionary()


@dataclass(frozen=True)
class NodeToNode(Pairing):
    """Pair every secondary node with the primary node opposite it before the deformation.

    The boundaries must match where they are opposite each other: `flangeway.mesh.match_boundaries` gives polygons of
    both bodies the nodes of the other one. Pairs never change and gaps are linear in the displacements, which must be
    small: sliding far below the edges; `press` has not converged where it is above half of one. A node's area is the
    integral of its shape function along the surface, which is positive for every order (trapezoids for order 1,
    Simpson's rule for order 2): a uniform pressure is exact.

    Gaps are taken along the mean of both surfaces' normals before the deformation. These turn with the chord of the
    primary surface, so that bodies may turn together; what a change of that turn does to the gap is of second order and
    left out of the derivatives.
    """

    averages: ClassVar[bool] = False

    def pair(
        self,
        secondary: Surface,
        primary: Surface,
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,  # noqa: ARG002 (pairs never change)
        *,
        settle: bool = False,  # noqa: ARG002
    ) -> MatchedPairs:
        """See `Pairing.pair`. An `InputError` if the boundaries do not match."""
        matching, contact_nodes = matching_nodes(secondary, primary), secondary.contact_places
        ends = primary.placed_nodes[primary.ends]
        turn = _chord(primary_edges[:, [0, -1]]) / _chord(ends)
        turned = (matching.normals @ np.array([1.0, 1j])) * turn / abs(turn)
        normals = np.column_stack((turned.real, turned.imag))
        apart = positions[matching.nodes] - primary_edges[matching.edges, matching.columns]
        gaps = np.einsum("ni,ni->n", normals, apart)
        areas, whole = matching.lengths * secondary.part.body.depth, self.node_areas(secondary)[matching.nodes]
        longest = np.zeros(len(secondary.nodes))
        for column in secondary.edge_places.T:
            np.maximum.at(longest, column, secondary.edge_lengths)
        points, slots, secondary_edges, _ = node_terms(
            contact_nodes, (positions[contact_nodes], primary_edges), matching.nodes, matching.edges
        )
        parameters = gauss_lobatto(primary_edges.shape[1])[0][matching.columns]
        members, rows = contact_nodes[secondary_edges], np.arange(len(gaps))
        return MatchedPairs(
            matching.nodes, matching.edges, matching.nodes, gaps, areas, whole, members, matching.edges, rows[:, None],
            points, slots, parameters, normals, slots[rows, 1 + matching.columns],
            np.abs(cross_product(normals, apart)), longest[matching.nodes],
        )  # fmt: skip


def _chord(edges: Floats) -> complex:
    """From the first node of edges in a chain (n, 2, 2) to the last one, or to that half of the way along a ring."""
    start, end = edges[0, 0], edges[-1, 1]
    if np.hypot(*(end - start)) < 1e-6 * float(np.ptp(edges, axis=(0, 1)).max()):
        end = edges[len(edges) // 2, 0]
    return complex(*(end - start))


def matching_nodes(secondary: Surface, primary: Surface) -> MatchingNodes:
    """Nodes of two surfaces that are opposite each other, by the edges of the meshes before the deformation.

    An `InputError` if the surfaces are nowhere opposite each other, or their nodes do not match.
    """
    known = _matched.get(secondary)
    if known is None or known[0] is not primary:
        known = _matched[secondary] = primary, _found(secondary, primary)
    return known[1]


def _found(secondary: Surface, primary: Surface) -> MatchingNodes:
    names = f"contact of {secondary.part.name!r} on {primary.part.name!r} by NodeToNode"
    if secondary.edge_nodes.shape[1] != primary.edge_nodes.shape[1]:
        orders = [side.edge_nodes.shape[1] - 1 for side in (secondary, primary)]
        raise InputError(
            f"{names} with elements of order {orders[0]} and {orders[1]}",
            "one order on both sides: nodes of the edges match",
            "take elements of one order, or SegmentToSegment",
        )
    points = [side.placed_nodes for side in (secondary, primary)]
    ends = [side.ends for side in (secondary, primary)]
    _, onto = opposite_places((points[0], ends[0]), (points[1], ends[1]))
    near = onto.away <= MAX_MATCH_DISTANCE
    partner = np.full(len(points[0]), -1)
    partner[onto.points[near]] = onto.nearest[near]
    start, end = partner[ends[0]].T
    keys, wanted = ends[1][:, 0] * len(points[1]) + ends[1][:, 1], end * len(points[1]) + start
    edges, met = places_in(keys, wanted)
    paired = met & (start >= 0) & (end >= 0)
    missing = onto.points[~near]
    if not len(missing):
        missing = ends[0][(start >= 0) & (end >= 0) & ~paired, 0]
    if len(missing) or not paired.any():
        at = points[0][missing[0] if len(missing) else ends[0][0, 0]]
        raise InputError(
            f"{names}: no node is opposite the one at {point_text(at)}" if len(missing) else f"{names}: no edges match",
            "boundaries whose nodes are opposite each other before the deformation",
            "give both meshes each other's nodes by flangeway.mesh.match_boundaries, or take SegmentToSegment",
        )
    nodes_of_edges, opposite_nodes = secondary.edge_places[paired], np.flip(primary.edge_places[edges[paired]], axis=1)
    width = nodes_of_edges.shape[1]
    lengths = sums_at(nodes_of_edges, secondary.edge_shares[paired], len(points[0]))
    nodes, first = np.unique(nodes_of_edges, return_index=True)
    at_edge, column = edges[paired][first // width], width - 1 - first % width
    shifted = [
        side.part.placement.points(side.part.body.nodes[side.nodes] + side.shifts) for side in (secondary, primary)
    ]
    normals = [_normals(*pair) for pair in zip(shifted, (secondary, primary), strict=True)]
    mean = normals[1][opposite_nodes.ravel()[first]] - normals[0][nodes]
    at_edge = at_edge.astype(np.int64)
    column = column if primary.bends is None else 2 * column  # the middles of edges with bends are between
    return MatchingNodes(nodes, at_edge, column, lengths[nodes], units_of(mean))


def _normals(points: Floats, surface: Surface) -> Floats:
    """Normals at the nodes of a surface, at points (n, 2), out of its body: on a circle the circle's."""
    ends = np.stack((surface.edge_places[:, :-1].ravel(), surface.edge_places[:, 1:].ravel()))
    chords = points[ends[1]] - points[ends[0]]
    of_edges = turned_right(chords) / (chords**2).sum(axis=1)[:, None]
    return units_of(sums_at(ends, np.stack((of_edges, of_edges)), len(points)))
