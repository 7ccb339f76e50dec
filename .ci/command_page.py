"""Writes docs/reference/command-line.md from the commands themselves: ``python .ci/command_page.py``."""

from pathlib import Path
from typing import Any

import typer

from flangeway.cli import app

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "command-line.md"
INTRODUCTION = """# Command line

`flangeway COMMAND --help` prints the section of a command. `--set KEY=VALUE` gives any input of a case, as often as
needed; `flangeway cases NAME` lists the keys with units, ranges and defaults. Results are in a folder of `out/`, which
`--out` changes.

The option `--install-completion` lets the shell complete names, options and keys with the tab key, and names and
choices behind `--set KEY=`. Bash does the last only with `COMP_WORDBREAKS=${COMP_WORDBREAKS//=}` in `~/.bashrc`.

**Exit status**: 0: done; 1: not converged, a check failed, or a library is missing; 2: the input is wrong; 130:
interrupted.
"""


def page() -> str:
    """Return the page."""
    group: Any = typer.main.get_command(app)
    lines = [INTRODUCTION, "| command | what it does |", "|---|---|"]
    for name, command in group.commands.items():
        lines.append(f"| [`{name}`](#flangeway-{name}) | {_words(command.help)} |")
    lines += [
        "",
        "## Options of every command",
        "",
        "Before the command; `--memory` and `--debug` also behind it.",
        "",
        *_options(group),
    ]
    for name, command in group.commands.items():
        arguments = [parameter for parameter in command.params if parameter.param_type_name == "argument"]
        usage = " ".join(["flangeway", name, *(_metavar(each) for each in arguments), "[OPTIONS]"])
        lines += ["", f"## `flangeway {name}`", "", _words(command.help), "", "```text", usage, "```", ""]
        lines += [f"- `{_metavar(each)}`: {_words(each.help)}{_default(each)}" for each in arguments]
        lines += _options(command)
    return "\n".join(lines) + "\n"


def _words(text: str | None) -> str:
    return " ".join((text or "").replace("|", "\\|").split())


def _metavar(argument: Any) -> str:
    name = (argument.metavar or argument.name.upper()).strip("[]{}")
    return name if argument.required else f"[{name}]"


def _default(parameter: Any) -> str:
    shown = getattr(parameter, "show_default", True) and not isinstance(parameter.default, bool)
    return f" Default: `{parameter.default}`." if shown and parameter.default not in (None, ()) else ""


def _options(command: Any) -> list[str]:
    lines = []
    for option in command.params:
        if option.param_type_name == "option":
            value = "" if option.is_flag else f" {option.metavar or 'VALUE'}"
            names = ", ".join([*option.opts, *option.secondary_opts])
            lines.append(f"- `{names}{value}`: {_words(option.help)}{_default(option)}")
    return lines


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
