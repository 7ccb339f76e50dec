"""The page of the documentation that compares published numbers with computed ones: Markdown and pictures.

No number in it is typed: `flangeway reproduce all --quick --page FILE` writes it.
"""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from flangeway.report.figures.drawing import png
from flangeway.system.output_folder import bytes_writer, refuse_unwritable, text_writer, write_together
from flangeway.validation.published_numbers import Reproduced
from flangeway.validation.validation_tables import PageTable, numbers_table, reasons, worst_table

PICTURES = "images"
"""Folder of the pictures, beside the page."""
DPI = 80

HEAD = """# Validation

*Written by `{command}`; all numbers and pictures on this page are generated.*

Numbers computed by flangeway, compared with published numbers and with exact solutions. "Moherdaui (2021)" is T. F.
Moherdaui, *The Virtual Element Method for Wheel-Rail Contact Problems*, São Paulo, 2021. Everything is computed anew:
the cache is not used. The same command writes all numbers with eight digits and more pictures into `out/reproduce`, and
ends with status 1 if a part is not passed.

{extent}

A *difference* is the relative difference of the computed number from the published one; beside a published zero it is
the computed number. A number with a *limit* must be within this limit. A number that is *shown only* has no limit; the
reason for a large difference is given below the table. Round-off is shown as `< 1e-10`, a relative difference below
1e-5 as `< 0.001 %`.
"""
WHOLE = "All meshes of all parts are computed."
QUICK = (
    "With `--quick` the finest mesh of Hertz's problem, the search for the wheel's flange root, and further crowns,\n"
    "meshes and moduli of wheel and rail are left out; without it they are computed as well."
)


@dataclass(frozen=True)
class Verdict:
    """The result of a reproduction.

    Parameters
    ----------
    n_required, n_within, n_shown
        Numbers with a limit, those of them that are within, and numbers that are shown only.
    passed
        Whether it has passed.
    seconds
        Wall-clock time.

    """

    n_required: int
    n_within: int
    n_shown: int
    passed: bool
    seconds: float

    @classmethod
    def of(cls, found: Reproduced) -> "Verdict":
        """Return the verdict on what was computed."""
        required = [number for number in found.numbers if number.required]
        n_within = sum(number.within for number in required)
        return cls(len(required), n_within, len(found.numbers) - len(required), found.passed, found.seconds)


@dataclass(frozen=True)
class PagePicture:
    """A picture of the page.

    Parameters
    ----------
    name
        Name of its file, without ending.
    alt
        Description for readers who cannot see it.
    draw
        Called with what was computed.

    """

    name: str
    alt: str
    draw: Callable[[Any], Figure]


@dataclass(frozen=True)
class Chapter:
    """Texts, pictures and tables of a reproduction on the page.

    Parameters
    ----------
    title
        Heading.
    text
        What is compared, and the source of the published numbers; one paragraph.
    pictures
        Pictures.
    tables
        Called with what was computed; returns further tables.

    """

    title: str
    text: str
    pictures: tuple[PagePicture, ...]
    tables: Callable[[Any], Sequence[PageTable]]


@dataclass(frozen=True)
class PageSection:
    """A part of the page as it is written.

    Parameters
    ----------
    title
        Heading.
    markdown
        Its text.
    verdict
        How it ended.
    pictures
        Contents of the files in `PICTURES`, by name.

    """

    title: str
    markdown: str
    verdict: Verdict
    pictures: Mapping[str, bytes] = field(repr=False)


def summary_sentence(found: Reproduced) -> str:
    """Return how many numbers are within their limits, and whether it has passed."""
    counts = Verdict.of(found)
    shown = f"; {counts.n_shown} more are shown only" if counts.n_shown else ""
    verdict = "Passed." if counts.passed else "Not passed."
    return f"{counts.n_within} of {counts.n_required} numbers with a limit are within{shown}. {verdict}"


def section_text(chapter: Chapter, found: Reproduced, pictures: Sequence[str]) -> str:
    """Return a section: claim, verdict, largest deviations, reasons, pictures at the given paths, tables, numbers."""
    every = numbers_table(found.numbers)
    images = [f"![{each.alt}]({path})" for each, path in zip(chapter.pictures, pictures, strict=True)]
    parts = [
        f"## {chapter.title}",
        textwrap.fill(" ".join(chapter.text.split()), 120),
        summary_sentence(found).replace("Not passed.", "**Not passed.**"),
        worst_table(found.numbers).markdown(),
        "\n".join(f"- {line}" for line in reasons(found.numbers)),
        *images,
        *(f"{table.caption}:\n\n{table.markdown()}" for table in chapter.tables(found)),
        f'<details markdown="1"><summary>{every.caption}</summary>\n\n{every.markdown()}\n\n</details>',
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def make_section(chapter: Chapter, found: Reproduced, page: Path) -> PageSection:
    """Return a section of a page with its pictures drawn."""
    names = _picture_names(chapter, page)
    text = section_text(chapter, found, [f"{PICTURES}/{name}" for name in names])
    drawn = [png(picture.draw(found), DPI) for picture in chapter.pictures]
    return PageSection(chapter.title, text, Verdict.of(found), dict(zip(names, drawn, strict=True)))


def check_page(page: Path, chapters: Sequence[Chapter]) -> None:
    """Refuse a page that cannot be written; see `flangeway.system.output_folder.refuse_unwritable`."""
    refuse_unwritable(page.parent, (page.name,))
    names = [name for chapter in chapters for name in _picture_names(chapter, page)]
    refuse_unwritable(page.parent / PICTURES, tuple(names))


def write_page(page: Path, sections: Sequence[PageSection], *, quick: bool) -> list[Path]:
    """Write the page, and its pictures in the folder `PICTURES` beside it; return the files.

    Raises
    ------
    InputError
        If they cannot be written.

    """
    command = f"flangeway reproduce all {'--quick ' * quick}--page {page.as_posix()}"
    head = HEAD.format(command=command, extent=QUICK if quick else WHOLE)
    text = "\n".join([head, _verdicts(sections), "", *(section.markdown for section in sections)])
    pictures = {name: bytes_writer(data) for section in sections for name, data in section.pictures.items()}
    files = write_together(page.parent / PICTURES, pictures)
    return [*files, *write_together(page.parent, {page.name: text_writer(text)})]


def _picture_names(chapter: Chapter, page: Path) -> list[str]:
    return [f"{page.stem}-{picture.name}.png" for picture in chapter.pictures]


def _verdicts(sections: Sequence[PageSection]) -> str:
    """Return the table of all parts."""
    rows = []
    for section in sections:
        found = section.verdict
        counts = (found.n_required, found.n_within, found.n_shown)
        rows.append((section.title, *map(str, counts), "passed" if found.passed else "**not passed**"))
    head = ("part", "numbers with a limit", "within", "shown only", "verdict")
    return PageTable("", head, tuple(rows)).markdown()
