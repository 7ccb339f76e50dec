"""Pictures of a wheelset: its section with the pressures; in three dimensions its patches and the stresses below."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from flangeway.cases.wheelset.wheelset_quantities import AnyPatch, patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.geometry import Placement
from flangeway.quantities import measured
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.railway.wheelset.wheelset_mesh import HELD
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    HALO,
    INK,
    PURPLE,
    Style,
    box,
    colour_bar,
    equal_axes,
    name_axes,
    new_figure,
    panels,
    shade_of,
    units_of,
)
from flangeway.report.figures.fields import drawn_parts
from flangeway.report.figures.stress_picture import pressure_curves, stress_panels
from flangeway.report.spatial.patch_map import PatchMap, draw_depths, maps_figure
from flangeway.types import Floats

N_LEVELS = 13
"""Limits of colours of a stress, from 0 to its maximum."""
DEPTH_OF_WIDTH = 0.7
"""Depth of the pictures of stresses over their width."""
STEEL = "#c9ced6"
HALF_VIEW_MM = 50.0
"""Half the width and height of what is shown of each side in section."""
GAUGE_SIDE_MM = 10.0
"""By which its middle lies beside that of the rail's head."""
ORDINATE_MM, ARROW_MM = 14.0, 24.0
"""Of the maximum pressure in the section, and of forces."""
WINDOW = 2.2
"""Half width of what is shown of stresses about a plane contact, in half widths of the contact."""


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
    """Draw both sides in section with their pressures and forces."""
    highest = max((patch.max_pressure for patch in run.patches), default=1.0)
    figure, (both,) = panels(11.0, 5.9, 1, 2, run.case.units)
    for axes, side in zip(both, SIDES, strict=True):
        axes.grid(visible=False)
        bodies = _outlines(run.space, side) if run.in_space is not None else _deformed(run.plane, side)
        for points in bodies:
            axes.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.8, alpha=0.85))
        for points, normals, pressures in _pressures(run, side):
            ordinates = points - ORDINATE_MM / highest * pressures[:, None] * normals
            axes.fill(*np.vstack((points, ordinates[::-1])).T, color=PURPLE, alpha=0.55, lw=0.0)
            axes.plot(*ordinates.T, color=PURPLE, lw=0.9)
        _draw_forces(axes, [patch for patch in run.patches if patch.patch.side == side])
        equal_axes(axes, _view(bodies[0], side))
        axes.set_title(f"{side} wheel and rail".capitalize(), fontsize=10)
    track = run.problem.track
    inclination = f"rail inclination 1:{1.0 / track.rail_inclination:g}" if track.rail_inclination else "upright"
    figure.suptitle(f"{run.problem.wheelset.wheel.title} on {track.rail.title}, {inclination}", fontsize=10)
    return figure


def _outlines(result: SpatialResult, side: Side) -> tuple[Floats, Floats]:
    """Outlines of the rail with the motion of its head, and of the wheel, in the track."""
    problem, motion = result.problem, result.equilibrium.position
    wheelset, track = problem.wheelset, problem.track
    rail = track.placement(side).points(track.rail_of(side).outline.sampled(max_deviation=0.01))
    wheel = motion.placement(wheelset, side).points(wheelset.wheel_of(side).outline.sampled(max_deviation=0.01))
    *shift, roll, _ = result.head_motion(side)
    return Placement.about(tuple(rail[rail[:, 1].argmax()].tolist()), roll).points(rail) + np.array(shift), wheel


def _deformed(result: WheelsetResult, side: Side) -> list[Floats]:
    """Deformed rims of the meshes of the rail and the wheel in the track."""
    rims = []
    for name in (f"rail-{side}", f"wheel-{side}"):
        mesh = result.model.parts[name].body.space.mesh
        rim = mesh.chain(*(name for name in mesh.edge_sets if name != HELD))  # its edges have other names too
        rims.append(result.placements[name].points(mesh.points[rim] + result.displacements[name][rim]))
    return rims


def _pressures(run: WheelsetRun, side: Side) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Points (n, 2) under pressure, the rail's normals there, and the maximum pressures (n,) along the track."""
    if run.in_space is None:
        for patch in run.plane.patches:
            if patch.side == side:
                force, pressure = patch.force_on_wheel_N, patch.pressure
                normal = force / np.linalg.norm(force)
                yield pressure.points, np.broadcast_to(normal, pressure.points.shape), pressure.pressures
        return
    state, mirror = run.space.equilibrium.state.sides[side], np.array([SIDE_SIGN[side], 1.0])
    values = state.cells.pressures.max(axis=1)
    loaded = np.flatnonzero(values > 0.0)
    if len(loaded):
        part = slice(max(loaded[0] - 1, 0), loaded[-1] + 2)
        yield (state.points * mirror)[part], (state.normals * mirror)[part], values[part]


def _view(rail: Floats, side: Side) -> Floats:
    """Corners (2, 2) of what is shown of a side: about the head of its rail."""
    highest = rail[:, 1].max()
    top = rail[rail[:, 1] > highest - 15.0, 0]
    middle = np.array([(top.min() + top.max()) / 2.0 - GAUGE_SIDE_MM * SIDE_SIGN[side], highest - 5.0])
    return np.stack((middle - HALF_VIEW_MM, middle + HALF_VIEW_MM))


def _draw_forces(axes: Axes, patches: Sequence[AnyPatch]) -> None:
    """Draw the force on the wheel at each patch, with its size and the maximum pressure."""
    units, centres = units_of(axes), np.array([patch.centre for patch in patches])
    for patch, centre in zip(patches, centres, strict=True):
        force = patch.patch.force_on_wheel_N
        size = float(np.linalg.norm(force))
        end = centre + ARROW_MM * force / size
        axes.annotate("", tuple(end), tuple(centre), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.3})
        text = f"{measured(1e-3 * size, 'kN', units)}\n{measured(patch.max_pressure, 'MPa', units, '.0f')}"
        # towards the outside of the other patches
        outer = 1.0 if centre[0] >= centres[:, 0].mean() else -1.0
        ends: Style = {"ha": "left" if outer > 0.0 else "right", "path_effects": [HALO]}
        axes.text(end[0] + 1.5 * outer, end[1] + 1.0, text, fontsize=8.5, **ends)


def contact_figure(run: WheelsetRun) -> Figure:
    """Draw the von Mises stress about each contact of a plane wheelset, deformed, in true shape and scale."""
    patches = run.plane.patches
    windows = [box([np.atleast_2d(patch.pressure.centre)], WINDOW * patch.pressure.half_width) for patch in patches]
    figure, zones = stress_panels(list(drawn_parts(run.plane).values()), windows, run.case.units)
    for axes, name in zip(zones, run.patch_names, strict=True):
        axes.set_title(name, fontsize=10)
    return figure


def nodes_figure(run: WheelsetRun) -> Figure:
    """Draw the nodes' pressures of a plane wheelset (Moherdaui 2021, Figure 63), beside Hertz's."""
    named = zip(run.patch_names, run.plane.patches, strict=True)
    return pressure_curves([(name, patch.pressure, patch.hertz) for name, patch in named], run.case.units)


def patches_figure(run: WheelsetRun) -> Figure:
    """Draw the pressures of both sides from above, z ahead, with outlines and Hertz's ellipses, in one scale."""
    maps = [patch_map(run.space, side) for side in SIDES]
    figure, both = maps_figure(maps, "across the rail, from its middle", "z ahead of the axle", run.case.units)
    for axes, side, shown in zip(both, SIDES, maps, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.6, ls="-.", zorder=0)
        axes.set_title(f"{side} rail".capitalize(), fontsize=10)
        words = ("← field side", "gauge side →") if side == "left" else ("← gauge side", "field side →")
        for place, word, end in zip((0.01, 0.99), words, ("left", "right"), strict=True):
            axes.text(place, 0.99, word, transform=axes.transAxes, fontsize=7.5, va="top", color=GREY, ha=end)
        if not shown.patches:
            axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", fontsize=9)
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
