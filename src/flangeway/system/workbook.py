"""Tables as a workbook (.xlsx) for spreadsheet programs: a sheet for each table."""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from flangeway.errors import InputError
from flangeway.system.operating_system import optional_module

NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)(?:e[-+]\d+)?")
"""Numbers as CSV files of flangeway have them; 60E1 is a rail."""
MAX_ROWS, MAX_LETTERS = 1_048_576, 31
"""Rows of a sheet and letters of its name (ECMA-376, and what spreadsheet programs open)."""
FORBIDDEN = re.compile(r"[\[\]:*?/\\]")


def spreadsheet_library() -> Any:
    """Return the module openpyxl; a `MissingLibraryError` says how to install it."""
    remedy = ", or leave --xlsx out: CSV files have the same tables"
    return optional_module("openpyxl", "workbooks (.xlsx) need openpyxl", remedy)


def write_workbook(path: Path, tables: Mapping[str, Iterable[Sequence[Any]]]) -> None:
    """Write a sheet for each table, whose first row is its header, with units, and stays in sight.

    - `tables`: rows of numbers, words and None by the names of the tables.

    It is an `InputError` if a table has more rows than a sheet.
    """
    library, sheets = spreadsheet_library(), dict[str, list[Sequence[Any]]]()
    for table, rows in tables.items():
        stem = FORBIDDEN.sub("-", table)[:MAX_LETTERS]
        name, number = stem, 1
        while name.lower() in map(str.lower, sheets):
            number += 1
            name = f"{stem[: MAX_LETTERS - 1 - len(str(number))]}-{number}"
        sheets[name] = list(rows)
        if len(sheets[name]) > MAX_ROWS:
            raise InputError(
                f"the table {table} with {len(sheets[name])} rows in a workbook",
                f"up to {MAX_ROWS} rows in a sheet",
                "leave --xlsx out and take the CSV file",
            )
    book = library.Workbook(write_only=True)
    for name, table_rows in sheets.items():
        sheet = book.create_sheet(name)
        sheet.freeze_panes = "A2"
        for row in table_rows:
            sheet.append(row)
    book.save(path)


def csv_tables(folder: Path) -> dict[str, Iterable[Sequence[Any]]]:
    """Return the rows of all CSV files in a folder and its folders by their names: numbers, words, or None."""
    files = sorted(folder.rglob("*.csv"))
    return {file.relative_to(folder).with_suffix("").as_posix(): _rows(file) for file in files}


def _rows(file: Path) -> Iterable[Sequence[Any]]:
    with file.open(encoding="utf-8", newline="") as text:
        for row in csv.reader(text):
            yield [float(cell) if NUMBER.fullmatch(cell) else cell or None for cell in row]
