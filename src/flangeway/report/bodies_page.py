"""Report, files and terminal summary of a case of bodies that are pressed, pulled and held."""

from collections.abc import Sequence
from functools import cache, partial

from flangeway.cases.bodies.bodies_run import (
    BODY,
    DISSIPATED,
    FORCES,
    FRICTION,
    HALF_WIDTH,
    MAX_DISPLACEMENT,
    MAX_PRESSURE,
    MAX_VON_MISES,
    PAIR,
    PATCH,
    REACTION,
    STICKING,
    BodiesRun,
)
from flangeway.elements import Element, Lagrange
from flangeway.geometry import Placement
from flangeway.report.figures.display import write_collection, write_contacts
from flangeway.report.page.html_page import run_record
from flangeway.report.page.record import Picture, Report, SummaryTable, fact, rows_of, table_across, table_of
from flangeway.report.scenes import BodySteps, bodies_fields, bodies_scene, body_steps, steps_table
from flangeway.space import Space
from flangeway.system.output_folder import Writer
from flangeway.system.templates import sentences

# --- Report, files and terminal summary of a case of bodies that are pressed, pulled and held.


MAX_FACTS = 6  # numbers of the case at the top of the page
AXES = {
    "x, y": "to the right and up",
    "stresses": "tension is positive; the axes are those of the picture",
    "pressure": "of contact, positive in compression",
    "forces": "contact forces are those on the secondary body of a pair",
}
ORDERS = {1: "linear", 2: "quadratic", 3: "cubic"}


def bodies_record(run: BodiesRun) -> Report:
    """Return what a run of a case of bodies found, its most informative picture first."""
    axes = AXES if run.contact is not None else {name: AXES[name] for name in ("x, y", "stresses")}
    steps = cache(lambda: body_steps(run, list(bodies_fields(run))))
    return run_record(
        run,
        _files_words(run),
        subtitle=_elements(run),
        message=run.status.message.removeprefix("converged "),
        facts=_facts(run),
        results=results_table(run),
        warnings=run.notices,
        assumptions=_assumptions(run),
        scene=lambda: bodies_scene(run, steps()),
        pictures=lambda: _pictures(run),
        tables=_tables(run),
        axes=axes,
        files=lambda: _files(run, steps()),
    )


def _pictures(run: BodiesRun) -> Sequence[Picture]:
    from flangeway.report.bodies_figures import bodies_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return bodies_pictures(run)


def _tables(run: BodiesRun) -> list[SummaryTable]:
    units = run.case.units
    patches = [run.pairs[patch.contact].name for patch in run.patches]
    tables = [
        table_across("Contacts", [pair.name for pair in run.pairs], run.pairs, PAIR[2:], units=units),
        table_across("Regions of contact", patches, run.patches, PATCH, units=units),
        table_of("Friction", run.rubbing, FRICTION, units=units),
        table_of("Forces on the bodies", run.in_contact, FORCES, units=units),
        table_of("Supports", run.reactions, REACTION, units=units),
        table_of("Bodies", [*run.bodies.values()], BODY, units=units),
    ]
    if run.contact is not None:
        tables.append(steps_table(run.contact))
    return [table for table in tables if len(table.header) > 1 and table.rows]


def _facts(run: BodiesRun) -> list[tuple[str, str]]:
    """Numbers that the case is about, or what there is of every case."""
    units, bodies = run.case.units, [*run.bodies.values()]
    about = [quantity for quantity in run.case.quantities(run) if isinstance(quantity.value(run), float)]
    facts = [fact(quantity, run, units) for quantity in about if quantity.label]
    if not any("pressure" in name for _, name in facts):
        facts += [fact(MAX_PRESSURE, pair, units, pair.name) for pair in run.pairs]
    owners = [body.field.problem.name if len(bodies) > 1 else "" for body in bodies]
    extremes = []
    for quantity in (MAX_DISPLACEMENT, MAX_VON_MISES):
        body_of_maximum = max(range(len(bodies)), key=lambda number, of=quantity: of.value(bodies[number]))  # type: ignore[misc]
        extremes.append(fact(quantity, bodies[body_of_maximum], units, owners[body_of_maximum]))
    return [*facts[:MAX_FACTS], *extremes]


def _files_words(run: BodiesRun) -> str:
    opened = "the VTU file is for ParaView"
    if run.contact is not None or len(run.bodies) > 1:
        opened = "ParaView opens all bodies and load steps with `bodies.pvd`"
    return f"The same numbers, for programs, are in `summary.json`; {opened}."


def _elements(run: BodiesRun) -> str:
    words = {name: _element_words(body.field.space) for name, body in run.bodies.items()}
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
    materials = dict.fromkeys(material for problem in problems for material in problem.materials)
    contacts = run.contact.system.contacts if run.contact is not None else ()
    return sentences(
        "flangeway.report", "bodies_assumptions.txt", problems=problems, materials=materials, contacts=contacts
    )


def results_table(run: BodiesRun) -> SummaryTable:
    """What the case is about, its contacts and its bodies, one number a row."""
    units = run.case.units
    rows = rows_of(run.case.quantities(run), run, units)
    for pair in run.pairs:
        rows += rows_of([MAX_PRESSURE], pair, units, pair.name)
        for patch in pair.patches:
            rows += rows_of([HALF_WIDTH], patch, units, pair.name)
        if pair.contact.friction_coefficient:
            rows += rows_of([STICKING, DISSIPATED], pair, units, pair.name)
    for body in run.bodies.values():
        rows += rows_of([MAX_DISPLACEMENT, MAX_VON_MISES], body, units, body.field.problem.name)
    return SummaryTable("Results", ("", "value"), tuple(rows))


STEPS = "steps"  # folder of the earlier load steps
CONTACT = "contact.vtu"


def _files(run: BodiesRun, steps: BodySteps) -> dict[str, Writer]:
    """Return functions that write the fields, by the files' names."""
    writers: dict[str, Writer] = {}
    entries = []
    for number, fields in zip(steps.numbers, steps.fields, strict=True):
        for index, body in enumerate(fields, 1):
            # a name given by the user may not be allowed as that of a file
            plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in body.name)
            stem = f"{index}-{plain}" if len(fields) > 1 else plain
            file = f"{stem}.vtu" if number == steps.numbers[-1] else f"{STEPS}/{stem}-{number}.vtu"
            writers[file] = partial(body.write, body_id=index - 1)
            entries.append((float(number), body.name, file))
        if run.contact is not None:
            last = number == steps.numbers[-1]
            file = CONTACT if last else f"{STEPS}/contact-{number}.vtu"
            starts = {body.name: Placement() for body in fields}
            state = run.contact.state if last else run.contact.steps[number - 1].state
            writers[file] = partial(write_contacts, system=run.contact.system, state=state, starts=starts)
            entries.append((float(number), "contact", file))
    if len(entries) > 1:
        writers["bodies.pvd"] = lambda path: write_collection(path, entries)
    return writers
