"""Report, files and terminal summary of a wheelset."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rich.console import Console

from flangeway.cases import CaseRun, Convergence
from flangeway.cases.wheelset.wheelset_case import MAX_APPROACH_CHANGE, MAX_POSITION_CHANGE_MM
from flangeway.cases.wheelset.wheelset_summary import ContactSummary, WheelsetSummary
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.drawing import png
from flangeway.report.figures.fields import PartFields, part_fields, write_part
from flangeway.report.figures.newton_history import convergence_figure
from flangeway.report.figures.series import write_collection, write_contacts
from flangeway.report.page.case_text import case_text, command_line, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture, report_page
from flangeway.report.page.tables import (
    SummaryTable,
    marked,
    number,
    print_notices,
    print_status,
    print_table,
    timings_table,
)
from flangeway.report.scenes import wheelset_scene
from flangeway.report.wheelset.bending_figure import bending_figure
from flangeway.report.wheelset.contact_figure import contact_figure, pressure_figure
from flangeway.report.wheelset.rigid_elastic_figure import rigid_elastic_figure
from flangeway.report.wheelset.subsurface_figure import (
    SubsurfaceLine,
    subsurface_figure,
    subsurface_lines,
    subsurface_table,
)
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.report.wheelset.wheelset_tables import (
    bending_table,
    bodies_table,
    contact_name,
    contacts_table,
    position_table,
    rigid_table,
    stresses_table,
    support_table,
)
from flangeway.system.output_folder import Writer, bytes_writer, text_writer

FILES = (
    "The same numbers, for programs, are in `summary.json`; the fields are in `wheelset.pvd`, which ParaView opens "
    "with all four parts; the stresses below the contacts, point by point, are in `subsurface.csv`."
)


def wheelset_page(run: CaseRun, pictures: Sequence[Picture], parts: Sequence[PartFields] = ()) -> Page:
    """Return the content of the report of a wheelset.

    - `pictures`: pictures, the most important first.
    - `parts`: fields of the parts, for the interactive picture; without any the page has none.
    """
    summary = run.summary
    problem = run.result.model.problem
    contacts = (contacts_table,) if summary.contacts else ()
    tables = (*(*contacts, position_table, rigid_table, bending_table), *(support_table, stresses_table, bodies_table))
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


def print_summary(console: Console, run: CaseRun) -> None:
    """Print status, position, contacts, stresses, warnings, and assumptions in short."""
    summary = run.summary
    print_status(console, run.case.name, run.status)
    contacts = (contacts_table,) if summary.contacts else ()
    for table in (position_table, *contacts):
        print_table(console, table(summary))
    print_table(console, bending_table(summary, short=True))
    for table in (stresses_table, bodies_table):
        print_table(console, table(summary))
    print_notices(console, summary.warnings, "Warning")
    short = [re.split(r"[:;.](?: |$)", sentence)[0] for sentence in summary.assumptions]
    console.print(f"Assumptions: {'; '.join(short)}.", markup=False)


def print_convergence(console: Console, convergence: Convergence, file: Path) -> None:
    """Print what changed when the mesh was halved, and whether that is within the limits."""
    for summary in convergence.summaries:
        if not summary.status.converged:
            print_status(console, summary.case["name"], summary.status)
    if convergence.converged:
        print_table(console, _convergence_table(convergence))
    verdict = "within" if convergence.within else "NOT within"
    console.print(
        f"The changes are {verdict} the limits: approach {100.0 * MAX_APPROACH_CHANGE:g} %, "
        f"positions {MAX_POSITION_CHANGE_MM:g} mm.",
        style="green" if convergence.within else "red",
        markup=False,
    )
    console.print(f"File: {file}", markup=False, soft_wrap=True)


def _convergence_table(convergence: Convergence) -> SummaryTable:
    both, changes = convergence.summaries, convergence.changes()

    def row(name: str, text: Callable[[ContactSummary], str], change: str) -> tuple[str, ...]:
        return name, *(" / ".join(text(c) for c in each.contacts) for each in both), change

    shift = f"{changes['position_change_mm']:.3f} mm"
    percent = {key: f"{100.0 * change:.3f} %" for key, change in changes.items()}
    rows = (
        ("approach, mm", *(number(each.position.approach_mm, 5) for each in both), percent["approach_change"]),
        row("x on the rail, mm", lambda c: number(c.rail_position_mm[0], 3), shift),
        row("x on the wheel, mm", lambda c: number(c.wheel_position_mm[0], 3), shift),
        row(
            "maximum pressure, MPa",
            lambda c: marked(number(c.max_pressure_MPa, 1), c.max_pressure_remark),
            percent["max_pressure_change"],
        ),
        row("half width, mm", lambda c: number(c.half_width_mm, 3), percent["half_width_change"]),
        ("unknowns", *(f"{sum(body.unknowns for body in each.bodies):,}" for each in both), ""),
    )
    scales = [f"size scale {each.case['size_scale']:g}" for each in both]
    return SummaryTable("The mesh halved (left / right)", ("", *scales, "maximum change"), rows)


PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
REPORT, COLLECTION, CONTACT, SUBSURFACE = "report.html", "wheelset.pvd", "contact.vtu", "subsurface.csv"
PICTURES = (
    "wheelset.png", "rigid-and-elastic.png", "stresses-left.png", "stresses-right.png", "pressure.png",
    "convergence.png", "subsurface.png", "bending.png",
)  # fmt: skip
NAMES = (*(f"{part}.vtu" for part in PARTS), CONTACT, COLLECTION, *PICTURES, SUBSURFACE, REPORT)


def wheelset_writers(run: CaseRun, progress: Callable[[str], None]) -> dict[str, Writer]:
    """Return functions that write pictures, fields, stresses below the contacts and report, by the files' names."""
    progress("drawing the pictures")
    fields = list(part_fields(run.result))
    below = subsurface_lines(run.result)
    pictures = _pictures(run, fields, below)
    progress("writing the files")
    writers: dict[str, Writer] = {f"{name}.vtu": partial(write_part, result=run.result, name=name) for name in PARTS}
    result = run.result
    writers[CONTACT] = lambda path: write_contacts(
        path, result.model.system, result.equilibrium.state, {name: result.placements[name] for name in PARTS}
    )
    vtu_files = [(0.0, Path(file).stem, file) for file in writers]
    writers[COLLECTION] = lambda path: write_collection(path, vtu_files)
    writers |= {name: bytes_writer(picture.png) for name, picture in zip(PICTURES, pictures, strict=True)}
    writers[SUBSURFACE] = text_writer(subsurface_table(below))
    writers[REPORT] = text_writer(report_page(wheelset_page(run, pictures, fields)))
    return writers


def _pictures(run: CaseRun, fields: list[PartFields], below: list[SubsurfaceLine]) -> list[Picture]:
    """Return all pictures in the order of `PICTURES`."""
    return [
        Picture(
            png(wheelset_figure(run, fields)),
            "Left and right wheel on their rails, deformed and coloured by von Mises stress, with a sketch of the "
            "wheelset, its load and its dimensions between them.",
            "The wheelset on its rails: von Mises stress on the deformed parts. Dark is most loaded; numbers on the "
            "lines are MPa. Web and foot of the rails are hatched: their stresses are those of a slice that carries "
            "the load alone and are not valid for a rail.",
        ),
        Picture(
            png(rigid_elastic_figure(run, fields)),
            "Outlines of the elastic wheels and rails in equilibrium over those of the rigid ones, with contact points "
            "and forces of both, whole heads above and the contact zones enlarged below.",
            "Elastic and rigid equilibrium positions, true to scale.",
        ),
        *(
            Picture(
                png(contact_figure(run, fields, side)),
                f"The contact zones of the {side} side, deformed, with the mesh, coloured by von Mises stress, by the "
                "minimum principal stress with the contact forces on the wheel as arrows, and by the maximum in-plane "
                "shear stress.",
                f"Contact zones of the {side} side, deformed: von Mises stress, minimum principal stress and maximum "
                "in-plane shear stress of each element. Both sides have the same colours.",
            )
            for side in SIDES
        ),
        Picture(
            png(pressure_figure(run)),
            "Contact pressure along the surface of both sides: nodes of the mesh and Hertz's ellipse.",
            "Contact pressure along the surface: nodal forces over their areas, and Hertz's theory for the same force "
            "and the profiles' radii at the contact, where the profiles are not conforming.",
        ),
        Picture(
            png(convergence_figure(run)),
            "Relative residuals of the equilibrium over the iterations, on a logarithmic axis.",
            "Convergence: residuals of forces and moment at each position of the wheelset in the iteration.",
        ),
        Picture(
            png(subsurface_figure(below)),
            "Stresses in rail and wheel over the depth below each contact, solid, and those of Hertz's line contact, "
            "dashed.",
            "Stresses along the inward normal through each centre of pressure, and those of Hertz's theory in half "
            "planes; in the head of a rail and in a rim the force spreads less, and the stresses fall more slowly.",
        ),
        Picture(
            png(bending_figure(run, fields)),
            "Sections of both rails with the stresses along their free surface as ordinates, and their deformed "
            "outlines dashed.",
            "Bending of the rails, held along their bases: stresses along the surface of web and fillets in MPa, and "
            "the deformed outlines. The stresses are those of the slice: compare runs with each other, not with a rail "
            "in track.",
        ),
    ]
