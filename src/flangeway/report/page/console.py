"""What all commands print alike: tables without a frame, how a run ended, notices, and the files."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.cases.summary import StatusSummary
from flangeway.solve import Status


def plain_table(*columns: str, title: str | None = None) -> Table:
    """Return a table without a frame; without columns it has no header either, and they are added to it."""
    return Table(*columns, title=title, box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=bool(columns))


def print_rows(console: Console, rows: Iterable[Sequence[str]]) -> None:
    """Print rows of a name, a value below the others by its last digit, and perhaps more words."""
    table = plain_table()
    table.add_column()
    table.add_column(justify="right")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def print_status(console: Console, name: str, status: Status | StatusSummary) -> None:
    """Print how the run of a case ended."""
    word, style = ("Converged", "bold green") if status.converged else ("NOT converged", "bold red")
    console.print(f"{name}: ", end="", markup=False)
    console.print(word, style=style, end="")
    console.print(f", {status.message}", markup=False, soft_wrap=True)


def print_notices(console: Console, notices: Iterable[str], word: str = "Note") -> None:
    """Print what the user should know, a line each."""
    for notice in notices:
        console.print(f"{word}: {notice}", style="yellow", markup=False, soft_wrap=True)


def print_files(console: Console, files: Sequence[Path], seconds: float | None = None) -> None:
    """Print the time, if it is given, and the files."""
    console.print("Files:" if seconds is None else f"Computed in {seconds:.1f} s. Files:", markup=False)
    for file in files:
        console.print(f"  {file}", markup=False, soft_wrap=True)
