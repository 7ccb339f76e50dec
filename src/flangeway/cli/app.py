"""The program itself: its options, and how it ends."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup

from flangeway.cli.common import (
    DONE,
    FAILED,
    INTERRUPTED,
    NOTHING_WRITTEN,
    WRONG_INPUT,
    complain,
    errors_as_exit_status,
    interruption_reported,
)
from flangeway.errors import DEBUG_VARIABLE, InputError, unforeseen
from flangeway.system.operating_system import environment

UNWRITABLE = (errno.EPIPE, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
"""Errors of writing to the standard output."""
MEMORY = "--memory"
MEMORY_VARIABLE = "FLANGEWAY_MEMORY_GB"
DEBUG = "--debug"


class Program(TyperGroup):
    """All commands; ``--memory`` and ``--debug`` are allowed behind the command as well as before it."""

    def make_context(self, *arguments: Any, **named: Any) -> Any:
        """Read the arguments, for which libraries are loaded."""
        with interruption_reported():
            return super().make_context(*arguments, **named)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with interruption_reported():
            return super().invoke(ctx)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take ``--memory GB`` and ``--debug`` to the front."""
        if _wants_debugging(args):
            args = [DEBUG, *(word for word in args if word != DEBUG)]
        ends = args.index("--") if "--" in args else len(args)
        for index, word in enumerate(args[:ends]):
            if word == MEMORY or word.startswith(f"{MEMORY}="):
                length = 2 if word == MEMORY else 1
                if index + length > ends:
                    break  # the number is missing
                args = args[index : index + length] + args[:index] + args[index + length :]
                break
        return super().parse_args(ctx, args)

    def format_commands(self, _: Any, formatter: Any) -> None:
        """Write what each command does in full; click's own list cuts it after some words."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, command.help) for name, command in self.commands.items()])


app = typer.Typer(
    cls=Program,
    help="Elastic contact with finite and virtual elements: a wheelset on two rails in three dimensions, plane bodies.",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120},
    rich_markup_mode=None,  # to load what draws boxes around the help takes twice as long as all the rest
    invoke_without_command=True,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from flangeway.system.output_folder import versions  # noqa: PLC0415

        typer.echo(f"flangeway {versions()['flangeway']}")
        raise typer.Exit(DONE)


@app.callback()
def _common(
    context: typer.Context,
    version: Annotated[  # noqa: ARG001 (its callback shows it)
        bool, typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version)
    ] = False,
    memory: Annotated[
        float | None,
        typer.Option(MEMORY, metavar="GB", help="Maximum memory to use (default: what is free)."),
    ] = None,
    debug: Annotated[  # noqa: ARG001 (`main` looks for it)
        bool, typer.Option(DEBUG, help="Show the traceback of an unexpected error.")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(DONE)
    if any(name.startswith("RAYON_") for name in os.environ):  # else the core is not needed yet
        with errors_as_exit_status():
            from flangeway.space.core_limits import refuse_many_threads  # noqa: PLC0415

            refuse_many_threads()
    if memory is not None:
        context.with_resource(_memory_limited(memory))


@contextmanager
def _memory_limited(gigabytes: float) -> Iterator[None]:
    """Set the variable of the limit, which processes of a campaign inherit."""
    with errors_as_exit_status():
        if not gigabytes > 0.0:
            raise InputError(f"{MEMORY} {gigabytes:g}", "a positive number of gigabytes", "correct it, or leave it out")
    with environment({MEMORY_VARIABLE: repr(gigabytes)}):
        yield


def _wants_debugging(args: list[str]) -> bool:
    return DEBUG in args[: args.index("--") if "--" in args else None]


def main() -> None:
    """Run the command line and exit with its status; an internal error ends in one sentence."""
    with environment({DEBUG_VARIABLE: "1"} if _wants_debugging(sys.argv[1:]) else {}):
        sys.exit(_status())


def _status() -> int:
    for stream in (sys.stdout, sys.stderr):  # letters that the terminal lacks are no reason to fail
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # the class is typer's own or click's, as typer's version wants it
    usage_error = cast(type[Exception], typer.BadParameter.__base__)
    try:
        for word in sys.argv[1:]:
            if not word.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in word):
                raise typer.BadParameter(f"an argument that is no text in UTF-8: {word!r}")
        status = int(app(prog_name="flangeway", standalone_mode=False) or DONE)
        sys.stdout.flush()  # not when Python ends, where nothing reports an error
        return status
    except usage_error as error:
        complain(_usage_message(error))
        return WRONG_INPUT
    except (KeyboardInterrupt, typer.Abort):
        complain(NOTHING_WRITTEN)
        return INTERRUPTED
    except Exception as error:
        if not (isinstance(error, OSError) and error.errno in UNWRITABLE and error.filename is None):
            complain(unforeseen(error))
            return WRONG_INPUT
        # the rest of the output is dropped; a reader that has closed its pipe wants no message
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if error.errno != errno.EPIPE:
            advice = "free some space, or direct the output to another place"
            complain(
                str(InputError(f"output that cannot be written: {error.strerror}", "a file with space left", advice))
            )
        return FAILED


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
    advice = f"`{context.command_path} --help` explains them"
    if "=" in given and "--set" in options:
        advice = f"give inputs as --set KEY=VALUE, one --set for each; {advice}"
    return str(InputError(given, known, advice))
