"""The how-to on profiles, followed to the letter: its scripts and commands are run in order, its outputs compared."""

import re
import runpy
import shlex
import sys
from pathlib import Path

import pytest

from flangeway import cli

TEXT = (Path(__file__).parents[1] / "docs" / "how-to" / "bring-your-profile.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(python|sh|text)\n(.*?)```", TEXT, flags=re.DOTALL)


def numbers(line):
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d+\.?\d*(?![\w.])", line)]


def refuse_other_line(shown, printed):
    """Fail unless a line with the same words is printed, with the same numbers to 2 %."""
    words = re.findall(r"[^\W\d]+", shown)
    same = [line for line in printed.splitlines() if re.findall(r"[^\W\d]+", line) == words]
    assert same, f"not printed: {shown}"
    assert numbers(same[0]) == pytest.approx(numbers(shown), rel=0.02, abs=2e-3), shown


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """Run a line of the page as users do, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")

    def run(line):
        monkeypatch.setattr(sys, "argv", shlex.split(line))
        with pytest.raises(SystemExit) as caught:
            cli.main()
        out, err = capsys.readouterr()
        assert caught.value.code == 0, err
        return out

    return run


def test_the_page_runs_from_top_to_bottom(command, tmp_path, capsys):
    """Every script and command of the page ends well, in its order, and prints the lines that the page shows."""
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
            printed = "".join(command(line) for line in text.splitlines())
        else:
            for line in text.splitlines():
                refuse_other_line(line, printed)
    assert done == {"python": 2, "sh": 4, "text": 2}
    assert {"worn_rail.csv", "S1002.prw", "S1002.whl"} <= {path.name for path in tmp_path.iterdir()}
    rms, largest = map(float, printed.split("\n")[0].split())
    assert 0.0 < rms < largest <= 30.0


def test_the_page_names_all_options_and_formats(command):
    """Each option of the command and each ending of a format is explained on the page."""
    from flangeway.railway.profile_file import FORMATS  # noqa: PLC0415

    shown = command("flangeway profile --help")
    for option in set(re.findall(r"--[a-z-]+", shown)) - {"--help", "--out"}:
        assert f"`{option}" in TEXT or f" {option} " in TEXT, option
    for ending in FORMATS:
        assert f"`{ending}`" in TEXT, ending


def test_the_numbers_of_the_page_are_the_programs(command):
    """Limits that the page tells are those of the program."""
    from flangeway.railway import joining, profile_checks, smoothing  # noqa: PLC0415

    assert (joining.LEAST_BLEND_MM, joining.LARGEST_BLEND_MM, joining.BLEND_FACTOR) == (1.0, 12.0, 4.0)
    assert (joining.LARGEST_GAP_MM, joining.LARGEST_RIM_GAP_MM) == (4.0, 15.0)
    assert (smoothing.USUAL_WAVELENGTH_MM, smoothing.NOISE_UM, smoothing.USUAL_LIMIT_UM) == (5.0, 0.02, 20.0)
    assert smoothing.ARC_TOLERANCE_MM == 2e-4
    assert profile_checks.SAME_MM == 0.01
    for words in (
        "4 mm",
        "at least 1 and at most 12 mm",
        "15 mm",
        "0.02 micrometres",
        "20\nmicrometres",
        "0.2 micrometres",
        "0.01 mm",
    ):
        assert words in TEXT, words
