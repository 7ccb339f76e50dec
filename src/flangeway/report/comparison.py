"""Two runs beside each other: inputs and numbers that differ, by the paths that ``summary.json`` has."""

import json
from pathlib import Path
from typing import Any

from flangeway.checks import is_number
from flangeway.errors import InputError
from flangeway.quantities import MISSING, plain_text
from flangeway.records import key_text, leaves
from flangeway.report.page.record import SUMMARY, Again, Report, SummaryTable
from flangeway.system.file_content import file_content

NOT_COMPARED = ("status", "residual", "timings_s", "peak_memory_MB", "versions", "assumptions", "warnings", "notices")
"""What says how a run went, not what it found."""
SAME = 1e-9
"""Relative difference up to which numbers are the same."""


def comparison_record(first: Path, second: Path, command: str) -> Report:
    """Return what differs between two runs: their inputs, and each number with its change.

    Parameters
    ----------
    first, second
        Folders of results, or the JSON files in them.
    command
        Compares them again.

    Raises
    ------
    InputError
        If there are no such files, they are no results of runs, or of different kinds of cases.

    """
    summaries = [_read(path) for path in (first, second)]
    kinds = [str(summary["case"].get("name")) for summary in summaries]
    if kinds[0] != kinds[1]:
        raise InputError(f"a run of {kinds[0]} and one of {kinds[1]}", "two runs of one kind of case", "compare others")
    values = [{key_text(key): value for key, value in leaves(_compared(summary))} for summary in summaries]
    paths = [path for path in dict.fromkeys([*values[0], *values[1]]) if not _same(*(of.get(path) for of in values))]
    rows = [_row(path, values[0].get(path), values[1].get(path)) for path in paths]
    n_inputs = sum(path.startswith("case.") for path in paths)
    statuses = [summary["status"] for summary in summaries]
    return Report(
        name=f"{first} and {second}",
        title="Two runs compared",
        subtitle=f"First: {first}. Second: {second}. {n_inputs} inputs and {len(rows) - n_inputs} results differ.",
        converged=all(status["converged"] for status in statuses),
        message="; ".join(status["message"] for status in statuses if not status["converged"]),
        results=SummaryTable("What differs", ("", "first", "second", "change", "change, %"), tuple(rows)),
        summary={path: dict(zip(("first", "second"), (of.get(path) for of in values), strict=True)) for path in paths},
        summary_file="compare.json",
        again=Again(command, files="The same, for programs, is in `compare.json`."),
    )


def _read(path: Path) -> dict[str, Any]:
    """Return the summary of a folder of results, or of its file."""
    file = path / SUMMARY if path.is_dir() else path
    try:
        summary = json.loads(file_content(file, "results"))
    except ValueError:
        summary = None
    if not isinstance(summary, dict) or not {"case", "status"} <= summary.keys():
        raise InputError(f"{file} without case and status", f"{SUMMARY} of a run", "give the folder of its results")
    return summary


def _compared(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if key not in NOT_COMPARED}


def _same(first: Any, second: Any) -> bool:
    if is_number(first) and is_number(second):
        return bool(abs(second - first) <= SAME * max(abs(first), abs(second)))
    return bool(first == second)


def _row(path: str, first: Any, second: Any) -> tuple[str, ...]:
    """Both values; of numbers the change, and that over the first value."""
    texts = tuple(
        MISSING if value is None else plain_text(value, ".6g") if type(value) is float else str(value)
        for value in (first, second)
    )
    if not (is_number(first) and is_number(second)):
        return path, *texts, "", ""
    change = second - first
    return path, *texts, f"{change:+.3g}", plain_text(100.0 * change / abs(first), "+.2f") if first else MISSING
