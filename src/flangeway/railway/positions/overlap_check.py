"""Overlap of wheel and rail in many positions, measured without trust in where their contact was evaluated."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.spatial import cKDTree

from flangeway.contact import Surface
from flangeway.types import Floats, Ints

ALLOWED_MM = 0.05
"""Overlap that curves between nodes and the stiff displacement of what is beside the running surfaces may show."""


@dataclass(frozen=True, eq=False)
class BoundaryNodes:
    """Corners of a body's whole boundary; what is beside the running surface moves with the nearer end of it.

    - `previous`, `following`: neighbours along the boundary, the body on the left, each (n,).
    - `moves_with`: node of the running surface that each of them is or moves with, shape (n,).
    - `offsets`: vectors from that node, shape (n, 2).
    """

    previous: Ints
    following: Ints
    moves_with: Ints
    offsets: Floats

    @classmethod
    def of(cls, surface: Surface) -> Self:
        """Boundary of the body of a running surface."""
        mesh = surface.part.body.mesh
        edges = mesh.boundary_edges.astype(np.int64)
        nodes, ends = np.unique(edges, return_inverse=True)
        first, second = ends.reshape(-1, 2).T
        previous, following = np.zeros((2, len(nodes)), dtype=np.int64)
        following[first], previous[second] = second, first
        points, running = mesh.points[nodes], surface.part.body.space.nodes[surface.nodes]
        to_ends = np.linalg.norm(points[:, None] - running[[0, -1]], axis=2)
        moves_with = np.where(to_ends[:, 0] < to_ends[:, 1], 0, len(running) - 1)
        place = {int(node): number for number, node in enumerate(surface.nodes)}
        moves_with = np.array([place.get(int(node), end) for node, end in zip(nodes, moves_with, strict=True)])
        return cls(previous, following, moves_with, points - running[moves_with])

    def positions(self, running: Floats, turn: Floats) -> Floats:
        """Positions (n, 2) by those of the running surface's nodes, and the matrix (2, 2) from the body's frame."""
        return running[self.moves_with] + self.offsets @ turn.T


def overlap_depth(one: BoundaryNodes, on_one: Floats, other: BoundaryNodes, on_other: Floats) -> float:
    """Maximum depth of a body's corners in another body and the reverse, at positions of their corners, each (n, 2)."""
    return max(_depth(on_one, other, on_other), _depth(on_other, one, on_one))


def _depth(points: Floats, other: BoundaryNodes, corners: Floats) -> float:
    """Maximum depth of points (m, 2) in a body whose corners are at positions (n, 2); zero outside of it."""
    points = points[((points > corners.min(axis=0)) & (points < corners.max(axis=0))).all(axis=1)]
    if len(points) == 0:
        return 0.0
    _, nearest = cKDTree(corners).query(points)
    before, corner, after = (
        corners[each[nearest]] for each in (other.previous, np.arange(len(corners)), other.following)
    )
    left = [_cross(end - start, points - start) > 0.0 for start, end in ((before, corner), (corner, after))]
    inside = np.where(_cross(corner - before, after - corner) > 0.0, left[0] & left[1], left[0] | left[1])
    distances = np.minimum(_distances(points, before, corner), _distances(points, corner, after))
    return float(distances[inside].max(initial=0.0))


def _cross(one: Floats, other: Floats) -> Floats:
    product: Floats = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return product


def _distances(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Distances of points from segments, one each, shape (m,)."""
    along = ends - starts
    share = np.clip(((points - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    distances: Floats = np.linalg.norm(points - starts - share[:, None] * along, axis=1)
    return distances
