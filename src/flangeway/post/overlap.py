"""Whether two bodies overlap, whatever contact was looked for."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.post.location import OUTSIDE, locate

Floats = NDArray[np.float64]

ALLOWED = 0.25
"""Depth over the length of the edges there up to which an overlap may be that of straight edges along curves."""


@dataclass(frozen=True)
class Overlap:
    """Where two bodies overlap most.

    Parameters
    ----------
    depth
        Distance of a point of one body from the boundary of the other, in which it lies.
    place
        That point, x and y.

    """

    depth: float
    place: tuple[float, float]


def moved_mesh(mesh: PolyMesh, displacements: Floats, placement: Placement) -> PolyMesh:
    """Mesh of a deformed body in space, by the displacements of its points in its frame, shape (n_points, 2)."""
    return replace(mesh, points=mesh.points + displacements).placed(placement)


def deepest_overlap(one: PolyMesh, other: PolyMesh) -> Overlap | None:
    """Return where points on the boundary of one body lie deepest in the other one.

    None if no point lies deeper than a quarter of the edges there, which chords of arcs may. Contact alone leaves no
    overlap: its penetration is far smaller than an edge.
    """
    found = [_deepest(one, other), _deepest(other, one)]
    return max((each for each in found if each is not None), key=lambda each: each.depth, default=None)


def _deepest(points_of: PolyMesh, inside_of: PolyMesh) -> Overlap | None:
    """Deepest of the points on one boundary within another body."""
    edges = points_of.boundary_edges
    numbers = np.unique(edges)
    numbers = numbers[locate(inside_of, points_of.points[numbers]) != OUTSIDE]
    if len(numbers) == 0:
        return None
    lengths = np.zeros(points_of.n_points)
    edge_lengths = np.linalg.norm(np.diff(points_of.points[edges], axis=1)[:, 0], axis=1)
    np.maximum.at(lengths, edges, edge_lengths[:, None])
    points, lengths = points_of.points[numbers], lengths[numbers]
    start, end = inside_of.points[inside_of.boundary_edges].swapaxes(0, 1)
    nearest, nearest_length = np.full(len(points), np.inf), np.zeros(len(points))
    for a, b in zip(start, end, strict=True):
        along = b - a
        squared = float(along @ along)
        share = np.clip((points - a) @ along / squared, 0.0, 1.0)
        distance = np.linalg.norm(points - a - share[:, None] * along, axis=1)
        closer = distance < nearest
        nearest[closer], nearest_length[closer] = distance[closer], np.sqrt(squared)
    deep = nearest > ALLOWED * np.maximum(lengths, nearest_length)
    if not deep.any():
        return None
    place = int(np.argmax(np.where(deep, nearest, -np.inf)))
    x, y = points[place].tolist()
    return Overlap(float(nearest[place]), (x, y))
