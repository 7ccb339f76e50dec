"""Profiles as rigid curves, and one rigid wheel over one rigid rail."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement
from flangeway.geometry.arrays import angles_of, norms
from flangeway.railway.profiles.smoothing import MAX_CLIPPED, STEEPEST_RAD, extent, graphs_of
from flangeway.railway.track.placements import RigidTrack, RigidWheelPair, Side, mirrored
from flangeway.types import Bools, Floats, Ints, floats

# --- Profiles as rigid curves of lines and arcs, evaluated for thousands of points at once.
#
# Both wheel and rail run from the gauge side to the field side, so that x grows along the curve. On a piece of
# curvature k the sine of the tangent's angle is linear in x, ``sin a = sin a0 + k (x - x0)``, and a chord has the mean
# angle of its ends, ``y - y0 = (x - x0) tan((a0 + a) / 2)``: lines and arcs share these two formulas.
#
# A wheel that is turned about the vertical touches with its outline across the track. It is a surface of revolution, a
# rail is a prism. In the longitudinal view the wheel is bounded below by the points whose normal lies across the track:
# where the profile has the angle ``a``, the point of its circle that is the angle ``t`` ahead of the lowest one,
# ``sin t = -tan a tan yaw``. Their outline has the angle ``b``, ``sin b = sin a / cos yaw``, and is a plane curve that
# comes down on the rail as a profile without yaw does. Roll turns the outline about the axis of the view.
#
# On a flange the points lie some millimetres to centimetres ahead of the axle, or behind it. Where the profile is so
# hollow that the outline would turn back, as in the flange root at large yaw, the lower envelope is taken: what turns
# back lies inside the wheel.


FACE_MM = 40.0  # height of the steep face below an end of a head that overhangs: below the tips of flanges
UPRIGHT_COSINE = np.finfo(float).eps
"""Cosine of the angle of an upright tangent: its slope stays a number."""


class CurvePoints(NamedTuple):
    """Points on a curve, arrays of one shape.

    - `angle`: angle of the tangent in radians, between -pi/2 and pi/2.
    - `curvature`: change of the angle per length along the curve, positive where the curve is hollow from above.
    """

    x: Floats
    y: Floats
    angle: Floats
    curvature: Floats


@dataclass(frozen=True, eq=False)
class RigidCurve:
    """Chain of lines and arcs along which x grows; tangents may jump at joints.

    - `starts`: first point of each piece, shape (n_pieces, 2).
    - `angles`: angle of the tangent there, shape (n_pieces,).
    - `curvatures`: curvature of each piece, positive when counter-clockwise, shape (n_pieces,).
    - `lengths`: length of each piece, shape (n_pieces,).
    """

    starts: Floats
    angles: Floats
    curvatures: Floats
    lengths: Floats

    def __post_init__(self) -> None:
        for name in ("starts", "angles", "curvatures", "lengths"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @classmethod
    def from_contour(
        cls,
        contour: Contour,
        placement: Placement | None = None,
        steepest_rad: float = STEEPEST_RAD,
        *,
        faces: bool = False,
    ) -> Self:
        """Return the widest part of a contour whose tangents are less steep than an angle.

        What lies beyond an overhang, as of a chamfer or a lip, is left out. An `InputError` if there is no such part,
        or another one is wider than `MAX_CLIPPED` of it.

        - `contour`: in either direction.
        - `placement`: where it is; untransformed by default.
        - `steepest_rad`: with more than 90 degrees x does not grow everywhere, and `over` has no meaning.
        - `faces`: whether a head has a steep face below an end at which the contour overhangs: a flange touches the
          edge of the steel there, while a contour that ends says nothing of what is below.
        """
        placement = placement or Placement()
        tables = _turned_graphs(contour, replace(placement, translation=(0.0, 0.0)), steepest_rad)
        if not tables:
            raise InputError("a profile without a running surface", "tangents that are not vertical", "check its axes")
        if len(tables) > 1 and extent(tables[1]) > MAX_CLIPPED * extent(tables[0]):
            x, y = tables[1][0, :2] + placement.translation
            raise InputError(
                f"a surface that overhangs at x = {x:.2f}, y = {y:.2f} mm",
                "one surface that runs from the gauge side to the field side",
                "check the profile's axes, and remove hooks of the measurement",
            )
        table = tables[0]
        curve = cls(table[:, :2] + placement.translation, table[:, 2], table[:, 3], table[:, 4])
        if not faces:
            return curve
        rows = [*np.column_stack((curve.starts, table[:, 2:]))]
        down = FACE_MM * np.array([math.cos(steepest_rad), math.sin(steepest_rad)])
        first, last = curve.starts[0], np.array(curve.at(curve.length)[:2])
        for number, end, start, angle in (
            (0, first, first - down, steepest_rad),
            (len(rows) + 1, last, last, -steepest_rad),
        ):
            if norms(placement.points(contour.ends) - end).min() > _APART_MM:
                rows.insert(number, np.array([*start, angle, 0.0, FACE_MM]))
        return cls(np.array(rows)[:, :2], *np.array(rows)[:, 2:].T)

    @classmethod
    def from_graph(cls, x: ArrayLike, y: ArrayLike, slope: ArrayLike) -> Self:
        """Return pairs of arcs through points of a smooth graph with its slopes.

        The tangent is continuous; between the points the error falls with the third power of their distance.

        - `x`, `y`, `slope`: increasing abscissae, heights and slopes, each (n,).
        """
        at, height = floats(x), floats(y)
        angle = np.arctan(floats(slope))
        if not (len(at) > 1 and (np.diff(at) > 0.0).all() and np.isfinite(height).all() and np.isfinite(angle).all()):
            raise InputError("a graph that is not one", "two or more points with increasing x", "sort the points")
        points, tangents = np.column_stack((at, height)), np.column_stack((np.cos(angle), np.sin(angle)))
        chord, first, last = np.diff(points, axis=0), tangents[:-1], tangents[1:]
        square, along = (chord**2).sum(axis=1), (chord * (first + last)).sum(axis=1)
        bend = 2.0 * (1.0 - (first * last).sum(axis=1))
        step = (square / (along + np.sqrt(along**2 + bend * square)))[:, None]
        middle = 0.5 * (points[:-1] + step * first + points[1:] - step * last)
        halves = np.stack((middle - points[:-1], points[1:] - middle), axis=1)
        # a chord has the mean angle of its arc's ends
        means = angles_of(halves)
        turns = 2.0 * np.stack((means[:, 0] - angle[:-1], angle[1:] - means[:, 1]), axis=1)
        lengths = norms(halves) / np.sinc(0.5 * turns / np.pi)
        starts = np.stack((points[:-1], middle), axis=1)
        angles = np.stack((angle[:-1], angle[1:] - turns[:, 1]), axis=1)
        return cls(starts.reshape(-1, 2), angles.ravel(), (turns / lengths).ravel(), lengths.ravel())

    def sampled(self, spacing_mm: float) -> CurvePoints:
        """Points along each piece, no farther apart than a spacing, both ends of each included, (n,)."""
        counts = np.ceil(self.lengths / spacing_mm).astype(np.int64) + 1
        piece, number = _repeated(counts)
        return self._along(piece, self.lengths[piece] * number / (counts[piece] - 1))

    @cached_property
    def offsets(self) -> Floats:
        """Length along the curve at the start of each piece, and at the end, shape (n_pieces + 1,)."""
        return np.concatenate(([0.0], np.cumsum(self.lengths)))

    @property
    def length(self) -> float:
        """Length of the whole curve."""
        return float(self.offsets[-1])

    @cached_property
    def joints(self) -> Floats:
        """X of the start of each piece, and of the end, shape (n_pieces + 1,)."""
        return np.append(self.starts[:, 0], self.at(np.array([self.length])).x)

    @cached_property
    def _directions(self) -> Floats:
        """Sine and cosine of `angles`, (2, n_pieces)."""
        return np.stack((np.sin(self.angles), np.cos(self.angles)))

    def at(self, arc_length: ArrayLike) -> CurvePoints:
        """Points at lengths along the curve from its start."""
        s = floats(arc_length)
        piece = np.clip(np.searchsorted(self.offsets, s, side="right") - 1, 0, len(self.lengths) - 1)
        return self._along(piece, s - self.offsets[piece])

    def _along(self, piece: Ints, local: Floats) -> CurvePoints:
        """Points at lengths from the start of pieces."""
        curvature, start_angle = self.curvatures[piece], self.angles[piece]
        half_turn = 0.5 * curvature * local
        chord = local * np.sinc(half_turn / np.pi)
        mean = start_angle + half_turn
        return CurvePoints(
            self.starts[piece, 0] + chord * np.cos(mean),
            self.starts[piece, 1] + chord * np.sin(mean),
            start_angle + 2.0 * half_turn,
            curvature,
        )

    def over(self, x: ArrayLike) -> CurvePoints:
        """Points at given x; beyond the ends the tangents there are prolonged, without curvature."""
        at = floats(x)
        height, slope, curvature = self.graph(at)
        return CurvePoints(at, height, np.arctan(slope), curvature)

    def graph(self, at: Floats) -> tuple[Floats, Floats, Floats]:
        """Heights, slopes and curvatures at given x, as `over`."""
        inside = np.clip(at, self.joints[0], self.joints[-1])
        piece = np.clip(np.searchsorted(self.joints, inside, side="right") - 1, 0, len(self.lengths) - 1)
        curvature, sine, cosine = self.curvatures[piece], *self._directions[:, piece]
        step = inside - self.starts[piece, 0]
        # sin(b) = sin(a) + k dx along an arc, and its chord has the slope tan((a + b) / 2)
        sine_there = np.clip(sine + curvature * step, -1.0, 1.0)
        cosine_there = np.sqrt(np.maximum(1.0 - sine_there**2, UPRIGHT_COSINE**2))
        height = self.starts[piece, 1] + step * (sine + sine_there) / (cosine + cosine_there)
        slope, beyond = sine_there / cosine_there, at - inside
        return height + beyond * slope, slope, np.where(beyond == 0.0, curvature, 0.0)

    def moved(self, x: float, y: float) -> "RigidCurve":
        """Return the curve after a translation."""
        return RigidCurve(self.starts + np.array([x, y]), self.angles, self.curvatures, self.lengths)


MAX_YAW_RAD = 0.2  # maximum yaw; beyond it steep flanges touch at the height of the axle

_CURVE_SPACING_MM = 0.1
_EDGE_STEP_RAD = 0.02
_MAX_SINE = 0.95
_SAME_POINT_MM = 1e-9
_APART_MM = 1e-5


def outline_across(profile: RigidCurve, yaw_rad: float) -> RigidCurve:
    """Outline of a yawed wheel in the longitudinal view.

    Returned: about the middle of the axle: x across the track, y up. Without yaw the profile itself. An `InputError` if
    the yaw is larger than `MAX_YAW_RAD`.

    - `profile`: about the middle of the axle: x along it to the field side, -y the rolling radius.
    - `yaw_rad`: rotation about the axis that is normal to the axle and to the track; its sign does not matter.
    """
    if not abs(yaw_rad) <= MAX_YAW_RAD:
        raise InputError(
            f"a yaw of {yaw_rad:g} rad", f"-{MAX_YAW_RAD:g} to {MAX_YAW_RAD:g} rad", "give 5 mrad as 0.005"
        )
    if yaw_rad == 0.0:
        return profile
    x, y, angle = _with_edges(profile)
    sine = np.tan(angle) * math.tan(abs(yaw_rad))
    seen = np.abs(sine) < _MAX_SINE
    x, y, angle, sine = x[seen], y[seen], angle[seen], sine[seen]
    across = x * math.cos(yaw_rad) - y * sine * math.sin(abs(yaw_rad))
    height = y * np.sqrt(1.0 - sine**2)
    kept = np.flatnonzero(_lowest(across, height))
    # an end of the profile that turns back and ends short of what is above it would be a jump: the outline ends before
    kept = kept[np.append(True, across[kept][1:] > np.maximum.accumulate(across[kept])[:-1])]
    across, height = across[kept], height[kept]
    slope = np.tan(np.arcsin(np.sin(angle[kept]) / math.cos(yaw_rad)))
    apart = np.concatenate(([True], np.diff(across) > _APART_MM))
    return RigidCurve.from_graph(across[apart], height[apart], slope[apart])


def on_profile(across: Floats, height: Floats, angle: Floats, yaw_rad: float) -> tuple[Floats, Floats, Floats]:
    """Where points of the outline lie on the wheel.

    Returned: position along the axle, rolling radius, and longitudinal distance by which the point is ahead of the
    axle.

    - `across`, `height`, `angle`: points of `outline_across` and angles of its tangent, any shape.
    - `yaw_rad`: the yaw; positive where this wheel is ahead of the other one.
    """
    tangent = math.tan(yaw_rad)
    sine = -np.tan(np.arcsin(np.sin(angle) * math.cos(yaw_rad))) * tangent
    radius = -height / np.sqrt(1.0 - sine**2)
    along = across / math.cos(yaw_rad) + radius * sine * tangent
    return along, radius, radius * sine / math.cos(yaw_rad)


def _repeated(counts: Ints) -> tuple[Ints, Ints]:
    """Numbers from 0, each as often as counted, and which time it is, from 0."""
    rows = np.repeat(np.arange(len(counts)), counts)
    return rows, np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)


def _with_edges(profile: RigidCurve) -> tuple[Floats, Floats, Floats]:
    """Dense points of a profile; at an edge with the angles between those of its sides."""
    points = profile.sampled(_CURVE_SPACING_MM)
    turn = np.diff(points.angle)
    counts = np.where(np.hypot(np.diff(points.x), np.diff(points.y)) < _SAME_POINT_MM, turn / _EDGE_STEP_RAD, 0.0)
    repeats = np.append(1 + np.maximum(np.floor(counts), 0.0).astype(np.int64), 1)
    source, number = _repeated(repeats)
    angle = points.angle[source] + np.append(turn, 0.0)[source] * number / repeats[source]
    return points.x[source], points.y[source], angle


def _lowest(x: Floats, y: Floats) -> Bools:
    """Which points of a chain that may turn back belong to its lower envelope."""
    if (np.diff(x) > -_SAME_POINT_MM).all():
        return np.ones(len(x), dtype=np.bool_)
    # runs along which x grows: parts that turn back are bounded by a lower run
    ends = np.flatnonzero(np.diff(x) <= -_SAME_POINT_MM) + 1
    lowest = np.full(len(x), np.inf)
    for run in np.split(np.arange(len(x)), ends):
        lowest = np.minimum(lowest, np.interp(x, x[run], y[run], left=np.inf, right=np.inf))
    kept: Bools = y <= lowest + _SAME_POINT_MM
    return kept


@lru_cache(maxsize=16)
def _turned_graphs(contour: Contour, turned: Placement, steepest_rad: float) -> list[Floats]:
    """Parts of a contour that is turned or mirrored only: tracks of other gauges have the same ones."""
    return graphs_of(contour.transformed(turned), steepest_rad)


# --- One rigid wheel over one rigid rail: where it touches first when it comes down, for many positions at once.
#
# Everything here is in the right-hand form of a side: x grows from the track's middle to the field side. The left side
# is the mirror image, with the opposite lateral displacement and roll.


N_TOUCHES = 6  # points of a side that are followed: the touch, and the next smallest gaps

_SPACING_MM = 0.2
_TABLE_MM = 0.005
_CHUNK = 128
_EDGE_MM = 1e-9
_N_FRONT = 2000  # points of a wheel at which the angle of its flange is looked up
_FIRST_MARGIN_MM = 0.2  # by which a sample may be lower than the highest one and yet touch first
_SAME_MM = 1e-6
_ARC_TOLERANCE_MM = 1e-12
_CORNER_RAD = 1e-6  # difference of the angles of wheel and rail where they touch, above which one has a corner


class Touches(NamedTuple):
    """Points where a wheel touches or comes close, arrays (n, N_TOUCHES) or (n, 1), the first touch first.

    - `lift`: height of the axle's middle over the track at which this point touches, -inf where there is none.
    - `wheel_arc`: length along the wheel's curve.
    - `x`, `y`: point of the rail in the track's axes, right-hand form.
    - `angle`: angle of the common tangent from the track's plane, positive towards the flange.
    - `relative_curvature`: sum of the curvatures of wheel and rail, convex positive.
    """

    lift: Floats
    wheel_arc: Floats
    x: Floats
    y: Floats
    angle: Floats
    relative_curvature: Floats


@dataclass(frozen=True, eq=False)
class RigidSide:
    """A wheel and its rail as rigid curves.

    - `wheel`: its outline in the longitudinal view, about the middle of the axle: x to the field side, y up. Without
      yaw that is the profile, and -y is the rolling radius.
    - `rail`: in the track's axes.
    - `wheel_frame`, `rail_frame`: from the frames of the profiles to those of the curves.
    - `yaw_rad`: yaw of the wheel, positive where it is ahead of the other one; see `outline_across`.
    """

    wheel: RigidCurve
    rail: RigidCurve
    wheel_frame: Placement = field(default_factory=Placement)
    rail_frame: Placement = field(default_factory=Placement)
    yaw_rad: float = 0.0

    @classmethod
    def of(cls, track: RigidTrack, wheelset: RigidWheelPair, side: Side, yaw_rad: float = 0.0) -> "RigidSide":
        """Return a side of a wheelset on a track, on the track's side of the same name."""
        rail_frame, reference = track.placement(side), wheelset.placement(side)
        if side == "left":
            rail_frame, reference = mirrored(rail_frame), mirrored(reference)
        wheel_frame = Placement(0.0, (0.0, -wheelset.tape_radius_mm)).after(reference)
        wheel, rail = wheelset.wheel_of(side), track.rail_of(side)
        profile = RigidCurve.from_contour(wheel.running_surface, wheel_frame)
        return cls(
            outline_across(profile, yaw_rad),
            RigidCurve.from_contour(rail.running_surface, rail_frame, faces=True),
            wheel_frame,
            rail_frame,
            yaw_rad if side == "right" else -yaw_rad,
        )

    def on_wheel(self, wheel_arc: Floats) -> tuple[Floats, Floats, Floats]:
        """Position along the axle, rolling radius, distance ahead of the axle; at lengths along the wheel's outline."""
        at = self.wheel.at(wheel_arc)
        return on_profile(at.x, at.y, at.angle, self.yaw_rad)

    @cached_property
    def _rail_heights(self) -> tuple[float, Floats]:
        """First x and heights of the rail on a grid, a little wider than its head."""
        first, last = self.rail.joints[[0, -1]]
        x = np.arange(first - 1.0, last + 1.0, _TABLE_MM)
        return float(x[0]), self.rail.over(x).y

    def over_rail(self, lateral: Floats) -> Bools:
        """Whether some of the wheel is above the rail's head, (n,)."""
        return (lateral + self.wheel.joints[-1] > self.rail.joints[0]) & (
            lateral + self.wheel.joints[0] < self.rail.joints[-1]
        )

    def touches(self, lateral: Floats, roll: Floats, *, first_only: bool = False) -> Touches:
        """First touch and next smallest gaps of a wheel that comes down.

        An `InputError` if no point of the wheel is above the rail's head.

        - `lateral`, `roll`: position of the axle's middle to the field side, and roll that lifts this wheel, each (n,).
        - `first_only`: whether the next smallest gaps are left out: arrays (n, 1).
        """
        over = self.over_rail(lateral)
        if not over.all():
            worst = float(lateral[~over][np.argmax(np.abs(lateral[~over]))])
            inside = self.rail.joints[0] - self.wheel.joints[-1] - worst
            outside = worst + self.wheel.joints[0] - self.rail.joints[-1]
            raise InputError(
                f"a lateral displacement of {worst:.1f} mm, with which the wheel misses the rail by "
                f"{max(inside, outside):.1f} mm",
                "displacements with the wheel above the head of its rail",
                f"{'lower' if inside > 0.0 else 'raise'} gauge_mm or {'raise' if inside > 0.0 else 'lower'} "
                "back_to_back_mm, or give a smaller displacement",
            )
        margin = _FIRST_MARGIN_MM if first_only else np.inf
        number, low, high = (
            np.concatenate(column)
            for column in zip(
                *(self._brackets(lateral, roll, slice(i, i + _CHUNK), margin) for i in range(0, len(lateral), _CHUNK)),
                strict=True,
            )
        )
        placed = self._placed(lateral[number], roll[number], self._refined(lateral[number], roll[number], low, high))
        # two brackets that met at one point are one touch
        order = np.lexsort((placed.wheel_arc, number))
        again = (np.diff(placed.wheel_arc[order]) < _SAME_MM) & (np.diff(number[order]) == 0)
        order = order[np.concatenate(([True], ~again))]
        order = order[np.lexsort((-placed.lift[order], number[order]))]
        row = number[order]
        rank = np.arange(len(row)) - np.searchsorted(row, row)
        n_kept = 1 if first_only else N_TOUCHES
        order, row, rank = order[rank < n_kept], row[rank < n_kept], rank[rank < n_kept]
        columns = [np.full((len(lateral), n_kept), fill) for fill in (-np.inf, *[np.nan] * 5)]
        for column, values in zip(columns, placed, strict=True):
            column[row, rank] = values[order]
        return Touches(*columns)

    @cached_property
    def _samples(self) -> tuple[Floats, CurvePoints]:
        """Lengths along the wheel at which its height over the rail is sampled, and the points there."""
        arcs = np.linspace(0.0, self.wheel.length, int(np.ceil(self.wheel.length / _SPACING_MM)) + 1)
        return arcs, self.wheel.at(arcs)

    def _brackets(self, lateral: Floats, roll: Floats, part: slice, margin: float) -> tuple[Ints, Floats, Floats]:
        """Numbers of positions, and brackets of lengths along the wheel about its local maxima over the rail.

        Maxima lower than the highest one by more than a margin are left out.
        """
        lateral, roll = lateral[part], roll[part]
        first, last = self.rail.joints[[0, -1]]
        arcs, wheel = self._samples
        # roll moves the wheel's lower part across by its radius times the angle
        across = lateral[:, None] - np.sin(roll)[:, None] * [wheel.y.min(), wheel.y.max()]
        near = np.flatnonzero((wheel.x + across.max() > first - 3.0) & (wheel.x + across.min() < last + 3.0))
        within = slice(near[0], near[-1] + 1)
        arcs, x, y = arcs[within], wheel.x[within], wheel.y[within]
        cosine, sine = np.cos(roll)[:, None], np.sin(roll)[:, None]
        over = lateral[:, None] + cosine * x - sine * y
        origin, heights = self._rail_heights
        position = np.clip((over - origin) / _TABLE_MM, 0.0, len(heights) - 1.001)
        cell = position.astype(np.int64)
        position -= cell
        lift = heights[cell]
        lift += position * (heights[cell + 1] - lift) - (sine * x + cosine * y)
        lift[(over < first - 0.5) | (over > last + 0.5)] = -np.inf
        # with the ends: a touch there is one at the edge of a profile
        highest = np.isfinite(lift) & (lift >= lift.max(axis=1, keepdims=True) - margin)
        highest[:, 1:] &= lift[:, 1:] >= lift[:, :-1]
        highest[:, :-1] &= lift[:, :-1] > lift[:, 1:]
        row, column = np.nonzero(highest)
        return row + part.start, arcs[np.maximum(column - 1, 0)], arcs[np.minimum(column + 1, len(arcs) - 1)]

    def _refined(self, lateral: Floats, roll: Floats, low: Floats, high: Floats) -> Floats:
        """Lengths along the wheel where the tangents of wheel and rail agree, by Newton kept in a bracket.

        A loop of its own: curvatures jump where arcs meet, so that only the bracket is sure; positions leave it one by
        one.
        """
        low, high = low.copy(), high.copy()
        arc = 0.5 * (low + high)
        active = np.arange(len(arc))
        for _ in range(100):
            s = arc[active]
            y, turn = lateral[active], roll[active]
            wheel = self.wheel.at(s)
            rail = self.rail.over(y + np.cos(turn) * wheel.x - np.sin(turn) * wheel.y)
            wheel_angle = wheel.angle + turn
            difference = rail.angle - wheel_angle
            rises = difference > 0.0
            low[active] = np.where(rises, s, low[active])
            high[active] = np.where(rises, high[active], s)
            slope = rail.curvature * np.cos(wheel_angle) / np.cos(rail.angle) - wheel.curvature
            falls = slope < 0.0
            step = np.where(falls, -difference / np.where(falls, slope, -1.0), np.inf)
            tolerance = _ARC_TOLERANCE_MM * (1.0 + np.abs(s))
            # in the end the root is an end of the bracket: a short step is the last one
            converged = (difference == 0.0) | (np.abs(step) < tolerance)
            target = np.where(difference == 0.0, s, s + step)
            inside = (target > low[active]) & (target < high[active])
            bisected = 0.5 * (low[active] + high[active])
            new = np.where(converged, np.clip(target, low[active], high[active]), np.where(inside, target, bisected))
            arc[active] = new
            active = active[~converged & (np.abs(new - s) >= tolerance)]
            if not len(active):
                break
        return arc

    def _placed(self, lateral: Floats, roll: Floats, arc: Floats) -> Touches:
        wheel = self.wheel.at(arc)
        cosine, sine = np.cos(roll), np.sin(roll)
        rail = self.rail.over(lateral + cosine * wheel.x - sine * wheel.y)
        lift = rail.y - (sine * wheel.x + cosine * wheel.y)
        # a corner of the rail has all angles between those of its sides, and is touched with that of the wheel
        angle, of_wheel = rail.angle.copy(), wheel.angle + roll
        corner = np.flatnonzero(np.abs(angle - of_wheel) > _CORNER_RAD)
        beside = [self.rail.over(rail.x[corner] + step).angle for step in (_SAME_MM, -_SAME_MM)]
        angle[corner] = np.clip(of_wheel[corner], *np.sort(beside, axis=0))
        return Touches(lift, arc, rail.x, rail.y, angle, wheel.curvature - rail.curvature)

    def close_arcs(self, lateral: float, roll: float, lift: float, gap_mm: float) -> Floats:
        """Lengths along the wheel, from first to last, at which it is over the rail by less than a gap, (n,).

        - `lateral`, `roll`: position of the wheel; see `touches`.
        - `lift`: height of the axle's middle.
        - `gap_mm`: largest vertical gap.
        """
        arcs = self._samples[0]
        placed = self._placed(np.full(len(arcs), lateral), np.full(len(arcs), roll), arcs)
        over = (placed.x >= self.rail.joints[0]) & (placed.x <= self.rail.joints[-1])
        return arcs[over & (lift - placed.lift < gap_mm)]

    def flange_angle_rad(self) -> float:
        """Maximum angle of the flange between its tip and the tape line, which is a contact angle without roll."""
        tip = int(np.argmin(self.wheel.starts[:, 1]))
        front = np.linspace(self.wheel.offsets[tip], self.wheel.length, _N_FRONT)
        at = self.wheel.at(front)
        return float(at.angle[at.x <= self.wheel_frame.translation[0]].max())

    def _at_ends(self, touches: Touches) -> dict[str, Bools]:
        """Whether the first touch is at each of the ends of the running surfaces, (n,), by their names."""
        arc, x = touches.wheel_arc[:, 0], touches.x[:, 0]
        return {
            "the lower end of the gauge face of the {} rail": x <= self.rail.joints[0],
            "the field-side end of the {} rail": x >= self.rail.joints[-1],
            "the back of the {} flange": arc < _EDGE_MM,
            "the rim of the {} wheel": arc > self.wheel.length - _EDGE_MM,
        }

    def edge_words(self, side: Side, touches: Touches) -> str:
        """End of a running surface at which the first position touches, in words; empty if it touches inside."""
        return next((words.format(side) for words, touched in self._at_ends(touches).items() if touched[0]), "")

    def at_edge(self, touches: Touches) -> Bools:
        """Whether the first touch is at an end of the wheel's or the rail's running surface, (n,)."""
        return np.any(list(self._at_ends(touches).values()), axis=0)
