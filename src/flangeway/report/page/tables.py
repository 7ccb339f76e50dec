"""Tables, and what all commands print alike: tables without a frame, how a run ended, notices, and the files."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.cases.summary import StatusSummary
from flangeway.solve import Status


@dataclass(frozen=True)
class SummaryTable:
    """A table of text, for the terminal, an HTML page or a page in Markdown."""

    caption: str
    header: tuple[str, ...]  # names of the columns with their units
    rows: tuple[tuple[str, ...], ...]  # the first cell of each row names it
    of_words: bool = False  # whether the cells are words rather than numbers, and are aligned on the left

    def markdown(self) -> str:
        """Return its lines, without the caption."""
        lines = [self.header, ("---",) * len(self.header), *self.rows]
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


Column = tuple[str, str | Callable[[Any], Any], str]
"""Heading, attribute of an object or function of it, and format of the value."""


def table_of(caption: str, objects: Iterable[Any], columns: Sequence[Column]) -> SummaryTable:
    """Return a table with a row for each object; missing values are dashes."""
    rows = tuple(tuple(cell_text(each, key, form) for _, key, form in columns) for each in objects)
    return SummaryTable(caption, tuple(name for name, _, _ in columns), rows)


def table_across(
    caption: str, names: Iterable[str], objects: Sequence[Any], quantities: Iterable[Column]
) -> SummaryTable:
    """Return a table with a column for each object, headed by its name, and a row for each quantity."""
    rows = tuple((name, *(cell_text(each, key, form) for each in objects)) for name, key, form in quantities)
    return SummaryTable(caption, ("", *names), rows)


def cell_text(of: Any, key: str | Callable[[Any], Any], form: str) -> str:
    """Return the text of an attribute, or of a function of an object; points are in brackets, None is a dash."""
    value = getattr(of, key) if isinstance(key, str) else key(of)
    if isinstance(value, list | tuple):
        return f"({', '.join(format(each, form) for each in value)})"
    return "–" if value is None else format(value, form)


def timings_table(timings_s: Mapping[str, float]) -> SummaryTable:
    """Seconds of each stage."""
    rows = [(name.replace("_", "-"), number(t, 2)) for name, t in timings_s.items()]
    return SummaryTable("Time", ("", "s"), tuple(rows))


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with the reason why it is approximate, if there is one."""
    return text if remark is None else f"about {text} ({remark})"


def number(value: float | None, digits: int) -> str:
    """Return a number with some decimals, or a dash for None."""
    return "–" if value is None else f"{value:.{digits}f}"


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


def print_table(console: Console, table: SummaryTable) -> None:
    """Print a table below its caption; a single column of values needs no header."""
    shown = plain_table()
    shown.show_header = any(table.header[2:])
    for place, name in enumerate(table.header):
        shown.add_column(name, justify="left" if place == 0 else "right")
    for row in table.rows:
        shown.add_row(*row)
    console.print(table.caption, style="bold")
    console.print(shown)
    console.print()


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
