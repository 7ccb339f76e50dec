"""Pictures of the contact geometry: contact locus, rolling radius difference, conicity."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.rigid.rigid_run import ConicityRun, GeometryRun
from flangeway.quantities import measured
from flangeway.railway.rigid.rigid_locus import ContactLocus, SideLocus
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    SIDE_COLOURS,
    Style,
    name_axes,
    panels,
    sequence_colours,
    units_of,
)
from flangeway.types import Floats
from flangeway.units import Units, in_us_units

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
    figure, (pairs, curves) = panels(9.0, 7.0, 2, 2, units)
    figure.suptitle(f"Contact locus: {Path(run.case.wheel).name} on {Path(run.case.rail).name}", fontsize=10)
    whole = np.abs(locus.lateral_mm - np.rint(locus.lateral_mm)) < 0.5 * run.case.step_mm
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
            place: Style = {"xytext": (0, 4), "textcoords": "offset points", "ha": "center"}
            text = measured(lateral, "mm", units_of(axes), "z.0f").partition(" ")[0]
            axes.annotate(text, top, fontsize=7, color=colour, **place)
    low, high = np.sort(sign * rail.x[[0, -1]])
    axes.set(xlim=(low - 12.0, high + 12.0), ylim=(-32.0, LIFT_MM + 14.0))
    axes.set_aspect("equal", adjustable="box")
    step, lift = (measured(length, "mm", units_of(axes)) for length in (1.0, LIFT_MM))
    axes.set_title(f"{side}: contact points, {step} of displacement apart", fontsize=9)
    name_axes(axes, ("x", "mm"), (f"y, wheel raised by {lift}", "mm"))


def conicity_figure(run: GeometryRun | ConicityRun, units: Units = "metric") -> Figure:
    """Draw the equivalent conicity over the amplitude by both methods."""
    figure, ((axes,),) = panels(6.4, 4.4, units=units)
    figure.suptitle(f"Equivalent conicity: {run.summary['case']}", fontsize=10)
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
            "\n".join(map(in_us_units, notices) if units == "us" else notices),
            transform=axes.transAxes,
            ha="center",
            wrap=True,
        )
    return figure


def pairs_figure(runs: Sequence[GeometryRun]) -> Figure:
    """Draw rolling radius difference and equivalent conicity of several pairs of profiles over each other."""
    figure, ((left, right),) = panels(10.0, 5.0, 1, 2, runs[0].case.units)
    figure.suptitle("Pairs of profiles", fontsize=10)
    rails = {run.case.rail for run in runs}
    for run, colour in zip(runs, sequence_colours(len(runs)), strict=True):
        names = [run.case.wheel, *([run.case.rail] if len(rails) > 1 else [])]
        label = " on ".join(Path(name).name for name in names)
        left.plot(run.locus.lateral_mm, run.locus.rolling_radius_difference_mm, color=colour, lw=1.2, label=label)
        right.plot(run.conicities.amplitudes_mm, run.conicities.integration, color=colour, lw=1.2)
    name_axes(left, LATERAL, RADII)
    name_axes(right, ("amplitude", "mm"), "equivalent conicity")
    right.set_ylim(bottom=0.0)
    left.legend(frameon=False, fontsize=8)
    return figure
