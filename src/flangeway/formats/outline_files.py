"""Sections from files: TOML, CSV of lines and arcs, DXF."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import annotated_types as at
from pydantic import Field, Strict, create_model

from flangeway.errors import InputError, located
from flangeway.formats.drawn_section import (
    DrawnSection,
    DrawnSegment,
    PartMaterial,
    agreed_unit,
    csv_section,
    drawn_circle,
    repaired_outline,
    through_arc,
)
from flangeway.formats.dxf_files import dxf_section
from flangeway.geometry.arrays import Point, point_text
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region, Section
from flangeway.geometry.shapes import rounded_sides
from flangeway.records import Pair, PoissonRatio, Positive, Record
from flangeway.system.file_content import file_content, toml_data, utf8_text

# --- Sections from TOML, the format to write by hand; `docs/tutorials/section.md` explains it with an example.


_HOW_IN_TOML = 'a line such as unit = "mm" at the top of the file'

Corner = Pair | Annotated[tuple[float, float, float], Strict(False)]
"""x, y, and a radius that rounds it."""


# the files' word is a keyword of Python, which no field of a class can have as a name
_From: type[Record] = create_model("_From", __base__=Record, **{"from": (Pair, Field(description="first point"))})  # type: ignore[call-overload]


class PathStart(_From):  # type: ignore[misc, valid-type]
    """Where a path begins."""

    @property
    def point(self) -> Point:
        """First point."""
        point: Point = getattr(self, "from")
        return point


class PathStep(Record):
    """A line or an arc of a path, from the end of the one before."""

    name: str | None = None
    """name of the side (default: step_1 and so on)"""


class LineStep(PathStep):
    """A line."""

    line_to: Pair
    """its end"""

    def segment(self, start: Point, name: str, _: str) -> DrawnSegment:
        """Return it from a point, called by a name, and by a place in messages."""
        return DrawnSegment(start, self.line_to, name=name)


class ArcThrough(PathStep):
    """An arc through a point."""

    arc_to: Pair
    """its end"""
    through: Pair
    """a point of it"""

    def segment(self, start: Point, name: str, here: str) -> DrawnSegment:
        """See `LineStep.segment`."""
        return through_arc(start, self.through, self.arc_to, name, here)


class ArcAbout(PathStep):
    """An arc about a centre."""

    arc_to: Pair
    """its end"""
    centre: Pair
    """its centre"""
    turn: Literal["left", "right"]
    """how it turns"""

    def segment(self, start: Point, name: str, _: str) -> DrawnSegment:
        """See `LineStep.segment`."""
        return DrawnSegment(start, self.arc_to, self.centre, self.turn == "left", name)


class CircleTable(Record):
    """A circle."""

    centre: Pair
    """its centre"""
    radius: Positive
    """its radius"""


class LoopTable(Record):
    """A closed outline."""

    points: Annotated[list[Corner], at.MinLen(3)] | None = None
    """corners [x, y], or [x, y, radius] to round them"""
    names: list[str] | None = None
    """names of the sides from each corner to the next (default: side_1 and so on)"""
    path: Annotated[list[PathStart | LineStep | ArcThrough | ArcAbout], at.MinLen(3)] | None = None
    """lines and arcs: { from = [x, y] }, then { line_to }, { arc_to, through } or { arc_to, centre, turn }"""
    circle: CircleTable | None = None
    """a circle"""

    exclusive = needed = (("points", "path", "circle"),)
    needs = (("names", "points"),)

    def outline(self, what: str, notices: list[str], *, is_outer: bool) -> Outline:
        """Return it, called `what` in messages; repairs are added to the notices."""
        if self.circle is not None:
            drawn = drawn_circle(self.circle.centre, self.circle.radius)
        else:
            drawn = _corners(self, what, notices) if self.path is None else _path(self.path, what)
        outline, repaired = repaired_outline(drawn, what, direction_matters=is_outer)
        notices += repaired
        return outline


def _corners(loop: LoopTable, what: str, notices: list[str]) -> list[DrawnSegment]:
    """Return the sides of a polygon, its corners rounded where a third number gives a radius."""
    rows = loop.points or []
    names = loop.names or [f"side_{number}" for number in range(1, len(rows) + 1)]
    if len(names) != len(rows):
        raise InputError(
            f"{what}: {len(names)} names for {len(rows)} points",
            "a name for the side from each point to the next",
            "correct the names",
        )
    corners, sides = [row[:2] for row in rows], list[tuple[Point, float, str]]()
    for number, (row, name) in enumerate(zip(rows, names, strict=True)):
        if corners[number] == corners[number - 1]:
            point = point_text(corners[number])
            notices.append(f"{what}: the point {point} is given twice; one of both is left out.")
        else:
            sides.append((corners[number], sum(row[2:]), name))
    with located(f"{what}: "):
        return [DrawnSegment(*side) for side in rounded_sides(*zip(*sides, strict=True))]


def _path(path: Sequence[PathStart | LineStep | ArcThrough | ArcAbout], what: str) -> list[DrawnSegment]:
    """Return the segments of a path."""
    first, *steps = path
    drawn = list[DrawnSegment]()
    for number, step in enumerate(steps, 1):
        if isinstance(step, PathStart) or not isinstance(first, PathStart):
            raise InputError(
                f"{what}: a path that does not begin with {{ from }}, or begins again",
                "from = [x, y] once",
                "correct it",
            )
        start = drawn[-1].end if drawn else first.point
        drawn.append(step.segment(start, step.name or f"step_{number}", f"{what}: step {number}"))
    return drawn


class OutlineTable(LoopTable):
    """An outline and its holes."""

    holes: list[LoopTable] = Field([])
    """holes"""

    def region(self, what: str, notices: list[str]) -> Region:
        """Return it; `what` stands before its parts in messages, repairs are added to the notices."""
        return _region(self, self.holes, what, notices)


def _region(outer: LoopTable, holes: Sequence[LoopTable], what: str, notices: list[str]) -> Region:
    """Return the region of an outline with holes."""
    boundary = outer.outline(f"{what}outer boundary", notices, is_outer=True)
    inner = [
        hole.outline(f"{what}hole {number} of {len(holes)}", notices, is_outer=False)
        for number, hole in enumerate(holes, 1)
    ]
    with located(what):
        return Region(boundary, tuple(inner))


class PartTable(Record):
    """A part of a section and its material."""

    outer: LoopTable | None = None
    """outer boundary"""
    holes: list[LoopTable] = Field([])
    """holes"""
    young_MPa: Positive | None = None  # noqa: N815 (the unit megapascal)
    """Young's modulus, of all parts or of none"""
    poisson: PoissonRatio | None = None
    """Poisson's ratio"""

    needed: ClassVar[tuple[tuple[str, ...], ...]] = (("outer",),)
    needs = (("young_MPa", "poisson"), ("poisson", "young_MPa"))


class SectionTable(PartTable):
    """The file of a section of one part, or of several by their names."""

    title: str = ""
    """title (default: the file's name)"""
    unit: str | None = None
    """unit of length of all coordinates"""
    parts: Annotated[dict[str, PartTable], at.MinLen(1)] | None = None
    """parts by name"""

    exclusive = tuple((key, "parts") for key in ("outer", "holes", "young_MPa", "poisson"))
    needed = (("outer", "parts"),)

    @classmethod
    def called(cls) -> str:
        """See `Record.called`."""
        return "the file"


def toml_section(text: str, *, unit: str | None = None) -> DrawnSection:
    """Return the section of a TOML file's text; an `InputError` if a key is unknown or missing, or an outline is wrong.

    The unit must be the file's.
    """
    table = SectionTable.from_values(toml_data(text, 'lines such as unit = "mm", tables such as [outer]'))
    agreed, notices = agreed_unit(table.unit, unit, _HOW_IN_TOML), list[str]()
    several = table.parts is not None
    parts: dict[str, PartTable] = table.parts or {"section": table}
    regions = {
        name: _region(part.outer, part.holes, f"part {name}: " if several else "", notices)
        for name, part in parts.items()
        if part.outer is not None
    }
    materials = {
        name: PartMaterial(young_MPa=part.young_MPa, poisson=part.poisson)
        for name, part in parts.items()
        if part.young_MPa is not None and part.poisson is not None
    }
    return DrawnSection(table.title, Section(regions), agreed, materials, tuple(notices))


# --- Sections from files: TOML, CSV of lines and arcs, DXF.


ENDINGS = (".toml", ".csv", ".dxf")


def read_section(
    path: str | Path, *, unit: str | None = None, mirrored: bool = False, layers: Sequence[str] = ()
) -> DrawnSection:
    """Read a section; the ending of the file's name gives its format.

    An `InputError` if the file cannot be read, is no section, or its outline is wrong; the message names the place.

    - `path`: file that ends with ``.toml``, ``.csv`` or ``.dxf``.
    - `unit`: unit of length of a file that does not name one (CSV and DXF).
    - `mirrored`: whether the file (CSV) holds one half only, to be mirrored about x = 0.
    - `layers`: names of the layers of a drawing (DXF) that are read, shown or not (default: what is visible).
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"file {file} with the ending {ending!r}", f"{', '.join(ENDINGS)}", "save the outline in one of these"
        )
    if mirrored and ending != ".csv":
        raise InputError(f"--mirror for {file}", "half outlines in a CSV file", "draw the whole outline")
    if layers and ending != ".dxf":
        raise InputError(f"layers of {file}", "layers of a DXF drawing", "leave the layers out")
    content = file_content(file, "an outline")
    readers: dict[str, Callable[[], DrawnSection]] = {
        ".toml": lambda: toml_section(_text(content), unit=unit),
        ".csv": lambda: csv_section(_text(content), unit=unit, mirrored=mirrored),
        ".dxf": lambda: dxf_section(content, unit=unit, layers=layers),
    }
    with located(f"{file}: "):
        section = readers[ending]()
    return section if section.title else replace(section, title=file.stem)


def _text(content: bytes) -> str:
    text = utf8_text(content)
    if "\0" in text:
        raise InputError("bytes that are no text (a zero byte)", "text in UTF-8", "check the format of the file")
    return text
