"""The page of the command line lists what the program has."""

import html
import re
from pathlib import Path

import typer

from flangeway.cli import app

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "command-line.md"
REMADE = "remake it as CONTRIBUTING.md says"


def test_the_page_has_every_command_with_its_help_arguments_and_options():
    """Each command has its section in the order of the help, and in it each parameter with its own words, no other."""
    text = html.unescape(PAGE.read_text(encoding="utf-8"))
    sections = dict(re.findall(r"^## `flangeway ([\w-]+)`\n(.*?)(?=^## |\Z)", text, flags=re.MULTILINE | re.DOTALL))
    commands = typer.main.get_command(app).commands
    assert list(sections) == list(commands), REMADE
    for name, command in commands.items():
        section = sections[name]
        assert " ".join(command.help.split()) in " ".join(section.split()), f"{name}: {REMADE}"
        shown = re.findall(r"^\* `(-[^`]*|[^`]*)`: (.*)$", section, flags=re.MULTILINE)
        options = [item for item, _ in shown if item.startswith("-") and item != "--help"]
        wanted = [each for each in command.params if each.opts[0].startswith("-")]
        assert len(options) == len(wanted), f"{name}: {REMADE}"
        for each in wanted:
            (said,) = (words for item, words in shown if re.split(r"[ ,]", item)[0] in each.opts)
            assert said.startswith(each.help), f"{name} {each.opts[0]}: {REMADE}"
        assert len(shown) == len(command.params) + 1, f"{name}: {REMADE}"
