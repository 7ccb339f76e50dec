"""What a table of creep forces has, for the terminal and the report, with a picture of forces over creepages."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.quantities import Quantities, Quantity, measured
from flangeway.report.figures.drawing import PAGE_IN, name_axes, panels, sequence_colours
from flangeway.report.page.html_page import inputs_tables
from flangeway.report.page.record import Again, Picture, Report, SummaryTable, table_of
from flangeway.system.output_folder import Writer
from flangeway.tables import CreepTable, TableRequest
from flangeway.tables.creep_table import AXES, SATURATED, within_cone
from flangeway.tables.table_outputs import FORCES, PATCHES, README, TABLE
from flangeway.units import Units

FRICTION, MAX_PERCENT, MAX_CURVES = 0.3, 1.0, 5
"""Coefficient of friction, creepage at the end and number of lateral positions in the picture."""
DRAWN = ("normal_force_N", "contact_angle_rad", "stiffness_N", "forces")
CAPTION = (
    f"Creep forces of the table relative to friction times normal force, at a coefficient of friction of {FRICTION:g}, "
    "on the most loaded patch of the right wheel at some lateral positions, against the longitudinal and the lateral "
    "creepage without spin."
)

JUMP: Quantities[Mapping[str, Any]] = (
    Quantity("side", "side", lambda jump: jump["side"]),
    Quantity("lateral", "lateral position", lambda jump: jump["lateral_mm"], "mm", ".3f"),
    Quantity("width", "within", lambda jump: jump["width_mm"], "mm", ".3f"),
)
"""Numbers of an interval in which patches jump."""


def creep_table_record(table: CreepTable, request: TableRequest, command: str, files: Mapping[str, Writer]) -> Report:
    """Return what a finished table has.

    - `command`: makes it again.
    - `files`: functions that write the table's own files, by their names.
    """
    checks, problem = table.metadata["checks"], request.case
    converged, failed = checks["within_tolerance"], checks["not_converged"]
    message = (
        f"error of {checks['claimed_error']:.2%} {'within' if converged else 'above'} the tolerance of "
        f"{checks['tolerance']:.2%}"
    )
    wheel, rail = problem.wheels.wheel_of("right"), problem.track.rail_of("right")
    jumps, units = checks["jumps"], request.case.units
    axes = [
        (name, str(len(axis)), f"{axis[0]:g}", f"{axis[-1]:g}") for name, axis in zip(AXES, table.axes, strict=True)
    ]
    return Report(
        name="creep-table",
        title="Creep forces of a wheelset",
        subtitle=f"Wheel {wheel.title} on rail {rail.title}; exact theory, for multibody programs",
        converged=converged,
        message=message,
        results=_results(table),
        summary={
            "status": {"converged": converged, "message": message},
            **table.metadata,
            "axes": {name: axis.tolist() for name, axis in zip(AXES, table.axes, strict=True)},
            "patches": _n_patches(table),
        },
        again=Again(
            command,
            files=f"The table is `{TABLE}`, its layout is in `{README}`; `{PATCHES}` and `{FORCES}` have the same.",
        ),
        units=units,
        versions=table.metadata["versions"],
        warnings=[f"{failed} of {checks['exact_solutions']} exact solutions did not converge"] if failed else [],
        notes=[f"in {len(jumps)} intervals patches jump: there forces go over from those of one position to another"]
        if jumps
        else [],
        pictures=lambda: [Picture("creep-forces.png", lambda: forces_figure(table, units), CAPTION)],
        tables=[
            SummaryTable("Positions", ("", "points", "from", "to"), tuple(axes)),
            *([table_of("Patches jump", jumps, JUMP, units=units)] if jumps else []),
        ],
        inputs=inputs_tables(request.case),
        timings_s={"total": table.metadata["seconds"]},
        files=lambda: files,
    )


def _n_patches(table: CreepTable) -> int:
    return int((table.values["normal_force_N"] > 0.0).sum())


def _results(table: CreepTable) -> SummaryTable:
    checks = table.metadata["checks"]
    rows = [
        ("positions: lateral x yaw x load", " x ".join(str(len(axis)) for axis in table.axes)),
        ("patches", str(_n_patches(table))),
        ("exact solutions", str(checks["exact_solutions"])),
        ("  not converged", str(checks["not_converged"])),
        ("intervals with a contact-point jump", str(len(checks["jumps"]))),
    ]
    rows.append(("claimed error, % of the limit of friction", _percent(checks["claimed_error"])))
    kinds = ("at random points", "between_positions"), ("where patches jump", "where_patches_jump")
    for words, kind in (*kinds, ("between creepages", "between_creepages")):
        check = checks[kind]
        rows.append((f"error {words}: points", str(check["n"])))
        for name, key in (("maximum", "max"), ("root mean square", "rms")):
            rows.append((f"  {name}, % of the limit of friction", _percent(check[key])))
    return SummaryTable("Table and its errors beside exact solutions", ("", "value"), tuple(rows))


def _percent(value: Any) -> str:
    return "–" if value is None else f"{100.0 * value:.2f}"


def forces_figure(table: CreepTable, units: Units = "metric") -> Figure:
    """Draw longitudinal and lateral force over their creepages, without spin, at some lateral positions."""
    lateral, yaw, load = table.axes
    slip, spin, creep = table.creep_axes
    size = 100.0 * SATURATED * slip[:-1] / (1.0 - slip[:-1])  # of creepages in %, over those of linear theory's limit
    figure, (both,) = panels(PAGE_IN, 3.2, 1, 2, units, sharey=True)
    chosen = np.unique(np.linspace(0, len(lateral) - 1, MAX_CURVES).round().astype(int))
    for index, colour in zip(chosen.tolist(), sequence_colours(len(chosen)), strict=True):
        right = index, len(yaw) // 2, len(load) // 2, 1
        most = *right, int(table.values["normal_force_N"][right].argmax())
        normal, angle, stiffness, forces = (table.values[name][most] for name in DRAWN)
        label = f"{measured(float(lateral[index]), 'mm', units)}, {np.rad2deg(angle):.1f}°"
        for component, axes in enumerate(both):
            shares = within_cone(slip[:-1, None] * forces[:-1, len(spin) // 2, component * (len(creep) // 2)])
            creepages = size * FRICTION * normal / stiffness[component]
            axes.plot(creepages, shares[:, component], ".-", color=colour, lw=1.4, label=label)
    for axes, word in zip(both, ("longitudinal", "lateral"), strict=True):
        name_axes(axes, (f"{word} creepage", "%"), f"{word} force relative to friction times normal force")
        axes.set_xlim(0.0, MAX_PERCENT)
    both[0].legend(title="lateral position, contact angle", fontsize=8, title_fontsize=8)
    return figure
