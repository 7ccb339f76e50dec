"""Node-to-segment contact: each secondary node against one primary edge (Moherdaui 2021, 3.5)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flangeway.checks import is_finite
from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, gaps_over, node_edge_gaps, shape_functions
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.search import leads_out, nearest_edges
from flangeway.contact.slip import Slides, node_edge_slips, node_edge_turns
from flangeway.contact.surface import COLLINEAR, Surface, node_normals, turns_of
from flangeway.contact.taylor import Taylor
from flangeway.errors import InputError, short
from flangeway.types import Bools, Floats, Ints

SLACK, OVERHANG = 1e-3, 0.1
"""Parts of an edge beyond its ends within which the foot of a node behind it may be, and that of an open node: the
latter bridges the dead angle at convex corners, where an open node is beyond the ends of both edges."""
CONCAVE = 0.5
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
        was = np.take_along_axis(before, self.slots[..., None], axis=1)
        slips, directions = node_edge_slips(now, self.parameters, was)
        at_points = (len(directions), 1, *self.points.shape[1:])
        return Slides(slips.value, slips.first.T.reshape(at_points), directions.reshape(at_points), self._turns)

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
    places: Ints, edges: tuple[Floats, Floats], nodes: Ints, faced: Ints, side: int = 0
) -> tuple[Floats, Ints, Ints, Ints]:
    """Points and slots of `NodePairs`, and their secondary and primary edges, each (m,).

    Of two edges that meet at a node the one of the higher number is taken.

    Parameters
    ----------
    places
        `Surface.contact_places` of the nodes' own side.
    edges
        Positions of the nodes of both sides' edges, each (n_edges, order + 1, 2).
    nodes, faced
        Nodes, and edges of the other side, each (m,).
    side
        Side of the nodes: 0 for the secondary, 1 for the primary.

    """
    owner, column = np.zeros((2, places.max() + 1), dtype=np.int64)
    for number in range(places.shape[1]):
        owner[places[:, number]] = np.arange(len(places))
        column[places[:, number]] = number
    secondary_edges, primary_edges = (owner[nodes], faced)[:: 1 - 2 * side]
    n_secondary, n_faced = edges[0].shape[1], edges[1 - side].shape[1]
    its = np.arange(n_faced) + (1 - side) * n_secondary
    slots = np.column_stack((column[nodes] + side * n_secondary, np.tile(its, (len(nodes), 1))))
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
    slack: float = SLACK

    def __post_init__(self) -> None:
        if not (is_finite(self.slack) and 0.0 < self.slack <= OVERHANG):
            raise InputError(f"NodeToSegment(slack={short(self.slack)})", f"0 < slack <= {OVERHANG}", "leave it out")

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
        """See `Pairing.pair`; ``settle``: pairs are kept within `OVERHANG` of their edge, not within ``slack``."""
        places = secondary.contact_places
        given = positions[: len(secondary.nodes)], secondary.edge_places, primary_edges, kept
        nodes, faced, found = self.find(*given, primary.corners, settle=settle)
        points, slots, own, _ = node_terms(places, (positions[places], primary_edges), nodes, faced)
        areas, rows = self.node_areas(secondary)[nodes], np.arange(len(nodes))[:, None]
        return NodePairs(
            nodes, faced, nodes, found.gaps, areas, areas, places[own], faced, rows, points, slots, found.parameters
        )

    def find(
        self,
        positions: Floats,
        edge_places: Ints,
        primary_edges: Floats,
        kept: Ints,
        corners: Bools | None = None,
        *,
        settle: bool = False,
    ) -> tuple[Ints, Ints, NodeEdgeGaps]:
        """Nodes, the edges they face, and the gaps; else as `pair`.

        ``edge_places`` is the secondary surface's, ``corners`` the primary's `Surface.corners` (left out: none).
        """
        stay = OVERHANG if settle else self.slack
        corners = np.zeros(len(primary_edges), dtype=np.bool_) if corners is None else corners
        at_end = np.where(corners, SLACK, OVERHANG)
        margins = np.stack((np.roll(at_end, 1), at_end), axis=1)
        normals, every = node_normals(positions, edge_places), np.arange(len(positions))
        given = positions, edge_places, primary_edges, every, normals, kept
        nodes, edges, gaps = facing_pairs(*given, stay, margins, OVERHANG)
        reach = 2.0 * float(np.linalg.norm(primary_edges[:, -1] - primary_edges[:, 0], axis=1).mean())
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
    points = positions[wanted]
    partners = nearest_edges(points, directions[wanted], edges)
    stays = kept[wanted] >= 0
    stays[stays] = np.abs(closest_parameters(points[stays], edges[kept[wanted[stays]]]) - 0.5) <= 0.5 + stay
    partners[stays] = kept[wanted[stays]]
    found = partners >= 0
    nodes, partners = wanted[found], partners[found]
    gaps = node_edge_gaps(positions[nodes], edges[partners])
    beyond = margins[partners]
    beyond[gaps.gaps >= 0.0] = np.maximum(beyond[gaps.gaps >= 0.0], overhang)
    near = stays[found] | ((gaps.parameters >= -beyond[:, 0]) & (gaps.parameters <= 1.0 + beyond[:, 1]))
    if explained is not None:
        near &= gaps.gaps < -explained(nodes, partners)
    behind = np.flatnonzero(near & (gaps.gaps < 0.0))
    vectors = -gaps.gaps[behind, None] * gaps.normals[behind]
    own, on = positions[edge_places], (edge_places == nodes[behind, None, None]).any(axis=2)
    sizes = np.where(on, np.linalg.norm(own[:, -1] - own[:, 0], axis=1), 0.0).max(axis=1)
    faced = partners[behind, None] == np.arange(len(edges))
    near[behind] = ~leads_out(positions[nodes[behind]], vectors, sizes, (own, on), (edges, faced))
    return nodes[near], partners[near], gaps.take(near)


def guarded_margins(edges: Floats) -> Floats:
    """How far beyond the start and the end of each edge of a chain the foot of a guarded node behind it may lie.

    In parts of the edge, shape (n, 2): `CONCAVE` at a concave joint, else `SLACK`, beyond which the node is outside.
    """
    ends = edges[:, [0, -1]]
    turns = turns_of(ends, np.roll(np.arange(len(ends)), -1))
    concave = (turns < -COLLINEAR) & (ends[:, 1] == np.roll(ends[:, 0], -1, axis=0)).all(axis=1)
    at_end = np.where(concave, CONCAVE, SLACK)
    return np.stack((np.roll(at_end, 1), at_end), axis=1)
