"""What a command found, once: the terminal, the report and the JSON file show the same record."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.report.page.tables import SummaryTable, print_notices, print_table
from flangeway.report.viewer import Scene
from flangeway.system.output_folder import Writer
from flangeway.system.versions import versions
from flangeway.units import Units, in_us_units

REPORT, SUMMARY = "report.html", "summary.json"
METRIC_FILES = (
    "The page, its pictures, CSV files and the workbook are in US units; JSON, Parquet and ParaView files are metric."
)


@dataclass(frozen=True)
class Picture:
    """A picture of the report, which is a file of its own as well; it is drawn when it is needed."""

    file: str  # name of the PNG file
    draw: Callable[[], Figure]
    caption: str  # what it shows
    chapter: str = ""  # the section of the report that it is in, if not that of all pictures


Figures: TypeAlias = dict[str, Callable[[], Figure]]
"""Functions that draw pictures, by file name."""


@dataclass(frozen=True)
class Again:
    """How to compute it again."""

    command: str  # the command; of cases with tables, which no command has room for, the one that runs the case file
    case_file: str = ""  # text of a case file that computes the same
    file_name: str = ""  # name of that file in `command`, empty where the command needs none
    files: str = ""  # sentences on the other files, their names between backticks


@dataclass(frozen=True, eq=False, kw_only=True)
class Record:
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
    sentences: Sequence[str] = ()  # further sentences of the summary
    warnings: Sequence[str] = ()
    notes: Sequence[str] = ()  # what was repaired, assumed or left out of what was given
    assumptions: Sequence[str] = ()  # sentences on the model
    scene: Callable[[], Scene] | None = None  # what the interactive picture shows
    pictures: Sequence[Picture] = ()  # the most important first
    tables: Sequence[SummaryTable] = ()  # further numbers
    chapters: Mapping[str, Sequence[SummaryTable]] = field(default_factory=dict)  # sections of their own
    axes: Mapping[str, str] = field(default_factory=dict)  # meanings of axes and signs by name
    inputs: Sequence[SummaryTable] = ()  # tables of inputs
    timings_s: Mapping[str, float] = field(default_factory=dict)  # seconds of each stage
    files: Callable[[], Mapping[str, Writer]] = dict  # functions that write further files, by their names

    def __post_init__(self) -> None:
        """Give sentences that computing wrote the units of the record; its numbers are made in them."""
        if self.units == "us":
            for name in ("title", "subtitle", "message", "sentences", "warnings", "notes", "assumptions"):
                text = getattr(self, name)
                converted = in_us_units(text) if isinstance(text, str) else [*map(in_us_units, text)]
                object.__setattr__(self, name, converted)
            if METRIC_FILES not in self.assumptions:  # a record that is copied has it
                object.__setattr__(self, "assumptions", [*self.assumptions, METRIC_FILES])

    @property
    def verdict(self) -> str:
        """How it ended, in words."""
        n = len(self.warnings)
        word = self.success if self.converged else f"NOT {self.success}"
        return f"{word} with {n} warning{'s' * (n > 1)}" if n else word


def print_record(console: Console, record: Record, *, quiet: bool = False) -> None:
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
