"""Where two segments meet, and where an outline crosses itself."""

import math
from collections.abc import Sequence

import numpy as np

from flangeway.geometry.arrays import cross_product
from flangeway.geometry.segments import Arc, Line, Segment
from flangeway.types import Floats


def crossing_shares(starts: Floats, steps: Floats, others: Floats, other_steps: Floats) -> tuple[Floats, Floats]:
    """Return where straight segments, starts and steps to their ends (..., 2), cross others: shares of both steps.

    Segments cross where both are between 0 and 1; those of parallel ones are not finite.
    """
    apart, area = others - starts, cross_product(steps, other_steps)
    with np.errstate(divide="ignore", invalid="ignore"):
        return cross_product(apart, other_steps) / area, cross_product(apart, steps) / area


def _line_line(a: Line, b: Line) -> list[Floats]:
    p, r = np.array(a.start), np.array(a.end) - np.array(a.start)
    q, s = np.array(b.start), np.array(b.end) - np.array(b.start)
    parallel = abs(cross_product(r, s)) <= 1e-14 * a.length * b.length
    return [] if parallel else [p + crossing_shares(p, r, q, s)[0] * r]


def _line_arc(a: Line, b: Arc) -> list[Floats]:
    p = np.array(a.start)
    unit = (np.array(a.end) - p) / a.length
    foot = p + unit * ((np.array(b.centre) - p) @ unit)
    square = b.radius**2 - float(np.sum((foot - np.array(b.centre)) ** 2))
    if square < 0.0:
        return []
    half = math.sqrt(square)
    return [foot - half * unit, foot + half * unit]


def _arc_arc(a: Arc, b: Arc) -> list[Floats]:
    c = np.array(a.centre)
    d = np.array(b.centre) - c
    distance = float(np.hypot(*d))
    if distance <= 1e-14 * (a.radius + b.radius):
        return []
    along = (distance**2 + (a.radius - b.radius) * (a.radius + b.radius)) / (2.0 * distance)
    square = (a.radius - along) * (a.radius + along)
    if square < 0.0:
        return []
    unit = d / distance
    across = math.sqrt(square) * np.array([-unit[1], unit[0]])
    return [c + along * unit - across, c + along * unit + across]


def meetings(a: Segment, b: Segment, tolerance: float) -> Floats:
    """Return the points (n, 2) that two segments have in common, to a distance `tolerance`.

    Of an overlap the ends are returned. A point may be returned more than once.
    """
    if isinstance(a, Line):
        crossed = _line_line(a, b) if isinstance(b, Line) else _line_arc(a, b)
    else:
        crossed = _line_arc(b, a) if isinstance(b, Line) else _arc_arc(a, b)
    candidates = np.array([*crossed, a.start, a.end, b.start, b.end])
    near = (a.closest(candidates)[1] <= tolerance) & (b.closest(candidates)[1] <= tolerance)
    return candidates[near]


def first_crossing(segments: Sequence[Segment], *, closed: bool, tolerance: float) -> tuple[int, int, Floats] | None:
    """Return the numbers of two segments of a chain that meet elsewhere than at their joint, and where (2,); or None.

    The tolerance is the distance below which points count as the same.
    """
    n = len(segments)
    boxes = np.array([segment.bounds for segment in segments])
    low, high = boxes[:, 0] - tolerance, boxes[:, 1] + tolerance
    for i in range(n - 1):
        later = slice(i + 1, n)
        beside = np.all((low[later] <= high[i]) & (low[i] <= high[later]), axis=1)
        for j in (i + 1 + np.flatnonzero(beside)).tolist():
            # the boxes of most neighbours have the joint's surroundings alone in common
            if (
                j == i + 1
                and float((np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])).max()) < 500 * tolerance
            ):
                continue
            found = meetings(segments[i], segments[j], tolerance)
            joints = [segments[i].end] if j == i + 1 else []
            if closed and i == 0 and j == n - 1:
                joints.append(segments[i].start)
            for joint in joints:
                # tangent neighbours meet over a length that grows with the root of rounding
                found = found[np.hypot(*(found - np.array(joint)).T) > 1e3 * tolerance]
            if len(found):
                return i, j, found[0]
    return None


def chains_meet(first: Sequence[Segment], second: Sequence[Segment], tolerance: float) -> Floats | None:
    """Return a point (2,) that two chains of segments have in common, or None."""
    boxes = np.array([segment.bounds for segment in second])
    for a in first:
        low, high = a.bounds
        beside = np.all((boxes[:, 0] <= high + tolerance) & (low <= boxes[:, 1] + tolerance), axis=1)
        for j in np.flatnonzero(beside).tolist():
            found = meetings(a, second[j], tolerance)
            if len(found):
                place: Floats = found[0]
                return place
    return None
