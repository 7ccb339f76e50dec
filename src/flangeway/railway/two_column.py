"""Profiles as plain text of two columns, with what the numbers mean in comments.

A line is a point: lateral and vertical coordinate, apart by blanks, tabs, commas or semicolons; decimal commas are read
where they are not separators as well. Comments start with ``#``, ``!``, ``%`` or ``//``. The comments
``# unit: mm``, ``# kind: rail``, ``# origin: top``, ``# up: yes``, ``# mirror``, ``# tape_mm: 70`` and ``# title: ...``
are read. The first line may name the columns, with their unit: ``x_mm,y_mm`` or ``y [mm]; z [mm]``; of more than two
columns those called x and y are taken, else those called y and z, else the first two.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import cast

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import UNITS, FloatArray
from flangeway.railway.raw_profile import (
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
_KEY = re.compile(r"\s*(unit|kind|origin|up|tape_mm|title)\s*[:=]\s*(.*?)\s*$")
_NAMES = (("x", "y"), ("y", "z"))
_ORIGINS = (*RAIL_ORIGINS, *WHEEL_ORIGINS)


def read_two_column(text: str) -> RawProfile:
    """Return the profile that a text of two columns holds; see the module for what is read.

    Raises
    ------
    InputError
        If a line is neither a comment nor a point, or a comment has a value that is not allowed.

    """
    header: dict[str, tuple[int, str]] = {}
    rows: list[tuple[int, float, float]] = []
    unit_of_columns = None
    n_wide, columns = 0, (0, 1)
    for number, line in enumerate(text.splitlines(), 1):
        comment = _COMMENT.match(line)
        if comment:
            words = comment[1].strip()
            if words == "mirror":
                header["mirror"] = (number, words)
            elif key := _KEY.match(words):
                header[key[1]] = (number, key[2])
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
    said = _said(header)
    taken = "the first two are" if columns == (0, 1) else f"numbers {columns[0] + 1} and {columns[1] + 1}, by name, are"
    notices = (f"{n_wide} lines have more than two columns; {taken} taken.",) if n_wide else ()
    unit = header["unit"][1] if "unit" in header else unit_of_columns
    return replace(said, points=points, lines=lines, unit=unit, mirrored="mirror" in header, notices=notices)


def write_two_column(points: FloatArray, kind: Kind, title: str) -> str:
    """Return points (n, 2) in mm, in this package's frame of a rail's running surface or a wheel, as text.

    Numbers have nine decimals, a picometre; the comments say what they mean, so that reading gives the same back.
    """
    origin = "top" if kind == "rail" else "tape"
    lines = [
        f"# title: {one_line(title)}",
        f"# kind: {kind}",
        "# unit: mm",
        f"# origin: {origin}",
        "# up: yes",
        "# right-hand side: first column away from the middle of the track, second column up",
        *(f"{x:.9f}\t{y:.9f}" for x, y in points),
    ]
    return "\n".join(lines) + "\n"


def one_line(text: str) -> str:
    """Return a text without line ends and control characters, for headers."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())


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
    """Return which columns hold the coordinates according to their names, the first two if these say nothing."""
    names = [re.split(r"[\s_\[(]", cell.strip().strip('"').lower(), maxsplit=1)[0] for cell in cells]
    for first, second in _NAMES if len(names) > 2 else ():
        if names.count(first) == 1 and names.count(second) == 1:
            return names.index(first), names.index(second)
    return 0, 1


def _unit_of_columns(line: str) -> str | None:
    """Return the unit in a line such as ``x_mm,y_mm`` or ``y [mm]; z [mm]``."""
    units = {word for word in re.findall(r"(?:_|\[|\()([a-z]+)(?:\]|\)|(?=[,;\s]|$))", line) if word in UNITS}
    return units.pop() if len(units) == 1 else None


def _said(header: Mapping[str, tuple[int, str]]) -> RawProfile:
    """Return what comments say, checked, without points."""

    def chosen(key: str, allowed: tuple[str, ...]) -> str | None:
        if key not in header:
            return None
        line, value = header[key]
        if value not in allowed:
            raise InputError(f"line {line}: {key} = {value!r}", ", ".join(allowed), "correct this comment")
        return value

    up = chosen("up", ("yes", "no"))
    tape = header.get("tape_mm")
    return RawProfile(
        np.zeros((0, 2)),
        np.zeros(0, dtype=np.int64),
        kind=cast(Kind | None, chosen("kind", KINDS)),
        upwards=None if up is None else up == "yes",
        origin=cast(Origin | None, chosen("origin", _ORIGINS)),
        tape_mm=None if tape is None else number_of(tape[1], "tape_mm", tape[0]),
        title=header.get("title", (0, ""))[1],
    )
