"""Curves: the two kinds of segment of an outline, straight lines and circular arcs, and splines through points."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import (
    Point,
    angles_of,
    as_point,
    as_points,
    chain_lengths,
    cross_product,
    frozen,
    norms,
    root_parameters,
    step_lengths,
    turned_right,
)
from flangeway.geometry.placement import Placement
from flangeway.types import Floats, Ints, floats

# --- The two kinds of segment of an outline, straight lines and circular arcs; where two meet, and an outline itself.
#
# A parameter `s` runs from 0 at the start to 1 at the end, in proportion to the length. The normal is to the right of
# the direction of travel, so it points outward on a counter-clockwise outline.


RADIUS_TOLERANCE = 1e-5  # maximum difference of an arc's two radii, relative to the radius (files carry 6 decimals)


def _parameters(s: ArrayLike) -> Floats:
    """Return the parameters as an array (n,)."""
    return np.atleast_1d(floats(s))


def _fixed(rows: list[list[float]]) -> Floats:
    """Return an array that is kept and therefore cannot be changed."""
    return frozen(np.array(rows))


def _pieces(segment: "Segment", parameters: ArrayLike) -> Iterator[tuple[Point, Point]]:
    """Return the ends of the pieces of a segment between inner cuts, in order."""
    cuts = np.unique(_parameters(parameters))
    if not np.all((cuts > 0.0) & (cuts < 1.0)):
        raise InputError(f"split at the parameters {cuts}", "parameters inside (0, 1)", "leave the ends out")
    return itertools.pairwise(map(as_point, segment.point([0.0, *cuts.tolist(), 1.0])))


@dataclass(frozen=True)
class Line:
    """Straight segment from `start` to `end`.

    Raises
    ------
    InputError
        If a coordinate is not finite or both ends coincide.
    """

    start: Point
    end: Point

    def __post_init__(self) -> None:
        """Check the ends."""
        object.__setattr__(self, "start", as_point(self.start, "start of a line"))
        object.__setattr__(self, "end", as_point(self.end, "end of a line"))
        _refuse_zero_length("line", self.start, self.end)

    @cached_property
    def step(self) -> Floats:
        """From the start to the end, (2,)."""
        return _fixed([[self.end[0] - self.start[0], self.end[1] - self.start[1]]])[0]

    @cached_property
    def length(self) -> float:
        """Length."""
        return math.dist(self.start, self.end)

    @property
    def curvature(self) -> float:
        """Zero."""
        return 0.0

    @cached_property
    def bounds(self) -> Floats:
        """Lower-left and upper-right corner (2, 2)."""
        (a, b), (c, d) = self.start, self.end
        return _fixed([[min(a, c), min(b, d)], [max(a, c), max(b, d)]])

    def point(self, s: ArrayLike) -> Floats:
        """Return the points (n, 2) at the parameters (n,)."""
        t = _parameters(s)[:, None]
        # both ends exact
        return (1.0 - t) * np.array(self.start) + t * np.array(self.end)

    def tangent(self, s: ArrayLike) -> Floats:
        """Return the unit tangents (n, 2) in the direction of travel."""
        return np.tile(self.step / self.length, (len(_parameters(s)), 1))

    def normal(self, s: ArrayLike) -> Floats:
        """Return the unit normals (n, 2), right of the direction of travel."""
        return turned_right(self.tangent(s))

    def reversed(self) -> "Line":
        """Return the same segment travelled backwards."""
        return Line(self.end, self.start)

    def transformed(self, placement: Placement) -> "Line":
        """Return the segment in the placed frame."""
        start, end = placement.points([self.start, self.end])
        return Line(as_point(start), as_point(end))

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Return parameters (n,) and distances (n,) of the closest points of the segment."""
        given = as_points(points)
        step = self.step
        s = np.clip((given - np.array(self.start)) @ step / (step @ step), 0.0, 1.0)
        return s, norms(given - self.point(s))

    def split(self, parameters: ArrayLike) -> tuple["Line", ...]:
        """Return the pieces between the parameters (each inside (0, 1)), in order."""
        return tuple(Line(a, b) for a, b in _pieces(self, parameters))


@dataclass(frozen=True)
class Arc:
    """Circular segment from `start` to `end` about `centre`, less than a full turn.

    Files round coordinates, so the two radii may differ by 1e-5 of the radius; the ends are then
    kept and the centre is moved onto their perpendicular bisector, which makes all three agree.

    Raises
    ------
    InputError
        If a coordinate is not finite, both ends coincide, or the radii differ by more.
    """

    start: Point
    end: Point
    centre: Point
    counter_clockwise: bool | None = None

    def __post_init__(self) -> None:
        """Check the points and move the centre onto the bisector of the ends."""
        if not isinstance(self.counter_clockwise, bool | np.bool_):
            raise InputError(
                f"Arc(counter_clockwise={short(self.counter_clockwise)})",
                "True or False: which way it runs from start to end about the centre",
                "give counter_clockwise; both directions join the same ends",
            )
        start = as_point(self.start, "start of an arc")
        end = as_point(self.end, "end of an arc")
        given = as_point(self.centre, "centre of an arc")
        _refuse_zero_length("arc", start, end)
        radii = math.dist(start, given), math.dist(end, given)
        chord = math.dist(start, end)
        along = ((end[0] - start[0]) / chord, (end[1] - start[1]) / chord)
        middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
        off = (given[0] - middle[0]) * along[0] + (given[1] - middle[1]) * along[1]
        radius = max(radii)
        if min(radii) <= 0.0 or abs(radii[0] - radii[1]) > RADIUS_TOLERANCE * radius:
            raise InputError(
                f"arc from {start} to {end} about {given}: radii {radii[0]:.9g} and {radii[1]:.9g}",
                f"equal radii to {RADIUS_TOLERANCE:g} of the radius",
                "correct the centre or an end of this arc",
            )
        centre = (given[0] - off * along[0], given[1] - off * along[1])
        for name, value in (("start", start), ("end", end), ("centre", centre)):
            object.__setattr__(self, name, value)

    @cached_property
    def radius(self) -> float:
        """Radius, positive."""
        return math.dist(self.start, self.centre)

    @cached_property
    def start_angle(self) -> float:
        """Angle of the start about the centre, in (-pi, pi]."""
        return math.atan2(self.start[1] - self.centre[1], self.start[0] - self.centre[0])

    @cached_property
    def sweep(self) -> float:
        """Angle travelled: in (0, 2 pi) if counter-clockwise, in (-2 pi, 0) if clockwise."""
        a = (self.start[0] - self.centre[0], self.start[1] - self.centre[1])
        b = (self.end[0] - self.centre[0], self.end[1] - self.centre[1])
        # from the cross product: short arcs of large radius keep their digits
        turn = math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
        if self.counter_clockwise:
            return turn if turn > 0.0 else turn + 2.0 * math.pi
        return turn if turn < 0.0 else turn - 2.0 * math.pi

    @cached_property
    def length(self) -> float:
        """Length along the arc."""
        return self.radius * abs(self.sweep)

    @property
    def curvature(self) -> float:
        """``1 / radius``, positive if counter-clockwise (convex on an outline)."""
        return math.copysign(1.0 / self.radius, self.sweep)

    @cached_property
    def bounds(self) -> Floats:
        """Lower-left and upper-right corner (2, 2), with the extremes between the ends."""
        quarter = 0.5 * math.pi
        low, high = sorted((self.start_angle, self.start_angle + self.sweep))
        # a pole at an end is the end itself, without rounding
        first, last = math.ceil(low / quarter + 1e-9), math.floor(high / quarter - 1e-9)
        poles = [((1, 0), (0, 1), (-1, 0), (0, -1))[number % 4] for number in range(first, last + 1)]
        x, y = ([c + self.radius * pole[axis] for pole in poles] for axis, c in enumerate(self.centre))
        x, y = ([*extremes, self.start[axis], self.end[axis]] for axis, extremes in enumerate((x, y)))
        return _fixed([[min(x), min(y)], [max(x), max(y)]])

    def point(self, s: ArrayLike) -> Floats:
        """Return the points (n, 2) at the parameters (n,); the ends are returned exactly."""
        t = _parameters(s)
        angle = self.sweep * t
        ray = np.array(self.start) - np.array(self.centre)
        cosine, sine = np.cos(angle), np.sin(angle)
        points: Floats = np.array(self.centre) + np.column_stack(
            [cosine * ray[0] - sine * ray[1], sine * ray[0] + cosine * ray[1]]
        )
        points[t == 0.0] = self.start
        points[t == 1.0] = self.end
        return points

    def tangent(self, s: ArrayLike) -> Floats:
        """Return the unit tangents (n, 2) in the direction of travel."""
        return -turned_right(self.normal(s))

    def normal(self, s: ArrayLike) -> Floats:
        """Return the unit normals (n, 2), right of the direction of travel."""
        rays: Floats = self.point(s) - np.array(self.centre)
        rays *= math.copysign(1.0, self.sweep) / norms(rays)[:, None]
        return rays

    def reversed(self) -> "Arc":
        """Return the same segment travelled backwards."""
        return Arc(self.end, self.start, self.centre, not self.counter_clockwise)

    def transformed(self, placement: Placement) -> "Arc":
        """Return the segment in the placed frame."""
        start, end, centre = (tuple(point) for point in placement.points([self.start, self.end, self.centre]).tolist())
        return Arc(start, end, centre, self.counter_clockwise != placement.mirrored)

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Return parameters (n,) and distances (n,) of the closest points of the segment.

        From the centre all points are equally far: the parameter is then arbitrary.
        """
        given = as_points(points)
        rays = given - np.array(self.centre)
        angle = angles_of(rays) - self.start_angle
        angle = np.mod(math.copysign(1.0, self.sweep) * angle, 2.0 * math.pi)
        opening = abs(self.sweep)
        # beyond the end: the nearer of both ends, divided at the middle of the gap
        outside = np.where(angle < 0.5 * opening + math.pi, 1.0, 0.0)
        s = np.where(angle <= opening, angle / opening, outside)
        return s, norms(given - self.point(s))

    def split(self, parameters: ArrayLike) -> tuple["Arc", ...]:
        """Return the pieces between the parameters (each inside (0, 1)), in order."""
        return tuple(Arc(a, b, self.centre, self.counter_clockwise) for a, b in _pieces(self, parameters))


Segment: TypeAlias = Line | Arc


def segment_of(start: Point, end: Point, centre: Point | None, counter_clockwise: bool) -> Segment:
    """Return the arc about a centre, or without one the line."""
    return Line(start, end) if centre is None else Arc(start, end, centre, counter_clockwise)


def _refuse_zero_length(kind: str, start: Point, end: Point) -> None:
    size = max(map(abs, (*start, *end)))
    if math.dist(start, end) <= 1e-14 * size:
        raise InputError(
            f"{kind} from {start} to {end} with zero length",
            "two ends that differ",
            "remove the duplicate point, or make a full circle of two arcs",
        )


def halved(segments: Sequence[Segment], maximum_sweep: float) -> list[tuple[Segment, int]]:
    """Return the segments with arcs cut into equal pieces no wider than an angle.

    Returned: pairs (piece, number of the segment it comes from), in order.
    """
    pieces: list[tuple[Segment, int]] = []
    for number, segment in enumerate(segments):
        count = math.ceil(abs(segment.sweep) / maximum_sweep) if isinstance(segment, Arc) else 1
        cuts = np.arange(1, count) / count
        pieces.extend((piece, number) for piece in (segment.split(cuts) if count > 1 else (segment,)))
    return pieces


def crossing_shares(starts: Floats, steps: Floats, others: Floats, other_steps: Floats) -> tuple[Floats, Floats]:
    """Return where straight segments, starts and steps to their ends (..., 2), cross others: shares of both steps.

    Segments cross where both are between 0 and 1; those of parallel ones are not finite.
    """
    apart, area = others - starts, cross_product(steps, other_steps)
    with np.errstate(divide="ignore", invalid="ignore"):
        return cross_product(apart, other_steps) / area, cross_product(apart, steps) / area


def _line_line(a: Line, b: Line) -> list[Floats]:
    p, q = np.array(a.start), np.array(b.start)
    parallel = abs(cross_product(a.step, b.step)) <= 1e-14 * a.length * b.length
    return [] if parallel else [p + crossing_shares(p, a.step, q, b.step)[0] * a.step]


def _line_arc(a: Line, b: Arc) -> list[Floats]:
    p = np.array(a.start)
    unit = a.step / a.length
    foot = p + unit * ((np.array(b.centre) - p) @ unit)
    square = b.radius**2 - float(np.sum((foot - np.array(b.centre)) ** 2))
    if square < 0.0:
        return []
    half = math.sqrt(square)
    return [foot - half * unit, foot + half * unit]


def _arc_arc(a: Arc, b: Arc) -> list[Floats]:
    c = np.array(a.centre)
    d = np.array(b.centre) - c
    distance = float(norms(d))
    if distance <= 1e-14 * (a.radius + b.radius):
        return []
    along = (distance**2 + (a.radius - b.radius) * (a.radius + b.radius)) / (2.0 * distance)
    square = (a.radius - along) * (a.radius + along)
    if square < 0.0:
        return []
    unit = d / distance
    across = math.sqrt(square) * turned_right(unit)
    return [c + along * unit + across, c + along * unit - across]


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


def _beside(first: Sequence[Segment], second: Sequence[Segment], tolerance: float) -> Ints:
    """Return the numbers (n, 2) of segments of two chains, in order, whose boxes overlap to a tolerance."""
    corners = [np.reshape([segment.bounds for segment in chain], (-1, 4)) for chain in (first, second)]
    boxes = [shapely.box(*(ends + 0.5 * tolerance * np.array([-1.0, -1.0, 1.0, 1.0])).T) for ends in corners]
    return np.unique(shapely.STRtree(boxes[1]).query(boxes[0]).T, axis=0)


def first_crossing(segments: Sequence[Segment], *, closed: bool, tolerance: float) -> tuple[int, int, Floats] | None:
    """Return the numbers of two segments of a chain that meet elsewhere than at their joint, and where (2,); or None.

    The tolerance is the distance below which points count as the same.
    """
    for i, j in _beside(segments, segments, 2.0 * tolerance).tolist():
        (low, high), (other_low, other_high) = segments[i].bounds, segments[j].bounds
        # the boxes of most neighbours have the joint's surroundings alone in common
        common = float((np.minimum(high, other_high) - np.maximum(low, other_low)).max())
        if i >= j or (j == i + 1 and common < 498 * tolerance):
            continue
        points = meetings(segments[i], segments[j], tolerance)
        joints = [segments[i].end] if j == i + 1 else []
        if closed and i == 0 and j == len(segments) - 1:
            joints.append(segments[i].start)
        for joint in joints:
            # tangent neighbours meet over a length that grows with the root of rounding
            points = points[norms(points - np.array(joint)) > 1e3 * tolerance]
        if len(points):
            return i, j, points[0]
    return None


def chains_meet(first: Sequence[Segment], second: Sequence[Segment], tolerance: float) -> Floats | None:
    """Return a point (2,) that two chains of segments have in common, or None."""
    for i, j in _beside(first, second, 2.0 * tolerance).tolist():
        points = meetings(first[i], second[j], tolerance)
        if len(points):
            return points[0]
    return None


# --- Smooth curve through points, which edges of a mesh can follow.


SAMPLES = 16  # between two points, to start the search of the closest place
CLOSURE_TOLERANCE = 1e-12  # distance of the ends relative to the coordinates, below which it is round-off


@dataclass(frozen=True, eq=False)
class Spline:
    """Cubic spline through points, with continuous curvature; parameters in proportion to the lengths of the chords.

    Without a condition on the slope at open ends ("not a knot"). Closed if the first point is repeated at the end, up
    to `CLOSURE_TOLERANCE` of the coordinates.

    Parameters
    ----------
    points
        Points (n, 2) in order, 4 or more.

    Raises
    ------
    InputError
        If there are fewer points, one is not finite, or two neighbours coincide.
    """

    points: Floats

    def __post_init__(self) -> None:
        """Check the points and keep a read-only copy."""
        points = as_points(self.points, "points of a spline").copy()
        if len(points) < 4:
            raise InputError(f"a spline through {len(points)} points", "4 points or more", "add points, or take an Arc")
        if (step_lengths(points) <= 1e-14 * np.abs(points).max()).any():
            raise InputError("a spline that has a point twice in a row", "neighbours that differ", "remove one")
        if np.abs(points[-1] - points[0]).max() <= CLOSURE_TOLERANCE * np.abs(points).max():
            points[-1] = points[0]
        object.__setattr__(self, "points", frozen(points))

    @property
    def closed(self) -> bool:
        """Whether the curve ends where it starts, smoothly."""
        return bool((self.points[0] == self.points[-1]).all())

    @cached_property
    def _curve(self) -> CubicSpline:
        along = chain_lengths(self.points)
        return CubicSpline(along / along[-1], self.points, bc_type="periodic" if self.closed else "not-a-knot")

    @cached_property
    def _samples(self) -> tuple[Floats, cKDTree]:
        knots = self._curve.x
        parameters = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(SAMPLES) / SAMPLES).ravel(), 1.0)
        return parameters, cKDTree(self._curve(parameters))

    def _inside(self, s: Floats) -> Floats:
        return np.mod(s, 1.0) if self.closed else np.clip(s, 0.0, 1.0)

    def point(self, s: ArrayLike) -> Floats:
        """Return the points (n, 2) at parameters (n,) from 0 to 1; on a closed curve they go around."""
        return self._curve(self._inside(np.atleast_1d(floats(s))))

    def closest(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Return parameters (n,) and distances (n,) of the closest points, by Newton's method from the best sample."""
        given = as_points(points)
        parameters, tree = self._samples
        s = parameters[tree.query(given)[1]]

        def change(s: Floats) -> Floats:
            off, slope, bend = self.point(s) - given, self._curve(s, 1), self._curve(s, 2)
            squares = (slope**2).sum(axis=1)
            return (off * slope).sum(axis=1) / np.maximum(squares + (off * bend).sum(axis=1), 0.1 * squares)

        s = root_parameters(change, s, 1.0 / (SAMPLES * (len(self.points) - 1)), 1e-15, self._inside)
        return s, norms(given - self.point(s))

    def transformed(self, placement: Placement) -> "Spline":
        """Return the curve in the placed frame, with the same parameters."""
        return Spline(placement.points(self.points))
