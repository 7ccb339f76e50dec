"""The how-to on tables for multibody programs, followed to the letter, with a small table in place of its own."""

import pytest

from flangeway.tables import write_table
from tests.tables.conftest import few_points, small

__all__ = ["few_points", "small"]


def test_the_page_runs_from_top_to_bottom(follow, small, tmp_path, monkeypatch):
    """Its Python reads the table and runs the FMU, and prints what the page shows."""
    pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    write_table(small[0], tmp_path / "out" / "creep-table-wheelset", fmu=True)
    done = follow("how-to/tables-for-multibody.md", skip=("flangeway creep-table", "creep-table: "))
    assert done == {"python": 2, "text": 2, "matlab": 1}
