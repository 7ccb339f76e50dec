"""Campaigns in TOML files."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flangeway.errors import InputError
from flangeway.study.campaign.campaign import Campaign, Row
from flangeway.study.campaign.columns import WHEELSET_COLUMNS
from flangeway.study.campaign.varying import VALUES_ALLOWED, flattened, grid, read_table, refuse_too_many, values_of
from flangeway.study.case import RunnableCase, closest, short
from flangeway.study.case_file import FILE_KEYS, is_case_file, read_case
from flangeway.study.wheelset_case import WheelsetCase

KEYS = ("case", "table", "inputs", "vary", "results")


def read_campaign(path: Path) -> Campaign:
    """See `Campaign.from_file`."""
    return _CampaignText.read(path).campaign()


@dataclass(frozen=True)
class _CampaignText:
    """A campaign's file.

    Parameters
    ----------
    file
        The file.
    text
        Its contents.
    data
        What it says.

    """

    file: Path
    text: str
    data: dict[str, Any]

    @classmethod
    def read(cls, file: Path) -> "_CampaignText":
        try:
            text = file.read_bytes().decode("utf-8-sig")
            return cls(file, text, tomllib.loads(text))
        except OSError as reason:
            raise InputError(
                f"campaign {file}: {reason.strerror or reason}", "a TOML file that can be read", "correct the name"
            ) from reason
        except (ValueError, RecursionError) as reason:  # what is no UTF-8 or no TOML is one of the former
            raise InputError(
                f"{file}: not TOML: {reason}",
                'lines such as case = "wheelset-tangent", tables such as [vary], each key once',
                "correct the place; names stand in quotation marks",
            ) from reason

    def campaign(self) -> Campaign:
        self._refuse_unknown()
        case = self._case_name()
        given: dict[str, Any] = self.data.get("inputs", {})
        if is_case_file(case):  # else tables are inputs of their own
            given = flattened(given)
        inputs = {key: self._resolved(key, value, "inputs") for key, value in given.items()}
        keys, varied = self._varied()
        for key in keys:
            if key in inputs:
                raise InputError(
                    f"{self.place('vary', key)}{key} under [inputs] and varied", "one of both", f"remove one {key}"
                )
        rows = []
        for number, values in enumerate(varied, 1):
            found = self._case(case, inputs, values, number)
            rows.append(Row(number, {key: _read(found, key, value) for key, value in values.items()}, found))
        self._check(rows)
        kind = type(rows[0].case)
        return Campaign(self.file.stem, kind, keys, tuple(rows), self._columns(kind))

    def _refuse_unknown(self) -> None:
        for key, value in self.data.items():
            if key not in KEYS:
                raise InputError(f"{self.place('', key)}{key}", f"the keys {', '.join(KEYS)}", self._advice(key))
            wanted: type = dict if key in ("inputs", "vary", "results") else str
            if not isinstance(value, wanted):
                allowed = "a name in quotation marks" if wanted is str else f"a table: [{key}] and its keys below"
                raise InputError(f"{self.place('', key)}{key} = {short(value)}", allowed, "correct it")
        if "case" not in self.data:
            raise InputError(
                f"{self.file}: no key case",
                'a line such as case = "wheelset-tangent" at the top',
                "add it; `flangeway cases` lists the names",
            )

    def _advice(self, key: str) -> str:
        near = closest(key, list(KEYS))
        return near if near.startswith("did") else f"inputs stand under [inputs] or [vary]: move {key} there"

    def _case_name(self) -> str:
        name = str(self.data["case"])
        if is_case_file(name) or is_case_file(self.file.parent / name):
            name = str((self.file.parent / name).resolve())
        try:
            read_case(name)
        except InputError as reason:
            raise self._placed(reason, self.place("", "case")) from reason
        return name

    def _varied(self) -> tuple[tuple[str, ...], list[dict[str, Any]]]:
        """Keys that vary, and their values row by row as they are written; the grid is inside of the table."""
        lists = flattened(self.data.get("vary", {}))
        table = self.data.get("table")
        if isinstance(lists.get("table"), str):  # the last line of a file belongs to its last table
            if table is not None:
                raise InputError(f"{self.place('vary', 'table')}table twice", "one table", "remove one of both")
            table = lists.pop("table")
        for key, given in lists.items():
            lists[key] = values_of(key, given, self.place("vary", key))
        if not lists and table is None:
            raise InputError(
                f"{self.file}: nothing varies", f"[vary] with {VALUES_ALLOWED}, or a table", "add one of them"
            )
        rows = grid(lists, f"{self.file}: ")
        keys = tuple(lists)
        if table is not None:
            read = read_table(self.file.parent / table)
            both = [key for key in read[0] if key in lists]
            if both:
                raise InputError(
                    f"{self.place('vary', both[0])}{both[0]} under [vary] and in {table}", "one of both", "remove one"
                )
            refuse_too_many(len(read) * len(rows), f"{self.file}: ")
            keys = (*read[0], *keys)
            rows = [{**outer, **inner} for outer in read for inner in rows]
        return keys, rows

    def _case(self, name: str, inputs: dict[str, Any], varied: dict[str, Any], number: int) -> RunnableCase:
        values = {key: self._resolved(key, value, "vary") for key, value in varied.items()}
        try:
            return read_case(name, {**inputs, **values})
        except InputError as reason:
            key = next((key for key in (*varied, *inputs) if re.search(rf"\b{re.escape(key)}\b", reason.given)), "")
            place = self.place("vary" if key in self.data.get("vary", {}) else "inputs", key)
            if key in varied and key not in self.data.get("vary", {}):
                place = f"{self.file}, table: "
            row = f"row {number}: " if key in varied else ""
            raise self._placed(reason, f"{place}{row}") from reason

    def _check(self, rows: list[Row]) -> None:
        """Check what goes beyond single values: whole cases once for all rows of the same bodies, loads of each."""
        seen: set[str] = set()
        for row in rows:
            try:
                if row.bodies not in seen:
                    row.case.check()
                elif isinstance(row.case, WheelsetCase):
                    row.case.load()
            except InputError as reason:
                given = ", ".join(f"{key} = {short(value)}" for key, value in row.varied.items())
                raise self._placed(reason, f"{self.file}, row {row.number} ({given}): ") from reason
            seen.add(row.bodies)

    def _resolved(self, key: str, value: Any, table: str) -> Any:
        """Make the name of a file independent of the current folder."""
        if key.rpartition(".")[2] not in FILE_KEYS or not isinstance(value, str):
            return value
        path = self.file.parent / value
        if path.is_file():
            return str(path.resolve())
        if "/" in value or re.search(r"\.\w{2,5}$", value):
            raise InputError(
                f"{self.place(table, key)}{key} = {short(value)}: there is no such file",
                f"a file, its path relative to the folder {self.file.parent.resolve()}",
                "correct the path, or copy the file there",
            )
        return value

    def _columns(self, kind: type[RunnableCase]) -> tuple[str, ...]:
        given = self.data.get("results", {})
        for key in given:
            if key != "columns":
                raise InputError(f"{self.place('results', key)}results.{key}", "columns", closest(key, ["columns"]))
        columns = given.get("columns", [])
        place = self.place("results", "columns")
        if not isinstance(columns, list) or not all(isinstance(name, str) for name in columns):
            raise InputError(f"{place}results.columns = {short(columns)}", "a list of names", "leave it out for all")
        if columns and not issubclass(kind, WheelsetCase):
            raise InputError(
                f"{place}results.columns with case = {kind.name!r}",
                "columns of wheelsets",
                "leave it out: all are kept",
            )
        for name in columns:
            if name not in WHEELSET_COLUMNS:
                raise InputError(
                    f"{place}results.columns with {name!r}",
                    ", ".join(WHEELSET_COLUMNS),
                    closest(name, list(WHEELSET_COLUMNS)),
                )
        return tuple(columns)

    @staticmethod
    def _placed(reason: InputError, place: str) -> InputError:
        return InputError(f"{place}{reason.given}", reason.allowed, reason.advice)

    def place(self, table: str, key: str) -> str:
        """File and line of a key, to stand before a message."""
        for number, found, name in self._lines():
            if found == table and name == key:
                return f"{self.file}, line {number}: "
        return f"{self.file}: "

    def _lines(self) -> Iterator[tuple[int, str, str]]:
        table = ""
        for number, row in enumerate(self.text.splitlines(), 1):
            if header := re.match(r"\s*\[\s*([\w-]+)\s*\]", row):
                table = header[1]
                yield number, "", table
            elif key := re.match(r"""\s*["']?([\w.-]+)["']?\s*=""", row):
                yield number, table, key[1]


def _read(case: RunnableCase, key: str, value: Any) -> Any:
    """Return an input as the case took it: text of a table is a number where the case wants one."""
    if not isinstance(value, str):
        return value
    found: Any = case
    for name in key.split("."):
        if isinstance(found, list | tuple):
            known = {str(number): item for number, item in enumerate(found, 1)}
            found = (known | {getattr(item, "name", None): item for item in found}).get(name)
        else:
            found = getattr(found, name, None)
    return found if isinstance(found, float | int) else value
