"""A section as a file or a catalogue gives it, closed outlines from what it draws, and sections from CSV."""

import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from flangeway.checks import parsed_number
from flangeway.errors import InputError, located, short
from flangeway.geometry.arrays import Point, circle_centres, cross_product, norms, point_text, sides_of
from flangeway.geometry.outline import JOINT_TOLERANCE, Outline, _joined
from flangeway.geometry.region import Section, nested_regions
from flangeway.geometry.segments import Segment, segment_of
from flangeway.records import PoissonRatio, Positive, Record
from flangeway.system.file_content import csv_cells, csv_separator

# --- A section as a file or a catalogue gives it, and closed outlines from what it draws: small faults are repaired.


UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
UNITS = tuple(UNITS_MM)
"""UNITS_MM, UNITS: units of length that drawings and profiles may have, and their lengths in mm."""


class PartMaterial(Record):
    """Elastic material of a part."""

    young_MPa: Positive  # noqa: N815 (the unit megapascal)
    """Young's modulus"""
    poisson: PoissonRatio
    """Poisson's ratio"""

    @property
    def shear_modulus_MPa(self) -> float:  # noqa: N802 (the unit megapascal)
        """``G = E / (2 (1 + nu))``."""
        return self.young_MPa / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True)
class DrawnSection:
    """What was read.

    An `InputError` if the unit is unknown, or some parts have a material and others none.

    - `unit`: unit of length of all coordinates, one of `UNITS`.
    - `materials`: material of each part; empty for a section of one material.
    - `notices`: what was repaired or left out, in sentences.
    - `certainty`: how accurate the outline is, if its source says so.
    """

    title: str
    section: Section
    unit: str
    materials: Mapping[str, PartMaterial] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    certainty: str = ""

    def __post_init__(self) -> None:
        """Check unit and materials; keep a copy that cannot be changed."""
        refuse_unit(self.unit)
        missing = sorted(set(self.section.parts) - set(self.materials))
        if self.materials and missing:
            raise InputError(
                f"no material for {', '.join(missing)}",
                "young_MPa and poisson for every part, or for none",
                "add both for each part",
            )
        object.__setattr__(self, "materials", MappingProxyType(dict(self.materials)))


def refuse_unit(unit: str) -> None:
    """Raise `InputError` for an unknown unit of length."""
    if unit not in UNITS:
        raise InputError(f"unit of length {unit!r}", f"one of {', '.join(UNITS)}", "name the unit of the coordinates")


def agreed_unit(in_file: str | None, given: str | None, how: str) -> str:
    """Return the unit of a file, or the one given for a file that names none, which it can do as `how` says.

    An `InputError` if both differ, or there is neither.
    """
    if given is not None:
        refuse_unit(given)
    if in_file is not None and given is not None and in_file != given:
        raise InputError(
            f"unit {given} for a file in {in_file}",
            "the file's own unit",
            "leave the unit out; coordinates are never converted",
        )
    unit = in_file or given
    if unit is None:
        raise InputError(
            "coordinates without a unit of length",
            how,
            'add the unit to the file; or give unit = "mm" in the case, --unit mm to `flangeway section`',
        )
    refuse_unit(unit)
    return unit


MAX_COORDINATE = 1e30  # so that the sixth power of a length, and products of such, stay within floating-point numbers


@dataclass(frozen=True)
class DrawnSegment:
    """Line, or arc if it has a centre, as a file gives it: not checked yet."""

    start: Point
    end: Point
    centre: Point | None = None
    counter_clockwise: bool = True
    name: str = "side"

    def checked(self) -> Segment:
        """Return the segment; see `Line` and `Arc` for what is refused."""
        return segment_of(self.start, self.end, self.centre, self.counter_clockwise)


def drawn_polygon(points: Sequence[Point]) -> list[DrawnSegment]:
    """Return the sides ``side_1`` and so on, from each point to the next and from the last to the first."""
    return [DrawnSegment(a, b, name=f"side_{number}") for number, (a, b) in enumerate(sides_of(points), 1)]


def drawn_circle(centre: Point, radius: float, name: str = "circle") -> list[DrawnSegment]:
    """Return a circle of four arcs, counter-clockwise."""
    x, y = centre
    ends = [(x + radius, y), (x, y + radius), (x - radius, y), (x, y - radius)]
    return [DrawnSegment(a, b, centre, counter_clockwise=True, name=name) for a, b in sides_of(ends)]


def through_arc(start: Point, middle: Point, end: Point, name: str, what: str) -> DrawnSegment:
    """Return the arc from `start` through `middle` to `end`; points on one line are an `InputError`."""
    a, b = np.subtract(middle, start), np.subtract(end, start)
    cross = float(cross_product(a, b))
    if not abs(cross) > 1e-9 * float(norms(a) * norms(b)):
        raise InputError(
            f"{what}: an arc through three points on one line, {short(start)}, {short(middle)}, {short(end)}",
            "a point that is off the line from start to end",
            "use line_to, or move the point",
        )
    x, y = (start + circle_centres(a, b)).tolist()
    return DrawnSegment(start, end, (x, y), cross > 0.0, name)


def reach_of(drawn: Iterable[DrawnSegment]) -> float:
    """Return the largest coordinate, in size, of the ends of segments."""
    return max(abs(coordinate) for segment in drawn for coordinate in (*segment.start, *segment.end))


def repaired_outline(
    drawn: Sequence[DrawnSegment], what: str, *, direction_matters: bool = True
) -> tuple[Outline, tuple[str, ...]]:
    """Return a counter-clockwise outline of segments in order, and a notice of each thing that was repaired.

    Repaired are points given twice (lines shorter than `JOINT_TOLERANCE` of the whole) and a clockwise direction, with
    a notice if it matters. An `InputError` if a number is not finite, the loop is open, meets itself or has no area; it
    calls the loop `what` and names the position.
    """
    if not drawn:
        raise InputError(f"{what}: no segment", "two segments or more", "draw the loop")
    _refuse_not_finite(drawn, what)
    kept, notices = _without_duplicates(drawn, what)
    _refuse_flat(kept or drawn, what)
    with located(f"{what}: "):
        segments = tuple(segment.checked() for segment in kept)
        names = [segment.name for segment in kept]
        outline = Outline.from_segments(segments, names)
    if direction_matters and Outline._trusted(_joined(segments, closed=True), tuple(names))._signed_area < 0.0:
        notices.append(f"{what}: drawn clockwise; its direction is reversed.")
    return outline, tuple(notices)


def _refuse_not_finite(drawn: Sequence[DrawnSegment], what: str) -> None:
    for number, segment in enumerate(drawn):
        for kind, point in (("start", segment.start), ("end", segment.end), ("centre", segment.centre)):
            if point is not None and not all(abs(coordinate) <= MAX_COORDINATE for coordinate in point):
                raise InputError(
                    f"{what}: {kind} of segment {number} ({segment.name}) is ({point[0]}, {point[1]})",
                    f"finite coordinates up to {MAX_COORDINATE:g}",
                    "repair or remove this point",
                )


def _without_duplicates(drawn: Sequence[DrawnSegment], what: str) -> tuple[list[DrawnSegment], list[str]]:
    """Leave out lines without length, and say where they were."""
    ends = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    tolerance = JOINT_TOLERANCE * float(norms(np.ptp(ends, axis=0)))
    kept, notices = [], []
    for segment in drawn:
        if segment.centre is None and math.dist(segment.start, segment.end) <= tolerance:
            notices.append(f"{what}: the point {point_text(segment.start)} is given twice; one of both is left out.")
        else:
            kept.append(segment)
    return kept, notices


def _refuse_flat(drawn: Sequence[DrawnSegment], what: str) -> None:
    """Refuse points on one line: they would be found as sides that overlap, which explains less."""
    points = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    local = points - points[0]
    spread = np.linalg.svd(local, compute_uv=False)
    if any(segment.centre is not None for segment in drawn) or spread[-1] > 1e-12 * max(spread[0], 1e-300):
        return
    raise InputError(
        f"{what}: no area, since all of its points lie on one line through {point_text(points[0])}",
        "a loop that encloses an area",
        "check the points",
    )


def section_of(
    outlines: Sequence[tuple[Outline, tuple[str, ...]]], unit: str, notices: Sequence[str] = ()
) -> DrawnSection:
    """Return the section of outlines with their notices: loops inside others are holes, or parts inside of these."""
    regions = nested_regions([outline for outline, _ in outlines])
    names = ["section"] if len(regions) == 1 else [f"part_{i}" for i in range(1, len(regions) + 1)]
    every = (*notices, *(notice for _, repaired in outlines for notice in repaired))
    return DrawnSection("", Section(dict(zip(names, regions, strict=True))), unit, notices=every)


# --- Sections from CSV: one row a line or an arc, or one row a corner.
#
# Rows of segments have the columns ``name, type, x0, y0, x1, y1`` and, for arcs, ``xc, yc``; ``type`` is ``line`` or
# ``arc``. Arcs are shorter than half a turn unless a column ``turn`` says ``left`` or ``right``. Rows of corners have
# the columns ``x, y``. Semicolons or tabs may separate cells, with decimal commas in them. Names of columns may carry
# the unit: ``x0_mm``. Lines that start with ``#`` are comments, but ``# unit: mm`` and ``# mirror`` are read, without
# the colon too. Loops follow each other; those inside others are holes.


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
    outlines = []
    for number, loop in enumerate(loops, 1):
        what = "outline" if len(loops) == 1 else f"loop {number} of {len(loops)}"
        drawn = _with_mirror_image(loop, what) if mirrored else loop
        try:
            outlines.append(repaired_outline(drawn, what, direction_matters=not mirrored and number == 1))
        except InputError as reason:
            if "starts at" in reason.given and "from the end" in reason.given:
                raise InputError(reason.given, reason.allowed, _MIRROR_ADVICE) from reason
            raise
    return section_of(outlines, agreed)


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
            return parsed_number(text)
        except ValueError:
            raise InputError(
                f"line {number}: {key} = {short(text)}", "a number, with a decimal point", "correct this cell"
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
