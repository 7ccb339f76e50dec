"""What a report has from a case and the summary of its run; inputs as the text of a case file, and as tables."""

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from flangeway.cases.case import OF_REPORT, Case, Run, RunnableCase, table_in
from flangeway.cases.case_file import FORMAT
from flangeway.cases.case_template import toml_value, write_case_file
from flangeway.checks import is_number
from flangeway.quantities import measured
from flangeway.report.page.record import Again, Record
from flangeway.report.page.tables import SummaryTable
from flangeway.units import Units, in_us_units, unit_in, us_key

MAX_LETTERS = 60  # of a value on the page; longer ones are cut there, the case file has them whole


def run_record(run: Run, about_files: str, first: Sequence[str] = (), **own: Any) -> Record:
    """Return the record of a run: what every run has, and its own, see `Record`.

    - `about_files`: for `Again`.
    - `first`: inputs that the first page has in any case, before the essential ones and those that are not defaults.
    """
    case, summary = run.case, run.summary
    assert isinstance(case, RunnableCase)
    file = f"{case.name}.toml" if has_tables(case) else ""
    shared: dict[str, Any] = {
        "name": case.name,
        "title": case.title,
        "converged": run.status.converged,
        "message": run.status.message,
        "summary": summary,
        "again": Again(f"flangeway run {file}" if file else command_line(case), case_text(case), file, about_files),
        "units": case.units,
        "inputs": inputs_tables(case),
        "details": [*filter(None, (case.project, case.author)), case.date or date.today().isoformat()],
        "given": given_inputs(case, (*first, *case.essential)),
        "timings_s": summary["timings_s"],
    }
    fields = shared | own
    if case.report_title:
        fields |= {"title": case.report_title, "subtitle": f"{fields['title']}. " + fields["subtitle"]}
    return Record(**fields)


def given_inputs(case: Case, first: Sequence[str]) -> dict[str, str]:
    """Return values by meanings of some inputs, and of those that are not the defaults; without those inside tables."""
    fields, given = type(case).model_fields, {}
    changed = [key for key, field in fields.items() if getattr(case, key) != field.default]
    for key in dict.fromkeys([*first, *changed]):
        if key in OF_REPORT or table_in(fields[key].annotation) is not None:
            continue
        meaning = re.split(r"[;,(:]", fields[key].description or key)[0].strip()
        given[meaning] = _in_words(getattr(case, key), unit_in(key), case.units)
    return given


def _in_words(value: object, unit: str, units: Units) -> str:
    """Text of an input with its unit; of a file with the date of its content."""
    if is_number(value):
        return measured(float(value), unit, units, ".6g")  # type: ignore[arg-type]
    if isinstance(value, str) and Path(value).is_file():
        return f"{value}, file of {date.fromtimestamp(Path(value).stat().st_mtime).isoformat()}"
    return "not given" if value is None else _plain(value)


def case_text(case: RunnableCase) -> str:
    """Return a case file that computes a case again: every input that is set, with all digits, defaults too.

    Names of files are as given; a case file reads them from its own folder. Tables have the inputs that are not the
    defaults.
    """
    if has_tables(case):
        return write_case_file(case)
    lines = [f"flangeway = {FORMAT}", f"case = {toml_value(case.name)}"]
    for key in type(case).model_fields:
        value = getattr(case, key)
        if value is not None:
            lines.append(f"{key} = {toml_value(value)}")
    return "\n".join(lines) + "\n"


def inputs_tables(case: Case) -> list[SummaryTable]:
    """Inputs for the page: plain ones with their meanings, and those inside tables that are set, table by table."""
    fields = type(case).model_fields
    plain = {key: value for key, value in case.model_dump().items() if table_in(fields[key].annotation) is None}
    meanings = [fields[key].description or "" for key in plain]
    if case.units == "us":
        meanings = [*map(in_us_units, meanings)]
    rows = tuple((*row, meaning) for row, meaning in zip(input_rows(plain, case.units), meanings, strict=True))
    found = [SummaryTable("Inputs (units in the names)", ("", "value", "meaning"), rows, of_words=True)]
    for key, value in case.model_dump(exclude_defaults=True).items():
        if key not in plain:
            items = (
                {f"{key}[{number}]": item for number, item in enumerate(value, 1)}
                if isinstance(value, list)
                else {key: value}
            )
            for caption, item in items.items():
                table = SummaryTable(caption, ("", "value"), tuple(input_rows(item, case.units)), of_words=True)
                found.append(table)
    return found


def has_tables(case: Case) -> bool:
    """Whether a case has inputs inside of tables, which a command cannot give."""
    return any(table_in(field.annotation) is not None for field in type(case).model_fields.values())


def input_rows(item: Mapping[str, Any], units: Units, path: str = "") -> Iterator[tuple[str, str]]:
    """Keys and values of a table in a system of units, those of tables inside behind a point."""
    for key, value in item.items():
        if isinstance(value, Mapping):
            yield from input_rows(value, units, f"{path}{key}.")
        else:
            unit = us_key(key) if units == "us" else None
            yield f"{path}{unit.name if unit else key}", _plain(unit.of(value) if unit else value, 6 if unit else 10)


def _plain(value: object, digits: int = 10) -> str:
    if value is None:
        return "–"
    if isinstance(value, list | tuple | Mapping):
        text = toml_value(value)
        return text if len(text) <= MAX_LETTERS else f"{text[: MAX_LETTERS - 4]} ..."
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


OPTIONS = {
    "units": "--units",
    "method": "--method",
    "order": "--order",
    "size_scale": "--size-scale",
    "primary": "--primary",
    "crown_radius_in": "--crown-radius",
}
"""Inputs of a case with an option of their own; all others go through ``--set``."""


def command_line(case: RunnableCase) -> str:
    """Return the command that runs a case, with what differs from the defaults; cases with tables have none."""
    words = ["flangeway", "run", case.name]
    for key, field in type(case).model_fields.items():
        value = getattr(case, key)
        if value != field.default:
            text = value if isinstance(value, str) else toml_value(value)
            words += [OPTIONS[key], text] if key in OPTIONS else ["--set", f"{key}={text}"]
    return shlex.join(words)
