"""The program itself: its options, and how it ends."""

import sys
from typing import Annotated, Any, cast

import typer

from flangeway.cli.common import DONE, INTERRUPTED, WRONG_INPUT, complain
from flangeway.errors import InputError

app = typer.Typer(
    help="Elastic contact in two dimensions with finite and virtual elements, up to a wheelset on two rails.",
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from flangeway.study.versions import versions  # noqa: PLC0415

        typer.echo(f"flangeway {versions()['flangeway']}")
        raise typer.Exit(DONE)


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version),
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line and exit with its status."""
    # the class is typer's own or click's, as typer's version wants it
    usage_error = cast(type[Exception], typer.BadParameter.__base__)
    try:
        status = app(prog_name="flangeway", standalone_mode=False)
    except usage_error as error:
        complain(_usage_message(error))
        status = WRONG_INPUT
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    sys.exit(status or DONE)


def _usage_message(error: Any) -> str:
    """Return a usage error in the three parts of all messages."""
    given, context = error.format_message().rstrip("."), error.ctx
    if context is None:
        return str(given)
    command = context.command
    words = [*getattr(command, "commands", {})] or command.collect_usage_pieces(context)[1:]
    options = [name for parameter in command.params for name in parameter.opts if name[0] == "-"]
    known = ", ".join([*(word.strip("{}") for word in words), *options, "--help"])
    return str(InputError(given, known, f"`{context.command_path} --help` explains them"))
