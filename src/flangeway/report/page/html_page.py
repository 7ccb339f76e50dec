"""The report: one HTML page with all pictures inside, which needs no network; the same for every kind of case."""

import base64
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from string import Template

from flangeway.report.page.tables import SummaryTable
from flangeway.report.viewer import Scene, field_viewer

SHOWN_SIZE = 0.55  # pixels of the page for one of a picture, so that letters have one size in wide and narrow pictures
INSTEAD = "The figures below show the most important fields."


@dataclass(frozen=True)
class Picture:
    """A picture of the report."""

    png: bytes  # contents of a PNG file
    alternative: str  # what it shows, for those who do not see it
    caption: str  # text below it


@dataclass(frozen=True)
class Again:
    """How to run a case again."""

    command: str  # the command; of cases with tables, which no command has room for, the one that runs the case file
    case_file: str  # text of a case file that computes the same
    file_name: str = ""  # name of that file in `command`, empty where the command needs none
    files: str = ""  # sentences on the other files of the run, their names between backticks


@dataclass(frozen=True, eq=False)
class Page:
    """Content of a report; what is left out or empty has no place on the page."""

    title: str
    subtitle: str  # title, subtitle: what was computed, and how
    converged: bool
    message: str  # converged, message: how it ended
    facts: Sequence[tuple[str, str]]  # the most important numbers with units, and what they are
    again: Again  # how to run it again
    versions: Mapping[str, str]  # versions of what it was made with, by name
    sentences: Sequence[str] = ()  # further sentences of the summary
    warnings: Sequence[str] = ()
    assumptions: Sequence[str] = ()  # warnings, assumptions: sentences
    scene: Scene | None = None  # what the interactive picture shows
    pictures: Sequence[Picture] = ()  # pictures, the most important first
    tables: Sequence[SummaryTable] = ()  # numbers
    axes: Mapping[str, str] = field(default_factory=dict)  # meanings of axes and signs by name
    inputs: Sequence[SummaryTable] = ()  # tables of inputs


def report_page(page: Page) -> str:
    """Return the page: summary first, then warnings, assumptions, fields, pictures, tables, inputs and the command."""
    sections = (
        _section("summary", "Summary", _summary(page)),
        _section("warnings", "Warnings", _items(page.warnings, " warning")),
        _section("assumptions", "Assumptions", _items(page.assumptions)),
        _section("fields", "Fields", field_viewer(page.scene, INSTEAD if page.pictures else "") if page.scene else ""),
        _section("pictures", "Pictures", "\n".join(_figure(picture) for picture in page.pictures)),
        _section("numbers", "Numbers", _tables(page.tables) + _axes(page.axes)),
        _section("inputs", "Inputs", _tables(page.inputs)),
        _section("again", "Run it again", _again(page.again)),
    )
    return Template(_text("page.html")).substitute(
        title=escape(page.title),
        subtitle=escape(page.subtitle),
        failed="" if page.converged else " failed",
        verdict="Converged:" if page.converged else "Not converged:",
        message=escape(page.message),
        sections="\n".join(section for section in sections if section),
        program=_text("page.js"),
        versions=escape("Made with " + ", ".join(f"{name} {text}" for name, text in page.versions.items())),
    )


def _text(name: str) -> str:
    return (files("flangeway.report.page") / name).read_text(encoding="utf-8")


def _section(name: str, heading: str, body: str) -> str:
    """Return a section under a heading, nothing if it would be empty."""
    if not body:
        return ""
    return f'<section aria-labelledby="{name}">\n<h2 id="{name}">{heading}</h2>\n{body}\n</section>'


def _summary(page: Page) -> str:
    facts = "\n".join(
        f'<li><span class="value">{escape(value)}</span><span class="name">{escape(name)}</span></li>'
        for value, name in page.facts
    )
    return "\n".join([f'<ul class="facts">\n{facts}\n</ul>', *(f"<p>{escape(each)}</p>" for each in page.sentences)])


def _again(again: Again) -> str:
    command = f'<pre data-copy="the command"><code>{escape(again.command)}</code></pre>'
    case_file = f'<pre data-copy="the case file"><code>{escape(again.case_file)}</code></pre>'
    if again.file_name:
        first = f"<p>Save this as <code>{escape(again.file_name)}</code> in the folder where you ran it:</p>"
        parts = [first, case_file, "<p>and run it:</p>", command]
    else:
        other = (
            "<p>Or put this into a file, change what you like, and give the file's name to "
            "<code>flangeway run</code>:</p>"
        )
        parts = [command, other, case_file]
    if again.files:
        parts.append("<p>{}</p>".format(re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(again.files))))
    return "\n".join(parts)


def _tables(tables: Sequence[SummaryTable]) -> str:
    if not tables:
        return ""
    return '<div class="tables">\n{}\n</div>'.format("\n".join(_table(table) for table in tables))


def _axes(axes: Mapping[str, str]) -> str:
    if not axes:
        return ""
    rows = "\n".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in axes.items())
    return f"\n<h3>Axes and signs</h3>\n<dl>\n{rows}\n</dl>"


def _items(sentences: Sequence[str], kind: str = "") -> str:
    if not sentences:
        return ""
    items = "\n".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f'<ul class="plain{kind}">\n{items}\n</ul>'


def _figure(picture: Picture) -> str:
    data = base64.b64encode(picture.png).decode("ascii")
    # width in the head of a PNG file
    width = round(int.from_bytes(picture.png[16:20], "big") * SHOWN_SIZE)
    return (
        f'<figure><div class="scroll"><img style="max-width: {width}px" alt="{escape(picture.alternative)}" '
        f'src="data:image/png;base64,{data}"></div>\n'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def _table(table: SummaryTable) -> str:
    kind = ' class="words"' if table.of_words else ""
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in table.header)
    rows = "\n".join(
        f'<tr><th scope="row">{escape(row[0])}</th>{"".join(_cell(text) for text in row[1:])}</tr>'
        for row in table.rows
    )
    return (
        f'<div class="scroll"><table{kind}>\n<caption>{escape(table.caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table></div>"
    )


def _cell(text: str) -> str:
    is_number = re.fullmatch(r"–|yes|no|[-+(\d.,) e/–]+", text)
    return f"<td>{escape(text)}</td>" if is_number else f'<td class="text">{escape(text)}</td>'
