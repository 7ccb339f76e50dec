"""Report, files and terminal summary of a wheelset."""

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

from matplotlib.figure import Figure

from flangeway.cases import CaseRun
from flangeway.cases.wheelset.spatial_wheelset_summary import SpatialWheelsetSummary, WheelPatchSummary
from flangeway.cases.wheelset.wheelset_summary import ContactSummary, WheelsetSummary
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.fields import PartFields, part_fields, write_part
from flangeway.report.figures.newton_history import newton_figure
from flangeway.report.figures.series import write_collection, write_contacts
from flangeway.report.page.case_text import run_record
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import marked, number
from flangeway.report.scenes import wheelset_scene
from flangeway.report.wheelset.contact_figure import contact_figure, pressure_figure
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.report.wheelset.wheelset_tables import (
    bodies_table,
    contact_name,
    contacts_table,
    position_table,
    results_table,
    rigid_table,
    stresses_table,
)
from flangeway.system.output_folder import Writer

FILES = (
    "The same numbers, for programs, are in `summary.json`; the fields are in `wheelset.pvd`, which ParaView opens "
    "with all four parts."
)


def wheelset_record(run: CaseRun) -> Record:
    """Return what a run of a wheelset found."""
    summary = run.summary
    problem = run.result.model.problem
    contacts = (contacts_table,) if summary.contacts else ()
    tables = (*contacts, position_table, rigid_table, stresses_table, bodies_table)
    fields = cache(lambda: list(part_fields(run.result)))
    return run_record(
        run,
        FILES,
        subtitle=f"Wheel {problem.wheelset.wheel.title} on rail {problem.track.rail.title}; plane strain, "
        f"{problem.thickness_mm:g} mm of length; {_method(run)}",
        facts=_facts(summary),
        results=results_table(summary),
        sentences=[_reference(summary)],
        warnings=summary.warnings,
        assumptions=summary.assumptions,
        scene=lambda: wheelset_scene(fields(), summary.contacts),
        pictures=_pictures(run, fields),
        tables=[table(summary) for table in tables],
        axes=summary.axes,
        files=lambda: _files(run),
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
    contacts = [(each, contact_name(each, summary.contacts)) for each in summary.contacts]
    return wheelset_facts(summary, f"{summary.position.lateral_mm:z.3f} mm", contacts)


def wheelset_facts(
    summary: WheelsetSummary | SpatialWheelsetSummary,
    lateral: str,
    patches: Sequence[tuple[ContactSummary | WheelPatchSummary, str]],
) -> list[tuple[str, str]]:
    """L/V of both wheels, the lateral position, the maximum pressure of each patch by its name, and the residual."""
    facts = [
        (number(side.lateral_over_vertical, 3), f"L/V of the {side.side} wheel")
        for side in summary.sides
        if side.lateral_over_vertical is not None
    ]
    facts.append((lateral, "lateral position of the axle"))
    for patch, name in patches:
        pressure = marked(number(patch.max_pressure_MPa, 0) + " MPa", patch.max_pressure_remark)
        facts.append((pressure, f"maximum pressure, {name}"))
    residual = summary.residual.equilibrium
    return [*facts, ("–" if residual is None else f"{residual:.0e}", "equilibrium residual")]


PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
COLLECTION, CONTACT = "wheelset.pvd", "contact.vtu"
PICTURES = (
    "wheelset.png", "stresses-left.png", "stresses-right.png", "pressure.png",
    "convergence.png",
)  # fmt: skip
NAMES = (*(f"{part}.vtu" for part in PARTS), CONTACT, COLLECTION, *PICTURES)


def _files(run: CaseRun) -> dict[str, Writer]:
    """Return functions that write the fields, by the files' names."""
    result = run.result
    writers: dict[str, Writer] = {f"{name}.vtu": partial(write_part, result=result, name=name) for name in PARTS}
    writers[CONTACT] = lambda path: write_contacts(
        path, result.model.system, result.equilibrium.state, {name: result.placements[name] for name in PARTS}
    )
    vtu_files = [(0.0, Path(file).stem, file) for file in writers]
    writers[COLLECTION] = lambda path: write_collection(path, vtu_files)
    return writers


def _pictures(run: CaseRun, fields: Callable[[], list[PartFields]]) -> list[Picture]:
    """Return all pictures in the order of `PICTURES`."""
    described: list[tuple[Callable[[], Figure], str, str]] = [
        (
            lambda: wheelset_figure(run, fields()),
            "Left and right wheel on their rails, deformed and coloured by von Mises stress, with a sketch of the "
            "wheelset, its load and its dimensions between them.",
            "The wheelset on its rails: von Mises stress on the deformed parts. Dark is most loaded; numbers on the "
            "lines are in the unit of the colours. Web and foot of the rails are hatched: their stresses are those of "
            "a slice that carries the load alone and are not valid for a rail.",
        ),
        *(
            (
                partial(lambda side: contact_figure(run, fields(), side), side),
                f"The contact zones of the {side} side, deformed, with the mesh, coloured by von Mises stress, by the "
                "minimum principal stress with the contact forces on the wheel as arrows, and by the maximum in-plane "
                "shear stress.",
                f"Contact zones of the {side} side, deformed: von Mises stress, minimum principal stress and maximum "
                "in-plane shear stress of each element. Both sides have the same colours.",
            )
            for side in SIDES
        ),
        (
            lambda: pressure_figure(run),
            "Contact pressure along the surface of both sides: nodes of the mesh and Hertz's ellipse.",
            "Contact pressure along the surface: nodal forces over their areas, and Hertz's theory for the same force "
            "and the profiles' radii at the contact, where the profiles are not conforming.",
        ),
        (
            lambda: newton_figure([("", run.result.equilibrium.state)]),
            "Residual and change of Newton's iterations, on a logarithmic axis.",
            "Newton's iterations for forces and position: residual of forces over the total force, or violation "
            "of the contact law, and change of the displacements.",
        ),
    ]
    return [Picture(name, *each) for name, each in zip(PICTURES, described, strict=True)]
