"""Node-to-segment contact: each secondary node against one primary edge (Moherdaui 2021, 3.5)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flangeway.checks import are_finite, check_positive
from flangeway.contact.edge_shapes import shape_functions
from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, node_edge_gaps
from flangeway.contact.pairs import Pairing
from flangeway.contact.search import has_node, leads_out, nearest_edges
from flangeway.contact.surface import Surface, node_normals
from flangeway.errors import InputError, short
from flangeway.types import Floats, Ints


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
        How far beyond the nearest edge, in parts of the edge, a foot may lie. It bridges the dead angle at convex
        corners, where an open node is beyond the ends of both its edges.

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
        partner = nearest_edges(positions, node_normals(positions, edge_places), primary_edges)
        before = np.flatnonzero(kept >= 0)
        parameters = closest_parameters(positions[before], primary_edges[kept[before]])
        stays = before[_within(parameters, self.overhang if settle else self.slack)]
        partner[stays] = kept[stays]

        nodes = np.flatnonzero(partner >= 0)
        kinematics = node_edge_gaps(positions[nodes], primary_edges[partner[nodes]])
        chords = primary_edges[:, -1] - primary_edges[:, 0]
        reach = self.reach or 2.0 * float(np.linalg.norm(chords, axis=1).mean())
        near = _within(kinematics.parameters, self.overhang) & (kinematics.gaps < reach)
        behind = np.flatnonzero(near & (kinematics.gaps < 0.0))
        ways = -kinematics.gaps[behind, None] * kinematics.normals[behind]
        near[behind] = ~leads_out(
            positions[nodes[behind]], ways, positions[edge_places], has_node(edge_places, nodes[behind])
        )
        return nodes[near], partner[nodes[near]], kinematics.take(near)


def _within(parameters: Floats, margin: float) -> NDArray[np.bool_]:
    return (parameters >= -margin) & (parameters <= 1.0 + margin)
