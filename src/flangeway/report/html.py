"""The report: one HTML page with all pictures inside, which needs no network."""

import base64
import re
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from flangeway.railway.discretisation import Role
from flangeway.report.command import command_line
from flangeway.report.tables import (
    Table,
    bodies_table,
    contact_name,
    contacts_table,
    motion_table,
    number,
    stresses_table,
    timings_table,
)
from flangeway.study import CaseRun


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


def report_page(run: CaseRun, pictures: Iterable[Picture]) -> str:
    """Return the page: summary first, then pictures, tables, assumptions, inputs and the command."""
    summary = run.summary
    status = summary["status"]
    problem = run.result.model.problem
    contacts = (contacts_table,) if summary["contacts"] else ()
    tables = (*contacts, motion_table, stresses_table, bodies_table, timings_table)
    template = (files("flangeway.report") / "page.html").read_text(encoding="utf-8")
    return Template(template).substitute(
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
        figures="\n".join(_figure(picture) for picture in pictures),
        tables="\n".join(_table(table(summary)) for table in tables),
        axes="\n".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in summary["axes"].items()),
        assumptions=_items(summary["assumptions"]),
        inputs=_table(_inputs(run)),
        command=escape(command_line(run.case)),
        versions=escape("Made with " + ", ".join(f"{name} {text}" for name, text in summary["versions"].items())),
    )


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
    data = base64.b64encode(picture.png).decode("ascii")
    return (
        f'<figure><img alt="{escape(picture.alternative)}" src="data:image/png;base64,{data}">\n'
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
    is_number = re.fullmatch(r"–|[-(\d.,) e]+", text)
    return f"<td>{escape(text)}</td>" if is_number else f'<td class="text">{escape(text)}</td>'


def _inputs(run: CaseRun) -> Table:
    rows = [(key, _plain(getattr(run.case, key)), meaning) for key, _, _, meaning in run.case.inputs()]
    return Table("Every key bears its unit", ("", "value", "meaning"), tuple(rows))


def _plain(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _items(sentences: list[str]) -> str:
    return "\n".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
