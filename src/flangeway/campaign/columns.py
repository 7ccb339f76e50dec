"""A row of a campaign: how it ended, and its numbers by columns."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from flangeway.cases.case import Run, RunnableCase
from flangeway.cases.summary import plain_numbers

Value = float | int | str | None


@dataclass(frozen=True)
class RowResult:
    """What one run gave.

    - `status`: ``converged``, ``not converged`` or ``failed``.
    - `message`: how it ended, in a sentence.
    - `warnings`: what limits it.
    - `values`: results by column, empty unless converged.
    - `patches`: patches by column, without the number of the row.
    - `seconds`: time that it took, its share of what is computed for several rows at once.
    """

    status: str
    message: str
    warnings: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    patches: tuple[Mapping[str, Value], ...] = ()
    seconds: float = 0.0


def row_of(case: RunnableCase, run: Run, seconds: float) -> RowResult:
    """Return the numbers of a run, which its case names."""
    message, warnings = run.status.message, tuple(case.warnings_of(run))
    if not run.status.converged:
        return RowResult("not converged", message, warnings, seconds=seconds)
    # None for what is not finite; SQLite knows neither
    patches = tuple(map(plain_numbers, case.patch_rows(run)))
    return RowResult("converged", message, warnings, plain_numbers(case.row(run)), patches, seconds)


def as_cell(value: Any) -> Value:
    """Return an input as it is stored: numbers and text as they are, tables and lists as JSON."""
    if isinstance(value, bool):
        return int(value)
    if value is None or isinstance(value, float | int | str):
        return value
    return json.dumps(value, ensure_ascii=False)
