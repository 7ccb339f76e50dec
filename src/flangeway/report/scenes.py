"""Fields and load steps for pictures and files, and what the interactive pictures of the pages show."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult
from flangeway.cases.section_run import SectionRun
from flangeway.contact import ContactSolution, ContactState, LoadStep
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, cell_stresses, shear_stresses
from flangeway.problems import ElasticField
from flangeway.railway.wheelset.plane_patch import WheelRailPatch
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.report.figures.display import (
    ShownCells,
    field_arrays,
    placed_stresses,
    shown_cells,
    solution_frame,
    write_frame,
)
from flangeway.report.page.record import SummaryTable
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.report.viewer.scene_model import DISPLACEMENT, Formula
from flangeway.types import Floats

# --- Displacements and stresses of the bodies of a case, as their VTU files and the page show them.


@dataclass(frozen=True, eq=False)
class BodyFields:
    """One body at its first place; each cell has points of its own, so that stresses jump between cells."""

    name: str  # name of the body
    shown: ShownCells  # the cells; of orders above 1 the triangles that they are cut into to be shown
    displacement: Floats  # whole motion of the points in space, mm, shape (n_points, 2)
    stresses: Stresses  # stresses at the points, axes of space, each from its own cell

    def write(self, path: Path, body_id: int = 0) -> None:
        """Write a VTU file; the arrays are those of `field_arrays`, the displacements are the whole motion."""
        arrays = field_arrays(self.displacement, self.stresses)
        write_vtu(path, self.shown.mesh, arrays, {"cell_number": self.shown.cells}, body_id=body_id)


def bodies_fields(run: BodiesRun) -> Iterator[BodyFields]:
    """Fields of all bodies in their order, with the elements' own fields shown for their order."""
    for name, body in run.bodies.items():
        yield body_fields(name, body, shown_cells(body.field.space, body.field.space.order))


def body_fields(name: str, body: BodyResult, shown: ShownCells) -> BodyFields:
    """Fields of a body at the points of its cells as they are shown."""
    elastic, stresses = shown.values(body.field)
    motion = body.moved(shown.mesh.points, elastic)
    return BodyFields(name, shown, motion, placed_stresses(stresses, body.placement))


MAX_VALUES = 3_000_000  # maximum number of values of all load steps on the page and in the files


@dataclass(frozen=True, eq=False)
class BodySteps:
    """Load steps with the fields of all bodies."""

    names: tuple[str, ...]  # number, count and name of each step, the last one's last
    numbers: tuple[int, ...]  # number of each step, from 1
    fields: tuple[Sequence[BodyFields], ...]
    """Fields of the bodies in their order, step by step, all at the same points."""
    note: str  # sentence on what is left out, empty if nothing is


def body_steps(run: BodiesRun, last: Sequence[BodyFields]) -> BodySteps:
    """Return the load steps of a run up to `last`, evenly chosen where all have more than `MAX_VALUES` numbers."""
    if run.contact is None:
        return BodySteps(("",), (1,), (last,), "")
    names = [name for name, _ in load_steps(run.contact)]
    earlier, note = run.contact.steps[: len(names) - 1], ""
    names = names[len(names) - 1 - len(earlier) :]
    chosen = evenly(len(names), MAX_VALUES // _n_values(run, last))
    if len(chosen) < len(names):
        kept = f"{len(chosen)} of the {len(names)} load steps are shown, evenly chosen, the last among them"
        if len(chosen) == 1:
            kept = f"Of the {len(names)} load steps only the last is shown"
        note = f"{kept}: a page has room for {MAX_VALUES:,} values."
    fields = [_fields_at(run, earlier[number], last) for number in chosen[:-1]]
    words, numbers = tuple(_words(names, number) for number in chosen), tuple(number + 1 for number in chosen)
    return BodySteps(words, numbers, (*fields, last), note)


def _words(names: Sequence[str], number: int) -> str:
    name = names[number]
    share = f"{name} of loads and displacements" if name.endswith("%") else name
    return f"{number + 1} of {len(names)}: {share}"


def _fields_at(run: BodiesRun, step: LoadStep, like: Sequence[BodyFields]) -> list[BodyFields]:
    bodies = run.at_step(step)
    return [body_fields(body.name, bodies[body.name], body.shown) for body in like]


def _n_values(run: BodiesRun, fields: Sequence[BodyFields]) -> int:
    """Numbers of one step: displacements of the places and stresses, which elements of order 1 have one a cell."""
    total = 0
    for field in fields:
        mesh, constant = field.shown.mesh, run.bodies[field.name].field.space.order == 1
        total += 2 * int(field.shown.places.max() + 1) + 4 * (mesh.n_cells if constant else mesh.n_points)
    return total


def evenly(n: int, most: int) -> list[int]:
    """Numbers of some of n steps, the last among them."""
    chosen: list[int] = np.rint(np.linspace(n - 1, 0, max(min(n, most), 1))).astype(int).tolist()
    return chosen[::-1]


def load_steps(contact: ContactSolution) -> list[tuple[str, ContactState]]:
    """Name and state of each load step, and where it ended without success."""
    steps: list[tuple[str, ContactState]] = []
    legs = any(step.share > 1.0 for step in contact.steps)
    for step in contact.steps:
        leg = max(math.ceil(step.share), 1)
        name = f"leg {leg}: " * legs + f"{100.0 * (step.share - leg + 1):.4g} %"
        steps.append((name, step.state))
    if not contact.status.converged:
        steps.append(("not converged", contact.state))
    return steps


def steps_table(contact: ContactSolution) -> SummaryTable:
    """Iterations, last errors and constraints under force of each load step."""
    rows = []
    for name, state in load_steps(contact):
        last = state.history[-1] if state.history else None
        errors = ("–", "–", "–") if last is None else (
            f"{last.residual:.1e}", f"{last.change:.1e}", f"{last.n_active}"
        )  # fmt: skip
        rows.append((name, f"{len(state.history)}", *errors))
    header = ("fraction of loads and displacements", "iterations", "residual", "change", "active constraints")
    return SummaryTable("Load steps", header, tuple(rows))


# --- Displacements and stresses of the parts in the axes of space, for pictures and files.


def part_fields(result: WheelsetResult) -> Iterator[ShownPart]:
    """Parts at their final places in space, left side first, wheels before rails; mirrored parts are mirrored.

    The displacements of the points are elastic, the stresses are means over the cells, both in the axes of space. The
    rigid motion of a wheel since the first touch of wheels and rails is its approach.
    """
    touches = result.model.placements(result.model.rigid_position)
    at_touch = {part.name: point for part, point in zip(result.model.system.parts, touches, strict=True)}
    for name, part in result.model.parts.items():
        placement, mesh = result.placements[name], part.body.space.mesh
        displacement = result.displacements[name]
        moved = placement.vectors(displacement[: mesh.n_points])
        stresses = placed_stresses(cell_stresses(part.body.elasticity, displacement), placement)
        placed, touch = mesh.placed(placement), at_touch[name].points(mesh.points)
        arrays = {DISPLACEMENT: moved}, {"stresses": stresses.components}
        yield ShownPart(name, placed, *arrays, side=name.rpartition("-")[2], approach=placed.points - touch)


def write_part(path: Path, result: WheelsetResult, name: str) -> None:
    """Write one part at its final position in space; the arrays are those of `field_arrays`.

    Displacements are elastic: a wheel's rigid displacement is in its position, so "Warp By Vector" with factor 1 shows
    the parts as they touch.
    """
    body, displacement = result.model.parts[name].body, result.displacements[name]
    field = ElasticField(body.elasticity, displacement)
    frame = solution_frame(field, part=name, unit="MPa", length_unit="mm", placement=result.placements[name])
    write_frame(path, frame, list(result.model.parts).index(name))


# --- What the interactive pictures of the pages show: parts of wheelsets, bodies, sections.


VIEW_WIDTHS = 8.0  # width of the view of a contact relative to the half width of the contact
MAX_POINTS = 400_000  # points of all bodies above which the page shows whole elements, with values at their corners

_STRESSES: tuple[tuple[str, str, Formula], ...] = (
    ("von_mises_MPa", "von Mises stress", "von-mises"),
    ("principal_1_MPa", "principal stress 1 (maximum)", "principal-1"),
    ("principal_2_MPa", "principal stress 2", "principal-2"),
    ("principal_3_MPa", "principal stress 3 (minimum)", "principal-3"),
    ("max_in_plane_shear_MPa", "maximum in-plane shear", "in-plane-shear"),
    ("stress_xx_MPa", "stress xx", "xx"),
    ("stress_yy_MPa", "stress yy", "yy"),
    ("stress_xy_MPa", "stress xy", "xy"),
    ("stress_zz_MPa", "stress zz", "zz"),
)


def wheelset_scene(parts: Sequence[ShownPart], patches: Sequence[WheelRailPatch]) -> Scene:
    """Parts of a wheelset with element averages, and a view of each contact."""
    views = []
    for patch in patches:
        x, y = patch.centre.tolist()
        alone = sum(other.side == patch.side for other in patches) == 1
        name = f"{patch.side} {'contact' if alone else patch.region}"
        views.append(View(name, (x, y), VIEW_WIDTHS * patch.half_width))
    notes = (
        "Stresses are element averages in the axes of the picture, tension positive; the VTU files have them at the "
        "elements' corners. Displacements are elastic nodal displacements. The deformation factor scales "
        "all displacements since first touch of wheels and rails, rigid and elastic: 0 is first touch, 1 is true. Left "
        "and right brought together changes the picture only, not the coordinates. Stresses in web, fillets and foot "
        "of the rails are those of a slice that carries the load alone: they are not valid for a rail in track.",
    )
    fields = _fields("Stresses, element averages", "Elastic nodal displacements")
    return Scene(parts, fields, views, notes=notes)


def bodies_scene(run: BodiesRun, steps: BodySteps) -> Scene:
    """Bodies with stresses at the points of their files, their load steps, and a view of each region of contact.

    Bodies with very many points are shown with whole cells and the values at their corners; see `body_steps` for what
    is shown of very many steps.
    """
    orders = [body.field.space.order for body in run.bodies.values()]
    whole = max(orders) > 1 and sum(body.shown.mesh.n_points for body in steps.fields[-1]) > MAX_POINTS
    if whole:
        bodies = run.bodies.items()
        steps = body_steps(run, [body_fields(name, body, shown_cells(body.field.space, 1)) for name, body in bodies])
    shown = [_shown_body(of_body) for of_body in zip(*steps.fields, strict=True)]
    notes = [
        "Stresses are in the axes of the picture, tension positive, not averaged between elements, as in the VTU "
        "files: constant in elements of order 1, otherwise evaluated at the points of the files. Displacements are "
        "total, rigid and elastic, from the initial position; the deformation factor scales them: 0 is the initial "
        "position, 1 is true."
    ]
    several = len(steps.names) > 1
    if several:
        notes.append(
            "The values of each load step are those at its end. All steps have one scale over the range of all."
        )
    if whole:
        notes.append("Because of the number of elements only values at their corners are shown; the files have more.")
    return Scene(
        shown,
        _fields("Stresses", "Total displacements"),
        _patch_views(run),
        notes=notes,
        steps=steps.names if several else (),
        steps_note=steps.note,
    )


def _shown_body(steps: Sequence[BodyFields]) -> ShownPart:
    """A body with its values at each step."""
    last = steps[-1]
    arrays = {
        DISPLACEMENT: np.stack([step.displacement for step in steps]),
        "stresses": np.stack([step.stresses.components for step in steps]),
    }
    shown = last.shown
    cells = None if shown.display is None else shown.cells
    return ShownPart(last.name, shown.mesh, arrays, places=shown.places, n_rim_places=shown.n_rim_places, cells=cells)


def _patch_views(run: BodiesRun) -> list[View]:
    """A view of each region of contact."""
    views: list[View] = []
    patches = run.patches
    for number, patch in enumerate(patches, 1):
        name = "contact" if len(patches) == 1 else f"contact {number}"
        x, y = patch.centre.tolist()
        views.append(View(name, (x, y), VIEW_WIDTHS * patch.half_width))
    return views


def _fields(stresses: str, motion: str) -> list[ShownField]:
    """Fields of stresses and displacements under two headings."""
    key = "displacement_mm"
    return [
        *(ShownField(name, words, "MPa", stresses, "stresses", formula) for name, words, formula in _STRESSES),
        ShownField(key, "displacement, magnitude", "mm", motion, DISPLACEMENT, "magnitude"),
        ShownField(f"{key}:x", "displacement x", "mm", motion, DISPLACEMENT, "x"),
        ShownField(f"{key}:y", "displacement y", "mm", motion, DISPLACEMENT, "y"),
    ]


def section_scene(run: SectionRun) -> Scene:
    """Warping, Prandtl's function and the shear stress of a section; nothing of it moves in the plane."""
    unit = run.drawn.unit
    points, cells = section_arrays(run)
    (warping, prandtl), (shear,) = points, cells
    shown = ShownPart("section", run.space.mesh, {name: values[:, None] for name, values in points.items()}, cells)
    at_points, means, per_area = "Functions of torsion, at nodes", "Shear stress, element averages", f"1/{unit}³"
    fields = [
        ShownField(shear, "shear stress / torque, magnitude", per_area, means, shear, "magnitude"),
        ShownField(f"{shear}:x", "shear stress / torque, xz", per_area, means, shear, "x"),
        ShownField(f"{shear}:y", "shear stress / torque, yz", per_area, means, shear, "y"),
        ShownField(warping, "warping / rate of twist", f"{unit}²", at_points, warping, "value"),
        ShownField(prandtl, "Prandtl's function / (G times rate of twist)", f"{unit}²", at_points, prandtl, "value"),
    ]
    notes = (
        "Shear stresses are element averages for a unit torque; warping is about the shear centre, for a unit rate of "
        "twist; section.vtu has the shear stresses at the corners of the elements.",
    )
    return Scene([shown], fields, unit=unit, notes=notes)


def section_arrays(run: SectionRun) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Arrays of a section by their names in its file, unit in each: of points (n,), and of cells (n, 2)."""
    mesh, unit, prandtl = run.space.mesh, run.drawn.unit, run.constants.prandtl
    points = {
        f"warping_{unit}2": warping_about_shear_centre(run),
        f"prandtl_{unit}2": prandtl.function[: mesh.n_points] / prandtl.problem.mean_modulus,
    }
    return points, {f"shear_stress_per_torque_per_{unit}3": shear_stresses(prandtl) / prandtl.torsional_rigidity}


def warping_about_shear_centre(run: SectionRun) -> Floats:
    """Warping at the mesh's points about Trefftz's shear centre, per rate of twist, shape (n_points,)."""
    mesh, solution = run.space.mesh, run.constants.warping
    centre = solution.problem.centre
    ray = np.array(run.constants.shear_centre_trefftz) - centre
    x, y = (mesh.points - centre).T
    values: Floats = solution.function[: mesh.n_points] - ray[1] * x + ray[0] * y
    return values


def part_numbers(mesh: PolyMesh) -> NDArray[np.int32]:
    """Return the number of each cell's part, shape (n_cells,)."""
    part = np.zeros(mesh.n_cells, dtype=np.int32)
    for number, cells in enumerate(mesh.cell_sets.values()):
        part[cells] = number
    return part
