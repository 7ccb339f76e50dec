"""Hat functions on a surface, which weight the gaps of segment-to-segment contact."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flangeway.types import Floats, Ints

if TYPE_CHECKING:
    from flangeway.contact.surface import Surface


SHARP = np.deg2rad(30.0)
"""Turn of a surface above which the two sides of a node have a constraint each."""


@dataclass(frozen=True, eq=False)
class Hats:
    """Hat functions on a surface, one an end of edges, two at sharp corners.

    Parameters
    ----------
    nodes
        Place in the surface of each function's node, shape (n,).
    of_edge
        Functions of the two ends of each edge, shape (n_edges, 2).
    areas
        Integrals of the functions over the undeformed surface, times the thickness, shape (n,).

    """

    nodes: Ints
    of_edge: Ints
    areas: Floats

    @classmethod
    def on(cls, surface: "Surface") -> "Hats":
        """Functions on a surface."""
        points = surface.part.body.mesh.points
        ends = points[surface.edge_nodes[:, [0, -1]]]
        chords = ends[:, 1] - ends[:, 0]
        before = np.roll(chords, 1, axis=0)
        turn = np.arctan2(before[:, 0] * chords[:, 1] - before[:, 1] * chords[:, 0], (before * chords).sum(1))
        starts_anew = np.abs(turn) > SHARP
        starts_anew[0] |= surface.edge_places[-1, -1] != 0
        # one new function at each edge's end, one more at its start where the surface starts anew
        last = np.arange(len(chords)) + np.cumsum(starts_anew)
        first = last - 1
        if not starts_anew[0]:
            first[0] = last[-1]
        nodes = np.empty(last.max() + 1, dtype=np.int64)
        nodes[first], nodes[last] = surface.edge_places[:, 0], surface.edge_places[:, -1]
        areas = np.zeros(len(nodes))
        for column in (first, last):
            np.add.at(areas, column, surface.edge_lengths / 2.0 * surface.part.body.thickness)
        return cls(nodes, np.stack((first, last), axis=1), areas)
