"""Profiles of lines and arcs, open or closed: CSV with the columns of outlines, and DXF drawings."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flangeway.errors import InputError
from flangeway.formats import outline_csv, outline_dxf
from flangeway.formats.drawn_section import UNITS_MM, DrawnSegment, reach_of
from flangeway.geometry import Arc, Contour, Outline, Point, Segment
from flangeway.geometry.contour import JOINT_TOLERANCE
from flangeway.railway.profiles.formats.raw_profile import RawProfile
from flangeway.railway.profiles.formats.two_column import read_two_column

_N_SAMPLES = 800
GAP_MM = 0.01  # maximum gap between the lines and arcs of a profile that is closed, with a notice: tables are rounded
_ROUNDING = 1e-3  # of that, below which nothing is stated
_MAX_COORDINATE = 1e9  # centres of flat arcs lie far away
_DXF_UNITS = {"mm": 4, "cm": 5, "m": 6, "in": 1, "ft": 2}


def is_segment_csv(text: str) -> bool:
    """Whether the first line of a CSV file that is no comment names the columns of lines and arcs."""
    for line in text.splitlines():
        if line.strip() and not line.strip().startswith("#"):
            return bool(re.search(r"\btype\b", line)) and bool(re.search(r"\bx0", line))
    return False


def read_segment_csv(text: str) -> RawProfile:
    """Return the chain of lines and arcs in a CSV file; for its columns see `flangeway.formats.outline_csv`.

    The comments of `flangeway.railway.profiles.formats.two_column` are read as well. An `InputError` if a column or
    number is missing or wrong, or the segments are no chain.
    """
    lines = text.splitlines()
    comments = [line if line.strip().startswith("#") else "#" for line in lines]
    # comments are checked there; the point is a placeholder
    stated = read_two_column("\n".join([*comments, "0 0"]))
    rows, unit = outline_csv.parse_table(text)
    drawn = [outline_csv.parse_segment(row, number) for number, row in rows]
    if unit is not None and stated.unit is not None and unit != stated.unit:
        raise InputError(f"columns in {unit} under a comment with {stated.unit}", "one unit", "correct one of them")
    return _profile(drawn, unit or stated.unit, stated)


def read_dxf_profile(content: bytes) -> RawProfile:
    """Return the one chain of lines and arcs in the model space of a DXF drawing, open or closed.

    An `InputError` if it is no DXF drawing, holds other curves, or its lines and arcs are not one chain.
    """
    drawing = outline_dxf.open_drawing(content)
    with outline_dxf.damage_reported():
        loops, chains, ignored = outline_dxf.pieces_of(drawing)
    if not loops + chains:
        raise InputError("a drawing without lines or arcs in its model space", "a profile", "draw it in model space")
    notices = tuple(f"Left out: {count} {kind}." for kind, count in sorted(ignored.items()))
    empty = RawProfile(np.zeros((1, 2)), np.zeros(1, dtype=np.int64), notices=notices)
    joined = outline_dxf.joined_chains(loops + chains, closed=False)
    if len(joined) > 1:
        raise InputError(
            f"{len(joined)} chains of lines and arcs apart", "one chain", "leave the profile alone in the drawing"
        )
    return _profile(joined[0], outline_dxf.unit_of(drawing), empty)


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
    drawing.header["$INSUNITS"] = _DXF_UNITS["mm"]
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
