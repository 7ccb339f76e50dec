"""The page of all benchmarks is made of what was recorded."""

from pathlib import Path

from benchmarks import report
from benchmarks.__main__ import ABOUTS, CAMPAIGNS
from benchmarks.measurement import Measurement


def test_the_page_holds_what_was_recorded(tmp_path: Path) -> None:
    """The page has what is measured, rows with the recorded times, ratios and accuracies, versions and the machine."""
    met = Measurement("some work", "peer", 0.5, 2.0, 1e-3, 2e-2, "a note", "1.2", 3.0, {"peak_mb": 7, "asked_mb": None})
    missed = Measurement(
        "more work", "peer", 0.5, 0.6, None, None, "", "1.2", 3.0, {"peak_mb": 1234.5, "asked_mb": 9.5}
    )
    missing = Measurement("other work", "rival", 0.5, None, None, None, "not installed", "", 2.0)
    alone = Measurement("growth", "none", 5.0, None, None, None, more={"exponents": {"factor": 1.25, "solve": 1.1}})
    report.record("one-name", [met, missed, missing, alone], tmp_path)
    abouts = {"other": "Not recorded.", "one-name": "What it is.\n\n    Time is from ``a`` to b.\n    "}
    page = report.write(abouts, tmp_path, tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| 1 | some work | peer 1.2 | 0.5 | 2 | 4 | 3 | 0.001 | 0.02 |" in page
    assert "| 2 | more work | peer 1.2 | 0.5 | 0.6 | **1.2** | 3 |  |  |" in page
    assert "| 3 | other work | rival | 0.5 | not measured |  | 2 |  |  |" in page
    assert "| 4 | growth |  | 5 |  |  |  |  |  |" in page
    assert "- 1: a note\n- 3: not installed" in page
    assert "|  | peak mb | goal mb |\n| --- | --- | --- |\n| 1 | 7 |  |\n| 2 | 1234 | 9.5 |" in page
    assert "|  | measured | factor | solve |\n| --- | --- | --- | --- |\n| 4 | exponents | 1.25 | 1.1 |" in page
    assert "| [One name](#one-name) | more work | peer 1.2 | **1.2** | 3 |" in page
    assert "\n\n## One name\n\n" in page
    assert "What it is.\n\nTime is from `a` to b." in page
    assert "processors" in page
    assert "; flangeway " in page
    assert "Not recorded" not in page


def test_the_page_of_performance_is_made_of_the_records(tmp_path: Path) -> None:
    """The page in the documentation is what the kept records of measurements make, to the letter."""
    page = report.write(ABOUTS, page=tmp_path / "performance.md")
    assert page.read_text(encoding="utf-8") == report.PAGE.read_text(encoding="utf-8")
    assert {path.stem for path in report.RECORDS.glob("*.json")} == set(ABOUTS) - CAMPAIGNS
