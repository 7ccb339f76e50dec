"""Summaries of runs: plain numbers with their units in the names, and the one way into ``summary.json``."""

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions


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

    def to_dict(self) -> dict[str, Any]:
        """Return what ``summary.json`` holds: strings, booleans, ints, floats, None, lists and dictionaries."""
        return dataclasses.asdict(self)


def write_summary(path: Path, summary: Summary | Mapping[str, Any]) -> None:
    """Write a summary as JSON."""
    content = summary.to_dict() if isinstance(summary, Summary) else summary
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


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
