"""The program itself: its options, and how it ends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup

from flangeway.cli.common import DONE, INTERRUPTED, WRONG_INPUT, complain, errors_as_exit_status
from flangeway.errors import InputError

MEMORY = "--memory"
MEMORY_VARIABLE = "FLANGEWAY_MEMORY_GB"


class Program(TyperGroup):
    """All commands; ``--memory`` may stand behind the command as well as before it."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take ``--memory GB`` to the front."""
        ends = args.index("--") if "--" in args else len(args)
        for place, word in enumerate(args[:ends]):
            if word == MEMORY or word.startswith(f"{MEMORY}="):
                length = 2 if word == MEMORY else 1
                if place + length > ends:
                    break  # the number is missing
                args = args[place : place + length] + args[:place] + args[place + length :]
                break
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=Program,
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
    context: typer.Context,
    version: Annotated[  # noqa: ARG001 (its callback shows it)
        bool,
        typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version),
    ] = False,
    memory: Annotated[
        float | None,
        typer.Option(
            MEMORY, metavar="GB", help="Most memory to use; what the machine has left if left out.", show_default=False
        ),
    ] = None,
) -> None:
    if memory is not None:
        context.with_resource(_memory_limited(memory))


@contextmanager
def _memory_limited(gigabytes: float) -> Iterator[None]:
    """Set the variable of the limit, which processes of a campaign inherit."""
    with errors_as_exit_status():
        if not gigabytes > 0.0:
            raise InputError(f"{MEMORY} {gigabytes:g}", "a positive number of gigabytes", "correct it, or leave it out")
    before = os.environ.get(MEMORY_VARIABLE)
    os.environ[MEMORY_VARIABLE] = repr(gigabytes)
    try:
        yield
    finally:
        if before is None:
            del os.environ[MEMORY_VARIABLE]
        else:
            os.environ[MEMORY_VARIABLE] = before


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
        return str(InputError(given, "options and their values", "`flangeway COMMAND --help` lists them"))
    command = context.command
    words = [*getattr(command, "commands", {})] or command.collect_usage_pieces(context)[1:]
    options = [name for parameter in command.params for name in parameter.opts if name[0] == "-"]
    known = ", ".join([*(word.strip("{}") for word in words), *options, "--help"])
    wrong: Any = getattr(error, "param", None)
    if isinstance(error, typer.BadParameter) and getattr(wrong, "help", None):  # a value, not a name
        option = wrong.opts[0] if wrong.opts[0][0] == "-" else ""
        known = f"{option} {wrong.metavar or ''}: {wrong.help.rstrip('.')}".strip()
    return str(InputError(given, known, f"`{context.command_path} --help` explains them"))
