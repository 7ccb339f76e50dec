"""From the axes of a file to this package's: kind, up and down, side of the track, order, origin.

The user's options come first, then the file's header, then its shape; all else is assumed. The sources are reported.
The points of a rail go from the field side to the gauge side and those of a wheel from the flange's
back to the rim: with the steel at the left, like the outlines of `flangeway.railway.profiles.bundled`.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import is_number, refused
from flangeway.errors import InputError
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.geometry import FloatArray
from flangeway.railway.profiles.formats.miniprof import TAPE_MM
from flangeway.railway.profiles.formats.raw_profile import KINDS, RAIL_ORIGINS, WHEEL_ORIGINS, Kind, Origin, RawProfile
from flangeway.railway.profiles.measures import crossings
from flangeway.railway.profiles.smoothing import MIN_POINTS
from flangeway.units import sentence

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
_FAR_MM = 150.0  # the rim of a wheel is at most this far from its flange's back; half of a gauge is further


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
    if min(abs(x.min()), abs(x.max())) > _FAR_MM and x.min() * x.max() > 0.0:
        raise InputError(
            sentence(
                "lateral coordinates from {:g (mm)} to {:g mm}, far from where a {} has its origin",
                x.min(),
                x.max(),
                kind,
            ),
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
            sentence("a tape line {:g mm} from the flange's back", value),
            sentence("{40 (mm)} to {110 mm}"),
            sentence("{70 mm} is usual"),
        )
    return value


def _numbers(origin: str | None) -> tuple[float, float] | None:
    parts = str(origin or "").split(",")
    try:
        x, y = (float(part) for part in parts)
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
    notices.append(sentence("The tread was at a height of {:.3f mm} at the tape line; it is moved to zero.", height))
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
