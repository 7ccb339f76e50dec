"""Which edges are near each other, and which edge each node faces."""

import numpy as np
import shapely
from numpy.typing import NDArray

from flangeway.geometry import crossing_shares
from flangeway.geometry.arrays import cross_product, turned_right
from flangeway.types import Floats, Ints

GROWTH = 4.0
"""Factor from one box of the search to the next: a few edges more in each against fewer of them."""
ZERO_DEPTH = 1e-6
"""Depth relative to the longest edge up to which a point is on the surface; see `leads_out`."""
MAX_ENTRY_DEPTH = 0.1
"""Depth behind an edge, relative to the length of the surface there, from which the point may have entered
elsewhere."""
MAX_SAGITTA = 0.25
"""Height of a curved edge over its chord, over the chord, beyond all meshes: a quarter of a circle has 0.2."""
OTHER_EDGE = 4.0
"""Depth behind an edge, relative to the distance from an edge without the point, from which it entered through that
one."""


def candidate_pairs(secondary_edges: Floats, primary_edges: Floats, reach: float | Floats) -> tuple[Ints, Ints]:
    """All pairs of edges whose bounding boxes, those of the secondary enlarged by ``reach``, touch or overlap.

    Parameters
    ----------
    secondary_edges, primary_edges
        Positions of the edges' nodes, shapes (n, k + 1, 2) and (m, j + 1, 2); boxes are those of the nodes.
    reach
        Length >= 0 by which boxes are enlarged on all sides, one or one an edge (n,).

    Returns
    -------
    tuple of Ints
        Numbers of secondary and of primary edges, one entry a pair, in rising order of the first, then the second.

    """
    secondary, primary = _boxes(secondary_edges, reach), _boxes(primary_edges, 0.0)
    # most edges of a long surface are far from all of the other one
    low, high = secondary[:2].min(axis=1, initial=np.inf), secondary[2:].max(axis=1, initial=-np.inf)
    near = np.flatnonzero(((primary[2:] >= low[:, None]) & (primary[:2] <= high[:, None])).all(axis=0))
    i, j = shapely.STRtree(shapely.box(*primary[:, near])).query(shapely.box(*secondary))
    order = np.lexsort((j, i))
    return i[order], near[j[order]]


def _boxes(edges: Floats, reach: float | Floats) -> Floats:
    """Bounding boxes of edges (n, k + 1, 2), enlarged by a reach: least x, y and largest x, y, shape (4, n)."""
    return np.concatenate(
        ((edges.min(axis=1) - np.transpose([reach])).T, (edges.max(axis=1) + np.transpose([reach])).T)
    )


def behind(points: Floats, edges: Floats) -> NDArray[np.bool_]:
    """Which points (n, 2) are behind the nearest of edges (n_edges, order + 1, 2), or hardly in front of its chord."""
    chords = edges[:, -1] - edges[:, 0]
    lengths = np.linalg.norm(chords, axis=1)
    of, nearest = shapely.STRtree(shapely.linestrings(edges[:, [0, -1]])).query_nearest(shapely.points(points))
    apart = points[of] - edges[nearest, 0]
    in_front = (apart[:, 0] * chords[nearest, 1] - apart[:, 1] * chords[nearest, 0]) / lengths[nearest]
    result = np.zeros(len(points), dtype=np.bool_)
    result[of[in_front <= MAX_SAGITTA * lengths.max()]] = True
    return result


def nearest_edges(points: Floats, directions: Floats, edges: Floats) -> Ints:
    """Nearest edge that faces each point, by distance to its chord.

    Edges are sought in boxes about the points, larger ones for those that no edge in their box faces, so that the
    answer is that of measuring them all.

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
        Number of the edge, shape (n_points,), the lowest of equally near ones; -1 where no edge faces the point.

    """
    result: Ints = np.full(len(points), -1, dtype=np.int64)
    starts, chords = edges[:, 0], edges[:, -1] - edges[:, 0]
    normals = turned_right(chords)
    open_points = np.flatnonzero(_may_face(directions, normals))
    tree = shapely.STRtree(shapely.box(*_boxes(edges[:, [0, -1]], 0.0)))
    everything = np.concatenate((points, *edges.swapaxes(0, 1)))
    extent, radius = float(np.ptp(everything, axis=0).max()), float(np.linalg.norm(chords, axis=1).mean())
    while len(open_points):
        low, high = points[open_points] - radius, points[open_points] + radius
        of, near = tree.query(shapely.box(*low.T, *high.T))
        of = open_points[of]
        facing = np.einsum("ni,ni->n", directions[of], normals[near]) < 0.0
        of, near = of[facing], near[facing]
        apart, along = points[of] - starts[near], chords[near]
        share = np.clip(np.einsum("ni,ni->n", apart, along) / np.einsum("ni,ni->n", along, along), 0.0, 1.0)
        apart -= share[:, None] * along
        squares = np.einsum("ni,ni->n", apart, apart)
        order = np.lexsort((near, squares, of))
        of, near, squares = of[order], near[order], squares[order]
        first = np.diff(of, prepend=-1) > 0
        # beyond the radius an edge outside of the box may be nearer
        close = first & ((squares <= radius**2) | (radius >= extent))
        result[of[close]] = near[close]
        open_points = np.setdiff1d(open_points, of[close]) if radius < extent else open_points[:0]
        radius *= GROWTH
    return result


def _may_face(directions: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Whether any edge faces points with outward directions (n, 2): its normal is the most against one, (n,)."""
    angles = np.sort(np.arctan2(normals[:, 1], normals[:, 0]))
    against = np.arctan2(-directions[:, 1], -directions[:, 0])
    index = np.searchsorted(angles, against)
    nearest = np.stack((angles[index - 1], angles[index % len(angles)]))
    return (np.cos(nearest - against) > -1e-9).any(axis=0)


def leads_out(
    points: Floats,
    vectors: Floats,
    sizes: Floats,
    surface: tuple[Floats, NDArray[np.bool_]],
    other: tuple[Floats, NDArray[np.bool_]],
) -> NDArray[np.bool_]:
    """Whether points of a surface lie behind edges of another one that they did not enter through.

    The far sides of two slender bodies side by side face each other through both bodies: the vector to such an edge
    leaves the point's own body, or enters the other one, across another edge. The next edge at a joint is crossed the
    other way, so that a point beside the joint faces what the points around it face. A point deep behind an edge, over
    its length, and much nearer to another one entered there.

    Parameters
    ----------
    points, vectors
        Points of the surface, and the vectors from them to the edges that they face, each (n, 2).
    sizes
        Length of the surface at each point, shape (n,).
    surface, other
        Positions of the edges' nodes of the point's and of the other surface, shape (n_edges, order + 1, 2), and which
        of them each point is on or faces, shape (n, n_edges).

    """
    depths = np.linalg.norm(vectors, axis=1)
    result = np.zeros(len(points), dtype=np.bool_)
    far = np.flatnonzero(
        depths > ZERO_DEPTH * float(np.linalg.norm(surface[0][:, -1] - surface[0][:, 0], axis=1).max())
    )
    if len(far) == 0:
        return result
    ways = np.stack((points[far], points[far] + vectors[far]), axis=1)
    through, nearer = np.zeros(len(far), dtype=np.bool_), np.zeros(len(far), dtype=np.bool_)
    of, edges = candidate_pairs(ways, surface[0][:, [0, -1]], depths[far] / OTHER_EDGE)
    on = surface[1][far[of], edges]
    outwards, _, apart = _crossed(ways[of], surface[0][edges])
    through[of[outwards & ~on]] = True
    nearer[of[~on & (OTHER_EDGE * apart < depths[far[of]])]] = True
    of, edges = candidate_pairs(ways, other[0][:, [0, -1]], 0.0)
    _, inwards, _ = _crossed(ways[of], other[0][edges])
    through[of[inwards & ~other[1][far[of], edges]]] = True
    result[far] = through | (nearer & (depths[far] > MAX_ENTRY_DEPTH * sizes[far]))
    return result


def _crossed(ways: Floats, edges: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_], Floats]:
    """Whether straight ways (n, 2, 2) leave, or enter, a body across the edges beside them, whose body is on the left.

    The third value is the distances of the ways' ends from these edges, (n,).
    """
    starts, chords = edges[:, 0], edges[:, -1] - edges[:, 0]
    on_way, on_edge = crossing_shares(ways[:, 0], ways[:, 1] - ways[:, 0], starts, chords)
    crossed = (on_way > 0.0) & (on_way < 1.0 - ZERO_DEPTH) & (on_edge >= 0.0) & (on_edge <= 1.0)
    beyond = ways[:, 1] - starts
    share = (beyond * chords).sum(axis=1) / (chords**2).sum(axis=1)
    out = cross_product(chords, ways[:, 1] - ways[:, 0]) < 0.0
    apart = np.linalg.norm(beyond - np.clip(share, 0.0, 1.0)[:, None] * chords, axis=1)
    return crossed & out, crossed & ~out, apart
