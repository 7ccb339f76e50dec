"""Which edges are near each other, and which edge each node faces."""

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from flangeway.geometry import Placement, crossing_shares
from flangeway.geometry.arrays import chords_of, cross_product, joined_columns, norms, turned_right
from flangeway.types import Bools, Floats, Ints

GROWTH = 4.0
"""Factor from one box of the search to the next: a few edges more in each against fewer of them."""
ZERO_DEPTH = 1e-6
"""Depth relative to the longest edge up to which a point is on the surface; see `leads_out`."""
MAX_ROTATION_STEP = 0.05
"""Rotation in rad between two positions of a path that is taken as straight."""
MAX_ENTRY_DEPTH = 0.1
"""Depth behind an edge, relative to the length of the surface there, from which the point may have entered
elsewhere."""
MAX_SAGITTA = 0.25
"""Height of a curved edge over its chord, over the chord, beyond all meshes: a quarter of a circle has 0.2."""
TINY = float(np.finfo(np.float64).tiny)
ON_SURFACE = 1e-9
"""Depth relative to an edge that is round-off of a point on it."""
OPPOSITE = -0.5
"""Cosine of the angle between normals below which two sides of a body face different ways: corners turn less."""
MAX_PAIRS = 2_000_000
"""Pairs of a point and an edge whose crossings are computed at a time."""
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


def on_path(first: Placement, last: Placement, points: Floats, share: float) -> Floats:
    """Points of a body at a share of its way, at two placements and shape (2, n, 2) in space at its ends: (n, 2).

    The body moves and turns in proportion, and deforms straight in its own frame.
    """
    local = (1.0 - share) * first.inverse().points(points[0]) + share * last.inverse().points(points[1])
    return last.after(first.inverse()).part(share).after(first).points(local)


class Visits(NamedTuple):
    """Points that enter a body through an edge of its surface while both move straight, k of them.

    - `points`, `edges`, `times`: the points, the edges, and parts of the move at which they enter, each (k,).
    - `ends`: parts of the move at which they leave, 1 if they do not, shape (k,).
    - `other_side`: whether they leave through an edge that faces the other way and is not the next one.
    - `depths`: distances behind the line of the edge, or from the surface where it is nearer; halfway of those that
      leave, at the end of those that stay.
    """

    points: Ints
    edges: Ints
    times: Floats
    ends: Floats
    other_side: Bools
    depths: Floats


def visits(points: Floats, edges: Floats, on_surface: Floats) -> Visits:
    """Which moving points enter through moving edges.

    A point at ``x + t (x' - x)`` is on the line of an edge where the cross product of the edge and of the vector to the
    point, which is quadratic in t, vanishes. A point that starts behind an edge by less than a depth enters at 0.

    Parameters
    ----------
    points
        Positions at the start and at the end of the move, shape (2, n, 2).
    edges
        Ends of the edges then, their body on the left, shape (2, m, 2, 2).
    on_surface
        That depth of each edge, >= 0, shape (m,).

    """
    n, m = points.shape[1], edges.shape[1]
    swept, rows = edges.transpose(1, 0, 2, 3).reshape(m, 4, 2), max(1, MAX_PAIRS // max(m, 1))
    blocks = []
    for first in range(0, n, rows):
        block = points[:, first : first + rows].swapaxes(0, 1)
        of, near = candidate_pairs(block, swept, float(on_surface.max(initial=0.0)))
        blocks.append(_crossings(points, edges, on_surface, first + of, near))
    of, near, times, inwards, normals = joined_columns(blocks)
    order = np.lexsort((~inwards, times, of))
    of, near, inwards = of[order], near[order], inwards[order]
    times, normals = times[order], normals[order]
    # the next crossing outwards of the same point
    count = len(order)
    leaving = np.minimum.accumulate(np.where(inwards, count, np.arange(count))[::-1])[::-1]
    leaves, leaving = leaving < count, np.minimum(leaving, count - 1)
    leaves &= of[leaving] == of
    ends = np.where(leaves, times[leaving], 1.0)
    other_side = leaves & ((normals * normals[leaving]).sum(axis=1) < OPPOSITE)
    entry, exit_edge = edges[0, near], edges[0, near[leaving]]
    # who crosses the tip of a sharp corner has not gone through
    other_side &= (entry[:, 1] != exit_edge[:, 0]).any(axis=1) & (entry[:, 0] != exit_edge[:, 1]).any(axis=1)
    halfway = np.where(leaves, (times + ends) / 2.0, 1.0)
    at, start, end = (
        values[0] + halfway[:, None] * (values[1] - values[0])
        for values in (points[:, of], edges[:, near, 0], edges[:, near, 1])
    )
    depths = cross_product(end - start, at - start) / np.maximum(norms(end - start), TINY)
    # what slides along another edge is not as deep
    deep = np.flatnonzero(inwards & (depths > on_surface[near]))
    for some in np.array_split(deep, 1 + len(deep) * m // MAX_PAIRS):
        surface = edges[0] + halfway[some, None, None, None] * (edges[1] - edges[0])
        depths[some] = np.minimum(depths[some], distances_from(at[some, None], surface).min(axis=1, initial=np.inf))
    other_side &= depths > ON_SURFACE * norms(end - start)
    return Visits(of[inwards], near[inwards], times[inwards], ends[inwards], other_side[inwards], depths[inwards])


def distances_from(points: Floats, edges: Floats) -> Floats:
    """Distances of points (..., 2) from straight edges with points (..., k, 2)."""
    start, chord = edges[..., 0, :], edges[..., -1, :] - edges[..., 0, :]
    share = ((points - start) * chord).sum(axis=-1) / np.maximum((chord**2).sum(axis=-1), TINY)
    return norms(points - start - np.clip(share, 0.0, 1.0)[..., None] * chord)


def _crossings(
    points: Floats, edges: Floats, on_surface: Floats, of: Ints, near: Ints
) -> tuple[Ints, Ints, Floats, Bools, Floats]:
    """Points, edges, times, whether inwards, and normals of the edges then, of the crossings of pairs of both."""
    start, chord = edges[:, near, 0], edges[:, near, 1] - edges[:, near, 0]
    vector = points[:, of] - start
    first, last = cross_product(chord, vector)  # at both ends of the move
    changes = chord[1] - chord[0], vector[1] - vector[0]
    change = cross_product(*changes)
    rate = last - first - change
    entered = (first >= 0.0) & (first <= on_surface[near] * norms(chord[0]))
    with np.errstate(divide="ignore", invalid="ignore"):
        # both roots of change t^2 + rate t + first
        root = -(rate + np.where(rate < 0.0, -1.0, 1.0) * np.sqrt(rate**2 - 4.0 * change * first)) / 2.0
        times = np.stack((root / change, first / root, np.where(entered, 0.0, np.nan)))
    number, pair = np.nonzero((times >= 0.0) & (times <= 1.0))
    t = times[number, pair]
    edge, at = (
        values[0][pair] + t[:, None] * more[pair] for values, more in zip((chord, vector), changes, strict=True)
    )
    share = (edge * at).sum(axis=1) / np.maximum((edge**2).sum(axis=1), TINY)
    slope, starts = rate[pair] + 2.0 * change[pair] * t, number == len(times) - 1
    # what only touches does not cross, and what starts on the surface is there already
    on = (share >= 0.0) & (share <= 1.0) & (starts | ((slope != 0.0) & ~(entered[pair] & (slope > 0.0) & (t == 0.0))))
    normals = turned_right(edge[on]) / np.maximum(norms(edge[on]), TINY)[:, None]
    return of[pair[on]], near[pair[on]], t[on], (starts | (slope > 0.0))[on], normals


def behind(points: Floats, edges: Floats) -> NDArray[np.bool_]:
    """Which points (n, 2) are behind the nearest of edges (n_edges, order + 1, 2), or hardly in front of its chord."""
    chords = chords_of(edges)
    lengths = norms(chords)
    of, nearest = shapely.STRtree(shapely.linestrings(edges[:, [0, -1]])).query_nearest(shapely.points(points))
    apart = points[of] - edges[nearest, 0]
    in_front = (apart[:, 0] * chords[nearest, 1] - apart[:, 1] * chords[nearest, 0]) / lengths[nearest]
    result = np.zeros(len(points), dtype=np.bool_)
    result[of[in_front <= MAX_SAGITTA * lengths.max()]] = True
    return result


def nearest_edges(points: Floats, directions: Floats, edges: Floats, opposition: Floats | float = 0.0) -> Ints:
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
    opposition
        Cosine >= 0 of the angle between a point's direction and the opposite of an edge's normal, up to which the edge
        faces it: one, or one a point (n_points,).

    Returns
    -------
    Ints
        Number of the edge, shape (n_points,), the lowest of equally near ones; -1 where no edge faces the point.

    """
    result: Ints = np.full(len(points), -1, dtype=np.int64)
    starts, chords = edges[:, 0], chords_of(edges)
    normals = turned_right(chords)
    limits = -opposition * norms(directions)
    open_points = np.flatnonzero(_may_face(directions, normals, opposition))
    tree = shapely.STRtree(shapely.box(*_boxes(edges[:, [0, -1]], 0.0)))
    everything = np.concatenate((points, *edges.swapaxes(0, 1)))
    lengths = norms(chords)
    extent, radius = float(np.ptp(everything, axis=0).max()), float(lengths.mean())
    while len(open_points):
        low, high = points[open_points] - radius, points[open_points] + radius
        of, near = tree.query(shapely.box(*low.T, *high.T))
        of = open_points[of]
        facing = np.einsum("ni,ni->n", directions[of], normals[near]) < limits[of] * lengths[near]
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


def _may_face(directions: Floats, normals: Floats, opposition: Floats | float) -> NDArray[np.bool_]:
    """Whether any edge faces points with outward directions (n, 2): its normal is the most against one, (n,)."""
    angles = np.sort(np.arctan2(normals[:, 1], normals[:, 0]))
    against = np.arctan2(-directions[:, 1], -directions[:, 0])
    index = np.searchsorted(angles, against)
    nearest = np.stack((angles[index - 1], angles[index % len(angles)]))
    return (np.cos(nearest - against) > opposition - 1e-9).any(axis=0)


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
    depths = norms(vectors)
    result = np.zeros(len(points), dtype=np.bool_)
    far = np.flatnonzero(depths > ZERO_DEPTH * float(norms(chords_of(surface[0])).max()))
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
    steps, chords = chords_of(ways), chords_of(edges)
    on_way, on_edge = crossing_shares(ways[:, 0], steps, edges[:, 0], chords)
    crossed = (on_way > 0.0) & (on_way < 1.0 - ZERO_DEPTH) & (on_edge >= 0.0) & (on_edge <= 1.0)
    out = cross_product(chords, steps) < 0.0
    return crossed & out, crossed & ~out, distances_from(ways[:, 1], edges)
