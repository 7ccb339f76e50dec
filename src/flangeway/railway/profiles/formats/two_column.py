"""Profiles as plain text of two columns, with the meaning of the numbers in comments.

A line is a point: lateral and vertical coordinate, apart by blanks, tabs, commas or semicolons; decimal commas are read
where they are not separators as well. Comments start with ``#``, ``!``, ``%`` or ``//``. The comments
``# unit: mm``, ``# kind: rail``, ``# origin: top``, ``# up: yes``, ``# mirror``, ``# tape_mm: 70`` and ``# title: ...``
are read, in small or capital letters, and without the colon before a single word. The first line may name the columns,
with their unit: ``x_mm,y_mm`` or ``y [mm]; z [mm]``; of more than two columns those called x and y are taken, else
those called y and z, else the first two.
"""

import difflib
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import cast

import numpy as np

from flangeway.errors import InputError
from flangeway.formats import UNITS
from flangeway.geometry import FloatArray
from flangeway.railway.profiles.formats.raw_profile import (
    KINDS,
    RAIL_ORIGINS,
    WHEEL_ORIGINS,
    Kind,
    Origin,
    RawProfile,
    number_of,
    numbered_points,
)

_COMMENT = re.compile(r"\s*(?:#|!|%|//)(.*)")
_KEYS = ("unit", "kind", "origin", "up", "mirror", "tape_mm", "title")
_SWITCH = ("yes", "no", "true", "false")
_NAMES = (("x", "y"), ("y", "z"))
_ORIGINS = (*RAIL_ORIGINS, *WHEEL_ORIGINS)


def read_two_column(text: str) -> RawProfile:
    """Return the profile that a text of two columns holds; see the module for what is read.

    An `InputError` if a line is neither a comment nor a point, or a comment has a value that is not allowed.
    """
    header: dict[str, tuple[int, str]] = {}
    rows: list[tuple[int, float, float]] = []
    unit_of_columns = None
    notices: list[str] = []
    n_wide, columns = 0, (0, 1)
    for number, line in enumerate(text.splitlines(), 1):
        comment = _COMMENT.match(line)
        if comment:
            key, value, unread = _keyed(comment[1].strip(), number)
            if key is not None:
                header[key] = (number, value)
            notices += [unread] if unread else []
        elif line.strip():
            cells = _cells(line)
            if not rows and len(cells) <= max(columns):
                columns = (0, 1)  # words of a sentence, no names
            values = _numbers(cells, columns)
            if values is None and not rows:
                unit_of_columns = _unit_of_columns(line) or unit_of_columns
                columns = _named_columns(cells)
            elif values is None:
                raise InputError(
                    f"line {number}: {line.strip()[:60]!r}", "two numbers, or a comment after #", "correct this line"
                )
            else:
                n_wide += len(cells) > 2
                rows.append((number, *values))
    points, lines = numbered_points(rows)
    stated = _stated(header)
    taken = "the first two are" if columns == (0, 1) else f"numbers {columns[0] + 1} and {columns[1] + 1}, by name, are"
    if n_wide:
        notices.append(f"{n_wide} lines have more than two columns; {taken} taken.")
    unit = header["unit"][1].lower() if "unit" in header else unit_of_columns
    return replace(stated, points=points, lines=lines, unit=unit, notices=tuple(notices))


def write_two_column(points: FloatArray, kind: Kind, title: str, tape_mm: float | None = None) -> str:
    """Return points (n, 2) in mm, in this package's frame of a rail's running surface or a wheel, as text.

    Numbers have nine decimals, a picometre; comments give their meaning, so that reading returns the same.
    """
    origin = "top" if kind == "rail" else "tape"
    lines = [
        f"# title: {one_line(title)}",
        f"# kind: {kind}",
        "# unit: mm",
        f"# origin: {origin}",
        "# up: yes",
        *([] if tape_mm is None else [f"# tape_mm: {tape_mm!r}"]),
        "# right-hand side: first column away from the middle of the track, second column up",
        *(f"{x:.9f}\t{y:.9f}" for x, y in points),
    ]
    return "\n".join(lines) + "\n"


def one_line(text: str) -> str:
    """Return a text without line ends and control characters, for headers."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())


def _keyed(words: str, number: int) -> tuple[str | None, str, str]:
    """Return key and value of a comment, and a notice if it looks like one that is read but is not.

    Keys count in capitals too, ``units`` and ``tape`` as well. The colon may be left out before a single word; more
    words behind it are a sentence.
    """
    match = re.match(r"([A-Za-z_]+)\s*(?:([:=])\s*)?(.*)$", words)
    if match is None:
        return None, "", ""
    name = match[1].lower()
    key = {"units": "unit", "tape": "tape_mm", "mirrored": "mirror"}.get(name, name)
    value = match[3].strip()
    if key in _KEYS and (match[2] or key == "title" or (len(value.split()) == 1) or (key == "mirror" and not value)):
        return key, value, ""
    near = [key] if key in _KEYS else difflib.get_close_matches(name, _KEYS, n=1, cutoff=0.75)
    if near and (match[2] or key in _KEYS):
        return None, "", f"The comment in line {number}, {words[:40]!r}, is not read; write it as '# {near[0]}: VALUE'."
    return None, "", ""


def _cells(line: str) -> list[str]:
    """Return the cells of a line; commas are decimal points where semicolons or blanks separate."""
    line = line.strip()
    if ";" in line:
        return [cell.strip().replace(",", ".") for cell in line.rstrip(";").split(";")]
    by_blanks = line.split()
    if len(by_blanks) > 1 and all(re.fullmatch(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", cell) for cell in by_blanks):
        return [cell.replace(",", ".") for cell in by_blanks]
    if "," in line:
        return [cell.strip() for cell in line.rstrip(",").split(",")]
    return by_blanks


def _numbers(cells: list[str], columns: tuple[int, int]) -> tuple[float, float] | None:
    try:
        values = [float(cell.replace("D", "e").replace("d", "e")) if cell else 0.0 for cell in cells]
    except ValueError:
        return None
    if len(values) <= max(columns) or not all(cells[column] for column in columns):
        return None
    return values[columns[0]], values[columns[1]]


def _named_columns(cells: list[str]) -> tuple[int, int]:
    """Return which columns hold the coordinates according to their names, the first two if these are not clear."""
    names = [re.split(r"[\s_\[(]", cell.strip().strip('"').lower(), maxsplit=1)[0] for cell in cells]
    for first, second in _NAMES if len(names) > 2 else ():
        if names.count(first) == 1 and names.count(second) == 1:
            return names.index(first), names.index(second)
    return 0, 1


def _unit_of_columns(line: str) -> str | None:
    """Return the unit in a line such as ``x_mm,y_mm`` or ``y [mm]; z [mm]``."""
    units = {word for word in re.findall(r"(?:_|\[|\()([a-z]+)(?:\]|\)|(?=[,;\s]|$))", line) if word in UNITS}
    return units.pop() if len(units) == 1 else None


def _stated(header: Mapping[str, tuple[int, str]]) -> RawProfile:
    """Return the declarations of the comments, checked, without points."""

    def chosen(key: str, allowed: tuple[str, ...]) -> str | None:
        if key not in header:
            return None
        line, value = header[key][0], header[key][1].lower()
        if value not in allowed:
            known = ", ".join(each for each in allowed if each)
            raise InputError(f"line {line}: {key} = {value!r}", known, "correct this comment")
        return value

    up, mirror = chosen("up", _SWITCH), chosen("mirror", (*_SWITCH, ""))
    tape = header.get("tape_mm")
    return RawProfile(
        np.zeros((0, 2)),
        np.zeros(0, dtype=np.int64),
        kind=cast(Kind | None, chosen("kind", KINDS)),
        upwards=None if up is None else up in ("yes", "true"),
        mirrored=mirror in ("yes", "true", ""),
        origin=cast(Origin | None, chosen("origin", _ORIGINS)),
        tape_mm=None if tape is None else number_of(tape[1], "tape_mm", tape[0]),
        title=header.get("title", (0, ""))[1],
    )
