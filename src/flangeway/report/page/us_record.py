"""A record in US units: numbers of tables with their names, sentences, and the columns of CSV files."""

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from flangeway.report.figures.us_figure import figure_in_us_units
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import Number, SummaryTable, formatted, marked
from flangeway.system.output_folder import Writer
from flangeway.units import NUMBER, Units, UsUnit, in_us_units, number_of, shown, us_key, us_unit

METRIC_PARTS = (
    "Numbers and pictures are in US units; fields to explore, animations, JSON, Parquet and ParaView files are metric."
)
UNIT_COLUMN = "in"  # of a table: the unit of the numbers on both sides of it, each row its own
MIN_DIGITS = 3  # of a converted number that is not below one before
SENTENCES = ("message", "warnings")  # columns of CSV files with text of the program; other texts are names


def in_units(record: Record, units: Units) -> Record:
    """Return a record in some units; one that is in US units already stays as it is."""
    if units == "metric" or METRIC_PARTS in record.assumptions:
        return record
    files = record.files
    return replace(
        record,
        title=in_us_units(record.title),
        subtitle=in_us_units(record.subtitle),
        message=in_us_units(record.message),
        facts=[(_cell(value, None), in_us_units(name)) for value, name in record.facts],
        results=_table(record.results),
        sentences=[*map(in_us_units, record.sentences)],
        warnings=[*map(in_us_units, record.warnings)],
        notes=[*map(in_us_units, record.notes)],
        assumptions=[*map(in_us_units, record.assumptions), METRIC_PARTS],
        tables=[*map(_table, record.tables)],
        pictures=[*map(_picture, record.pictures)],
        chapters={name: [*map(_table, tables)] for name, tables in record.chapters.items()},
        axes={name: in_us_units(text) for name, text in record.axes.items()},
        inputs=[*map(_table, record.inputs)],
        files=lambda: files_in_units(files(), units),
    )


def files_in_units(writers: Mapping[str, Writer], units: Units) -> dict[str, Writer]:
    """Return functions that write files, by their names; those of CSV files do it in some units."""
    in_us = units == "us"
    return {name: _csv(write) if in_us and name.endswith(".csv") else write for name, write in writers.items()}


def _picture(picture: Picture) -> Picture:
    alternative, caption = in_us_units(picture.alternative), in_us_units(picture.caption)
    return replace(picture, draw=lambda: figure_in_us_units(picture.draw()), alternative=alternative, caption=caption)


def _table(table: SummaryTable) -> SummaryTable:
    columns = [_named(name) for name in table.header]
    rows = []
    for name, *cells in table.rows:
        of_row, row_name = _named(name)
        units = [unit or of_row for unit, _ in columns[1:]]
        if UNIT_COLUMN in table.header:
            place = table.header.index(UNIT_COLUMN) - 1
            of_change = us_unit(cells[place])
            units[place - 1 : place + 2] = of_change, None, of_change
            cells[place] = of_change.name if of_change else cells[place]
        rows.append((row_name, *map(_cell, cells, units)))
    header = tuple(name for _, name in columns)
    return replace(
        table, caption=in_us_units(table.caption), header=header, rows=tuple(rows), note=in_us_units(table.note)
    )


def _named(name: str) -> tuple[UsUnit | None, str]:
    """Unit of the numbers that a name is of, and the name with it: "force, kN", or a key such as ``force_kN``."""
    before, comma, last = name.rpartition(", ")
    unit = us_unit(last) if comma else None
    if unit is not None:
        return unit, f"{in_us_units(before)}, {unit.name}"
    key = us_key(name)
    return key, key.name if key else in_us_units(name)


def _cell(text: str, unit: UsUnit | None) -> str:
    """Convert the number of a cell, or all numbers in it, with about as many digits as it has."""
    if unit is None or re.search(r"[a-df-zA-Z%]", text):  # a sentence, or a part of a number
        found = in_us_units(text)
    elif re.fullmatch(NUMBER, text):
        value, form = (text.value, text.form) if isinstance(text, Number) else (number_of(text), _form(text))
        if not form.endswith("g"):
            decimals = int((re.search(r"\.(\d+)f", form) or "00")[1]) + round(math.log10(unit.metric))
            if value and abs(value) >= 1.0:  # 70 mm are 2.76 in, not 2.8
                decimals = max(decimals, MIN_DIGITS - 1 - math.floor(math.log10(abs(unit.of(value)))))
            form = f"{'z' * form.startswith('z')}.{max(decimals, 0)}f"
        found = formatted(unit.of(value), form)
    else:
        found = re.sub(NUMBER, lambda each: shown(unit.of(number_of(each[0]))), text)
    return marked(found, in_us_units(getattr(text, "remark", "")))


def _form(text: str) -> str:
    """Format of a number that is a text."""
    if "e" in text:
        return f".{len(re.sub(r'e.*|[^0-9]', '', text))}g"
    return f".{len(text.partition('.')[2])}f"


def _csv(write: Writer) -> Writer:
    """Return a function that writes a CSV file in US units; one that begins with a comment has units of its own."""

    def converted(path: Path) -> None:
        write(path)
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = [[], *csv.reader(file)][1:] or [[]]
        units = {name: us_key(name) for name in header}
        if (header and header[0].startswith("#")) or not any(units.values()):
            return
        # an input that is given in US units is a column already, beside the metric one of the results
        kept = [place for place, name in enumerate(header) if not (unit := units[name]) or unit.name not in units]
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(unit.name if (unit := units[header[place]]) else header[place] for place in kept)
            for row in rows:
                writer.writerow(_csv_cell(header[place], row[place], units[header[place]]) for place in kept)

    return converted


def _csv_cell(column: str, cell: str, unit: UsUnit | None) -> str:
    if unit and re.fullmatch(NUMBER, cell):
        return f"{float(1 / unit.metric) * float(cell):.10g}"
    return in_us_units(cell) if column in SENTENCES else cell
