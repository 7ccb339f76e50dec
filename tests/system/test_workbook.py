"""Workbooks hold the same numbers as CSV files, a sheet each."""

import csv
import sys

import openpyxl
import pytest

from flangeway.errors import InputError, MissingLibraryError
from flangeway.system import workbook

SMALL = [word for key in ("curve_points=3", "cells_along=8", "cells_across=8") for word in ("--set", key)]
PATCH = ["run", "rolling-patch", *SMALL, "-q", "--no-pictures", "--xlsx"]


def sheets(path) -> dict:
    book = openpyxl.load_workbook(path)
    return {sheet.title: [tuple(row) for row in sheet.iter_rows(values_only=True)] for sheet in book.worksheets}


def test_a_run_writes_a_sheet_for_each_csv_file(call, tmp_path) -> None:
    """Headers with units and rows are those of the CSV files; numbers are numbers; the summary is a sheet."""
    assert call(*PATCH, "--out", tmp_path)[0] == 0
    found = sheets(tmp_path / "tables.xlsx")
    files = sorted(tmp_path.glob("*.csv"))
    assert [*found] == ["summary", *(file.stem for file in files)]
    assert len(files) == 2
    for file in files:
        header, *rows = csv.reader(file.read_text(encoding="utf-8").splitlines())
        assert list(found[file.stem][0]) == header
        for row, cells in zip(rows, found[file.stem][1:], strict=True):
            for text, cell in zip(row, cells, strict=True):
                assert (float(text) if isinstance(cell, float | int) else text) == (cell if cell is not None else "")
    cells = found["cells"]
    assert all(isinstance(each, float | int) for row in cells[1:] for each in row)
    summary = dict(found["summary"][1:])
    assert summary["force_kN"] == pytest.approx(80.0)
    assert call(*PATCH, "--units", "us", "--out", tmp_path)[0] == 0
    summary = dict(sheets(tmp_path / "tables.xlsx")["summary"][1:])
    assert summary["force_kip"] == pytest.approx(80.0 / 4.4482216152605)
    assert "force_kN" not in summary


def test_words_stay_words(tmp_path) -> None:
    """60E1 is a rail, not 600; what is missing is an empty cell; sheets have different names of 31 letters at most."""
    (tmp_path / "a").mkdir()
    for name in ("a/long" + 40 * "x" + "1", "a/long" + 40 * "x" + "2"):
        (tmp_path / f"{name}.csv").write_text("rail,value_mm\n60E1,1e-05\n54E1,\n", encoding="utf-8")
    workbook.write_workbook(tmp_path / "book.xlsx", workbook.csv_tables(tmp_path))
    found = sheets(tmp_path / "book.xlsx")
    assert len(found) == 2
    assert max(map(len, found)) == 31
    for rows in found.values():
        assert rows == [("rail", "value_mm"), ("60E1", 1e-5), ("54E1", None)]


def test_without_openpyxl_nothing_is_computed(call, tmp_path, monkeypatch) -> None:
    """The message has the command that installs it."""
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingLibraryError):
        workbook.spreadsheet_library()
    status, _, error = call(*PATCH, "--out", tmp_path / "out")
    assert status == 1
    assert "pip install 'flangeway[campaign]'" in error
    assert not (tmp_path / "out").exists()


def test_a_table_longer_than_a_sheet_is_refused(tmp_path, monkeypatch) -> None:
    """The message names the table."""
    monkeypatch.setattr(workbook, "MAX_ROWS", 2)
    with pytest.raises(InputError, match="long"):
        workbook.write_workbook(tmp_path / "book.xlsx", {"long": [[1.0]] * 3})
