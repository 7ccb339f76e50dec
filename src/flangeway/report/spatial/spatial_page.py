"""Files, report and terminal summary of two bodies in contact in three dimensions."""

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.spatial.spatial_case import SpatialRun
from flangeway.cases.spatial.spatial_summary import SpatialSummary
from flangeway.contact.patch.patch_body import points_along
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import SectionStresses, SpatialStresses
from flangeway.report.figures.drawing import named
from flangeway.report.figures.series import write_collection
from flangeway.report.page.case_text import run_record
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import Column, SummaryTable, table_across, with_whole
from flangeway.report.spatial.patch_map import surface_mesh
from flangeway.report.spatial.spatial_figures import depth_figure, patch_figure, pressure_figure
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.system.output_folder import Writer
from flangeway.types import Ints

PICTURES: dict[str, tuple[Callable[[SpatialRun], Figure], str]] = {
    "patch.png": (patch_figure, "The pressure from above, with the outline of the patch and Hertz's ellipse"),
    "pressure.png": (pressure_figure, "The pressure across and along z through its maximum, beside Hertz's"),
    "depth.png": (depth_figure, "Stresses below the centre of the patch in both bodies"),
}
COLLECTION, SURFACE = "bodies.pvd", "surface.vtu"
SECTIONS = ("section-lower.vtu", "section-upper.vtu")
NAMES = (*PICTURES, SURFACE, *SECTIONS, COLLECTION)
NEAR = 6.0
"""Width of the view of a patch over its longer semi-axis."""
AXES = {
    "x, y, z": "to the right, up, and along the prisms towards the reader of a section",
    "force": "on the upper body",
    "angle": "from z to the longer semi-axis; positive to the left, seen from above with z up",
    "stresses": "tension positive; below the patch x is along the surface, y along its normal",
}


def _write_surface(run: SpatialRun, path: Path) -> None:
    """Write pressure and gap of the cells on the first body's surface."""
    contact = run.contact
    nodes, z, mesh = surface_mesh(contact.cells)
    ends, _ = points_along(contact.pair.first.chain, nodes)
    space = np.column_stack((np.repeat(ends, len(z), axis=0), np.tile(z, len(nodes))))
    values = {"pressure_MPa": contact.pressures, "gap_mm": contact.contact.gaps}
    write_vtu(path, mesh, corner_data={key: np.repeat(each, 4) for key, each in values.items()}, positions=space)


def _write_section(section: SectionStresses, stresses: SpatialStresses, body_id: int, path: Path) -> None:
    """Write the stresses of a section, each cell with points of its own."""
    mesh = _mesh(section)
    positions = np.column_stack((mesh.points, np.full(mesh.n_points, section.z)))
    arrays = {"stress_MPa": stresses.components, "von_mises_MPa": stresses.von_mises}
    write_vtu(path, mesh, corner_data=arrays, positions=positions, body_id=body_id)


def _mesh(section: SectionStresses) -> PolyMesh:
    return section.body.problem.elasticity.space.mesh.placed(section.body.placement)


def spatial_record(run: SpatialRun) -> Record:
    """Return what a run of two bodies in contact in three dimensions found."""
    corners = cache(lambda: [section.corners() for section in run.sections])
    summary = run.summary
    patch = summary.patches[0]
    return run_record(
        run,
        "The same numbers, for programs, are in `summary.json`; `surface.vtu` has pressures and gaps, "
        "`section-lower.vtu` and `section-upper.vtu` stresses, for ParaView.",
        subtitle=f"{len(summary.patches)} patch{'es' * (len(summary.patches) > 1)} on {summary.cells[0]} by "
        f"{summary.cells[1]} cells",
        facts=[
            (f"{patch.max_pressure_MPa:.5g} MPa", "maximum pressure"),
            (f"{patch.semi_axes_mm[0]:.4g} mm", "longer semi-axis of the patch"),
            (f"{patch.semi_axes_mm[1]:.4g} mm", "shorter semi-axis"),
            (f"{1e-3 * summary.force_N[1]:.5g} kN", "force"),
            (f"{summary.approach_mm:.4g} mm", "approach"),
            (f"{max(b.max_von_mises.value_MPa for b in summary.bodies):.4g} MPa", "maximum von Mises stress below it"),
        ],
        results=_results(summary),
        warnings=summary.notices,
        assumptions=[
            "Linear elastic bodies, small strains, contact without friction.",
            "Each body is a prism along z of unlimited length; of a body of revolution the true surface is in the gap, "
            "its elasticity is that of the prism of its section.",
            "The load acts along y; the upper body is held along x and against rotation.",
            "Hertz's values are those of half-spaces for the same force and the curvatures of the gap under pressure.",
        ],
        scene=lambda: _scene(run, corners()),
        pictures=[Picture(name, partial(draw, run), f"{words}.") for name, (draw, words) in PICTURES.items()],
        tables=[_bodies_table(summary)],
        axes=AXES,
        files=lambda: _files(run, corners()),
    )


def _files(run: SpatialRun, corners: list[SpatialStresses]) -> dict[str, Writer]:
    writers: dict[str, Writer] = {SURFACE: lambda path: _write_surface(run, path)}
    for number, (name, section, stresses) in enumerate(zip(SECTIONS, run.sections, corners, strict=True)):
        writers[name] = partial(_write_section, section, stresses, number)
    files = [(0.0, Path(file).stem, file) for file in (*SECTIONS, SURFACE)]
    writers[COLLECTION] = lambda path: write_collection(path, files)
    return writers


def _scene(run: SpatialRun, corners: list[SpatialStresses]) -> Scene:
    parts = []
    for section, stresses in zip(run.sections, corners, strict=True):
        mesh = _mesh(section)
        used, places = np.unique(mesh.cell_points, return_inverse=True)
        own = PolyMesh(mesh.points[mesh.cell_points], mesh.cell_offsets, np.arange(len(places), dtype=np.int32))
        arrays = {name: values[:, None] for name, values in stresses.by_name.items()}
        numbers: Ints = places.astype(np.int64)
        parts.append(ShownPart(section.body.name, own, arrays, places=numbers, n_rim_places=len(used)))
    fields = [ShownField(name, named(name)[0], "MPa", "Stresses", name, "value") for name in corners[0].by_name]
    patch = run.summary.patches[0]
    view = View("patch", (patch.centre_mm[0], patch.centre_mm[1]), NEAR * patch.semi_axes_mm[0])
    note = (
        f"Stresses in the plane z = {run.sections[0].z:z.3f} mm, of the centre of the first patch, in the axes of the "
        "picture, tension positive, as in the VTU files of the sections."
    )
    return Scene(parts, fields, [view], notes=(note,))


def _results(summary: SpatialSummary) -> SummaryTable:
    """Approach, stresses of the bodies, and the patches, one column a patch."""
    quantities: list[Column] = [
        ("force {x|y}, N", "force_N", "z.1f"),
        ("centre of pressure {x|y|z}, mm", "centre_mm", "z.3f"),
        ("maximum pressure, MPa", "max_pressure_MPa", ".1f"),
        ("  Hertz, MPa", "hertz_pressure_MPa", ".1f"),
        ("{longer|shorter} semi-axis, mm", "semi_axes_mm", ".4f"),
        ("  Hertz, {longer|shorter}, mm", "hertz_semi_axes_mm", ".4f"),
        ("orientation of the major axis, degrees", "angle_deg", "z.1f"),
        ("area, mm²", "area_mm2", ".3f"),
        ("cells {across|along z}", "cells", "d"),
    ]
    names = [f"patch {number}" for number in range(1, len(summary.patches) + 1)]
    whole = {"approach from first touch, mm": f"{summary.approach_mm:.5g}"}
    for body in summary.bodies:
        whole[f"von Mises below the first patch, {body.name}, MPa"] = f"{body.max_von_mises.value_MPa:.1f}"
    return with_whole(table_across("Results", names, summary.patches, quantities), whole)


def _bodies_table(summary: SpatialSummary) -> SummaryTable:
    quantities: list[Column] = [
        *(("elements", "elements", ","), ("unknowns", "unknowns", ","), ("wavenumbers", "wavenumbers", "d")),
        ("maximum von Mises stress below the first patch, MPa", lambda body: body.max_von_mises.value_MPa, ".1f"),
        ("  at the depth, mm", lambda body: body.max_von_mises.depth_mm, ".3f"),
        ("maximum Tresca stress below the first patch, MPa", lambda body: body.max_tresca.value_MPa, ".1f"),
        ("  at the depth, mm", lambda body: body.max_tresca.depth_mm, ".3f"),
    ]
    return table_across("Bodies", [body.name for body in summary.bodies], summary.bodies, quantities)
