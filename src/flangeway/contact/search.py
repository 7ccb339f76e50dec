"""Which edge each node faces."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PAIRS_PER_CHUNK = 2_000_000


def nearest_edges(points: Floats, directions: Floats, edges: Floats) -> Ints:
    """Nearest edge that faces each point, by distance to its chord.

    Every edge is measured, so that none is missed however unequal the edges are; chunks bound the memory.

    Parameters
    ----------
    points
        Shape (n_points, 2).
    directions
        Outward directions of the points' own body, shape (n_points, 2).
    edges
        Positions of the edges' nodes, their body on the left, shape (n_edges, order + 1, 2).

    Returns
    -------
    Ints
        Number of the edge, shape (n_points,); -1 where no edge faces the point.

    """
    start, chord = edges[:, 0], edges[:, -1] - edges[:, 0]
    squared = np.einsum("ei,ei->e", chord, chord)
    normals = np.stack((chord[:, 1], -chord[:, 0]), axis=1)
    nearest = np.empty(len(points), dtype=np.int64)
    size = max(1, PAIRS_PER_CHUNK // len(edges))
    for first in range(0, len(points), size):
        part = slice(first, first + size)
        apart = points[part, None] - start
        parameter = np.clip(np.einsum("pei,ei->pe", apart, chord) / squared, 0.0, 1.0)
        distance = np.linalg.norm(apart - parameter[..., None] * chord, axis=-1)
        distance[directions[part] @ normals.T >= 0.0] = np.inf
        best = np.argmin(distance, axis=1)
        found = np.isfinite(distance[np.arange(len(best)), best])
        nearest[part] = np.where(found, best, -1)
    return nearest
