"""Report, files and terminal summary of a case of bodies that are pressed, pulled and held."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from rich.console import Console

from flangeway.cases.bodies.bodies_run import BodiesRun, BodiesSummary, PairSummary
from flangeway.cases.case import RunnableCase
from flangeway.elements import Element, Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic, Material
from flangeway.report.bodies.bodies_figures import pressure_figure, stress_figure
from flangeway.report.bodies.body_fields import BodySteps, bodies_fields, body_steps
from flangeway.report.figures.drawing import png
from flangeway.report.figures.newton_history import newton_figure, steps_table
from flangeway.report.figures.series import write_collection, write_contacts
from flangeway.report.page.case_text import case_text, command_line, has_tables, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture, report_page
from flangeway.report.page.tables import (
    Column,
    SummaryTable,
    marked,
    print_notices,
    print_rows,
    print_status,
    table_across,
    table_of,
    timings_table,
)
from flangeway.report.scenes import bodies_scene
from flangeway.space import Space
from flangeway.system.output_folder import Writer, bytes_writer, text_writer

MOST_FACTS = 6
HYPOTHESES = {
    "plane_strain": "Plane strain: no strain out of the plane.",
    "plane_stress": "Plane stress: no stress out of the plane.",
    "axisymmetric": "Axisymmetric: x is the radius, y the axis.",
}
AXES = {
    "x, y": "to the right and up",
    "stresses": "tension is positive; the axes are those of the picture",
    "pressure": "of contact, positive in compression",
    "forces": "contact forces are those on the secondary body of a pair",
}
ORDERS = {1: "linear", 2: "quadratic", 3: "cubic"}


def bodies_page(run: BodiesRun, pictures: Sequence[Picture], steps: BodySteps) -> Page:
    """Return the report of a case of bodies, its most informative picture first."""
    case, summary = run.case, run.summary
    assert isinstance(case, RunnableCase)
    axes = dict(AXES)
    if not summary.contacts:
        del axes["pressure"], axes["forces"]
    return Page(
        title=case.title,
        subtitle=_elements(run),
        converged=run.status.converged,
        message=run.status.message,
        facts=_facts(summary),
        again=_again(case, run),
        versions=summary.versions,
        warnings=summary.notices,
        assumptions=_assumptions(run),
        scene=bodies_scene(run, steps),
        pictures=pictures,
        tables=_tables(run),
        axes=axes,
        inputs=inputs_tables(case),
    )


def _tables(run: BodiesRun) -> list[SummaryTable]:
    summary, found = run.summary, []
    rows = result_rows(summary)
    if rows:
        found.append(SummaryTable("Results", ("", "value"), tuple(rows)))
    if summary.contacts:
        found.append(contacts_of_bodies(summary))
    if summary.forces:
        found.append(table_of("Forces on the bodies (x, y)", summary.forces, FORCES))
    if summary.supports:
        found.append(table_of("Supports", summary.supports, SUPPORTS))
    found.append(table_of("Bodies", summary.bodies, SIZES))
    if run.contact is not None:
        found.append(steps_table(run.contact))
    return [*found, timings_table(summary.timings_s)]


def _facts(summary: BodiesSummary) -> list[tuple[str, str]]:
    """Numbers that the case is about, or what there is of every case."""
    facts = [
        (marked(" ".join((f"{value:.5g}", *words_of(key)[1:])), remark_of(summary.results, key)), words_of(key)[0])
        for key, value in summary.results.items()
        if isinstance(value, float)
    ]
    if not any("pressure" in name for _, name in facts):
        facts += [
            (
                marked(f"{each.max_pressure_MPa:.5g} MPa", each.max_pressure_remark),
                f"maximum pressure, {each.secondary} on {each.primary}",
            )
            for each in summary.contacts
        ]
    bodies = summary.bodies
    maximum = max(bodies, key=lambda body: body.max_von_mises_MPa)
    where = f", {maximum.name}" if len(bodies) > 1 else ""
    return [
        *facts[:MOST_FACTS],
        (f"{max(body.max_displacement_mm for body in bodies):.4g} mm", "maximum displacement"),
        (f"{maximum.max_von_mises_MPa:.4g} MPa", f"maximum von Mises stress{where}"),
    ]


def _again(case: RunnableCase, run: BodiesRun) -> Again:
    opened = "the VTU file is for ParaView"
    if run.contact is not None or len(run.bodies) > 1:
        opened = "ParaView opens all bodies and load steps with `bodies.pvd`"
    files = f"The same numbers, for programs, are in `summary.json`; {opened}."
    if has_tables(case):
        name = f"{case.name}.toml"
        return Again(f"flangeway run {name}", case_text(case), name, files)
    return Again(command_line(case), case_text(case), files=files)


def _elements(run: BodiesRun) -> str:
    words = {name: _element_words(body.field.problem.space) for name, body in run.bodies.items()}
    if len(set(words.values())) == 1:
        return next(iter(words.values()))
    return "; ".join(f"{name}: {text}" for name, text in words.items())


def _element_words(space: Space) -> str:
    elements = [space.element] if isinstance(space.element, Element) else list(space.element.values())
    kinds = sorted({"finite" if isinstance(element, Lagrange) else "virtual" for element in elements})
    order = ORDERS.get(space.order, f"order {space.order}")
    return f"{order} {' and '.join(kinds)} elements"


def _assumptions(run: BodiesRun) -> list[str]:
    problems = [body.field.problem for body in run.bodies.values()]
    materials: dict[Material, None] = dict.fromkeys(material for problem in problems for material in problem.materials)
    thicknesses = sorted({problem.thickness for problem in problems})
    sentences = [
        *(HYPOTHESES[name] for name in dict.fromkeys(material.hypothesis for material in materials)),
        f"Thickness {', '.join(f'{each:g}' for each in thicknesses)} mm: forces refer to this length out of the plane.",
        *(
            f"Linear elastic, isotropic: Young's modulus {each.young:g} MPa, Poisson's ratio {each.poisson:g}; no "
            "yielding, however high the stress."
            for each in materials
            if isinstance(each, Elastic)
        ),
        "Small strains. Stresses at re-entrant corners and under point forces are singular: they grow with refinement.",
    ]
    if run.contact is None:
        return sentences
    pairs = "; ".join(
        f"{each.primary.part.name} is the primary surface for {each.secondary.part.name}"
        for each in run.contact.system.contacts
    )
    return [*sentences, "Frictionless contact.", f"Contact pairs: {pairs}."]


UNITS = {"_N_mm_per_mm": "N mm per mm", "_MPa": "MPa", "_mm": "mm", "_N": "N", "_rad": "rad", "_deg": "degrees"}

REMARK = "_remark"


def case_rows(summary: BodiesSummary) -> list[tuple[str, str]]:
    """Names with units and values of what a case of bodies found, as shown."""
    rows = result_rows(summary)
    for each in summary.contacts:
        name = f"{each.secondary} on {each.primary}"
        rows.append((f"{name}: force on {each.secondary} (x, y), N", value_text(each.force_on_secondary_N)))
        rows.append((f"{name}: maximum pressure, MPa", _pressure(each)))
        rows.append((f"{name}: half width of contact, mm", _half_widths(each)))
    for body in summary.bodies:
        rows.append((f"{body.name}: maximum displacement, mm", value_text(body.max_displacement_mm)))
        rows.append((f"{body.name}: maximum von Mises stress, MPa", value_text(body.max_von_mises_MPa)))
        rows.append((f"{body.name}: elements, unknowns", f"{body.elements}, {body.unknowns}"))
    return rows


def result_rows(summary: BodiesSummary) -> list[tuple[str, str]]:
    """Names with units and values of what a case is about."""
    results = summary.results
    return [
        (", ".join(words_of(key)), marked(value_text(value), remark_of(results, key)))
        for key, value in results.items()
        if not key.endswith(REMARK)
    ]


def remark_of(results: Mapping[str, Any], key: str) -> str | None:
    """Why the value of a key is not reliable; None without a remark."""
    remark = results.get(key.removesuffix("_MPa") + REMARK)
    return None if remark is None else str(remark)


def contacts_of_bodies(summary: BodiesSummary) -> SummaryTable:
    """Forces, pressures and regions of the contacts, one column a contact."""
    quantities: tuple[Column, ...] = (
        ("force on the secondary body (x, y), N", "force_on_secondary_N", ".6g"),
        ("maximum pressure, MPa", _pressure, ""),
        ("half width of contact, mm", _half_widths, ""),
        ("centre of pressure (x, y), mm", lambda c: _of_patches(c, "centre_mm"), ""),
        ("reaches an end of the surface", lambda c: _of_patches(c, "reaches_an_end"), ""),
        ("initial overlap, mm", "initial_penetration_mm", ".6g"),
    )
    names = (f"{each.secondary} on {each.primary}" for each in summary.contacts)
    return table_across("Contacts", names, summary.contacts, quantities)


FORCES: tuple[Column, ...] = (
    *(("", "body", ""), ("contact, N", "contact_N", ".6g")),
    *(("loads, N", "loads_N", ".6g"), ("supports, N", "supports_N", ".6g")),
)
SUPPORTS: tuple[Column, ...] = (("", "number", ""), ("body", "body", ""), ("force on it (x, y), N", "force_N", ".6g"))
SIZES: tuple[Column, ...] = (
    *(("", "name", ""), ("elements", "elements", ","), ("unknowns", "unknowns", ",")),
    ("maximum displacement, mm", "max_displacement_mm", ".6g"),
    ("maximum von Mises, MPa", "max_von_mises_MPa", ".6g"),
    ("minimum principal, MPa", "min_principal_MPa", ".6g"),
    ("maximum in-plane shear, MPa", "max_in_plane_shear_MPa", ".6g"),
)


def words_of(key: str) -> tuple[str, ...]:
    """A key as words, and its unit if it has one."""
    for ending, unit in UNITS.items():
        if key.endswith(ending):
            return key[: -len(ending)].replace("_", " "), unit
    return (key.replace("_", " "),)


def value_text(value: Any) -> str:
    """Write a value for people: six digits, lists in brackets."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return f"({', '.join(value_text(each) for each in value)})"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pressure(contact: PairSummary) -> str:
    return marked(value_text(contact.max_pressure_MPa), contact.max_pressure_remark)


def _half_widths(contact: PairSummary) -> str:
    return _of_patches(contact, "half_width_mm") if contact.patches else "no contact"


def _of_patches(contact: PairSummary, key: str) -> str:
    return ", ".join(value_text(getattr(patch, key)) for patch in contact.patches) or "–"


STEPS = "steps"  # folder of the earlier load steps
REPORT, COLLECTION, CONTACT = "report.html", "bodies.pvd", "contact.vtu"
STRESSES, PRESSURE, CONVERGENCE = "stresses.png", "pressure.png", "convergence.png"
NAMES = (REPORT, COLLECTION, CONTACT, STRESSES, PRESSURE, CONVERGENCE)
"""Names of the files, except the fields, which have the names of the bodies."""


def bodies_writers(run: BodiesRun, progress: Callable[[str], None]) -> dict[str, Writer]:
    """Return functions that write pictures, fields and report, by the files' names."""
    progress("drawing the pictures and writing the files")
    pictures = _pictures(run)
    steps = body_steps(run, list(bodies_fields(run)))
    writers = {name: bytes_writer(picture.png) for name, picture in pictures.items()}
    entries = []
    for number, fields in zip(steps.numbers, steps.fields, strict=True):
        for place, body in enumerate(fields, 1):
            # a name given by the user may not be allowed as that of a file
            plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in body.name)
            stem = f"{place}-{plain}" if len(fields) > 1 else plain
            file = f"{stem}.vtu" if number == steps.numbers[-1] else f"{STEPS}/{stem}-{number}.vtu"
            writers[file] = partial(body.write, body_id=place - 1)
            entries.append((float(number), body.name, file))
        if run.contact is not None:
            last = number == steps.numbers[-1]
            file = CONTACT if last else f"{STEPS}/contact-{number}.vtu"
            starts = {body.name: Placement() for body in fields}
            state = run.contact.state if last else run.contact.steps[number - 1].state
            writers[file] = partial(write_contacts, system=run.contact.system, state=state, starts=starts)
            entries.append((float(number), "contact", file))
    if len(entries) > 1:
        writers[COLLECTION] = lambda path: write_collection(path, entries)
    writers[REPORT] = text_writer(report_page(bodies_page(run, list(pictures.values()), steps)))
    return writers


def _pictures(run: BodiesRun) -> dict[str, Picture]:
    """Pictures by the names of their files, the most important first."""
    near = ", and near the contact" if run.patches else ""
    pictures = {
        STRESSES: Picture(
            png(stress_figure(run)),
            f"The bodies as deformed, with their elements, coloured by von Mises stress{near}.",
            f"Von Mises stress on the deformed bodies{near}.",
        )
    }
    if run.patches:
        theory = ", beside Hertz's theory for the same force" if run.theory is not None else ""
        pictures[PRESSURE] = Picture(
            png(pressure_figure(run)),
            f"Contact pressure along each region of contact, node by node{theory}.",
            f"Contact pressure along the surface{theory}.",
        )
    if run.contact is not None:
        pictures[CONVERGENCE] = Picture(
            png(newton_figure(run.contact)),
            "Relative residuals over the iterations of Newton's method in all load steps, on a logarithmic axis.",
            "Convergence: residual of the forces and change of the displacements in each iteration.",
        )
    return pictures


def print_bodies(console: Console, run: BodiesRun) -> None:
    """Print status, results and notices."""
    print_status(console, run.case.name, run.status)
    print_rows(console, case_rows(run.summary))
    print_notices(console, run.summary.notices)
