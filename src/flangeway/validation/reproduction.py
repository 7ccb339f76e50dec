"""One of the studies that ``flangeway reproduce`` can compute, with its files and its summary."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases.case import closest
from flangeway.errors import InputError
from flangeway.report.figures.drawing import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.system.output_folder import Writer, refuse_unwritable, write_together
from flangeway.validation.published_numbers import Reproduced, Row, write_numbers, write_rows
from flangeway.validation.validation_page import Chapter, Verdict, summary_sentence
from flangeway.validation.validation_tables import PageTable, outside, worst_table

ALL = "all"
"""The name of all reproductions together."""
TABLE = "table.csv"


class Compute(Protocol):
    """Computes again what was published, with `quick` only the cheaper part of it."""

    def __call__(self, *, quick: bool = ..., progress: Callable[[str], None] = ...) -> Reproduced:
        """Compute."""


@dataclass(frozen=True)
class Reproduction:
    """One reproduction.

    Parameters
    ----------
    compute
        Called with ``quick`` and ``progress``.
    chapter
        Its chapter of the page of validation.
    figures
        Functions that draw what was computed, by the names of the PNG files.
    rows
        Functions that return the rows of further CSV files, by the files' names; no file is written without rows.
    brief
        Whether it takes seconds only, so that ``all --quick`` computes the whole of it.

    """

    compute: Compute
    chapter: Chapter
    figures: Mapping[str, Callable[[Any], Figure]] = field(default_factory=dict)
    rows: Mapping[str, Callable[[Any], Sequence[Row]]] = field(default_factory=dict)
    brief: bool = False

    @property
    def files(self) -> tuple[str, ...]:
        """Names of all files that it may write."""
        return (*self.figures, *self.rows, TABLE)

    def check_folder(self, folder: Path) -> None:
        """Refuse a folder that cannot take the files; see `flangeway.system.output_folder.refuse_unwritable`."""
        refuse_unwritable(folder, self.files)

    def write(self, found: Reproduced, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
        """Write figures and tables into a folder, together or not at all; return the files.

        Raises
        ------
        InputError
            If the folder cannot be written.

        """
        writers: dict[str, Writer] = {}
        for name, draw in self.figures.items():
            progress(f"drawing {name}")
            writers |= picture_writers({name: draw(found)})
        for name, make in self.rows.items():
            rows = make(found)
            if rows:
                writers[name] = partial(write_rows, rows=rows)
        writers[TABLE] = lambda path: write_numbers(path, found.numbers)
        return write_together(folder, writers)

    def print_summary(self, console: Console, found: Reproduced, files: Sequence[Path]) -> None:
        """Print the verdict, what failed, the largest deviation of each quantity, further tables, and the files."""
        style = "bold green" if found.passed else "bold red"
        console.print(f"{self.chapter.title}: {summary_sentence(found)}", style=style, markup=False, soft_wrap=True)
        for failure in found.failures:
            console.print(f"  {failure}", style="red", markup=False, soft_wrap=True)
        for number, text in outside(found.numbers):
            style = "red" if number.required else "yellow"
            console.print(f"  {text}", style=style, markup=False, soft_wrap=True)
        for table in (worst_table(found.numbers), *self.chapter.tables(found)):
            _print_table(console, table)
        print_files(console, files, found.seconds)


def _print_table(console: Console, table: PageTable) -> None:
    console.print(f"{table.caption}:", markup=False)
    shown = plain_table(*table.head)
    for row in table.rows:
        shown.add_row(*(cell.strip("*") for cell in row))
    console.print(shown, markup=False)


def find_reproductions(name: str, known: Mapping[str, Reproduction]) -> dict[str, Reproduction]:
    """Return the reproduction of that name among those known, or every one for ``"all"``.

    Raises
    ------
    InputError
        If there is none.

    """
    if name == ALL:
        return dict(known)
    if name not in known:
        names = [*known, ALL]
        raise InputError(f"a reproduction called {name!r}", f"one of: {', '.join(names)}", closest(name, names))
    return {name: known[name]}


def print_verdicts(console: Console, verdicts: Mapping[str, Verdict]) -> None:
    """Print a line for each reproduction: numbers with a limit, those within, others, verdict and time."""
    shown = plain_table("reproduction")
    for name in ("with a limit", "within", "shown only", "verdict", "seconds"):
        shown.add_column(name, justify="right")
    for key, verdict in verdicts.items():
        counts = (verdict.n_required, verdict.n_within, verdict.n_shown)
        word, style = ("passed", "green") if verdict.passed else ("not passed", "bold red")
        shown.add_row(key, *map(str, counts), word, f"{verdict.seconds:.1f}", style=style)
    console.print(shown)
