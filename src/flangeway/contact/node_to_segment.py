"""Node-to-segment contact: each secondary node against one primary edge (seed 3.5)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, node_edge_gaps
from flangeway.contact.search import nearest_edges
from flangeway.contact.surface import node_normals
from flangeway.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NodePairs:
    """Secondary nodes and the primary edges that they face, with their gaps.

    Parameters
    ----------
    nodes
        Places of the nodes in the secondary surface, shape (m,).
    edges
        Numbers of the edges in the primary surface, shape (m,).
    kinematics
        Gaps and their derivatives.

    """

    nodes: Ints
    edges: Ints
    kinematics: NodeEdgeGaps


@dataclass(frozen=True)
class NodeToSegment:
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

    reach: float | None = None
    slack: float = 1e-3
    overhang: float = 0.1

    def __post_init__(self) -> None:
        if self.reach is not None and not self.reach > 0.0:
            raise InputError(f"NodeToSegment(reach={self.reach})", "a positive length or None", "leave it out")
        if not 0.0 < self.slack <= self.overhang < 0.5:
            raise InputError(
                f"NodeToSegment(slack={self.slack}, overhang={self.overhang})",
                "0 < slack <= overhang < 0.5",
                "leave them out",
            )

    def pair(
        self,
        secondary: Floats,
        secondary_places: Ints,
        primary_edges: Floats,
        kept: Ints,
    ) -> NodePairs:
        """Find the pairs within reach.

        Parameters
        ----------
        secondary
            Positions of the secondary nodes, shape (n_nodes, 2).
        secondary_places
            The secondary surface's `edge_places`.
        primary_edges
            Positions of the primary edges' nodes, shape (n_edges, order + 1, 2).
        kept
            Edge that each node faced before, -1 for none, shape (n_nodes,).

        """
        partner = nearest_edges(secondary, node_normals(secondary, secondary_places), primary_edges)
        before = np.flatnonzero(kept >= 0)
        parameters = closest_parameters(secondary[before], primary_edges[kept[before]])
        stays = before[_within(parameters, self.slack)]
        partner[stays] = kept[stays]

        nodes = np.flatnonzero(partner >= 0)
        kinematics = node_edge_gaps(secondary[nodes], primary_edges[partner[nodes]])
        chords = primary_edges[:, -1] - primary_edges[:, 0]
        reach = self.reach or 2.0 * float(np.linalg.norm(chords, axis=1).mean())
        near = _within(kinematics.parameters, self.overhang) & (kinematics.gaps < reach)
        chosen = NodeEdgeGaps(
            kinematics.parameters[near],
            kinematics.gaps[near],
            kinematics.normals[near],
            kinematics.gradients[near],
            kinematics.hessians[near],
        )
        return NodePairs(nodes[near], partner[nodes[near]], chosen)


def _within(parameters: Floats, margin: float) -> NDArray[np.bool_]:
    return (parameters >= -margin) & (parameters <= 1.0 + margin)
