"""Pictures of the contact geometry: contact locus, rolling radius difference, conicity."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.rigid.rigid_run import ConicityRun, GeometryRun
from flangeway.railway.rigid.rigid_locus import ContactLocus, SideLocus
from flangeway.railway.track.placements import SIDES, Side
from flangeway.report.figures.drawing import GREY, INK, SIDE_COLOURS, Room, figure_with_room
from flangeway.report.profile.profile_figures import sequence_colours
from flangeway.types import Floats

STYLES: dict[Side, str] = {"left": "--", "right": "-"}
LIFT_MM = 12.0  # distance at which the wheels are drawn above the rails, so that lines join the points of contact

LATERAL = "lateral displacement to the right in mm"
_ROOM = Room(left=0.8, bottom=0.6, top=0.55, across=0.9, between=0.6)


def _panels(title: str, width_in: float, height_in: float, rows: int, columns: int, *, sharex: bool = False) -> Any:
    """Figure with a title, and its axes (rows, columns) with a grid."""
    figure, axes = figure_with_room(width_in, height_in, _ROOM, rows, columns, sharex=sharex)
    figure.suptitle(title, fontsize=10)
    for each in axes.flat:
        each.grid(color="#dddddd", lw=0.5)
    return figure, axes


def _legend(*axes: Axes) -> None:
    for each in axes:
        each.legend(frameon=False, fontsize=8)


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
    figure, (pairs, curves) = _panels(f"Contact locus: {run.summary['title']}", 9.0, 7.0, 2, 2)
    whole = np.abs(run.locus.lateral_mm - np.rint(run.locus.lateral_mm)) < 0.5 * run.case.step_mm
    _, first = np.unique(np.rint(run.locus.lateral_mm[whole]), return_index=True)
    shown = run.locus.part(np.flatnonzero(whole)[first])
    for axes, side in zip(pairs, SIDES, strict=True):
        axes.grid(visible=False)
        _draw_pairs(axes, run, shown, side)
    curves[0].plot(run.locus.lateral_mm, run.locus.rolling_radius_difference_mm, color=INK, lw=1.3)
    _draw_sides(curves[1], run, lambda at: np.degrees(at.contact_angles_rad[:, 0]))
    for axes, name in zip(curves, ("rolling radius, right less left, in mm", "contact angle in degrees"), strict=True):
        axes.set(xlabel=LATERAL, ylabel=name)
    _legend(curves[1])
    return figure


def _draw_pairs(axes: Axes, run: GeometryRun, shown: ContactLocus, side: Side) -> None:
    """Draw a wheel above its rail, in the middle of the track, and lines between points of contact each millimetre."""
    curves, sign = run.geometry.side(side), (-1.0 if side == "left" else 1.0)
    wheel = curves.wheel.at(np.linspace(0.0, curves.wheel.length, 1500))
    rail = curves.rail.at(np.linspace(0.0, curves.rail.length, 1500))
    height = run.geometry.reference_height_mm + LIFT_MM
    axes.plot(sign * rail.x, rail.y, color=INK, lw=1.2)
    axes.plot(sign * wheel.x, wheel.y + height, color=INK, lw=1.2)
    at = shown.side(side)
    on_wheel = curves.wheel_frame.points(at.wheel_points_mm[:, 0])
    on_rail = curves.rail_frame.points(at.rail_points_mm[:, 0])
    for lateral, upper, lower in zip(shown.lateral_mm, on_wheel, on_rail, strict=True):
        central = round(float(lateral)) % 5 == 0
        axes.plot(
            [sign * upper[0], sign * lower[0]],
            [upper[1] + height, lower[1]],
            color=SIDE_COLOURS[side] if central else GREY,
            lw=1.2 if central else 0.5,
        )
        if central:
            axes.annotate(
                f"{round(float(lateral))}",
                (sign * upper[0], upper[1] + height), (0, 4), textcoords="offset points", fontsize=7,
                ha="center", color=SIDE_COLOURS[side],
            )  # fmt: skip
    low, high = np.sort(sign * rail.x[[0, -1]])
    axes.set(xlim=(low - 12.0, high + 12.0), ylim=(-32.0, LIFT_MM + 14.0))
    axes.set_aspect("equal", adjustable="box")
    axes.set_title(f"{side}: contact points at each millimetre", fontsize=9)
    axes.set(xlabel="x in mm", ylabel=f"y in mm, wheel raised by {LIFT_MM:g} mm")


def conicity_figure(run: GeometryRun | ConicityRun) -> Figure:
    """Draw the equivalent conicity over the amplitude by both methods."""
    figure, ((axes,),) = _panels(run.summary["title"], 6.4, 4.4, 1, 1)
    found = run.conicities
    axes.plot(found.amplitudes_mm, found.integration, color=INK, lw=1.5, label="integration of the kinematic motion")
    axes.plot(found.amplitudes_mm, found.regression, "--", color=GREY, lw=1.2, label="linear regression")
    axes.set_ylim(bottom=0.0)
    axes.set(xlabel="amplitude in mm", ylabel="equivalent conicity")
    if len(found.amplitudes_mm):
        _legend(axes)
    else:
        axes.text(0.5, 0.5, "\n".join(run.summary["notices"]), transform=axes.transAxes, ha="center", wrap=True)
    return figure


def pairs_figure(runs: Sequence[GeometryRun]) -> Figure:
    """Draw rolling radius difference and equivalent conicity of several pairs of profiles over each other."""
    figure, ((left, right),) = _panels("Pairs of profiles", 10.0, 5.0, 1, 2)
    rails = {run.case.rail for run in runs}
    for run, colour in zip(runs, sequence_colours(len(runs)), strict=True):
        names = [run.case.wheel, *([run.case.rail] if len(rails) > 1 else [])]
        label = " on ".join(Path(name).name for name in names)
        left.plot(run.locus.lateral_mm, run.locus.rolling_radius_difference_mm, color=colour, lw=1.2, label=label)
        right.plot(run.conicities.amplitudes_mm, run.conicities.integration, color=colour, lw=1.2)
    left.set(xlabel=LATERAL, ylabel="rolling radius, right less left, in mm")
    right.set(xlabel="amplitude in mm", ylabel="equivalent conicity")
    right.set_ylim(bottom=0.0)
    left.legend(frameon=False, fontsize=8)
    return figure
