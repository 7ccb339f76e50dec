"""The report of a case of bodies that are pressed, pulled and held."""

from collections.abc import Sequence

from flangeway.cases.bodies.bodies_run import BodiesRun, BodiesSummary
from flangeway.cases.case import RunnableCase
from flangeway.elements import Element, Lagrange
from flangeway.materials import Elastic, Material
from flangeway.report.bodies.bodies_text import (
    contacts_of_bodies,
    forces_table,
    remark_of,
    result_rows,
    sizes_table,
    supports_table,
    words_of,
)
from flangeway.report.bodies.body_steps import BodySteps
from flangeway.report.figures.newton_history import steps_table
from flangeway.report.page.case_text import case_text, has_tables, inputs_tables
from flangeway.report.page.command import command_line
from flangeway.report.page.html_page import Again, Page, Picture
from flangeway.report.page.page_tables import Table, marked, timings_table
from flangeway.report.scenes import bodies_scene
from flangeway.space import Space

MOST_FACTS = 6
HYPOTHESES = {
    "plane_strain": "Plane strain: the bodies do not stretch out of the plane.",
    "plane_stress": "Plane stress: nothing holds the bodies out of the plane.",
    "axisymmetric": "Axisymmetric: x is the radius, y the axis.",
}
AXES = {
    "x, y": "to the right and up",
    "stresses": "tension is positive; the axes are those of the picture",
    "pressure": "of contact, positive in compression",
    "forces": "contact forces are those on the first body of a pair",
}
ORDERS = {1: "linear", 2: "quadratic", 3: "cubic"}


def bodies_page(run: BodiesRun, pictures: Sequence[Picture], steps: BodySteps) -> Page:
    """Return what the report of a case of bodies says.

    Parameters
    ----------
    run
        The run.
    pictures
        Pictures, the most telling first.
    steps
        Fields of the bodies in their load steps.

    """
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


def _tables(run: BodiesRun) -> list[Table]:
    summary, found = run.summary, []
    rows = result_rows(summary)
    if rows:
        found.append(Table("Results", ("", "value"), tuple(rows)))
    if summary.contacts:
        found.append(contacts_of_bodies(summary))
    if summary.forces:
        found.append(forces_table(summary))
    if summary.supports:
        found.append(supports_table(summary))
    found.append(sizes_table(summary))
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
        f"Thickness {', '.join(f'{each:g}' for each in thicknesses)} mm: forces act on this length out of the plane.",
        *(
            f"Linear elastic, isotropic: Young's modulus {each.young:g} MPa, Poisson's ratio {each.poisson:g}; no "
            "yielding, however high the stress."
            for each in materials
            if isinstance(each, Elastic)
        ),
        "Small strains; stresses at sharp inner corners and under point forces grow without limit as the mesh gets "
        "finer.",
    ]
    if run.contact is None:
        return sentences
    pairs = "; ".join(
        f"{each.primary.part.name} is the primary surface for {each.secondary.part.name}"
        for each in run.contact.system.contacts
    )
    return [*sentences, "Contact without friction.", f"Contact: {pairs}."]
