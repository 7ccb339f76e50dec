"""The report, one HTML page with all pictures inside that needs no network, and the other files of a record."""

import base64
import re
import time
from collections.abc import Callable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from flangeway.cases.summary import write_summary
from flangeway.report.figures.drawing import png
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import About, SummaryTable, timings_table
from flangeway.report.viewer import field_viewer
from flangeway.system.output_folder import bytes_writer, text_writer, write_together

SHOWN_SIZE = 0.55  # pixels of the page for one of a picture, so that letters have one size in wide and narrow pictures
LONG, SHORT = 40, 12  # rows of a table above which it is folded, letters of a cell up to which it is not broken
NUMBER_CELL = re.compile(r"–|yes|no||[-+(\d.,) e/–%]+")
INSTEAD = "The figures above and the figures below show the most important fields."
Drawn = Sequence[tuple[Picture, bytes]]  # pictures and the contents of their PNG files


def report_page(record: Record, drawn: Drawn = (), timings_s: Mapping[str, float] | None = None) -> str:
    """Return the page: numbers that matter and the first picture, results, fields, pictures, and all the rest.

    - `drawn`: pictures with the contents of their files.
    - `timings_s`: seconds of each stage; those of the record if left out.
    """
    times = record.timings_s if timings_s is None else timings_s
    tables = [*record.tables, *([timings_table(times)] if times else [])]
    viewer = field_viewer(record.scene(), INSTEAD if drawn else "") if record.scene else ""
    sections = [
        ("summary", "Summary", _summary(record, drawn[:1])),
        ("fields", "Fields", viewer),
        ("pictures", "Pictures", _figures(drawn[1:], "")),
        *((name.lower(), name, _tables(each) + _figures(drawn, name)) for name, each in record.chapters.items()),
        ("numbers", "Numbers", _tables(tables) + _axes(record.axes)),
        ("assumptions", "Assumptions", _items([*record.notes, *record.assumptions])),
        ("inputs", "Inputs", _folded("All inputs with their values and meanings", _tables(record.inputs))),
        ("again", "Run it again", _again(record.again)),
    ]
    present = [(name, heading, body) for name, heading, body in sections if body]
    return Template(_text("page.html")).substitute(
        title=escape(record.title),
        subtitle=escape(record.subtitle),
        kind=" failed" if not record.converged else " warned" if record.warnings else "",
        verdict=escape(f"{record.verdict[0].upper()}{record.verdict[1:]}{':' if record.message else ''}"),
        message=escape(record.message),
        warnings=_items(record.warnings),
        contents="\n".join(f'<a href="#{name}">{heading}</a>' for name, heading, _ in present),
        sections="\n".join(
            f'<section aria-labelledby="{name}">\n<h2 id="{name}">{heading}</h2>\n{body}\n</section>'
            for name, heading, body in present
        ),
        program=_text("page.js"),
        versions=escape("Made with " + ", ".join(f"{name} {text}" for name, text in record.versions.items())),
    )


def write_record(
    record: Record, folder: Path, progress: Callable[[str], None] = lambda _: None, *, pictures: bool = True
) -> list[Path]:
    """Write all files of a record, the report and the summary last, together or not at all.

    - `pictures`: whether pictures are drawn.

    It is an `InputError` if the folder cannot be written.
    """
    start = time.perf_counter()
    drawn: list[tuple[Picture, bytes]] = []
    if record.pictures and pictures:
        progress("drawing the pictures")
        drawn = [(each, png(each.draw())) for each in record.pictures]
    timings_s = {**record.timings_s, "pictures": time.perf_counter() - start} if drawn else record.timings_s
    progress("writing the files")
    writers = {each.file: bytes_writer(data) for each, data in drawn} | dict(record.files())
    writers[REPORT] = text_writer(report_page(record, drawn, timings_s))
    writers[record.summary_file] = lambda path: write_summary(path, record.summary)
    return write_together(folder, writers)


def _text(name: str) -> str:
    return (files("flangeway.report.page") / name).read_text(encoding="utf-8")


def _figures(drawn: Drawn, chapter: str) -> str:
    return "\n".join(_figure(*each) for each in drawn if each[0].chapter == chapter)


def _summary(record: Record, first: Drawn) -> str:
    facts = "\n".join(
        f'<li><span class="value">{_marked(value)}</span><span class="name">{escape(name)}</span></li>'
        for value, name in record.facts
    )
    parts = [
        f'<ul class="facts">\n{facts}\n</ul>' if facts else "",
        *(_figure(*each) for each in first),
        _tables([record.results]),
        *(f"<p>{_text_with_names(each)}</p>" for each in record.sentences),
    ]
    return "\n".join(part for part in parts if part)


def _again(again: Again) -> str:
    command = f'<pre data-copy="the command"><code>{escape(again.command)}</code></pre>'
    case_file = f'<pre data-copy="the case file"><code>{escape(again.case_file)}</code></pre>'
    if not again.case_file:
        parts = [command]
    elif again.file_name:
        first = f"<p>Save this as <code>{escape(again.file_name)}</code> in the folder where you ran it:</p>"
        parts = [first, case_file, "<p>and run it:</p>", command]
    else:
        other = (
            "<p>Or put this into a file, change what you like, and give the file's name to "
            "<code>flangeway run</code>:</p>"
        )
        parts = [command, other, case_file]
    if again.files:
        parts.append(f"<p>{_text_with_names(again.files)}</p>")
    return "\n".join(parts)


def _tables(tables: Sequence[SummaryTable]) -> str:
    if not tables:
        return ""
    return '<div class="tables">\n{}\n</div>'.format("\n".join(_table(table) for table in tables))


def _folded(heading: str, body: str) -> str:
    return f"<details><summary>{heading}</summary>\n{body}\n</details>" if body else ""


def _axes(axes: Mapping[str, str]) -> str:
    if not axes:
        return ""
    rows = "\n".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in axes.items())
    return f"\n<h3>Axes and signs</h3>\n<dl>\n{rows}\n</dl>"


def _text_with_names(text: str) -> str:
    """Names of files and keys are between backticks."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def _items(sentences: Sequence[str]) -> str:
    if not sentences:
        return ""
    items = "\n".join(f"<li>{_text_with_names(sentence)}</li>" for sentence in sentences)
    return f'<ul class="plain">\n{items}\n</ul>'


def _figure(picture: Picture, content: bytes) -> str:
    data = base64.b64encode(content).decode("ascii")
    # width in the head of a PNG file
    width = round(int.from_bytes(content[16:20], "big") * SHOWN_SIZE)
    return (
        f'<figure><div class="scroll"><img style="max-width: {width}px" alt="{escape(picture.alternative)}" '
        f'src="data:image/png;base64,{data}"></div>\n'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def _table(table: SummaryTable) -> str:
    kind = ' class="words"' if table.of_words else ""
    words = {i for i, text in enumerate(table.rows[0] if table.rows else ()) if not NUMBER_CELL.fullmatch(text)}
    head = "".join(
        f'<th scope="col"{" class=text" * (i in words)}>{escape(name)}</th>' for i, name in enumerate(table.header)
    )
    rows = "\n".join(
        f'<tr><th scope="row">{escape(row[0])}</th>{"".join(_cell(text) for text in row[1:])}</tr>'
        for row in table.rows
    )
    remarks = "".join(f'<p class="remark">{escape(remark)}</p>' for remark in table.remarks)
    whole = (
        f'<div class="block"><div class="scroll"><table{kind}>\n<caption>{escape(table.caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table></div>{remarks}</div>"
    )
    return _folded(escape(table.caption), whole) if len(table.rows) > LONG else whole


def _cell(text: str) -> str:
    # browsers fold numbers behind the sign of an exponent
    words, short = not NUMBER_CELL.fullmatch(text), len(text) <= SHORT
    kinds = " ".join(["text"] * words + ["short"] * (short and (words or "e-" in text)))
    kind = f' class="{kinds}"' if kinds else ""
    return f"<td{kind}>{_marked(text)}</td>"


def _marked(text: str) -> str:
    """Mark an approximate value by its style, so that what is copied is the number alone."""
    if isinstance(text, About):
        return f'<span class="about" title="{escape(text.remark)}">{escape(text)}</span>'
    return escape(text)
