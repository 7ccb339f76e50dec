"""Pictures of a wheelset and its patches, standing or rolling, and the files of its running surfaces."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from flangeway.cases.wheelset.wheelset_case import WheelsetRun
from flangeway.cases.wheelset.wheelset_quantities import AnyPatch, patch_name
from flangeway.formats import write_vtu, write_vtu_grids
from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.quantities import measured
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.railway.wheelset.side_contact import FAR_MM, SideState, wheel_gap
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import WheelPatch
from flangeway.railway.wheelset.wheelset_model import SUPPORT
from flangeway.railway.wheelset.whole_sections import WholeSection
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
from flangeway.report.figures.plots import drawn_parts, pressure_curves, stress_panels
from flangeway.report.page.record import Figures, Picture
from flangeway.report.patch_maps import (
    PatchMap,
    ShownRolling,
    at_corners,
    cell_fields,
    draw_depths,
    maps_figure,
    rolling_figure,
    shakedown_figure,
    strip_mesh,
)
from flangeway.results import ResultTable
from flangeway.types import Bools, Floats

# --- Pictures of a wheelset: its section with the pressures; in three dimensions its patches and the stresses below.


N_LEVELS = 13
"""Limits of colours of a stress, from 0 to its maximum."""
DEPTH_OF_WIDTH = 0.7
"""Depth of the pictures of stresses relative to their width."""
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
    patches = [patch for patch in result.patches if patch.side == side]
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
        _draw_forces(axes, [patch for patch in run.patches if patch.side == side])
        equal_axes(axes, _view(bodies[0], side))
        axes.set_title(f"{side} wheel and rail".capitalize(), fontsize=10)
    track = run.problem.track
    inclination = f"rail inclination 1:{1.0 / track.inclination:g}" if track.inclination else "upright"
    figure.suptitle(
        f"{run.problem.wheels.wheel_of('right').title} on {track.rail_of('right').title}, {inclination}", fontsize=10
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


def _pressures(run: WheelsetRun, side: Side) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Points (n, 2) under pressure, the rail's normals there, and the maximum pressures (n,) along the track."""
    if run.in_space is None:
        for patch in run.plane.patches:
            if patch.side == side:
                normal = patch.force_on_wheel_N / patch.normal_force_N
                yield patch.points, np.broadcast_to(normal, patch.points.shape), patch.pressures
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
    units, centres = units_of(axes), np.array([patch.centre_mm[:2] for patch in patches])
    for patch, centre in zip(patches, centres, strict=True):
        force = patch.force_on_wheel_N[:2]
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
    windows = [box([np.atleast_2d(patch.centre)], WINDOW * patch.half_width) for patch in patches]
    figure, zones = stress_panels(list(drawn_parts(run.plane).values()), windows, run.case.units)
    for axes, name in zip(zones, run.patch_names, strict=True):
        axes.set_title(name, fontsize=10)
    return figure


def nodes_figure(run: WheelsetRun) -> Figure:
    """Draw the nodes' pressures of a plane wheelset (Moherdaui 2021, Figure 63), beside Hertz's."""
    named = zip(run.patch_names, run.plane.patches, strict=True)
    return pressure_curves([(name, patch, patch.hertz) for name, patch in named], run.case.units)


def patches_figure(run: WheelsetRun) -> Figure:
    """Draw the pressures of both sides from above, z ahead, with outlines and Hertz's ellipses, in one scale."""
    maps = [patch_map(run.space, side) for side in SIDES]
    figure, both = maps_figure(maps, "across the rail, from its middle", "z ahead of the axle", run.case.units)
    for axes, side, shown in zip(both, SIDES, maps, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.6, ls="-.", zorder=0)
        axes.set_title(f"{side} rail".capitalize(), fontsize=10)
        words = ("← field side", "gauge side →") if side == "left" else ("← gauge side", "field side →")
        for x, word, end in zip((0.01, 0.99), words, ("left", "right"), strict=True):
            axes.text(x, 0.99, word, transform=axes.transAxes, fontsize=7.5, va="top", color=GREY, ha=end)
        if not shown.patches:
            axes.text(0.5, 0.5, "no contact", transform=axes.transAxes, ha="center", fontsize=9)
    return figure


def lines_below(result: SpatialResult) -> list[tuple[WheelPatch, Role]]:
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
        field = patch.stress_fields[role]
        highest, shown = field.max_von_mises, patch_map(run.space, patch.side)
        at = field.nearest(highest.position)
        across, values = shown.across(field.along), field.von_mises
        deepest = min(field.depths[-1], DEPTH_OF_WIDTH * float(np.ptp(across)))
        cuts = (
            (across, values[:, :, at[2]], across[at[0]], "length along the rail's surface"),
            (field.z, values[:, at[0]], field.z[at[2]], "z ahead of the axle"),
        )
        for axes, (positions, cut, middle, words) in zip(row, cuts, strict=False):
            levels = np.linspace(0.0, highest.value, N_LEVELS)
            order = np.argsort(positions)
            axes.contourf(positions[order], field.depths, cut[:, order], levels, cmap=COLOURS, extend="max")
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


# --- The patches of a wheelset that rolls: pictures and numbers of friction.


MAPS, SHAKEDOWN = "rolling.png", "shakedown.png"
CAPTIONS = {
    MAPS: "Each patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the wheel; "
    "slip velocity; frictional power per area.",
    SHAKEDOWN: "Maximum pressure over the shear strength and traction coefficient of each patch, among the limits of "
    "a circular patch and of a line contact. Above the highest limit steel yields under each wheel.",
}
AXES = {
    "creepage": "and creep force: of the wheel on the rail: ahead, and along the rail's surface to the right; spin "
    "and its moment counter-clockwise seen from above",
    "T-gamma": "energy that friction dissipates per distance rolled: its power divided by the speed; N is J/m. Without "
    "and with spin: creep forces times creepages at the centre of the patch, and spin moment times spin",
}


def rolling_pictures(run: WheelsetRun) -> list[Picture]:
    """Pictures of the patches that roll; none without friction."""
    result, strength, units = run.space, run.space.yield_MPa, run.case.units
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


# --- Files of a wheelset in three dimensions: surfaces and sections for ParaView, patches and lines below as tables.


PARTS: tuple[tuple[Side, Role], ...] = tuple((side, role) for role in ROLES for side in ("left", "right"))
DIGITS = 6
DEPTH = 2.0
"""Depth of the stresses that are written relative to the shorter semi-axis: deeper, normals of a gauge corner cross."""


def write_surface(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write pressure and gap on the running surface of a rail, or where the wheel is opposite to it.

    The points are in the track's axes, z ahead of the axle: the rail's as it is bent, the wheel's in its place, both
    without the indentation at the contact. The gap is nan where no wheel is opposite. With friction also the tractions
    on this body, the slip velocity of the wheel, the frictional power per area, and the state: 0 no contact,
    1 sticks, 2 slips.
    """
    state = result.equilibrium.state.sides[side]
    nodes, z = state.grid.grid.bounds, state.grid.grid.strip_bounds
    mesh = strip_mesh(nodes, z)
    on_rail, on_wheel, met = _corners(state, nodes, z)
    positions = on_wheel if role == "wheel" else on_rail
    positions[..., 0] *= SIDE_SIGN[side]
    corners = mesh.cell_points.reshape(-1, 4)
    opposite = met.ravel()[corners].all(axis=1)
    chosen = opposite if role == "wheel" else np.ones_like(opposite)
    used, numbers = np.unique(corners[chosen], return_inverse=True)
    mesh = PolyMesh.from_cells(mesh.points[used], numbers.reshape(-1, 4))
    gaps = np.where(opposite.reshape(state.gaps.shape), state.gaps, np.nan)
    values = {"pressure_MPa": state.cells.pressures, "gap_mm": gaps} | friction_fields(result, side, role)
    arrays = {key: values[np.repeat(chosen, 4)] for key, values in at_corners(values).items()}
    write_vtu(
        path, mesh, corner_data=arrays, positions=positions.reshape(-1, 3)[used], body_id=PARTS.index((side, role))
    )


def write_section(section: WholeSection, side: Side, role: Role, path: Path) -> None:
    """Write displacement and stresses of a whole section of a body, each cell with points of its own.

    A rail is drawn unloaded, a wheel in its place: "Warp By Vector" shows them as they touch.
    """
    arrays = {
        "displacement_mm": section.displacement[section.mesh.cell_points],
        "stress_MPa": section.stresses.components,
        "von_mises_MPa": section.stresses.von_mises,
    }
    number = PARTS.index((side, role))
    write_vtu(path, section.mesh, corner_data=arrays, positions=section.positions, body_id=number)


def write_stresses(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write the stresses in the volumes below the patches of a body, of a half-space under the tractions of all cells.

    The points are in the track's axes; components of the stress are those across (x), normal to the surface (y) and
    along the track (z) at each patch.
    """
    stress_fields = [(patch, patch.stress_fields[role]) for patch in result.patches if patch.side == side]
    grids: list[Floats] = []
    stresses: list[Floats] = []
    mises: list[Floats] = []
    for patch, field in stress_fields:
        # beyond the last cells the surface has no points of its own
        low, high = patch.state.grid.grid.stations[[0, -1]]
        shown = np.ix_(field.depths <= DEPTH * patch.semi_axes[1], (field.along >= low) & (field.along <= high))
        depths, along, z = np.meshgrid(
            field.depths[shown[0].ravel()], field.along[shown[1].ravel()], field.z, indexing="ij"
        )
        grids.append(patch.points_below(role, along.ravel(), depths.ravel(), z.ravel()).reshape(*z.shape, 3))
        stresses.append(field.components[shown])
        mises.append(field.von_mises[shown])
    # seven digits are enough for stresses, and halve the files
    arrays = {
        name: [part.astype(np.float32) for part in parts]
        for name, parts in (("stress_MPa", stresses), ("von_mises_MPa", mises))
    }
    write_vtu_grids(path, grids, arrays, body_id=PARTS.index((side, role)))


def friction_fields(result: SpatialResult, side: Side, role: Role) -> dict[str, Floats]:
    """Arrays of friction on the cells of a side, (n, n_z) or vectors (n, n_z, 3); none without it."""
    state, total = result.equilibrium.state.sides[side], dict[str, Floats]()
    # directions t (across) and z of the cells in the track's axes
    axes = np.zeros((len(state.normals), 2, 3))
    axes[:, 0, :2] = np.stack((-SIDE_SIGN[side] * state.normals[:, 1], state.normals[:, 0]), axis=1)
    axes[:, 1, 2] = 1.0
    for patch, creep in result.rolling:
        if creep.cells is None:
            continue
        for name, values in cell_fields(creep.cells, creep.speed).items():
            here = patch.side == side
            whole = patch.on_side(creep, values) if here else np.zeros((*state.forces.shape, *values.shape[2:]))
            if values.ndim > 2:
                whole = np.einsum("nma,nax->nmx", whole, axes)
            total[name] = total.get(name, 0.0) + (-whole if name == "traction_MPa" and role == "rail" else whole)
    return total


def _corners(state: SideState, nodes: Floats, z: Floats) -> tuple[Floats, Floats, Bools]:
    """Points of rail and wheel at the corners of cells, each (k, m, 3), and where the wheel is opposite, (k, m)."""
    surfaces, stations = state.grid.surfaces, state.grid.grid.stations
    points, normals = surfaces.rail_points(nodes)
    moved = state.points - surfaces.rail_points(stations)[0]
    points = points + np.stack([np.interp(nodes, stations, moved[:, axis]) for axis in (0, 1)], axis=1)
    gap = wheel_gap(surfaces.wheel, state.pose.middle, state.pose.axis, points, normals, z)
    rail = np.concatenate(
        (np.repeat(points[:, None], len(z), axis=1), np.tile(z[:, None], (len(nodes), 1, 1))), axis=-1
    )
    wheel = gap.arms + np.append(state.pose.middle, 0.0)
    return rail, wheel, gap.gaps < FAR_MM


def below_table(run: WheelsetRun) -> str:
    """Return the stresses on the normals below the centres of pressure as CSV, a row for each depth."""
    rows: list[dict[str, object]] = []
    for patch, role in lines_below(run.space):
        line = patch.lines[role]
        where = {"side": patch.side, "region": patch.region, "body": role}
        columns = ResultTable({"depth_mm": line.depths, **line.stresses.by_name})
        rows += [{**where, **dict(zip(columns.columns, row, strict=True))} for row in columns.rows()]
    return ResultTable.of_rows(rows).in_units(run.case.units).csv(DIGITS)
