"""Segments that touch or cross."""

from dataclasses import dataclass

import numpy as np
import shapely

from flangeway.geometry.arrays import IntArray, extent, norms
from flangeway.types import Floats, Ints

TOUCHING = 1e-6
"""Distance of a point from a segment, over the shorter of it and the point's own, up to which they touch."""

ROUNDING = 1e-9
"""Distance over the size of the mesh up to which they touch where the segments are short, by files' few digits."""


def touching_distance(lengths: Floats, points: Floats) -> Floats:
    """Distance up to which segments of some lengths (n,) touch in a mesh of points (n_points, 2)."""
    rounding = ROUNDING * extent(points)
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
    reach = touching_distance(norms(points[segments[:, 1]] - points[segments[:, 0]]), points)
    lines = shapely.linestrings(points[segments])
    i, j = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    i, j = np.stack((i, j))[:, i < j]
    touched, touching = np.zeros(len(i), dtype=bool), []
    for on, of in ((i, j), (j, i)):
        for p in segments[of].T:
            distances = shapely.distance(lines[on], shapely.points(points[p]))
            touches = (distances <= np.minimum(reach[i], reach[j])) & (segments[on] != p[:, None]).all(axis=1)
            touched |= touches
            touching.append((on[touches], of[touches], p[touches]))
    shared = (segments[i][:, :, None] == segments[j][:, None]).any(axis=(1, 2))
    crosses = shapely.crosses(lines[i], lines[j]) & ~touched & ~shared
    on, of, met = (np.concatenate(part).astype(np.int64) for part in zip(*touching, strict=True))
    return Meeting(on, of, met, np.column_stack([i[crosses], j[crosses]]))
