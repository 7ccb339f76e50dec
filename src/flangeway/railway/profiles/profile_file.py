"""Profiles from files of all formats, in this package's frames, and back into files."""

import codecs
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_kind
from flangeway.errors import InputError, located
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.geometry import Arc, Contour, FloatArray, Line, Outline, Segment, as_point
from flangeway.railway.profiles.formats.miniprof import TAPE_MM, read_miniprof, write_miniprof
from flangeway.railway.profiles.formats.raw_profile import Kind, RawProfile
from flangeway.railway.profiles.formats.segment_files import (
    is_segment_csv,
    read_dxf_profile,
    read_segment_csv,
    write_dxf_profile,
    write_segment_csv,
)
from flangeway.railway.profiles.formats.simpack import read_simpack, write_simpack
from flangeway.railway.profiles.formats.slice_files import SLICES, UNITS, read_slices
from flangeway.railway.profiles.formats.two_column import one_line, read_two_column, write_two_column
from flangeway.railway.profiles.measures import left_hand, seen_back_mm, worn_side
from flangeway.railway.profiles.orientation import Orientation, ReadOptions, agreed_unit, orientation
from flangeway.railway.profiles.profile_checks import checked_points, refuse_length
from flangeway.railway.profiles.smoothing import USUAL_WAVELENGTH_MM, Smoothing, smoothed
from flangeway.system.file_content import file_content, path_of
from flangeway.types import floats
from flangeway.units import sentence, with_unit

FORMATS = {
    ".ban": "MiniProf",
    ".whl": "MiniProf",
    ".prr": "Simpack",
    ".prw": "Simpack",
    ".dxf": "DXF",
    ".csv": "CSV",
    ".txt": "two columns",
    ".dat": "two columns",
}
"""Formats by the ending of the file's name."""

READABLE = (*FORMATS, *SLICES)  # endings of files that are read

_KINDS_BY_ENDING: dict[str, Kind] = {".ban": "rail", ".whl": "wheel", ".prr": "rail", ".prw": "wheel"}
_CONTROL = bytes(set(range(32)) - {9, 10, 12, 13, 26})
_SPACING_MM = 0.25
_MANY_HELD = 0.05
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
            stem = f"{file.stem} at " + with_unit(position, UNITS[slices.kind])
            read, options = partial(_slice, unit=given.unit), replace(given, unit=None)
            profile = _profile(slices.section(position, read), "slices", options, stem, slices.slice(0, read))
            return replace(profile, file=file.name)
        if given.position is not None:
            raise InputError(f"--position {given.position:g}", f"a file of slices, {', '.join(SLICES)}", "leave it out")
        return replace(_profile(_read(content, ending), FORMATS[ending], given, file.stem), file=file.name)


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
    if ending in (".ban", ".whl"):
        return read_miniprof(text, _KINDS_BY_ENDING[ending])
    if ending in (".prr", ".prw"):
        return read_simpack(text, _KINDS_BY_ENDING[ending])
    if ending == ".csv" and is_segment_csv(text):
        return read_segment_csv(text)
    return read_two_column(text)


def _profile(
    raw: RawProfile, format_: str, options: ReadOptions, stem: str, first: RawProfile | None = None
) -> MeasuredProfile:
    """Return the profile; of slices all are placed as the first one."""
    unit = agreed_unit(raw, options.unit)
    more: list[str] = []
    scale = UNITS_MM[unit]
    sure = (raw.unit is not None and raw.unit_is_sure) or options.unit is not None
    if raw.contour is not None:
        refuse_length(raw.points * scale, sure)
    else:
        points, lines, more = checked_points(raw.points * scale, raw.lines, unit_is_sure=sure)
        raw = replace(raw, points=points / scale, lines=lines)
    taken, notices = orientation(first or raw, options)
    # crossings, and what was drawn, may be unlike on both sides
    if taken.kind == "rail" and options.mirror is None and not raw.mirrored and first is None and raw.contour is None:
        why = left_hand(taken.applied(raw.points))
        if why is not None:
            taken, notices = orientation(raw, replace(options, mirror=True))
            taken = replace(taken, how={**taken.how, "side": "from the worn side"})
            more.append(sentence("{}: read as a right-hand one, {}. --no-mirror keeps it as it is.", MIRRORED, why))
    if options.mirror is False:
        taken = replace(taken, how={**taken.how, "side": "given"})
    if taken.mirrored and taken.how["side"] == "from the flange":
        more.append("The flange shows a left-hand wheel; it is mirrored to the right-hand side.")
    title = (one_line(raw.title) or stem) if first is None else stem
    points = taken.applied(raw.points)
    if raw.contour is not None:
        surface = _placed(raw.contour, taken)
        points = surface.sampled(spacing=_SPACING_MM, max_deviation=_DEVIATION_MM)
        format_ = format_ if format_ == "DXF" else "CSV of lines and arcs"
        taken, seen = _checked_against_shape(taken, surface)
        return MeasuredProfile(title, format_, taken, points, surface, None, tuple(notices + more + seen))
    if taken.reversed_order:
        points = points[::-1]
    points = np.ascontiguousarray(points)
    smoothing = smoothed(points, options.smooth_mm, options.limit_um, name="measured")
    if options.smooth_mm is None and smoothing.wavelength_mm > USUAL_WAVELENGTH_MM:
        more.append(
            sentence(
                "The noise is {:.0f} micrometres; waves shorter than {:g mm} are "
                "smoothed away so that curvatures can be trusted.",
                smoothing.noise_um,
                smoothing.wavelength_mm,
            )
        )
    if smoothing.n_held > _MANY_HELD * len(points):
        more.append(
            f"{smoothing.n_held} of {len(points)} points were held to the limit: the waves that they show are smoothed "
            "with a larger --smooth and --limit."
        )
    taken, seen = _checked_against_shape(taken, smoothing.curve)
    placing = None
    if first is not None and taken.kind == "rail":
        ordered = taken.applied(first.points)[:: -1 if taken.reversed_order else 1]
        placing = smoothed(np.ascontiguousarray(ordered), options.smooth_mm, options.limit_um, name="measured").curve
    every = tuple(notices + more + seen)
    return MeasuredProfile(title, format_, taken, points, smoothing.curve, smoothing, every, placing)


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
            sentence(
                "The profile reaches {:.2f mm} from the tape line to the flange's back, the tape distance "
                "({}) is {:g mm}: the wheels' inner faces are taken at the latter; "
                "--tape gives another one.",
                reach,
                taken.how["tape line"],
                taken.tape_mm,
            )
        ]
    if seen is not None:
        return replace(taken, tape_mm=seen, how={**taken.how, "tape line": "from the flange's back"}), []
    return replace(taken, tape_mm=TAPE_MM), [
        sentence(
            "The flange's back is not measured: it is taken {:g mm} from the tape line; --tape gives another distance.",
            TAPE_MM,
        )
    ]


def side_notices(head: Contour) -> list[str]:
    """Return a notice where a rail's head is worn more at the side that no flange reaches."""
    side = worn_side(head.sampled(spacing=_SPACING_MM, max_deviation=_DEVIATION_MM))
    if side is None or side.name == "gauge side":
        return []
    return [
        sentence(
            "{}, by {:.2f mm} ({}): a left-hand rail? --mirror reverses it.",
            FIELD_WORN,
            side.more_mm,
            side.measure,
        )
    ]


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
    """Return text in UTF-8, in UTF-16 as of spreadsheets, or in the code of Windows that older instruments write."""
    # each digit has a byte of zero in UTF-16, also in files that do not begin with the mark of its order
    zeros = {"utf-16-be": content[::2].count(0), "utf-16-le": content[1::2].count(0)}
    code = next((name for name, count in zeros.items() if count > len(content) // 4), "")
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        code = "utf-16"
    if code:
        content = content.decode(code, errors="replace").encode()
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
