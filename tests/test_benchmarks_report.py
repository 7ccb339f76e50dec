"""The page of all benchmarks is made of what was recorded."""

from pathlib import Path

from benchmarks import report
from benchmarks.__main__ import ABOUTS, CAMPAIGNS


def test_the_page_of_performance_is_made_of_the_records(tmp_path: Path) -> None:
    """The page in the documentation is what the kept records of measurements make, to the letter."""
    page = report.write(ABOUTS, page=tmp_path / "performance.md")
    assert page.read_text(encoding="utf-8") == report.PAGE.read_text(encoding="utf-8")
    assert {path.stem for path in report.RECORDS.glob("*.json")} == set(ABOUTS) - CAMPAIGNS
