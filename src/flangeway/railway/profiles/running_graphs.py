"""Parts of a profile that a wheel coming down can touch: graphs over the lateral coordinate, between overhangs."""

import math

import numpy as np

from flangeway.geometry import Contour, Segment
from flangeway.types import Floats

STEEPEST_RAD = math.radians(89.0)
"""Steeper parts of a profile are left out: a wheel that comes from above cannot touch there first."""
MAX_CLIPPED = 0.5
"""Width of a part beyond an overhang over that of the running surface, above which it may be a second one."""


def graphs_of(contour: Contour, steepest_rad: float = STEEPEST_RAD) -> list[Floats]:
    """Return the parts of a contour that are less steep than an angle, the widest first; up to 90 degrees x grows.

    Each is a table (n, 5) of its pieces: x and y of the start, angle of the tangent there, curvature, length.
    """
    if contour.ends[1][0] < contour.ends[0][0]:
        contour = contour.reversed()
    runs: list[list[tuple[float, ...]]] = [[]]
    for segment in contour.segments:
        row, reaches_start, reaches_end = _running_part(segment, steepest_rad)
        if not reaches_start:
            runs.append([])
        if row is not None:
            runs[-1].append(row)
        if not reaches_end:
            runs.append([])
    return sorted((np.array(run) for run in runs if run), key=extent, reverse=True)


def extent(rows: Floats) -> float:
    """Return the width in x of such a part."""
    return float(rows[:, 4] @ np.cos(rows[:, 2] + 0.5 * rows[:, 3] * rows[:, 4]))


def _running_part(segment: Segment, steepest_rad: float) -> tuple[tuple[float, ...] | None, bool, bool]:
    """Part of a segment that is not too steep, and whether it reaches the segment's start and end.

    Returned: x, y, angle, curvature and length of the part, or None; two flags.
    """
    tangent = segment.tangent(0.0)[0]
    angle = math.atan2(tangent[1], tangent[0])
    curvature = segment.curvature
    first, last = 0.0, segment.length
    if curvature == 0.0:
        if abs(angle) > steepest_rad:
            return None, False, False
    else:
        # the lengths at which the angle takes both limits; files give arcs shorter than half a turn
        limits = sorted(((-steepest_rad - angle) / curvature, (steepest_rad - angle) / curvature))
        first, last = max(first, limits[0]), min(last, limits[1])
        if last - first < 1e-9 * segment.length:
            return None, False, False
    start = segment.point(first / segment.length)[0]
    row = (float(start[0]), float(start[1]), angle + curvature * first, curvature, last - first)
    return row, first == 0.0, last == segment.length
