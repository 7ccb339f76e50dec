"""The how-to on case files, followed to the letter: files saved, commands and scripts run, outputs compared."""

import json
import re
import runpy
import shlex
import sys
from pathlib import Path

import pytest

from flangeway import cli
from flangeway.study import CASES, load_case
from flangeway.study.case_file import FORMAT

TEXT = (Path(__file__).parents[1] / "docs" / "how-to" / "write-a-case-file.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"(?:Save as `(\S+)`[^`]*?)?```(toml|inp|sh|text|python)\n(.*?)```", TEXT, flags=re.DOTALL)


def numbers(line):
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d+\.?\d*(?![\w.])", line)]


def refuse_other_line(shown, printed):
    """Fail unless a line with the same words is printed, with the same numbers to 1 %."""
    words = re.findall(r"[^\W\d]+", shown)
    same = [line for line in printed.splitlines() if re.findall(r"[^\W\d]+", line) == words]
    assert same, f"not printed: {shown}"
    assert numbers(same[0]) == pytest.approx(numbers(shown), rel=0.01), shown


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """Run a line of the page as users do, in a folder of its own; return its status and what it printed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")

    def run(line):
        monkeypatch.setattr(sys, "argv", shlex.split(line))
        with pytest.raises(SystemExit) as caught:
            cli.main()
        out, err = capsys.readouterr()
        return caught.value.code, out, err

    return run


def test_the_page_runs_from_top_to_bottom(command, tmp_path, capsys):
    """Every file is saved, every command ends with status 0, every script runs, and what is shown is printed."""
    printed, before, done = "", "", {"toml": 0, "inp": 0, "sh": 0, "text": 0, "python": 0}
    for name, kind, text in BLOCKS:
        done[kind] += 1
        if name:
            (tmp_path / name).write_text(text, encoding="utf-8")
        elif kind == "sh":
            printed = ""
            for line in text.splitlines():
                status, out, err = command(line)
                assert status == 0, err
                printed += out
        elif kind == "python":
            script = tmp_path / f"script_{done[kind]}.py"
            script.write_text(text if "load_case" in text else before + text, encoding="utf-8")
            runpy.run_path(str(script))
            before = text
            printed = capsys.readouterr().out
        elif text.startswith("*"):  # the rest of the deck
            whole = (tmp_path / "blocks.inp").read_text(encoding="utf-8") + text
            (tmp_path / "blocks_with_steps.inp").write_text(whole, encoding="utf-8")
        elif not text.startswith("flangeway: "):
            for line in text.splitlines():
                refuse_other_line(line, printed)
    assert done == {"toml": 3, "inp": 1, "sh": 5, "text": 4, "python": 2}
    assert (tmp_path / "out" / "mine" / "summary.json").is_file()
    forces = [
        json.loads((tmp_path / "out" / name / "summary.json").read_text()) for name in ("blocks", "blocks_with_steps")
    ]
    first, second = (summary["contacts"][0]["force_on_secondary_N"] for summary in forces)
    assert first == pytest.approx(second)
    assert load_case(tmp_path / "steps.toml").bodies[0].cells == "LOWER"
    assert load_case(tmp_path / "curve.toml").rail == "60E1"
    shortest = re.search(r"Save as `curve.toml`.*?```toml\n(.*?)```", TEXT, flags=re.DOTALL)[1]
    assert len(shortest.splitlines()) < 10


def test_the_mistake_of_the_page_is_told_as_shown(command, tmp_path):
    """The shown message is that of a misspelt key in line 3, but for the rest of the keys."""
    (tmp_path / "cylinders.toml").write_text('flangeway = 1\ncase = "hertz"\nradus_mm = 3.0\n', encoding="utf-8")
    status, out, err = command("flangeway run cylinders.toml")
    shown = next(text for _, kind, text in BLOCKS if kind == "text" and text.startswith("flangeway: "))
    assert (status, out) == (2, "")
    for line, told in zip(shown.splitlines(), err.splitlines(), strict=True):
        assert told.startswith(line.removesuffix("...")), line


def test_the_page_names_all_cases_and_the_format():
    """Each case is in the table, and the number of the format is the program's."""
    for name in CASES:
        assert f"`{name}`" in TEXT
    assert f"`flangeway = {FORMAT}`" in TEXT


def test_commands_on_case_files(command, tmp_path):
    """`init` does not write over files, `schema` writes or prints JSON, `cases` explains one case or all."""
    assert command("flangeway init cook")[0] == 0
    status, out, err = command("flangeway init cook")
    assert (status, out) == (2, "")
    assert "cook.toml, which is there already" in err
    assert command("flangeway init cok")[2].endswith("did you mean cook?\n")
    assert command("flangeway check cook.toml")[1].startswith("cook.toml: a case cook")
    assert command("flangeway check none.toml")[0] == 2
    assert command("flangeway run cook.toml --set level=1 --set levl=2")[0] == 2
    status, out, err = command("flangeway schema")
    assert status == 0
    assert out.startswith("{")
    assert command("flangeway schema --to s.json")[0] == 0
    assert (tmp_path / "s.json").read_text(encoding="utf-8") == out
    (tmp_path / "elsewhere").mkdir()
    assert command("flangeway profile S1002 --to elsewhere/mine.whl")[0] == 0
    own = 'case = "wheelset-tangent"\nwheel = "mine.whl"\nwheel_body = "S1002"\n'
    (tmp_path / "elsewhere" / "own.toml").write_text(own, encoding="utf-8")
    assert command("flangeway check elsewhere/own.toml")[0] == 0
    assert "level" in command("flangeway cases cook")[1]
    assert all(name in command("flangeway cases")[1] for name in CASES)
    assert "wheelset-tangent" in command("flangeway converge cook")[2]
    assert command("flangeway run torsion --set size=30 --out t")[0] == 0
    assert {"summary.json", "section.vtu", "warping.png"} <= {file.name for file in (tmp_path / "t").iterdir()}
