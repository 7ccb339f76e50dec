"""Profiles of MiniProf and Simpack, and of lines and arcs in CSV and DXF."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flangeway.errors import InputError
from flangeway.formats import drawn_section, dxf_files
from flangeway.formats.drawn_section import UNITS_MM, DrawnSegment, reach_of
from flangeway.geometry import Arc, Contour, FloatArray, Outline, Point, Segment
from flangeway.geometry.outline import JOINT_TOLERANCE
from flangeway.railway.profiles.formats.two_column import (
    KINDS,
    Kind,
    RawProfile,
    keys_and_rows,
    leading_numbers,
    number_of,
    one_line,
    points_in,
    read_two_column,
    text_of,
)
from flangeway.types import Ints

# --- MiniProf files: ``.ban`` for rails and ``.whl`` for wheels.
#
# The head of the file has lines ``Key=value``, of which ``ColumnDef`` names the columns, ``XYPoints`` counts the points
# and ``WheelDiameterTaperline`` places the tape line; an empty line and one point a line follow. Files of old versions
# have ``MINIPROF`` in one of their first three lines, words without keys, and points behind the first empty line.
# Everything after ``"``, ``!`` or ``%`` is a comment. Lengths are mm, unless the user gives another unit. The second
# column of rails points up and that of wheels towards the flange's tip, unless the shape shows the contrary, since
# programs differ; the first column of wheels counts from the flange's back.


TAPE_MM = 70.0  # usual distance of the tape line from the flange's back (EN 13715)

_N_FIRST_LINES = 3
_REFERENCE = "".join(
    f"RefPoint{i}={['0.0000, 0.0000', '10.0000, 0.0000', '0.0000, 5.0000'][(i - 1) % 3]}\n" for i in range(1, 10)
)


def read_miniprof(text: str, kind: Kind) -> RawProfile:
    """Return the profile in a MiniProf file.

    An `InputError` if it has several profiles, no columns X and Y, no points, or not as many points as its header.

    - `kind`: from the ending of its name.
    """
    lines = text.splitlines()
    if any(line.strip().startswith("[FileInfo]") for line in lines[:_N_FIRST_LINES]):
        raise InputError(
            "a MiniProf file of several profiles", "one profile a file", "save the profile that you want alone"
        )
    if any("MINIPROF" in line for line in lines[:_N_FIRST_LINES]):  # words without keys, up to the first empty line
        lines = [""] * lines.index("") + lines[lines.index("") :] if "" in lines else []
    header, rows = keys_and_rows((n, re.split(r'["!%]', line, maxsplit=1)[0]) for n, line in enumerate(lines, 1))
    line, columns = header.get("columndef", (0, ""))
    names = [name.strip().upper() for name in columns.split(",")] if columns else ["X", "Y"]
    if "X" not in names or "Y" not in names:
        raise InputError(f"line {line}: ColumnDef={columns}", "columns X and Y", "save the file with both")
    points, numbers = points_in(rows, names.index("X"), names.index("Y"))
    notices: list[str] = []
    if text_of(header, "xypoints"):
        line, text = header["xypoints"]
        wanted = number_of(text, "XYPoints", line)
        if len(points) < 0.9 * wanted:
            raise InputError(
                f"{len(points)} points in a file with XYPoints={wanted:g}",
                "as many points as XYPoints",
                "the file was cut off: save it again, or correct XYPoints",
            )
        if len(points) != wanted:
            notices.append(f"The header has XYPoints={wanted:g}, the file {len(points)} points; all of them are taken.")
    offsets = [text_of(header, key) for key in ("xoffset", "yoffset")]
    if any(offset and leading_numbers(offset) not in ([], [0.0]) for offset in offsets):
        notices.append(f"XOffset and YOffset ({', '.join(offsets)}) are not applied.")
    side = [f"{key}={text}" for key in ("Rail", "Side") if (text := text_of(header, key.lower()))]
    if side:
        notices.append(
            f"The header has {', '.join(side)}; the profile is used as it is, --mirror makes it the other side."
        )
    line, value = header.get("wheeldiametertaperline", (0, ""))
    tape = number_of(value, "WheelDiameterTaperline", line) if value and kind == "wheel" else None
    title = next(filter(None, (text_of(header, key) for key in ("mpdn", "comment", "filename", "uof1"))), "")
    return RawProfile(
        points,
        numbers,
        unit="mm",
        unit_is_sure=False,
        kind=kind,
        upwards=kind == "rail",
        tape_mm=tape,
        title=title,
        notices=tuple(notices),
    )


def write_miniprof(points: FloatArray, kind: Kind, title: str, back_mm: float = TAPE_MM) -> str:
    """Return points (n, 2) in mm as a MiniProf file.

    Rails: from the top, second column up. Wheels: from the flange's back, second column towards the flange's tip.

    - `points`: in this package's frame of a rail's running surface or a wheel.
    - `title`: goes into ``MPDN``.
    - `back_mm`: distance of the flange's back from the tape line of a wheel; goes into ``WheelDiameterTaperline``.
    """
    shown = points if kind == "rail" else points * [1.0, -1.0] + [back_mm, 0.0]
    tape = f"WheelDiameterTaperline={back_mm!r}\n" if kind == "wheel" else ""
    rows = "".join(f"{x:.9f} {y:.9f}\n" for x, y in shown)
    name = re.sub(r'["!%=]', " ", one_line(title))
    return (
        f"ProgramName=flangeway\nMPDN={name}\nMPTypeNo=299\nMPSerNo=0\nXoffset=0.0000\nYoffset=0.0000\n"
        f"{_REFERENCE}{tape}ColumnDef=X,Y\nXYPoints={len(points)}\nChars=UTF8\n\n{rows}"
    )


# --- Simpack profile files: ``.prr`` for rails and ``.prw`` for wheels.
#
# Sections ``header.begin`` to ``header.end`` and ``spline.begin`` to ``spline.end`` hold lines ``key = value``; the
# points stand between ``point.begin`` and ``point.end``: y to the right, z down, and a weight that is not used. ``!``
# and ``%`` start comments. The points are changed as the header says, in the order of Simpack: smallest distance,
# shift, rotation, bounds, mirrors, order, unit.


_MM_PER_M = 1000.0


def read_simpack(text: str, kind: Kind) -> RawProfile:
    """Return the profile in a Simpack file, processed as the file asks.

    An `InputError` if sections are missing, the type is another one than that of the ending, or a number is wrong.

    - `kind`: from the ending of its name.
    """
    content: list[tuple[int, str]] = []
    sections: list[str] = []
    for number, line in enumerate(text.splitlines(), 1):
        # a comment ends a line, not inside quotes
        words = (re.match(r"(?:[^!%']|'[^']*')*", line) or [""])[0].strip()
        section, _, edge = words.rpartition(".")
        if edge == "begin":
            sections.append(section)
        elif edge == "end":
            if sections[-1:] != [section]:
                raise InputError(f"line {number}: {section}.end without its beginning", "whole sections", "check it")
            sections.pop()
        else:  # both sections have a key `type`
            content.append((number, f"header.{words}" if sections[-1:] == ["header"] else words))
    if sections:
        raise InputError(f"a section {sections[-1]}.begin without its end", "whole sections", "the file was cut off")
    keys, rows = keys_and_rows(content)
    points, lines = points_in(rows)
    sure = _refuse_other_kind(keys, kind)
    points, lines, per_metre = _processed(points, lines, keys)
    return RawProfile(
        points,
        lines,
        unit=None if per_metre is None else "mm",
        kind=kind,
        kind_is_sure=sure,
        upwards=False,
        title=text_of(keys, "comment") or text_of(keys, "file"),
    )


def _refuse_other_kind(keys: dict[str, tuple[int, str]], kind: Kind) -> bool:
    """Return whether the header declares the kind of the ending; refuse the other one."""
    line, value = keys.get("header.type", (0, ""))
    stated = {"0": KINDS[0], "1": KINDS[1]}.get(value)
    if stated is not None and stated != kind:
        raise InputError(
            f"line {line}: type = {value}, a {stated}, in a file with the ending of a {kind}",
            "an ending that agrees: .prr for rails, .prw for wheels",
            "rename the file, or correct its header",
        )
    return stated is not None


def _processed(
    points: FloatArray, lines: Ints, keys: dict[str, tuple[int, str]]
) -> tuple[FloatArray, Ints, float | None]:
    """Apply the header; return points, their lines, and the number of the file's units in a metre."""

    def value(key: str) -> float:
        line, text = keys.get(key, (0, ""))
        return number_of(text, key, line) if text else 0.0

    if value("point.dist.min") > 0.0:
        kept = [0]
        for i in range(1, len(points)):
            if abs(points[i, 0] - points[kept[-1], 0]) > value("point.dist.min"):
                kept.append(i)
        points, lines = points[kept], lines[kept]
    points = points + np.array([value("shift.y"), value("shift.z")])
    angle = value("rotate") / (value("units.ang.f") or 1.0)
    if angle:
        cosine, sine = math.cos(angle), math.sin(angle)
        points = points @ np.array([[cosine, sine], [-sine, cosine]])
    low, high = value("bound.y.min"), value("bound.y.max")
    if low < high:
        inside = (points[:, 0] >= low) & (points[:, 0] <= high)
        points, lines = points[inside], lines[inside]
    low, high = value("bound.z.min"), value("bound.z.max")
    if low < high:
        points = np.column_stack([points[:, 0], np.clip(points[:, 1], low, high)])
    points = points * [-1.0 if value("mirror.y") else 1.0, -1.0 if value("mirror.z") else 1.0]
    if value("inversion"):
        points, lines = points[::-1], lines[::-1]
    per_metre = value("units.len.f") or None
    if per_metre is not None:
        if per_metre < 0.0:
            raise InputError(f"units.len.f = {per_metre:g}", "the number of the file's units in a metre", "1000 for mm")
        points = points * (_MM_PER_M / per_metre)
    return np.ascontiguousarray(points), np.ascontiguousarray(lines), per_metre


def write_simpack(points: FloatArray, kind: Kind, title: str) -> str:
    """Return points (n, 2) in mm, in this package's frame of a rail's running surface or a wheel, as a Simpack file.

    z is written downwards, rails from the middle of the track outwards and wheels the other way, as Simpack wants.
    """
    shown = points * [1.0, -1.0]
    outwards = shown[-1, 0] >= shown[0, 0]
    if outwards == (kind == "wheel"):
        shown = shown[::-1]
    comment = re.sub(r"['!%]", " ", one_line(title))
    rows = "".join(f"      {y:.9f} {z:.9f}\n" for y, z in shown)
    return (
        "header.begin\n"
        "  version = 1\n"
        f"  type = {KINDS.index(kind)} ! 0 = rail, 1 = wheel\n"
        "header.end\n"
        "spline.begin\n"
        "  approx.smooth = 0.0\n"
        f"  comment = '{comment}'\n"
        "  mirror.y = 0\n  mirror.z = 0\n  inversion = 0\n"
        "  units.len.f = 1000.0 ! units in a metre: mm\n"
        "  units.ang.f = 1.0\n"
        f"  point.begin\n{rows}  point.end\n"
        "spline.end\n"
    )


# --- Profiles of lines and arcs, open or closed: CSV with the columns of outlines, and DXF drawings.


_N_SAMPLES = 800
GAP_MM = 0.01  # maximum gap between the lines and arcs of a profile that is closed, with a notice: tables are rounded
_ROUNDING = 1e-3  # of that, below which nothing is stated
_MAX_COORDINATE = 1e9  # centres of flat arcs lie far away


def is_segment_csv(text: str) -> bool:
    """Whether the first line of a CSV file that is no comment names the columns of lines and arcs."""
    for line in text.splitlines():
        if line.strip() and not line.strip().startswith("#"):
            return bool(re.search(r"\btype\b", line)) and bool(re.search(r"\bx0", line))
    return False


def read_segment_csv(text: str) -> RawProfile:
    """Return the chain of lines and arcs in a CSV file; for its columns see `flangeway.formats.drawn_section`.

    The comments of `flangeway.railway.profiles.formats.two_column` are read as well. An `InputError` if a column or
    number is missing or wrong, or the segments are no chain.
    """
    lines = text.splitlines()
    comments = [line if line.strip().startswith("#") else "#" for line in lines]
    # comments are checked there; the point is a placeholder
    stated = read_two_column("\n".join([*comments, "0 0"]))
    rows, unit = drawn_section.parse_table(text)
    drawn = [drawn_section.parse_segment(row, number) for number, row in rows]
    if unit is not None and stated.unit is not None and unit != stated.unit:
        raise InputError(f"columns in {unit} under a comment with {stated.unit}", "one unit", "correct one of them")
    return _profile(drawn, unit or stated.unit, stated)


def read_dxf_profile(content: bytes) -> RawProfile:
    """Return the one chain of lines and arcs in the model space of a DXF drawing, open or closed.

    An `InputError` if it is no DXF drawing, holds other curves, or its lines and arcs are not one chain.
    """
    drawing = dxf_files.read_drawing(content)
    pieces = drawing.loops + drawing.chains
    if not pieces:
        raise InputError("a drawing without lines or arcs in its model space", "a profile", "draw it in model space")
    empty = RawProfile(np.zeros((1, 2)), np.zeros(1, dtype=np.int64), notices=tuple(drawing.notices))
    joined = dxf_files.joined_chains(pieces, closed=False)
    if len(joined) > 1:
        raise InputError(
            f"{len(joined)} chains of lines and arcs apart", "one chain", "leave the profile alone in the drawing"
        )
    return _profile(joined[0], drawing.unit, empty)


def _profile(drawn: Sequence[DrawnSegment], unit: str | None, stated: RawProfile) -> RawProfile:
    numbers = [c for s in drawn for p in (s.start, s.end, s.centre) if p is not None for c in p]
    if not all(abs(number) <= _MAX_COORDINATE for number in numbers):
        raise InputError("a coordinate that is not finite or very large", f"up to {_MAX_COORDINATE:g}", "repair it")
    drawn, notices = closed_gaps(drawn, GAP_MM / UNITS_MM.get(unit or "mm", 1.0))
    segments = [segment.checked() for segment in drawn]
    names = [segment.name for segment in drawn]
    size = reach_of(drawn)
    closed = len(segments) > 1 and math.dist(segments[0].start, segments[-1].end) <= JOINT_TOLERANCE * size
    contour = Outline.from_segments(segments, names) if closed else Contour.from_segments(segments, names)
    points = contour.sampled(spacing=contour.length / _N_SAMPLES)
    if closed:
        # the highest and the lowest place are then inside the list, as the search for head and flange wants
        top, bottom = int(np.argmax(points[:, 1])), int(np.argmin(points[:, 1]))
        points = np.roll(points, -((top + bottom) // 2), axis=0)
    lines, all_notices = np.zeros(len(points), dtype=np.int64), (*stated.notices, *notices)
    return replace(stated, points=points, lines=lines, unit=unit, contour=contour, notices=all_notices)


def closed_gaps(drawn: Sequence[DrawnSegment], maximum: float) -> tuple[list[DrawnSegment], tuple[str, ...]]:
    """Close gaps up to `maximum` between neighbours, as of rounded tables, and report where.

    Both ends move to the middle of the gap, and centres across the chord to where they are equally far from both ends.
    """
    ends = [[s.start, s.end] for s in drawn]
    gaps: list[tuple[float, int]] = []
    for i in range(len(drawn) if len(drawn) > 1 else 0):
        j = (i + 1) % len(drawn)
        (x0, y0), (x1, y1) = drawn[i].end, drawn[j].start
        gap = math.hypot(x1 - x0, y1 - y0)
        if gap <= maximum:
            ends[i][1] = ends[j][0] = (0.5 * (x0 + x1), 0.5 * (y0 + y1))
            gaps.append((gap, i))
        elif j:
            raise InputError(
                f"segment {j} starts at {drawn[j].start}, {gap:.6g} from the end {drawn[i].end} of segment {i}",
                f"a chain with gaps up to {maximum:.3g}, which are closed",
                "close the gap or reorder the segments",
            )
    closed = [_moved(segment, start, end, maximum) for segment, (start, end) in zip(drawn, ends, strict=True)]
    stated = [gap_at for gap_at in gaps if gap_at[0] > _ROUNDING * maximum]
    if not stated:
        return closed, ()
    gap, i = max(stated)
    return closed, (
        f"{len(stated)} gaps between lines and arcs are closed, up to {maximum:.3g}, the widest of {gap:.3g} behind "
        f"segment {i}, {drawn[i].name}.",
    )


def _moved(segment: DrawnSegment, start: Point, end: Point, maximum: float) -> DrawnSegment:
    """Return a segment with other ends; a centre whose distances from them differ by rounding is moved as well."""
    moved = replace(segment, start=start, end=end)
    length = math.dist(start, end)
    if segment.centre is None or not length:
        return moved
    ray = (segment.centre[0] - start[0], segment.centre[1] - start[1])
    along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)
    off = ray[0] * along[0] + ray[1] * along[1] - 0.5 * length
    if abs(math.hypot(*ray) - math.dist(segment.centre, end)) > 2.0 * maximum:
        return segment  # which is refused
    return replace(moved, centre=(segment.centre[0] - off * along[0], segment.centre[1] - off * along[1]))


def write_segment_csv(contour: Contour, kind: str, title: str, origin: str, tape_mm: float | None = None) -> str:
    """Return a chain in mm as CSV of lines and arcs, with comments on kind and frame."""
    rows = [
        f"# title: {title}",
        f"# kind: {kind}",
        f"# origin: {origin}",
        "# up: yes",
        *([] if tape_mm is None else [f"# tape_mm: {tape_mm!r}"]),
        "name,type,x0_mm,y0_mm,x1_mm,y1_mm,xc_mm,yc_mm,turn",
    ]
    for name, segment in zip(contour.names, contour.segments, strict=True):
        ends = ",".join(repr(c) for c in (*segment.start, *segment.end))
        label = re.sub(r'[,"\s]', "_", name)
        if isinstance(segment, Arc):
            turn = "left" if segment.counter_clockwise else "right"
            rows.append(f"{label},arc,{ends},{segment.centre[0]!r},{segment.centre[1]!r},{turn}")
        else:
            rows.append(f"{label},line,{ends},,,")
    return "\n".join(rows) + "\n"


def write_dxf_profile(contour: Contour) -> str:
    """Return a chain in mm as a DXF drawing with one polyline, its arcs as bulges."""
    import io  # noqa: PLC0415

    import ezdxf.document  # noqa: PLC0415  (slow to import, and few programs write drawings)

    drawing: Any = ezdxf.document.Drawing.new("R2010")
    drawing.header["$INSUNITS"] = dxf_files.MILLIMETRES
    rows = [(*segment.start, _bulge(segment)) for segment in contour.segments]
    closed = isinstance(contour, Outline)
    if not closed:
        rows.append((*contour.ends[1], 0.0))
    drawing.modelspace().add_lwpolyline(rows, format="xyb", close=closed)
    stream = io.StringIO()
    drawing.write(stream)
    return stream.getvalue()


def _bulge(segment: Segment) -> float:
    return math.tan(0.25 * segment.sweep) if isinstance(segment, Arc) else 0.0
