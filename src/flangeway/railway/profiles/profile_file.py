"""Profiles from files of all formats, checked, in this package's frames, and back into files."""

import codecs
import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_kind
from flangeway.errors import InputError, located
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.geometry import Arc, Contour, FloatArray, Line, Outline, Segment, as_point
from flangeway.geometry.arrays import cross_product, norms, step_lengths
from flangeway.railway.profiles.formats.instrument_files import (
    TAPE_MM,
    is_segment_csv,
    read_dxf_profile,
    read_miniprof,
    read_segment_csv,
    read_simpack,
    write_dxf_profile,
    write_miniprof,
    write_segment_csv,
    write_simpack,
)
from flangeway.railway.profiles.formats.slice_files import SLICES, UNITS, read_slices
from flangeway.railway.profiles.formats.two_column import (
    Kind,
    RawProfile,
    one_line,
    read_json,
    read_two_column,
    write_two_column,
)
from flangeway.railway.profiles.orientation import (
    Orientation,
    ReadOptions,
    agreed_unit,
    left_hand,
    orientation,
    seen_back_mm,
    worn_side,
)
from flangeway.railway.profiles.smoothing import (
    MIN_POINTS,
    USUAL_WAVELENGTH_MM,
    Smoothing,
    noise_um,
    refuse_few,
    rounding_um,
    smoothed,
)
from flangeway.system.file_content import file_content, path_of
from flangeway.types import Ints, floats

# --- Checks of measured points: doubled ones are left out, other errors are refused with their line.


SAME_MM = 0.01  # neighbours nearer than this are one point given twice
MERGED_NOISES = 8.0
"""Distance relative to the noise within which neighbours are merged, if most are as near: farther ones are in order."""
MAX_MERGED_MM = 0.25
"""The same at most: the usual spacing of points."""
LENGTHS_MM = (5.0, 1000.0)  # lengths along a profile, for a unit that the file or the user names
USUAL_LENGTHS_MM = (40.0, 500.0)  # lengths along a profile, for a unit that is assumed

UNITS_TO_GUESS = {"in": 25.4, "m": 1000.0, "cm": 10.0}

MAX_GAP_MM = 25.0
_SMALL_GAP_MM = 5.0
_TURN_OVER_GAP_DEG = 12.0
_FOLD_DEG = 100.0
_MAX_FOLD_MM = 1.0
_MAX_FOLDED = 20
_MAX_HOOK_POINTS = 3  # points at the end of a file that may be a stray stroke
_OUTLIER_UM = 100.0
MAX_OUTLIERS = 0.05  # part of the points that may be off the curve

Lines = Ints


def checked_points(points: FloatArray, lines: Lines, *, unit_is_sure: bool) -> tuple[FloatArray, Lines, list[str]]:
    """Return the points (n, 2) in mm that can be used, their lines (n,), and a notice of what was left out or bridged.

    An `InputError` if there are too few points, the length is no profile's, points are out of order, many are off the
    curve, or a part is missing.

    - `points`: points (n, 2) in mm, in the order of the file.
    - `lines`: line of the file of each.
    - `unit_is_sure`: whether the unit was named; lengths of a profile in an assumed unit have to be usual ones.
    """
    refuse_few(points)
    refuse_length(points, unit_is_sure)
    notices: list[str] = []
    for repaired in (_merged, _without_outliers, _without_folds):
        points, lines, more = repaired(points, lines)
        refuse_few(points)
        notices += more
    return points, lines, notices + _gaps(points, lines)


def refuse_length(points: FloatArray, unit_is_sure: bool) -> None:
    """Refuse points (n, 2) in mm along a curve that is far shorter or longer than any rail or wheel.

    An `InputError` if it is; the message names the unit that the file may have.
    """
    low, high = LENGTHS_MM if unit_is_sure else USUAL_LENGTHS_MM
    # noise lengthens the path of dense points, the box does not
    size = float(norms(np.ptp(points, axis=0)))
    path = float(step_lengths(points).sum())
    if not (0.5 * low <= size and path >= low and size <= high):
        # the unit that makes it about as long as heads and treads are
        guess = min(UNITS_TO_GUESS, key=lambda unit: abs(math.log(max(path, 1e-9) * UNITS_TO_GUESS[unit] / 150.0)))
        fits = not unit_is_sure and 40.0 <= path * UNITS_TO_GUESS[guess] <= high
        advice = (
            f"is its unit {guess}? Then give --unit {guess}" if fits else "check the unit, --unit mm if it is right"
        )
        raise InputError(
            f"a profile of {path:.4g} mm along its curve",
            f"{low:g} to {high:g} mm",
            "check the numbers and the unit that is named" if unit_is_sure else advice,
        )


def _merged(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    """Take means of points given twice, and of points denser than their noise, which has no order along the curve."""
    starts = _starts(points, SAME_MM)
    if len(starts) < MIN_POINTS:
        return points[starts], lines[starts], []
    reach = float(np.clip(MERGED_NOISES * 1e-3 * noise_um(points[starts]), SAME_MM, MAX_MERGED_MM))
    if float(np.median(step_lengths(points[starts]))) < reach:
        starts = _starts(points, reach)
    else:
        reach = SAME_MM
    n_merged = len(points) - len(starts)
    if not n_merged:
        return points, lines, []
    means = np.add.reduceat(points, starts) / np.diff(np.append(starts, len(points)))[:, None]
    first = lines[np.setdiff1d(np.arange(len(points)), starts)[0]]
    why = " of each other" if reach == SAME_MM else ", denser than their noise,"
    notice = f"{n_merged} of {len(points)} points within {reach:.2g} mm{why} are merged into means"
    return means, lines[starts], [f"{notice}, the first in line {first}."]


def _starts(points: FloatArray, reach_mm: float) -> Ints:
    """Numbers of the points (n, 2) that are at least a distance from the start before them."""
    starts = [0]
    rows = points.tolist()
    for number, point in enumerate(rows):
        if math.dist(point, rows[starts[-1]]) >= reach_mm:
            starts.append(number)
    return np.array(starts, dtype=np.int64)


def _outliers(points: FloatArray) -> Ints:
    """Numbers of single points that stick out of a curve which is smooth without them."""
    before, here, after = points[:-2], points[1:-1], points[2:]
    out = np.zeros(len(points))
    out[1:-1] = _off_line(here, before, after)
    without = np.zeros(len(points))
    # how much the curve bends about the point, seen by the neighbours that pass it over
    without[2:-2] = np.maximum(
        _off_line(points[1:-3], points[:-4], points[3:-1]), _off_line(points[3:-1], points[1:-3], points[4:])
    )
    # where sweeps overlap, the neighbours lie beside each other; that is no outlier but a fold
    steps = step_lengths(points)
    apart = np.zeros(len(points), dtype=np.bool_)
    apart[2:-2] = norms(points[3:-1] - points[1:-3]) > 0.7 * np.minimum(steps[:-3], steps[3:])
    least = 1e-3 * max(_OUTLIER_UM, 10.0 * noise_um(points))
    outliers: Ints = np.flatnonzero((out > least) & (out > 6.0 * without) & apart)
    return outliers


def _off_line(points: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Distances (n,) of points from the lines through two others each."""
    along = ends - starts
    apart = points - starts
    length = np.maximum(norms(along), 1e-12)
    distances: FloatArray = np.abs(cross_product(along, apart)) / length
    return distances


def _point(point: FloatArray) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g}) mm"


def _without_outliers(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    outliers = _outliers(points)
    if not len(outliers):
        return points, lines, []
    what = f"line {lines[outliers[0]]}: the point {_point(points[outliers[0]])}"
    if len(outliers) > MAX_OUTLIERS * len(points):
        raise InputError(
            f"{len(outliers)} points off the curve, the first in " + what, "a smooth curve", "measure again"
        )
    kept = np.setdiff1d(np.arange(len(points)), outliers)
    return (
        points[kept],
        lines[kept],
        [f"{len(outliers)} of {len(points)} points off the curve are left out, the first in {what}."],
    )


def _without_folds(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    """Leave out points that go back a little, as where two sweeps of an instrument overlap; refuse larger folds."""
    kept = [0, 1]
    dropped = []
    for i in range(2, len(points)):
        last = points[kept[-1]]
        turn = float(_turns_deg((last - points[kept[-2]])[None], (points[i] - last)[None])[0])
        if turn <= _FOLD_DEG:
            kept.append(i)
            continue
        dropped.append(i)
        if len(points) - i <= _MAX_HOOK_POINTS:
            notice = (
                f"The last {len(points) - i} of {len(points)} points turn back and are left out, from line {lines[i]}."
            )
            return points[kept], lines[kept], [notice]
        if math.dist(points[i], last) > _MAX_FOLD_MM or len(dropped) > _MAX_FOLDED:
            raise InputError(
                f"line {lines[i]}: the points turn back at {_point(last)}",
                f"points in order along the profile, or overlaps up to {_MAX_FOLD_MM:g} mm",
                "sort the points along the profile, or remove those that are wrong",
            )
    if not dropped:
        return points, lines, []
    location = f"line {lines[dropped[0]]} at {_point(points[dropped[0]])}"
    return (
        points[kept],
        lines[kept],
        [f"{len(dropped)} of {len(points)} points that go back are left out, the first in {location}."],
    )


def _gaps(points: FloatArray, lines: Lines) -> list[str]:
    """Refuse missing parts where the profile turns; return notices of those that are bridged."""
    steps = np.diff(points, axis=0)
    lengths = norms(steps)
    wide = np.flatnonzero(lengths > max(_SMALL_GAP_MM, 8.0 * float(np.median(lengths))))
    notices = []
    for i in wide.tolist():
        gap = f"gap of {lengths[i]:.3g} mm from {_point(points[i])} to {_point(points[i + 1])}, line {lines[i]}"
        before = points[i] - points[max(i - 4, 0)]
        after = points[min(i + 5, len(points) - 1)] - points[i + 1]
        around = [d for d in (before, after) if norms(d) > 0.0]
        turn = max(float(_turns_deg(steps[i][None], d[None])[0]) for d in around) if around else 180.0
        at_end = len(around) < 2
        if lengths[i] > MAX_GAP_MM or turn > _TURN_OVER_GAP_DEG or at_end:
            raise InputError(
                "a " + gap,
                f"gaps up to {MAX_GAP_MM:g} mm, and only where the profile is straight",
                "measure it again",
            )
        notices.append("A " + gap + ", is bridged: the profile is straight there.")
    return notices


def _turns_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angles (n,) between directions (n, 2)."""
    turns: FloatArray = np.degrees(np.abs(np.arctan2(cross_product(first, second), (first * second).sum(axis=1))))
    return turns


# --- Profiles from files of all formats, in this package's frames, and back into files.


FORMATS = {
    ".ban": "MiniProf",
    ".whl": "MiniProf",
    ".prr": "Simpack",
    ".prw": "Simpack",
    ".dxf": "DXF",
    ".csv": "CSV",
    ".txt": "two columns",
    ".dat": "two columns",
    ".rail": "two columns",
    ".wheel": "two columns",
}
"""Formats by the ending of the file's name."""

READABLE = (*FORMATS, ".json", *SLICES)  # endings of files that are read

_KINDS_BY_ENDING: dict[str, Kind] = {
    **dict.fromkeys((".ban", ".prr", ".rail"), "rail"),
    **dict.fromkeys((".whl", ".prw", ".wheel"), "wheel"),
}
MAX_LINE = 10_000  # letters in a line of a text
_CONTROL = bytes(set(range(32)) - {9, 10, 12, 13})
_SPACING_MM = 0.25
_MAX_HELD = 0.05
_DEVIATION_MM = 2e-4

MIRRORED = "The file holds a left-hand rail, and is mirrored"
FIELD_WORN = "The head is worn more at the field side"
"""MIRRORED, FIELD_WORN: beginnings of notices of which results warn."""
BACK_OFF_MM = 0.5
"""Difference of a measured flange back from the tape distance of the file above which there is a notice."""


@dataclass(frozen=True, eq=False)
class MeasuredProfile:
    """A running surface or whole outline from a file, in mm and this package's axes, with the steel at its left.

    Wheels have their origin on the tread at the tape line. Rails have it where the file has it: at the middle of the
    head's top, of the base, or at the gauge face, see `orientation`.

    - `orientation`: how the numbers of the file were interpreted.
    - `points`: points (n, 2) as measured; of lines and arcs, points along them.
    - `surface`: lines and arcs: the file's own, or arcs along the smooth curve. An `Outline` if the file holds a closed
      one.
    - `smoothing`: the smooth curve beside the points; None for lines and arcs.
    - `notices`: sentences on what was left out, bridged or assumed.
    - `first_slice`: of a rail that varies along the track the surface of the first slice, which places all of them.
    - `file`: name of its file.
    """

    title: str
    format: str
    orientation: Orientation
    points: FloatArray
    surface: Contour
    smoothing: Smoothing | None
    notices: tuple[str, ...] = ()
    first_slice: Contour | None = None
    file: str = ""

    def __post_init__(self) -> None:
        """Make the points read-only."""
        self.points.setflags(write=False)

    @property
    def kind(self) -> Kind:
        """Rail or wheel."""
        return self.orientation.kind

    @property
    def flange_back_mm(self) -> float:
        """Distance of a wheel's inner face from the tape line, from its file, its flange's back, or assumed.

        An `InputError` if it is a rail.
        """
        if self.orientation.tape_mm is None:
            raise InputError(f"the tape line of {self.title}, a rail", "a wheel", "give the file of a wheel")
        return self.orientation.tape_mm

    def place(self, point: ArrayLike, moved: tuple[float, float] = (0.0, 0.0)) -> str:
        """Return words for a point in this package's axes, moved from there, in the file's own coordinates."""
        x, y = self.orientation.undone(floats(point) - moved)
        return f"x = {x:z.5g}, y = {y:z.5g} {self.orientation.unit} in {self.file or self.title}"

    @property
    def best_points(self) -> FloatArray:
        """Points (n, 2) to write into other formats: the smooth curve's, or the measured ones without smoothing."""
        if self.smoothing is None or self.smoothing.wavelength_mm == 0.0:
            return self.points
        return self.smoothing.points


def read_profile(path: str | Path, options: ReadOptions | None = None) -> MeasuredProfile:
    """Read a profile; the ending of the file's name gives its format, see `READABLE`.

    Raises
    ------
    InputError
        If the file cannot be read, is no profile, or the meaning of its numbers is missing; the message names the line.
    """
    file, given = path_of("read_profile", path), options or ReadOptions()
    check_kind("read_profile", "options", given, ReadOptions, "ReadOptions(...)", "leave it out")
    ending = file.suffix.lower()
    if ending not in READABLE:
        raise InputError(
            f"file {file} with the ending {ending!r}", ", ".join(READABLE), "save the profile in one of these"
        )
    content = file_content(file, "a profile")
    with located(f"{file}: "):
        if ending in SLICES:
            slices = read_slices(file, _text(content))
            position = slices.wanted(given.position)
            stem = f"{file.stem} at {position:g} {UNITS[slices.kind]}"
            read, options = partial(_slice, unit=given.unit), replace(given, unit=None)
            profile = _profile(slices.section(position, read), "slices", options, stem, slices.slice(0, read))
            return replace(profile, file=file.name)
        if given.position is not None:
            raise InputError(f"--position {given.position:g}", f"a file of slices, {', '.join(SLICES)}", "leave it out")
        return replace(_profile(_read(content, ending), FORMATS.get(ending, "JSON"), given, file.stem), file=file.name)


def sections_of(file: Path) -> tuple[float, ...]:
    """Return the positions of the slices that a file lists; none if it is no list of slices."""
    if file.suffix.lower() not in SLICES:
        return ()
    with located(f"{file}: "):
        return tuple(read_slices(file, _text(file_content(file, "a list of slices"))).positions.tolist())


def _slice(file: Path, unit: str | None) -> RawProfile:
    """Return the content of the file of a slice, in mm if the user gives the unit that it does not name."""
    with located(f"slice {file}: "):
        raw = _read(file_content(file, "a slice"), file.suffix.lower())
        if unit is None or raw.unit is not None:
            return raw
        return replace(raw, points=raw.points * UNITS_MM[agreed_unit(raw, unit)], unit="mm")


def _read(content: bytes, ending: str) -> RawProfile:
    if ending == ".dxf":
        return read_dxf_profile(content)
    text = _text(content)
    if ending == ".json":
        return read_json(text)
    line, longest = max(enumerate(map(len, text.splitlines()), 1), key=lambda row: row[1], default=(0, 0))
    if longest > MAX_LINE:
        raise InputError(
            f"line {line} of {longest} letters", f"up to {MAX_LINE}", "check the ending of the file's name"
        )
    if ending in (".ban", ".whl"):
        return read_miniprof(text, _KINDS_BY_ENDING[ending])
    if ending in (".prr", ".prw"):
        return read_simpack(text, _KINDS_BY_ENDING[ending])
    if ending == ".csv" and is_segment_csv(text):
        return read_segment_csv(text)
    raw = read_two_column(text)
    return replace(raw, kind=raw.kind or _KINDS_BY_ENDING.get(ending))


def _profile(
    raw: RawProfile, format_: str, options: ReadOptions, stem: str, first: RawProfile | None = None
) -> MeasuredProfile:
    """Return the profile; of slices all are placed as the first one."""
    scale = UNITS_MM[agreed_unit(raw, options.unit)]
    rounding = rounding_um(raw.points, scale)
    raw, repairs = _repaired(raw, options, scale)
    taken, assumed, mirrored = _oriented(raw, options, first)
    if raw.contour is not None:
        surface, smoothing, smoothed_away = _placed(raw.contour, taken), None, list[str]()
        points = surface.sampled(spacing=_SPACING_MM, max_deviation=_DEVIATION_MM)
        format_ = format_ if format_ == "DXF" else "CSV of lines and arcs"
    else:
        points = taken.in_order(raw.points)
        smoothing = smoothed(points, options.smooth_mm, options.limit_um, "measured", rounding)
        surface, smoothed_away = smoothing.curve, _of_smoothing(smoothing, options, len(points))
    taken, contradictions = _checked_against_shape(taken, surface)
    title, placing = one_line(raw.title) or stem, None
    if first is not None:
        title = stem
        if taken.kind == "rail":
            ordered = taken.in_order(first.points)
            placing = smoothed(ordered, options.smooth_mm, options.limit_um, "measured").curve
    notices = (*assumed, *repairs, *mirrored, *smoothed_away, *contradictions)
    return MeasuredProfile(title, format_, taken, points, surface, smoothing, notices, placing)


def _repaired(raw: RawProfile, options: ReadOptions, scale: float) -> tuple[RawProfile, list[str]]:
    """Return the profile with the points that can be used, see `checked_points`, and notices; lines and arcs as is.

    - `scale`: length of the file's unit in mm.
    """
    sure = (raw.unit is not None and raw.unit_is_sure) or options.unit is not None
    if raw.contour is not None:
        refuse_length(raw.points * scale, sure)
        return raw, []
    points, lines, notices = checked_points(raw.points * scale, raw.lines, unit_is_sure=sure)
    return replace(raw, points=points / scale, lines=lines), notices


def _oriented(
    raw: RawProfile, options: ReadOptions, first: RawProfile | None
) -> tuple[Orientation, list[str], list[str]]:
    """Return the interpretation of a file, notices of what was assumed, and a notice if it was mirrored.

    Measured heads that are those of a left-hand rail are mirrored; the sides of crossings, and of what was drawn, may
    differ.
    """
    taken, assumed = orientation(first or raw, options)
    mirrored = list[str]()
    measured = first is None and raw.contour is None and not raw.mirrored
    if taken.kind == "rail" and measured and options.mirror is None and (why := left_hand(taken.applied(raw.points))):
        taken, assumed = orientation(raw, replace(options, mirror=True))
        taken = taken.by(side="from the worn side")
        mirrored.append(f"{MIRRORED}: read as a right-hand one, {why}. --no-mirror keeps it as it is.")
    if options.mirror is False:
        taken = taken.by(side="given")
    if taken.mirrored and taken.how["side"] == "from the flange":
        mirrored.append("The flange shows a left-hand wheel; it is mirrored to the right-hand side.")
    return taken, assumed, mirrored


def _of_smoothing(smoothing: Smoothing, options: ReadOptions, n_points: int) -> list[str]:
    """Return notices of strong noise, and of points that were held to the limit."""
    notices = list[str]()
    if options.smooth_mm is None and smoothing.wavelength_mm > USUAL_WAVELENGTH_MM:
        notices.append(
            f"The noise is {smoothing.noise_um:.0f} micrometres; waves shorter than "
            f"{smoothing.wavelength_mm:g} mm are smoothed away so that curvatures can be trusted."
        )
    if smoothing.n_held > _MAX_HELD * n_points:
        notices.append(
            f"{smoothing.n_held} of {n_points} points were held to the limit: the waves that they show are smoothed "
            "with a larger --smooth and --limit."
        )
    return notices


def _checked_against_shape(taken: Orientation, surface: Contour) -> tuple[Orientation, list[str]]:
    """Return the tape distance, from the shape if nothing else gives it, and notices of what contradicts the shape."""
    if taken.kind == "rail":
        return taken, [] if isinstance(surface, Outline) else side_notices(surface)
    reach = -float(surface.bounds()[0, 0])
    seen = round(reach, 4) if isinstance(surface, Outline) else seen_back_mm(surface)
    if taken.tape_mm is not None:
        if (seen is None and reach <= taken.tape_mm) or abs(reach - taken.tape_mm) <= BACK_OFF_MM:
            return taken, []
        return taken, [
            (
                f"The profile reaches {reach:.2f} mm from the tape line to the flange's back, the tape distance "
                f"({taken.how['tape line']}) is {taken.tape_mm:g} mm: the wheels' inner faces are taken at the "
                "latter; --tape gives another one."
            )
        ]
    if seen is not None:
        return replace(taken.by(**{"tape line": "from the flange's back"}), tape_mm=seen), []
    return replace(taken, tape_mm=TAPE_MM), [
        (
            f"The flange's back is not measured: it is taken {TAPE_MM:g} mm from the tape line; --tape gives "
            "another distance."
        )
    ]


def side_notices(head: Contour) -> list[str]:
    """Return a notice where a rail's head is worn more at the side that no flange reaches."""
    side = worn_side(head.sampled(spacing=_SPACING_MM, max_deviation=_DEVIATION_MM))
    if side is None or side.name == "gauge side":
        return []
    return [f"{FIELD_WORN}, by {side.more_mm:.2f} mm ({side.measure}): a left-hand rail? --mirror reverses it."]


def _placed(contour: Contour, taken: Orientation) -> Contour:
    """Return lines and arcs of a file in this package's axes, with the steel at the left."""
    turned = taken.mirrored == taken.upwards  # one reflection, not two or none

    def moved(segment: Segment) -> Segment:
        if isinstance(segment, Line):
            start, end = taken.applied(np.array([segment.start, segment.end]))
            return Line(as_point(start), as_point(end))
        start, end, centre = taken.applied(np.array([segment.start, segment.end, segment.centre]))
        return Arc(as_point(start), as_point(end), as_point(centre), segment.counter_clockwise != turned)

    segments = [moved(segment) for segment in contour.segments]
    if isinstance(contour, Outline):
        return Outline.from_segments(segments, contour.names)
    chain = Contour.from_segments(segments, contour.names)
    return chain.reversed() if taken.reversed_order else chain


def _text(content: bytes) -> str:
    """Return text in UTF-8, in UTF-16 as of spreadsheets, or in the code of Windows that older instruments write.

    It ends at a control-Z, as files of DOS do.
    """
    # each digit has a byte of zero in UTF-16, also in files that do not begin with the mark of its order
    zeros = {"utf-16-be": content[::2].count(0), "utf-16-le": content[1::2].count(0)}
    code = next((name for name, count in zeros.items() if count > len(content) // 4), "")
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        code = "utf-16"
    if code:
        content = content.decode(code, errors="replace").encode()
    content = content.partition(b"\x1a")[0]
    if any(byte in content for byte in _CONTROL):
        raise InputError("bytes that are no text", "a text file", "check the ending of the file's name")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def profile_text(
    profile: MeasuredProfile, ending: str, outline: Outline | None = None, outline_origin: str | None = None
) -> str:
    """Return a profile in the format of a file's ending; see `FORMATS`. CSV has lines and arcs, text two columns.

    An `InputError` if the ending is unknown, belongs to the other kind, or its format holds running surfaces but no
    whole outline.

    - `ending`: ending of the file's name.
    - `outline`, `outline_origin`: whole outline, and where its origin lies, to be written into CSV and DXF instead of
      the profile's surface.
    """
    if ending not in FORMATS:
        raise InputError(f"--to a file with the ending {ending!r}", ", ".join(FORMATS), "choose one of these formats")
    kind = _KINDS_BY_ENDING.get(ending, profile.kind)
    if kind != profile.kind:
        endings = ", ".join(e for e, k in _KINDS_BY_ENDING.items() if k == profile.kind)
        raise InputError(f"--to {ending}, which holds {kind}s, for a {profile.kind}", endings, "change the ending")
    title = one_line(profile.title)
    origin, tape = frame_origin(profile), profile.orientation.tape_mm
    if ending == ".csv":
        return write_segment_csv(outline or profile.surface, kind, title, outline_origin or origin, tape)
    if ending == ".dxf":
        return write_dxf_profile(outline or profile.surface)
    if isinstance(profile.surface, Outline):
        raise InputError(f"--to {ending} for a closed outline", ".csv or .dxf", "choose one of these")
    points = profile.best_points
    if kind == "rail" and origin == "base":
        # the other formats count from the top
        points = points - np.array([0.0, profile.surface.top])
    if ending in (".ban", ".whl"):
        return write_miniprof(points, kind, title, TAPE_MM if tape is None else tape)
    if ending in (".prr", ".prw"):
        return write_simpack(points, kind, title)
    return write_two_column(points, kind, title, tape)


def frame_origin(profile: MeasuredProfile) -> str:
    """Return where the origin of a profile lies now: ``"tape"`` for wheels, for rails where the file has it."""
    if profile.kind == "wheel":
        return "tape"
    known = profile.orientation.origin in ("top", "base", "gauge")
    return profile.orientation.origin if known else "top"
