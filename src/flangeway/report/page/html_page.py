"""The report, one HTML page with all pictures inside that needs no network, and what it says of a case."""

import base64
import re
import shlex
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import date
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, get_origin

import numpy as np
from jinja2 import Template
from markupsafe import Markup, escape
from pydantic.fields import FieldInfo

from flangeway.cases import Convergence
from flangeway.cases.case import OF_REPORT, Case, RunnableCase
from flangeway.cases.case_file import toml_value, write_case_file
from flangeway.cases.summary import RunResult, mapped, summary_text
from flangeway.checks import is_number
from flangeway.quantities import measured, plain_text
from flangeway.records import alternatives, are_tables, entries_of, records_in
from flangeway.report.page.record import REPORT, Again, Picture, Report, SummaryTable, timings_table
from flangeway.report.viewer import field_viewer
from flangeway.results import ResultTable
from flangeway.system.output_folder import bytes_writer, text_writer, write_together
from flangeway.system.templates import templates
from flangeway.system.workbook import csv_tables, write_workbook
from flangeway.types import Progress
from flangeway.units import Units, unit_in, us_key

# --- What a report has from a case and the summary of its run; inputs as the text of a case file, and as tables.


MESH_OPTIONS = ("method", "order", "size_scale")
MAX_LETTERS = 60  # of a value on the page; longer ones are cut there, the case file has them whole


def run_record(run: RunResult, about_files: str, first: Sequence[str] = (), **own: Any) -> Report:
    """Return the record of a run: what every run has, and its own, see `Report`.

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
        "again": Again(
            f"flangeway run {file}" if file else command_line(case), write_case_file(case), file, about_files
        ),
        "units": case.units,
        "inputs": inputs_tables(case),
        "details": [*filter(None, (case.project, case.author)), case.date or date.today().isoformat()],
        "given": given_inputs(case, (*first, *case.essential)),
        "timings_s": summary["timings_s"],
    }
    fields = shared | own
    if case.report_title:
        fields |= {"title": case.report_title, "subtitle": f"{fields['title']}. " + fields["subtitle"]}
    return Report(**fields)


def given_inputs(case: Case, first: Sequence[str]) -> dict[str, str]:
    """Return values by meanings of some inputs, by their paths, and of those that are not the defaults.

    Those of lists of tables are left out.
    """
    given, entries = dict[str, str](), {entry.name: entry for entry in entries_of(case)}
    changed = [name for name, entry in entries.items() if not entry.is_default]
    for name in dict.fromkeys([*first, *changed]):
        entry = entries.get(name)
        if entry is None or name in OF_REPORT or are_tables(entry.field.annotation):
            continue
        meaning = re.split(r"[;,(:]", entry.field.description or name)[0].strip()
        given[meaning] = _in_words(entry.value, unit_in(entry.path[-1]), case.units)
    return given


def _in_words(value: object, unit: str, units: Units) -> str:
    """Text of an input with its unit; of a file with the date of its content."""
    if is_number(value):
        return measured(float(value), unit, units, ".6g")  # type: ignore[arg-type]
    if isinstance(value, str) and Path(value).is_file():
        return f"{value}, file of {date.fromtimestamp(Path(value).stat().st_mtime).isoformat()}"
    return "not given" if value is None else _plain(value)


def inputs_tables(case: Case) -> list[SummaryTable]:
    """Inputs for the page with their meanings, and tables of lists that are set, table by table."""
    rows, tables = [], []
    for entry in entries_of(case):
        if not has_list(entry.field):
            row = next(input_rows({entry.path[-1]: entry.value}, case.units, "".join(f"{n}." for n in entry.path[:-1])))
            rows.append((*row, entry.field.description or ""))
            continue
        dumped = case.changed.get(entry.path[0], [])
        items = enumerate(dumped, 1) if isinstance(dumped, list) else dumped.items()
        for number, item in items:
            cells = tuple(input_rows(item, case.units))
            tables.append(SummaryTable(f"{entry.name}[{number}]", ("", "value"), cells, of_words=True))
    columns = ("", "value", "meaning")
    return [SummaryTable("Inputs (units in the names)", columns, tuple(rows), of_words=True), *tables]


def has_list(field: FieldInfo) -> bool:
    """Whether an input is a list of tables, or tables by names."""
    return any(get_origin(kind) in (list, dict) and records_in(kind) for kind in alternatives(field.annotation))


def has_tables(case: Case) -> bool:
    """Whether a case has inputs inside of lists of tables, which a command cannot give."""
    return any(has_list(field) for field in type(case).model_fields.values())


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
        rounded = mapped(value, lambda _, one: float(f"{one:.{digits}g}") if isinstance(one, float) else one)
        text = toml_value(rounded)
        if len(text) > MAX_LETTERS and isinstance(rounded, list):  # in any units the same items
            text = f"{toml_value(rounded[:2])[:-1]}, ...]"
        return text if len(text) <= MAX_LETTERS else f"{text[: MAX_LETTERS - 4]} ..."
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


OPTIONS = {
    "units": "--units",
    "wheelset.wheel": "--wheel",
    "track.rail": "--rail",
    "contact.primary": "--primary",
    **{f"{above}{key}": f"--{key.replace('_', '-')}" for above in ("", "mesh.") for key in MESH_OPTIONS},
}
"""Inputs of a case with an option of their own; all others go through ``--set``."""


def command_line(case: RunnableCase) -> str:
    """Return the command that runs a case without lists of tables, with what differs from the defaults."""
    words = ["flangeway", "run", case.name]
    for entry in entries_of(case):
        if not entry.is_default:
            text = entry.value if isinstance(entry.value, str) else toml_value(entry.value)
            words += [OPTIONS[entry.name], text] if entry.name in OPTIONS else ["--set", f"{entry.name}={text}"]
    return shlex.join(words)


# --- The report, one HTML page with all pictures inside that needs no network, and the other files of a record.


PAGE_LETTERS, HALF_LETTERS, BESIDE_LETTERS = 98, 48, 64
"""Letters beside each other on A4, on half of it (widest usual font, 0.64 em, 8 pt), and beside a picture."""
LABEL_LETTERS, SHORT_LETTERS, GAP_LETTERS = 24, 12, 2
"""Letters of a line of row names, of cells that do not break, and between columns."""
SHOWN_SIZE = 96.0 / 240.0  # pixels of the page for one of a picture: in its size, as it is printed
NUMBER_CELL = re.compile(r"–|yes|no||[-+(\d.,) e/–%]+")
Drawn = Sequence[tuple[Picture, bytes]]  # pictures and the contents of their PNG files


def report_page(record: Report, drawn: Drawn = (), timings_s: Mapping[str, float] | None = None) -> str:
    """Return the page: numbers that matter and the first picture, results, fields, pictures, and all the rest.

    - `drawn`: pictures with the contents of their files.
    - `timings_s`: seconds of each stage; those of the record if left out.
    """
    times = record.timings_s if timings_s is None else timings_s
    return _template("page.html").render(
        record=record,
        drawn=drawn,
        beside=BESIDE_LETTERS,
        tables=[*record.tables, *([timings_table(times)] if times else [])],
        viewer=Markup(
            field_viewer(
                record.scene().in_units(record.units),
                "The pictures above show the most important fields." if drawn else "",
            )
        )
        if record.scene
        else "",
        program=Markup((files("flangeway.report.page") / "page.js").read_text(encoding="utf-8")),
    )


def printed_parts(table: SummaryTable) -> list[SummaryTable]:
    """Return tables of the first and some of the other columns, as few as fit the width of a printed page."""
    label, *widths = _widths(table)
    most = max(PAGE_LETTERS, label + max(widths, default=0))
    for number in range(1, len(widths) + 2):
        groups = np.array_split(np.arange(1, len(widths) + 1), number)
        if all(label + sum(widths[column - 1] for column in group) <= most for group in groups):
            break
    parts = [[tuple(line[at] for at in (0, *group)) for line in (table.header, *table.rows)] for group in groups]
    return [replace(table, header=header, rows=tuple(rows)) for header, *rows in parts]


def _widths(table: SummaryTable) -> list[int]:
    """Letters of the widest cell of each column: names of rows and longer texts break between words."""

    def letters(cell: str) -> int:
        return len(cell) if len(cell) <= SHORT_LETTERS else min(max(map(len, cell.split()), default=0), LABEL_LETTERS)

    label, *columns = zip(table.header, *table.rows, strict=True)
    return [
        min(max(map(len, label)), LABEL_LETTERS),
        *(max(map(letters, column)) + GAP_LETTERS for column in columns),
    ]


def record_html(record: Report) -> str:
    """Return what the terminal shows of a record, as HTML for a notebook."""
    return _template("record.html").render(record=record)


def write_record(
    record: Report,
    folder: Path,
    progress: Progress = lambda _: None,
    *,
    pictures: bool = True,
    xlsx: bool = False,
    whole_sections: bool = False,
) -> list[Path]:
    """Write all files of a record, the report and the summary last, together or not at all.

    - `pictures`: whether pictures are drawn.
    - `xlsx`: whether a workbook has the numbers of the summary and of all CSV files, a sheet each.
    - `whole_sections`: whether files of whole sections are among them.

    It is an `InputError` if the folder cannot be written.
    """
    start = time.perf_counter()
    drawn: list[tuple[Picture, bytes]] = []
    if pictures and (described := record.pictures()):
        from flangeway.report.figures.drawing import png  # noqa: PLC0415 (it loads Matplotlib)

        progress("drawing the pictures")
        drawn = [(picture, png(picture.draw())) for picture in described]
    timings_s = (
        {**record.timings_s, "pictures": time.perf_counter() - start}
        if drawn and record.timings_s
        else record.timings_s
    )
    progress("writing the files")
    writers = {picture.file: bytes_writer(data) for picture, data in drawn}
    writers |= record.with_sections() if whole_sections else record.files()
    if xlsx:
        summary = ResultTable.of_numbers(record.summary)
        rows = [[*summary.columns], *(_in_units(row, record.units) for row in summary.rows())]
        writers["tables.xlsx"] = lambda path: write_workbook(path, {"summary": rows, **csv_tables(path.parent)})
    writers[REPORT] = text_writer(report_page(record, drawn, timings_s))
    writers[record.summary_file] = text_writer(summary_text(record.summary))
    return write_together(folder, writers)


def _in_units(row: Sequence[Any], units: Units) -> Sequence[Any]:
    """Return a name and its number in a system of units."""
    unit = us_key(row[0]) if units == "us" else None
    return (unit.name, unit.of(row[1])) if unit else row


@cache
def _template(name: str) -> Template:
    filters: dict[str, Any] = {"with_names": _with_names, "base64": _base64, "shown_width": _shown_width}
    filters["printed"] = printed_parts
    environment = templates("flangeway.report.page", markup=True, **filters)
    environment.tests["words"] = lambda text: not NUMBER_CELL.fullmatch(text)
    environment.tests["narrow"] = lambda table, letters=HALF_LETTERS: sum(_widths(table)) <= letters
    return environment.get_template(name)


def _with_names(text: str) -> Markup:
    """Names of files and keys are between backticks."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _shown_width(content: bytes) -> int:
    """Width on the page of a picture, which is in the head of its PNG file."""
    return round(int.from_bytes(content[16:20], "big") * SHOWN_SIZE)


# --- Report of ``flangeway converge``: a case with its sizes and with half of them.


SUMMARY = "converge.json"


def convergence_record(name: str, convergence: Convergence, command: str) -> Report:
    """Return how much each number of a case changes when its sizes are halved."""
    case, runs = convergence.case, convergence.runs
    stopped = [run.status.message for run in runs if not run.status.converged]
    sizes = ", ".join((f"{key} {coarse:g} and {fine:g}" for key, (coarse, fine) in convergence.sizes.items()))
    parts = ("given sizes", "half of the sizes")
    return Report(
        name=name,
        title=f"{case.report_title or case.name}: the sizes halved",
        subtitle="Two runs: " + sizes,
        converged=convergence.converged,
        message="; ".join(stopped),
        results=_changes(convergence),
        summary=convergence.to_json(),
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        units=case.units,
        warnings=[f"{part}: " + text for part, run in zip(parts, runs, strict=True) for text in case.warnings_of(run)],
        timings_s={part: sum(run.summary["timings_s"].values()) for part, run in zip(parts, runs, strict=True)},
    )


def _changes(convergence: Convergence) -> SummaryTable:
    """One row for each number: both values, the change, and that over the first value where it is not above it."""
    both = {key: list(values) for key, values in convergence.numbers.items()}
    table = ResultTable(both).in_units(convergence.case.units)
    rows = []
    for key, (coarse, fine) in table.columns.items():
        change = 100.0 * (fine - coarse)
        over = plain_text(change / abs(coarse), "+.2f") if abs(fine - coarse) < abs(coarse) else "–"
        texts = (plain_text(value, ".0f" if 1e4 <= abs(value) < 1e7 else ".4g") for value in (coarse, fine))
        rows.append((key, *texts, f"{fine - coarse:+.2g}", over))
    return SummaryTable("Sizes halved", ("", "given", "half", "change", "change, %"), tuple(rows))
