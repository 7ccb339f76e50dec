"""Node-to-segment contact: each secondary node against one primary edge (Moherdaui 2021, 3.5)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flangeway.checks import is_finite
from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, node_edge_gaps, shape_functions
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.search import leads_out, nearest_edges
from flangeway.contact.slip import Slides, node_edge_slides
from flangeway.contact.surface import COLLINEAR, Surface, node_normals, turns_of
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
    kinematics
        Gaps of the nodes over the edges, and their derivatives.
    slots
        The node, then the edge's nodes, among the points of the term, shape (m, order + 2).
    width
        Number of the term's points.

    """

    kinematics: NodeEdgeGaps
    slots: Ints
    width: int

    @property
    def gradients(self) -> Floats:
        """See `Pairs.gradients`."""
        return self._on_points(self.kinematics.gradients)

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `Pairs.curvatures`."""
        return self._on_terms(forces, self.kinematics.hessians)

    def slides(self, points: Floats, before: Floats) -> Slides:
        """See `Pairs.slides`."""
        each = np.arange(len(self.slots))[:, None]
        now, was = points[each, self.slots], before[each, self.slots]
        given = now[:, 0], now[:, 1:], self.kinematics.parameters, was[:, 0], was[:, 1:]
        slips, *by_points, turns = node_edge_slides(*given)
        rates, directions = (self._on_points(found.reshape(*self.slots.shape, 2)) for found in by_points)
        return Slides(slips, rates, directions, lambda forces: self._on_terms(forces, turns))

    def _on_points(self, gradients: Floats) -> Floats:
        """Derivatives by the node and the edge's nodes (m, order + 2, 2) as those by the term's points."""
        result = np.zeros((len(self.slots), self.width, 2))
        np.put_along_axis(result, self.slots[:, :, None], gradients, axis=1)
        return result[:, None]

    def _on_terms(self, forces: Floats, hessians: Floats) -> tuple[Ints, Floats]:
        """Terms under load, and second derivatives by the node and the edge's nodes as those by the term's points."""
        loaded = np.flatnonzero(forces)
        dofs = (2 * self.slots[loaded][:, :, None] + np.arange(2)).reshape(len(loaded), 2 * self.slots.shape[1])
        result = np.zeros((len(loaded), 2 * self.width, 2 * self.width))
        each = np.arange(len(loaded))[:, None, None]
        result[each, dofs[:, :, None], dofs[:, None, :]] = hessians[loaded]
        return loaded, forces[loaded, None, None] * result

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Pairs.opposite_points`."""
        shapes = shape_functions(edges.shape[1] - 1, self.kinematics.parameters, 0)[0]
        points: Floats = np.einsum("na,nai->ni", shapes, edges[self.primary_edges])
        node = self.slots[:, 0] - self.secondary_members.shape[1]
        primary = node >= 0
        points[primary] = edges[self.primary_edges[primary], node[primary]]
        return points


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
        positions = positions[: len(secondary.nodes)]
        given = positions, secondary.edge_places, primary_edges, kept
        nodes, edges, kinematics = self.find(*given, primary.corners, settle=settle)
        areas, width = self.node_areas(secondary)[nodes], 1 + primary_edges.shape[1]
        slots = np.broadcast_to(np.arange(width), (len(nodes), width))
        each = np.arange(len(nodes))[:, None]
        return NodePairs(
            nodes, edges, nodes, kinematics.gaps, areas, areas, nodes[:, None], edges, each, kinematics, slots, width
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
        """Nodes, the edges they face, and their gaps; else as `pair`.

        ``edge_places`` is the secondary surface's, ``corners`` the primary's `Surface.corners` (left out: none).
        """
        stay = OVERHANG if settle else self.slack
        corners = np.zeros(len(primary_edges), dtype=np.bool_) if corners is None else corners
        at_end = np.where(corners, SLACK, OVERHANG)
        margins = np.stack((np.roll(at_end, 1), at_end), axis=1)
        smooth = ~corners & (primary_edges[:, -1] == np.roll(primary_edges[:, 0], -1, axis=0)).all(axis=1)
        normals, every = node_normals(positions, edge_places), np.arange(len(positions))
        given = positions, edge_places, primary_edges, every, normals, kept
        nodes, edges, gaps = facing_pairs(*given, stay, margins, OVERHANG, smooth)
        reach = 2.0 * float(np.linalg.norm(primary_edges[:, -1] - primary_edges[:, 0], axis=1).mean())
        near = gaps.gaps < reach
        return nodes[near], edges[near], gaps.take(near)


def facing_pairs(
    positions: Floats, edge_places: Ints, edges: Floats, wanted: Ints, directions: Floats, kept: Ints, stay: float,
    margins: Floats, overhang: float, smooth: Bools,
) -> tuple[Ints, Ints, NodeEdgeGaps]:  # fmt: skip
    """Nodes, of those wanted, that face an edge of another surface, those edges, and their gaps.

    The outward directions, and the edges that were ``kept`` (-1 for none), are those of all nodes. A node stays with
    the latter up to parts ``stay`` of the edge beyond it. An open one may be beyond any edge by ``overhang``; one
    behind an edge by the ``margins`` of its ends (n_edges, 2), if the way to it crosses no other edge than the next one
    at a ``smooth`` joint, shape (n_edges,).
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
    feet = gaps.parameters
    near = stays[found] | ((feet >= -beyond[:, 0]) & (feet <= 1.0 + beyond[:, 1]))
    behind = np.flatnonzero(near & (gaps.gaps < 0.0))
    vectors = -gaps.gaps[behind, None] * gaps.normals[behind]
    own, on = positions[edge_places], (edge_places == nodes[behind, None, None]).any(axis=2)
    sizes = np.where(on, np.linalg.norm(own[:, -1] - own[:, 0], axis=1), 0.0).max(axis=1)
    each, at = np.arange(len(edges)), partners[behind, None]
    its = (at == each) | (np.roll(smooth, 1) & (at == np.roll(each, 1))) | (smooth & (at == np.roll(each, -1)))
    near[behind] = ~leads_out(positions[nodes[behind]], vectors, sizes, (own, on), (edges, its))
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
