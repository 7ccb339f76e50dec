"""A study that ``flangeway reproduce`` computes: its files, its summary, and its chapter of the page of validation."""

import csv
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases.case import closest
from flangeway.cases.summary import plain_numbers
from flangeway.errors import InputError
from flangeway.report.page.record import REPORT, SUMMARY, Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, plain_table
from flangeway.system.output_folder import Writer, refuse_unwritable, text_writer, write_together
from flangeway.system.versions import versions
from studies.published_numbers import (
    Reproduced,
    ReproducedNumber,
    Row,
    numbers_table,
    outside,
    reasons,
    worst_table,
    write_numbers,
    write_rows,
)

HEAD = """# Validation

*Written by `{command}`; all numbers on this page are generated.*

Numbers computed by flangeway, compared with published numbers and with exact solutions. "Moherdaui (2021)" is T. F.
Moherdaui, *The Virtual Element Method for Wheel-Rail Contact Problems*, São Paulo, 2021. Everything is computed anew:
the cache is not used. The tables show the largest deviation of each quantity with a limit; [all numbers]({numbers})
are in a CSV file. The same command writes a report of each part, with pictures, further tables and all numbers, into
`out/reproduce`, and ends with status 1 if a part is not passed.

{extent}

A *difference* is the relative difference of the computed number from the published one, or the computed number less the
published one where the limit is a number without "%" or zero is published. A number with a *limit* must be within this
limit. A number that is *shown only* has no limit; the reason for a large difference is given below the table. Round-off
is shown as `< 1e-10`, a relative difference below 1e-5 as `< 0.001 %`.
"""
WHOLE = "All meshes of all parts are computed."
QUICK = (
    "With `--quick` the finest meshes of Hertz's problem and of bars under short waves, the search for the wheel's\n"
    "flange root, further crowns, meshes and moduli of wheel and rail, and four in five positions and the elements of\n"
    "order 1 of the wheelset in three dimensions are left out; without it they are computed as well."
)


@dataclass(frozen=True)
class Verdict:
    """The result of a reproduction."""

    n_required: int
    n_within: int
    n_shown: int
    """n_required, n_within, n_shown: numbers with a limit, those of them that are within, and numbers that are shown
    only."""
    passed: bool  # whether it has passed
    seconds: float  # wall-clock time

    @classmethod
    def of(cls, found: Reproduced) -> "Verdict":
        """Return the verdict on what was computed."""
        required = [number for number in found.numbers if number.required]
        n_within = sum(number.within for number in required)
        return cls(len(required), n_within, len(found.numbers) - len(required), found.passed, found.seconds)


@dataclass(frozen=True)
class PagePicture:
    """A picture of the page."""

    name: str  # name of its file, without ending
    alt: str  # description for readers who cannot see it
    draw: Callable[[Any], Figure]  # called with what was computed


@dataclass(frozen=True)
class Chapter:
    """Texts, pictures and tables of a reproduction on the page."""

    title: str  # heading
    text: str  # what is compared, and the source of the published numbers; one paragraph
    pictures: tuple[PagePicture, ...]  # pictures
    tables: Callable[[Any], Sequence[SummaryTable]]  # called with what was computed; returns further tables


@dataclass(frozen=True)
class PageSection:
    """A part of the page as it is written."""

    title: str  # heading
    markdown: str  # its text
    verdict: Verdict  # how it ended
    numbers: SummaryTable = field(repr=False)  # all its numbers


def summary_sentence(found: Reproduced) -> str:
    """Return how many numbers are within their limits, and whether it has passed."""
    counts = Verdict.of(found)
    shown = f"; {counts.n_shown} more are shown only" if counts.n_shown else ""
    verdict = "Passed." if counts.passed else "Not passed."
    return f"{counts.n_within} of {counts.n_required} numbers with a limit are within{shown}. {verdict}"


def section_text(chapter: Chapter, found: Reproduced) -> str:
    """Return a section: what is compared, verdict, largest deviations of what has a limit, and reasons."""
    parts = [
        f"## {chapter.title}",
        textwrap.fill(" ".join(chapter.text.split()), 120),
        summary_sentence(found).replace("Not passed.", "**Not passed.**"),
        _short_table(found.numbers).markdown(),
        "\n".join(f"- {line}" for line in reasons(found.numbers)),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def make_section(chapter: Chapter, found: Reproduced) -> PageSection:
    """Return a section of a page."""
    return PageSection(chapter.title, section_text(chapter, found), Verdict.of(found), numbers_table(found.numbers))


def check_page(page: Path) -> None:
    """Refuse a page that cannot be written; see `flangeway.system.output_folder.refuse_unwritable`."""
    refuse_unwritable(page.parent, (page.name, page.with_suffix(".csv").name))


def write_page(page: Path, sections: Sequence[PageSection], *, quick: bool) -> list[Path]:
    """Write the page, and all its numbers as CSV beside it; return the files.

    It is an `InputError` if they cannot be written.
    """
    command = f"flangeway reproduce all {'--quick ' * quick}--page {page.as_posix()}"
    extent, numbers = QUICK if quick else WHOLE, page.with_suffix(".csv").name
    head = HEAD.format(command=command, extent=extent, numbers=numbers)
    rows = [row for section in sections for row in _csv_rows(section)]
    return _written(page, rows, "\n".join([head, _verdicts(sections), "", *(each.markdown for each in sections)]))


def replace_chapters(page: Path, sections: Sequence[PageSection]) -> list[Path]:
    """Write chapters of a page anew, with their numbers and their rows of its first table; return the files.

    It is an `InputError` if the page has no such chapter.
    """
    text = page.read_text(encoding="utf-8")
    with page.with_suffix(".csv").open(encoding="utf-8", newline="") as stream:
        rows: list[Row] = [*csv.DictReader(stream)]
    for section in sections:
        chapter = re.compile(rf"^## {re.escape(section.title)}\n.*?(?=^## |\Z)", re.MULTILINE | re.DOTALL)
        row = re.compile(rf"^\| {re.escape(section.title)} \|.*$", re.MULTILINE)
        if not (chapter.search(text) and row.search(text)):
            raise InputError(
                f"{page} without the chapter {section.title!r}", "a page of validation", "write it by reproduce all"
            )
        text = row.sub(lambda _, new=section: _verdicts([new]).splitlines()[-1], text, count=1)  # type: ignore[misc]
        last = chapter.search(text).end() == len(text)  # type: ignore[union-attr]
        start = next(i for i, row in enumerate(rows) if row["part"] == section.title)
        others = [row for row in rows if row["part"] != section.title]
        rows = [*others[:start], *_csv_rows(section), *others[start:]]
        text = chapter.sub(lambda _, new=section, end="" if last else "\n": new.markdown + end, text)  # type: ignore[misc]
    return _written(page, rows, text)


def _csv_rows(section: PageSection) -> list[Row]:
    table = section.numbers
    return [{"part": section.title, **dict(zip(table.header, row, strict=True))} for row in table.rows]


def _written(page: Path, rows: Sequence[Row], text: str) -> list[Path]:
    writers: dict[str, Writer] = {page.with_suffix(".csv").name: partial(write_rows, rows=rows)}
    return write_together(page.parent, writers | {page.name: text_writer(text)})


def _verdicts(sections: Sequence[PageSection]) -> str:
    """Return the table of all parts."""
    rows = []
    for section in sections:
        found = section.verdict
        counts = (found.n_required, found.n_within, found.n_shown)
        rows.append((section.title, *map(str, counts), "passed" if found.passed else "**not passed**"))
    head = ("part", "numbers with a limit", "within", "shown only", "verdict")
    return SummaryTable("", head, tuple(rows)).markdown()


ALL = "all"  # the name of all reproductions together
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
        return (*self.figures, *self.rows, TABLE, REPORT, SUMMARY)

    def check_folder(self, folder: Path) -> None:
        """Refuse a folder that cannot take the files; see `flangeway.system.output_folder.refuse_unwritable`."""
        refuse_unwritable(folder, self.files)

    def record(self, name: str, found: Reproduced, command: str) -> Record:
        """Return what was found, under a name; `command` computes it again."""
        chapter, required = self.chapter, [number for number in found.numbers if number.required]
        described = {_function(picture.draw): picture.alt for picture in chapter.pictures}
        words = {
            file: f"{described.get(_function(draw)) or _described(file, draw)}".rstrip(".") + "."
            for file, draw in self.figures.items()
        }
        remarks = [text for number, text in outside(found.numbers) if not number.required]
        return Record(
            name=name,
            title=chapter.title,
            subtitle="Computed numbers beside published or exact ones",
            converged=found.passed,
            success="passed",
            message=summary_sentence(found).removesuffix(" Passed.").removesuffix(" Not passed."),
            facts=[
                (f"{sum(number.within for number in required)} of {len(required)}", "numbers with a limit within it"),
                *([(f"{others}", "numbers shown only")] if (others := len(found.numbers) - len(required)) else []),
            ],
            results=_short_table(found.numbers),
            summary={
                "name": name,
                "title": chapter.title,
                "passed": found.passed,
                "failures": list(found.failures),
                "numbers": [plain_numbers(asdict(number)) for number in found.numbers],
                "seconds": found.seconds,
                "versions": versions(),
            },
            again=Again(command, files=f"All numbers, for spreadsheets, are in `{TABLE}`."),
            versions=versions(),
            sentences=[" ".join(chapter.text.split())],
            warnings=[*found.failures, *(text for number, text in outside(found.numbers) if number.required)],
            assumptions=remarks,
            pictures=[Picture(file, partial(draw, found), words[file]) for file, draw in self.figures.items()],
            tables=[worst_table(found.numbers), *chapter.tables(found), numbers_table(found.numbers)],
            timings_s={"total": found.seconds},
            files=lambda: self._files(found),
        )

    def _files(self, found: Reproduced) -> dict[str, Writer]:
        """Return functions that write the tables, by the files' names."""
        rows = {name: make(found) for name, make in self.rows.items()}
        writers: dict[str, Writer] = {name: partial(write_rows, rows=each) for name, each in rows.items() if each}
        return writers | {TABLE: lambda path: write_numbers(path, found.numbers)}


def _function(draw: Callable[[Any], Figure]) -> object:
    """What is the same for two partial functions that are."""
    return (draw.func, *draw.keywords.items()) if isinstance(draw, partial) else draw


def _described(file: str, draw: Callable[[Any], Figure]) -> str:
    """Words of a file's name, and the first sentence of the function that draws it."""
    function = draw.func if isinstance(draw, partial) else draw
    sentence = (function.__doc__ or "").partition("\n")[0].removeprefix("Draw ")
    name = Path(file).stem.replace("_", " ")
    return f"{name[0].upper()}{name[1:]}: {sentence[:1].lower()}{sentence[1:]}"


def _short_table(numbers: Sequence[ReproducedNumber]) -> SummaryTable:
    """Return the largest deviation of each quantity with a limit, without the numbers themselves."""
    whole = worst_table(number for number in numbers if number.required)
    columns = [whole.header.index(name) for name in ("quantity", "difference", "limit", "within")]
    rows = tuple(tuple(row[column] for column in columns) for row in whole.rows)
    return SummaryTable("Largest deviation of each quantity", ("", "difference", "limit", "within"), rows)


def find_reproductions(name: str, known: Mapping[str, Reproduction]) -> dict[str, Reproduction]:
    """Return the reproduction of that name among those known, or every one for ``"all"``.

    It is an `InputError` if there is none.
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
