"""Segments that touch or cross."""

from dataclasses import dataclass

import numpy as np
import shapely

from flangeway.geometry.arrays import IntArray, cross_product
from flangeway.types import Floats, Ints

TOUCHING = 1e-6
"""Distance of a point from a segment, over the shorter of it and the point's own, up to which they touch."""

ROUNDING = 1e-9
"""Distance over the size of the mesh up to which they touch where the segments are short, by files' few digits."""


def touching_distance(lengths: Floats, points: Floats) -> Floats:
    """Distance up to which segments of some lengths (n,) touch in a mesh of points (n_points, 2)."""
    rounding = ROUNDING * float(np.ptp(points, axis=0).max())
    return np.clip(rounding, TOUCHING * lengths, 0.01 * lengths)


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where segments come together other than at a common end.

    Segments ``on`` which a point of another one lies, the other segments ``of``, and these points, each (n_touches,);
    pairs (n_crossings, 2) of segments that cross and do not touch.
    """

    on: Ints
    of: Ints
    points: Ints
    crossing: Ints


def meeting(points: Floats, segments: IntArray) -> Meeting:
    """Find the segments, numbers of start and end (n, 2) among points (n_points, 2), that touch or cross.

    They may meet at a point that is an end of both.
    """
    reach = touching_distance(np.hypot(*(points[segments[:, 1]] - points[segments[:, 0]]).T), points)
    lines = shapely.linestrings(points[segments])
    i, j = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    return _examined(points, segments, reach, *np.sort((i, j), axis=0)[:, i != j])


def _examined(points: Floats, segments: IntArray, reach: Floats, i: Ints, j: Ints) -> Meeting:
    """Touches and crossings of pairs (i, j), i < j, each of which may be given twice."""
    i, j = np.unique(np.column_stack((i, j)), axis=0).T
    (a, b), (c, d) = segments[i].T, segments[j].T
    u, v = points[b] - points[a], points[d] - points[c]
    nearest = np.minimum(reach[i], reach[j])
    touched = np.zeros(len(i), dtype=bool)
    touching = []
    turns = []
    for on, of, p, start, end, step in ((i, j, c, a, b, u), (i, j, d, a, b, u), (j, i, a, c, d, v), (j, i, b, c, d, v)):
        away = points[p] - points[start]
        turns.append(cross_product(step, away))
        along = np.einsum("ni,ni->n", away, step) / np.maximum(np.einsum("ni,ni->n", step, step), 1e-300)
        off = away - np.clip(along, 0.0, 1.0)[:, None] * step
        touches = (np.hypot(*off.T) <= nearest) & (p != start) & (p != end)
        touched |= touches
        touching.append((on[touches], of[touches], p[touches]))
    shared = (a == c) | (a == d) | (b == c) | (b == d)
    crosses = (turns[0] * turns[1] < 0.0) & (turns[2] * turns[3] < 0.0) & ~touched & ~shared
    on, of, met = (np.concatenate(part).astype(np.int64) for part in zip(*touching, strict=True))
    return Meeting(on, of, met, np.column_stack([i[crosses], j[crosses]]))
