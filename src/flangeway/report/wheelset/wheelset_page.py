"""The report of a wheelset."""

from collections.abc import Sequence

from flangeway.cases import CaseRun
from flangeway.cases.wheelset.wheelset_summary import WheelsetSummary
from flangeway.railway.track.discretisation import Role
from flangeway.report.figures.fields import PartFields
from flangeway.report.page.case_text import case_text, command_line, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture
from flangeway.report.page.page_tables import (
    bending_table,
    bodies_table,
    contact_name,
    contacts_table,
    marked,
    number,
    position_table,
    rigid_table,
    stresses_table,
    support_table,
    timings_table,
)
from flangeway.report.scenes import wheelset_scene

FILES = (
    "The same numbers, for programs, are in `summary.json`; the fields are in `wheelset.pvd`, which ParaView opens "
    "with all four parts; the stresses below the contacts, point by point, are in `subsurface.csv`."
)


def wheelset_page(run: CaseRun, pictures: Sequence[Picture], parts: Sequence[PartFields] = ()) -> Page:
    """Return what the report of a wheelset says.

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
    problem = run.result.model.problem
    contacts = (contacts_table,) if summary.contacts else ()
    tables = (
        *(*contacts, position_table, rigid_table, bending_table),
        *(support_table, stresses_table, bodies_table),
    )
    return Page(
        title=run.case.title,
        subtitle=f"Wheel {problem.wheelset.wheel.title} on rail {problem.track.rail.title}; plane strain, "
        f"{problem.thickness_mm:g} mm of length; {_method(run)}",
        converged=summary.status.converged,
        message=summary.status.message,
        facts=_facts(summary),
        again=Again(command_line(run.case), case_text(run.case), files=FILES),
        versions=summary.versions,
        sentences=[_reference(summary)],
        warnings=summary.warnings,
        assumptions=summary.assumptions,
        scene=wheelset_scene(parts, summary.contacts) if parts else None,
        pictures=pictures,
        tables=[*(table(summary) for table in tables), timings_table(summary.timings_s)],
        axes=summary.axes,
        inputs=inputs_tables(run.case),
    )


def _method(run: CaseRun) -> str:
    problem = run.result.model.problem
    settings = problem.discretisation
    words = []
    for role in ("wheel", "rail"):
        kind: Role = "wheel" if role == "wheel" else "rail"
        order = "linear" if settings.order_of(kind) == 1 else "quadratic"
        words.append(f"{order} {'finite' if settings.method_of(kind) == 'fem' else 'virtual'} elements")
    elements = words[0] if words[0] == words[1] else f"{words[0]} in the wheels, {words[1]} in the rails"
    return f"{elements}, the {problem.primary[0]}s are the primary surface"


def _reference(summary: WheelsetSummary) -> str:
    published = summary.published
    return summary.position.reference + (f" {published.reason}" if published else "")


def _facts(summary: WheelsetSummary) -> list[tuple[str, str]]:
    facts = [(number(summary.position.approach_mm, 3) + " mm", "approach after first touch")]
    for contact in summary.contacts:
        side, name = contact.side, contact_name(contact, summary.contacts)
        facts += [
            (number(contact.force_kN, 2) + " kN", f"force on the {side} wheel" + name.removeprefix(side)),
            (
                marked(number(contact.max_pressure_MPa, 0) + " MPa", contact.max_pressure_remark),
                f"maximum pressure, {name}",
            ),
        ]
    residual = summary.residual.equilibrium
    facts.append(("–" if residual is None else f"{residual:.0e}", "equilibrium residual"))
    return facts
