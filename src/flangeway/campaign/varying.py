"""Values of the inputs that vary: lists, ranges, and tables in CSV."""

import itertools
import math
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field, create_model

from flangeway.cases.case import GivenText, Table
from flangeway.errors import InputError, short
from flangeway.system.file_content import csv_table

RANGE_KEYS = ("from", "to", "n", "step")
MAX_ROWS = 1_000_000
VALUES_ALLOWED = "a list such as [100, 150, 200], or a range such as { from = -7, to = 7, n = 141 }"
RangeTable: type[Table] = create_model(
    "RangeTable",
    __base__=Table,
    **{
        "from": (float, Field(description="first value")),
        "to": (float, Field(description="last value")),
        "n": (int | None, Field(None, ge=2, le=MAX_ROWS, description="number of values")),
        "step": (float | None, Field(None, description="distance of the values, instead of n")),
    },
)  # type: ignore[call-overload]
"""A range of values; its keys are words of Python."""


def flattened(values: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return inputs inside tables by their paths, ``bodies.disc.size_mm``; ranges stay tables."""
    by_path: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict) and value and not set(value) & set(RANGE_KEYS):
            by_path |= flattened(value, f"{above}{key}.")
        else:
            by_path[f"{above}{key}"] = value
    return by_path


def values_of(key: str, given: Any, place: str) -> list[Any]:
    """Values of one input.

    An `InputError` if it is neither, or without values.

    - `given`: a list, or a range: a table with ``from``, ``to`` and ``n`` or ``step``.
    - `place`: file and line, before a message.
    """
    if isinstance(given, dict):
        return range_values(f"{place}vary.{key}", given)
    if not isinstance(given, list):
        raise InputError(
            f"{place}vary.{key} = {short(given)}", VALUES_ALLOWED, "put one value for all rows under [inputs]"
        )
    if not given:
        raise InputError(f"{place}vary.{key} = []", "one value or more", "give values, or leave the key out")
    if len(given) > MAX_ROWS:
        refuse_too_many(len(given), place)
    seen: set[bytes] = set()
    for value in given:
        # not as text, which Python refuses to write of whole numbers with thousands of digits
        written = pickle.dumps(value)
        if written in seen:
            raise InputError(f"{place}vary.{key} with {short(value)} twice", "each value once", "leave one out")
        seen.add(written)
    return given


def range_values(name: str, given: dict[str, Any]) -> list[float]:
    """Return the values of a range that a user gave under a name; an `InputError` if it is none."""
    limits = RangeTable.from_values(given, lambda _: f"{name}: ")
    low, high, number, step = (getattr(limits, each) for each in RANGE_KEYS)
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


def grid(varied: Mapping[str, list[Any]], place: str) -> list[dict[str, Any]]:
    """All combinations, the last key fastest."""
    n_rows = math.prod(len(values) for values in varied.values())
    refuse_too_many(n_rows, place)
    return [dict(zip(varied, values, strict=True)) for values in itertools.product(*varied.values())]


def refuse_too_many(n_rows: int, place: str) -> None:
    """Refuse more rows than one campaign can have."""
    if n_rows > MAX_ROWS:
        raise InputError(f"{place}{n_rows} rows", f"up to {MAX_ROWS}", "make several campaigns of it")


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
