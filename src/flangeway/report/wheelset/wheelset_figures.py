"""Pictures of a wheelset and its patches, standing or rolling."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from flangeway.cases.wheelset.wheelset_case import AnyWheelsetRun, PlaneWheelsetRun, SpatialWheelsetRun
from flangeway.cases.wheelset.wheelset_quantities import AnyPatch, patch_name
from flangeway.geometry import Placement
from flangeway.geometry.arrays import box
from flangeway.quantities import measured
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.supported_rail import RailAlongTrack
from flangeway.railway.wheelset.wheelset_model import SUPPORT
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    HALO,
    INK,
    PAGE_IN,
    PURPLE,
    SIDE_COLOURS,
    Style,
    colour_bar,
    equal_axes,
    legend_below,
    name_axes,
    new_figure,
    panels,
    shade_of,
    units_of,
)
from flangeway.report.figures.plots import drawn_parts, pressure_curves, stress_panels
from flangeway.report.page.record import Figures, Picture
from flangeway.report.patch_figures import draw_depths, maps_figure, rolling_figure, shakedown_figure
from flangeway.report.patch_maps import ShownRolling
from flangeway.report.wheelset.wheelset_files import foot_stresses, lines_below, patch_map
from flangeway.types import Floats
from flangeway.units import Units, us_unit

# --- Pictures of a wheelset: its section with the pressures; in three dimensions its patches and the stresses below.


N_LEVELS = 13
"""Limits of colours of a stress, from 0 to its maximum."""
DEPTH_OF_WIDTH = 0.7
"""Depth of the pictures of stresses relative to their width."""
STEEL = "#c9ced6"
HALF_VIEW_MM = np.array([62.0, 50.0])
"""Half the width and height of what is shown of each side in section."""
GAUGE_SIDE_MM = 14.0
"""By which its middle lies beside that of the rail's head."""
Pressed = tuple[Floats, Floats, Floats]
"""Points (n, 2) under pressure, the rail's normals there, and the maximum pressures (n,) along the track."""
ORDINATE_MM, ARROW_MM = 14.0, 24.0
"""Of the maximum pressure in the section, and of forces."""
WINDOW = 2.2
"""Half width of what is shown of stresses about a plane contact, in half widths of the contact."""


def section_figure(run: SpatialWheelsetRun) -> Figure:
    """Draw both sides in section with their pressures and forces."""
    return _section(run, partial(_outlines, run.result), partial(_pressures, run.result))


def plane_section_figure(run: PlaneWheelsetRun) -> Figure:
    """Draw both sides of a plane wheelset, deformed, with their pressures and forces."""
    return _section(run, partial(_deformed, run.result), partial(_plane_pressures, run.result))


def _section(
    run: AnyWheelsetRun, outlines: Callable[[Side], Sequence[Floats]], pressures_of: Callable[[Side], Iterable[Pressed]]
) -> Figure:
    """Both sides: outlines of rail and wheel, and what is under pressure."""
    highest = max((patch.max_pressure for patch in run.patches), default=1.0)
    figure, (both,) = panels(PAGE_IN, 2.9, 1, 2, run.case.units)
    for axes, side in zip(both, SIDES, strict=True):
        axes.grid(visible=False)
        bodies = outlines(side)
        for points in bodies:
            axes.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.8, alpha=0.85))
        for points, normals, pressures in pressures_of(side):
            ordinates = points - ORDINATE_MM / highest * pressures[:, None] * normals
            axes.fill(*np.vstack((points, ordinates[::-1])).T, color=PURPLE, alpha=0.55, lw=0.0)
            axes.plot(*ordinates.T, color=PURPLE, lw=0.9)
        _draw_forces(axes, [patch for patch in run.patches if patch.side == side])
        equal_axes(axes, _view(bodies[0], side))
        axes.set_title(f"{side} wheel and rail".capitalize(), fontsize=9)
    track = run.problem.track
    inclination = f"rail inclination 1:{1.0 / track.inclination:g}" if track.inclination else "upright"
    figure.suptitle(
        f"{run.problem.wheels.wheel_of('right').title} on {track.rail_of('right').title}, {inclination}", fontsize=9
    )
    return figure


def _outlines(result: SpatialResult, side: Side) -> tuple[Floats, Floats]:
    """Outlines of the rail with the motion of its head, and of the wheel on the axle as it bends, in the track."""
    wheelset, track = result.problem.wheels, result.problem.track
    pose, sign = result.equilibrium.state.sides[side].pose, SIDE_SIGN[side]
    x, y = pose.middle.tolist()
    motion = WheelsetPosition(sign * x, y - wheelset.tape_radius_mm, sign * pose.whole_roll)
    rail = track.placement(side).points(track.rail_of(side).outline.sampled(max_deviation=0.01))
    wheel = motion.placement(wheelset, side).points(wheelset.wheel_of(side).outline.sampled(max_deviation=0.01))
    *shift, roll, _ = result.head_motion(side)
    return Placement.about(tuple(rail[rail[:, 1].argmax()].tolist()), roll).points(rail) + np.array(shift), wheel


def _deformed(result: WheelsetResult, side: Side) -> list[Floats]:
    """Deformed rims of the meshes of the rail and the wheel in the track."""
    rims = []
    for name in (f"rail-{side}", f"wheel-{side}"):
        mesh = result.model.parts[name].body.space.mesh
        rim = mesh.chain(*(name for name in mesh.edge_sets if name != SUPPORT))  # its edges have other names too
        rims.append(result.placements[name].points(mesh.points[rim] + result.displacements[name][rim]))
    return rims


def _plane_pressures(result: WheelsetResult, side: Side) -> Iterator[Pressed]:
    for patch in result.patches:
        if patch.side == side:
            normal = patch.force_on_wheel_N / patch.normal_force_N
            yield patch.points, np.broadcast_to(normal, patch.points.shape), patch.pressures


def _pressures(result: SpatialResult, side: Side) -> Iterator[Pressed]:
    state, mirror = result.equilibrium.state.sides[side], np.array([SIDE_SIGN[side], 1.0])
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
    units, centres = units_of(axes), np.array([patch.centre_mm[:2] for patch in patches])
    for patch, centre in zip(patches, centres, strict=True):
        force = patch.force_on_wheel_N[:2]
        size = float(np.linalg.norm(force))
        end = centre + ARROW_MM * force / size
        axes.annotate("", tuple(end), tuple(centre), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.3})
        text = f"{measured(1e-3 * size, 'kN', units, '.1f')}\n{measured(patch.max_pressure, 'MPa', units, '.0f')}"
        # towards the outside of the other patches
        outer = 1.0 if centre[0] >= centres[:, 0].mean() else -1.0
        ends: Style = {"ha": "left" if outer > 0.0 else "right", "path_effects": [HALO]}
        axes.text(end[0] + 1.5 * outer, end[1] + 1.0, text, fontsize=8.5, **ends)


def contact_figure(run: PlaneWheelsetRun) -> Figure:
    """Draw the von Mises stress about each contact of a plane wheelset, deformed, in true shape and scale."""
    patches = run.result.patches
    windows = [box([np.atleast_2d(patch.centre)], WINDOW * patch.half_width) for patch in patches]
    figure, zones = stress_panels(list(drawn_parts(run.result).values()), windows, run.case.units)
    for axes, name in zip(zones, run.patch_names, strict=True):
        axes.set_title(name, fontsize=9)
    return figure


def nodes_figure(run: PlaneWheelsetRun) -> Figure:
    """Draw the nodes' pressures of a plane wheelset (Moherdaui 2021, Figure 63), beside Hertz's."""
    named = zip(run.patch_names, run.result.patches, strict=True)
    return pressure_curves([(name, patch, patch.hertz) for name, patch in named], run.case.units)


def patches_figure(run: SpatialWheelsetRun) -> Figure:
    """Draw the pressures of a run, see `pressures_figure`."""
    return pressures_figure(run.result, run.case.units)


def pressures_figure(result: SpatialResult, units: Units = "metric") -> Figure:
    """Draw the pressures of both sides from above, z ahead, with outlines and Hertz's ellipses, in one scale."""
    maps = [patch_map(result, side) for side in SIDES]
    figure, both = maps_figure(maps, "across the rail, from its middle", "z ahead of the axle", units)
    for axes, side, shown in zip(both, SIDES, maps, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.6, ls="-.", zorder=0)
        axes.set_title(f"{side} rail".capitalize(), fontsize=9)
        words = ("← field", "gauge →") if side == "left" else ("← gauge", "field →")
        for x, word, end in zip((0.01, 0.99), words, ("left", "right"), strict=True):
            axes.text(x, 0.99, word, transform=axes.transAxes, fontsize=8, va="top", color=GREY, ha=end)
        if not shown.patches:
            axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", fontsize=9)
    return figure


def stresses_figure(run: SpatialWheelsetRun) -> Figure:
    """Draw the von Mises stress below each patch across and along the track, and stresses over its maximum's depth."""
    lines, units = lines_below(run.result), run.case.units
    several = len({role for _, role in lines}) > 1
    figure = new_figure(PAGE_IN, min(0.5 + 1.9 * max(len(lines), 1), 4.2), units)
    rows = figure.subplots(max(len(lines), 1), 3, squeeze=False)
    for row, (patch, role) in zip(rows, lines, strict=False):
        field = patch.stress_fields[role]
        highest, shown = field.max_von_mises, patch_map(run.result, patch.side)
        at = field.nearest(highest.position)
        across, values = shown.across(field.along), field.von_mises
        deepest = min(field.depths[-1], DEPTH_OF_WIDTH * float(np.ptp(across)))
        cuts = (
            (across, values[:, :, at[2]], across[at[0]], "across, along the surface"),
            (field.z, values[:, at[0]], field.z[at[2]], "z ahead of the axle"),
        )
        for axes, (positions, cut, middle, words) in zip(row, cuts, strict=False):
            levels = np.linspace(0.0, highest.value, N_LEVELS)
            order = np.argsort(positions)
            axes.contourf(positions[order], field.depths, cut[:, order], levels, cmap=COLOURS, extend="max")
            axes.plot(middle, highest.position[1], "+", color="white", ms=9)
            axes.set_aspect("equal", adjustable="box")
            name_axes(axes, (words if row[0] is rows[-1, 0] else "", "mm"))
        colour_bar(shade_of(values, (0.0, highest.value)), row[1], "von Mises", "MPa")
        draw_depths(row[2], field.column(at))
        for axes in row:
            axes.set_ylim(deepest, 0.0)
            name_axes(axes, y=("depth" if axes is row[0] else "", "mm"))
        if row[0] is not rows[-1, 0]:
            row[2].set_xlabel("")
        name = (f"{role}: {patch_name(patch)}" if several else patch_name(patch)).capitalize()
        maximum = measured(highest.value, "MPa", units, ".0f")
        titles = f"{name}: across", f"Along the track, maximum {maximum}", "Below the maximum"
        for axes, title in zip(row, titles, strict=True):
            axes.set_title(title, fontsize=9)
    legend_below(figure, 5)
    return figure


# --- The patches of a wheelset that rolls: pictures and numbers of friction.


MAPS, SHAKEDOWN = "rolling.png", "shakedown.png"
CAPTIONS = {
    MAPS: "Each patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the wheel; "
    "slip velocity; frictional power per area.",
    SHAKEDOWN: "Maximum pressure over the shear strength and traction coefficient of each patch, among the limits of "
    "a circular patch and of a line contact. Above the highest limit steel yields under each wheel.",
}


def rolling_pictures(run: SpatialWheelsetRun) -> list[Picture]:
    """Pictures of the patches that roll; none without friction."""
    result, strength, units = run.result, run.result.yield_MPa, run.case.units
    # right of the track to the right, lengths from the middle of the rail's profile
    shown = [
        ShownRolling(
            patch_name(patch), creep.cells, creep.speed, patch_map(result, patch.side).origin, SIDE_SIGN[patch.side]
        )
        for patch, creep in result.rolling
        if creep.cells is not None
    ]
    points = [(patch_name(patch), creep.used_friction, patch.max_pressure) for patch, creep in result.rolling]
    figures: Figures = {}
    if shown:
        figures[MAPS] = lambda: rolling_figure(shown, units)
    if points and strength is not None:
        figures[SHAKEDOWN] = lambda: shakedown_figure(points, strength, units)
    return [Picture(name, draw, CAPTIONS[name], chapter="Rolling") for name, draw in figures.items()]


# --- Rails along the track, and which pictures a wheelset has.


STYLES = {"left": "-", "right": "--"}  # of symmetric wheelsets both are one line


LINES: tuple[tuple[str, str, Callable[[RailAlongTrack], Floats]], ...] = (
    ("rail-top\ndeflection", "mm", lambda rail: -rail.head[:, 1]),
    ("gauge-face\ndeflection", "mm", lambda rail: rail.gauge_outward_mm),
    ("stress under\nthe foot", "MPa", foot_stresses),
)
"""What is drawn along the track, one panel each."""


def rails_figure(run: SpatialWheelsetRun) -> Figure:
    """Draw deflection, gauge face and stress under the foot of both rails along the track, and sleepers with forces."""
    rails, units = run.result.rails, run.case.units
    figure, rows = panels(PAGE_IN, 4.2, len(LINES), 1, units, sharex=True)
    for axes, (words, unit, values) in zip(rows[:, 0], LINES, strict=True):
        for side, rail in rails.items():
            style: Style = {"color": SIDE_COLOURS[side], "ls": STYLES[side], "lw": 1.5, "label": f"{side} rail"}
            axes.plot(rail.z_mm / 1e3, values(rail), **style)
        axes.axhline(0.0, color=GREY, lw=0.8)
        name_axes(axes, y=(words, unit))
    top = rows[0, 0]
    top.invert_yaxis()
    first = next(iter(rails.values()))
    kip = us_unit("kN") if units == "us" else None
    for number, z in enumerate(first.sleepers_mm):
        if abs(z) <= np.abs(first.z_mm).max():
            top.axvline(z / 1e3, color=GREY, lw=0.6, ls=":")
            seats = (rail.reactions[number, 1] / 1e3 for rail in rails.values())
            forces = " / ".join(f"{kip.of(seat):z.1f}" if kip else f"{seat:z.0f}" for seat in seats)
            words_at: Style = {"xycoords": ("data", "axes fraction"), "ha": "center"}
            top.annotate(forces, (z / 1e3, 1.02), fontsize=8, color=INK, **words_at)
    if len(first.sleepers_mm):
        words = f"forces of the sleepers on the left / right rail, {kip.name if kip else 'kN'}"
        top.set_title(words, fontsize=9, pad=16, loc="left")
    top.legend(loc="lower right", fontsize=8)
    name_axes(rows[-1, 0], ("z ahead of the axle", "m"))
    return figure


Described = tuple[str, Callable[[Any], Figure], str]
"""A picture: name of its file, what draws it, and its caption."""
PICTURES: tuple[Described, ...] = (
    (
        "wheelset.png",
        section_figure,
        "The wheelset in the section through its axle. Violet: the maximum pressure of each position across the rail, "
        "drawn into the rail along its normal. Arrows: forces on the wheels.",
    ),
    (
        "patches.png",
        patches_figure,
        "The patches from above, the running surface rolled out flat: pressure, outline, and, where the curvatures "
        "allow one, Hertz's ellipse for the same force (dashed).",
    ),
    (
        "stresses.png",
        stresses_figure,
        "The von Mises stress below each patch, across and along the track through its maximum (+), and stresses on "
        "the normal there: x along the surface across the track, y along the normal, z along the track; of a "
        "half-space under the tractions of all cells. Bodies of one material: the rail's; without friction the wheel "
        "has the same.",
    ),
)
RAILS_PICTURE: Described = (
    "rails.png",
    rails_figure,
    "The rails along the track: deflection, motion of the gauge face, and stress along the track in the middle of the "
    "foot's underside.",
)
PLANE_PICTURES: tuple[Described, ...] = (
    (
        "wheelset.png",
        plane_section_figure,
        "The wheelset in section. Violet: the contact pressure, drawn into the rail. Arrows: forces on the wheels.",
    ),
    (
        "stresses.png",
        contact_figure,
        "Von Mises stress about each contact, deformed, in one scale; stresses in web and foot of the rails are those "
        "of a slice that carries the load alone and are not valid for a rail.",
    ),
    (
        "pressure.png",
        nodes_figure,
        "Contact pressure along the surface: nodal forces divided by their areas, and Hertz's theory for the same "
        "force and the profiles' radii at the contact, where the profiles are not conforming.",
    ),
)
"""PICTURES, RAILS_PICTURE, PLANE_PICTURES: pictures of a wheelset in three dimensions, and in the plane."""


def wheelset_pictures(run: SpatialWheelsetRun) -> list[Picture]:
    """Pictures of a run: of the patches where there are some, of the rails where they bend, of friction with it."""
    rails = (RAILS_PICTURE,) if run.result.rails else ()
    return [*_pictures(run, PICTURES), *_drawn(run, rails), *rolling_pictures(run)]


def plane_pictures(run: PlaneWheelsetRun) -> list[Picture]:
    """Pictures of a run of a plane wheelset."""
    return _pictures(run, PLANE_PICTURES)


def _pictures(run: AnyWheelsetRun, described: Sequence[Described]) -> list[Picture]:
    """Pictures, the first alone where a search that found no equilibrium has no patches."""
    return _drawn(run, described if run.patches else described[:1])


def _drawn(run: AnyWheelsetRun, described: Sequence[Described]) -> list[Picture]:
    return [Picture(name, partial(draw, run), caption) for name, draw, caption in described]
