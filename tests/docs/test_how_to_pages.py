"""How-tos beside their blocks: names in sentences and numbers in tables are the program's."""

import re
from pathlib import Path

import pytest

from flangeway.cases import CASES
from flangeway.cases.bodies.cook import NEARLY_INCOMPRESSIBLE_WORK, CookCode, solve_cook
from flangeway.cases.case_file import FORMAT
from flangeway.railway.profiles.profile_file import READABLE

HOW_TOS = Path(__file__).parents[2] / "docs" / "how-to"
OF_ALL_COMMANDS = ("--help", "--out", "--quiet", "--json", "--no-pictures", "--units", "--xlsx")


def text_of(name):
    return (HOW_TOS / f"{name}.md").read_text(encoding="utf-8")


def test_the_page_of_case_files_names_all_cases_and_the_format():
    """Each case is in the table, and the number of the format is the program's."""
    for words in (*CASES, f"flangeway = {FORMAT}"):
        assert f"`{words}`" in text_of("write-a-case-file")


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


def test_the_page_of_profiles_names_all_options_and_formats(call):
    """Each option of the command and each ending of a format is explained on the page."""
    text, (_, shown, _) = text_of("bring-your-profile"), call("profile", "--help")
    for option in set(re.findall(r"--[a-z-]+", shown)).difference(OF_ALL_COMMANDS):
        assert f"`{option}" in text or f" {option} " in text, option
    for ending in READABLE:
        assert f"`{ending}`" in text, ending


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("method", "words"), [("F", "triangles"), ("V", "dual polygons")])
def test_the_table_of_nearly_incompressible_numbers_is_computed(method, words, order):
    """The rows of the page's table for the two coarser meshes are those of the program, to their last digit."""
    (row,) = re.findall(rf"^\| {words}, order {order} \|(.*)\|$", text_of("nearly-incompressible"), flags=re.MULTILINE)
    for level, given in enumerate(re.findall(r"-[\d.]+", row)[:2], start=1):
        work = solve_cook(CookCode(method, level, order).space(), 0.4999).load_work
        error = 100.0 * (work / NEARLY_INCOMPRESSIBLE_WORK - 1.0)
        assert error == pytest.approx(float(given), abs=1.5 * 10.0 ** -len(given.partition(".")[2]))
