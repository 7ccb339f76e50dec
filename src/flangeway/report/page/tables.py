"""Tables, and what all commands print alike: tables without a frame, how a run ended, notices, and the files."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
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
    note: str = ""  # what limits the use of its numbers

    @property
    def remarks(self) -> list[str]:
        """Why the approximate values are so, and what limits the use of the numbers."""
        found = dict.fromkeys(cell.remark for row in self.rows for cell in row if isinstance(cell, About))
        return [*(f"≈ {remark}" for remark in found), *([self.note] if self.note else [])]

    def markdown(self) -> str:
        """Return its lines, without the caption."""
        lines = [self.header, ("---",) * len(self.header), *self.rows]
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


Column = tuple[str, str | Callable[[Any], Any], str] | Quantity[Any]
"""A quantity; or heading, attribute of an object or function of it, and format of the value."""


def table_of(
    caption: str, objects: Iterable[Any], columns: Sequence[Column], note: str = "", units: Units = "metric"
) -> SummaryTable:
    """Return a table with a row for each object and a number in each cell; missing values are dashes."""
    objects = list(objects)
    found = [_cells(column, objects, units) for column in _shown(columns)]
    heads = tuple(head for heads, _ in found for head in heads)
    rows = zip(*(cells for _, lines in found for cells in lines), strict=True)
    return SummaryTable(caption, heads, tuple(rows), note=note)


def table_across(
    caption: str,
    names: Iterable[str],
    objects: Sequence[Any],
    quantities: Iterable[Column],
    note: str = "",
    units: Units = "metric",
) -> SummaryTable:
    """Return a table with a column for each object, headed by its name, and a row for each number of a quantity."""
    found = [_cells(quantity, objects, units) for quantity in _shown(quantities)]
    rows = tuple((head, *cells) for heads, lines in found for head, cells in zip(heads, lines, strict=True))
    return SummaryTable(caption, ("", *names), rows, note=note)


def rows_of(
    quantities: Iterable[Quantity[Any]], of: Any, units: Units = "metric", owner: str = ""
) -> list[tuple[str, str]]:
    """Return names and texts of the numbers of one object, a row each, the names after that of an owner."""
    table = table_across("", ("",), [of], quantities, units=units)
    return [(f"{owner}: {name}" if owner else name, text) for name, text in table.rows]


def fact(quantity: Quantity[Any], of: Any, units: Units = "metric", owner: str = "") -> tuple[str, str]:
    """Return the text of a number with its unit, and what it is, and of which owner, for the top of the page."""
    text, label = quantity.fact(of, units)
    return marked(text, quantity.remark(of)), f"{label}, {owner}" if owner else label


def _shown(columns: Iterable[Column]) -> list[Column]:
    return [column for column in columns if not isinstance(column, Quantity) or column.label]


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


def _cells(column: Column, objects: Sequence[Any], units: Units) -> tuple[list[str], list[list[str]]]:
    """Names and texts of the numbers of a quantity: of several numbers each has its own, as "{x|y} of a point"."""
    if isinstance(column, Quantity):
        rows = [[marked(text, column.remark(of)) for text in column.texts(of, units)] for of in objects]
        names = column.labels(units)
        return names, [[row[number] for row in rows] for number in range(len(names))]
    name, key, form = column
    values = [getattr(of, key) if isinstance(key, str) else key(of) for of in objects]
    choice = re.search(r"\{(.*?)\}", name)
    if choice is None:
        return [name], [[cell_text(value, form) for value in values]]
    words, forms = choice[1].split("|"), form.split("|")
    forms *= len(words) // len(forms)
    lines = [
        [cell_text(None if value is None else value[place], forms[place]) for value in values]
        for place in range(len(words))
    ]
    return [name.replace(choice[0], word) for word in words], lines


def cell_text(value: Any, form: str) -> str:
    """Return the text of a value; None is a dash."""
    return "–" if value is None else value if isinstance(value, str) else formatted(value, form)


def timings_table(timings_s: Mapping[str, float]) -> SummaryTable:
    """Seconds of each stage; ``total`` is that of computing."""
    rows = [(name.replace("_", "-"), number(t, 2)) for name, t in timings_s.items()]
    return SummaryTable("Time", ("", "s"), tuple(rows))


class Number(str):
    """The text of a number, which has all its digits and its format for other units."""

    value: float
    form: str


class About(Number):
    """The text of a value that is approximate."""

    remark: str = ""  # the reason


def formatted(value: float, form: str) -> Number:
    """Return the text of a number."""
    found = Number(format(value, form))
    found.value, found.form = value, form
    return found


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with the reason why it is approximate, if there is one."""
    if not remark:
        return text
    found = About(text)
    found.__dict__ |= vars(text) if isinstance(text, Number) else {}
    found.remark = remark
    return found


def number(value: float | None, digits: int) -> str:
    """Return a number with some decimals, or a dash for None."""
    return cell_text(value, f".{digits}f")


def plain_table(*columns: str) -> Table:
    """Return a table without a frame; without columns it has no header either, and they are added to it."""
    return Table(*columns, box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=bool(columns))


def print_table(console: Console, table: SummaryTable) -> None:
    """Print a table of results and the remarks on it; a single column of values needs no header."""
    shown = plain_table()
    shown.show_header = any(table.header[2:])
    for place, name in enumerate(table.header):
        shown.add_column(name, justify="left" if place == 0 or table.of_words else "right")
    for row in table.rows:
        shown.add_row(*(f"≈ {cell}" if isinstance(cell, About) else cell.strip("*") for cell in row))
    console.print(shown, markup=False)
    for remark in table.remarks:
        console.print(remark, markup=False)


def print_notices(console: Console, notices: Iterable[str], word: str = "Note") -> None:
    """Print what the user should know, a line each."""
    for notice in notices:
        console.print(f"{word}: {notice}", style="yellow", markup=False, soft_wrap=True)
