"""What readers of files share: whether there is a file, its bytes, the cells of lines in CSV, and files in TOML."""

import csv
import errno
import re
import stat
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from flangeway.checks import check_kind, parsed_number
from flangeway.errors import InputError, located
from flangeway.types import Floats, Key
from flangeway.units import us_key

# --- What readers of files share: whether there is a file, its bytes, the cells of lines in CSV, and what TOML says.


MAX_BYTES = 50_000_000
COMMA_NUMBER = re.compile(r"[+-]?\d*,\d*(?:[eE][+-]?\d+)?")
MAX_DEPTH = 50  # tables and lists inside of each other; no input has more than ten
_NAME = r"(?:[\w-]+|\"[^\"]*\"|'[^']*')"
_PART = r"(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+"  # of a name with points, without ways back
_LONG_NAME = re.compile(rf"(?<![\w-]){_PART}(?:\.[ \t]*+{_PART}){{{MAX_DEPTH}}}")


def is_file(path: Path) -> bool:
    """Whether there is a file; a name that no file can have, too long or with a zero byte, has none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def names_file(name: str, folder: Path = Path()) -> bool:
    """Whether a text names a file that is there: with an ending or a folder; a single word means something bundled."""
    path = Path(name)
    return bool(path.suffix or path.name != name) and is_file(folder / path)


def path_of(owner: str, path: object) -> Path:
    """Return the path of a file that a user of Python names; an `InputError` if it is neither a text nor a path."""
    check_kind(owner, "path", path, str | PathLike, "the name of a file", "give a text or a path")
    return Path(path)  # type: ignore[arg-type]


def limited_bytes(
    file: Path, limit: int, smaller: str, name: str = "file", instead: str = "", get_one: str = "check the name"
) -> bytes:
    """Bytes of a file; an `InputError` if it cannot be read, or is larger than a limit.

    - `smaller`: advice for a file that is too large.
    - `name`: what the file is called.
    - `instead`: what may be given in its place.
    - `get_one`: advice where it cannot be read.
    """
    try:
        status = file.stat()
        if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):  # a folder has an error of its own
            raise OSError(errno.EINVAL, "not a file but a pipe or a device")
        if status.st_size <= limit:
            return file.read_bytes()
    except (OSError, ValueError) as reason:  # a zero byte in the name is the latter
        why = getattr(reason, "strerror", None) or reason
        raise InputError(f"{name} {file}: {why}", f"a file that can be read{instead}", get_one) from reason
    raise InputError(f"{name} {file} of {status.st_size} bytes", f"a file of up to {limit} bytes", smaller)


def file_content(file: Path, what: str) -> bytes:
    """Return the bytes of a file; an `InputError` if it cannot be read or is empty, "a profile" expected, say."""
    content = limited_bytes(file, MAX_BYTES, f"give {what} and no more")
    if not content.strip():
        raise InputError(f"{file}: an empty file", what, "check that it was saved")
    return content


def utf8_text(content: bytes) -> str:
    """Return a text in UTF-8; an `InputError` if it is none."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        raise InputError(
            f"bytes that are no text (byte {reason.start})", "text in UTF-8", "check the format, or save it as UTF-8"
        ) from reason


def csv_separator(header: str) -> str:
    """What separates the cells of a table with this first line: semicolons or tabs if it has some, else commas."""
    return next((separator for separator in ";\t" if separator in header), ",")


def csv_cells(line: str, number: int, separator: str = ",") -> list[str]:
    """Return the cells of a line without blanks around them; none of an empty line.

    Unless commas separate them, those in numbers are decimal commas, and become points.
    """
    try:
        cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error as reason:
        raise InputError(
            f"line {number} of {len(line)} characters: {reason}", "short cells", "check that each row has its own line"
        ) from reason
    return [cell.replace(",", ".") if separator != "," and COMMA_NUMBER.fullmatch(cell) else cell for cell in cells]


def csv_table(file: Path, what: str) -> list[tuple[int, dict[str, str]]]:
    """Return the lines of a CSV file by the names in its first line, behind their numbers; empty lines are left out.

    An `InputError` if it cannot be read, a column has no name or that of another, or a line another number of cells.

    - `what`: what is expected, for messages.
    """
    with located(f"{file}, ", unless=str(file)):
        text = utf8_text(file_content(file, what))
        separator = csv_separator(text.partition("\n")[0])
        lines = [(n, csv_cells(line, n, separator)) for n, line in enumerate(text.splitlines(), 1)]
    (first, names), *rows = ((number, cells) for number, cells in lines if any(cells))
    for column, name in enumerate(names):
        if not name or name in names[:column]:
            fault = f"the column {name} twice" if name else "a column without a name"
            raise InputError(f"{file}, line {first}: {fault}", "each name once", "correct the first line")
    for number, cells in rows:
        if len(cells) != len(names):
            raise InputError(
                f"{file}, line {number}: {len(cells)} cells",
                f"{len(names)} values: {', '.join(names)}",
                "complete the line, or remove it",
            )
    return [(number, dict(zip(names, cells, strict=True))) for number, cells in rows]


def number_table(file: Path, columns: Sequence[str], what: str) -> Floats:
    """Return the numbers of some columns of a CSV file, shape (n_lines, n_columns), one line or more.

    An `InputError` as of `csv_table`, if a column is missing, or if a cell has no finite number.
    """
    rows = csv_table(file, what)
    missing = [name for name in columns if rows and name not in rows[0][1]]
    if missing or not rows:
        fault = f"no column {' and '.join(missing)}" if missing else "no numbers"
        raise InputError(f"{file}, line 1: {fault}", what, "name the columns")
    values: Floats = np.empty((len(rows), len(columns)))
    for line, (number, cells) in zip(values, rows, strict=True):
        texts = [cells[name] for name in columns]
        try:
            line[:] = [parsed_number(text) for text in texts]
        except ValueError as reason:
            raise InputError(
                f"{file}, line {number}: {','.join(texts)!r}", "a number in each column", "correct it"
            ) from reason
    if not np.isfinite(values).all():
        raise InputError(f"{file}: numbers that are not finite", what, "correct them")
    return values


def packaged_rows(package: str, name: str) -> list[dict[str, str]]:
    """Rows of a CSV file in a package's folder ``data`` by column; lines that begin with ``#`` state the source."""
    return list(csv.DictReader(line for line in packaged_text(package, name).splitlines() if not line.startswith("#")))


def packaged_text(package: str, name: str) -> str:
    """Text of a file in a package's folder ``data``."""
    return (files(package) / "data" / name).read_text(encoding="utf-8")


def toml_data(text: str, lines: str) -> dict[str, Any]:
    """Return the data of a text in TOML; the `InputError` of a wrong one shows `lines`: "lines such as ..."."""
    try:
        if _LONG_NAME.search(text):  # tables inside of each other take the square of their number
            raise RecursionError
        data = tomllib.loads(text)
        if _depth(data) <= MAX_DEPTH:
            return data
        why = "lists or tables too deep inside of each other"
    except tomllib.TOMLDecodeError as reason:
        why = str(reason)
    except RecursionError:
        why = "lists or tables too deep inside of each other"
    except ValueError:  # Python reads no such integer
        why = "a number of thousands of digits"
    raise InputError(f"not TOML: {why}", f"{lines}, each key once", "correct the line; write names in quotation marks")


def _depth(data: dict[str, Any]) -> int:
    """How deep tables and lists are inside of each other; past `MAX_DEPTH` it is not counted on."""
    level: list[Any] = [data]
    depth = 0
    while level and depth <= MAX_DEPTH:
        depth += 1
        inner = [
            value_inside for value in level for value_inside in (value.values() if isinstance(value, dict) else value)
        ]
        level = [value_inside for value_inside in inner if isinstance(value_inside, dict | list)]
    return depth


# --- What case files and campaigns share: a file in TOML, and the lines of its keys.


MAX_TOML_BYTES = 5_000_000

_HEADER = re.compile(r"\s*(\[\[?)([\w.\s\"'-]+)\]\]?\s*(?:#.*)?$")
_KEY = re.compile(rf"\s*({_NAME}(?:\s*\.\s*{_NAME})*)\s*=")


@dataclass(frozen=True)
class TomlKind:
    """What messages about a file in TOML say: its name, what may be given instead, and advice for each fault."""

    name: str
    instead: str
    get_one: str
    lines: str
    too_large: str


@dataclass(frozen=True)
class TomlFile:
    """A file in TOML, its text, and the data in it."""

    file: Path
    text: str
    data: dict[str, Any]

    kind: ClassVar[TomlKind]

    @classmethod
    def read(cls, file: Path) -> Self:
        """Read a file; `InputError` if it cannot be read, is larger than `MAX_TOML_BYTES`, or is no TOML in UTF-8."""
        kind = cls.kind
        content = limited_bytes(file, MAX_TOML_BYTES, kind.too_large, kind.name, kind.instead, kind.get_one)
        with located(f"{file}: "):
            text = utf8_text(content)
            return cls(file, text, toml_data(text, kind.lines))

    def place(self, key: Key) -> str:
        """File and line of a key, in metric or US units, or of the nearest one above it, for the start of a message."""
        for end in range(len(key), 0, -1):
            in_us = us_key(str(key[end - 1]))
            for name in (key[end - 1], in_us.name if in_us else ""):
                line = self._lines.get((*key[: end - 1], name))
                if line is not None:
                    return f"{self.file}, line {line}: "
        return f"{self.file}: "

    @cached_property
    def _lines(self) -> dict[Key, int]:
        """Line of each table and key."""
        lines: dict[Key, int] = {}
        items: dict[Key, int] = {}
        table: Key = ()
        for number, row in enumerate(self.text.split("\n"), 1):
            if header := _HEADER.match(row):
                table = ()
                names = _names(header[2])
                for index, name in enumerate(names):
                    table = (*table, name)
                    if index == len(names) - 1 and header[1] == "[[":
                        items[table] = items.get(table, -1) + 1
                    if table in items:
                        table = (*table, items[table])
                lines.setdefault(table, number)
            elif key := _KEY.match(row):
                names = _names(key[1])
                for end in range(1, len(names) + 1):
                    lines.setdefault((*table, *names[:end]), number)
        return lines


def _names(dotted: str) -> list[str]:
    """Parts of a name with points between them; a point inside quotation marks is part of a name."""
    return [name.strip("\"'") for name in re.findall(_NAME, dotted)]
