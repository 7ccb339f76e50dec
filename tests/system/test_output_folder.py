"""Folders of results are filled at once or not at all; workbooks hold the numbers of the CSV files."""

import csv
import sys

import openpyxl
import pytest

from flangeway.errors import InputError, MissingLibraryError
from flangeway.system import workbook
from flangeway.system.output_folder import refuse_unwritable, write_together


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_files_are_written_in_a_new_folder(tmp_path):
    """Files go to a folder that is made for them, and nothing else stays there."""
    out = tmp_path / "a" / "b"
    refuse_unwritable(out)
    assert everything(tmp_path) == []
    files = write_together(out, {"x": lambda p: p.write_text("1"), "y": lambda p: p.write_text("2")})
    assert [file.read_text() for file in files] == ["1", "2"]
    assert everything(tmp_path) == ["a", "a/b", "a/b/x", "a/b/y"]


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_nothing_behind(tmp_path, failure):
    """If one writer fails, or the user stops it, no file is new or changed and no temporary folder stays."""

    def broken(path):
        path.write_text("half")
        raise failure

    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "x").write_text("before")
    for out in (tmp_path / "old", tmp_path / "new"):
        with pytest.raises(failure):
            write_together(out, {"x": lambda p: p.write_text("after"), "y": broken})
    assert everything(tmp_path) == ["old", "old/x"]
    assert (tmp_path / "old" / "x").read_text() == "before"


def test_files_of_a_former_run_are_replaced_and_others_kept(tmp_path):
    """A second run replaces the files of its names and leaves the others alone."""
    (tmp_path / "x").write_text("before")
    (tmp_path / "notes").write_text("mine")
    write_together(tmp_path, {"x": lambda p: p.write_text("after")})
    assert (tmp_path / "x").read_text() == "after"
    assert (tmp_path / "notes").read_text() == "mine"


def test_a_file_in_the_way_is_refused(tmp_path):
    """A file where the folder should be, or above it, is refused before and while writing."""
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="not a folder"):
            refuse_unwritable(out)
        with pytest.raises(InputError, match="cannot be written"):
            write_together(out, {"x": lambda p: p.write_text("1")})
    assert everything(tmp_path) == ["file"]


@pytest.mark.parametrize("name", ["summary.json", "report.html", "body.vtu", "campaign.sqlite"])
def test_a_folder_with_the_name_of_a_file_is_refused(tmp_path, name):
    """A folder called like a file of the results is refused before anything is computed; others may be there."""
    (tmp_path / "steps").mkdir()
    refuse_unwritable(tmp_path)
    (tmp_path / name).mkdir()
    with pytest.raises(InputError, match=f"{name}, which is a folder"):
        refuse_unwritable(tmp_path)


def test_a_system_that_does_not_allow_to_write_is_refused(tmp_path, monkeypatch):
    """If the system does not allow a file in the folder, the message says so."""

    def denied(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", denied)
    with pytest.raises(InputError, match="Permission denied"):
        refuse_unwritable(tmp_path)


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
