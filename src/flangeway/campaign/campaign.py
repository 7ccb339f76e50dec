"""A campaign: one case over many inputs, from a TOML file, with the values that vary."""

import itertools
import math
import pickle
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import Field, create_model

from flangeway.cases.case import RunnableCase
from flangeway.cases.case_file import CASE_FILES, bodies_key, case_content, hash_of, is_case_file, read_case, resolved
from flangeway.errors import InputError, located, short
from flangeway.records import GivenText, Record, flattened, path_by_ending, require_known
from flangeway.system.file_content import TomlFile, TomlKind, csv_table, path_of
from flangeway.system.output_folder import versions
from flangeway.units import Units, metric_key

# --- Values of the inputs that vary: lists, ranges, and tables in CSV.


RANGE_KEYS = ("from", "to", "n", "step")
MAX_ROWS = 1_000_000
VALUES_ALLOWED = "a list such as [100, 150, 200], or a range such as { from = -7, to = 7, n = 141 }"
RangeTable: type[Record] = create_model(
    "RangeTable",
    __base__=Record,
    **{
        "from": (float, Field(description="first value")),
        "to": (float, Field(description="last value")),
        "n": (int | None, Field(None, ge=2, le=MAX_ROWS, description="number of values")),
        "step": (float | None, Field(None, description="distance of the values, instead of n")),
    },
)  # type: ignore[call-overload]
"""A range of values; its keys are words of Python."""


def values_of(key: str, given: Any, location: str) -> list[Any]:
    """Values of one input.

    An `InputError` if it is neither, or without values.

    - `given`: a list, or a range: a table with ``from``, ``to`` and ``n`` or ``step``.
    - `location`: file and line, before a message.
    """
    if isinstance(given, dict):
        return range_values(f"{location}vary.{key}", given)
    if not isinstance(given, list):
        raise InputError(
            f"{location}vary.{key} = {short(given)}", VALUES_ALLOWED, "put one value for all rows under [inputs]"
        )
    if not given:
        raise InputError(f"{location}vary.{key} = []", "one value or more", "give values, or leave the key out")
    if len(given) > MAX_ROWS:
        refuse_too_many(len(given), location)
    seen: set[bytes] = set()
    for value in given:
        # not as text, which Python refuses to write of whole numbers with thousands of digits
        written = pickle.dumps(value)
        if written in seen:
            raise InputError(f"{location}vary.{key} with {short(value)} twice", "each value once", "leave one out")
        seen.add(written)
    return given


def range_values(name: str, given: dict[str, Any]) -> list[float]:
    """Return the values of a range that a user gave under a name; an `InputError` if it is none."""
    limits = RangeTable.from_values(given, lambda _: f"{name}: ")
    low, high, number, step = (getattr(limits, name) for name in RANGE_KEYS)
    if (number is None) == (step is None):
        raise InputError(
            f"{name} = {short(given)}",
            "from, to, and one of n and step",
            "{ from = -7, to = 7, n = 141 } has 141 values",
        )
    steps = number - 1 if step is None else round((high - low) / step) if abs(step) * MAX_ROWS > abs(high - low) else 0
    if step is not None and not (
        1 <= steps < MAX_ROWS and math.isclose(low + steps * step, high, abs_tol=1e-9 * abs(step))
    ):
        raise InputError(
            f"{name}.step = {step:g}",
            f"a step that leads from {low:g} to {high:g}",
            "correct it, or give n instead",
        )
    if low == high:
        raise InputError(f"{name} from {low:g} to {high:g}", "two different ends", "put one value under [inputs]")
    # rounded, so that -7 to 7 has 0 and 0.1, not 1e-16 and 0.09999999999999964
    digits = 12 - math.ceil(math.log10(max(abs(low), abs(high))))
    return [round(low + (high - low) * i / steps, digits) + 0.0 for i in range(steps + 1)]


def grid(varied: Mapping[str, list[Any]], location: str) -> list[dict[str, Any]]:
    """All combinations, the last key fastest."""
    n_rows = math.prod(len(values) for values in varied.values())
    refuse_too_many(n_rows, location)
    return [dict(zip(varied, values, strict=True)) for values in itertools.product(*varied.values())]


def refuse_too_many(n_rows: int, location: str) -> None:
    """Refuse more rows than one campaign can have."""
    if n_rows > MAX_ROWS:
        raise InputError(f"{location}{n_rows} rows", f"up to {MAX_ROWS}", "make several campaigns of it")


def read_table(path: Path) -> list[dict[str, Any]]:
    """Rows of a CSV file with the names of inputs in its first line, all as text: 60E1 is a rail, not a number.

    An `InputError` as of `csv_table`, or if a cell is empty or there is no row.
    """
    rows = csv_table(path, "a CSV file with the names of inputs in its first line and a line for each row")
    if not rows:
        raise InputError(f"table {path} with 1 lines", "a line with names of inputs, and one for each row", "add rows")
    for number, row in rows:
        if "" in row.values():
            raise InputError(
                f"{path}, line {number}: an empty cell",
                f"{len(row)} values: {', '.join(row)}",
                "complete the line, or remove it",
            )
    return [{name: GivenText(cell) for name, cell in row.items()} for _, row in rows]


# --- A campaign: one case over many inputs, from a TOML file.


CAMPAIGN_FILE = TomlKind(
    name="campaign",
    instead="",
    get_one="correct the name",
    lines='lines such as case = "wheelset-tangent", tables such as [vary]',
    too_large="give many rows as a range, or as a table in a CSV file",
)

ROWS_OF_A_CHUNK = 48
"""Maximum number of positions in a chunk. Fixed: a table depends neither on workers nor on interruptions."""

MIN_IN_CHUNK = 12
"""Positions of the same bodies in a chunk, if there are as many: fewer waste the time to prepare the bodies."""


@dataclass(frozen=True)
class Row:
    """One run of a campaign.

    - `number`: its number in the campaign, from 1.
    - `varied`: the inputs that vary, as they are written in the campaign's file.
    - `case`: the case with all its inputs.
    """

    number: int
    varied: Mapping[str, Any]
    case: RunnableCase

    @cached_property
    def content(self) -> dict[str, Any]:
        """All inputs, files by their content: their folder does not matter."""
        return case_content(self.case)

    @cached_property
    def identity(self) -> str:
        """Hash of all inputs."""
        return hash_of(self.content)

    @cached_property
    def bodies(self) -> str:
        """Hash of the inputs that shape the bodies: rows that share it differ in position and load only."""
        return bodies_key(self.case)


def _columns(names: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    """Columns of several rows, each once."""
    return tuple(dict.fromkeys(name for several in dict.fromkeys(names) for name in several))


@dataclass(frozen=True)
class Campaign:
    """One case over many inputs; all rows are checked.

    Read one with `Campaign.from_file`.

    Parameters
    ----------
    name
        What it is called.
    case
        Type of the case.
    keys
        Inputs that vary, in their order.
    rows
        Rows in their order.
    columns
        Columns of results to export; empty: all.
    """

    name: str
    case: type[RunnableCase]
    keys: tuple[str, ...]
    rows: tuple[Row, ...]
    columns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.rows:
            raise InputError(f"campaign {self.name} without rows", "one row or more", "vary an input")
        seen: dict[str, int] = {}
        for row in self.rows:
            first = seen.setdefault(row.identity, row.number)
            if first != row.number:
                raise InputError(
                    f"campaign {self.name}: rows {first} and {row.number} with the same inputs",
                    "rows that differ, so that nothing is computed twice",
                    "leave one of them out",
                )

    @classmethod
    def from_file(cls, path: str | Path, *, units: Units | None = None) -> "Campaign":
        """Read a campaign's file and check all of it.

        Parameters
        ----------
        path
            A TOML file with the keys ``case`` and ``table`` and the tables ``[inputs]``, ``[vary]`` and ``[results]``.
        units
            Units of messages and results, instead of those of the file.

        Raises
        ------
        InputError
            If anything in it is wrong; the message names file, key, value, what is allowed and what to do.
        """
        return _CampaignText.read(path_of("Campaign.from_file", path)).campaign(units)

    @property
    def units(self) -> Units:
        """Units of its results; the database has metric ones."""
        return self.rows[0].case.units

    @property
    def identity(self) -> str:
        """Hash of all rows in their order, and of the version that computes them."""
        return hash_of([versions()["flangeway"], *(row.identity for row in self.rows)])

    @cached_property
    def known_columns(self) -> tuple[str, ...]:
        """Columns of its results that are known before they are computed."""
        return _columns(row.case.columns() for row in self.rows)

    @cached_property
    def patch_columns(self) -> tuple[str, ...]:
        """Columns of its table of patches."""
        return _columns(("row", "side", "number", *row.case.patch_columns()) for row in self.rows)

    @property
    def chunks(self) -> tuple[tuple[Row | None, tuple[Row, ...]], ...]:
        """Rows that are computed together, the same whoever computes them, after the row they are prepared for.

        Many positions of the same bodies are prepared for the first of all of them; other rows are computed alone and
        have None.
        """
        groups: dict[str, list[Row]] = {}
        for row in self.rows:
            groups.setdefault(row.bodies, []).append(row)
        chunks: list[tuple[Row | None, tuple[Row, ...]]] = []
        for group in groups.values():
            fewest = group[0].case.min_together
            together = fewest is not None and len(group) >= fewest
            size = min(max(math.ceil(len(group) / 8), MIN_IN_CHUNK), ROWS_OF_A_CHUNK) if together else 1
            first = group[0] if together else None
            chunks += [(first, tuple(group[start : start + size])) for start in range(0, len(group), size)]
        return tuple(chunks)


class ResultsTable(Record):
    """Which results are kept."""

    columns: list[str] = Field([])
    """names of columns of wheelsets (default: all)"""


class CampaignTables(Record):
    """Tables of the file."""

    case: str
    """a line such as case = "wheelset-tangent" at the top; `flangeway cases` lists the names"""
    table: str | None = None
    """CSV file with the names of inputs in its first line and a line for each row"""
    inputs: dict[str, Any] = Field({})
    """inputs of all rows"""
    vary: dict[str, Any] = Field({})
    """lists or ranges of the values of inputs, of which all combinations are rows"""
    results: ResultsTable = Field(default_factory=lambda: ResultsTable(columns=[]))
    """which results are kept"""

    @classmethod
    def called(cls) -> str:
        """See `Record.called`."""
        return "a campaign; those of its case belong under [inputs] or [vary]"


class _CampaignText(TomlFile):
    """A campaign's file."""

    kind = CAMPAIGN_FILE

    def campaign(self, units: Units | None) -> Campaign:
        tables = CampaignTables.from_values(self.data, self.place)
        case = self._case_name(tables.case)
        inputs = resolved(self, tables.inputs, self.file.parent.resolve(), ("inputs",))
        inputs = flattened(inputs)
        if units:
            inputs["units"] = units
        keys, varied = self._varied(tables)
        for key in keys:
            if key == "units":
                raise InputError(
                    f"{self._line('vary', key)}units that vary",
                    "one system of units for all rows",
                    "move it to [inputs]",
                )
            if key in inputs:
                raise InputError(
                    f"{self._line('vary', key)}{key} under [inputs] and varied", "one of both", f"remove one {key}"
                )
        rows = []
        for number, values in enumerate(varied, 1):
            row_case = self._case(case, inputs, values, number)
            rows.append(Row(number, {key: _read(row_case, key, value) for key, value in values.items()}, row_case))
        self._check(rows)
        kind = type(rows[0].case)
        return Campaign(self.file.stem, kind, keys, tuple(rows), self._columns(kind, rows, tables.results.columns))

    def _case_name(self, name: str) -> str:
        if name not in CASE_FILES and (is_case_file(name) or is_case_file(self.file.parent / name)):
            name = str((self.file.parent / name).resolve())
        with located(self.place(("case",))):
            read_case(name)
        return name

    def _varied(self, tables: CampaignTables) -> tuple[tuple[str, ...], list[dict[str, Any]]]:
        """Keys that vary, and their values row by row as they are written; the grid is inside of the table."""
        lists, table = flattened(tables.vary, RANGE_KEYS), tables.table
        if isinstance(lists.get("table"), str):  # the last line of a file belongs to its last table
            if table is not None:
                raise InputError(f"{self._line('vary', 'table')}table twice", "one table", "remove one of both")
            table = lists.pop("table")
        for key, given in lists.items():
            lists[key] = values_of(key, given, self._line("vary", key))
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
                    f"{self._line('vary', both[0])}{both[0]} under [vary] and in {table}", "one of both", "remove one"
                )
            refuse_too_many(len(read) * len(rows), f"{self.file}: ")
            keys = (*read[0], *keys)
            rows = [{**outer, **inner} for outer in read for inner in rows]
        return keys, rows

    def _case(self, name: str, inputs: dict[str, Any], varied: dict[str, Any], number: int) -> RunnableCase:
        try:
            return read_case(name, inputs | resolved(self, varied, self.file.parent.resolve(), ("vary",)))
        except InputError as reason:
            key = next((key for key in (*varied, *inputs) if _is_reported(key, reason.given)), "")
            location = self._line("vary" if key in varied else "inputs", key)
            if key in varied and key not in flattened(self.data.get("vary", {}), RANGE_KEYS):
                location = f"{self.file}, table: "
            row = f"row {number}: " if key in varied else ""
            raise InputError(location + row + reason.given, reason.allowed, reason.advice) from reason

    def _check(self, rows: list[Row]) -> None:
        """Check more than single values: whole cases once for all rows of the same bodies, loads of each."""
        seen: set[str] = set()
        for row in rows:
            given = ", ".join(f"{key} = {short(value)}" for key, value in row.varied.items())
            with located(f"{self.file}, row {row.number} ({given}): "):
                if row.bodies not in seen:
                    row.case.check()
                else:
                    row.case.check_position()
            seen.add(row.bodies)

    def _columns(self, kind: type[RunnableCase], rows: Sequence[Row], columns: Sequence[str]) -> tuple[str, ...]:
        known, location = _columns(row.case.columns() for row in rows), self._line("results", "columns")
        if columns and not known:
            raise InputError(
                f"{location}results.columns with case = {kind.name!r}",
                "columns of wheelsets",
                "leave it out: all are kept",
            )
        columns = [metric_key(name, known)[0] for name in columns]
        for name in columns:
            require_known(f"{location}results.columns", name, known)
        return tuple(columns)

    def _line(self, table: str, key: str) -> str:
        """File and line of a key in a table."""
        return self.place((table, *key.split(".")))


def _is_reported(key: str, message: str) -> bool:
    """Whether a message is about an input; inside tables it may have the number of the item: ``bodies[1].size_mm``."""
    table, _, name = key.rpartition(".")
    return bool(re.search(rf"\b{re.escape(key)}\b" + (rf"|\.{re.escape(name)}\b" if table else ""), message))


def _read(case: RunnableCase, key: str, value: Any) -> Any:
    """Return an input as the case took it: text of a table is a number where the case wants one."""
    if not isinstance(value, str):
        return value
    entry: Any = case
    for name in path_by_ending(type(case), key):
        if isinstance(entry, list | tuple):
            known = {str(number): item for number, item in enumerate(entry, 1)}
            entry = (known | {getattr(item, "name", None): item for item in entry}).get(name)
        elif isinstance(entry, Record):
            metric, unit = entry.input_named(name)
            entry = getattr(entry, metric, None)
            entry = unit.of(entry) if unit else entry
    return entry if isinstance(entry, float | int) else value
