"""What a campaign found, and the files that it leaves beside its database."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from flangeway.campaign import CampaignProgress, CampaignTable
from flangeway.campaign.database import export_writers
from flangeway.quantities import Quantity, measured
from flangeway.railway.track.placements import SIDES
from flangeway.report.campaign_figures import FORCES, LOCUS, PRESSURE, PRESSURE_MAP, RATIO, campaign_figures
from flangeway.report.page.html_page import input_rows
from flangeway.report.page.record import Again, Picture, Report, SummaryTable, named
from flangeway.system.output_folder import versions, write_together
from flangeway.units import Units

DATABASE = "campaign.sqlite"
MAX_REASONS, MAX_WARNINGS = 10, 3  # reasons and lines of the table of results, and warnings
FIRST = ("_max_pressure_MPa", "_lateral_over_vertical", "_normal_force_kN", "_contact_angle_deg")
SHOWN = {
    LOCUS: "Contact points against the varied input; dots sized by force",
    PRESSURE_MAP: "Maximum pressure over two inputs",
    PRESSURE: "Maximum pressure against the varied input",
    RATIO: "L/V of both wheels against the varied input",
    FORCES: "Normal, lateral and vertical forces of both wheels against the varied input",
}
NUMBER = r"[-+]?\d[\d,.]*(?:e[-+]?\d+)?"
"""Regular expression of a number in a warning."""
MAX_NUMBERS = 8
LARGER_UNITS = {"N": ("kN", 1e-3), "rad": ("mrad", 1e3)}
"""Units in which the page has forces and angles, with their factors."""
ROUND_OFF = 1e-9  # a column of lengths, forces, pressures or angles below it is zero
MAX_DECIMALS = 7


def write_export(table: CampaignTable, folder: Path, kind: str, units: Units = "metric") -> list[Path]:
    """Write the tables of a campaign as CSV, in some units, or as Parquet, together or not at all."""
    return write_together(folder, export_writers(table, kind, units))


def campaign_record(
    end: CampaignProgress,
    table: CampaignTable,
    kind: str,
    command: str,
    seconds: float,
    units: Units = "metric",
) -> Report:
    """Return what a finished campaign found; its tables are written as CSV and as `kind`.

    - `command`: runs it again.
    - `seconds`: how long it took.
    """
    counts = {status: number for status, number in end.counts.items() if number}
    failures = sorted(table.failures().items(), key=lambda failure: -len(failure[1]))
    warned: dict[str, int] = {}
    for text in table.rows["warnings"]:
        for warning in json.loads(str(text or "[]")):
            warned[warning] = warned.get(warning, 0) + 1
    files = "every row is in `results.csv`, every contact in `patches.csv`, all of it in `campaign.sqlite`"
    ranges = _ranges(table)
    shown = tuple(_shown_range(name, values, units) for name, values in ranges)
    return Report(
        name=table.name,
        title=f"{table.name}: a campaign of {table.case}",
        subtitle=f"{end.n_rows} runs of case {table.case!r}; varied: {', '.join(table.keys) or 'nothing'}",
        converged=end.all_converged,
        message=", ".join(f"{number} {status}" for status, number in counts.items()),
        facts=[(f"{number}", f"rows {status}") for status, number in counts.items()] + _extremes(table, units),
        results=SummaryTable(
            "Range of the results over all rows", ("", "minimum", "median", "maximum"), shown[:MAX_REASONS]
        ),
        summary={
            "campaign": table.name,
            "case": table.case,
            "rows": end.n_rows,
            "counts": counts,
            "varied": list(table.keys),
            "inputs": table.inputs,
            "failures": [{"status": s, "message": m, "rows": rows} for (s, m), rows in failures],
            "warnings": warned,
            "ranges": {
                name: dict(zip(("minimum", "median", "maximum"), values, strict=True)) for name, values in ranges
            },
            "versions": versions(),
        },
        again=Again(command, files=f"A campaign goes on where it stopped; {files}."),
        units=units,
        warnings=_warnings(failures, warned),
        pictures=lambda: [
            Picture(name, draw, f"{SHOWN[name]}.") for name, draw in campaign_figures(table, units).items()
        ],
        tables=[SummaryTable("Further results", ("", "minimum", "median", "maximum"), shown[MAX_REASONS:])]
        if len(ranges) > MAX_REASONS
        else [],
        inputs=[
            SummaryTable(
                "Inputs of the first row",
                ("", "value"),
                tuple(input_rows(table.inputs, units)),
                of_words=True,
            )
        ],
        timings_s={"total": seconds},
        files=lambda: export_writers(table, "csv", units) | (export_writers(table, kind) if kind != "csv" else {}),
    )


def _warnings(failures: Sequence[tuple[tuple[str, str], Sequence[int]]], warned: Mapping[str, int]) -> list[str]:
    """Sentences on the most frequent reasons of failures and warnings, and how many others there are."""
    warnings = [
        f"{len(rows)} {status}: {message}; rows {_numbers(rows)}" for (status, message), rows in failures[:MAX_REASONS]
    ]
    if len(failures) > MAX_REASONS:
        warnings.append(f"{len(failures) - MAX_REASONS} other reasons: column message of results.csv")
    alike: dict[str, list[tuple[str, int]]] = {}  # warnings that differ in numbers only
    for text, n in warned.items():
        alike.setdefault(re.sub(NUMBER, "", text), []).append((text, n))
    kinds = sorted(alike.values(), key=lambda rows_of_kind: -sum(n for _, n in rows_of_kind))
    for kind in kinds[:MAX_WARNINGS]:
        n = sum(count for _, count in kind)
        numbers = ", numbers of the first" * (len(kind) > 1)
        warnings.append(f"in {n} row{'s' * (n != 1)}{numbers}: {kind[0][0]}")
    if len(kinds) > MAX_WARNINGS:
        warnings.append(f"{len(kinds) - MAX_WARNINGS} others: column warnings of results.csv")
    return warnings


def _ranges(table: CampaignTable) -> list[tuple[str, list[float]]]:
    """Name, and minimum, median and maximum, of every column of results that are numbers."""
    ranges = []
    for name, values in table.rows.items():
        known = [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
        if name in ("row", *table.keys) or not known or any(isinstance(value, str) for value in values):
            continue
        ranges.append((name, [min(known), median(known), max(known)]))
    return sorted(ranges, key=lambda row: next((i for i, end in enumerate(FIRST) if row[0].endswith(end)), len(FIRST)))


def _shown_range(key: str, values: list[float], units: Units) -> tuple[str, ...]:
    """Words and unit of a column of results, and its numbers with as many digits as the largest needs."""
    side, _, rest = key.partition("_")
    words, unit = named(rest if side in SIDES else key)
    unit, factor = LARGER_UNITS.get(unit, (unit, 1.0))
    numbers = [factor * value for value in values]
    size = max(map(abs, numbers))
    if unit and size < ROUND_OFF:
        size, numbers = 0.0, [0.0] * len(numbers)
    decimals = 0 if all(isinstance(value, int) for value in values) or not size else 4 - math.floor(math.log10(size))
    form = f".{max(decimals, 0)}f" if decimals <= MAX_DECIMALS else ".3g"
    words = f"{side}: {words}" if side in SIDES else words
    of: Quantity[Any] = Quantity(key, words, lambda value: value, unit, form)
    return *of.labels(units), *(text for value in numbers for text in of.texts(float(value), units))


def _extremes(table: CampaignTable, units: Units) -> list[tuple[str, str]]:
    """Maximum pressure and L/V of all rows."""
    facts = []
    for key, words, unit, form in (
        ("max_pressure_MPa", "pressure", "MPa", ".0f"),
        ("lateral_over_vertical", "L/V", "", ".3f"),
    ):
        columns = (table.rows[f"{side}_{key}"] for side in SIDES if f"{side}_{key}" in table.rows)
        values = [value for column in columns for value in column if value is not None]
        if values:
            facts.append((measured(float(max(values)), unit, units, form), f"maximum {words} of all rows"))
    return facts


def _numbers(rows: Sequence[int]) -> str:
    shown = ", ".join(str(row) for row in rows[:MAX_NUMBERS])
    return shown if len(rows) <= MAX_NUMBERS else f"{shown}, and {len(rows) - MAX_NUMBERS} more"
