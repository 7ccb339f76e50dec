"""The how-to on tables for multibody programs, followed to the letter, with a small table in place of its own."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from flangeway.report.rolling.creep_table_page import creep_table_record
from flangeway.tables import write_table
from tests.tables.conftest import COARSE, few_points, small

__all__ = ["few_points", "small"]

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "tables-for-multibody.md"


def test_the_page_runs_from_top_to_bottom(follow, small, tmp_path, monkeypatch):
    """Its Python reads the table and runs the FMU, and prints what the page shows."""
    pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    write_table(small[0], tmp_path / "out" / "creep-table-wheelset", fmu=True)
    done = follow("how-to/tables-for-multibody.md", skip=("flangeway creep-table", "creep-table: "))
    assert done == {"python": 2, "text": 2, "matlab": 1}


def test_the_output_that_is_shown_has_the_rows_of_a_table_and_its_own_tolerance(small):
    """Each row that is shown is one of any table's; the claim is not below what was found at random points."""
    text = PAGE.read_text(encoding="utf-8")
    first, _, *shown = re.search(r"```text\n(creep-table: .*?)```", text, flags=re.DOTALL)[1].splitlines()
    request = SimpleNamespace(case=COARSE)
    rows = creep_table_record(small[0], request, "", {}).results.rows
    found = [re.fullmatch(r" *(\S.*?)  +(\S.*)", line) for line in shown]
    assert [each[1] for each in found] == [row[0].strip() for row in rows]
    tolerance = float(re.search(r"tolerance of ([\d.]+)%", first)[1])
    errors = {each[1]: float(each[2]) for each in reversed(found) if "%" in each[1] and each[2] != "–"}
    assert errors["maximum, % of the limit of friction"] <= errors["claimed error, % of the limit of friction"]
    assert ("NOT converged" in first) == (errors["claimed error, % of the limit of friction"] > tolerance)
