"""The tutorial on a wheelset in a curve, followed to the letter: its commands and scripts run, its outputs compared."""

import re
import runpy
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flangeway.cli.app import app

TEXT = (Path(__file__).parents[1] / "docs" / "tutorials" / "wheelset-in-a-curve.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(python|sh|text)\n(.*?)```", TEXT, flags=re.DOTALL)


def numbers(line):
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d+\.?\d*(?![\w.])", line)]


def refuse_other_line(shown, printed):
    """Fail unless a line with the same words is printed, with the same numbers to 2 %."""
    words = re.findall(r"[^\W\d]+", shown)
    same = [line for line in printed.splitlines() if re.findall(r"[^\W\d]+", line) == words]
    assert same, f"not printed: {shown}"
    assert any(numbers(line) == pytest.approx(numbers(shown), rel=0.02, abs=2e-3) for line in same), shown


def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capsys):
    """Every command and script ends well, in its order, and prints the lines that the page shows, to 2 %."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "110")
    monkeypatch.setenv("NO_COLOR", "1")
    printed = ""
    done = {"python": 0, "sh": 0, "text": 0}
    for kind, text in BLOCKS:
        done[kind] += 1
        if kind == "python":
            script = tmp_path / f"script_{done[kind]}.py"
            script.write_text(text, encoding="utf-8")
            runpy.run_path(str(script))
            printed = capsys.readouterr().out
        elif kind == "sh":
            for line in text.splitlines():
                result = CliRunner().invoke(app, shlex.split(line)[1:])
                assert result.exit_code == 0, result.stderr
                printed = result.stdout
        else:
            for line in text.splitlines():
                refuse_other_line(line, printed)
    assert done == {"python": 2, "sh": 6, "text": 7}
    assert "The noise is" in printed or "noise" in (tmp_path / "out/worn/summary.json").read_text(encoding="utf-8")


def test_numbers_in_the_text_are_the_cases():
    """Load, radius, speed, force and superelevation that the text names are the case's own."""
    from flangeway.railway.load import curve_force_N  # noqa: PLC0415
    from flangeway.study import WheelsetCurveCase  # noqa: PLC0415

    case = WheelsetCurveCase.from_values({})
    assert (case.axle_load_kN, case.lateral_force_kN, case.superelevation_mm) == (300.0, 28.4, 30.0)
    assert curve_force_N(300e3, 70.0, 400.0) == pytest.approx(28.4e3, rel=0.02)
    assert case.cant == pytest.approx(1.0 / 40.0)
    for words in ("300 kN", "400 m", "70 km/h", "30 mm", "28.4 kN", "1:40", "136RE", "AAR-1B"):
        assert words in TEXT, words
