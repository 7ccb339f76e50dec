"""Summaries of runs: plain numbers with their units in the names, and the one way into ``summary.json``."""

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from flangeway.results import Result, ResultTable
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions

PAIRS = ("longer", "shorter")
ENDINGS = {"cells": ("across", "along"), "semi_axes_mm": PAIRS, "hertz_semi_axes_mm": PAIRS}
"""Endings of the columns of lists that are not x, y and z."""


@dataclass(frozen=True)
class SummaryPart:
    """Part of a summary: arrays and NumPy's numbers become Python's own, what is not finite becomes None."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            object.__setattr__(self, name, plain_numbers(value))


@dataclass(frozen=True)
class StatusSummary(SummaryPart):
    """How a run ended."""

    converged: bool
    message: str


@dataclass(frozen=True, kw_only=True)
class Summary(SummaryPart):
    """What every summary has."""

    status: StatusSummary  # how the run ended
    case: dict[str, Any]  # name and inputs
    timings_s: dict[str, float]  # seconds of each stage and in total
    peak_memory_MB: float = field(default_factory=lambda: peak_memory_bytes() / 1e6)  # noqa: N815 (the unit)
    versions: dict[str, str] = field(default_factory=versions)
    parts: dict[str, Any] = field(default_factory=dict)  # the numbers of this kind of case, by their keys

    def to_dict(self) -> dict[str, Any]:
        """Return what ``summary.json`` holds: strings, booleans, ints, floats, None, lists and dictionaries."""
        content = dataclasses.asdict(self)
        return content | content.pop("parts")


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
    def summary(self) -> Summary:
        """What ``summary.json`` holds."""
        return Summary(
            status=StatusSummary(self.status.converged, self.status.message),
            case={"name": self.case.name, **self.case.model_dump()},
            timings_s=dict(self.timings_s),
            parts=self.parts(),
        )

    @property
    def tables(self) -> dict[str, ResultTable]:
        """Tables by the names that their rows have in ``summary.json``."""
        rows = self.summary.to_dict().items()
        return {
            name: ResultTable.of_rows(each, ENDINGS)
            for name, each in rows
            if isinstance(each, list) and each and isinstance(each[0], dict)
        }

    @property
    def table(self) -> ResultTable:
        """The table that it is about."""
        return self.tables.get(self.main_table, ResultTable({}))


NO_RESULTS = ("timings_s", "peak_memory_MB", "case", "versions", "status")
"""Parts of summaries that are no result of a row, or depend on the machine and on what it computed before."""


def summary_numbers(summary: Summary) -> dict[str, Any]:
    """Return all single numbers of a summary, and remarks on them, named by their paths with underscores."""
    content = summary.to_dict()
    return dict(_numbers({key: part for key, part in content.items() if key not in NO_RESULTS}, ""))


def _numbers(value: Any, path: str) -> Iterable[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _numbers(inner, f"{path}_{key}" if path else str(key))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value, 1):
            yield from _numbers(inner, f"{path}_{number}")
    elif isinstance(value, float | int) or (value is not None and path.endswith("_remark")):
        yield path, value


def summary_text(summary: Summary | Mapping[str, Any]) -> str:
    """Return a summary as JSON."""
    content = summary.to_dict() if isinstance(summary, Summary) else summary
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_summary(path: Path, summary: Summary | Mapping[str, Any]) -> None:
    """Write a summary as JSON."""
    path.write_text(summary_text(summary), encoding="utf-8")


def plain_numbers(value: Any) -> Any:
    """Turn arrays and NumPy's numbers into lists and Python's own; what is not finite into None."""
    if isinstance(value, dict):
        return {key: plain_numbers(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain_numbers(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
