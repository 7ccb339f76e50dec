"""The how-to 'add a kind of result', followed to the letter."""

import json
import math
import re
import sys
from pathlib import Path

import pytest

from flangeway.report import RECORDS

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-result.md"
MAX_LINES = 70  # of the whole file, imports and the mechanics of the example too


def test_the_example_has_numbers_picture_page_and_columns(tmp_path, monkeypatch, capsys):
    """Its code writes the report in US units; pressure and half width are those of Hertz (1882) by hand."""
    code, use = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= MAX_LINES
    (tmp_path / "roller_on_plate.py").write_text(code, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    known = set(RECORDS)
    try:
        exec(use, {})
    finally:
        sys.modules.pop("roller_on_plate", None)
        for kind in set(RECORDS) - known:
            del RECORDS[kind]
    pressure = math.sqrt(500.0 * 115_385.0 / (math.pi * 25.0))
    half_width = math.sqrt(4.0 * 500.0 * 25.0 / (math.pi * 115_385.0))
    summary = json.loads((tmp_path / "roller" / "summary.json").read_text(encoding="utf-8"))
    assert summary["max_pressure_MPa"] == pytest.approx(pressure, rel=1e-9)
    assert f"{pressure:.6f}"[:8] in capsys.readouterr().out
    page = (tmp_path / "roller" / "report.html").read_text(encoding="utf-8")
    for value, name in ((pressure / 6.894757293168361, "maximum pressure, ksi"), (half_width / 25.4, "contact, in")):
        assert name in page
        assert f">{value:.2f}" in page
    assert (tmp_path / "roller" / "pressure.png").is_file()
