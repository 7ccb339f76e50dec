"""Report, files and terminal summary of a case of bodies that are pressed, pulled and held."""

from collections.abc import Mapping
from functools import cache, partial
from typing import Any

from flangeway.cases.bodies.bodies_run import BodiesRun, BodiesSummary, PairSummary
from flangeway.elements import Element, Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic, Material
from flangeway.report.bodies.bodies_figures import pressure_figure, stress_figure, traction_figure
from flangeway.report.bodies.body_fields import BodySteps, bodies_fields, body_steps
from flangeway.report.figures.drawing import spelled
from flangeway.report.figures.newton_history import load_steps, newton_figure, steps_table
from flangeway.report.figures.series import write_collection, write_contacts
from flangeway.report.page.case_text import run_record
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import Column, SummaryTable, marked, table_across, table_of
from flangeway.report.scenes import bodies_scene
from flangeway.space import Space
from flangeway.system.output_folder import Writer

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


def bodies_record(run: BodiesRun) -> Record:
    """Return what a run of a case of bodies found, its most informative picture first."""
    summary = run.summary
    axes = dict(AXES)
    if not summary.contacts:
        del axes["pressure"], axes["forces"]
    steps = cache(lambda: body_steps(run, list(bodies_fields(run))))
    return run_record(
        run,
        _files_words(run),
        subtitle=_elements(run),
        message=summary.status.message.removeprefix("converged "),
        facts=_facts(summary),
        results=results_table(summary),
        warnings=summary.notices,
        assumptions=_assumptions(run),
        scene=lambda: bodies_scene(run, steps()),
        pictures=_pictures(run),
        tables=_tables(run),
        axes=axes,
        files=lambda: _files(run, steps()),
    )


def _tables(run: BodiesRun) -> list[SummaryTable]:
    summary, found = run.summary, []
    if summary.contacts:
        found.append(contacts_of_bodies(summary))
    if summary.friction:
        found.append(table_of("Friction", summary.friction, FRICTION))
    if summary.forces:
        found.append(table_of("Forces on the bodies", summary.forces, FORCES))
    if summary.supports:
        found.append(table_of("Supports", summary.supports, SUPPORTS))
    found.append(table_of("Bodies", summary.bodies, SIZES))
    return [*found, steps_table(run.contact)] if run.contact is not None else found


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


def _files_words(run: BodiesRun) -> str:
    opened = "the VTU file is for ParaView"
    if run.contact is not None or len(run.bodies) > 1:
        opened = "ParaView opens all bodies and load steps with `bodies.pvd`"
    return f"The same numbers, for programs, are in `summary.json`; {opened}."


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
    coefficients = {each.friction_coefficient for each in run.contact.system.contacts}
    law = "Frictionless contact."
    if any(coefficients):
        law = f"Coulomb's friction, coefficient {' and '.join(f'{each:g}' for each in sorted(coefficients))}."
    return [*sentences, law, f"Contact pairs: {pairs}."]


UNITS = {"_N_mm_per_mm": "N mm/mm", "_MPa": "MPa", "_mm": "mm", "_N": "N", "_rad": "rad", "_deg": "degrees"}

REMARK = "_remark"


def results_table(summary: BodiesSummary) -> SummaryTable:
    """What the case is about, its contacts and its bodies, one number a row."""
    rows = []
    for key, value in summary.results.items():
        if not key.endswith(REMARK):
            name, *unit = words_of(key)
            for word, each in zip("xyz", value, strict=False) if isinstance(value, list) else [("", value)]:
                text = marked(value_text(each), remark_of(summary.results, key))
                rows.append((", ".join((f"{name} {word}".rstrip(), *unit)), text))
    for contact in summary.contacts:
        name = f"{contact.secondary} on {contact.primary}"
        rows.append((f"{name}: maximum pressure, MPa", _pressure(contact)))
        rows += [(f"{name}: half width of contact, mm", value_text(each.half_width_mm)) for each in contact.patches]
        if not contact.patches:
            rows.append((f"{name}: half width of contact, mm", "no contact"))
    for rubbed in summary.friction:
        name = f"{rubbed.secondary} on {rubbed.primary}"
        rows.append((f"{name}: sticking share of the contact", value_text(rubbed.sticking_share)))
        rows.append((f"{name}: dissipated work, N mm", value_text(rubbed.dissipated_N_mm)))
    for body in summary.bodies:
        rows.append((f"{body.name}: maximum displacement, mm", value_text(body.max_displacement_mm)))
        rows.append((f"{body.name}: maximum von Mises stress, MPa", value_text(body.max_von_mises_MPa)))
    return SummaryTable("Results", ("", "value"), tuple(rows))


def remark_of(results: Mapping[str, Any], key: str) -> str | None:
    """Why the value of a key is not reliable; None without a remark."""
    remark = results.get(key.removesuffix("_MPa") + REMARK)
    return None if remark is None else str(remark)


def contacts_of_bodies(summary: BodiesSummary) -> SummaryTable:
    """Forces, pressures and regions of the contacts, one column a region of a contact."""
    found = [
        (each, patch) for each in summary.contacts for patch in (*each.patches, *(() if each.patches else (None,)))
    ]
    quantities: tuple[Column, ...] = (
        ("force on the secondary body {x|y}, N", lambda c: c[0].force_on_secondary_N, "z.6g"),
        ("maximum pressure, MPa", lambda c: _pressure(c[0]), ""),
        ("half width of contact, mm", lambda c: c[1] and c[1].half_width_mm, ".6g"),
        ("centre of pressure {x|y}, mm", lambda c: c[1] and c[1].centre_mm, "z.6g"),
        ("reaches an end of the surface", lambda c: c[1] and value_text(c[1].reaches_an_end), ""),
        ("initial overlap, mm", lambda c: c[0].initial_penetration_mm, "z.6g"),
    )
    names = (f"{each.secondary} on {each.primary}" for each, _ in found)
    return table_across("Contacts", names, found, quantities)


FORCES: tuple[Column, ...] = (
    *(("", "body", ""), ("contact {x|y}, N", "contact_N", "z.6g")),
    *(("loads {x|y}, N", "loads_N", "z.6g"), ("supports {x|y}, N", "supports_N", "z.6g")),
)
FRICTION: tuple[Column, ...] = (
    *(("secondary", "secondary", ""), ("primary", "primary", ""), ("coefficient", "coefficient", "g")),
    *(("tangential force, N", "tangential_force_N", "z.6g"), ("maximum traction, MPa", "max_traction_MPa", ".6g")),
    ("maximum slip in the last step, mm", "max_slip_in_step_mm", ".4g"),
    *(("sticking share", "sticking_share", ".3f"), ("dissipated work, N mm", "dissipated_N_mm", ".6g")),
)
SUPPORTS: tuple[Column, ...] = (("", "number", ""), ("body", "body", ""), ("force on it {x|y}, N", "force_N", "z.6g"))
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
            return spelled(key[: -len(ending)]), unit
    return (spelled(key),)


def value_text(value: Any) -> str:
    """Write a value for people: six digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pressure(contact: PairSummary) -> str:
    return marked(value_text(contact.max_pressure_MPa), contact.max_pressure_remark)


STEPS = "steps"  # folder of the earlier load steps
COLLECTION, CONTACT = "bodies.pvd", "contact.vtu"
FEW = 2  # iterations, of which the table says all
STRESSES, PRESSURE, TRACTION, CONVERGENCE = "stresses.png", "pressure.png", "traction.png", "convergence.png"
NAMES = (COLLECTION, CONTACT, STRESSES, PRESSURE, TRACTION, CONVERGENCE)
"""Names of the files, except the fields, which have the names of the bodies."""


def _files(run: BodiesRun, steps: BodySteps) -> dict[str, Writer]:
    """Return functions that write the fields, by the files' names."""
    writers: dict[str, Writer] = {}
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
    return writers


def _pictures(run: BodiesRun) -> list[Picture]:
    """Pictures, the most important first."""
    near, contact = ", and near the contact" if run.patches else "", run.contact
    pictures = [
        Picture(
            STRESSES,
            lambda: stress_figure(run),
            f"The bodies as deformed, with their elements, coloured by von Mises stress{near}.",
            f"Von Mises stress on the deformed bodies{near}.",
        )
    ]
    if run.patches:
        theory = ", beside Hertz's theory for the same force" if run.theory is not None else ""
        pictures.append(
            Picture(
                PRESSURE,
                lambda: pressure_figure(run),
                f"Contact pressure along each region of contact, node by node{theory}.",
                f"Contact pressure along the surface{theory}.",
            )
        )
    if run.patches and run.summary.friction:
        pictures.append(
            Picture(
                TRACTION,
                lambda: traction_figure(run),
                "Tangential traction of each contact, and the limits of friction, along the surface.",
                "Tangential traction along the surface (solid) between the limits of friction (dashed).",
            )
        )
    if contact is not None and sum(len(state.history) for _, state in load_steps(contact)) > FEW:
        pictures.append(
            Picture(
                CONVERGENCE,
                lambda: newton_figure(load_steps(contact)),
                "Relative residuals over the iterations of Newton's method in all load steps, on a logarithmic axis.",
                "Convergence: residual of the forces and change of the displacements in each iteration.",
            )
        )
    return pictures
