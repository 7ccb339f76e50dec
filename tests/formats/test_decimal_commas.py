"""Sections, profiles, pressures and campaigns read the same CSV files."""

from pathlib import Path

import pytest

from flangeway.campaign.varying import read_table
from flangeway.formats import read_section
from flangeway.railway.profiles.formats.two_column import read_two_column
from flangeway.system.file_content import csv_cells

CORNERS = ((0.0, 0.0), (12.5, 0.0), (12.5, 7.25), (0.0, 7.25))


@pytest.mark.parametrize("separator", [";", "\t", ","])
def test_a_section_with_semicolons_and_decimal_commas(tmp_path: Path, separator: str) -> None:
    """Its area is that of the rectangle, whatever separates the cells; a profile reads the same points."""
    rows = [separator.join(f"{value:g}" for value in corner) for corner in CORNERS]
    text = "\n".join(row.replace(".", ",") if separator != "," else row for row in rows)
    file = tmp_path / "section.csv"
    file.write_text(f"x_mm{separator}y_mm\n{text}\n", encoding="utf-8")
    (part,) = read_section(file).section.regions
    assert part.outer.area == pytest.approx(12.5 * 7.25, rel=1e-12)
    assert read_two_column(f"x{separator}y\n{text}\n").points.tolist() == [list(corner) for corner in CORNERS]


def test_a_campaign_with_decimal_commas(tmp_path: Path) -> None:
    """Numbers of a table get points, names of profiles stay."""
    file = tmp_path / "rows.csv"
    file.write_text("rail;lateral_mm\n60E1;1,5\n136RE;-2\n", encoding="utf-8")
    expected = [{"rail": "60E1", "lateral_mm": "1.5"}, {"rail": "136RE", "lateral_mm": "-2"}]
    assert read_table(file) == expected


def test_commas_that_separate_are_no_decimal_commas() -> None:
    """Between commas there are numbers with points, and text between semicolons keeps its commas."""
    assert csv_cells("1,5,a", 1) == ["1", "5", "a"]
    assert csv_cells("1,5; a, b ;-2,5e3", 1, ";") == ["1.5", "a, b", "-2.5e3"]
