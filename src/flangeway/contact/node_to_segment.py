"""Node-to-segment contact: each secondary node against one primary edge (Moherdaui 2021, 3.5)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flangeway.checks import are_finite, check_positive
from flangeway.contact.edge_shapes import shape_functions
from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, node_edge_gaps
from flangeway.contact.pairs import Pairing
from flangeway.contact.search import leads_out, nearest_edges
from flangeway.contact.surface import Surface, node_normals
from flangeway.errors import InputError, short
from flangeway.types import Floats, Ints

SLACK = 1e-3
"""Parts of an edge beyond its ends within which a node behind it may be."""
HOLLOW = 0.5
"""The same at a joint that is hollow, behind which points are beyond the ends of both edges."""
HARDLY = 1e-6
"""Turn of a joint that is straight but for round-off."""


@dataclass(frozen=True, eq=False)
class NodePairs:
    """Secondary nodes and the primary edges that they face: a constraint each; see `flangeway.contact.pairs.Pairs`.

    Parameters
    ----------
    nodes
        Places of the nodes in the secondary surface, shape (m,).
    primary_edges
        Numbers of the edges in the primary surface, shape (m,).
    areas
        Areas of the nodes, shape (m,).
    kinematics
        Gaps and their derivatives.

    """

    nodes: Ints
    primary_edges: Ints
    areas: Floats
    kinematics: NodeEdgeGaps

    @property
    def keys(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.keys`."""
        return self.nodes

    @property
    def guarded(self) -> NDArray[np.bool_]:
        """See `flangeway.contact.pairs.Pairs.guarded`."""
        return np.zeros(len(self.keys), dtype=np.bool_)

    @property
    def partners(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.partners`."""
        return self.primary_edges

    @property
    def gaps(self) -> Floats:
        """See `flangeway.contact.pairs.Pairs.gaps`."""
        return self.kinematics.gaps

    @property
    def whole_areas(self) -> Floats:
        """See `flangeway.contact.pairs.Pairs.whole_areas`."""
        return self.areas

    @property
    def secondary_members(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.secondary_members`."""
        return self.nodes[:, None]

    @property
    def rows(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.rows`."""
        return np.arange(len(self.nodes))[:, None]

    @property
    def gradients(self) -> Floats:
        """See `flangeway.contact.pairs.Pairs.gradients`."""
        return self.kinematics.gradients[:, None]

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `flangeway.contact.pairs.Pairs.curvatures`."""
        loaded = np.flatnonzero(forces)
        return loaded, forces[loaded, None, None] * self.kinematics.hessians[loaded]

    def opposite_points(self, edges: Floats) -> Floats:
        """See `flangeway.contact.pairs.Pairs.opposite_points`."""
        shapes = shape_functions(edges.shape[1] - 1, self.kinematics.parameters, 0)[0]
        points: Floats = np.einsum("na,nai->ni", shapes, edges[self.primary_edges])
        return points


@dataclass(frozen=True)
class NodeToSegment(Pairing):
    """Pair every secondary node with the primary edge it faces.

    Parameters
    ----------
    reach
        Nodes whose gap is larger take no part; None: twice the mean length of the primary edges. It must exceed the
        gaps that an iteration can close.
    slack
        How far beyond its edge, in parts of the edge, a node stays with the edge it faced before. It stops nodes from
        hopping between two edges; it also is the width within which the answer depends on the path to it.
    overhang
        How far beyond the nearest edge, in parts of the edge, the foot of an open node may lie, and that of any node
        where the surface ends. It bridges the dead angle at convex corners, where an open node is beyond the ends of
        both its edges.

    """

    averages: ClassVar[bool] = False
    reach: float | None = None
    slack: float = 1e-3
    overhang: float = 0.1

    def __post_init__(self) -> None:
        if self.reach is not None:
            check_positive("NodeToSegment", "reach", self.reach, "a positive length or None", "leave it out")
        widths = self.slack, self.overhang
        if not (are_finite(widths, 2) and 0.0 < widths[0] <= widths[1] < 0.5):
            raise InputError(
                f"NodeToSegment(slack={short(self.slack)}, overhang={short(self.overhang)})",
                "0 < slack <= overhang < 0.5",
                "leave them out",
            )

    def node_areas(self, secondary: Surface) -> Floats:
        """See `Pairing.node_areas`."""
        return secondary.tributary_lengths * secondary.part.body.thickness

    def key_nodes(self, secondary: Surface) -> Ints:
        """See `Pairing.key_nodes`."""
        return np.arange(len(secondary.nodes))

    def pair(
        self,
        secondary: Surface,
        primary: Surface,  # noqa: ARG002 (its edges are enough)
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,
        *,
        settle: bool = False,
    ) -> NodePairs:
        """See `Pairing.pair`; ``settle``: pairs are kept within ``overhang`` of their edge, not within ``slack``."""
        positions = positions[: len(secondary.nodes)]
        nodes, edges, kinematics = self.find(positions, secondary.edge_places, primary_edges, kept, settle=settle)
        return NodePairs(nodes, edges, self.node_areas(secondary)[nodes], kinematics)

    def find(
        self, positions: Floats, edge_places: Ints, primary_edges: Floats, kept: Ints, *, settle: bool = False
    ) -> tuple[Ints, Ints, NodeEdgeGaps]:
        """Nodes, the edges they face, and their gaps; ``edge_places`` is the secondary surface's, else as `pair`."""
        stay = self.overhang if settle else self.slack
        normals, every = node_normals(positions, edge_places), np.arange(len(positions))
        given = positions, edge_places, primary_edges, every, normals, kept
        nodes, edges, gaps = facing_pairs(*given, stay, self.overhang)
        reach = self.reach or 2.0 * float(np.linalg.norm(primary_edges[:, -1] - primary_edges[:, 0], axis=1).mean())
        near = gaps.gaps < reach
        return nodes[near], edges[near], gaps.take(near)


def facing_pairs(
    positions: Floats, edge_places: Ints, edges: Floats, wanted: Ints, directions: Floats, kept: Ints, stay: float,
    overhang: float,
) -> tuple[Ints, Ints, NodeEdgeGaps]:  # fmt: skip
    """Nodes, of those wanted, that face an edge of another surface, those edges, and their gaps.

    Directions (outwards) and the edges that were ``kept``, -1 for none, are those of all nodes. A node stays with the
    latter up to parts ``stay`` of the edge beyond it. An open one may be beyond any edge by ``overhang``; one behind an
    edge, see `margins_of`.
    """
    points = positions[wanted]
    partners = nearest_edges(points, directions[wanted], edges)
    stays = kept[wanted] >= 0
    stays[stays] = np.abs(closest_parameters(points[stays], edges[kept[wanted[stays]]]) - 0.5) <= 0.5 + stay
    partners[stays] = kept[wanted[stays]]
    found = partners >= 0
    nodes, partners = wanted[found], partners[found]
    gaps = node_edge_gaps(positions[nodes], edges[partners])
    margins = margins_of(edges, overhang)[partners]
    margins[gaps.gaps >= 0.0] = np.maximum(margins[gaps.gaps >= 0.0], overhang)
    near = stays[found] | within(gaps.parameters, margins)
    behind = np.flatnonzero(near & (gaps.gaps < 0.0))
    ways = -gaps.gaps[behind, None] * gaps.normals[behind]
    own, on = positions[edge_places], (edge_places == nodes[behind, None, None]).any(axis=2)
    sizes = np.where(on, np.linalg.norm(own[:, -1] - own[:, 0], axis=1), 0.0).max(axis=1)
    its = edges, partners[behind, None] == np.arange(len(edges))
    near[behind] = ~leads_out(positions[nodes[behind]], ways, sizes, (own, on), its)
    return nodes[near], partners[near], gaps.take(near)


def margins_of(edges: Floats, overhang: float) -> Floats:
    """How far beyond the start and the end of each edge of a chain the foot of a point behind it may lie.

    In parts of the edge, shape (n, 2): hardly at a corner, beyond which the point is outside; far at a hollow joint;
    ``overhang`` where the chain ends.
    """
    following = np.roll(edges, -1, axis=0)
    into, out = edges[:, -1] - edges[:, 0], following[:, -1] - following[:, 0]
    hollow = np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(axis=1)) < -HARDLY
    meets = (edges[:, -1] == following[:, 0]).all(axis=1)
    at_end = np.where(meets, np.where(hollow, HOLLOW, SLACK), overhang)
    return np.stack((np.roll(at_end, 1), at_end), axis=1)


def within(parameters: Floats, margins: Floats) -> NDArray[np.bool_]:
    """Whether feet are on their edges, or beyond them by margins (n, 2) at most."""
    return (parameters >= -margins[:, 0]) & (parameters <= 1.0 + margins[:, 1])
