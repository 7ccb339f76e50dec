"""What a command found, once: the terminal, the report and the JSON file show the same record with its tables."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.quantities import Quantity
from flangeway.report.viewer import Scene
from flangeway.system.output_folder import Writer, versions
from flangeway.units import Units

if TYPE_CHECKING:  # drawing alone needs it, and loading it takes as long as the main job
    from matplotlib.figure import Figure

# --- Tables, and what all commands print alike: tables without a frame, how a run ended, notices, and the files.


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
        remarks = dict.fromkeys(cell.remark for row in self.rows for cell in row if isinstance(cell, About))
        return [f"≈ {remark}" for remark in remarks]

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
            (name, *(texts.get(group, "") if groups.index(group) == at else "" for at, group in enumerate(groups)))
        )
    return replace(table, rows=(*rows, *table.rows))


def timings_table(timings_s: Mapping[str, float]) -> SummaryTable:
    """Seconds of each stage; ``total`` is that of computing."""
    rows = [(name.replace("_", "-"), f"{t:.2f}") for name, t in timings_s.items()]
    return SummaryTable("Time", ("", "s"), tuple(rows))


POWERS = str.maketrans("23", "²³")
QUANTITIES = {
    "head_lateral_mm": "railhead lateral displacement",
    "head_vertical_mm": "top of the head, up",
    "head_roll_mrad": "roll of the head",
    "gauge_outward_mm": "gauge-face deflection (outwards)",
    "lateral_mm": "lateral displacement to the right",
    "lateral_over_vertical": "L/V",
    "semi_axes_a_mm": "semi-axis a",
    "semi_axes_b_mm": "semi-axis b",
    "max_pressure_MPa": "maximum pressure",
    "n_patches": "number of patches",
    "angle_deg": "orientation of the major axis",
    "rail_position_x_mm": "x on the rail",
    "rail_position_y_mm": "y on the rail",
    "wheel_position_x_mm": "x on the wheel",
    "wheel_position_y_mm": "y on the wheel",
    "vertical_mm": "vertical displacement, up",
    "car_mass_t": "mass of the car",
    "n_axles": "number of axles",
    "size_scale": "factor on the sizes of the elements",
}
"""What keys mean whose words are not enough."""
NAMES = {"von mises": "von Mises", "hertz": "Hertz", "lame ": "Lamé's ", "max ": "maximum "}
UNIT = re.compile(r"_(km_h|mph|kip|lbf|ksi|ft|N_mm\d|N_mm|N_m|MPa|GPa|mm\d?|mrad|rad|deg|kN|N|m|t|s|in)$")


def named(key: str) -> tuple[str, str]:
    """Words for a key of inputs or results, names with their capitals, and its unit, empty without one."""
    unit = UNIT.search(key)
    words = QUANTITIES.get(key) or (key[: unit.start()] if unit else key).replace("_", " ")
    for letters, name in NAMES.items():
        words = words.replace(letters, name)
    return words, unit[1].replace("_", "/").translate(POWERS) if unit else ""


class About(str):
    """The text of a value that is approximate."""

    remark: str = ""  # the reason


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with the reason why it is approximate, if there is one."""
    if remark is None:
        return text
    about = About(text)
    about.remark = remark
    return about


def plain_table(*columns: str, header: bool = True) -> Table:
    """Return a table without a frame."""
    return Table(*columns, box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=header)


def print_table(console: Console, table: SummaryTable) -> None:
    """Print a table of results and the remarks on it; a single column of values needs no header."""
    shown = plain_table(header=any(table.header[2:]))
    for index, name in enumerate(table.header):
        # names of files are read to their ends
        shown.add_column(name, justify="left" if index == 0 or table.of_words else "right", overflow="fold")
    for row in table.rows:
        shown.add_row(*(f"≈ {cell}" if isinstance(cell, About) else cell.strip("*") for cell in row))
    console.print(shown, markup=False)
    for remark in table.remarks:
        console.print(remark, markup=False)


def print_notices(console: Console, notices: Iterable[str], word: str = "Note") -> None:
    """Print what the user should know, a line each."""
    for notice in notices:
        console.print(f"{word}: {notice}", style="yellow", markup=False, soft_wrap=True)


# --- What a command found, once: the terminal, the report and the JSON file show the same record.


REPORT, SUMMARY = "report.html", "summary.json"
METRIC_FILES = (
    "Numbers of tables, tiles, pictures, CSV files and the workbook are in US units; sentences, and JSON, Parquet and "
    "ParaView files, are metric."
)


@dataclass(frozen=True)
class Picture:
    """A picture of the report, which is a file of its own as well; it is drawn when it is needed."""

    file: str  # name of the PNG file
    draw: Callable[[], "Figure"]
    caption: str  # what it shows
    chapter: str = ""  # the section of the report that it is in, if not that of all pictures


Figures: TypeAlias = "dict[str, Callable[[], Figure]]"
"""Functions that draw pictures, by file name."""


@dataclass(frozen=True)
class Again:
    """How to compute it again."""

    command: str  # the command; of cases with tables, which no command has room for, the one that runs the case file
    case_file: str = ""  # text of a case file that computes the same
    file_name: str = ""  # name of that file in `command`, empty where the command needs none
    files: str = ""  # sentences on the other files, their names between backticks


@dataclass(frozen=True, eq=False, kw_only=True)
class Report:
    """What a command found; what is left out or empty has no place in the report."""

    name: str
    title: str
    subtitle: str  # name, title, subtitle: what was computed, short and in words, and how
    converged: bool
    message: str  # converged, message: how it ended
    success: str = "converged"  # the word for that
    details: Sequence[str] = ()  # project, author, date
    given: Mapping[str, str] = field(default_factory=dict)  # inputs that define it, by their meanings, with units
    facts: Sequence[tuple[str, str]] = ()  # the most important numbers with units, and what they are
    results: SummaryTable  # the one table of results that the terminal shows
    summary: Mapping[str, Any]  # the numbers for programs
    summary_file: str = SUMMARY
    again: Again  # how to compute it again
    versions: Mapping[str, str] = field(default_factory=versions)  # versions of what it was made with, by name
    units: Units = "metric"  # units of tables, pictures and CSV files
    warnings: Sequence[str] = ()
    notes: Sequence[str] = ()  # what was repaired, assumed or left out of what was given
    assumptions: Sequence[str] = ()  # sentences on the model
    scene: Callable[[], Scene] | None = None  # what the interactive picture shows
    pictures: Callable[[], Sequence[Picture]] = list  # the most important first
    tables: Sequence[SummaryTable] = ()  # further numbers
    chapters: Mapping[str, Sequence[SummaryTable]] = field(default_factory=dict)  # sections of their own
    axes: Mapping[str, str] = field(default_factory=dict)  # meanings of axes and signs by name
    inputs: Sequence[SummaryTable] = ()  # tables of inputs
    timings_s: Mapping[str, float] = field(default_factory=dict)  # seconds of each stage
    files: Callable[[], Mapping[str, Writer]] = dict  # functions that write further files, by their names
    with_sections: Callable[[], Mapping[str, Writer]] = dict  # `files` with whole sections, where the case has some

    def __post_init__(self) -> None:
        """Add a note on what is metric where the units are not."""
        if self.units == "us" and METRIC_FILES not in self.assumptions:  # a record that is copied has it
            object.__setattr__(self, "assumptions", [*self.assumptions, METRIC_FILES])

    @property
    def verdict(self) -> str:
        """How it ended, in words."""
        n = len(self.warnings)
        word = self.success if self.converged else f"NOT {self.success}"
        return f"{word} with {n} warning{'s' * (n > 1)}" if n else word


def print_record(console: Console, record: Report, *, quiet: bool = False) -> None:
    """Print how it ended, the warnings, the table of results, and notes; if it is quiet, the first two only."""
    style = "bold red" if not record.converged else "bold yellow" if record.warnings else "bold green"
    console.print(f"{record.name}: ", end="", markup=False)
    console.print(record.verdict, style=style, end="")
    console.print(f", {record.message}" if record.message else "", markup=False, soft_wrap=True)
    print_notices(console, record.warnings, "Warning")
    if quiet:
        return
    console.print(record.subtitle, markup=False)
    print_table(console, record.results)
    print_notices(console, record.notes)
