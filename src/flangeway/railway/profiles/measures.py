"""Gauge measures of running surfaces, as instruments print them, and curvatures at points of contact."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.geometry import Contour, FloatArray
from flangeway.geometry.arrays import angles_of, norms
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.raw_profile import Kind
from flangeway.units import sentence

FACE_MM = 10.0  # distance from the tread, towards the flange's tip, at which the flange is measured (EN 15313)
TIP_MM = 2.0  # distance below the flange's tip of the upper point of the measure qR (EN 15313)
GAUGE_DEPTH_MM = 14.0  # depth below the rails' tops at which the gauge is measured (EN 13848-1), and a head's width
SIDE_MM = 25.0  # distance from a head's middle, to each side, at which its drop below the top is measured
WORN_MM = 0.5  # difference of both sides of a head from which one of them is the worn one
WORN_FACE_MM = (
    0.9  # difference of the half widths that a face worn by flanges makes, and an inclination of 1:15 does not
)
LEFT_MM = 1.5  # difference of the drops that an inclination does not make; 1:40 makes 1.25 mm
MAX_WIDTH = 0.5  # half width of a contact over a radius of its bodies up to which these are half planes

MAX_CHANGE = 1.5
"""Factor between the gap at an end of the contact and that of constant curvature up to which Hertz's theory applies."""

_N_ALONG = 50
_SPACING_MM = 0.02
_CHORD_MM = 0.2  # over which the angle of a flange is taken
_DEEPEST_MM = 20.0  # flanges hardly reach further down; below it an inclined head would seem worn
_UPRIGHT = 0.18  # tangent of 10 degrees: a rounding of 20 mm goes on for 0.3 mm


@dataclass(frozen=True)
class WornSide:
    """Side of a rail's head that is worn more.

    - `name`: ``"gauge side"`` (negative x) or ``"field side"``.
    - `more_mm`: how much more, > 0.
    - `measure`: what was compared.
    - `clear`: whether it is more than an inclination of the head makes.
    """

    name: str
    more_mm: float
    measure: str
    clear: bool


def measures(surface: Contour, kind: Kind) -> dict[str, float]:
    """Return those measures of a running surface in mm that it reaches far enough for.

    Wheels: ``flange_height_mm`` (Sh), ``flange_thickness_mm`` (Sd) and ``flange_slope_mm`` (qR), from the tread at the
    tape line. Rails: ``head_width_mm`` at `GAUGE_DEPTH_MM` below the highest place; below it ``gauge_drop_mm`` and
    ``field_drop_mm`` at `SIDE_MM` from the head's middle, and at `GAUGE_DEPTH_MM` ``gauge_half_width_mm`` and
    ``field_half_width_mm`` from that middle, which lies between the faces as far down as both are seen, where no wheel
    wears them.

    - `surface`: in this package's frame of a wheel or a rail.
    - `kind`: what it is.
    """
    points = surface.sampled(spacing=_SPACING_MM, max_deviation=1e-4)
    return _wheel(points) if kind == "wheel" else _rail(points)


def _wheel(points: FloatArray) -> dict[str, float]:
    tip = int(np.argmin(points[:, 1]))
    lowest = float(points[tip, 1])
    if tip in (0, len(points) - 1) or lowest > -FACE_MM - TIP_MM or points[:, 0].max() < 0.0:
        return {}
    measures = {"flange_height_mm": -lowest}
    front = _front(points)
    back = points[: tip + 1] if points[-1, 0] > points[tip, 0] else points[tip:]
    face, top = _first_x(front, -FACE_MM), _first_x(front, lowest + TIP_MM)
    if face is not None and top is not None:
        measures["flange_slope_mm"] = face - top
    # the back has to be seen, not the tip's rounding alone
    if face is not None and back[:, 1].max() > lowest + FACE_MM:
        measures["flange_thickness_mm"] = face - float(back[:, 0].min())
    return measures


def _front(points: FloatArray) -> FloatArray:
    """Points of a wheel from the flange's tip to the tread and the rim."""
    tip = int(np.argmin(points[:, 1]))
    return points[tip:] if points[-1, 0] > points[tip, 0] else points[tip::-1]


def flange_angle_rad(surface: Contour) -> float:
    """Return the steepest angle of a wheel's flange with its axis, between the tip and the tape line (EN 13715).

    The edge of the rim, which is steep too, does not count.
    """
    front = _front(surface.sampled(spacing=_CHORD_MM))
    along = np.diff(front[front[:, 0] <= 0.0], axis=0)
    return float(angles_of(along).max())


def _rail(points: FloatArray) -> dict[str, float]:
    top = int(np.argmax(points[:, 1]))
    level = float(points[top, 1]) - GAUGE_DEPTH_MM
    first, second = _first_x(points[top::-1], level), _first_x(points[top:], level)
    if first is None or second is None:
        return {}
    measures = {"head_width_mm": abs(second - first)}
    # faces may lean inwards below their widest place: each side counts as far as it goes down
    sides = points[points[:, 0] <= points[top, 0]], points[points[:, 0] > points[top, 0]]
    low = max(float(points[top, 1]) - _DEEPEST_MM, *(float(side[:, 1].min()) + _SPACING_MM for side in sides))
    left, right = (_first_x(side, low) for side in (points[top::-1], points[top:]))
    if left is None or right is None:
        return measures
    left, right = sorted((left, right))
    middle = 0.5 * (left + right)
    order = np.argsort(points[:, 0])
    for name, sign, side_x in (("gauge", -1.0, min(first, second)), ("field", 1.0, max(first, second))):
        at = middle + sign * SIDE_MM
        if left < at < right:
            measures[f"{name}_drop_mm"] = float(points[top, 1] - np.interp(at, points[order, 0], points[order, 1]))
            measures[f"{name}_half_width_mm"] = sign * (side_x - middle)
    return measures


def worn_side(points: FloatArray) -> WornSide | None:
    """Return the side of a right-hand rail's head (n, 2) that is worn more, None if neither is or not both are seen.

    Compared are both sides' drops below the top and both sides' half widths, see `measures`: a worn corner drops more,
    a worn face is nearer to the middle. A head that was measured inclined drops more at the gauge side as well.
    """
    measures = _rail(points)
    if "gauge_drop_mm" not in measures or "field_drop_mm" not in measures:
        return None
    drop = measures["gauge_drop_mm"] - measures["field_drop_mm"]
    width = measures["field_half_width_mm"] - measures["gauge_half_width_mm"]
    # a worn face moves the middle away from itself, so that the other side seems to drop more
    if abs(width) >= min(WORN_FACE_MM, abs(drop)):
        more, measure, clear = (
            width,
            sentence("half width {:g mm} below the top", GAUGE_DEPTH_MM),
            abs(width) >= WORN_FACE_MM,
        )
    else:
        more, measure, clear = drop, sentence("drop {:g mm} from the middle", SIDE_MM), abs(drop) >= LEFT_MM
    name = "gauge side" if more > 0.0 else "field side"
    return None if abs(more) < WORN_MM else WornSide(name, abs(more), measure, clear)


def only_face(points: FloatArray) -> str | None:
    """Return the side of a right-hand rail's head (n, 2) whose face alone was measured; None if both or none were."""
    top = points[np.argmax(points[:, 1])]
    gauge, field = (float(top[1] - points[side, 1].min()) for side in (points[:, 0] <= top[0], points[:, 0] >= top[0]))
    if max(gauge, field) < GAUGE_DEPTH_MM or min(gauge, field) > 0.5 * GAUGE_DEPTH_MM:
        return None
    return "gauge side" if gauge > field else "field side"


def left_hand(points: FloatArray) -> str | None:
    """Return what shows that points (n, 2) of a head, read as a right-hand one, are those of a left-hand one.

    Instruments measure the gauge face, and wheels wear it: both on the field side show it, if it is clear.
    """
    if only_face(points) == "field side":
        return "only the face of its field side is measured"
    side = worn_side(points)
    if side is None or side.name == "gauge side" or not side.clear:
        return None
    return sentence("its field side is worn more, by {:.2f mm} ({})", side.more_mm, side.measure)


def seen_back_mm(surface: Contour) -> float | None:
    """Return the distance of a wheel's flange back from the tape line, None if the surface does not show it.

    It does where the point most distant from the tread lies beyond the flange's tip, and the surface is upright.
    """
    points = surface.sampled(spacing=0.05, max_deviation=1e-4)
    far, tip = int(np.argmin(points[:, 0])), int(np.argmin(points[:, 1]))
    near = points[norms(points - points[far]) <= 1.0]
    width, height = np.ptp(near, axis=0)
    if points[far, 1] <= points[tip, 1] + TIP_MM or points[far, 0] >= points[tip, 0] or width > _UPRIGHT * height:
        return None
    # the tip lies between the back and the face
    beyond = points[:tip] if far < tip else points[tip + 1 :]
    return round(-float(points[far, 0]), 4) if len(beyond) and tip not in (0, len(points) - 1) else None


def crossings(points: FloatArray, level: float, axis: int = 1) -> FloatArray:
    """Return the other coordinates at which a chain of points (n, 2) passes a level of x (axis 0) or y, in order."""
    above = points[:, axis] > level
    passed = np.flatnonzero(above[1:] != above[:-1])
    first, step = points[passed], np.diff(points, axis=0)[passed]
    places: FloatArray = first[:, 1 - axis] + (level - first[:, axis]) / step[:, axis] * step[:, 1 - axis]
    return places


def _first_x(points: FloatArray, level: float) -> float | None:
    """Return x where points (n, 2) first pass a height, None if they do not."""
    return next(iter(crossings(points, level).tolist()), None)


def relative_curvature(wheel: WheelProfile, wheel_point: ArrayLike, rail: RailProfile, rail_point: ArrayLike) -> float:
    """Sum of the curvatures of a wheel and a rail at points in their own frames, 1/mm; convex is positive."""
    total = 0.0
    for curve, point in ((wheel.running_surface, wheel_point), (rail.running_surface, rail_point)):
        segment = int(curve.closest(np.atleast_2d(point))[0][0])
        total += curve.segments[segment].curvature
    return total


def conforming(
    wheel: WheelProfile, wheel_point: ArrayLike, rail: RailProfile, rail_point: ArrayLike, half_width_mm: float
) -> bool:
    """Whether Hertz's theory does not apply: it needs constant curvatures, and a width that is small against the radii.

    So it is where Hertz's own half width a exceeds `MAX_WIDTH` times the smallest radius of either profile over
    it, or the gap of the profiles at either end of it, ``int_0^a (a - s) k(s) ds`` with the relative curvature k along
    the surfaces, is not that of the curvature at the middle, ``k(0) a^2 / 2``, within a factor of `MAX_CHANGE`.

    - `wheel`, `wheel_point`, `rail`, `rail_point`: profiles, and the points of contact in their frames, each (2,).
    - `half_width_mm`: Hertz's half width for the curvatures at these points, > 0.
    """
    along = half_width_mm * (np.arange(_N_ALONG) + 0.5) / _N_ALONG
    along = np.concatenate([-along[::-1], along])
    # both surfaces have their steel at the left: one runs against the other
    of_wheel, of_rail = (
        curve.curvatures_at(curve.lengths_at(point) + lengths)
        for curve, point, lengths in (
            (wheel.running_surface, wheel_point, along),
            (rail.running_surface, rail_point, -along),
        )
    )
    if half_width_mm * max(np.abs(of_wheel).max(), np.abs(of_rail).max()) > MAX_WIDTH:
        return True
    weights = half_width_mm - np.abs(along)
    middle = relative_curvature(wheel, wheel_point, rail, rail_point)
    ends = [
        float((weights * (of_wheel + of_rail))[side].sum() / weights[side].sum()) for side in (along < 0, along > 0)
    ]
    return not all(1.0 / MAX_CHANGE <= end / middle <= MAX_CHANGE for end in ends)
