"""Files, report and terminal summary of two bodies in contact in three dimensions."""

from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from flangeway.cases.patch_quantities import AXES as SEMI_AXES
from flangeway.cases.patch_quantities import MAX_PRESSURE
from flangeway.cases.spatial_case import APPROACH, BODY, LOAD, MAX_VON_MISES, PATCH, SpatialRun
from flangeway.contact.patch.patch_grid import points_along
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import SectionStresses, SpatialStresses
from flangeway.report.figures.display import collection
from flangeway.report.page.html_page import run_record
from flangeway.report.page.record import (
    Picture,
    Report,
    SummaryTable,
    fact,
    named,
    rows_of,
    table_across,
    with_whole,
)
from flangeway.report.patch_maps import at_corners, cell_columns, normal_fields, strip_mesh
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer
from flangeway.types import Ints

SURFACE, CELLS = "surface.vtu", "cells.csv"
SECTIONS = ("section-lower.vtu", "section-upper.vtu")
PATCH_VIEW_WIDTH = 6.0
"""Width of the view of a patch relative to its longer semi-axis."""
AXES = {
    "x, y, z": "to the right, up, and along the prisms towards the reader of a section",
    "force": "on the upper body",
    "a, b": "longer and shorter semi-axis of the ellipse with the same second moments of pressure as Hertz's",
    "orientation": "from z to the major axis; positive to the left, seen from above with z up",
    "stresses": "tension positive; below the patch x is along the surface, y along its normal",
}


def _write_surface(run: SpatialRun, path: Path) -> None:
    """Write pressure and gap of the cells on the first body's surface."""
    contact = run.contact
    nodes, z = contact.pair.grid.bounds, contact.pair.grid.strip_bounds
    ends, _ = points_along(contact.pair.first.chain, nodes)
    space = np.column_stack((np.repeat(ends, len(z), axis=0), np.tile(z, len(nodes))))
    values = {"pressure_MPa": contact.pressures, "gap_mm": contact.contact.gaps}
    write_vtu(path, strip_mesh(nodes, z), corner_data=at_corners(values), positions=space)


def _cells_table(run: SpatialRun) -> str:
    """Return all cells under pressure as CSV, a row for each, with their points on the first body."""
    cells, inside = run.contact.cells, run.contact.loaded
    row, strip = np.nonzero(inside)
    stations, z = cells.grid.middles
    x, y = cells.points[row].T
    patches = sum(number * patch.inside for number, patch in enumerate(run.contact.patches, 1))
    positions = {
        "patch": np.asarray(patches)[inside],
        "along_surface_mm": stations[row],
        "x_mm": x,
        "y_mm": y,
        "z_mm": z[strip],
    }
    fields = normal_fields(cells, run.contact.contact.approach * cells.normals[:, 1:])
    return ResultTable(positions | cell_columns(cells.grid, fields, inside)).in_units(run.case.units).csv(6)


def _write_section(section: SectionStresses, stresses: SpatialStresses, body_id: int, path: Path) -> None:
    """Write the stresses of a section, each cell with points of its own."""
    mesh = _mesh(section)
    positions = np.column_stack((mesh.points, np.full(mesh.n_points, section.z)))
    arrays = {"stress_MPa": stresses.components, "von_mises_MPa": stresses.von_mises}
    write_vtu(path, mesh, corner_data=arrays, positions=positions, body_id=body_id)


def _mesh(section: SectionStresses) -> PolyMesh:
    return section.body.problem.elasticity.space.mesh.placed(section.body.placement)


def _pictures(run: SpatialRun) -> Sequence[Picture]:
    from flangeway.report.spatial_figures import spatial_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return spatial_pictures(run)


def spatial_record(run: SpatialRun) -> Report:
    """Return what a run of two bodies in contact in three dimensions found."""
    corners = cache(lambda: [section.corners() for section in run.sections])
    units, (patch, *_), n = run.case.units, run.patches, len(run.patches)
    across, along = run.contact.loaded.shape
    highest = max(run.bodies, key=lambda body: body.von_mises[0])
    names = [body.name for body in run.bodies]
    return run_record(
        run,
        "The same numbers, for programs, are in `summary.json`; position, gap, pressure and displacement of each cell "
        "in `cells.csv`; `surface.vtu` has pressures and gaps, "
        "`section-lower.vtu` and `section-upper.vtu` stresses, for ParaView.",
        subtitle=f"{n} patch{'es' * (n > 1)} on {across} by {along} cells",
        facts=[
            *(fact(quantity, patch, units) for quantity in (MAX_PRESSURE, SEMI_AXES)),
            *(fact(quantity, run.contact, units) for quantity in (LOAD, APPROACH)),
            fact(MAX_VON_MISES, highest, units, highest.name),
        ],
        results=_results(run),
        warnings=run.notices,
        assumptions=[
            "Linear elastic bodies, small strains, contact without friction.",
            "Each body is a prism along z of unlimited length; of a body of revolution the true surface is in the gap, "
            "its elasticity is that of the prism of its section.",
            "The load acts along y; the upper body is held along x and against rotation.",
            "Hertz's values are those of half-spaces for the same force and the curvatures of the gap under pressure.",
        ],
        scene=lambda: _scene(run, corners()),
        pictures=lambda: _pictures(run),
        tables=[table_across("Bodies, and stresses below the first patch", names, run.bodies, BODY, units=units)],
        axes=AXES,
        files=lambda: _files(run, corners()),
    )


def _files(run: SpatialRun, corners: list[SpatialStresses]) -> dict[str, Writer]:
    writers: dict[str, Writer] = {
        name: partial(_write_section, section, stresses, number)
        for number, (name, section, stresses) in enumerate(zip(SECTIONS, run.sections, corners, strict=True))
    }
    writers[SURFACE] = lambda path: _write_surface(run, path)
    writers[CELLS] = text_writer(_cells_table(run))
    return writers | {"bodies.pvd": collection(writers)}


def _scene(run: SpatialRun, corners: list[SpatialStresses]) -> Scene:
    parts = []
    for section, stresses in zip(run.sections, corners, strict=True):
        mesh = _mesh(section)
        used, of_corners = np.unique(mesh.cell_points, return_inverse=True)
        arrays = {name: values[:, None] for name, values in stresses.by_name.items()}
        numbers: Ints = of_corners.astype(np.int64)
        parts.append(ShownPart(section.body.name, mesh.apart(), arrays, places=numbers, n_rim_places=len(used)))
    fields = [ShownField(name, named(name)[0], "MPa", "Stresses", name, "value") for name in corners[0].by_name]
    patch = run.contact.patches[0]
    view = View("patch", (float(patch.centre[0]), float(patch.centre[1])), PATCH_VIEW_WIDTH * patch.semi_axes[0])
    note = (
        f"Stresses in the plane z = {run.sections[0].z:z.3f} mm, of the centre of the first patch, in the axes of "
        "the picture, tension positive, as in the VTU files of the sections."
    )
    return Scene(parts, fields, [view], notes=(note,))


def _results(run: SpatialRun) -> SummaryTable:
    """Approach, stresses of the bodies, and the patches, one column a patch."""
    units, names = run.case.units, [f"patch {number}" for number in range(1, len(run.patches) + 1)]
    whole = rows_of([APPROACH], run.contact, units)
    for body in run.bodies:
        whole += rows_of([MAX_VON_MISES], body, units, body.name)
    return with_whole(table_across("Results", names, run.patches, PATCH, units=units), dict(whole))
