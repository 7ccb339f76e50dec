"""Pictures of a wheelset in three dimensions: its section with the pressures, its patches, the stresses below them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from flangeway.cases.wheelset.wheelset_quantities import patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.geometry import Placement
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.report.figures.drawing import (
    GREY,
    HALO,
    INK,
    Room,
    draw_title,
    equal_axes,
    figure_with_room,
    new_figure,
)
from flangeway.report.figures.plots import COLOURS
from flangeway.report.spatial.patch_map import PatchMap, draw_depths, draw_pressures, draw_sections
from flangeway.report.wheelset.wheelset_figure import STEEL, draw_sketch

ROOM = Room(left=0.72, right=0.75, bottom=0.62, top=0.68, across=0.15)
ROOM_OF_STRESSES = Room(left=0.8, bottom=0.6, top=0.4, across=0.9, between=0.75)
N_LEVELS = 13
"""Limits of colours of a stress, from 0 to its maximum."""
DEPTH_OF_WIDTH = 0.7
"""Depth of the pictures of stresses over their width."""
ROOM_OF_LINES = Room(left=0.8, bottom=0.6, top=0.35, across=0.75, between=0.75)
HALF_VIEW_MM = 50.0
"""Half the width and height of what is shown of each side in section."""
GAUGE_SIDE_MM = 10.0
"""By which its middle lies beside that of the rail's head."""
ORDINATE_MM = 14.0
"""Of the maximum pressure in the section."""
ARROW_MM = 24.0
PRESSURE = "#8b1a8b"
NARROWEST_MM = 12.0
"""Least width of what is shown of a rail from above."""
WIDEST_IN, HIGHEST_IN = 9.0, 8.0
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
    problem, motion = result.problem, result.equilibrium.position
    figure, ((left, middle, right),) = figure_with_room(13.0, 5.6, ROOM, n_columns=3, width_ratios=(1.0, 1.0, 1.0))
    highest = max((patch.ellipse.max_pressure for patch in result.patches), default=1.0)
    for axes, side in ((left, SIDES[0]), (right, SIDES[1])):
        _draw_side(axes, run, side, highest)
        draw_title(axes, f"{side} wheel and rail".capitalize())
    right.yaxis.set_label_position("right")
    right.yaxis.tick_right()
    draw_sketch(middle, problem, motion)
    track = problem.track
    inclination = f"rail inclination 1:{1.0 / track.rail_inclination:g}" if track.rail_inclination else "upright"
    draw_title(middle, f"{problem.wheelset.wheel.title}\non {track.rail.title}, {inclination}", 10.0)
    return figure


def _draw_side(axes: Axes, run: WheelsetRun, side: Side, highest: float) -> None:
    result, problem, motion = run.space, run.space.problem, run.space.equilibrium.position
    wheelset, track = problem.wheelset, problem.track
    placed = (
        (track.rail_of(side).outline, track.placement(side)),
        (wheelset.wheel_of(side).outline, motion.placement(wheelset, side)),
    )
    rail, wheel = (placement.points(outline.sampled(max_deviation=0.01)) for outline, placement in placed)
    *shift, roll, _ = result.head_motion(side)
    rail = Placement.about(tuple(rail[rail[:, 1].argmax()].tolist()), roll).points(rail)
    for points in (rail + np.array(shift), wheel):
        axes.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.8, alpha=0.85))
    state, mirror = result.equilibrium.state.sides[side], np.array([SIDE_SIGN[side], 1.0])
    points, normals, shown = state.points * mirror, state.normals * mirror, patch_map(result, side)
    for rows in shown.runs:
        values = shown.cells.pressures[rows].max(axis=1)
        loaded = np.flatnonzero(values > 0.0)
        if len(loaded):
            part = slice(max(loaded[0] - 1, 0), loaded[-1] + 2)
            on, height = points[rows][part], ORDINATE_MM / highest * values[part]
            ordinates = on - height[:, None] * normals[rows][part]
            axes.fill(*np.vstack((on, ordinates[::-1])).T, color=PRESSURE, alpha=0.55, lw=0.0)
            axes.plot(*ordinates.T, color=PRESSURE, lw=0.9)
    patches = [patch for patch in result.patches if patch.side == side]
    for patch in patches:
        force, centre = patch.force_on_wheel_N, patch.centre_mm[:2]
        size = float(np.linalg.norm(force))
        end = centre + ARROW_MM * force / size
        axes.annotate(
            "", (end[0], end[1]), (centre[0], centre[1]), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.3}
        )
        text = f"{1e-3 * size:.4g} kN\n{patch.ellipse.max_pressure:.0f} MPa"
        # towards the outside of the other patches
        outer = 1.0 if centre[0] >= np.mean([each.centre_mm[0] for each in patches]) else -1.0
        axes.text(
            end[0] + 1.5 * outer, end[1] + 1.0, text, fontsize=8.5, path_effects=[HALO],
            ha="left" if outer > 0.0 else "right",
        )  # fmt: skip
    top = rail[rail[:, 1] > -15.0, 0]
    middle = np.array([(top.min() + top.max()) / 2.0 - GAUGE_SIDE_MM * SIDE_SIGN[side], -5.0])
    equal_axes(axes, np.stack((middle - HALF_VIEW_MM, middle + HALF_VIEW_MM)))


def patches_figure(run: WheelsetRun) -> Figure:
    """Draw the pressures of both sides from above, z ahead, with outlines and Hertz's ellipses, in one scale."""
    result = run.space
    maps = [patch_map(result, side) for side in SIDES]
    boxes = [shown.box for shown in maps]
    for box in boxes:
        box[:, 0] += np.array([-0.5, 0.5]) * max(NARROWEST_MM - float(np.ptp(box[:, 0])), 0.0)
    ahead = np.array([box[:, 1] for box in boxes])
    ends, widths = (ahead[:, 0].min(), ahead[:, 1].max()), [float(np.ptp(box[:, 0])) for box in boxes]
    scale = min(WIDEST_IN / sum(widths), HIGHEST_IN / (ends[1] - ends[0]))
    figure = new_figure(scale * sum(widths) + 1.0, scale * (ends[1] - ends[0]) + 1.9)
    panels = figure.subplots(1, 2, sharey=True, width_ratios=widths)
    highest = max(float(shown.cells.pressures.max()) for shown in maps)
    for axes, side, shown, box in zip(panels, SIDES, maps, boxes, strict=True):
        drawn = draw_pressures(axes, shown, max(highest, 1.0))
        axes.set(xlim=box[:, 0], ylim=ends)
        axes.locator_params(axis="x", nbins=5)
        axes.axhline(0.0, color=GREY, lw=0.6, ls="-.", zorder=0)
        gauge, field = ("gauge side →", "← field side") if side == "left" else ("← gauge side", "field side →")
        axes.set_title(f"{side} rail".capitalize(), fontsize=10)
        words = (field, gauge) if side == "left" else (gauge, field)
        for place, word in zip((0.01, 0.99), words, strict=True):
            axes.text(
                place, 0.99, word, transform=axes.transAxes, fontsize=7.5, va="top", color=GREY,
                ha="left" if place < 0.5 else "right",
            )  # fmt: skip
        if not shown.patches:
            axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", fontsize=9)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="lower right", fontsize=8)
    panels[0].set_ylabel("z ahead of the axle in mm")
    figure.supxlabel("length along the rail's surface from the middle of its profile, in mm", fontsize=10)
    figure.colorbar(drawn, ax=panels, label="contact pressure in MPa", location="top", aspect=45, shrink=0.9)
    return figure


def pressures_figure(run: WheelsetRun) -> Figure:
    """Draw the pressure across and along the track through the maximum of each patch, beside Hertz's."""
    result = run.space
    patches = result.patches
    count = max(len(patches), 1)
    figure, rows = figure_with_room(10.0, 0.5 + 2.8 * count, ROOM_OF_LINES, count, 2)
    maps = {side: patch_map(result, side) for side in SIDES}
    for (across, along), patch in zip(rows, patches, strict=False):
        shown = maps[patch.side]
        number = next(i for i, (ellipse, _) in enumerate(shown.patches) if ellipse is patch.ellipse)
        draw_sections(across, along, shown, number)
        along.sharey(across)
        across.set_title(f"{patch_name(patch)}: across".capitalize(), fontsize=10)
        along.set_title(f"{patch_name(patch)}: along the track".capitalize(), fontsize=10)
        across.set_ylabel("pressure in MPa")
        across.legend(loc="lower center", fontsize=8)
    rows[-1, 0].set_xlabel("length along the rail's surface in mm")
    rows[-1, 1].set_xlabel("z ahead of the axle in mm")
    return figure


def lines_below(result: SpatialResult) -> list[tuple[SpatialPatch, Role]]:
    """Patches and the bodies below them whose stresses differ: rail and wheel have the same in one material."""
    ratios = {role: result.problem.material_of(role).poisson for role in ROLES}
    roles: tuple[Role, ...] = ("rail",) if len(set(ratios.values())) == 1 else ROLES[::-1]
    return [(patch, role) for patch in result.patches for role in roles]


def stresses_figure(run: WheelsetRun) -> Figure:
    """Draw the von Mises stress below each patch across and along the track, and stresses over its maximum's depth."""
    lines = lines_below(run.space)
    count, several = max(len(lines), 1), len({role for _, role in lines}) > 1
    figure, rows = figure_with_room(12.5, 0.5 + 3.3 * count, ROOM_OF_STRESSES, count, 3)
    for panels, (patch, role) in zip(rows, lines, strict=False):
        field = patch.field(role, run.space.tractions_of(patch.side))
        where = patch_name(patch)
        found, shown = field.max_von_mises, patch_map(run.space, patch.side)
        row, _, strip = at = field.nearest(found.position)
        values, highest = field.von_mises, found.value
        across = shown.across(field.along)
        deepest = min(field.depths[-1], DEPTH_OF_WIDTH * float(np.ptp(across)))
        cuts = (across, values[:, :, strip], across[row]), (field.z, values[:, row], field.z[strip])
        for axes, (places, cut, middle) in zip(panels, cuts, strict=False):
            levels = np.linspace(0.0, highest, N_LEVELS)
            order = np.argsort(places)
            drawn = axes.contourf(places[order], field.depths, cut[:, order], levels, cmap=COLOURS, extend="max")
            axes.plot(middle, found.position[1], "+", color="white", ms=9)
            axes.set(ylim=(deepest, 0.0), ylabel="depth in mm")
            axes.set_aspect("equal", adjustable="box")
        figure.colorbar(drawn, ax=panels[1], label="von Mises in MPa", format="%.0f")
        draw_depths(panels[2], field.column(at))
        panels[2].set(ylim=(deepest, 0.0), ylabel="depth in mm")
        name = (f"{role}: {where}" if several else where).capitalize()
        titles = f"{name}: across", f"Along the track, maximum {highest:.0f} MPa", "Below the maximum"
        for axes, title in zip(panels, titles, strict=True):
            axes.set_title(title, fontsize=10)
    for axes, label in zip(
        rows[-1], ("length along the rail's surface in mm", "z ahead of the axle in mm", "stress in MPa"), strict=True
    ):
        axes.set_xlabel(label)
    if lines:
        rows[0, 2].legend(loc="lower left", fontsize=8)
    return figure
