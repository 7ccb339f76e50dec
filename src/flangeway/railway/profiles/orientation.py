"""Gauge measures of running surfaces, and from the axes of a file to this package's."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import is_number, parsed_number, refused
from flangeway.errors import InputError
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.geometry import Contour, FloatArray
from flangeway.geometry.arrays import angles_of, norms
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.instrument_files import TAPE_MM
from flangeway.railway.profiles.formats.two_column import KINDS, RAIL_ORIGINS, WHEEL_ORIGINS, Kind, Origin, RawProfile
from flangeway.railway.profiles.smoothing import MIN_POINTS

# --- Gauge measures of running surfaces, as instruments print them, and curvatures at points of contact.


FACE_MM = 10.0  # distance from the tread, towards the flange's tip, at which the flange is measured (EN 15313)
TIP_MM = 2.0  # distance below the flange's tip of the upper point of the measure qR (EN 15313)
GAUGE_DEPTH_MM = 14.0  # depth below the rails' tops at which the gauge is measured (EN 13848-1), and a head's width
SIDE_MM = 25.0  # distance from a head's middle, to each side, at which its drop below the top is measured
WORN_MM = 0.5  # difference of both sides of a head from which one of them is the worn one
WORN_FACE_MM = 0.9
"""Difference of the half widths that a face worn by flanges makes, and an inclination of 1:15 does not."""
LEFT_MM = 1.5  # difference of the drops that an inclination does not make; 1:40 makes 1.25 mm
MAX_WIDTH = 0.5  # half width of a contact relative to a radius of its bodies up to which these are half planes

MAX_CHANGE = 1.5
"""Factor between the gap at an end of the contact and that of constant curvature up to which Hertz's theory applies."""

_N_ALONG = 50
_SPACING_MM = 0.02
_CHORD_MM = 0.2  # over which the angle of a flange is taken
_MAX_DEPTH_MM = 20.0  # flanges hardly reach further down; below it an inclined head would seem worn
_UPRIGHT_TANGENT = 0.18  # tangent of 10 degrees: a rounding of 20 mm goes on for 0.3 mm


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
    low = max(float(points[top, 1]) - _MAX_DEPTH_MM, *(float(side[:, 1].min()) + _SPACING_MM for side in sides))
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
            f"half width {GAUGE_DEPTH_MM:g} mm below the top",
            abs(width) >= WORN_FACE_MM,
        )
    else:
        more, measure, clear = drop, f"drop {SIDE_MM:g} mm from the middle", abs(drop) >= LEFT_MM
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
    return f"its field side is worn more, by {side.more_mm:.2f} mm ({side.measure})"


def seen_back_mm(surface: Contour) -> float | None:
    """Return the distance of a wheel's flange back from the tape line, None if the surface does not show it.

    It does where the point most distant from the tread lies beyond the flange's tip, and the surface is upright.
    """
    points = surface.sampled(spacing=0.05, max_deviation=1e-4)
    far, tip = int(np.argmin(points[:, 0])), int(np.argmin(points[:, 1]))
    near = points[norms(points - points[far]) <= 1.0]
    width, height = np.ptp(near, axis=0)
    if (
        points[far, 1] <= points[tip, 1] + TIP_MM
        or points[far, 0] >= points[tip, 0]
        or width > _UPRIGHT_TANGENT * height
    ):
        return None
    # the tip lies between the back and the face
    beyond = points[:tip] if far < tip else points[tip + 1 :]
    return round(-float(points[far, 0]), 4) if len(beyond) and tip not in (0, len(points) - 1) else None


def crossings(points: FloatArray, level: float, axis: int = 1) -> FloatArray:
    """Return the other coordinates at which a chain of points (n, 2) passes a level of x (axis 0) or y, in order."""
    above = points[:, axis] > level
    passed = np.flatnonzero(above[1:] != above[:-1])
    first, step = points[passed], np.diff(points, axis=0)[passed]
    positions: FloatArray = first[:, 1 - axis] + (level - first[:, axis]) / step[:, axis] * step[:, 1 - axis]
    return positions


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


# --- From the axes of a file to this package's: kind, up and down, side of the track, order, origin.
#
# The user's options come first, then the file's header, then its shape; all else is assumed. The sources are reported.
# The points of a rail go from the field side to the gauge side and those of a wheel from the flange's
# back to the rim: with the steel at the left, like the outlines of `flangeway.railway.profiles.bundled`.


TREAD_OFF_MM = 0.05  # height of the tread at the tape line above which a wheel is moved to have it at zero

_MIN_DROP_MM = 4.0
_MIN_END_DROP_MM = 3.0
_NECK_MM = 10.0
_MIN_FLANGE_MM = 15.0
_TREAD_FROM_MM = 40.0
_TREAD_MM = 30.0
_TREAD_DROP_MM = 12.0
_FLANGE_WIDTHS_MM = (12.0, 45.0)
_HEAD_WIDTHS_MM = (45.0, 120.0)
_MAX_RIM_DISTANCE_MM = 150.0
"""The rim of a wheel is at most this far from its flange's back; half of a gauge is further."""


@dataclass(frozen=True)
class ReadOptions:
    """Options of the user for a file; None leaves them to the file and its shape.

    Parameters
    ----------
    unit
        Unit of length.
    kind
        ``"rail"`` or ``"wheel"``.
    mirror
        Whether to reverse the first coordinate: the file holds the profile of a left-hand side. None: a wheel's flange
        shows it, and a rail's head where one side is clearly worn more, or only one is measured.
    flip
        Whether to reverse the second coordinate.
    origin
        Where the file's (0, 0) lies: ``"top"``, ``"base"`` or ``"gauge"`` of a rail, ``"tape"`` or ``"flange-back"`` of
        a wheel; or ``"X,Y"``, the place in the file of a rail's top or of a wheel's tread at the tape line.
    tape_mm
        Distance of a wheel's tape line from the flange's back.
    smooth_mm
        Wavelength to smooth by; 0 for none. See `flangeway.railway.profiles.smoothing.smoothed`.
    limit_um
        Maximum distance that smoothing may move a point.
    position
        Position of the section in a file of slices: mm along the track, degrees around a wheel.
    """

    unit: str | None = None
    kind: str | None = None
    mirror: bool | None = None
    flip: bool = False
    origin: str | None = None
    tape_mm: float | None = None
    smooth_mm: float | None = None
    limit_um: float | None = None
    position: float | None = None

    def __post_init__(self) -> None:
        for name in ("tape_mm", "smooth_mm", "limit_um", "position"):
            value = getattr(self, name)
            if not (value is None or is_number(value)):
                raise refused("ReadOptions", name, value, "a number", "leave it out, or give a number")


@dataclass(frozen=True)
class Orientation:
    """How the numbers of a file were interpreted.

    - `kind`: rail or wheel.
    - `upwards`: whether the file's second coordinate points up.
    - `mirrored`: whether the file's first coordinate was reversed.
    - `reversed_order`: whether the order of the points was reversed.
    - `origin`: where the file's (0, 0) lies.
    - `tape_mm`: distance of a wheel's tape line from the flange's back; None for rails, and if neither user nor file
      gives it.
    - `shift_mm`: what was added to the points in mm, after mirrors.
    - `how`: where each of these comes from: ``{"kind": "from the ending", ...}``.
    """

    kind: Kind
    unit: str
    upwards: bool
    mirrored: bool
    reversed_order: bool
    origin: str
    tape_mm: float | None
    shift_mm: tuple[float, float]
    how: dict[str, str]

    def applied(self, points: FloatArray) -> FloatArray:
        """Return points (n, 2) of the file in mm and this package's axes, in the file's order."""
        placed: FloatArray = points * self._signs + self.shift_mm
        return placed

    def in_order(self, points: FloatArray) -> FloatArray:
        """Return points (n, 2) of the file in this package's axes, with the steel at the left."""
        return np.ascontiguousarray(self.applied(points)[:: -1 if self.reversed_order else 1])

    def by(self, **how: str) -> "Orientation":
        """Return it with other sources of some of its parts, see `how`."""
        return replace(self, how=self.how | how)

    def undone(self, points: FloatArray) -> FloatArray:
        """Return points (n, 2) in this package's axes as the file has them, in its unit."""
        original: FloatArray = (points - self.shift_mm) / self._signs
        return original

    @property
    def _signs(self) -> FloatArray:
        scale = UNITS_MM[self.unit]
        return np.array([-scale if self.mirrored else scale, scale if self.upwards else -scale])


@dataclass(frozen=True)
class _Shape:
    """What the shape shows: kind, whether the file's second coordinate points up, and the flange's side in x."""

    kind: Kind
    upwards: bool
    flange_side: float


def orientation(raw: RawProfile, options: ReadOptions) -> tuple[Orientation, list[str]]:
    """Return the interpretation of a file, and notices of what was assumed or is unusual.

    An `InputError` if the user, the file and the shape contradict each other, or something that is needed is missing.
    """
    unit, kind, origin = options.unit, options.kind, options.origin
    how: dict[str, str] = {}
    in_unit = agreed_unit(raw, unit)
    how["unit"] = "given" if unit else "assumed"
    if raw.unit and not unit:
        how["unit"] = "from the file" if raw.unit_is_sure else "of the format"
    points = raw.points * UNITS_MM[in_unit]
    shape = _shape(points)
    if shape is None and kind is None and raw.kind is None:
        _refuse_exchanged(points)
    agreed_kind = _kind(raw, kind, shape, how)
    notices = list(raw.notices)
    if shape is None and agreed_kind == "rail" and not raw.kind_is_sure:
        shape = _half_head(points)
    if shape is None:
        _refuse_exchanged(points, agreed_kind)
    if shape is not None and shape.kind != agreed_kind:
        notices.append(f"The shape is that of a {shape.kind}; it is taken as a {agreed_kind} nevertheless.")
        shape = None
    upwards = _upwards(raw, agreed_kind, shape, options.flip, how, notices)
    mirrored = _mirrored(raw, agreed_kind, shape, bool(options.mirror), how)
    x_sign, y_sign = (-1.0 if mirrored else 1.0), (1.0 if upwards else -1.0)
    placed = points * [x_sign, y_sign]
    outwards = float(placed[-1, 0] - placed[0, 0])
    reversed_order = outwards > 0.0 if agreed_kind == "rail" else outwards < 0.0
    given = _numbers(origin)
    tape: float | None = None
    if given is not None:
        scale = UNITS_MM[in_unit]
        shift = (-x_sign * given[0] * scale, -y_sign * given[1] * scale)
        label, how["origin"] = f"{given[0]:g},{given[1]:g}", "given"
    else:
        at_origin = _origin(raw, agreed_kind, placed, origin, how)
        label = at_origin
        shift = (0.0, 0.0)
    if agreed_kind == "wheel":
        tape = _tape(raw, options.tape_mm, label == "flange-back", how)
        if label == "flange-back" and tape is not None:
            shift = (-tape, 0.0)
        shift = _on_tread(placed, shift, notices)
    if "assumed" in how["unit"]:
        notices.append(f"The unit {in_unit} is assumed; --unit gives another one.")
    return (Orientation(agreed_kind, in_unit, upwards, mirrored, reversed_order, label, tape, shift, how), notices)


def agreed_unit(raw: RawProfile, unit: str | None) -> str:
    """Return the unit of a file: the one given, the file's own, or mm.

    An `InputError` if it is unknown, or the file has another one than the user.
    """
    for name in (unit, raw.unit):
        if name is not None and name not in UNITS_MM:
            raise InputError(f"unit of length {name!r}", f"one of {', '.join(UNITS_MM)}", "name the unit")
    if unit is not None and raw.unit is not None and raw.unit_is_sure and unit != raw.unit:
        raise InputError(f"--unit {unit} for a file in {raw.unit}", "the file's own unit", "leave --unit out")
    return unit or raw.unit or "mm"


def _kind(raw: RawProfile, kind: str | None, shape: _Shape | None, how: dict[str, str]) -> Kind:
    if kind is not None and kind not in KINDS:
        raise InputError(f"--kind {kind}", "rail or wheel", "choose one of them")
    if kind is not None:
        how["kind"] = "given"
        return kind
    if raw.kind is not None:
        if shape is not None and shape.kind != raw.kind and not raw.kind_is_sure:
            raise InputError(
                f"a {raw.kind} according to the file, of the shape of a {shape.kind}",
                "a file whose ending or header names the kind",
                f"rename the file, or give --kind {shape.kind} or --kind {raw.kind} to insist",
            )
        how["kind"] = "from the file"
        return raw.kind
    if shape is None:
        raise InputError(
            "a profile whose kind, rail or wheel, follows from neither file nor shape",
            "--kind rail or --kind wheel",
            "add the option, or a line '# kind: rail' to the file",
        )
    how["kind"] = "from the shape"
    return shape.kind


def _refuse_exchanged(points: FloatArray, *kinds: Kind) -> None:
    """Refuse points (n, 2) that have the shape of a rail or wheel, or of a kind, with their columns exchanged."""
    shape = _shape(np.ascontiguousarray(points[:, ::-1]))
    if shape is not None and shape.kind in (kinds or KINDS):
        raise InputError(
            f"heights in the first column and lateral coordinates in the second: exchanged, they are a {shape.kind}",
            "the lateral coordinate first, then the vertical one",
            "exchange the columns",
        )


def _upwards(
    raw: RawProfile, kind: Kind, shape: _Shape | None, flip: bool, how: dict[str, str], notices: list[str]
) -> bool:
    stated = raw.upwards
    if flip:
        how["up"] = "given"
        usual = stated if stated is not None else shape.upwards if shape else True
        return not usual
    if shape is not None:
        how["up"] = "from the shape" if stated is None else "from the file"
        if stated is not None and stated != shape.upwards:
            how["up"] = "from the shape, against the format's custom"
            notices.append(
                f"The second coordinate points {'up' if shape.upwards else 'down'}, against the format's custom: the "
                f"{'head' if kind == 'rail' else 'flange'} shows it."
            )
        return shape.upwards
    how["up"] = "from the file" if stated is not None else "assumed"
    if stated is None:
        notices.append("The second coordinate is assumed to point up; --flip if it points down.")
    return True if stated is None else stated


def _mirrored(raw: RawProfile, kind: Kind, shape: _Shape | None, mirror: bool, how: dict[str, str]) -> bool:
    if kind == "wheel" and shape is not None:
        wanted = shape.flange_side > 0.0
        if mirror and not wanted:
            raise InputError(
                "--mirror for a wheel whose flange is at the side of the track's middle already",
                "right-hand wheels, the flange at smaller x than the tread",
                "leave --mirror out: the flange shows the side of a wheel",
            )
        how["side"] = "from the flange"
        return wanted
    how["side"] = "given" if mirror else "from the file" if raw.mirrored else "assumed"
    return mirror != raw.mirrored


def _origin(raw: RawProfile, kind: Kind, placed: FloatArray, origin: str | None, how: dict[str, str]) -> Origin:
    allowed = RAIL_ORIGINS if kind == "rail" else WHEEL_ORIGINS
    if origin is not None and origin not in allowed:
        raise InputError(
            f"--origin {origin} for a {kind}", f"{', '.join(allowed)}, or two numbers X,Y", "choose one of these"
        )
    how["origin"] = "given" if origin else "from the file" if raw.origin else "from the numbers"
    stated = origin or raw.origin
    if stated is not None:
        if stated not in allowed:
            raise InputError(f"origin {stated} of a {kind}", ", ".join(allowed), "correct the file, or give --origin")
        return stated
    top, x = float(placed[:, 1].max()), placed[:, 0]
    if min(abs(x.min()), abs(x.max())) > _MAX_RIM_DISTANCE_MM and x.min() * x.max() > 0.0:
        raise InputError(
            f"lateral coordinates from {x.min():g} to {x.max():g} mm, far from where a {kind} has its origin",
            f"(0, 0) at one of: {', '.join(allowed)}",
            f"--origin X,Y gives the position of the {'top' if kind == 'rail' else 'tread at the tape line'} in the "
            "file, in its unit; --to FILE writes the profile with its own origin, for cases",
        )
    if kind == "rail":
        if top > 80.0:
            return "base"
        return "gauge" if x.min() > -6.0 and x.max() > 40.0 else "top"
    # the back is the end of the points at the flange's side
    return "flange-back" if x.min() > -25.0 and x.max() > 60.0 else "tape"


def _tape(raw: RawProfile, tape_mm: float | None, from_back: bool, how: dict[str, str]) -> float | None:
    how["tape line"] = "given" if tape_mm is not None else "from the file" if raw.tape_mm is not None else "assumed"
    value = tape_mm if tape_mm is not None else raw.tape_mm
    if value is None:
        return TAPE_MM if from_back else None
    if not 40.0 <= value <= 110.0:
        raise InputError(
            f"a tape line {value:g} mm from the flange's back",
            "40 to 110 mm",
            "70 mm is usual",
        )
    return value


def _numbers(origin: str | None) -> tuple[float, float] | None:
    parts = str(origin or "").split(",")
    try:
        x, y = map(parsed_number, parts)
    except ValueError:
        return None
    if not (abs(x) < 1e6 and abs(y) < 1e6):
        raise InputError(f"--origin {origin}", "two numbers X,Y in the file's unit", "correct the numbers")
    return x, y


def _on_tread(placed: FloatArray, shift: tuple[float, float], notices: list[str]) -> tuple[float, float]:
    """Return a wheel's shift with its tread at the tape line at zero."""
    heights = crossings(placed + shift, 0.0, axis=0)
    if not len(heights):
        notices.append("The profile does not reach its tape line: its height is taken as it is in the file.")
        return shift
    # the flange's face may cross it as well in a wrong frame: the tread is the lowest there
    height = min(heights.tolist(), key=abs)
    if abs(height) <= TREAD_OFF_MM:
        return shift
    notices.append(f"The tread was at a height of {height:.3f} mm at the tape line; it is moved to zero.")
    return shift[0], shift[1] - height


def _shape(points: FloatArray) -> _Shape | None:
    """Tell rails and wheels by the bump between deeper places: a head, or a flange with a tread beside it."""
    for sign in (1.0, -1.0):
        bump = _bump(points[:, 0], sign * points[:, 1])
        if bump is None:
            continue
        left, top, right = bump
        width = abs(float(points[right, 0] - points[left, 0]))
        if _FLANGE_WIDTHS_MM[0] < width <= _FLANGE_WIDTHS_MM[1]:
            sides = [_tread_side(points[top:], sign), _tread_side(points[top::-1], sign)]
            if any(sides):
                return _Shape("wheel", sign < 0.0, -next(side for side in sides if side))
        elif _HEAD_WIDTHS_MM[0] < width < _HEAD_WIDTHS_MM[1]:
            return _Shape("rail", sign > 0.0, 0.0)
    return None


def _half_head(points: FloatArray) -> _Shape | None:
    """Tell up and down of a head of which one side is missing: its ends are lower than its middle."""
    ends = 0.5 * float(points[0, 1] + points[-1, 1])
    lower = float(np.median(points[:, 1])) - ends
    return None if abs(lower) < _MIN_END_DROP_MM else _Shape("rail", lower > 0.0, 0.0)


def _bump(x: FloatArray, height: FloatArray) -> tuple[int, int, int] | None:
    """Numbers of the highest point and of the places beside it that are lower by the neck, None without such places."""
    top = int(np.argmax(height))
    drop = min(float(height[top] - height[: top + 1].min()), float(height[top] - height[top:].min()))
    if drop < _MIN_DROP_MM or len(x) < MIN_POINTS:
        return None
    level = height[top] - min(_NECK_MM, 0.9 * drop)
    left, right = np.flatnonzero(height[:top] < level), np.flatnonzero(height[top:] < level)
    return int(left[-1]), top, top + int(right[0])


def _tread_side(points: FloatArray, sign: float) -> float:
    """Side in x, -1 or 1, of a flat tread well below the first point, 0 if there is none."""
    away = np.abs(points[:, 0] - points[0, 0])
    passed = np.flatnonzero(away >= _TREAD_FROM_MM + _TREAD_MM)
    near = slice(0, int(passed[0]) + 1 if len(passed) else len(points))
    beside = away[near] >= _TREAD_FROM_MM
    depth = sign * (points[0, 1] - points[near, 1][beside])
    if len(depth) < 2 or depth.min() < _MIN_FLANGE_MM or np.ptp(depth) > _TREAD_DROP_MM:
        return 0.0
    if np.ptp(points[near, 0][beside]) < 0.5 * _TREAD_MM:
        return 0.0
    return float(np.sign(points[near, 0][beside][0] - points[0, 0]))
