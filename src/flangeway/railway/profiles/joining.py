"""A measured running surface on the body of a nominal rail or wheel, and a body from a whole outline."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from flangeway.checks import check_kind
from flangeway.errors import InputError
from flangeway.geometry import Contour, FloatArray, Line, Outline, Placement, Point, Segment, as_point
from flangeway.railway.profiles.bundled import (
    RAILS,
    REFERENCE_RAIL,
    REFERENCE_WHEELS,
    SECTIONS,
    WHEELS,
    RailProfile,
    WheelProfile,
    bundled_name,
    rail,
    wheel,
)
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM
from flangeway.railway.profiles.profile_file import MeasuredProfile, frame_origin, side_notices
from flangeway.railway.profiles.smoothing import MAX_CLIPPED, extent, graphs_of

# --- Pieces of closed outlines, and a rail or wheel from one: its head, base, running surface and cut.


_HEAD_SHARE = 0.6  # of the height: above it the widest point belongs to the head
_POSITION_TOLERANCE = 1e-6
_SLOPE_TOLERANCE = 1e-6
_SPACING_MM = 0.05


def whole_profile(measured: MeasuredProfile) -> RailProfile | WheelProfile:
    """Return a rail or wheel whose file holds its whole outline.

    A rail's origin is put to the middle of its base. Its head reaches from the widest point of the upper part at one
    side over the top to that at the other; its base are the sides at the lowest height. A wheel's running surface is
    all but the straight cut on top and the upright faces below it. An `InputError` if the file holds a running surface
    only, a rail has no flat base, or a wheel no level cut.
    """
    outline = measured.surface
    if not isinstance(outline, Outline):
        raise InputError(
            "a running surface without a body", "a closed outline", "join it to a nominal rail or wheel with --join"
        )
    certainty, source = "As the file draws it.", f"File: {measured.format}."
    if measured.kind == "rail":
        whole = _rail(outline, measured.title, certainty, source)
        return replace(whole, notices=(*measured.notices, *side_notices(whole.running_surface)))
    profile = _wheel(outline, measured.title, measured.flange_back_mm, certainty, source)
    return replace(profile, notices=measured.notices)


def _rail(outline: Outline, title: str, certainty: str, source: str) -> RailProfile:
    low = outline.bounds()[0]
    size = outline.size
    base = [i for i, segment in enumerate(outline.segments) if segment.bounds[1, 1] - low[1] <= _SLOPE_TOLERANCE * size]
    if not base:
        raise InputError("a rail without a flat base", "a straight side at the lowest height", "check the outline")
    ends = np.array([p for i in base for p in (outline.segments[i].start, outline.segments[i].end)])
    middle = 0.5 * float(ends[:, 0].min() + ends[:, 0].max())
    shifted = outline.transformed(Placement(translation=(-middle, -float(low[1]))))
    named = _renamed(shifted, dict.fromkeys(base, "base"), "side")
    field, gauge = _widest(named, 1.0), _widest(named, -1.0)
    pieces = [("head", segment) for _, segment in pieces_between(named, field, gauge)]
    pieces += pieces_between(named, gauge, field)
    whole = Outline.named(pieces)
    return RailProfile(title, whole, ("head",), ("base",), certainty, source)


def _widest(outline: Outline, side: float) -> float:
    """Return the length along a rail's outline of the widest point of its head at a side, the lowest of several."""
    top = outline.top
    best = (-np.inf, 0.0, 0.0)
    for i, segment in enumerate(outline.segments):
        parameters = np.linspace(0.0, 1.0, max(int(segment.length / _SPACING_MM), 2))
        points: FloatArray = segment.point(parameters)
        for (x, y), parameter in zip(points.tolist(), parameters.tolist(), strict=True):
            if y > _HEAD_SHARE * top:
                best = max(best, (round(side * x, 6), -y, float(outline.offsets[i] + parameter * segment.length)))
    return best[2]


def _wheel(outline: Outline, title: str, flange_back_mm: float, certainty: str, source: str) -> WheelProfile:
    high = outline.top
    names: dict[int, str] = {}
    for i, segment in enumerate(outline.segments):
        if isinstance(segment, Line) and segment.bounds[0, 1] >= high - _SLOPE_TOLERANCE * outline.size:
            names[i] = "cut"
    if not names:
        raise InputError("a wheel without a level cut on top", "a straight, level side on top", "check the outline")
    n = outline.n_segments
    for step, name in ((-1, "outer_face"), (1, "back_face")):
        i = next(i for i in names if names[i] == "cut" and (i + step) % n not in names)
        while _is_upright(outline.segments[(i + step) % n]) and (i + step) % n not in names:
            i = (i + step) % n
            names[i] = name
    named = _renamed(outline, names, "running")
    height = -named.bottom
    return WheelProfile(title, named, ("running",), height, flange_back_mm, certainty, source)


def _is_upright(segment: Segment) -> bool:
    return isinstance(segment, Line) and abs(segment.start[0] - segment.end[0]) <= 1e-3 * segment.length


def _renamed(outline: Outline, names: dict[int, str], other: str) -> Outline:
    return Outline.from_segments(outline.segments, [names.get(i, other) for i in range(outline.n_segments)])


def point_at(outline: Outline, length: float) -> Point:
    """Return the point at a length along an outline."""
    i = int(outline.numbers_at(np.array(length)))
    return as_point(outline.segments[i].point((length - outline.offsets[i]) / outline.segments[i].length)[0])


def pieces_between(outline: Contour, first: float, last: float) -> list[tuple[str, Segment]]:
    """Return the named pieces of an outline from one length along it forwards to another."""
    total = float(outline.offsets[-1])
    last = last if last > first else last + total
    pieces: list[tuple[str, Segment]] = []
    for lap in (0.0, total):
        for i, segment in enumerate(outline.segments):
            low, high = outline.offsets[i : i + 2] + lap
            start, end = max(first, low), min(last, high)
            if end - start <= _POSITION_TOLERANCE:
                continue
            cuts = [
                (at - low) / segment.length
                for at in (start, end)
                if low + _POSITION_TOLERANCE < at < high - _POSITION_TOLERANCE
            ]
            parts = segment.split(cuts) if cuts else (segment,)
            inside = 1 if start > low + _POSITION_TOLERANCE else 0
            pieces.append((outline.names[i], parts[inside]))
    return pieces


# --- A measured running surface on the body of a nominal rail or wheel.
#
# The rule: the measured surface is kept whole. From each of its ends a straight transition leads to the nominal
# outline, to the point that lies beyond the end's foot on that outline by a blend: four times the distance between the
# end and its foot, at least `MIN_BLEND_MM` and at most `MAX_BLEND_MM`. The nominal outline closes the body from there.
# The ends may be no further from the nominal outline than the limits below: else the origin is wrong, or it is the
# profile of another rail or wheel.
#
# Files of heads often count from the highest point or from a mark of the instrument instead of the head's middle. A
# head whose ends do not fit is moved sideways until its field side, which does not wear, lies on the nominal one, and a
# notice reports it; the gauge is measured on the head, so that nothing else depends on where the file's x = 0 is.


MIN_BLEND_MM = 1.0
MAX_BLEND_MM = 12.0
BLEND_FACTOR = 4.0
MAX_GAP_MM = 4.0
"""Maximum distance of an end of a rail's head, or of a wheel's flange back, from the nominal outline.

A new head that its file holds inclined by 1:40 about its top ends 3 mm from the upright body.
"""

MAX_WEAR_MM = 12.0
"""The same at the gauge side of a head, where the end lies inside of the nominal outline: a face that is worn."""

MAX_RIM_GAP_MM = 15.0  # the same at the rim of a wheel: rims differ in width
MAX_SHIFT_MM = 15.0  # maximum shift sideways that lays the field side of a measured head on the nominal one

REACHES_MM = {"rail": (-15.0, 10.0), "wheel": (-40.0, 20.0)}
"""First and last x that a measured surface covers at least, from the head's middle or the tape line: where contact is.

A shorter one would be in contact on the nominal outline, without a warning.
"""

HEIGHTS_MM = (-30.0, 1.0)
"""Height of a measured head's top relative to that of the nominal rail: worn, but never higher than new."""

BELOW_HEAD_MM = 3.0  # depth below the nominal head from where a file shows the web, which the body has
HALF_HEAD_MM = 36.0  # distance of a head's middle from its gauge face
TIP_OFF_MM = 0.05  # height of a measured flange above the tip of the joined body below which the tip counts as measured

SPACING_MM = 0.5  # distance of the points whose distances are taken
PLAIN_CUT_MM, PLAIN_BASE_MM = 50.0, 150.0
MEASURED = "measured"

LEANS_DEG = (0.8, 4.0)
"""Lean of a head's field side from the nominal one that is reported: inclinations are 1:60 to 1:15."""

RAIL_SIDES, WHEEL_SIDES = ("field side", "gauge side"), ("flange's back", "rim")
"""Both ends of a running surface, in the direction of the outline."""
CLIPPED_MM = 2.0  # width of a part beyond an overhang from which there is a notice that contact leaves it out
FACE_MM = 5.0  # height of the face, above the end of the measured surface, whose lean is measured
STRAIGHT_MM = 0.02  # distance from a straight line below which a face counts as straight


@dataclass(frozen=True)
class Joint:
    """Where a measured surface goes over into the nominal outline.

    - `foot`: closest point of the nominal outline.
    - `landing`: where the transition reaches the nominal outline.
    - `gap_mm`: distance between end and foot.
    - `name`: name of the transition.
    """

    end: Point
    foot: Point
    landing: Point
    gap_mm: float
    name: str


@dataclass(frozen=True)
class Joined:
    """A body with a measured running surface.

    - `profile`: the rail or wheel, to be used like a bundled one.
    - `nominal`: the rail or wheel whose body it has.
    - `measured`: the measured surface as it was placed.
    - `joints`: both joints, in the direction of the outline.
    """

    profile: RailProfile | WheelProfile
    nominal: RailProfile | WheelProfile
    measured: Contour
    joints: tuple[Joint, Joint]


def joined(measured: MeasuredProfile, name: str) -> Joined:
    """Return a body that has a measured running surface and all else of a nominal rail or wheel.

    Rails are placed by their origin: the file's top is the nominal rail's, or the file counts from the base, or its
    x = 0 is at the nominal gauge face. Wheels have their origin on the tread at the tape line as it is.

    Parameters
    ----------
    measured
        What was read.
    name
        A bundled rail or wheel; ``136RE-8``, ``136RE-14`` are the 136RE with these crown radii.

    Raises
    ------
    InputError
        If the name is unknown or of the other kind, the file holds a whole outline, or the surface does not fit.
    """
    _refuse_unread("joined", measured)
    nominal = nominal_profile(name)
    kind: Kind = "rail" if isinstance(nominal, RailProfile) else "wheel"
    if measured.kind != kind:
        known = RAILS if measured.kind == "rail" else WHEELS
        raise InputError(f"--join {name}, a {kind}, for a {measured.kind}", ", ".join(known), "choose one of these")
    if isinstance(measured.surface, Outline):
        raise InputError(f"--join {name} for a closed outline", "a running surface", "leave --join out: it is whole")
    measured = _above_web(measured, nominal)
    shift, offset = _shift(measured, nominal)
    surface = measured.surface.transformed(Placement(translation=shift))
    outline, joints = _closed(surface, nominal, partial(measured.place, moved=shift))
    running = _running(outline, nominal.running_names)
    notices = (*measured.notices, *clipped_notices(outline.part(running), measured, shift))
    if offset:
        notices = (
            *notices,
            f"The head is moved sideways by {offset:.2f} mm: its field side lies on the nominal one.",
        )
    _refuse_short(surface, kind)
    title = f"{measured.title} (body of {nominal.title})"
    certainty = (
        "Running surface as measured, joined by straight transitions to the nominal "
        f"{nominal.title}.{_tape_text(measured)}"
    )
    source = f"File: {measured.format}. Body: {nominal.source}"
    notices += (
        _lean(surface, nominal) if isinstance(nominal, RailProfile) else _unmeasured_tip(surface, outline, nominal)
    )
    base = nominal.held_names if isinstance(nominal, RailProfile) else ()
    profile = _with_body(measured, shift, (title, outline, running, base), (certainty, source, notices))
    if isinstance(profile, RailProfile) and isinstance(nominal, RailProfile):
        profile = replace(profile, unworn=nominal.unworn)
    return Joined(profile, nominal, surface, joints)


def _refuse_unread(owner: str, measured: object) -> None:
    check_kind(
        owner, "measured", measured, MeasuredProfile, "a profile that was read", "give what read_profile returns"
    )


def _with_body(
    measured: MeasuredProfile,
    shift: tuple[float, float],
    shape: tuple[str, Outline, tuple[str, ...], tuple[str, ...]],
    words: tuple[str, str, tuple[str, ...]],
) -> RailProfile | WheelProfile:
    """Return a measured profile with its body as a rail or wheel.

    - `shift`: from the frame of the file to that of the outline.
    - `shape`: title, outline, names of the running surface in its direction, and of a rail's base.
    - `words`: certainty, source, notices.
    """
    title, outline, running, base = shape
    if measured.kind == "rail":
        placing = measured.first_slice and measured.first_slice.transformed(Placement(translation=shift))
        return RailProfile(title, outline, running[::-1], base, *words, placing)
    height = -outline.bottom
    return WheelProfile(title, outline, running, height, measured.flange_back_mm, *words)


def clipped_notices(
    running: Contour, measured: MeasuredProfile, moved: tuple[float, float] = (0.0, 0.0)
) -> tuple[str, ...]:
    """Return a notice for each end at which contact leaves out more than `CLIPPED_MM` beyond an overhang.

    An `InputError` if as much lies beyond it as of a second running surface, see `MAX_CLIPPED`.

    - `running`: running surface of the joined body, from the field side to the gauge side or from the back to the rim.
    - `moved`: what it was moved by from where the file's axes have it.
    """
    kept, *others = graphs_of(running)
    x, y, angle, curvature, length = kept[-1]
    mean = angle + 0.5 * curvature * length
    chord = length * np.sinc(0.5 * curvature * length / np.pi)
    ends = (kept[0, :2], np.array([x + chord * np.cos(mean), y + chord * np.sin(mean)]))
    words = RAIL_SIDES[::-1] if measured.kind == "rail" else WHEEL_SIDES
    if others and extent(others[0]) > MAX_CLIPPED * extent(kept):
        raise InputError(
            f"a surface that overhangs at {measured.place(ends[int(others[0][0, 0] > x)], moved)}",
            f"one running surface, or parts beyond an overhang up to {MAX_CLIPPED:g} of its width",
            "save the part that the wheel runs on alone, and remove hooks of the measurement",
        )
    beyond = {bool(other[0, 0] > kept[0, 0]) for other in others if extent(other) > CLIPPED_MM}
    return tuple(
        f"Beyond {measured.place(ends[after], moved)} the surface overhangs; contact leaves it out ({words[after]})."
        for after in sorted(beyond)
    )


def body_distance_mm(measured: MeasuredProfile, name: str) -> float | None:
    """Median distance of a measured surface from a bundled outline, which wear hardly changes; None if it does not fit.

    The head's ends alone do not tell rails apart.
    """
    nominal = nominal_profile(name)
    head = _above_web(measured, nominal)
    try:
        shift = _shift(head, nominal)[0]
        placed = Placement(translation=shift)
        _joints(head.surface.transformed(placed), nominal, partial(measured.place, moved=shift))
    except InputError:
        return None
    # with what lies below the head, by which rails differ
    surface = measured.surface.transformed(placed)
    return float(np.median(nominal.outline.closest(surface.sampled(spacing=SPACING_MM))[2]))


def _above_web(measured: MeasuredProfile, nominal: RailProfile | WheelProfile) -> MeasuredProfile:
    """Return a rail's head without the web that its file has below it, with a notice."""
    if not isinstance(nominal, RailProfile) or measured.first_slice is not None:
        return measured
    segments = measured.surface.segments
    heights = np.array([min(segment.start[1], segment.end[1]) for segment in segments])
    foot = float(nominal.outline.bounds(nominal.running_names)[0, 1])
    level = foot - _rail_shift(measured, nominal)[1] - BELOW_HEAD_MM
    below = np.flatnonzero(heights < level)
    if not len(below) or len(below) == len(segments):
        return measured
    top = int(np.argmax(heights))
    first = int(below[below < top].max(initial=-1)) + 1
    last = int(below[below > top].min(initial=len(segments)))
    kept = Contour.from_segments(segments[first:last], measured.surface.names[first:last])
    words = ("gauge side", last < len(segments)), ("field side", first > 0)
    left_out = [
        f"{measured.place(point)} ({side})"
        for (side, is_cut), point in zip(words, kept.ends[::-1], strict=True)
        if is_cut
    ]
    notice = f"What lies below the head is left out, beyond {' and '.join(left_out)}."
    return replace(measured, surface=kept, notices=(*measured.notices, notice))


def _shift(measured: MeasuredProfile, nominal: RailProfile | WheelProfile) -> tuple[tuple[float, float], float]:
    """Return the shift of a measured surface to the frame of a nominal profile, and its part that made it fit."""
    if isinstance(nominal, WheelProfile):
        return (0.0, 0.0), 0.0
    shift = _rail_shift(measured, nominal)
    surface = (measured.first_slice or measured.surface).transformed(Placement(translation=shift))
    _refuse_height(surface, nominal)
    try:
        _joints(surface, nominal, partial(measured.place, moved=shift))
    except InputError:
        offset = _field_shift(measured, surface, nominal)
        if offset is None:
            raise
        return (shift[0] + offset, shift[1]), offset
    return shift, 0.0


def nominal_profile(name: str) -> RailProfile | WheelProfile:
    """Return a bundled rail or wheel by a name such as ``136RE-8`` or ``UIC 60``, see `bundled_name`.

    An `InputError` if there is none of that name.
    """
    known = bundled_name(name)
    if known in (*WHEELS, *REFERENCE_WHEELS):
        return wheel(known)
    if known not in (*SECTIONS, REFERENCE_RAIL):
        raise InputError(f"a rail or wheel called {name!r}", BUNDLED_NAMES, "choose one of them, or give a file")
    rail_name, radius = SECTIONS.get(known, (known, None))
    return rail(rail_name, crown_radius_in=radius)


BUNDLED_NAMES = ", ".join(("136RE", "136RE-8", "136RE-14", *RAILS[1:], REFERENCE_RAIL, *WHEELS, *REFERENCE_WHEELS))


def _rail_shift(measured: MeasuredProfile, nominal: RailProfile) -> tuple[float, float]:
    """Return the shift of a measured head to the frame of a nominal rail."""
    origin = frame_origin(measured)
    height = nominal.outline.top
    if origin == "base":
        return 0.0, 0.0
    if origin == "top":
        return 0.0, height
    head = nominal.outline.part(nominal.running_names).sampled(spacing=0.1)
    face = head[head[:, 0] < 0.0]
    order = np.argsort(face[:, 1])
    return float(np.interp(height - GAUGE_DEPTH_MM, face[order, 1], face[order, 0])), height


def _field_shift(measured: MeasuredProfile, surface: Contour, nominal: RailProfile | WheelProfile) -> float | None:
    """Return the shift of a measured head's field side onto the nominal one; None where that does not help."""
    if not isinstance(nominal, RailProfile) or frame_origin(measured) != "top":
        return None
    if measured.orientation.how.get("origin") == "given":
        return None
    x, y = max(surface.ends)
    face = _field_side(nominal.outline.part(nominal.running_names))
    face = face[np.argsort(face[:, 1])]
    if not face[0, 1] - MAX_GAP_MM <= y <= face[-1, 1]:
        return None
    shift = float(np.interp(y, face[:, 1], face[:, 0])) - x
    return shift if abs(shift) <= MAX_SHIFT_MM else None


def _field_side(head: Contour) -> FloatArray:
    """Points (n, 2) of a head away from the track's middle."""
    points = head.sampled(spacing=0.1)
    return points[points[:, 0] > 0.0]


def _lean(surface: Contour, nominal: RailProfile) -> tuple[str, ...]:
    """Report a head whose field side, which does not wear, is not parallel to that of the nominal rail."""
    sides = [_field_side(head) for head in (surface, nominal.outline.part(nominal.running_names))]
    low = float(sides[0][:, 1].min())
    slopes = []
    for side in sides:
        part = side[(side[:, 1] >= low) & (side[:, 1] <= low + FACE_MM)]
        if len(part) < FACE_MM / 0.2:
            return ()
        line = np.polyfit(part[:, 1], part[:, 0], 1)
        if np.abs(np.polyval(line, part[:, 1]) - part[:, 0]).max() > STRAIGHT_MM:
            return ()
        slopes.append(float(np.degrees(np.arctan(line[0]))))
    lean = slopes[1] - slopes[0]
    if not LEANS_DEG[0] <= abs(lean) <= LEANS_DEG[1]:
        return ()
    what = f"The head's field side leans by {abs(lean):.1f} degrees {'to' if lean > 0.0 else 'from'} the track's middle"
    if lean > 0.0:
        return (
            f"{what}: if it was measured in the track's axes it holds the rail's inclination; give "
            f"track.inclination = 0 then.",
        )
    return (f"{what}: a left-hand rail, measured in the track's axes, needs --mirror, and track.inclination = 0.",)


def on_plain_body(measured: MeasuredProfile) -> RailProfile | WheelProfile:
    """Return a rail or wheel with a measured running surface on a block of steel with upright faces at its ends.

    A wheel's block is cut level `PLAIN_CUT_MM` above the tape line, a rail's `PLAIN_BASE_MM` below its top; 10 mm
    beyond the surface if that is more. For profiles different from all bundled ones: the stresses beside the contact
    are those of the block. An `InputError` if it is no running surface, or the faces meet it.
    """
    _refuse_unread("on_plain_body", measured)
    surface, is_rail = measured.surface, measured.kind == "rail"
    if isinstance(surface, Outline):
        raise InputError(f"a plain body for {measured.title}", "a running surface", "leave it out")
    middle = HALF_HEAD_MM if is_rail and frame_origin(measured) == "gauge" else 0.0
    _refuse_short(surface, measured.kind, middle)
    start, end = surface.ends
    (_, low), (_, top) = (measured.first_slice or surface).bounds()
    level = min(top - PLAIN_BASE_MM, low - 10.0) if is_rail else max(PLAIN_CUT_MM, start[1] + 10.0, end[1] + 10.0)
    around = ("gauge_face", "base", "field_face") if is_rail else ("outer_face", "cut", "back_face")
    names = [*[MEASURED] * len(surface.segments), *around]
    outline = Outline.closed(surface.segments, [(end[0], level), (start[0], level)], names)
    title, source = f"{measured.title} on a plain body", f"File: {measured.format}."
    certainty = "Running surface as measured, on a block of steel with upright faces." + _tape_text(measured)
    notices = (*measured.notices, *clipped_notices(surface, measured))
    shift = (-0.5 * (start[0] + end[0]), -level) if is_rail else (0.0, 0.0)
    placed = outline.transformed(Placement(translation=shift))
    return _with_body(measured, shift, (title, placed, (MEASURED,), ("base",)), (certainty, source, notices))


def _tape_text(measured: MeasuredProfile) -> str:
    """Return a sentence on the position of a wheel's tape line; nothing for rails."""
    taken = measured.orientation
    if taken.tape_mm is None:
        return ""
    return f" Its tape line is {taken.tape_mm:g} mm from the flange's back ({taken.how['tape line']})."


def _unmeasured_tip(surface: Contour, outline: Outline, nominal: WheelProfile) -> tuple[str, ...]:
    tip = -outline.bottom
    if surface.bottom <= -tip + TIP_OFF_MM:
        return ()
    return (
        (
            f"The flange's tip is not measured: the nominal {nominal.title} has it {tip:.2f} mm below the tape "
            "line, from where a radius at the flange tip counts."
        ),
    )


def _refuse_short(surface: Contour, kind: Kind, middle: float = 0.0) -> None:
    (low, _), (high, _) = surface.bounds() - np.array([middle, 0.0])
    first, last = REACHES_MM[kind]
    if low > first or high < last:
        raise InputError(
            f"a measured surface from x = {low:.4g} to {high:.4g} mm, too short for the contact",
            f"at least from {first:g} to {last:g} mm, counted from the "
            + ("middle of the head" if kind == "rail" else "tape line"),
            "measure the whole running surface, or check --origin and --tape",
        )


def _refuse_height(surface: Contour, nominal: RailProfile) -> None:
    height = surface.top - nominal.outline.top
    low, high = HEIGHTS_MM
    if not low <= height <= high:
        raise InputError(
            f"a measured head whose top is {height:.3g} mm above that of the nominal {nominal.title}",
            f"{low:g} to {high:g} mm",
            "check --origin and the name after --join",
        )


def _joints(
    surface: Contour, nominal: RailProfile | WheelProfile, where: Callable[[Point], str]
) -> tuple[list[float], tuple[Joint, Joint]]:
    """Return the lengths along the nominal outline at which the transitions land, and both joints."""
    is_rail = isinstance(nominal, RailProfile)
    words = RAIL_SIDES if is_rail else WHEEL_SIDES
    names = ("transition_field", "transition_gauge") if is_rail else ("transition_back", "transition_rim")
    limits = (MAX_GAP_MM, MAX_GAP_MM if is_rail else MAX_RIM_GAP_MM)
    total = float(nominal.outline.offsets[-1])
    lengths, joints = [], []
    for i, (end, sense) in enumerate(zip(surface.ends, (-1.0, 1.0), strict=True)):
        foot_place = float(nominal.outline.lengths_at([end])[0])
        foot = point_at(nominal.outline, foot_place % total)
        gap = math.dist(end, foot)
        limit = MAX_WEAR_MM if is_rail and i == 1 and end[0] > foot[0] else limits[i]
        if gap > limit:
            raise InputError(
                f"the end of the measured surface at the {words[i]}, {where(end)}, {gap:.3g} mm from the "
                f"nominal {nominal.title}",
                f"up to {limit:g} mm",
                "check --origin, --mirror and the name after --join"
                + ("" if is_rail else ", and the tape line: --tape"),
            )
        blend = min(max(MIN_BLEND_MM, BLEND_FACTOR * gap), MAX_BLEND_MM)
        length = (foot_place + sense * blend) % total
        lengths.append(length)
        joints.append(Joint(end, foot, point_at(nominal.outline, length), gap, names[i]))
    return lengths, (joints[0], joints[1])


def _closed(
    surface: Contour, nominal: RailProfile | WheelProfile, where: Callable[[Point], str]
) -> tuple[Outline, tuple[Joint, Joint]]:
    """Return the outline of the measured surface, both transitions, and the remainder of the nominal outline."""
    lengths, joints = _joints(surface, nominal, where)
    others = pieces_between(nominal.outline, lengths[1], lengths[0])
    chain: list[tuple[str, Segment]] = [
        (joints[0].name, Line(joints[0].landing, joints[0].end)),
        *((MEASURED, segment) for segment in surface.segments),
        (joints[1].name, Line(joints[1].end, joints[1].landing)),
        *others,
    ]
    try:
        outline = Outline.named(chain)
    except InputError as reason:
        raise InputError(
            f"the measured surface on the nominal {nominal.title}: {reason.given}",
            "a surface that fits the body",
            "check --origin, --mirror and the name after --join",
        ) from reason
    return outline, joints


def _running(outline: Outline, nominal_names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the running surface: measured, transitions, and and the remaining nominal parts."""
    running = {MEASURED, *nominal_names, *(name for name in outline.names if name.startswith("transition"))}
    n = outline.n_segments
    start = next(i for i in range(n) if outline.names[i] == MEASURED)
    first = last = start
    while outline.names[(first - 1) % n] in running and last - first < n - 1:
        first -= 1
    while outline.names[(last + 1) % n] in running and last - first < n - 1:
        last += 1
    return tuple(dict.fromkeys(outline.names[i % n] for i in range(first, last + 1)))
