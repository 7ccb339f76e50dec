"""Closed outlines from what a file draws: duplicate points and direction repaired with a notice, the rest refused."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry.arrays import Point, point_text
from flangeway.geometry.contour import JOINT_TOLERANCE, _joined
from flangeway.geometry.outline import Outline
from flangeway.geometry.segments import Arc, Line, Segment

MAX_COORDINATE = 1e30  # so that the sixth power of a length, and products of such, stay within floating-point numbers


@dataclass(frozen=True)
class DrawnSegment:
    """Line, or arc if it has a centre, as a file gives it: not checked yet."""

    start: Point
    end: Point
    centre: Point | None = None
    counter_clockwise: bool = True
    name: str = "side"

    def checked(self) -> Segment:
        """Return the segment; see `Line` and `Arc` for what is refused."""
        if self.centre is None:
            return Line(self.start, self.end)
        return Arc(self.start, self.end, self.centre, self.counter_clockwise)


def drawn_polygon(points: Sequence[Point]) -> list[DrawnSegment]:
    """Return the sides ``side_1`` and so on, from each point to the next and from the last to the first."""
    ends = zip(points, [*points[1:], points[0]], strict=True)
    return [DrawnSegment(a, b, name=f"side_{number}") for number, (a, b) in enumerate(ends, 1)]


def drawn_circle(centre: Point, radius: float, name: str = "circle") -> list[DrawnSegment]:
    """Return a circle of four arcs, counter-clockwise."""
    x, y = centre
    ends = [(x + radius, y), (x, y + radius), (x - radius, y), (x, y - radius)]
    return [
        DrawnSegment(a, b, centre, counter_clockwise=True, name=name)
        for a, b in zip(ends, ends[1:] + ends[:1], strict=True)
    ]


def repaired_outline(
    drawn: Sequence[DrawnSegment], what: str, *, direction_matters: bool = True
) -> tuple[Outline, tuple[str, ...]]:
    """Return a counter-clockwise outline of segments in order, and a notice of each thing that was repaired.

    Repaired are points given twice (lines shorter than `JOINT_TOLERANCE` of the whole) and a clockwise direction, with
    a notice if it matters. An `InputError` if a number is not finite, the loop is open, meets itself or has no area; it
    calls the loop `what` and names the position.
    """
    if not drawn:
        raise InputError(f"{what}: no segment", "two segments or more", "draw the loop")
    _refuse_not_finite(drawn, what)
    kept, notices = _without_duplicates(drawn, what)
    _refuse_flat(kept or drawn, what)
    try:
        segments = tuple(segment.checked() for segment in kept)
        names = [segment.name for segment in kept]
        outline = Outline.from_segments(segments, names)
    except InputError as reason:
        raise InputError(f"{what}: {reason.given}", reason.allowed, reason.advice) from reason
    if direction_matters and Outline._trusted(_joined(segments, closed=True), tuple(names))._signed_area < 0.0:
        notices.append(f"{what}: drawn clockwise; its direction is reversed.")
    return outline, tuple(notices)


def _refuse_not_finite(drawn: Sequence[DrawnSegment], what: str) -> None:
    for number, segment in enumerate(drawn):
        for kind, point in (("start", segment.start), ("end", segment.end), ("centre", segment.centre)):
            if point is not None and not all(abs(coordinate) <= MAX_COORDINATE for coordinate in point):
                raise InputError(
                    f"{what}: {kind} of segment {number} ({segment.name}) is ({point[0]}, {point[1]})",
                    f"finite coordinates up to {MAX_COORDINATE:g}",
                    "repair or remove this point",
                )


def _without_duplicates(drawn: Sequence[DrawnSegment], what: str) -> tuple[list[DrawnSegment], list[str]]:
    """Leave out lines without length, and say where they were."""
    ends = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    tolerance = JOINT_TOLERANCE * float(np.hypot(*np.ptp(ends, axis=0)))
    kept, notices = [], []
    for segment in drawn:
        if segment.centre is None and math.dist(segment.start, segment.end) <= tolerance:
            notices.append(f"{what}: the point {point_text(segment.start)} is given twice; one of both is left out.")
        else:
            kept.append(segment)
    return kept, notices


def _refuse_flat(drawn: Sequence[DrawnSegment], what: str) -> None:
    """Refuse points on one line: they would be found as sides that overlap, which explains less."""
    points = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    local = points - points[0]
    spread = np.linalg.svd(local, compute_uv=False)
    if any(segment.centre is not None for segment in drawn) or spread[-1] > 1e-12 * max(spread[0], 1e-300):
        return
    raise InputError(
        f"{what}: no area, since all of its points lie on one line through {point_text(points[0])}",
        "a loop that encloses an area",
        "check the points",
    )
