"""What commands share: exit statuses, errors as messages, progress, ``--out``, ``--set``, ``--unit``.

NumPy, SciPy, Matplotlib and what needs them are imported inside of functions, so that help is quick.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from flangeway.errors import InputError, MissingLibraryError, OutOfMemoryError

Progress = Callable[[str], None]

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
NOTHING_WRITTEN = "interrupted; nothing was written"


def path_given(text: str) -> Path:
    """Return the path that an option names; an empty name is refused, which `Path` would take for the folder here."""
    if not text.strip():
        raise typer.BadParameter("an empty name")
    return Path(text)


Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for the results.", show_default=False, parser=path_given),
]
Unit = Annotated[
    str | None,
    typer.Option("--unit", metavar="[mm|cm|m|in|ft]", help="Unit of a file that names none.", show_default=False),
]


def settings_of(settings: list[str] | None, advice: str) -> dict[str, Any]:
    """Return the values of ``--set``, by key."""
    from flangeway.cases.case import GivenText  # noqa: PLC0415

    given: dict[str, Any] = {}
    for setting in settings or []:
        key, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}", "--set KEY=VALUE", advice)
        given[key.strip()] = GivenText(value.strip())
    return given


@contextmanager
def errors_as_exit_status() -> Iterator[None]:
    """Turn the errors that users can meet into a message and an exit status."""
    try:
        with interruption_reported():
            yield
    except InputError as error:
        complain(str(error))
        raise typer.Exit(WRONG_INPUT) from None
    except MissingLibraryError as error:
        complain(str(error))
        raise typer.Exit(FAILED) from None
    except MemoryError as error:
        if not isinstance(error, OutOfMemoryError):
            error = OutOfMemoryError(str(error.args[0]) if error.args else "a computation")
        complain(f"out of memory, nothing was written: {error}")
        raise typer.Exit(FAILED) from None


@contextmanager
def interruption_reported() -> Iterator[None]:
    """Turn Ctrl-C into a message and an exit status."""
    try:
        yield
    except KeyboardInterrupt:
        complain(NOTHING_WRITTEN)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def progress_shown() -> Iterator[Progress]:
    """Show sentences on stderr: one changing line on a terminal, a line each elsewhere."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress as Bar  # noqa: PLC0415
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    from flangeway.mesh import long_meshes_reported  # noqa: PLC0415

    console = Console(stderr=True)
    if not console.is_terminal:
        with long_meshes_reported(show_progress):
            yield show_progress
        return
    columns = (SpinnerColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(sentence: str) -> None:
            bar.update(task, description=sentence)

        with long_meshes_reported(show):
            yield show


def show_progress(sentence: str) -> None:
    """Show a sentence on stderr, in a line of its own."""
    print(sentence, file=sys.stderr, flush=True)


def stdout() -> Any:
    """Return the terminal for results."""
    from rich.console import Console  # noqa: PLC0415

    return Console(highlight=False)


def complain(message: str) -> None:
    """Report an error on stderr."""
    typer.echo(f"flangeway: {message}", err=True)
