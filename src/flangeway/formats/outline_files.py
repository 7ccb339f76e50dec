"""Sections from files: TOML, CSV of lines and arcs, DXF."""

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.checks import is_finite
from flangeway.errors import InputError, located, short
from flangeway.formats.drawn_section import (
    DrawnSection,
    DrawnSegment,
    PartMaterial,
    agreed_unit,
    csv_section,
    drawn_circle,
    repaired_outline,
)
from flangeway.formats.dxf_files import dxf_section
from flangeway.geometry.arrays import Point, circle_centres, cross_product, norms, point_text
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region, Section
from flangeway.geometry.shapes import rounded_sides
from flangeway.system.file_content import file_content, toml_data, utf8_text

# --- Sections from TOML, the format to write by hand; `docs/tutorials/section.md` explains it with an example.


_PART_KEYS = ("outer", "holes", "young_MPa", "poisson")
_LOOP_KEYS = ("points", "names", "path", "circle")
_HOW_IN_TOML = 'a line such as unit = "mm" at the top of the file'


def toml_section(text: str, *, unit: str | None = None) -> DrawnSection:
    """Return the section of a TOML file's text; an `InputError` if a key is unknown or missing, or an outline is wrong.

    The unit must be the file's.
    """
    data = toml_data(text, 'lines such as unit = "mm", tables such as [outer]')
    several = "parts" in data
    allowed = ("title", "unit", "parts") if several else ("title", "unit", *_PART_KEYS)
    _refuse_unknown(data, allowed, "the file")
    in_file = data.get("unit")
    agreed = agreed_unit(None if in_file is None else _name(in_file, "unit"), unit, _HOW_IN_TOML)
    parts = _table(data["parts"], "parts") if several else {"section": data}
    regions, materials = {}, {}
    notices: list[str] = []
    for name, part in parts.items():
        what = f"part {name}: " if several else ""
        table = _table(part, f"parts.{name}")
        _refuse_unknown(table, allowed if not several else _PART_KEYS, f"part {name}")
        regions[name] = _region(table, what, notices)
        material = _material(table, what)
        if material is not None:
            materials[name] = material
    return DrawnSection(_name(data.get("title", ""), "title"), Section(regions), agreed, materials, tuple(notices))


def outline_region(table: Mapping[str, Any], what: str, notices: list[str]) -> Region:
    """Return the region of a table with points, path or circle, by itself or in `outer`, and holes.

    Repairs are added to the notices.
    """
    keys = (*_LOOP_KEYS, "outer", "holes")
    _refuse_unknown(table, keys, f"{what}the table")
    if "outer" not in table:
        outer = {key: value for key, value in table.items() if key in _LOOP_KEYS}
        table = {"outer": outer, **{key: value for key, value in table.items() if key not in outer}}
    return _region(table, what, notices)


def _region(table: Mapping[str, Any], what: str, notices: list[str]) -> Region:
    if "outer" not in table:
        raise InputError(f"{what}no outer boundary", "a table [outer] with points, path or circle", "add it")
    holes = table.get("holes", [])
    if not isinstance(holes, list):
        raise InputError(f"{what}holes = {short(holes)}", "tables [[holes]]", "write [[holes]] above each hole")
    outer = _outline(_table(table["outer"], f"{what}outer"), f"{what}outer boundary", notices, outer=True)
    inner = [
        _outline(_table(hole, f"{what}hole {i}"), f"{what}hole {i} of {len(holes)}", notices, outer=False)
        for i, hole in enumerate(holes, 1)
    ]
    with located(what):
        return Region(outer, tuple(inner))


def _outline(table: Mapping[str, Any], what: str, notices: list[str], *, outer: bool) -> Outline:
    _refuse_unknown(table, _LOOP_KEYS, what)
    kinds = [kind for kind in ("points", "path", "circle") if kind in table]
    if len(kinds) != 1 or ("names" in table and kinds != ["points"]):
        raise InputError(
            f"{what} with {' and '.join([*kinds, *(['names'] if 'names' in table else [])]) or 'nothing'}",
            "one of points (with optional names), path, circle",
            "keep one of them",
        )
    kind = kinds[0]
    if kind == "points":
        drawn = _corners(table, what, notices)
    elif kind == "path":
        drawn = _path(table["path"], what)
    else:
        circle = _table(table["circle"], f"{what}: circle")
        _refuse_unknown(circle, ("centre", "radius"), f"{what}: circle")
        radius = _number(circle.get("radius"), f"{what}: radius of the circle")
        if not radius > 0.0:
            raise InputError(f"{what}: radius of the circle = {radius:g}", "a positive length", "correct it")
        drawn = drawn_circle(_point(circle.get("centre"), f"{what}: centre of the circle"), radius)
    outline, repaired = repaired_outline(drawn, what, direction_matters=outer)
    notices += repaired
    return outline


def _corners(table: Mapping[str, Any], what: str, notices: list[str]) -> list[DrawnSegment]:
    """Return the sides of a polygon, its corners rounded where a third number gives a radius."""
    rows = table["points"]
    if not isinstance(rows, list) or len(rows) < 3:
        raise InputError(f"{what}: points = {short(rows)}", "three points [x, y] or more", "add points")
    corners: list[Point] = []
    radii: list[float] = []
    for number, row in enumerate(rows, 1):
        here = f"{what}: point {number}"
        if not isinstance(row, list) or len(row) not in (2, 3):
            raise InputError(f"{here} is {short(row)}", "[x, y], or [x, y, radius] to round the corner", "correct it")
        corners.append(_point(row[:2], here))
        radii.append(_number(row[2], f"{here}: radius") if len(row) == 3 else 0.0)
    names = table.get("names", [f"side_{i}" for i in range(1, len(corners) + 1)])
    if not isinstance(names, list) or len(names) != len(corners):
        raise InputError(
            f"{what}: names = {short(names)}",
            f"{len(corners)} names, one for the side from each point to the next",
            "correct the names",
        )
    kept = [i for i, corner in enumerate(corners) if corner != corners[i - 1]]
    notices += [
        f"{what}: the point {point_text(corners[i])} is given twice; one of both is left out."
        for i in sorted(set(range(len(corners))) - set(kept))
    ]
    labels = [_name(names[i], f"{what}: name {i + 1}") for i in kept]
    with located(f"{what}: "):
        sides = rounded_sides([corners[i] for i in kept], [radii[i] for i in kept], labels)
    return [DrawnSegment(*side) for side in sides]


def _path(steps: Any, what: str) -> list[DrawnSegment]:
    """Return the segments of ``{ from = [x, y] }, { line_to = ... }, { arc_to = ..., through = ... }``."""
    if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps) or len(steps) < 3:
        raise InputError(
            f"{what}: path = {short(steps)}", "steps { from }, { line_to }, { arc_to }", "see the tutorial"
        )
    if set(steps[0]) != {"from"}:
        raise InputError(f"{what}: a path that starts with {short(steps[0])}", "{ from = [x, y] } first", "add it")
    end = _point(steps[0]["from"], f"{what}: from")
    drawn = []
    for number, step in enumerate(steps[1:], 1):
        segment = _step(step, end, f"{what}: step {number}")
        drawn.append(segment)
        end = segment.end
    return drawn


def _step(step: Mapping[str, Any], start: Point, here: str) -> DrawnSegment:
    _refuse_unknown(step, ("line_to", "arc_to", "through", "centre", "turn", "name"), here)
    name = _name(step.get("name", here.rpartition(": ")[2].replace(" ", "_")), f"{here}: name")
    keys = set(step) - {"name"}
    if keys == {"line_to"}:
        return DrawnSegment(start, _point(step["line_to"], f"{here}: line_to"), name=name)
    if keys == {"arc_to", "through"}:
        end, middle = _point(step["arc_to"], f"{here}: arc_to"), _point(step["through"], f"{here}: through")
        return through_arc(start, middle, end, name, here)
    if keys == {"arc_to", "centre", "turn"} and step["turn"] in ("left", "right"):
        end, centre = _point(step["arc_to"], f"{here}: arc_to"), _point(step["centre"], f"{here}: centre")
        return DrawnSegment(start, end, centre, step["turn"] == "left", name)
    raise InputError(
        f"{here} is {short(dict(step))}",
        '{ line_to }, { arc_to, through } or { arc_to, centre, turn = "left" or "right" }, each with an optional name',
        "correct this step",
    )


def _material(table: Mapping[str, Any], what: str) -> PartMaterial | None:
    if "young_MPa" not in table and "poisson" not in table:
        return None
    young = _number(table.get("young_MPa"), f"{what}young_MPa")
    poisson = _number(table.get("poisson"), f"{what}poisson")
    with located(what):
        return PartMaterial(young, poisson)


def _table(value: Any, what: str) -> Mapping[str, Any]:
    if not isinstance(value, dict) or not value:
        raise InputError(f"{what} = {short(value)}", "a table with keys", "see the tutorial for the format")
    return value


def _name(value: Any, what: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"{what} is {short(value)}", "text in quotation marks", "correct it")
    return value


def _number(value: Any, what: str) -> float:
    if not is_finite(value):
        raise InputError(f"{what} is {'missing' if value is None else short(value)}", "a finite number", "correct it")
    return float(value)


def _point(value: Any, what: str) -> Point:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{what} is {'missing' if value is None else short(value)}", "a point [x, y]", "correct it")
    return _number(value[0], f"{what}: x"), _number(value[1], f"{what}: y")


def _refuse_unknown(table: Mapping[str, Any], known: Sequence[str], what: str) -> None:
    for key in table:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
            advice = f"did you mean {near[0]}?" if near else "remove it"
            raise InputError(f"{what} with the key {short(key)}", f"keys {', '.join(known)}", advice)


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
