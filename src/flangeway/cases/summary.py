"""Summaries of runs, the content of ``summary.json``: plain numbers with their units in the keys."""

import json
import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

from flangeway.records import leaves
from flangeway.results import Result, ResultTable
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.output_folder import versions
from flangeway.types import Key

# --- Values inside tables and lists.


def mapped(value: Any, function: Callable[[Key, Any], Any], key: Key = ()) -> Any:
    """Return tables and lists with a function of path and value in the place of each value in them."""
    if isinstance(value, Mapping):
        return {name: mapped(inner, function, (*key, name)) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [mapped(inner, function, (*key, number)) for number, inner in enumerate(value)]
    return function(key, value)


# --- Summaries of runs, the content of ``summary.json``: plain numbers with their units in the names.


PAIRS = ("longer", "shorter")
ENDINGS = {"cells": ("across", "along"), "semi_axes_mm": PAIRS, "hertz_semi_axes_mm": PAIRS}
"""Endings of the columns of lists that are not x, y and z."""


class RunResult(Result):
    """What a run of a case returns; its tables are those of its summary."""

    main_table: ClassVar[str]  # name of the table that it is about
    case: Any  # the inputs
    status: Any  # how it ended
    timings_s: Any  # seconds by stage

    def parts(self) -> dict[str, Any]:
        """Return the numbers of this kind of run, as ``summary.json`` has them."""
        raise NotImplementedError

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What ``summary.json`` holds, made of Python's own types; what is not finite is None."""
        common = {
            "status": {"converged": self.status.converged, "message": self.status.message},
            "case": {"name": self.case.name, **self.case.model_dump()},
            "timings_s": dict(self.timings_s),
            "peak_memory_MB": peak_memory_bytes() / 1e6,
            "versions": versions(),
        }
        content: dict[str, Any] = plain_numbers(common | self.parts())
        return content

    @property
    def tables(self) -> dict[str, ResultTable]:
        """Tables by the names that their rows have in ``summary.json``."""
        return {
            name: ResultTable.of_rows(rows, ENDINGS)
            for name, rows in self.summary.items()
            if isinstance(rows, list) and rows and isinstance(rows[0], dict)
        }

    @property
    def table(self) -> ResultTable:
        """The table that it is about."""
        return self.tables.get(self.main_table, ResultTable({}))


NO_RESULTS = ("timings_s", "peak_memory_MB", "case", "versions", "status")
"""Parts of summaries that are no result of a row, or depend on the machine and on what it computed before."""


def summary_numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return all single numbers of a summary, and remarks on them, named by their paths with underscores."""
    numbers = {}
    for key, value in leaves({name: part for name, part in summary.items() if name not in NO_RESULTS}):
        path = "_".join(str(name + 1) if isinstance(name, int) else str(name) for name in key)
        if isinstance(value, float | int) or (value is not None and path.endswith("_remark")):
            numbers[path] = value
    return numbers


def summary_text(summary: Mapping[str, Any]) -> str:
    """Return a summary as JSON."""
    return json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def plain_numbers(value: Any) -> Any:
    """Turn arrays and NumPy's numbers into lists and Python's own; what is not finite into None."""

    def plain(_: Key, leaf: Any) -> Any:
        if hasattr(leaf, "tolist"):
            return plain_numbers(leaf.tolist())
        return None if isinstance(leaf, float) and not math.isfinite(leaf) else leaf

    return mapped(value, plain)
