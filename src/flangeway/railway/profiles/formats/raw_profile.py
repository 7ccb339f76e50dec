"""Result of a reader of profile files: numbers as they are written, and what the file declares."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Contour, FloatArray

Kind = Literal["rail", "wheel"]
KINDS: tuple[Kind, ...] = ("rail", "wheel")
Origin = Literal["top", "base", "gauge", "tape", "flange-back"]
RAIL_ORIGINS: tuple[Origin, ...] = ("top", "base", "gauge")
WHEEL_ORIGINS: tuple[Origin, ...] = ("tape", "flange-back")

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
_DECIMAL_COMMAS = re.compile(r"\s*[-+]?\d+,\d+(?:[eE][-+]?\d+)?(?:\s+[-+]?\d+(?:,\d+)?(?:[eE][-+]?\d+)?)+\s*")
LEADING_NUMBER = re.compile(rf"\s*({_NUMBER})(?=[\s,;]|$)")
MAX_COORDINATE = 1e6  # in the file's unit: beyond it no profile was meant


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
    lines: NDArray[np.int64]
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


def numbered_points(rows: Sequence[tuple[int, float, float]]) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return points (n, 2) and their lines (n,) from rows of line, x and y.

    An `InputError` if there is no row, or a number is not finite or absurdly large; the message names the line.
    """
    if not rows:
        raise InputError("a file without points", "one point a line: two numbers", "check that the file is whole")
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

    An `InputError` if words stand between the rows; words before them are no points.

    - `lines`: numbers of lines, and lines without comments.
    """
    header: Header = {}
    rows: list[tuple[int, list[float]]] = []
    for number, words in lines:
        key, equals, value = words.partition("=")
        values = leading_numbers(words)
        if equals:
            header[key.strip().lower()] = (number, value.strip().strip("'"))
        elif values:
            rows.append((number, values))
        elif rows and words.strip():
            raise InputError(f"line {number}: {words.strip()[:60]!r}", "a point", "correct this line")
    return header, rows


def points_in(
    rows: Sequence[tuple[int, list[float]]], first: int = 0, second: int = 1
) -> tuple[FloatArray, NDArray[np.int64]]:
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
    place = 0
    line = with_decimal_points(line)
    while match := LEADING_NUMBER.match(line, place):
        numbers.append(float(match[1].replace("d", "e").replace("D", "e")))
        place = match.end()
        separator = re.compile(r"\s*[,;]?").match(line, place)
        place = separator.end() if separator else place
    return numbers


def with_decimal_points(line: str) -> str:
    """Return a line of numbers apart by blanks, ``-37,05  0,2``, with points for their decimal commas."""
    return line.replace(",", ".") if _DECIMAL_COMMAS.fullmatch(line) else line


def number_of(text: str, what: str, line: int) -> float:
    """Return a number from the header of a file. An `InputError` if the text is no finite number."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"line {line}: {what} = {text!r}", "a finite number", "correct this line")
    return value
