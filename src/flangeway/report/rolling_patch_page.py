"""Files, report and terminal summary of one contact patch that rolls with friction."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.patch_quantities import (
    BY_THEORY,
    CREEPAGES,
    FORCES,
    LATERAL_FORCE,
    LONGITUDINAL_FORCE,
    SLIP_AREA,
    SPIN_MOMENT,
    T_GAMMA,
    TRACTION,
)
from flangeway.cases.rolling_patch_case import (
    COMPONENTS,
    ENERGY_ERROR,
    MAX_PRESSURE,
    PATCH,
    STATE,
    RollingPatchRun,
)
from flangeway.contact.rolling.fast_theories import TITLES, Theory
from flangeway.errors import InputError
from flangeway.formats import write_vtu
from flangeway.quantities import columns, numbers, present
from flangeway.report.figures.drawing import GREY, INK, PURPLE, SERIES, legend_below, name_axes, panels
from flangeway.report.page.html_page import run_record
from flangeway.report.page.record import Figures, Picture, Report, SummaryTable, fact, rows_of, table_across
from flangeway.report.patch_maps import ShownRolling, at_corners, cell_fields, rolling_figure, shown_fields, strip_mesh
from flangeway.report.viewer import Scene, ShownPart
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer
from flangeway.types import Floats

MAPS, SECTION, CURVE = "rolling.png", "tractions.png", "creep-curve.png"
CELLS, CURVE_TABLE, PATCH_FILE = "cells.csv", "creep-curve.csv", "patch.vtu"
CAPTIONS = {
    MAPS: "The patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the upper "
    "body; slip; frictional power per area.",
    SECTION: "Tractions on the upper body in the middle of the patch, along and across, below their limit, friction "
    "times pressure. Where the magnitude reaches it the surfaces slip. Steps across are those of the leading edge on "
    "the cells: more cells make them smaller.",
    CURVE: "Creep forces on the upper body and spin moment over one creepage by all theories; the others are those of "
    "the case.",
}
AXES = {
    "ahead, right": "directions of rolling and across it, seen from above; y and x in the file for ParaView",
    "creepage": "slip of the upper body on the lower one over the speed; spin counter-clockwise seen from above",
    "force": "on the upper body, about the centre of pressure; the spin moment counter-clockwise",
    "CONTACT": "for rolling ahead xi, eta and phi are the longitudinal, the lateral and minus the spin creepage; F_x, "
    "F_y and M_z the longitudinal force, the lateral one, and minus the spin moment",
}
STYLES: dict[Theory, tuple[str, Any]] = {
    "exact": (INK, "-"), "fastsim": (SERIES[0], (0, (5, 2))), "fastrip": (SERIES[2], "--"),
    "polach": (SERIES[1], "dashdot"), "linear": (GREY, (0, (1, 1.5))),
}  # fmt: skip
CREEPAGE_OF = dict(zip(COMPONENTS, CREEPAGES, strict=True))
MAX_DRAWN_FORCE = 1.3
"""Highest force that is drawn relative to the limit of friction: linear theory goes on."""
WIDE_IN = 7.5
"""Width of a picture with room for all names beside each other."""
ROUND_OFF = 1e-6
"""Force relative to the limit of friction, and moment over this times the semi-axis along, that is none and not
drawn."""
DIGITS = 6


def rolling_patch_record(run: RollingPatchRun) -> Report:
    """Return what a run of one patch found."""
    case, state, units = run.case, run.state, run.case.units
    moves = f"at {case.speed_km_h:g} km/h" if case.rolls else "shifted"
    across, along = (part.stop - part.start for part in run.contact.box)
    results = rows_of(PATCH, run, units)
    results += rows_of(present(STATE[1:], state), state, units)
    return run_record(
        run,
        "The same numbers, for programs, are in `summary.json`; pressures, tractions, slip and states of all cells in "
        f"`{CELLS}` and, for ParaView, in `{PATCH_FILE}`"
        + (f"; the creep curve in `{CURVE_TABLE}`." if run.curve else "."),
        subtitle=f"{state.theory}, {across} by {along} cells, {moves}, coefficient of friction {case.friction:g}",
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
        pictures=[Picture(name, draw, CAPTIONS[name]) for name, draw in _pictures(run).items()],
        tables=_tables(run),
        axes=AXES,
        files=lambda: _files(run),
    )


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


def _shown(run: RollingPatchRun) -> ShownRolling:
    # t of the patch is drawn to the right
    forces = run.state.cells
    assert forces is not None
    return ShownRolling("patch", forces, abs(forces.motion.speed), 0.0, -1.0)


def _pictures(run: RollingPatchRun) -> Figures:
    figures: Figures = {}
    if run.state.cells is not None:
        figures[MAPS] = lambda: rolling_figure([_shown(run)], run.case.units)
        figures[SECTION] = lambda: section_figure(run)
    if run.curve:
        figures[CURVE] = lambda: creep_curve_figure(run)
    return figures


def main_figure(run: RollingPatchRun) -> Figure:
    """Draw the first picture that there is; an `InputError` if there is none."""
    for draw in _pictures(run).values():
        return draw()
    raise InputError(
        f"a picture of {run.state.theory} without a creep curve", "a theory with tractions, or a curve", "choose one"
    )


def section_figure(run: RollingPatchRun) -> Figure:
    """Draw tractions and their limit through the middle of the patch, along and across."""
    assert run.state.cells is not None
    contact, tractions = run.contact, run.state.cells.tractions
    across, along = contact.places
    limit = contact.friction.limits[0][:, None] * contact.pressures
    row, strip = (int(np.abs(centres).argmin()) for centres in (across, along))
    figure, (both,) = panels(9.0, 3.7, 1, 2, run.case.units, sharey=True)
    lines = (
        (along, limit[row], tractions[row], "z ahead"),
        (across, limit[:, strip], tractions[:, strip], "to the right"),
    )
    for axes, (positions, most, cut, words) in zip(both, lines, strict=True):
        axes.fill_between(positions, most, color="#e8edf3", lw=0.0, label="up to the limit")
        axes.plot(positions, np.linalg.norm(cut, axis=-1), color=INK, lw=1.4, label="magnitude")
        axes.plot(positions, cut[:, 1], color=SERIES[0], lw=1.2, ls="--", label="ahead")
        axes.plot(positions, cut[:, 0], color=SERIES[1], lw=1.2, ls="dashdot", label="to the right")
        axes.axhline(0.0, color=GREY, lw=0.6)
        name_axes(axes, (words, "mm"))
    name_axes(both[0], y=("traction on the upper body", "MPa"))
    legend_below(figure, 7, fontsize=9)
    return figure


def creep_curve_figure(run: RollingPatchRun) -> Figure:
    """Draw forces and spin moment over the creepage of the curve by all theories."""
    spin = run.case.curve == "spin"
    creepage = CREEPAGE_OF[run.case.curve]
    scale = np.array([1.0 if spin else 100.0, 1.0])
    limit = run.contact.friction.limits[0][0] * run.contact.force / 1e3
    least = {"kN": ROUND_OFF * limit, "Nm": ROUND_OFF * limit * run.semi_axes[0]}
    every = [point for points in run.curve.values() for point in points]
    drawn = [force for force in FORCES if max(abs(force.value(point)) for point in every) > least[force.unit]]
    width = max(3.7 * len(drawn), 6.5)
    figure, (row,) = panels(width, 3.9, 1, len(drawn), run.case.units)
    for axes, force in zip(row, drawn, strict=True):
        both = (creepage, force)
        curves = {theory: scale * [numbers(both, point) for point in points] for theory, points in run.curve.items()}
        here = scale * numbers(both, run.state)
        for theory, line in curves.items():
            colour, style = STYLES[theory]
            axes.plot(*line.T, color=colour, ls=style, lw=1.3, label=TITLES[theory])
        axes.plot(*here, "D", color=PURPLE, ms=6.0, label="working point", zorder=5)
        axes.axhline(0.0, color=GREY, lw=0.6)
        low, high = axes.get_ylim()
        # linear theory goes on beyond the limit of friction, and its moment beyond the others'
        others = [np.abs(line[:, 1]).max() for theory, line in curves.items() if theory != "linear"]
        top = MAX_DRAWN_FORCE * (max(others, default=0.0) if force is SPIN_MOMENT else limit) or max(-low, high)
        axes.set_ylim(max(low, -top), min(high, top))
        for level in () if force is SPIN_MOMENT else (-limit, limit):
            if low < level < high:
                axes.axhline(level, color=GREY, lw=0.8, ls=(0, (10, 4)), label="limit of friction")
        name_axes(axes, (creepage.label, creepage.unit if spin else "%"), (force.label, force.unit))
    legend_below(figure, 7 if width > WIDE_IN else 4, fontsize=9)
    return figure


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
    for name, values in _fields(run).items():
        if values.ndim == 2:
            cells[name] = values[loaded]
            continue
        quantity, unit = next(
            (name.removesuffix(unit), unit) for unit in ("_MPa", "_m_s", "_mm") if name.endswith(unit)
        )
        cells |= {f"{quantity}_{word}{unit}": values[loaded][:, axis] for axis, word in ((1, "ahead"), (0, "right"))}
    return ResultTable(cells).in_units(run.case.units).csv(DIGITS)


def _files(run: RollingPatchRun) -> dict[str, Writer]:
    files: dict[str, Writer] = {CELLS: text_writer(_cells_table(run)), PATCH_FILE: partial(_write_patch, run)}
    if run.curve:
        points = [point for points in run.curve.values() for point in points]
        files[CURVE_TABLE] = text_writer(columns(BY_THEORY, points, run.case.units).csv(DIGITS))
    return files
