"""Pictures of the contact geometry: contact locus, rolling radius difference, conicity, effect of the flange root."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.rigid.conicities import ConicityRun
from flangeway.cases.rigid.rigid_run import FlangeRootEffect, GeometryRun
from flangeway.railway.rigid.conicity import REFERENCE_AMPLITUDE_MM
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.railway.track.placements import SIDES, Side
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.types import Floats

COLOURS: dict[Side, str] = {"left": "#9a6a00", "right": "#0b5394"}
STYLES: dict[Side, str] = {"left": "--", "right": "-"}
MAX_RATIO = 0.9
LIFT_MM = 12.0
"""How far the wheels are drawn above the rails, so that lines join the points of contact."""


def locus_figure(run: GeometryRun) -> Figure:
    """Draw wheels over rails with lines between their points of contact, and the points over the lateral motion."""
    figure = new_figure(9.0, 7.0)
    grid = figure.add_gridspec(2, 2, height_ratios=(0.8, 1.0))
    whole = np.abs(run.locus.lateral_mm - np.rint(run.locus.lateral_mm)) < 0.5 * run.case.step_mm
    _, first = np.unique(np.rint(run.locus.lateral_mm[whole]), return_index=True)
    shown = run.locus.part(np.flatnonzero(whole)[first])
    for column, side in enumerate(SIDES):
        _draw_pairs(figure.add_subplot(grid[0, column]), run, shown, side)
    wheel_axes, rail_axes = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    for side in SIDES:
        at = run.locus.side(side)
        for axes, points in ((wheel_axes, at.wheel_points_mm), (rail_axes, at.rail_points_mm)):
            x, y = _with_gaps(run.locus.lateral_mm, points[:, 0, 0])
            axes.plot(x, y, STYLES[side], color=COLOURS[side], lw=1.4, label=side)
    for axes, name in ((wheel_axes, "wheel, from the tape line"), (rail_axes, "rail, from its middle")):
        axes.set_xlabel("lateral motion to the right in mm")
        axes.set_ylabel(f"point on the {name}, in mm")
        axes.grid(color="#dddddd", lw=0.5)
        axes.legend(frameon=False, fontsize=8)
    figure.suptitle(f"Contact locus: {run.summary['title']}", fontsize=10)
    return figure


def _draw_pairs(axes: Axes, run: GeometryRun, shown: ContactLocus, side: Side) -> None:
    """Draw a wheel above its rail, in the middle of the track, and lines between points of contact each millimetre."""
    curves, sign = run.wheelset.side(side), (-1.0 if side == "left" else 1.0)
    wheel = curves.wheel.at(np.linspace(0.0, curves.wheel.length, 1500))
    rail = curves.rail.at(np.linspace(0.0, curves.rail.length, 1500))
    height = run.wheelset.reference_height_mm + LIFT_MM
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
            color=COLOURS[side] if central else GREY,
            lw=1.2 if central else 0.5,
        )
        if central:
            axes.annotate(
                f"{round(float(lateral))}",
                (sign * upper[0], upper[1] + height), (0, 4), textcoords="offset points", fontsize=7,
                ha="center", color=COLOURS[side],
            )  # fmt: skip
    low, high = np.sort(sign * rail.x[[0, -1]])
    axes.set_xlim(low - 12.0, high + 12.0)
    axes.set_ylim(-32.0, LIFT_MM + 14.0)
    axes.set_aspect("equal", adjustable="box")
    axes.set_title(f"{side}: points that meet at each millimetre", fontsize=9)
    axes.set_xlabel("x in mm")
    axes.set_ylabel(f"y in mm; wheel lifted by {LIFT_MM:g}")


def _with_gaps(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the line with a gap at each jump."""
    steps = np.abs(np.diff(y))
    places = np.flatnonzero(steps > np.maximum(0.5, 25.0 * np.median(steps))) + 1
    return np.insert(x, places, np.nan), np.insert(y, places, np.nan)


def rolling_figure(run: GeometryRun) -> Figure:
    """Draw rolling radius difference, contact angles, roll and the next gap over the lateral motion."""
    figure = new_figure(8.4, 6.6)
    (top, right), (angles, gaps) = figure.subplots(2, 2, sharex=True)
    lateral = run.locus.lateral_mm
    top.plot(lateral, run.locus.rolling_radius_difference_mm, color=INK, lw=1.3)
    top.set_ylabel("rolling radius, right less left, in mm")
    right.plot(lateral, 1e3 * run.locus.roll_rad, color=INK, lw=1.3)
    right.set_ylabel("roll in mrad")
    for side in SIDES:
        at = run.locus.side(side)
        x, y = _with_gaps(lateral, np.degrees(at.contact_angles_rad[:, 0]))
        angles.plot(x, y, STYLES[side], color=COLOURS[side], lw=1.3, label=side)
        finite = np.where(np.isfinite(at.gaps_mm[:, 1]), at.gaps_mm[:, 1], np.nan)
        gaps.plot(lateral, finite, STYLES[side], color=COLOURS[side], lw=1.3, label=side)
    angles.set_ylabel("contact angle in degrees")
    gaps.set_ylabel("gap at the next place that may touch, in mm")
    for axes in (top, right, angles, gaps):
        axes.grid(color="#dddddd", lw=0.5)
    for axes in (angles, gaps):
        axes.set_xlabel("lateral motion to the right in mm")
        axes.legend(frameon=False, fontsize=8)
    figure.suptitle(f"Contact geometry: {run.summary['title']}", fontsize=10)
    return figure


def conicity_figure(run: GeometryRun | ConicityRun) -> Figure:
    """Draw the equivalent conicity over the amplitude by both methods."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    found = run.conicities
    axes.plot(found.amplitudes_mm, found.integration, color=INK, lw=1.5, label="integration of the wave motion")
    axes.plot(found.amplitudes_mm, found.regression, "--", color=GREY, lw=1.2, label="linear regression")
    at_3 = found.at_reference()
    if at_3 is not None:
        axes.plot(REFERENCE_AMPLITUDE_MM, at_3["integration"], "o", mfc="white", mec=INK)
        axes.annotate(
            f"{at_3['integration']:.3f} at {REFERENCE_AMPLITUDE_MM:g} mm",
            (REFERENCE_AMPLITUDE_MM, at_3["integration"]), (8, 10), textcoords="offset points", fontsize=9,
        )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("amplitude in mm")
    axes.set_ylabel("equivalent conicity")
    axes.grid(color="#dddddd", lw=0.5)
    if len(found.amplitudes_mm):
        axes.legend(frameon=False, fontsize=8)
    else:
        axes.text(0.5, 0.5, "\n".join(run.summary["notices"]), transform=axes.transAxes, ha="center", wrap=True)
    axes.set_title(run.summary["title"], fontsize=9)
    return figure


def flange_root_figure(effect: FlangeRootEffect) -> Figure:
    """Draw the lateral displacement in equilibrium over the radii of the flange root, and over the lateral force."""
    figure = new_figure(9.0, 4.2)
    left, right = figure.subplots(1, 2)
    left.plot(effect.narrow_mm, effect.lateral_narrow_mm, "s--", color=GREY, label="narrow arc, beside the flange")
    left.plot(effect.wide_mm, effect.lateral_wide_mm, "o-", color=INK, label="wide arc, beside the tread")
    left.set_xlabel("radius of the flange root's arc in mm")
    left.set_ylabel("lateral motion in balance, in mm")
    left.legend(frameon=False, fontsize=8)
    shades = np.linspace(0.0, 0.75, len(effect.narrow_mm))
    for radius, ratio, lateral, shade in zip(effect.narrow_mm, effect.ratios, effect.laterals_mm, shades, strict=True):
        # as far as the flange holds
        shown = np.arange(len(ratio)) < int(np.argmax(~(ratio <= MAX_RATIO)))
        right.plot(ratio[shown], lateral[shown], color=str(shade), lw=1.2, label=f"narrow arc {radius:g} mm")
    right.set_xlabel("lateral force over weight, along and onto the track; overturning apart")
    right.set_ylabel("lateral motion in balance, in mm")
    right.legend(frameon=False, fontsize=8)
    for axes in (left, right):
        axes.grid(color="#dddddd", lw=0.5)
    figure.suptitle("Rigid wheelset of AAR-1B (approximate) wheels: effect of the flange root", fontsize=10)
    return figure
