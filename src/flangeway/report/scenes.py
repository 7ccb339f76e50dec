"""What the interactive pictures of the pages show: parts of wheelsets, bodies, sections."""

from collections.abc import Sequence

import numpy as np

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.section.section_run import SectionRun
from flangeway.post import shear_stresses
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.report.bodies.body_fields import BodyFields, BodySteps, body_fields, body_steps
from flangeway.report.figures.display import shown_cells
from flangeway.report.section.section_figures import warping_about_shear_centre
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.report.viewer.scene_model import DISPLACEMENT, Formula
from flangeway.types import Floats

VIEW_WIDTHS = 8.0  # width of the view of a contact over the half width of the contact
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
        x, y = patch.pressure.centre.tolist()
        alone = sum(other.side == patch.side for other in patches) == 1
        name = f"{patch.side} {'contact' if alone else patch.region}"
        views.append(View(name, (x, y), VIEW_WIDTHS * patch.pressure.half_width))
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
    whole = max(orders) > 1 and sum(each.shown.mesh.n_points for each in steps.fields[-1]) > MAX_POINTS
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
        DISPLACEMENT: np.stack([each.displacement for each in steps]),
        "stresses": np.stack([each.stresses.components for each in steps]),
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
