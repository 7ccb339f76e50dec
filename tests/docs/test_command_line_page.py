"""The page of the command line, and every command line that a page prints: the program takes it as it stands."""

import re
import runpy
import shlex
from pathlib import Path

import pytest
import typer

from flangeway.cases.case_file import CASES
from flangeway.cli import app
from flangeway.records import path_by_ending

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PROGRAM = typer.main.get_command(app)
PREFIX = ".venv/bin/"


def name_of(page):
    return page.relative_to(ROOT).as_posix()


def lines_of(page, kinds="sh"):
    """Lines of the shell on a page, those that are continued joined, without comments."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(rf"^ *```(?:{kinds})\n(.*?)^ *```$", text, flags=re.DOTALL | re.MULTILINE)
    joined = "\n".join(blocks).replace("\\\n", " ")
    return [part.strip() for line in joined.splitlines() for part in line.split(" && ") if part.strip()]


def words_of(line):
    """Words of a line after the variables of the environment that it sets."""
    words = shlex.split(line, comments=True)
    while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):
        words.pop(0)
    return words


def parsed(words):
    """Have the program parse the arguments of a command line; nothing is computed. Returned: command and values."""
    words = shlex.split(re.sub(r"--memory(?: |=)\S+|--debug", "", shlex.join(words)))  # allowed anywhere
    at = next((place for place, word in enumerate(words) if word in PROGRAM.commands), None)
    assert at is not None, f"no command in {words}"
    command = PROGRAM.commands[words[at]]
    return words[at], command.make_context(words[at], list(words[at + 1 :])).params


def refuse_unknown_keys(name, values):
    """Fail if a case of the package is given an input that it does not have."""
    case = CASES.get(values.get("case") or values.get("case_or_file") or "")
    if name in {"run", "converge", "check"} and case is not None:
        for item in values.get("settings") or values.get("set") or ():
            path_by_ending(case, item.partition("=")[0])


def test_the_page_of_the_command_line_is_what_the_commands_say():
    """The page is the one that its script writes from the program: every command, argument and option, in full."""
    script = runpy.run_path(str(ROOT / ".ci" / "command_page.py"))
    text = script["PAGE"].read_text(encoding="utf-8")
    assert text == script["page"](), "run python .ci/command_page.py"
    for name, command in PROGRAM.commands.items():
        assert f"| [`{name}`](#flangeway-{name}) | {' '.join(command.help.split())} |" in text
        section = text.partition(f"\n## `flangeway {name}`\n")[2].partition("\n## ")[0]
        for parameter in command.params:
            assert " ".join((parameter.help or "").split()) in section, f"{name} {parameter.name}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_command_line_runs_as_printed(page):
    """Each line of the shell that calls the program has the folder of the environment, and the program parses it."""
    for line in lines_of(page):
        words = words_of(line)
        if words and words[0].removeprefix(PREFIX) in {"flangeway", "python", "pip", "dask", "mkdocs", "pytest"}:
            assert words[0].startswith(PREFIX), f"{line}: not found unless an environment is active"
        if words and words[0] == f"{PREFIX}flangeway":
            refuse_unknown_keys(*parsed(words[1:]))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_command_in_a_sentence_is_one_of_the_program(page):
    """Each `flangeway ...` within a sentence has a command and options that the program has."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for quoted in re.findall(rf"`(?:{re.escape(PREFIX)})?flangeway (?!=)([^`]+)`", text):
        words = [word for word in shlex.split(quoted) if word != "..."]
        if not words or words[0] in {"--version", "COMMAND"} or quoted.endswith("--help"):
            continue
        try:
            refuse_unknown_keys(*parsed(words))
        except typer.BadParameter as wrong:
            if type(wrong).__name__ != "MissingParameter":  # a sentence may leave out the file
                raise AssertionError(quoted) from wrong
