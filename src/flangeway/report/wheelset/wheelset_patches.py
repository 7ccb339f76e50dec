"""Pictures of a wheelset in three dimensions: its section with the pressures, its patches, the stresses below them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from flangeway.cases.wheelset.wheelset_quantities import patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.geometry import Placement
from flangeway.quantities import measured
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    HALO,
    INK,
    PURPLE,
    Style,
    colour_bar,
    name_axes,
    new_figure,
    panels,
    shade_of,
    units_of,
)
from flangeway.report.spatial.patch_map import PatchMap, draw_depths, draw_pressures, draw_sections
from flangeway.report.wheelset.wheelset_figure import STEEL, sides_about_sketch
from flangeway.types import Floats

N_LEVELS = 13
"""Limits of colours of a stress, from 0 to its maximum."""
DEPTH_OF_WIDTH = 0.7
"""Depth of the pictures of stresses over their width."""
HALF_VIEW_MM = 50.0
"""Half the width and height of what is shown of each side in section."""
GAUGE_SIDE_MM = 10.0
"""By which its middle lies beside that of the rail's head."""
ORDINATE_MM, ARROW_MM = 14.0, 24.0
"""Of the maximum pressure in the section, and of forces."""
MIN_WIDTH_MM = 12.0
"""Of what is shown of a rail from above."""
MAX_WIDTH_IN, MAX_HEIGHT_IN = 9.0, 8.0
"""Size of the picture of the patches without labels."""


def patch_map(result: SpatialResult, side: Side) -> PatchMap:
    """Patches of a side from above, right of the track to the right; lengths from the middle of the rail's profile."""
    state = result.equilibrium.state.sides[side]
    surfaces = state.grid.surfaces
    arcs, stations = surfaces.rail_stations.T
    at = surfaces.rail.at(arcs)
    middle = surfaces.rail_frame.inverse().points(np.stack((at.x, at.y), axis=1))[:, 0]
    patches = [(patch.ellipse, patch.hertz) for patch in result.patches if patch.side == side]
    return PatchMap(state.cells, patches, float(np.interp(0.0, middle, stations)), SIDE_SIGN[side])


def section_figure(run: WheelsetRun) -> Figure:
    """Draw both sides in section with their pressures, and the sketch of the whole between them."""
    result = run.space
    highest = max((patch.ellipse.max_pressure for patch in result.patches), default=1.0)
    bodies = {side: _outlines(result, side) for side in SIDES}
    figure, axes = sides_about_sketch(run, 5.6, [_view(bodies[side][0], side) for side in SIDES], "")
    for panel, side in zip(axes, SIDES, strict=True):
        for points in bodies[side]:
            panel.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.8, alpha=0.85))
        _draw_pressures(panel, result, side, highest)
        _draw_forces(panel, result, side)
    return figure


def _outlines(result: SpatialResult, side: Side) -> tuple[Floats, Floats]:
    """Outlines of the rail with the motion of its head, and of the wheel, in the track."""
    problem, motion = result.problem, result.equilibrium.position
    wheelset, track = problem.wheelset, problem.track
    rail = track.placement(side).points(track.rail_of(side).outline.sampled(max_deviation=0.01))
    wheel = motion.placement(wheelset, side).points(wheelset.wheel_of(side).outline.sampled(max_deviation=0.01))
    *shift, roll, _ = result.head_motion(side)
    return Placement.about(tuple(rail[rail[:, 1].argmax()].tolist()), roll).points(rail) + np.array(shift), wheel


def _view(rail: Floats, side: Side) -> Floats:
    """Corners (2, 2) of what is shown of a side: about the head of its rail."""
    highest = rail[:, 1].max()
    top = rail[rail[:, 1] > highest - 15.0, 0]
    middle = np.array([(top.min() + top.max()) / 2.0 - GAUGE_SIDE_MM * SIDE_SIGN[side], highest - 5.0])
    return np.stack((middle - HALF_VIEW_MM, middle + HALF_VIEW_MM))


def _draw_pressures(axes: Axes, result: SpatialResult, side: Side, highest: float) -> None:
    """Draw the maximum pressure of each position across the rail into the rail, along its normal."""
    state, mirror = result.equilibrium.state.sides[side], np.array([SIDE_SIGN[side], 1.0])
    points, normals, shown = state.points * mirror, state.normals * mirror, patch_map(result, side)
    for rows in shown.runs:
        values = shown.cells.pressures[rows].max(axis=1)
        loaded = np.flatnonzero(values > 0.0)
        if len(loaded):
            part = slice(max(loaded[0] - 1, 0), loaded[-1] + 2)
            on, height = points[rows][part], ORDINATE_MM / highest * values[part]
            ordinates = on - height[:, None] * normals[rows][part]
            axes.fill(*np.vstack((on, ordinates[::-1])).T, color=PURPLE, alpha=0.55, lw=0.0)
            axes.plot(*ordinates.T, color=PURPLE, lw=0.9)


def _draw_forces(axes: Axes, result: SpatialResult, side: Side) -> None:
    """Draw the force on the wheel at each patch, with its size and the maximum pressure."""
    patches, units = [patch for patch in result.patches if patch.side == side], units_of(axes)
    for patch in patches:
        force, centre = patch.force_on_wheel_N, patch.centre_mm[:2]
        size = float(np.linalg.norm(force))
        end = centre + ARROW_MM * force / size
        axes.annotate("", tuple(end), tuple(centre), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.3})
        text = f"{measured(1e-3 * size, 'kN', units)}\n{measured(patch.ellipse.max_pressure, 'MPa', units, '.0f')}"
        # towards the outside of the other patches
        outer = 1.0 if centre[0] >= np.mean([each.centre_mm[0] for each in patches]) else -1.0
        ends: Style = {"ha": "left" if outer > 0.0 else "right", "path_effects": [HALO]}
        axes.text(end[0] + 1.5 * outer, end[1] + 1.0, text, fontsize=8.5, **ends)


def patches_figure(run: WheelsetRun) -> Figure:
    """Draw the pressures of both sides from above, z ahead, with outlines and Hertz's ellipses, in one scale."""
    result = run.space
    maps = [patch_map(result, side) for side in SIDES]
    boxes = [shown.box for shown in maps]
    for box in boxes:
        box[:, 0] += np.array([-0.5, 0.5]) * max(MIN_WIDTH_MM - float(np.ptp(box[:, 0])), 0.0)
    ahead = np.array([box[:, 1] for box in boxes])
    ends, widths = (ahead[:, 0].min(), ahead[:, 1].max()), [float(np.ptp(box[:, 0])) for box in boxes]
    scale = min(MAX_WIDTH_IN / sum(widths), MAX_HEIGHT_IN / (ends[1] - ends[0]))
    figure = new_figure(scale * sum(widths) + 1.0, scale * (ends[1] - ends[0]) + 1.9, run.case.units)
    both = figure.subplots(1, 2, sharey=True, width_ratios=widths)
    highest = max(float(shown.cells.pressures.max()) for shown in maps)
    for axes, side, shown, box in zip(both, SIDES, maps, boxes, strict=True):
        drawn = draw_pressures(axes, shown, max(highest, 1.0))
        axes.set(xlim=box[:, 0], ylim=ends)
        axes.locator_params(axis="x", nbins=5)
        axes.axhline(0.0, color=GREY, lw=0.6, ls="-.", zorder=0)
        axes.set_title(f"{side} rail".capitalize(), fontsize=10)
        words = ("← field side", "gauge side →") if side == "left" else ("← gauge side", "field side →")
        for place, word, end in zip((0.01, 0.99), words, ("left", "right"), strict=True):
            axes.text(place, 0.99, word, transform=axes.transAxes, fontsize=7.5, va="top", color=GREY, ha=end)
        if not shown.patches:
            axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", fontsize=9)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="lower right", fontsize=8)
        name_axes(axes, ("across the rail, from its middle", "mm"))
    name_axes(both[0], y=("z ahead of the axle", "mm"))
    colour_bar(drawn, list(both), "contact pressure", "MPa", location="top", aspect=45)
    return figure


def pressures_figure(run: WheelsetRun) -> Figure:
    """Draw the pressure across and along the track through the maximum of each patch, beside Hertz's."""
    result = run.space
    patches = result.patches
    figure, rows = panels(10.0, 0.7 + 2.8 * max(len(patches), 1), max(len(patches), 1), 2, run.case.units, sharey="row")
    maps = {side: patch_map(result, side) for side in SIDES}
    for row, patch in zip(rows, patches, strict=False):
        shown = maps[patch.side]
        number = next(i for i, (ellipse, _) in enumerate(shown.patches) if ellipse is patch.ellipse)
        draw_sections(row[0], row[1], shown, number)
        for axes, words, way in zip(
            row, ("length along the rail's surface", "z ahead of the axle"), ("across", "along the track"), strict=True
        ):
            name_axes(axes, (words, "mm"))
            axes.set_title(f"{patch_name(patch)}: {way}".capitalize(), fontsize=10)
        name_axes(row[0], y=("pressure", "MPa"))
        row[0].legend(loc="lower center", fontsize=8)
    return figure


def lines_below(result: SpatialResult) -> list[tuple[SpatialPatch, Role]]:
    """Patches and the bodies below them whose stresses differ: rail and wheel have the same in one material."""
    ratios = {role: result.problem.material_of(role).poisson for role in ROLES}
    roles: tuple[Role, ...] = ("rail",) if len(set(ratios.values())) == 1 else ROLES[::-1]
    return [(patch, role) for patch in result.patches for role in roles]


def stresses_figure(run: WheelsetRun) -> Figure:
    """Draw the von Mises stress below each patch across and along the track, and stresses over its maximum's depth."""
    lines, units = lines_below(run.space), run.case.units
    several = len({role for _, role in lines}) > 1
    figure = new_figure(12.5, 0.7 + 3.3 * max(len(lines), 1), units)
    rows = figure.subplots(max(len(lines), 1), 3, squeeze=False)
    for row, (patch, role) in zip(rows, lines, strict=False):
        field = run.space.stress_fields[patch][role]
        highest, shown = field.max_von_mises, patch_map(run.space, patch.side)
        at = field.nearest(highest.position)
        across, values = shown.across(field.along), field.von_mises
        deepest = min(field.depths[-1], DEPTH_OF_WIDTH * float(np.ptp(across)))
        cuts = (
            (across, values[:, :, at[2]], across[at[0]], "length along the rail's surface"),
            (field.z, values[:, at[0]], field.z[at[2]], "z ahead of the axle"),
        )
        for axes, (places, cut, middle, words) in zip(row, cuts, strict=False):
            levels = np.linspace(0.0, highest.value, N_LEVELS)
            order = np.argsort(places)
            axes.contourf(places[order], field.depths, cut[:, order], levels, cmap=COLOURS, extend="max")
            axes.plot(middle, highest.position[1], "+", color="white", ms=9)
            axes.set_aspect("equal", adjustable="box")
            name_axes(axes, (words, "mm"))
        colour_bar(shade_of(values, (0.0, highest.value)), row[1], "von Mises stress", "MPa")
        draw_depths(row[2], field.column(at))
        for axes in row:
            axes.set_ylim(deepest, 0.0)
            name_axes(axes, y=("depth", "mm"))
        name = (f"{role}: {patch_name(patch)}" if several else patch_name(patch)).capitalize()
        maximum = measured(highest.value, "MPa", units, ".0f")
        titles = f"{name}: across", f"Along the track, maximum {maximum}", "Below the maximum"
        for axes, title in zip(row, titles, strict=True):
            axes.set_title(title, fontsize=10)
    if lines:
        rows[0, 2].legend(loc="lower left", fontsize=8)
    return figure
