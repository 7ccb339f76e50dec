"""Pictures, record and files of ``flangeway geometry``."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.rigid_run import (
    CONICITY_QUANTITIES,
    CONTACT_QUANTITIES,
    POSITION_QUANTITIES,
    ConicityRun,
    GeometryRun,
)
from flangeway.quantities import Quantities, Quantity, columns, measured, of_part
from flangeway.railway.profiles.named import name_of
from flangeway.railway.rigid.rigid_geometry import ContactJump, ContactLocus, SideLocus
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    PAGE_IN,
    SIDE_COLOURS,
    Style,
    name_axes,
    panels,
    sequence_colours,
    units_of,
)
from flangeway.report.page.html_page import input_rows
from flangeway.report.page.record import (
    Again,
    Picture,
    Report,
    SummaryTable,
    rows_of,
    table_across,
    table_of,
    with_whole,
)
from flangeway.types import Floats
from flangeway.units import Units

# --- Pictures of the contact geometry: contact locus, rolling radius difference, conicity.


STYLES: dict[Side, str] = {"left": "--", "right": "-"}
LIFT_MM = 12.0  # distance at which the wheels are drawn above the rails, so that lines join the points of contact
LATERAL = ("lateral displacement to the right", "mm")
RADII = ("rolling radius, right less left", "mm")


def _draw_sides(axes: Axes, run: GeometryRun, values: Callable[[SideLocus], Floats]) -> None:
    """Draw a value of both sides over the lateral displacement, with gaps at jumps."""
    for side in SIDES:
        y = values(run.locus.side(side))
        steps = np.abs(np.diff(y))
        jumps = np.flatnonzero(steps > np.maximum(0.5, 25.0 * np.nanmedian(steps))) + 1
        x, y = np.insert(run.locus.lateral_mm, jumps, np.nan), np.insert(y, jumps, np.nan)
        axes.plot(x, y, STYLES[side], color=SIDE_COLOURS[side], lw=1.3, label=side)


def locus_figure(run: GeometryRun) -> Figure:
    """Draw wheels over rails with lines between their points of contact, and radii and angles over the displacement."""
    locus, units = run.locus, run.case.units
    figure, (pairs, curves) = panels(PAGE_IN, 4.2, 2, 2, units)
    figure.suptitle(f"Contact locus: {name_of(run.case.wheelset.wheel)} on {name_of(run.case.track.rail)}", fontsize=9)
    whole = np.abs(locus.lateral_mm - np.rint(locus.lateral_mm)) < 0.5 * run.case.scan.step_mm
    _, first = np.unique(np.rint(locus.lateral_mm[whole]), return_index=True)
    shown = locus.part(np.flatnonzero(whole)[first])
    for axes, side in zip(pairs, SIDES, strict=True):
        _draw_pairs(axes, run, shown, side)
    curves[0].plot(locus.lateral_mm, locus.rolling_radius_difference_mm, color=INK, lw=1.3)
    _draw_sides(curves[1], run, lambda at: np.degrees(at.contact_angles_rad[:, 0]))
    for axes, name in zip(curves, (RADII, ("contact angle", "deg")), strict=True):
        name_axes(axes, LATERAL, name)
    curves[1].legend(frameon=False, fontsize=8)
    return figure


def _draw_pairs(axes: Axes, run: GeometryRun, shown: ContactLocus, side: Side) -> None:
    """Draw a wheel above its rail, in the middle of the track, and lines between points of contact each millimetre."""
    axes.grid(visible=False)
    curves, sign = run.geometry.side(side), SIDE_SIGN[side]
    wheel = curves.wheel.at(np.linspace(0.0, curves.wheel.length, 1500))
    rail = curves.rail.at(np.linspace(0.0, curves.rail.length, 1500))
    height = run.geometry.reference_height_mm + LIFT_MM
    axes.plot(sign * rail.x, rail.y, color=INK, lw=1.2)
    axes.plot(sign * wheel.x, wheel.y + height, color=INK, lw=1.2)
    at = shown.side(side)
    on_wheel = curves.wheel_frame.points(at.wheel_points_mm[:, 0])
    on_rail = curves.rail_frame.points(at.rail_points_mm[:, 0])
    for lateral, upper, lower in zip(np.rint(shown.lateral_mm), on_wheel, on_rail, strict=True):
        central, top = lateral % 5 == 0, (sign * upper[0], upper[1] + height)
        colour, width = (SIDE_COLOURS[side], 1.2) if central else (GREY, 0.5)
        axes.plot([top[0], sign * lower[0]], [top[1], lower[1]], color=colour, lw=width)
        if central:
            style: Style = {"xytext": (0, 4), "textcoords": "offset points", "ha": "center"}
            text = measured(lateral, "mm", units_of(axes), ".0f").partition(" ")[0]
            axes.annotate(text, top, fontsize=8, color=colour, **style)
    low, high = np.sort(sign * rail.x[[0, -1]])
    axes.set(xlim=(low - 12.0, high + 12.0), ylim=(-32.0, LIFT_MM + 14.0))
    axes.set_aspect("equal", adjustable="box")
    step, lift = (measured(length, "mm", units_of(axes)) for length in (1.0, LIFT_MM))
    axes.set_title(f"{side}: contact points, {step} of displacement apart", fontsize=9)
    name_axes(axes, ("x", "mm"), (f"y, wheel raised by {lift}", "mm"))


def conicity_figure(run: GeometryRun | ConicityRun, units: Units = "metric") -> Figure:
    """Draw the equivalent conicity over the amplitude by both methods."""
    figure, ((axes,),) = panels(6.4, 3.6, units=units)
    figure.suptitle(f"Equivalent conicity: {run.summary['case']}", fontsize=9)
    conicity, notices = run.conicities, run.summary["notices"]
    axes.plot(conicity.amplitudes_mm, conicity.integration, color=INK, lw=1.5, label="integration of the motion")
    axes.plot(conicity.amplitudes_mm, conicity.regression, "--", color=GREY, lw=1.2, label="linear regression")
    axes.set_ylim(bottom=0.0)
    name_axes(axes, ("amplitude", "mm"), "equivalent conicity")
    if len(conicity.amplitudes_mm):
        axes.legend(frameon=False, fontsize=8)
    else:
        axes.text(
            0.5,
            0.5,
            "\n".join(notices),
            transform=axes.transAxes,
            ha="center",
            wrap=True,
        )
    return figure


def pairs_figure(runs: Sequence[GeometryRun]) -> Figure:
    """Draw rolling radius difference and equivalent conicity of several pairs of profiles over each other."""
    figure, ((left, right),) = panels(PAGE_IN, 3.6, 1, 2, runs[0].case.units)
    figure.suptitle("Pairs of profiles", fontsize=9)
    rails = {name_of(run.case.track.rail) for run in runs}
    for run, colour in zip(runs, sequence_colours(len(runs)), strict=True):
        names = [name_of(run.case.wheelset.wheel), *([name_of(run.case.track.rail)] if len(rails) > 1 else [])]
        label = " on ".join(Path(name).name for name in names)
        left.plot(run.locus.lateral_mm, run.locus.rolling_radius_difference_mm, color=colour, lw=1.2, label=label)
        right.plot(run.conicities.amplitudes_mm, run.conicities.integration, color=colour, lw=1.2)
    name_axes(left, LATERAL, RADII)
    name_axes(right, ("amplitude", "mm"), "equivalent conicity")
    right.set_ylim(bottom=0.0)
    left.legend(frameon=False, fontsize=8)
    return figure


# --- Report and files of ``flangeway geometry``.


TABLE, CONICITY, SUMMARY = "table.csv", "conicity.csv", "geometry.json"
CONICITY_PICTURE = "conicity.png"
BATCH_TABLE, BATCH_SUMMARY = "geometries.csv", "geometries.json"
LOCUS_SHOWN = (
    "Contact points at each millimetre, rolling radius difference and contact angles against the lateral position"
)
CONICITY_SHOWN = "Equivalent conicity versus amplitude"
AXES = {
    "lateral, vertical": "of the axle in space, to the right and up, from the middle of the track",
    "x": "on the wheel from the tape line, on the rail from its middle, away from the middle of the track",
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards; without friction",
}
ASSUMPTIONS = (
    "Rigid wheels on rigid rails: the points of contact are those of the profiles as they are.",
    "Hertz's values are of a line contact of the rigid equilibrium's force and curvatures.",
)


_POSITION: Quantities[GeometryRun] = of_part(lambda run: run.equilibrium.position, *POSITION_QUANTITIES)
PAIR_QUANTITIES: Quantities[GeometryRun] = (
    Quantity("wheel", "wheel", lambda run: name_of(run.case.wheelset.wheel)),
    Quantity("rail", "rail", lambda run: name_of(run.case.track.rail)),
    *CONICITY_QUANTITIES,
    *_POSITION,
    Quantity("jumps", "contact jumps", lambda run: len(run.jumps), form="d"),
    Quantity("status", "status", lambda run: "converged" if run.equilibrium.status.converged else "not converged"),
)
"""Numbers of a pair of profiles."""


JUMP: Quantities[ContactJump] = (
    Quantity("side", "side", lambda jump: jump.side),
    Quantity("lateral", "lateral displacement", lambda jump: jump.motion.lateral_mm, "mm", ".3f"),
    Quantity(
        "rail_x", "x on the rail", lambda jump: [x for x, _ in jump.rail_points_mm], "mm", ".2f", ("before", "after")
    ),
)
"""Numbers of a jump of the point of contact."""


def geometry_record(run: GeometryRun, command: str) -> Report:
    """Return what was found of the contact geometry; `command` computes it again."""
    summary, position, units = run.summary, run.equilibrium.position, run.case.units
    facts = [quantity.fact(position, units) for quantity in POSITION_QUANTITIES[::3]] if position else []
    jumps = table_of("Jumps of the point of contact", run.jumps, JUMP, units=units)
    inputs = tuple(input_rows(summary["inputs"], units))
    return Report(
        **_common(summary, command, units, (SUMMARY, TABLE, CONICITY)),
        subtitle=f"Rigid wheels {name_of(run.case.wheelset.wheel)} on rigid rails {name_of(run.case.track.rail)}",
        converged=run.equilibrium.status.converged,
        message=run.equilibrium.status.message,
        facts=[*facts, *_conicity_facts(run)],
        results=_results(run),
        assumptions=ASSUMPTIONS,
        pictures=lambda: [
            Picture("contact_locus.png", lambda: locus_figure(run), f"{LOCUS_SHOWN}."),
            Picture(CONICITY_PICTURE, lambda: conicity_figure(run, units), f"{CONICITY_SHOWN}."),
        ],
        tables=[jumps] if run.jumps else [],
        axes=AXES,
        inputs=[SummaryTable("Inputs", ("", "value"), inputs, of_words=True)],
        files=lambda: {TABLE: run.table.in_units(units).to_csv, CONICITY: run.conicities.table.in_units(units).to_csv},
    )


def geometries_record(runs: Sequence[GeometryRun], command: str) -> Report:
    """Return conicity and equilibrium of several pairs of profiles side by side; `command` computes them again."""
    units = runs[0].case.units
    return Report(
        **_common(runs[0].summary, command, units, (BATCH_SUMMARY, BATCH_TABLE))
        | {
            "summary": {"pairs": [run.summary for run in runs]},
            "summary_file": BATCH_SUMMARY,
            "title": f"{len(runs)} pairs of profiles",
            "notes": list(dict.fromkeys(notice for run in runs for notice in run.summary["notices"])),
            "timings_s": {"total": sum(run.summary["timings_s"]["total"] for run in runs)},
        },
        subtitle=f"{len(runs)} pairs of rigid wheels and rails",
        converged=all(run.equilibrium.status.converged for run in runs),
        message="",
        results=table_of("Pairs of profiles", runs, [PAIR_QUANTITIES[at] for at in (0, 1, 2, 4, 7, 8)], units=units),
        assumptions=ASSUMPTIONS,
        pictures=lambda: [
            Picture(
                "geometries.png",
                lambda: pairs_figure(runs),
                "Rolling radius difference and equivalent conicity of all pairs.",
            )
        ],
        axes=AXES,
        files=lambda: {BATCH_TABLE: columns(PAIR_QUANTITIES, runs, units).to_csv},
    )


def conicity_record(run: ConicityRun, command: str, units: Units = "metric") -> Report:
    """Return what was found of a rolling radius difference from a file; `command` computes it again."""
    summary = run.summary
    middle: Quantity[ConicityRun] = Quantity(
        "centred",
        "lateral position without a difference of the radii",
        lambda of: of.summary["lateral_without_difference_mm"],
        "mm",
        ".3f",
    )
    return Report(
        **_common(summary, command, units, (SUMMARY, CONICITY)),
        subtitle=summary["inputs"]["file"],
        converged=True,
        success="computed",
        message=f"at {len(run.conicities.amplitudes_mm)} amplitudes"
        if summary["equivalent_conicity"]
        else "without a conicity at 3 mm, see the notes",
        facts=_conicity_facts(run),
        results=table_across("Conicity", ("value",), [run], (middle, *CONICITY_QUANTITIES), units=units),
        pictures=lambda: [Picture(CONICITY_PICTURE, lambda: conicity_figure(run, units), f"{CONICITY_SHOWN}.")],
        files=lambda: {CONICITY: run.conicities.table.in_units(units).to_csv},
    )


def _common(summary: dict[str, Any], command: str, units: Units, files: tuple[str, ...]) -> dict[str, Any]:
    """Return what both records have from their summaries."""
    return {
        "name": summary["case"],
        "title": summary["title"],
        "summary": summary,
        "summary_file": SUMMARY,
        "again": Again(command, files=f"Numbers for programs and spreadsheets: {', '.join(f'`{f}`' for f in files)}."),
        "units": units,
        "notes": summary["notices"],
        "timings_s": summary["timings_s"],
    }


def _conicity_facts(run: GeometryRun | ConicityRun) -> list[tuple[str, str]]:
    return [CONICITY_QUANTITIES[0].fact(run)] if run.summary["equivalent_conicity"] else []


def _results(run: GeometryRun) -> SummaryTable:
    """Position and conicity, and the points of contact, one column each."""
    units, sides = run.case.units, [contact.point.side for contact in run.contacts]
    table = table_across("Results", sides, run.contacts, CONTACT_QUANTITIES[1:], units=units)
    return with_whole(table, dict(rows_of(PAIR_QUANTITIES[2:-1], run, units)), sides)
