"""Files, report and terminal summary of one contact patch that rolls with friction."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from flangeway.cases.patch_quantities import (
    BY_THEORY,
    FORCES,
    LATERAL_FORCE,
    LONGITUDINAL_FORCE,
    SLIP_AREA,
    T_GAMMA,
    TRACTION,
)
from flangeway.cases.rolling_patch_case import (
    ENERGY_ERROR,
    MAX_PRESSURE,
    PATCH,
    STATE,
    RollingPatchRun,
)
from flangeway.formats import write_vtu
from flangeway.quantities import columns, present
from flangeway.report.page.html_page import run_record
from flangeway.report.page.record import Picture, Report, SummaryTable, fact, rows_of, table_across
from flangeway.report.patch_maps import at_corners, cell_columns, cell_fields, shown_fields, strip_mesh
from flangeway.report.viewer import Scene, ShownPart
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer
from flangeway.types import Floats

CELLS, CURVE_TABLE, PATCH_FILE = "cells.csv", "creep-curve.csv", "patch.vtu"
AXES = {
    "ahead, right": "directions of rolling and across it, seen from above; y and x in the file for ParaView",
    "creepage": "slip of the upper body on the lower one over the speed; spin counter-clockwise seen from above",
    "force": "on the upper body, about the centre of pressure; the spin moment counter-clockwise",
    "CONTACT": "for rolling ahead xi, eta and phi are the longitudinal, the lateral and minus the spin creepage; F_x, "
    "F_y and M_z the longitudinal force, the lateral one, and minus the spin moment",
}
DIGITS = 6


def rolling_patch_record(run: RollingPatchRun) -> Report:
    """Return what a run of one patch found."""
    case, state, units = run.case, run.state, run.case.units
    across, along = (part.stop - part.start for part in run.contact.box)
    results = rows_of(PATCH, run, units)
    results += rows_of(present(STATE[1:], state), state, units)
    return run_record(
        run,
        "The same numbers, for programs, are in `summary.json`; pressures, tractions, slip and states of all cells in "
        f"`{CELLS}` and, for ParaView, in `{PATCH_FILE}`"
        + (f"; the creep curve in `{CURVE_TABLE}`." if run.curve else "."),
        subtitle=f"{state.theory}, {across} by {along} cells, {case.motion.words}, "
        f"coefficient of friction {case.friction:g}",
        facts=[
            *(fact(quantity, state, units) for quantity in (LONGITUDINAL_FORCE, LATERAL_FORCE, TRACTION)),
            fact(MAX_PRESSURE, run, units),
            *(fact(quantity, state, units) for quantity in present((SLIP_AREA, T_GAMMA), state)),
        ],
        results=SummaryTable("Results", ("", "value"), tuple(results)),
        warnings=run.notices,
        assumptions=[
            "Half-spaces, linear elastic; the patch is flat.",
            "Fast theories take the ellipse with the second moments of the pressures, and the mean material.",
        ],
        scene=lambda: _scene(run),
        pictures=lambda: _pictures(run),
        tables=_tables(run),
        axes=AXES,
        files=lambda: _files(run),
    )


def _pictures(run: RollingPatchRun) -> Sequence[Picture]:
    from flangeway.report.rolling_patch_figures import rolling_patch_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return rolling_patch_pictures(run)


def _tables(run: RollingPatchRun) -> list[SummaryTable]:
    tables, names = [], [rolling.theory for rolling in run.theories]
    if names:
        caption = "The same creepages by all theories"
        tables.append(table_across(caption, names, run.theories, (*FORCES, T_GAMMA), units=run.case.units))
    if run.residuals:
        rows = [(f"law of friction: {name}", f"{value:.1e}") for name, value in run.residuals.items()]
        rows += rows_of([ENERGY_ERROR], run)
        tables.append(SummaryTable("Residuals", ("", "value"), tuple(rows)))
    return tables


def _fields(run: RollingPatchRun) -> dict[str, Floats]:
    """Fields of the cells, (n_cells, n_strips) or vectors to the right and ahead with a third component 0."""
    fields = {"pressure_MPa": run.contact.pressures}
    cells = run.state.cells
    if cells is None:
        return fields
    for name, values in cell_fields(cells, abs(cells.motion.speed)).items():
        fields[name] = np.pad(values, ((0, 0), (0, 0), (0, 1))) if values.ndim > 2 else values
    return fields


def _scene(run: RollingPatchRun) -> Scene:
    grid = run.contact.grid
    mesh = strip_mesh(grid.bounds, grid.strip_bounds)
    fields, arrays = shown_fields(_fields(run))
    part = ShownPart("patch", mesh, cell_arrays={name: values.reshape(-1, 1) for name, values in arrays.items()})
    note = (
        "The patch from above: x to the right, y ahead. Values are means over cells, vectors are shown by their sizes."
    )
    return Scene([part], fields, notes=(note,))


def _write_patch(run: RollingPatchRun, path: Path) -> None:
    part = _scene(run).parts[0]
    space = np.column_stack((part.mesh.points, np.zeros(part.mesh.n_points)))
    write_vtu(path, part.mesh, corner_data=at_corners(_fields(run)), positions=space)


def _cells_table(run: RollingPatchRun) -> str:
    """Fields of the cells with pressure as CSV, places from the centre of pressure."""
    s, z = run.contact.places
    loaded = run.contact.pressures > 0.0
    cells: dict[str, Floats] = {
        "right_mm": np.broadcast_to(s[:, None], loaded.shape)[loaded],
        "ahead_mm": np.broadcast_to(z, loaded.shape)[loaded],
    }
    cells |= cell_columns(run.contact.grid, _fields(run), loaded)
    return ResultTable(cells).in_units(run.case.units).csv(DIGITS)


def _files(run: RollingPatchRun) -> dict[str, Writer]:
    files: dict[str, Writer] = {CELLS: text_writer(_cells_table(run)), PATCH_FILE: partial(_write_patch, run)}
    if run.curve:
        points = [point for points in run.curve.values() for point in points]
        files[CURVE_TABLE] = text_writer(columns(BY_THEORY, points, run.case.units).csv(DIGITS))
    return files
