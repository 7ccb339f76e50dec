"""The how-to on case files, followed to the letter: files saved, commands and scripts run, outputs compared."""

from pathlib import Path

from flangeway.cases import CASES
from flangeway.cases.case_file import FORMAT

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "write-a-case-file.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_page_names_all_cases_and_the_format():
    """Each case is in the table, and the number of the format is the program's."""
    for name in CASES:
        assert f"`{name}`" in TEXT
    assert f"`flangeway = {FORMAT}`" in TEXT


def test_commands_on_case_files(call, tmp_path):
    """`schema` writes what it prints; `check` finds profiles beside a case file; all cases are listed."""
    assert call("init", "cook")[0] == 0
    assert call("check", "cook.toml")[1].startswith("cook.toml: a case cook")
    status, out, _ = call("schema")
    assert (status, out[0]) == (0, "{")
    assert call("schema", "--to", "s.json")[0] == 0
    assert (tmp_path / "s.json").read_text(encoding="utf-8") == out
    (tmp_path / "elsewhere").mkdir()
    assert call("profile", "S1002", "--to", "elsewhere/mine.whl", "--no-pictures")[0] == 0
    own = 'case = "wheelset-tangent"\nwheel = "mine.whl"\nwheel_body = "S1002"\n'
    (tmp_path / "elsewhere" / "own.toml").write_text(own, encoding="utf-8")
    assert call("check", "elsewhere/own.toml")[0] == 0
