"""Tables, and what all commands print alike: tables without a frame, how a run ended, notices, and the files."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.quantities import Quantity
from flangeway.units import Units


@dataclass(frozen=True)
class SummaryTable:
    """A table of text, for the terminal, an HTML page or a page in Markdown."""

    caption: str
    header: tuple[str, ...]  # names of the columns with their units
    rows: tuple[tuple[str, ...], ...]  # the first cell of each row names it
    of_words: bool = False  # whether the cells are words rather than numbers, and are aligned on the left

    @property
    def remarks(self) -> list[str]:
        """Why the approximate values are so."""
        found = dict.fromkeys(cell.remark for row in self.rows for cell in row if isinstance(cell, About))
        return [f"≈ {remark}" for remark in found]

    def markdown(self) -> str:
        """Return its lines, without the caption."""
        lines = [self.header, ("---",) * len(self.header), *self.rows]
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def table_of(
    caption: str, objects: Iterable[Any], quantities: Iterable[Quantity[Any]], units: Units = "metric"
) -> SummaryTable:
    """Return a table with a row for each object and a number in each cell; missing values are dashes."""
    heads, columns = _columns(quantities, list(objects), units)
    return SummaryTable(caption, tuple(heads), tuple(zip(*columns, strict=True)))


def table_across(
    caption: str,
    names: Iterable[str],
    objects: Sequence[Any],
    quantities: Iterable[Quantity[Any]],
    units: Units = "metric",
) -> SummaryTable:
    """Return a table with a column for each object, headed by its name, and a row for each number of a quantity."""
    heads, columns = _columns(quantities, objects, units)
    rows = tuple((head, *cells) for head, cells in zip(heads, columns, strict=True))
    return SummaryTable(caption, ("", *names), rows)


def _columns(
    quantities: Iterable[Quantity[Any]], objects: Sequence[Any], units: Units
) -> tuple[list[str], list[list[str]]]:
    """Names of the numbers of quantities, and their texts for all objects."""
    shown = [quantity for quantity in quantities if quantity.label]
    heads = [name for quantity in shown for name in quantity.labels(units)]
    lines = [[text for quantity in shown for text in texts(quantity, of, units)] for of in objects]
    return heads, [[line[number] for line in lines] for number in range(len(heads))]


def texts(quantity: Quantity[Any], of: Any, units: Units = "metric") -> list[str]:
    """Return the numbers of an object as texts, marked if they are approximate."""
    return [marked(text, quantity.remark(of)) for text in quantity.texts(of, units)]


def rows_of(
    quantities: Iterable[Quantity[Any]], of: Any, units: Units = "metric", owner: str = ""
) -> list[tuple[str, str]]:
    """Return names and texts of the numbers of one object, a row each, the names after that of an owner."""
    heads, columns = _columns(quantities, [of], units)
    return [(f"{owner}: {name}" if owner else name, text) for name, (text,) in zip(heads, columns, strict=True)]


def fact(quantity: Quantity[Any], of: Any, units: Units = "metric", owner: str = "") -> tuple[str, str]:
    """Return the text of a number with its unit, and what it is, and of which owner, for the top of the page."""
    text, label = quantity.fact(of, units)
    return marked(text, quantity.remark(of)), f"{label}, {owner}" if owner else label


def with_whole(
    table: SummaryTable,
    whole: Mapping[str, str],
    groups: Sequence[str] = (),
    of_group: Mapping[str, Mapping[Any, str]] | None = None,
) -> SummaryTable:
    """Return a table of contacts with rows before: of the whole, and of a group in the group's first column.

    - `whole`: texts by their names.
    - `groups`: the group of each column, such as the side of a contact.
    - `of_group`: texts of each group by their names.
    """
    n_columns = len(table.header) - 1
    if not n_columns:
        return replace(table, header=("", "value"), rows=tuple(whole.items()))
    rows = [(name, text, *[""] * (n_columns - 1)) for name, text in whole.items()]
    for name, texts in (of_group or {}).items():
        rows.append(
            (name, *(texts.get(each, "") if groups.index(each) == at else "" for at, each in enumerate(groups)))
        )
    return replace(table, rows=(*rows, *table.rows))


def timings_table(timings_s: Mapping[str, float]) -> SummaryTable:
    """Seconds of each stage; ``total`` is that of computing."""
    rows = [(name.replace("_", "-"), f"{t:.2f}") for name, t in timings_s.items()]
    return SummaryTable("Time", ("", "s"), tuple(rows))


class About(str):
    """The text of a value that is approximate."""

    remark: str = ""  # the reason


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with the reason why it is approximate, if there is one."""
    if not remark:
        return text
    about = About(text)
    about.remark = remark
    return about


def plain_table(*columns: str) -> Table:
    """Return a table without a frame; without columns it has no header either, and they are added to it."""
    return Table(*columns, box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=bool(columns))


def print_table(console: Console, table: SummaryTable) -> None:
    """Print a table of results and the remarks on it; a single column of values needs no header."""
    shown = plain_table()
    shown.show_header = any(table.header[2:])
    for place, name in enumerate(table.header):
        # names of files are read to their ends
        shown.add_column(name, justify="left" if place == 0 or table.of_words else "right", overflow="fold")
    for row in table.rows:
        shown.add_row(*(f"≈ {cell}" if isinstance(cell, About) else cell.strip("*") for cell in row))
    console.print(shown, markup=False)
    for remark in table.remarks:
        console.print(remark, markup=False)


def print_notices(console: Console, notices: Iterable[str], word: str = "Note") -> None:
    """Print what the user should know, a line each."""
    for notice in notices:
        console.print(f"{word}: {notice}", style="yellow", markup=False, soft_wrap=True)
