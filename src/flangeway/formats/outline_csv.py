"""Sections from CSV: one row a line or an arc, or one row a corner.

Rows of segments have the columns ``name, type, x0, y0, x1, y1`` and, for arcs, ``xc, yc``; ``type`` is ``line`` or
``arc``. Arcs are shorter than half a turn unless a column ``turn`` says ``left`` or ``right``. Rows of corners have the
columns ``x, y``. Semicolons or tabs may separate cells, with decimal commas in them. Names of columns may carry the
unit: ``x0_mm``. Lines that start with ``#`` are comments, but ``# unit: mm`` and ``# mirror`` are read, without the
colon too. Loops follow each other; those inside others are holes.
"""

import itertools
import math
import re
from collections.abc import Mapping, Sequence

import numpy as np

from flangeway.errors import InputError
from flangeway.formats.drawn_section import (
    UNITS,
    DrawnSection,
    DrawnSegment,
    agreed_unit,
    drawn_polygon,
    reach_of,
    repaired_outline,
    section_of,
)
from flangeway.geometry.arrays import Point, cross_product, point_text
from flangeway.geometry.contour import JOINT_TOLERANCE
from flangeway.system.file_content import csv_cells, csv_separator

_COORDINATES = ("x0", "y0", "x1", "y1", "xc", "yc", "x", "y")
_HOW = "columns such as x0_mm, a line '# unit: mm', or the input unit"
_MIRROR_ADVICE = "close it; if it is one half, add a line '# mirror' or --mirror of `flangeway section`"


def csv_section(text: str, *, unit: str | None = None, mirrored: bool = False) -> DrawnSection:
    """Return the section of a CSV file's text, see the module for the columns; an `InputError` if it is wrong.

    The unit is needed if the file names none; a mirrored outline is one half, from x = 0 to x = 0.
    """
    comments = [line.strip()[1:].strip() for line in text.splitlines() if line.strip().startswith("#")]
    rows, in_header = parse_table(text)
    in_comment = [match[1] for line in comments if (match := re.fullmatch(r"units?\s*[:=]?\s*(\w+)", line.lower()))]
    agreed = agreed_unit(in_header or next(iter(in_comment), None), unit, _HOW)
    mirrored = mirrored or any(re.fullmatch(r"mirror(\s*[:=]?\s*(yes|true))?", line.lower()) for line in comments)
    if "x" in rows[0][1]:
        loops = [drawn_polygon([_point(row, "x", "y", number) for number, row in rows])]
    else:
        loops = _loops([parse_segment(row, number) for number, row in rows])
    found = []
    for number, loop in enumerate(loops, 1):
        what = "outline" if len(loops) == 1 else f"loop {number} of {len(loops)}"
        drawn = _with_mirror_image(loop, what) if mirrored else loop
        try:
            found.append(repaired_outline(drawn, what, direction_matters=not mirrored and number == 1))
        except InputError as reason:
            if "starts at" in reason.given and "from the end" in reason.given:
                raise InputError(reason.given, reason.allowed, _MIRROR_ADVICE) from reason
            raise
    return section_of(found, agreed)


def parse_table(text: str) -> tuple[list[tuple[int, dict[str, str]]], str | None]:
    """Return the cells of a table by column, without units, behind the numbers of their lines; and the columns' unit.

    An `InputError` if it has no rows, its columns are others than the module's, or a row has more cells than these.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.strip().startswith("#")
    ]
    header, unit = _header(lines)
    return _rows(header, lines), unit


def _header(lines: Sequence[tuple[int, str]]) -> tuple[list[str], str | None]:
    """Return the names of columns in the first of numbered lines, without units, and the unit that they carry."""
    number, line = lines[0] if lines else (1, "")
    names = csv_cells(line, number, csv_separator(line))
    units = {name.rpartition("_")[2] for name in names if name.rpartition("_")[0] in _COORDINATES}
    if len(units) > 1 or not units <= set(UNITS):
        raise InputError(
            f"columns in {' and '.join(sorted(units))}", f"one unit of {', '.join(UNITS)}", "rename the columns"
        )
    plain = [name.rpartition("_")[0] if name.rpartition("_")[0] in _COORDINATES else name for name in names]
    corners, segments = {"x", "y"} <= set(plain), {"type", "x0", "y0", "x1", "y1"} <= set(plain)
    if corners == segments:
        raise InputError(
            f"columns {', '.join(names) if any(names) else '(none)'}",
            "x, y for corners; or name, type, x0, y0, x1, y1, xc, yc for lines and arcs",
            "put these names in the first line that is no comment",
        )
    return plain, next(iter(units), None)


def _rows(header: Sequence[str], lines: Sequence[tuple[int, str]]) -> list[tuple[int, dict[str, str]]]:
    """Return the cells of lines after that of the header by column, with the number of each line."""
    rows, separator = [], csv_separator(lines[0][1])
    for number, line in lines[1:]:
        cells = csv_cells(line, number, separator)
        if len(cells) > len(header):
            raise InputError(f"line {number} with {len(cells)} cells", f"{len(header)} cells", "correct the line")
        rows.append((number, dict(itertools.zip_longest(header, cells, fillvalue=""))))
    if not rows:
        raise InputError("a header without rows", "one row a segment or corner", "check that the file is whole")
    return rows


def _point(row: Mapping[str, str], x: str, y: str, number: int) -> Point:
    def coordinate(key: str) -> float:
        text = row.get(key, "")
        try:
            return float(text)
        except ValueError:
            raise InputError(
                f"line {number}: {key} = {text!r}", "a number, with a decimal point", "correct this cell"
            ) from None

    return coordinate(x), coordinate(y)


def parse_segment(row: Mapping[str, str], number: int) -> DrawnSegment:
    """Return the line or arc of a row, whose line of the file is named in errors."""
    start, end = _point(row, "x0", "y0", number), _point(row, "x1", "y1", number)
    name = row.get("name") or "side"
    if row["type"] == "line":
        return DrawnSegment(start, end, name=name)
    if row["type"] != "arc":
        raise InputError(f"line {number}: type = {row['type']!r}", "line or arc", "correct this cell")
    centre = _point(row, "xc", "yc", number)
    turn = row.get("turn", "")
    if turn not in ("", "left", "right"):
        raise InputError(f"line {number}: turn = {turn!r}", "left or right, or nothing", "correct this cell")
    if not turn:
        cross = float(cross_product(np.subtract(start, centre), np.subtract(end, centre)))
        if abs(cross) <= 1e-9 * math.dist(start, centre) ** 2:
            raise InputError(
                f"line {number}: an arc of half a turn from {start} to {end}",
                "arcs shorter than half a turn, or a column 'turn' with left or right",
                "divide the arc, or say how it turns",
            )
        turn = "left" if cross > 0.0 else "right"
    return DrawnSegment(start, end, centre, turn == "left", name)


def _loops(segments: Sequence[DrawnSegment]) -> list[list[DrawnSegment]]:
    """Cut the rows where a loop has come back to its start."""
    size = reach_of(segments)
    loops: list[list[DrawnSegment]] = [[]]
    for segment in segments:
        loop = loops[-1]
        if len(loop) > 1 and math.dist(loop[0].start, loop[-1].end) <= JOINT_TOLERANCE * size:
            loops.append([])
        loops[-1].append(segment)
    return loops


def _with_mirror_image(drawn: Sequence[DrawnSegment], what: str) -> list[DrawnSegment]:
    """Add the mirror image about x = 0 to a chain from x = 0 to x = 0, or to a loop with a line on x = 0 as its cut."""
    size = reach_of(drawn)
    half = _without_cut(drawn, JOINT_TOLERANCE * size)
    for word, point in (("starts", half[0].start), ("ends", half[-1].end)):
        if not abs(point[0]) <= JOINT_TOLERANCE * size:
            raise InputError(
                f"{what}: a half outline that {word} at {point_text(point)}",
                "halves that start and end on the axis x = 0",
                "correct the end, or leave the mirror out for a whole outline",
            )

    def image(point: Point) -> Point:
        return (-point[0], point[1])

    back = [
        DrawnSegment(
            image(s.end), image(s.start), s.centre and image(s.centre), s.counter_clockwise, f"{s.name}_mirrored"
        )
        for s in reversed(half)
    ]
    return [*half, *back]


def _without_cut(loop: Sequence[DrawnSegment], slack: float) -> list[DrawnSegment]:
    """Chain of a closed half without its line on the axis; others as they are."""
    cuts = [
        number
        for number, segment in enumerate(loop)
        if segment.centre is None and max(abs(segment.start[0]), abs(segment.end[0])) <= slack
    ]
    if len(cuts) != 1 or math.dist(loop[0].start, loop[-1].end) > slack:
        return list(loop)
    return [*loop[cuts[0] + 1 :], *loop[: cuts[0]]]
