"""Node-to-node contact: each node against the one opposite it, on boundaries whose nodes match."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar
from weakref import WeakKeyDictionary

import numpy as np

from flangeway.contact.node_to_segment import NodePairs, node_terms
from flangeway.contact.pairs import Pairing
from flangeway.contact.slip import Slides
from flangeway.contact.surface import Surface
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError
from flangeway.geometry.arrays import cross_product, point_text, turned_right
from flangeway.mesh.insertion import opposite_places
from flangeway.types import Floats, Ints

NEAR = 0.25
"""Distance along the primary of nodes that match, over the shorter edge there: on curves they are not quite opposite
each other."""


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
        result, each = np.zeros((len(directions), 1, *self.points.shape[1:])), np.arange(len(directions))
        result[each, 0, self.slots[:, 0]], result[each, 0, self.opposite] = directions, -directions
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
        found, places = matching_nodes(secondary, primary), secondary.contact_places
        ends = primary.part.placement.points(primary.part.body.nodes[primary.nodes])[primary.edge_places[:, [0, -1]]]
        turn = _chord(primary_edges[:, [0, -1]]) / _chord(ends)
        turned = (found.normals @ np.array([1.0, 1j])) * turn / abs(turn)
        normals = np.column_stack((turned.real, turned.imag))
        apart = positions[found.nodes] - primary_edges[found.edges, found.columns]
        gaps = np.einsum("ni,ni->n", normals, apart)
        areas, whole = found.lengths * secondary.part.body.depth, self.node_areas(secondary)[found.nodes]
        longest = np.zeros(len(secondary.nodes))
        for column in secondary.edge_places.T:
            np.maximum.at(longest, column, secondary.edge_lengths)
        points, slots, own, _ = node_terms(places, (positions[places], primary_edges), found.nodes, found.edges)
        parameters = gauss_lobatto(primary_edges.shape[1])[0][found.columns]
        members, each = places[own], np.arange(len(gaps))
        return MatchedPairs(
            found.nodes, found.edges, found.nodes, gaps, areas, whole, members, found.edges, each[:, None], points,
            slots, parameters, normals, slots[each, 1 + found.columns], np.abs(cross_product(normals, apart)),
            longest[found.nodes],
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
    points = [side.part.placement.points(side.part.body.nodes[side.nodes]) for side in (secondary, primary)]
    ends = [side.edge_places[:, [0, -1]] for side in (secondary, primary)]
    _, onto = opposite_places((points[0], ends[0]), (points[1], ends[1]))
    near = onto.away <= NEAR
    partner = np.full(len(points[0]), -1)
    partner[onto.points[near]] = onto.nearest[near]
    start, end = partner[ends[0]].T
    keys, wanted = ends[1][:, 0] * len(points[1]) + ends[1][:, 1], end * len(points[1]) + start
    order = np.argsort(keys)
    edges = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)]
    paired = (keys[edges] == wanted) & (start >= 0) & (end >= 0)
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
    mine, theirs = secondary.edge_places[paired], np.flip(primary.edge_places[edges[paired]], axis=1)
    width = mine.shape[1]
    lengths = np.zeros(len(points[0]))
    np.add.at(lengths, mine, secondary.edge_shares[paired])
    nodes, first = np.unique(mine, return_index=True)
    at_edge, column = edges[paired][first // width], width - 1 - first % width
    shifted = [
        side.part.placement.points(side.part.body.nodes[side.nodes] + side.shifts) for side in (secondary, primary)
    ]
    normals = [_normals(*each) for each in zip(shifted, (secondary, primary), strict=True)]
    mean = normals[1][theirs.ravel()[first]] - normals[0][nodes]
    at_edge = at_edge.astype(np.int64)
    column = column if primary.bends is None else 2 * column  # the middles of edges with bends are between
    return MatchingNodes(nodes, at_edge, column, lengths[nodes], mean / np.hypot(*mean.T)[:, None])


def _normals(points: Floats, surface: Surface) -> Floats:
    """Normals at the nodes of a surface, at points (n, 2), out of its body: on a circle the circle's."""
    pairs = np.stack((surface.edge_places[:, :-1].ravel(), surface.edge_places[:, 1:].ravel()))
    chords = points[pairs[1]] - points[pairs[0]]
    normals = np.zeros_like(points)
    for ends in pairs:
        np.add.at(normals, ends, turned_right(chords) / (chords**2).sum(axis=1)[:, None])
    return normals / np.hypot(*normals.T)[:, None]
