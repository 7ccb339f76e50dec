"""Deformed boundaries, and how deep one lies within another."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from flangeway.contact.edge_shapes import shape_functions
from flangeway.contact.search import candidate_pairs
from flangeway.types import Bools, Floats, Ints

SHARP = np.deg2rad(15.0)
"""Turn between two edges from which they meet in a corner that was drawn, not in one of a curve's chords."""

STRAIGHT = 1e-9
"""Turn between two parts of a straight side, by round-off."""

LITTLE = 1e-3
"""Depth over the maximum displacement of the surfaces that elements leave between nodes."""

ROUND_OFF = 1e-9
"""Of a depth, over the size of the smaller body."""

SAMPLES = np.linspace(0.0, 1.0, 6)
"""Where parts of edges inside of another body are looked at."""

ENTRIES_PER_CHUNK = 1_000_000


@dataclass(frozen=True)
class Intrusion:
    """Where one boundary lies within the other one, beyond what it may.

    Parameters
    ----------
    depth
        Distance of a point of one boundary from the other, in whose body it lies.
    place
        That point, x and y.
    allowed
        Depth that the chords of curves explain there.

    """

    depth: float
    place: tuple[float, float]
    allowed: float


@dataclass(frozen=True, eq=False)
class Boundary:
    """Edges of a body's boundary as straight segments, and how far a smooth curve may lie from them.

    Parameters
    ----------
    segments
        Ends of the segments, the body on their left, shape (n, 2, 2).
    sagittas
        Distance to which a curve through the edges' ends may leave the segments, shape (n,).

    """

    segments: Floats
    sagittas: Floats

    @classmethod
    def of(cls, drawn: Floats, deformed: Floats, joints: tuple[Ints, Ints]) -> Self:
        """Edges of any order; curved ones become several segments.

        The sagitta ``h^2 / 8 R`` is found from the edges themselves: two chords of a circle meet at the angle h / R. An
        edge on a curve that was drawn turns at both ends to one side, by less than `SHARP`; straight sides do not,
        and a corner is at one end. What the deformation adds to the turns at both ends counts wherever it is. A curved
        edge has at least the distance of its nodes from its chord.

        Parameters
        ----------
        drawn
            Ends of the edges before the deformation, shape (n, 2, 2).
        deformed
            Nodes of the deformed edges, shape (n, order + 1, 2).
        joints
            Points at which the edges start and end, each (n,): where two edges have one, they meet.

        """
        order = deformed.shape[1] - 1
        sagittas = sagittas_of(drawn, deformed, joints)
        if order == 1:
            return cls(deformed, sagittas)
        parts = 4 * (order // 2 + 1)
        points = np.einsum("ta,nai->nti", shape_functions(order, np.linspace(0.0, 1.0, parts + 1), 0)[0], deformed)
        segments = np.stack((points[:, :-1], points[:, 1:]), axis=2).reshape(-1, 2, 2)
        return cls(segments, np.repeat(sagittas, parts))

    def contains(self, points: Floats) -> Bools:
        """Whether points (m, 2) lie within the closed boundary, by the number of segments to their right."""
        (ax, ay), (bx, by) = self.segments.transpose(1, 2, 0)
        inside = np.zeros(len(points), dtype=np.bool_)
        for here in _chunks(len(points), len(ax)):
            x, y = points[here, :1], points[here, 1:]
            which, side = np.nonzero((ay <= y) != (by <= y))
            share = (y[which, 0] - ay[side]) / (by[side] - ay[side])
            right = ax[side] + share * (bx[side] - ax[side]) > x[which, 0]
            inside[here] = np.bincount(which[right], minlength=len(x)) % 2 == 1
        return inside

    def nearest(self, points: Floats) -> tuple[Floats, Ints]:
        """Distances of points (m, 2) from the boundary, and the segments that are nearest, each (m,)."""
        starts = self.segments[:, 0]
        chords = self.segments[:, 1] - starts
        squares = (chords**2).sum(axis=1)
        distances, numbers = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
        for here in _chunks(len(points), len(starts)):
            x, y = (points[here, axis, None] - starts[:, axis] for axis in range(2))
            share = np.clip((x * chords[:, 0] + y * chords[:, 1]) / squares, 0.0, 1.0)
            apart = (x - share * chords[:, 0]) ** 2 + (y - share * chords[:, 1]) ** 2
            numbers[here] = apart.argmin(axis=1)
            distances[here] = np.sqrt(apart.min(axis=1))
        return distances, numbers

    def within(self, other: "Boundary") -> Intrusion | None:
        """Return the point of this boundary that lies in the other's body deepest beyond what curves explain."""
        near = np.flatnonzero(_boxes_meet(self.segments, other.segments))
        starts = self.segments[near, 0]
        ends = self.segments[near, 1]
        chosen = other.contains(starts) | other.contains(ends)
        of, crossings = _crossings(self.segments[near], other.segments)
        chosen[of] = True
        every = np.flatnonzero(chosen)
        if len(every) == 0:
            return None
        owners = np.concatenate((every, every, of))
        places = np.concatenate((np.zeros(len(every)), np.ones(len(every)), crossings))
        order = np.lexsort((places, owners))
        owners, places = owners[order], places[order]
        same = np.flatnonzero(owners[1:] == owners[:-1])
        along = places[same, None] + (places[same + 1] - places[same])[:, None] * SAMPLES
        owner = np.repeat(owners[same], len(SAMPLES))
        along = along.ravel()
        points = starts[owner] + along[:, None] * (ends - starts)[owner]
        inside = other.contains(points)
        points, owner = points[inside], near[owner[inside]]
        if len(points) == 0:
            return None
        depths, nearest = other.nearest(points)
        allowed = self.sagittas[owner] + other.sagittas[nearest]
        deepest = int(np.argmax(depths - allowed))
        x, y = points[deepest].tolist()
        return Intrusion(float(depths[deepest]), (x, y), float(allowed[deepest]))


def deepest_intrusion(one: Boundary, other: Boundary) -> Intrusion | None:
    """Where two bodies overlap most, beyond what the chords of curves explain; None where nothing lies in the other."""
    found = [each for each in (one.within(other), other.within(one)) if each is not None]
    return max(found, key=lambda each: each.depth - each.allowed, default=None)


def sagittas_of(drawn: Floats, deformed: Floats, joints: tuple[Ints, Ints]) -> Floats:
    """Sagittas of edges, the largest of each one's own and its neighbours', shape (n,); see `Boundary.of`."""
    n = len(drawn)
    starting = np.argsort(joints[0], kind="stable")
    place = np.minimum(np.searchsorted(joints[0][starting], joints[1]), n - 1)
    following = starting[place]
    meets = joints[0][following] == joints[1]
    was, now = (turns_of(edges, following) for edges in (drawn, deformed[:, [0, -1]]))
    curved = np.where(meets & (np.abs(was) < SHARP), was, 0.0)
    added = np.where(meets, np.abs(np.remainder(now - was + np.pi, 2.0 * np.pi) - np.pi), 0.0)
    previous = np.full(n, -1)
    previous[following[meets]] = np.flatnonzero(meets)
    first, last = previous < 0, ~meets
    added_before = np.where(first, 0.0, added[previous])
    at_start, at_end = np.where(first, 0.0, curved[previous]), curved
    # of the two halves of a chord, as on dual polygons, each has a turn at one end: that of the other half is its own
    ends = ~first & (np.abs(was[previous]) <= STRAIGHT), ~last & (np.abs(was) <= STRAIGHT)
    half = ends[0] ^ ends[1]
    at_start, at_end = (
        np.where(half & ends[0], at_start[previous], at_start),
        np.where(half & ends[1], at_end[following], at_end),
    )
    # where a chain ends, its last edge is taken for one on the curve of the turn before
    at_start, at_end = np.where(first, at_end, at_start), np.where(last, at_start, at_end)
    smooth = np.where(at_start * at_end > 0.0, np.minimum(np.abs(at_start), np.abs(at_end)), 0.0)
    lengths = np.linalg.norm(deformed[:, -1] - deformed[:, 0], axis=1)
    own = lengths / 8.0 * (np.where(half, 2.0, 1.0) * smooth + (added + added_before))
    chord = (deformed[:, -1] - deformed[:, 0]) / lengths[:, None]
    inner = deformed[:, 1:-1] - deformed[:, :1]
    bulge = np.abs(inner[..., 0] * chord[:, None, 1] - inner[..., 1] * chord[:, None, 0]).max(axis=1, initial=0.0)
    own = np.maximum(own, bulge)
    result = own.copy()
    np.maximum.at(result, following[meets], own[meets])
    result[meets] = np.maximum(result[meets], own[following[meets]])
    return result


def turns_of(edges: Floats, following: Ints) -> Floats:
    """Angle from each edge (n, 2, 2) to the one that follows."""
    chords = edges[:, 1] - edges[:, 0]
    after = chords[following]
    cross = chords[:, 0] * after[:, 1] - chords[:, 1] * after[:, 0]
    turns: Floats = np.arctan2(cross, (chords * after).sum(axis=1))
    return turns


def _boxes_meet(segments: Floats, others: Floats) -> Bools:
    """Whether the bounding boxes of segments meet the box round all the others."""
    low, high = others.min(axis=(0, 1)), others.max(axis=(0, 1))
    meets: Bools = ((segments.max(axis=1) >= low) & (segments.min(axis=1) <= high)).all(axis=1)
    return meets


def _crossings(segments: Floats, others: Floats) -> tuple[Ints, Floats]:
    """Segments that cross others, and the shares of their lengths at which they do, each (c,)."""
    if len(segments) == 0:
        return np.empty(0, dtype=np.int64), np.empty(0)
    i, j = candidate_pairs(segments, others, 0.0)
    along, other = segments[i, 1] - segments[i, 0], others[j, 1] - others[j, 0]
    apart = others[j, 0] - segments[i, 0]
    area = along[:, 0] * other[:, 1] - along[:, 1] * other[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (apart[:, 0] * other[:, 1] - apart[:, 1] * other[:, 0]) / area
        t = (apart[:, 0] * along[:, 1] - apart[:, 1] * along[:, 0]) / area
    cross = (s > 0.0) & (s < 1.0) & (t >= 0.0) & (t <= 1.0)
    return i[cross], s[cross]


def _chunks(n: int, width: int) -> list[slice]:
    size = max(1, ENTRIES_PER_CHUNK // max(width, 1))
    return [slice(first, first + size) for first in range(0, n, size)]
