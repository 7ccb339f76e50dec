"""What readers of profile files return, and profiles as plain text of two columns."""

import difflib
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias, cast

import numpy as np

from flangeway.checks import are_finite, parsed_number
from flangeway.errors import InputError
from flangeway.formats import UNITS
from flangeway.geometry import Contour, FloatArray
from flangeway.system.file_content import csv_cells, csv_separator
from flangeway.types import Ints

# --- Result of a reader of profile files: numbers as they are written, and what the file declares.


Kind = Literal["rail", "wheel"]
KINDS: tuple[Kind, ...] = ("rail", "wheel")
Origin = Literal["top", "base", "gauge", "tape", "flange-back"]
RAIL_ORIGINS: tuple[Origin, ...] = ("top", "base", "gauge")
WHEEL_ORIGINS: tuple[Origin, ...] = ("tape", "flange-back")

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
_COMMA_NUMBER = r"[-+]?\d+(?:,\d+)?(?:[eE][-+]?\d+)?"
_DECIMAL_COMMAS = re.compile(rf"\s*{_COMMA_NUMBER}(?:(?:\s*;\s*|,?\s+){_COMMA_NUMBER})+\s*;?\s*")
_LIKE_A_NUMBER, _UNDERSCORED = re.compile(r"[-+.]?\d"), re.compile(r"\s*[-+]?\d[\d.]*_")
LEADING_NUMBER = re.compile(rf"\s*({_NUMBER})(?=[\s,;]|$)")
MAX_COORDINATE = 1e6  # in the file's unit: beyond it no profile was meant
MAX_POINTS = 50_000  # ten times as many as an instrument writes


@dataclass(frozen=True, eq=False)
class RawProfile:
    """Points or segments of a profile in the file's own unit and axes.

    - `points`: points (n, 2) in the order of the file: lateral coordinate, vertical coordinate.
    - `lines`: line of the file that holds each point (n,), for messages.
    - `unit`: unit of length that the file names, None if it names none.
    - `unit_is_sure`: whether the file names it, not only its format.
    - `kind`: ``"rail"`` or ``"wheel"`` if the file declares it.
    - `kind_is_sure`: whether the file declares it inside, not only by its name.
    - `upwards`: whether the second coordinate points up, None if the file does not declare it.
    - `mirrored`: whether the file declares that it has to be mirrored to be a right-hand profile.
    - `origin`: where the file's (0, 0) lies, if the file declares it.
    - `tape_mm`: distance of the tape line from the flange's back, if the file declares it.
    - `title`: name or comment in the file.
    - `contour`: exact lines and arcs, in the order of `points` (their joints), instead of measured points.
    - `notices`: what the reader left out or assumed, in sentences.
    """

    points: FloatArray
    lines: Ints
    unit: str | None = None
    unit_is_sure: bool = True
    kind: Kind | None = None
    kind_is_sure: bool = False
    upwards: bool | None = None
    mirrored: bool = False
    origin: Origin | None = None
    tape_mm: float | None = None
    title: str = ""
    contour: Contour | None = None
    notices: tuple[str, ...] = ()


def numbered_points(rows: Sequence[tuple[int, float, float]]) -> tuple[FloatArray, Ints]:
    """Return points (n, 2) and their lines (n,) from rows of line, x and y.

    An `InputError` if there is no row or more than `MAX_POINTS`, or a number is not finite or absurdly large; the
    message names the line.
    """
    if not rows:
        raise InputError("a file without points", "one point a line: two numbers", "check that the file is whole")
    if len(rows) > MAX_POINTS:
        raise InputError(f"{len(rows)} points", f"up to {MAX_POINTS}", "leave points out")
    for line, *values in rows:
        if not all(abs(value) <= MAX_COORDINATE for value in values):
            raise InputError(
                f"line {line}: the point ({values[0]:g}, {values[1]:g})",
                f"finite coordinates up to {MAX_COORDINATE:g}",
                "repair or remove this line",
            )
    table = np.array(rows, dtype=np.float64)
    return table[:, 1:].copy(), table[:, 0].astype(np.int64)


Header: TypeAlias = dict[str, tuple[int, str]]
"""Line and value by the key in small letters."""


def text_of(header: Header, key: str) -> str:
    """Return the value of a key; an empty one if there is none."""
    return header.get(key, (0, ""))[1]


def keys_and_rows(lines: Iterable[tuple[int, str]]) -> tuple[Header, list[tuple[int, list[float]]]]:
    """Return the lines ``key = value`` of a text, and its rows of numbers, each after its number of line.

    An `InputError` if words stand between the rows, or commas separate numbers with decimal commas; words before them
    are no points.

    - `lines`: numbers of lines, and lines without comments; those that begin with ``#`` are comments too.
    """
    header: Header = {}
    rows: list[tuple[int, list[float]]] = []
    lines = [(number, words) for number, words in lines if not words.lstrip().startswith("#")]
    for number, words in lines:
        key, equals, value = words.partition("=")
        values = leading_numbers(words)
        if equals:
            header[key.strip().lower()] = (number, value.strip().strip("'"))
        elif values:
            rows.append((number, values))
        elif words.strip() and (rows or _UNDERSCORED.match(words)):
            raise InputError(f"line {number}: {words.strip()[:60]!r}", "a point", "correct this line")
    _refuse_commas_twice(dict(lines), rows)
    return header, rows


def points_in(rows: Sequence[tuple[int, list[float]]], first: int = 0, second: int = 1) -> tuple[FloatArray, Ints]:
    """Return points (n, 2) from two columns of rows, and their lines (n,); errors as of `numbered_points`.

    An `InputError` if a row is shorter.
    """
    for number, values in rows:
        if len(values) <= max(first, second):
            raise InputError(
                f"line {number}: {len(values)} numbers", f"{max(first, second) + 1} or more", "correct this line"
            )
    return numbered_points([(number, values[first], values[second]) for number, values in rows])


def leading_numbers(line: str) -> list[float]:
    """Return the numbers that a line starts with, apart by blanks, commas or semicolons; words end them."""
    numbers = []
    start = 0
    line = with_decimal_points(line)
    while match := LEADING_NUMBER.match(line, start):
        numbers.append(float(match[1].replace("d", "e").replace("D", "e")))
        start = match.end()
        separator = re.compile(r"\s*[,;]?").match(line, start)
        start = separator.end() if separator else start
    return numbers


def with_decimal_points(line: str) -> str:
    """Return a line of numbers with points for their decimal commas, if other characters separate the numbers.

    These are blanks, ``-37,05  0,2``, semicolons, or commas with a blank behind them, ``-37,05, 0,2``.
    """
    return re.sub(r"(?<=\d),(?=\d)", ".", line) if _DECIMAL_COMMAS.fullmatch(line) else line


def number_of(text: str, what: str, line: int) -> float:
    """Return a number from the header of a file. An `InputError` if the text is no finite number."""
    try:
        value = parsed_number(text.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"line {line}: {what} = {text!r}", "a finite number", "correct this line")
    return value


# --- Profiles as plain text of two columns, with the meaning of the numbers in comments.
#
# A line is a point: lateral and vertical coordinate, apart by blanks, tabs, commas or semicolons; decimal commas are
# read where other characters, or commas with a blank behind them, separate the numbers. Comments start with ``#``,
# ``!``, ``%`` or ``//``. The comments ``# unit: mm``, ``# kind: rail``, ``# origin: top``, ``# up: yes``, ``# mirror``,
# ``# tape_mm: 70`` and ``# title: ...`` are read, in small or capital letters, and without the colon before a single
# word. The first line may name the columns, with their unit: ``x_mm,y_mm`` or ``y [mm]; z [mm]``; of more than two
# columns those called x and y are taken, else those called y and z or x and z, else the first two after those that
# count the points or never change.


_COMMENT = re.compile(r"\s*(?:#|!|%|//)(.*)")
_KEYS = ("unit", "kind", "origin", "up", "mirror", "tape_mm", "title")
_SWITCH = ("yes", "no", "true", "false")
_NAMES = (("x", "y"), ("y", "z"), ("x", "z"))
_ORIGINS = (*RAIL_ORIGINS, *WHEEL_ORIGINS)
_JSON = 'points [[x, y], ...] or {"x": [...], "y": [...]}'


def read_two_column(
    text: str, names_taken: tuple[tuple[str, str], ...] = _NAMES, allowed: str = "two numbers"
) -> RawProfile:
    """Return the profile that a text of two columns holds; see the module for what is read.

    An `InputError` if a line is neither a comment nor a point, or a comment has a value that is not allowed.

    - `names_taken`: first words of the names of the two columns to take of several, the first pair that is there.
    - `allowed`: what a line has, for messages.
    """
    header: dict[str, tuple[int, str]] = {}
    rows: list[tuple[int, list[float]]] = []
    unit_of_columns = None
    notices: list[str] = []
    names, last = list[str](), (0, "")
    for number, line in enumerate(text.splitlines(), 1):
        comment = _COMMENT.match(line)
        if comment:
            key, value, unread = _keyed(comment[1].strip(), number)
            if key is not None:
                header[key] = (number, value)
            notices += [unread] if unread else []
        elif line.strip():
            cells = _cells(line, number)
            values = _numbers(cells, len(names))
            if values is None and not rows and not all(map(_LIKE_A_NUMBER.match, cells)):
                unit_of_columns = _unit_of_columns(line) or unit_of_columns
                names, last = cells, (number, line)
            elif values is None:
                raise _wrong_line(number, line, allowed)
            else:
                rows.append((number, values))
    if names and not rows:  # every line has words
        raise _wrong_line(*last, allowed)
    _refuse_commas_twice(dict(enumerate(text.splitlines(), 1)), rows)
    first, second = columns = _columns_taken(names, names_taken, [values for _, values in rows])
    if len(names) > max(columns):
        unit_of_columns = _unit_of_columns(f"{names[first]},{names[second]}") or unit_of_columns
    for number, values in rows:
        if len(values) <= max(columns) or not math.isfinite(values[first] + values[second]):
            raise _wrong_line(number, text.splitlines()[number - 1], allowed)
    points, lines = numbered_points([(number, values[first], values[second]) for number, values in rows])
    stated = _stated(header)
    n_wide = sum(len(values) > 2 for _, values in rows)
    if n_wide:
        taken = "the first two" if columns == (0, 1) else f"numbers {first + 1} and {second + 1}"
        notices.append(f"{n_wide} lines have more than two columns; {taken} are taken.")
    unit = header["unit"][1].lower() if "unit" in header else unit_of_columns
    return replace(stated, points=points, lines=lines, unit=unit, notices=tuple(notices))


def read_json(text: str) -> RawProfile:
    """Return the profile in JSON: a list of points, two lists of coordinates, or an object with one of these.

    The object has ``points``, or lists ``x`` and ``y``, ``y`` and ``z``, or ``x`` and ``z``; its texts and numbers are
    those of the comments of two columns, such as ``"unit": "mm"``. An `InputError` as of `read_two_column`, or if it is
    no such JSON; it names points in place of lines.
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as reason:
        raise InputError(f"no JSON: {str(reason)[:60]}", _JSON, "save the file again") from None
    stated = data if isinstance(data, dict) else {"points": data}
    table = stated.get("points")
    if table is None:
        table = next(([stated[x], stated[y]] for x, y in _NAMES if x in stated and y in stated), None)
    if isinstance(table, list) and len(table) == 2 and all(isinstance(row, list) and len(row) > 2 for row in table):
        table = list(zip(*table, strict=True)) if len(table[0]) == len(table[1]) else None
    if not (isinstance(table, list) and all(isinstance(row, list | tuple) and are_finite(row, 2) for row in table)):
        raise InputError("JSON of another shape", _JSON, "save pairs of numbers, or two lists of as many numbers")
    comments = {key: (0, str(value)) for key, value in stated.items() if isinstance(value, str | bool | int | float)}
    points, lines = numbered_points([(n, float(x), float(y)) for n, (x, y) in enumerate(table, 1)])
    unit = comments.get("unit", (0, None))[1]
    return replace(_stated(comments), points=points, lines=lines, unit=unit and unit.lower())


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


def _cells(line: str, number: int) -> list[str]:
    """Return the cells of a line; commas are decimal points where semicolons or blanks separate."""
    line = with_decimal_points(line.strip())
    return csv_cells(line.rstrip(";,"), number, csv_separator(line)) if ";" in line or "," in line else line.split()


def _numbers(cells: list[str], n_names: int = 0) -> list[float] | None:
    """Return the numbers of a line, NaN for empty cells; None if a cell is none, or there are fewer than two.

    - `n_names`: headings; in a line of as many cells words, such as "good", may follow two numbers, and are NaN.
    """
    values = []
    for column, cell in enumerate(cells):
        try:
            values.append(parsed_number(cell.replace("D", "e").replace("d", "e")) if cell else math.nan)
        except ValueError:
            if column < 2 or len(cells) != n_names:
                return None
            values.append(math.nan)
    return values if len(values) > 1 and any(cells) else None


def _wrong_line(number: int, line: str, allowed: str) -> InputError:
    return InputError(
        f"line {number}: {line.strip()[:60]!r}", f"{allowed}, or a comment after #", "correct this line, or remove it"
    )


def _refuse_commas_twice(texts: Mapping[int, str], rows: list[tuple[int, list[float]]]) -> None:
    """Refuse rows, each after its line, whose decimal commas are those between the numbers too.

    - `texts`: lines by their numbers.
    """
    lines = [texts[number] for number, _ in rows]
    if rows and all(re.fullmatch(r"\s*[-+]?\d+,\d+,[-+]?\d+,\d+\s*", line) for line in lines):
        raise InputError(
            f"line {rows[0][0]}: {lines[0].strip()[:60]!r}, with commas in the numbers and between them",
            "semicolons, tabs or blanks between numbers with decimal commas",
            "save the file so",
        )


def _columns_taken(
    names: list[str], names_taken: tuple[tuple[str, str], ...], rows: list[list[float]]
) -> tuple[int, int]:
    """Return which columns hold the coordinates: by their names, else the first two that do."""
    fewest = min(map(len, rows), default=2)
    words = [re.split(r"[\s_\[(]", name.strip().strip('"').lower(), maxsplit=1)[0] for name in names]

    def is_coordinate(column: int) -> bool:
        """Whether a column neither counts the points nor is always the same."""
        steps = {right[column] - left[column] for left, right in pairwise(rows)}
        return not (steps == {0.0} or (steps == {1.0} and rows[0][column] in (0.0, 1.0)))

    for first, second in names_taken if len(words) > 2 else ():
        if words.count(first) == 1 and words.count(second) == 1 and max(map(words.index, (first, second))) < fewest:
            taken = words.index(first), words.index(second)
            if all(map(is_coordinate, taken)):
                return taken
    columns = [column for column in range(fewest) if is_coordinate(column)] if fewest > 2 else []
    return (columns[0], columns[1]) if len(columns) > 1 else (0, 1)


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
            known = ", ".join(word for word in allowed if word)
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
