"""Which edges are near each other, and which edge each node faces."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flangeway.geometry import crossing_shares
from flangeway.types import Floats, Ints

PAIRS_PER_CHUNK = 2_000_000
FEW_PAIRS = 500_000  # to measure as many is faster than an index
FIRST_NEIGHBOURS = 8  # edges measured for each point at first; four times as many in each further round
LAST_NEIGHBOURS = 512  # beyond, all edges are measured
ZERO_DEPTH = 1e-6
"""Depth over the longest edge up to which a point is on the surface; see `leads_out`."""
DEEP = 0.1
"""Depth behind an edge, over the length of the surface there, from which the point may have entered elsewhere."""
OTHER_EDGE, OWN_EDGE = 4.0, 10.0
"""Depth behind an edge, over the distance from another edge, from which a point entered through that other edge. The
second value is for an edge with the point itself: it exceeds that of a sharp corner."""
CLASS_FACTOR = 4.0  # edges of one spatial index differ in size by this factor at most


def candidate_pairs(secondary_edges: Floats, primary_edges: Floats, reach: float | Floats) -> tuple[Ints, Ints]:
    """All pairs of edges whose bounding boxes, those of the secondary enlarged by ``reach``, touch or overlap.

    Edges are sorted into classes of size with a spatial index each, so that a few long ones do not slow the search.

    Parameters
    ----------
    secondary_edges, primary_edges
        Positions of the edges' nodes, shapes (n, k + 1, 2) and (m, j + 1, 2); boxes are those of the nodes.
    reach
        Length >= 0 by which boxes are enlarged on all sides, one or one an edge (n,); infinity pairs all with all.

    Returns
    -------
    tuple of Ints
        Numbers of secondary and of primary edges, one entry a pair, in rising order of the first, then the second.

    """
    sides = [_boxes(edges) for edges in (secondary_edges, primary_edges)]
    reaches = np.broadcast_to(reach, len(secondary_edges))
    reach = float(reaches.max(initial=0.0))
    if not np.isfinite(reach) or len(secondary_edges) * len(primary_edges) <= FEW_PAIRS:
        near = np.ones((len(secondary_edges), len(primary_edges)), dtype=np.bool_)
        for axis in range(2):
            (middles, halves), (others, other_halves) = ((side[0][:, axis], side[1][:, axis]) for side in sides)
            near &= np.abs(middles[:, None] - others) <= (halves + reaches)[:, None] + other_halves
        i, j = np.nonzero(near)
        return i, j
    classes = [_size_classes(half.max(axis=1), reach) for _, half in sides]
    found: list[tuple[Ints, Ints]] = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    trees = [cKDTree(sides[1][0][members]) for members in classes[1]]
    for mine in classes[0]:
        tree = cKDTree(sides[0][0][mine])
        for theirs, other in zip(classes[1], trees, strict=True):
            radius = float(sides[0][1][mine].max() + sides[1][1][theirs].max()) + reach
            close = tree.sparse_distance_matrix(other, radius * (1.0 + 1e-12), p=np.inf, output_type="ndarray")
            found.append((mine[close["i"]], theirs[close["j"]]))
    i, j = (np.concatenate([pair[side] for pair in found]) for side in range(2))
    apart = np.abs(sides[0][0][i] - sides[1][0][j]) - sides[0][1][i] - sides[1][1][j]
    close = (apart <= reaches[i, None]).all(axis=1)
    i, j = i[close], j[close]
    order = np.lexsort((j, i))
    return i[order], j[order]


def nearest_edges(points: Floats, directions: Floats, edges: Floats) -> Ints:
    """Nearest edge that faces each point, by distance to its chord.

    A spatial index on the edges' middles proposes edges until no other can be nearer, however unequal the edges are:
    the answer is that of measuring them all.

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
    chords = _Chords(edges)
    best = _Best(len(points))
    wanted = np.flatnonzero(chords.may_face(directions))
    for members in _size_classes(chords.halves, 0.0)[::-1]:
        tree = cKDTree(chords.middles[members])
        widest = float(chords.halves[members].max()) * (1.0 + 1e-12)
        open_points, count = wanted, min(FIRST_NEIGHBOURS, len(members))
        while len(open_points) and count <= LAST_NEIGHBOURS:
            far, near = tree.query(points[open_points], k=np.arange(1, count + 1))
            best.measure(points, directions, chords, np.repeat(open_points, count), members[near.ravel()])
            if count == len(members):
                open_points = open_points[:0]
                break
            # every edge not proposed has its middle beyond the last one proposed
            open_points = open_points[far[:, -1] <= best.distances[open_points] + widest]
            count = min(4 * count, len(members))
        for part in _chunks(open_points, len(members)):
            pairs = np.repeat(part, len(members)), np.tile(members, len(part))
            best.measure(points, directions, chords, *pairs)
    return best.edges


def leads_out(
    points: Floats,
    vectors: Floats,
    sizes: Floats,
    own: tuple[Floats, NDArray[np.bool_]],
    other: tuple[Floats, NDArray[np.bool_]],
) -> NDArray[np.bool_]:
    """Whether points of a surface lie behind edges of another one that they did not enter through.

    The far sides of two slender bodies side by side face each other through both bodies: the vector to such an edge
    crosses another edge. A point deep behind an edge, over its length, and much nearer to another one entered there.

    Parameters
    ----------
    points, vectors
        Points of the surface, and the vectors from them to the edges that they face, each (n, 2).
    sizes
        Length of the surface at each point, shape (n,).
    own, other
        Positions of the edges' nodes of the point's and of the other surface, shape (n_edges, order + 1, 2), and which
        of them each point is on or faces, shape (n, n_edges).

    """
    depths = np.linalg.norm(vectors, axis=1)
    result = np.zeros(len(points), dtype=np.bool_)
    far = np.flatnonzero(depths > ZERO_DEPTH * float(np.linalg.norm(own[0][:, -1] - own[0][:, 0], axis=1).max()))
    if len(far) == 0:
        return result
    ways = np.stack((points[far], points[far] + vectors[far]), axis=1)
    through, nearer = np.zeros(len(far), dtype=np.bool_), np.zeros(len(far), dtype=np.bool_)
    of, edges = candidate_pairs(ways, own[0][:, [0, -1]], depths[far] / OTHER_EDGE)
    on = own[1][far[of], edges]
    crossed, apart = _crossed(ways[of], own[0][edges])
    through[of[crossed & ~on]] = True
    nearer[of[np.where(on, OWN_EDGE, OTHER_EDGE) * apart < depths[far[of]]]] = True
    of, edges = candidate_pairs(ways, other[0][:, [0, -1]], 0.0)
    crossed, _ = _crossed(ways[of], other[0][edges])
    through[of[crossed & ~other[1][far[of], edges]]] = True
    result[far] = through | (nearer & (depths[far] > DEEP * sizes[far]))
    return result


def _crossed(ways: Floats, edges: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Whether straight ways (n, 2, 2) cross the edges beside them, and the distances of their ends from these, (n,)."""
    starts, chords = edges[:, 0], edges[:, -1] - edges[:, 0]
    on_way, on_edge = crossing_shares(ways[:, 0], ways[:, 1] - ways[:, 0], starts, chords)
    crossed = (on_way > 0.0) & (on_way < 1.0 - ZERO_DEPTH) & (on_edge >= 0.0) & (on_edge <= 1.0)
    beyond = ways[:, 1] - starts
    share = (beyond * chords).sum(axis=1) / (chords**2).sum(axis=1)
    return crossed, np.linalg.norm(beyond - np.clip(share, 0.0, 1.0)[:, None] * chords, axis=1)


class _Chords:
    """Chords of edges."""

    def __init__(self, edges: Floats) -> None:
        self.starts, ends = edges[:, 0], edges[:, -1]
        self.vectors: Floats = ends - self.starts
        self.squares: Floats = self.vectors[:, 0] ** 2 + self.vectors[:, 1] ** 2
        self.middles: Floats = (self.starts + ends) / 2.0
        self.halves: Floats = np.sqrt(self.squares) / 2.0
        self.normals: Floats = np.stack((self.vectors[:, 1], -self.vectors[:, 0]), axis=1)

    def may_face(self, directions: Floats) -> NDArray[np.bool_]:
        """Whether any edge may face points with these outward directions: the one most against them, shape (n,)."""
        angles = np.sort(np.arctan2(self.normals[:, 1], self.normals[:, 0]))
        against = np.arctan2(-directions[:, 1], -directions[:, 0])
        position = np.searchsorted(angles, against)
        neighbours = np.stack((angles[position - 1], angles[position % len(angles)]))
        may: NDArray[np.bool_] = (np.cos(neighbours - against) > -1e-9).any(axis=0)
        return may


class _Best:
    """Nearest facing edge of each point so far."""

    def __init__(self, n_points: int) -> None:
        self.edges: Ints = np.full(n_points, -1, dtype=np.int64)
        self.distances: Floats = np.full(n_points, np.inf)
        self._squares: Floats = np.full(n_points, np.inf)

    def measure(self, points: Floats, directions: Floats, chords: _Chords, of: Ints, edges: Ints) -> None:
        """Take into account edges of points ``of``, one pair an entry; ``of`` rises."""
        normals, ahead = chords.normals[edges], directions[of]
        facing = ahead[:, 0] * normals[:, 0] + ahead[:, 1] * normals[:, 1] < 0.0
        of, edges = of[facing], edges[facing]
        if len(of) == 0:
            return
        squares = _squared_distances(points[of], chords, edges)
        order = np.lexsort((edges, squares, of))
        of, edges, squares = of[order], edges[order], squares[order]
        first = np.concatenate(([True], of[1:] != of[:-1]))
        of, edges, squares = of[first], edges[first], squares[first]
        better = (squares < self._squares[of]) | ((squares == self._squares[of]) & (edges < self.edges[of]))
        of = of[better]
        self.edges[of], self._squares[of] = edges[better], squares[better]
        self.distances[of] = np.sqrt(squares[better])


def _squared_distances(points: Floats, chords: _Chords, edges: Ints) -> Floats:
    """Squared distance of each point to the chord of its edge, shape (n,)."""
    apart, vectors = points - chords.starts[edges], chords.vectors[edges]
    along = (apart[:, 0] * vectors[:, 0] + apart[:, 1] * vectors[:, 1]) / chords.squares[edges]
    off = apart - np.clip(along, 0.0, 1.0)[:, None] * vectors
    squares: Floats = off[:, 0] ** 2 + off[:, 1] ** 2
    return squares


def _boxes(edges: Floats) -> tuple[Floats, Floats]:
    """Middles and half sides of the edges' bounding boxes, each (n, 2)."""
    low, high = edges.min(axis=1), edges.max(axis=1)
    return (low + high) / 2.0, (high - low) / 2.0


def _size_classes(sizes: Floats, least: float) -> list[Ints]:
    """Numbers of things of like size, from small to large; those below ``least`` are one class."""
    if len(sizes) == 0:
        return []
    smallest = max(least, 1e-9 * float(sizes.max()), np.finfo(np.float64).tiny)
    levels = np.floor(np.log(np.maximum(sizes, smallest) / smallest) / np.log(CLASS_FACTOR)).astype(np.int64)
    return [np.flatnonzero(levels == level) for level in np.unique(levels)]


def _chunks(numbers: Ints, width: int) -> Iterator[Ints]:
    size = max(1, PAIRS_PER_CHUNK // width)
    for first in range(0, len(numbers), size):
        yield numbers[first : first + size]
