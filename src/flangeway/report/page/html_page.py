"""The report, one HTML page with all pictures inside that needs no network, and the other files of a record."""

import base64
import re
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Template
from markupsafe import Markup, escape

from flangeway.cases.summary import summary_text
from flangeway.report.figures.drawing import png
from flangeway.report.page.record import REPORT, Picture, Record
from flangeway.report.page.tables import timings_table
from flangeway.report.viewer import field_viewer
from flangeway.results import ResultTable
from flangeway.system.output_folder import bytes_writer, text_writer, write_together
from flangeway.system.templates import templates
from flangeway.system.workbook import csv_tables, write_workbook
from flangeway.units import Units, us_key

SHOWN_SIZE = 0.55  # pixels of the page for one of a picture, so that letters have one size in wide and narrow pictures
NUMBER_CELL = re.compile(r"–|yes|no||[-+(\d.,) e/–%]+")
Drawn = Sequence[tuple[Picture, bytes]]  # pictures and the contents of their PNG files


def report_page(record: Record, drawn: Drawn = (), timings_s: Mapping[str, float] | None = None) -> str:
    """Return the page: numbers that matter and the first picture, results, fields, pictures, and all the rest.

    - `drawn`: pictures with the contents of their files.
    - `timings_s`: seconds of each stage; those of the record if left out.
    """
    times = record.timings_s if timings_s is None else timings_s
    return _template().render(
        record=record,
        drawn=drawn,
        tables=[*record.tables, *([timings_table(times)] if times else [])],
        viewer=Markup(
            field_viewer(
                record.scene().in_units(record.units),
                "The figures above and the figures below show the most important fields." if drawn else "",
            )
        )
        if record.scene
        else "",
        program=Markup((files("flangeway.report.page") / "page.js").read_text(encoding="utf-8")),
    )


def record_html(record: Record) -> str:
    """Return what the terminal shows of a record, as HTML for a notebook."""

    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    table = record.results
    head = f"<p><b>{escape(record.verdict)}</b>, {escape(record.message)}<br>{escape(record.subtitle)}</p>"
    warnings = "".join(f"<li>{escape(warning)}</li>" for warning in record.warnings)
    body = "".join(line(row, "td") for row in table.rows)
    return f"{head}<ul>{warnings}</ul><table><thead>{line(table.header, 'th')}</thead><tbody>{body}</tbody></table>"


def write_record(
    record: Record,
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    *,
    pictures: bool = True,
    xlsx: bool = False,
) -> list[Path]:
    """Write all files of a record, the report and the summary last, together or not at all.

    - `pictures`: whether pictures are drawn.
    - `xlsx`: whether a workbook has the numbers of the summary and of all CSV files, a sheet each.

    It is an `InputError` if the folder cannot be written.
    """
    start = time.perf_counter()
    drawn: list[tuple[Picture, bytes]] = []
    if record.pictures and pictures:
        progress("drawing the pictures")
        drawn = [(each, png(each.draw())) for each in record.pictures]
    timings_s = (
        {**record.timings_s, "pictures": time.perf_counter() - start}
        if drawn and record.timings_s
        else record.timings_s
    )
    progress("writing the files")
    writers = {each.file: bytes_writer(data) for each, data in drawn} | dict(record.files())
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
def _template() -> Template:
    filters: dict[str, Any] = {"with_names": _with_names, "base64": _base64, "shown_width": _shown_width}
    environment = templates("flangeway.report.page", markup=True, **filters)
    environment.tests |= {"words": lambda text: not NUMBER_CELL.fullmatch(text)}
    return environment.get_template("page.html")


def _with_names(text: str) -> Markup:
    """Names of files and keys are between backticks."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _shown_width(content: bytes) -> int:
    """Width on the page of a picture, which is in the head of its PNG file."""
    return round(int.from_bytes(content[16:20], "big") * SHOWN_SIZE)
