"""Profiles as rigid curves of lines and arcs, evaluated for thousands of points at once.

Both wheel and rail run from the gauge side to the field side, so that x grows along the curve. On a piece of
curvature k the sine of the tangent's angle is linear in x, ``sin a = sin a0 + k (x - x0)``, and a chord has the mean
angle of its ends, ``y - y0 = (x - x0) tan((a0 + a) / 2)``: lines and arcs share these two formulas.

A wheel that is turned about the vertical touches with its outline across the track. It is a surface of revolution, a
rail is a prism. In the longitudinal view the wheel is bounded below by the points whose normal lies across the track:
where the profile has the angle ``a``, the point of its circle that is the angle ``t`` ahead of the lowest one,
``sin t = -tan a tan yaw``. Their outline has the angle ``b``, ``sin b = sin a / cos yaw``, and is a plane curve that
comes down on the rail as a profile without yaw does. Roll turns the outline about the axis of the view.

On a flange the points lie some millimetres to centimetres ahead of the axle, or behind it. Where the profile is so
hollow that the outline would turn back, as in the flange root at large yaw, the lower envelope is taken: what turns
back lies inside the wheel.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement
from flangeway.geometry.arrays import angles_of, norms
from flangeway.railway.profiles.running_graphs import MAX_CLIPPED, STEEPEST_RAD, extent, graphs_of
from flangeway.types import Floats, Ints, floats
from flangeway.units import sentence

UPRIGHT = np.finfo(float).eps
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
        cls, contour: Contour, placement: Placement | None = None, steepest_rad: float = STEEPEST_RAD
    ) -> Self:
        """Return the widest part of a contour whose tangents are less steep than an angle.

        What lies beyond an overhang, as of a chamfer or a lip, is left out. An `InputError` if there is no such part,
        or another one is wider than `MAX_CLIPPED` of it.

        - `contour`: in either direction.
        - `placement`: where it is; untransformed by default.
        - `steepest_rad`: with more than 90 degrees x does not grow everywhere, and `over` has no meaning.
        """
        placement = placement or Placement()
        tables = _turned_graphs(contour, replace(placement, translation=(0.0, 0.0)), steepest_rad)
        if not tables:
            raise InputError("a profile without a running surface", "tangents that are not vertical", "check its axes")
        if len(tables) > 1 and extent(tables[1]) > MAX_CLIPPED * extent(tables[0]):
            x, y = tables[1][0, :2] + placement.translation
            raise InputError(
                sentence("a surface that overhangs at x = {:.2f (mm)}, y = {:.2f mm}", x, y),
                "one surface that runs from the gauge side to the field side",
                "check the profile's axes, and remove hooks of the measurement",
            )
        table = tables[0]
        return cls(table[:, :2] + placement.translation, table[:, 2], table[:, 3], table[:, 4])

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

    def _along(self, piece: NDArray[np.int64], local: Floats) -> CurvePoints:
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
        cosine_there = np.sqrt(np.maximum(1.0 - sine_there**2, UPRIGHT**2))
        height = self.starts[piece, 1] + step * (sine + sine_there) / (cosine + cosine_there)
        slope, beyond = sine_there / cosine_there, at - inside
        return height + beyond * slope, slope, np.where(beyond == 0.0, curvature, 0.0)

    def moved(self, x: float, y: float) -> "RigidCurve":
        """Return the curve after a translation."""
        return RigidCurve(self.starts + np.array([x, y]), self.angles, self.curvatures, self.lengths)


MAX_YAW_RAD = 0.2  # maximum yaw; beyond it steep flanges touch at the height of the axle

_SPACING_MM = 0.1
_EDGE_STEP_RAD = 0.02
_MAX_SINE = 0.95
_SAME_MM = 1e-9
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
    points = profile.sampled(_SPACING_MM)
    turn = np.diff(points.angle)
    counts = np.where(np.hypot(np.diff(points.x), np.diff(points.y)) < _SAME_MM, turn / _EDGE_STEP_RAD, 0.0)
    repeats = np.append(1 + np.maximum(np.floor(counts), 0.0).astype(np.int64), 1)
    source, number = _repeated(repeats)
    angle = points.angle[source] + np.append(turn, 0.0)[source] * number / repeats[source]
    return points.x[source], points.y[source], angle


def _lowest(x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Which points of a chain that may turn back belong to its lower envelope."""
    if (np.diff(x) > -_SAME_MM).all():
        return np.ones(len(x), dtype=np.bool_)
    # runs along which x grows: parts that turn back are bounded by a lower run
    ends = np.flatnonzero(np.diff(x) <= -_SAME_MM) + 1
    lowest = np.full(len(x), np.inf)
    for run in np.split(np.arange(len(x)), ends):
        lowest = np.minimum(lowest, np.interp(x, x[run], y[run], left=np.inf, right=np.inf))
    kept: NDArray[np.bool_] = y <= lowest + _SAME_MM
    return kept


@lru_cache(maxsize=16)
def _turned_graphs(contour: Contour, turned: Placement, steepest_rad: float) -> list[Floats]:
    """Parts of a contour that is turned or mirrored only: tracks of other gauges have the same ones."""
    return graphs_of(contour.transformed(turned), steepest_rad)
