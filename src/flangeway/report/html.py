"""The report: one HTML page with all pictures inside, which needs no network."""

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from flangeway.railway.discretisation import Role
from flangeway.report.case_text import case_text
from flangeway.report.command import command_line
from flangeway.report.compact import compact_png
from flangeway.report.fields import PartFields
from flangeway.report.tables import (
    Table,
    bending_table,
    bodies_table,
    contact_name,
    contacts_table,
    motion_table,
    number,
    rigid_table,
    stresses_table,
    support_table,
    timings_table,
)
from flangeway.report.viewer import View, field_viewer
from flangeway.study import CaseRun

VIEW_WIDTHS = 8.0
"""Width of the view of a contact over the half width of the contact."""


@dataclass(frozen=True)
class Picture:
    """A picture of the report.

    Parameters
    ----------
    png
        Contents of a PNG file.
    alternative
        What it shows, for those who do not see it.
    caption
        What stands below it.

    """

    png: bytes
    alternative: str
    caption: str


def report_page(run: CaseRun, pictures: Iterable[Picture], parts: Sequence[PartFields] = ()) -> str:
    """Return the page: summary first, then assumptions, fields, pictures, tables, inputs and the command.

    Parameters
    ----------
    run
        The run.
    pictures
        Pictures, the most telling first.
    parts
        Fields of the parts, for the interactive picture; without any the page has none.

    """
    summary = run.summary
    status = summary["status"]
    problem = run.result.model.problem
    contacts = (contacts_table,) if summary["contacts"] else ()
    tables = (
        *(*contacts, motion_table, rigid_table, bending_table),
        *(support_table, stresses_table, bodies_table, timings_table),
    )
    return Template(_text("page.html")).substitute(
        title=escape(run.case.title),
        subtitle=escape(
            f"Wheel {problem.wheelset.wheel.title} on rail {problem.track.rail.title}; plane strain, "
            f"{problem.thickness_mm:g} mm of length; {_method(run)}"
        ),
        failed="" if status["converged"] else " failed",
        verdict="Converged:" if status["converged"] else "Not converged:",
        message=escape(status["message"]),
        facts="\n".join(_facts(summary)),
        sentence=escape(_reference(summary)),
        warnings=_warnings(summary["warnings"]),
        fields=_fields(summary, parts),
        figures="\n".join(_figure(picture) for picture in pictures),
        tables="\n".join(_table(table(summary)) for table in tables),
        axes="\n".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in summary["axes"].items()),
        assumptions=_items(summary["assumptions"]),
        inputs=_table(_inputs(run)),
        command=escape(command_line(run.case)),
        case_file=escape(case_text(run.case)),
        program=_text("page.js"),
        versions=escape("Made with " + ", ".join(f"{name} {text}" for name, text in summary["versions"].items())),
    )


def _text(name: str) -> str:
    return (files("flangeway.report") / name).read_text(encoding="utf-8")


def _fields(summary: dict[str, Any], parts: Sequence[PartFields]) -> str:
    """Return the interactive picture, with a view of each contact."""
    if not parts:
        return ""
    views = []
    for contact in summary["contacts"]:
        x, y = contact["space_position_mm"]
        alone = contact_name(contact, summary["contacts"]) == contact["side"]
        name = f"{contact['side']} {'contact' if alone else contact['region']}"
        views.append(View(name, (x, y), VIEW_WIDTHS * contact["half_width_mm"]))
    viewer = field_viewer(parts, views, "The pictures further down show the most important fields.")
    return f'<section aria-labelledby="fields">\n<h2 id="fields">Fields</h2>\n{viewer}</section>'


def _method(run: CaseRun) -> str:
    problem = run.result.model.problem
    settings = problem.discretisation
    words = []
    for role in ("wheel", "rail"):
        kind: Role = "wheel" if role == "wheel" else "rail"
        order = "linear" if settings.order_of(kind) == 1 else "quadratic"
        words.append(f"{order} {'finite' if settings.method_of(kind) == 'fem' else 'virtual'} elements")
    cells = words[0] if words[0] == words[1] else f"{words[0]} in the wheels, {words[1]} in the rails"
    return f"{cells}, the {problem.primary[0]}s give the segments of contact"


def _reference(summary: dict[str, Any]) -> str:
    published = summary["published"]
    more = f" {published['reason']}" if published else ""
    return f"{summary['motion']['reference']}{more}"


def _facts(summary: dict[str, Any]) -> list[str]:
    facts = [
        (number(summary["motion"]["approach_mm"], 3) + " mm", "approach after first touch"),
    ]
    for contact in summary["contacts"]:
        side, place = contact["side"], contact_name(contact, summary["contacts"])
        facts += [
            (number(contact["force_kN"], 2) + " kN", f"force on the {side} wheel" + place.removeprefix(side)),
            (number(contact["max_pressure_MPa"], 0) + " MPa", f"largest pressure, {place}"),
        ]
    error = summary["balance"]["resulting_error"]
    facts.append(("–" if error is None else f"{error:.0e}", "resulting error of the balance"))
    return [
        f'<li><span class="value">{escape(value)}</span><span class="name">{escape(name)}</span></li>'
        for value, name in facts
    ]


def _warnings(sentences: list[str]) -> str:
    if not sentences:
        return ""
    return (
        '<section aria-labelledby="warnings">\n<h2 id="warnings">Warnings</h2>\n'
        f'<ul class="plain warning">\n{_items(sentences)}\n</ul>\n</section>'
    )


def _figure(picture: Picture) -> str:
    data = base64.b64encode(compact_png(picture.png)).decode("ascii")
    return (
        f'<figure><div class="scroll">'
        f'<img alt="{escape(picture.alternative)}" src="data:image/png;base64,{data}"></div>\n'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in table.header)
    rows = "\n".join(
        f'<tr><th scope="row">{escape(row[0])}</th>{"".join(_cell(text) for text in row[1:])}</tr>'
        for row in table.rows
    )
    return (
        f'<div class="scroll"><table>\n<caption>{escape(table.caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table></div>"
    )


def _cell(text: str) -> str:
    is_number = re.fullmatch(r"–|[-(\d.,) e/–]+", text)
    return f"<td>{escape(text)}</td>" if is_number else f'<td class="text">{escape(text)}</td>'


def _inputs(run: CaseRun) -> Table:
    rows = [(key, _plain(getattr(run.case, key)), meaning) for key, _, _, meaning in run.case.inputs()]
    return Table("Every key bears its unit", ("", "value", "meaning"), tuple(rows))


def _plain(value: object) -> str:
    if value is None:
        return "–"
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _items(sentences: list[str]) -> str:
    return "\n".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
