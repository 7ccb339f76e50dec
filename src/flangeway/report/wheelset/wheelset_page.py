"""Report, files and terminal summary of a wheelset, in three dimensions or in the plane."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from flangeway.cases.wheelset.wheelset_case import AnyWheelsetRun, PlaneWheelsetRun, SpatialWheelsetRun
from flangeway.cases.wheelset.wheelset_quantities import (
    CREEP_FURTHER,
    CREEP_MAIN,
    LATERAL,
    LOAD,
    LOAD_FACTOR,
    MAX_VON_MISES,
    MESH,
    NADAL_WORDS,
    PATCH,
    PRESSURE,
    RATIO,
    REFERENCE,
    RESIDUAL,
    ROLLING,
    SHAKEDOWN,
    TRACK,
    patch_name,
)
from flangeway.mesh import PolyMesh
from flangeway.quantities import Quantity, columns, measured, present
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.supported_rail import REGIONS, RailAlongTrack
from flangeway.railway.wheelset.whole_sections import WholeSection, whole_sections
from flangeway.report.figures.display import collection, write_contacts
from flangeway.report.page.html_page import run_record
from flangeway.report.page.record import (
    Picture,
    Report,
    SummaryTable,
    fact,
    rows_of,
    table_across,
    table_of,
    with_whole,
)
from flangeway.report.patch_maps import shown_fields, strip_mesh
from flangeway.report.scenes import part_fields, wheelset_scene, write_part
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.report.wheelset.wheelset_files import (
    DIGITS,
    PARTS,
    below_table,
    cells_table,
    foot_stresses,
    friction_fields,
    write_section,
    write_stresses,
    write_surface,
)
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer
from flangeway.types import Floats
from flangeway.units import Units

# --- Pressures and friction of a wheelset on the running surfaces of its rails, in three dimensions, for the viewer.


RAISED_MM_PER_MPA = 0.01
SPACING_MM = 1.5
"""Of the surface's points away from the patches."""
ROUND_MM = 12.0
"""Length of rail that is shown ahead of the patches and behind them."""
DEEP_MM, LOWER_MM = 14.0, 5.0
"""Depth of the heads that is shown, and at least below what is in contact."""
PATCH_VIEW_MM = 40.0
"""Width of the view of a patch in mm."""
PRESSURE_FIELD = "pressure_MPa"
BELOW_MM = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0)
"""Depths at which the stress is shown."""
MISES = "von_mises_MPa"


def pressure_scene(run: SpatialWheelsetRun) -> Scene:
    """Running surfaces of both rails, raised where there is pressure, stresses below, and a view of each patch."""
    patches = run.result.patches
    views = [View(patch_name(patch), (patch.centre_mm[0], patch.centre_mm[2]), PATCH_VIEW_MM) for patch in patches]
    note = (
        "Running surfaces of the rails in the track's axes: x to the right, z ahead of the axle, y up. For the eye "
        f"they are raised where there is pressure, by {RAISED_MM_PER_MPA:g} mm for 1 MPa; y is that of the raised "
        "surface, without the rail's deflection. Pressures are means over the cells of the contact, as in the VTU "
        "files of the rails."
    )
    z = np.concatenate([state.grid.grid.along for state in run.result.equilibrium.state.sides.values()])
    ends = float(z.min()) - ROUND_MM, float(z.max()) + ROUND_MM
    if run.result.rolling:
        note += " Tractions and slip velocities are shown by their sizes."
    note += (
        " Von Mises stresses are those of the rail below each cell, along the surface's normal: the largest one of all "
        "depths, and those at some depths; the VTU files of stresses have the volume."
    )
    parts = [_part(run.result, side, ends, run.case.units) for side in SIDES]
    return Scene(
        [part for part, _ in parts],
        parts[0][1],
        views,
        notes=(note,),
        axes=("x", "z", "y"),
    )


def _part(
    result: SpatialResult, side: Side, ends: tuple[float, float], units: Units
) -> tuple[ShownPart, list[ShownField]]:
    """Running surface of a rail with its fields."""
    state = result.equilibrium.state.sides[side]
    surfaces, cells, grid = state.grid.surfaces, state.cells, state.grid.grid
    depths = surfaces.rail_points(surfaces.rail_stations[:, 1])[0][:, 1]
    lowest = min(-DEEP_MM, float(cells.points[:, 1].min()) - LOWER_MM)
    stations = surfaces.rail_stations[depths > lowest, 1]
    nodes = _with_coarse(grid.bounds, float(stations.min()), float(stations.max()))
    z = _with_coarse(grid.strip_bounds, *ends)
    shape = len(nodes) - 1, len(z) - 1
    first, row = np.searchsorted(z, grid.strip_bounds[0]), np.searchsorted(nodes, grid.bounds[0])
    window = slice(row, row + len(grid.widths)), slice(first, first + grid.n_strips)
    later = np.ones(shape)
    later[window] = 0.0
    fields, by_name = shown_fields({PRESSURE_FIELD: cells.pressures} | friction_fields(result, side, "rail"))
    fields, by_name = fields + below_fields(units), by_name | stresses_below(result, side)
    arrays = {name: np.zeros(shape) for name in by_name}
    for name, values in by_name.items():
        arrays[name][window] = values
    around = np.pad(arrays[PRESSURE_FIELD], 1)
    at_nodes = (around[1:, 1:] + around[:-1, 1:] + around[1:, :-1] + around[:-1, :-1]) / 4.0
    points, _ = surfaces.rail_points(nodes)
    heights = np.repeat(points[:, 1], len(z)) + RAISED_MM_PER_MPA * at_nodes.ravel()
    mesh = strip_mesh(SIDE_SIGN[side] * points[:, 0], z)
    # first the cells of the contact, with the numbers of the VTU file
    order = np.argsort(later.ravel(), kind="stable")
    corners = mesh.cell_points.reshape(-1, 4)[order]
    # lengths along the surface run to the gauge side: the cells of the right rail are turned over
    corners = corners if side == "left" else corners[:, [1, 0, 3, 2]]
    mesh = PolyMesh.from_cells(mesh.points, corners)
    ordered = {name: values.reshape(-1, 1)[order] for name, values in arrays.items()}
    return ShownPart(f"rail-{side}", mesh, cell_arrays=ordered, side=side, heights=heights), fields


def below_fields(units: Units) -> list[ShownField]:
    """Fields of the von Mises stress of the rail below the cells."""
    depths = [f"at a depth of {measured(depth, 'mm', units)}" for depth in BELOW_MM]
    names = [f"{MISES}:{number}" for number in range(len(depths) + 1)]
    words = ("largest at any depth", *depths)
    return [
        ShownField(name, f"von Mises stress, {word}", "MPa", "Below the patches", name, "value")
        for name, word in zip(names, words, strict=True)
    ]


def stresses_below(result: SpatialResult, side: Side) -> dict[str, Floats]:
    """Arrays of `below_fields` on the cells of a side, (n, n_z)."""
    grid = result.equilibrium.state.sides[side].grid.grid
    total = np.zeros((len(BELOW_MM) + 1, len(grid.stations), grid.n_strips))
    for patch in (patch_of_side for patch_of_side in result.patches if patch_of_side.side == side):
        field = patch.stress_fields["rail"]
        row = np.searchsorted(field.depths, BELOW_MM).clip(1, len(field.depths) - 1)
        part = (BELOW_MM - field.depths[row - 1]) / np.diff(field.depths)[row - 1]
        low, high = field.von_mises[row - 1], field.von_mises[row]
        values = np.concatenate(
            (field.von_mises.max(axis=0)[None], low + part.clip(0.0, 1.0)[:, None, None] * (high - low))
        )
        surface = RegularGridInterpolator(
            (field.along, field.z), np.moveaxis(values, 0, 2), bounds_error=False, fill_value=0.0
        )
        on_cells = surface(np.stack(np.meshgrid(*grid.middles, indexing="ij"), axis=-1))
        total = np.maximum(total, np.moveaxis(on_cells, 2, 0))
    return {field.array: values for field, values in zip(below_fields("metric"), total, strict=True)}


def _with_coarse(fine: Floats, low: float, high: float) -> Floats:
    """Fine rising values, and coarser ones in their gaps and out to two ends."""
    ends = np.unique(np.concatenate(([min(low, fine[0])], fine, [max(high, fine[-1])])))
    steps = np.ceil(np.diff(ends) / SPACING_MM - 1e-9).astype(np.int64)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], steps, strict=True)]
    return np.append(np.concatenate(parts), ends[-1])


# --- Rails along the track: picture, table and CSV file.


def rails_table(run: SpatialWheelsetRun) -> SummaryTable:
    """Return maxima of both rails, with the places of the stresses."""
    rails, units = run.result.rails, run.case.units
    quantities: list[Quantity[RailAlongTrack]] = [
        Quantity("down", "top of the rail down", lambda rail: -rail.head[:, 1].min(), "mm", ".3f"),
        Quantity("gauge", "gauge-face deflection", lambda rail: rail.gauge_outward_mm.max(), "mm", ".3f"),
    ]
    if len(next(iter(rails.values())).sleepers_mm):
        force: Callable[[RailAlongTrack], float] = lambda rail: rail.reactions[:, 1].max() / 1e3  # noqa: E731
        quantities.append(Quantity("seat", "maximum force of a sleeper", force, "kN", ".2f"))
    for region in REGIONS:
        for name, kind in (("stress along the track", "along_MPa"), ("von Mises stress", "von_mises_MPa")):
            peak, position = (partial(_peak, region, kind, part) for part in (0, 1))
            quantities.append(Quantity(kind, f"{region}: {name}", peak, "MPa", ".1f"))
            quantities.append(Quantity(f"{kind}_at", "  at", position, "mm", ".0f", ("x", "y", "z")))
    caption = "Rails along the track: maximum values"
    return table_across(caption, rails, list(rails.values()), quantities, units=units)


def _peak(region: str, kind: str, part: int, rail: RailAlongTrack) -> Any:
    """Maximum of a stress in a region, and its place."""
    return rail.stresses.peak(region, getattr(rail.stresses, kind))[part]


def rails_csv(run: SpatialWheelsetRun) -> str:
    """Return both rails along the track as a CSV file, a row for each place."""
    names = "side,z_mm,base_x_mm,base_y_mm,base_roll_rad,head_x_mm,head_y_mm,head_roll_rad,gauge_outward_mm,foot_MPa"
    rows = []
    for side, rail in run.result.rails.items():
        table = np.column_stack((rail.z_mm, rail.base, rail.head, rail.gauge_outward_mm, foot_stresses(rail)))
        rows += [(side, *row) for row in table.tolist()]
    columns = dict(zip(names.split(","), zip(*rows, strict=True), strict=True))
    return ResultTable(columns).in_units(run.case.units).csv(6)


# --- Report, files and terminal summary of a wheelset, in three dimensions or in the plane.


GIVEN = (
    *("wheelset.wheel", "track.rail", "load.axle_load_kN", "load.lateral_force_kN"),
    *("load.curve.radius_m", "load.curve.speed_km_h", "load.curve.superelevation_mm", "rolling.friction"),
    *("rolling.speed_km_h", "position.yaw_mrad"),
)
"""Inputs that the first page has in any case; a plane wheelset has the first of them."""
SHOWN = ("yaw", "t_gamma", "power")
"""Numbers of the rolling at the top of the page."""
COLLECTION, PATCHES, CELLS, BELOW = "wheelset.pvd", "patches.csv", "cells.csv", "subsurface.csv"
RAILS, CONTACT = "rails.csv", "contact.vtu"
PLANE_PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
FILES = (
    "The same numbers, for programs, are in `summary.json`; a row for each patch, for a spreadsheet, in `patches.csv`; "
    "position, gap, pressure, displacement, tractions and slip of each cell of the patches in `cells.csv`; the "
    "stresses below the patches in `subsurface.csv`; the rails along the track in `rails.csv`; pressures "
    "and gaps on the running surfaces, and stresses in the volumes below the patches, in `wheelset.pvd`, which "
    "ParaView opens with both rails and wheels; with `--whole-sections` also displacements and stresses of whole "
    "sections through the patches."
)
PLANE_FILES = (
    "The same numbers, for programs, are in `summary.json`; the fields are in `wheelset.pvd`, which ParaView opens "
    "with all four parts."
)
TRACK_AXES = {
    "position": REFERENCE,
    "space": (
        "The track's axes: x across the track to the right, y up from its plane; origin in the middle of the track at "
        "the top of the rails; roll counter-clockwise about the axle's middle. Superelevation turns them in space."
    ),
    "rail": (
        "The right rail's profile: x from the middle of its base away from the middle of the track, y up "
        "from its base, before its inclination. The left rail is its mirror image."
    ),
    "wheel": (
        "The right wheel's profile: x from the tape line away from the middle of the track, y up to the "
        "axle. The left wheel is its mirror image."
    ),
    "forces": "Of the rail on the wheel, the track's axes: a positive lateral force pushes the wheel to the right.",
    "L/V": "ratio of the lateral to the vertical force of a wheel, positive where it pushes its rail outwards",
    "contact angle": "of the plane normal to the force from the track's plane, positive towards the flange",
}
ROLLING_AXES = {
    "creepage": "and creep force: of the wheel on the rail: ahead, and along the rail's surface to the right; spin "
    "and its moment counter-clockwise seen from above",
    "T-gamma": "energy that friction dissipates per distance rolled: its power divided by the speed; N is J/m. Without "
    "and with spin: creep forces times creepages at the centre of the patch, and spin moment times spin",
}
AXES = TRACK_AXES | {
    "a, b": "longer and shorter semi-axis of the ellipse with the same second moments of pressure as Hertz's",
    "z": "along the track, ahead of the axle: x, y, z are left-handed, so that ParaView shows the VTU files "
    "as seen from ahead; with yaw, patches lie ahead of the axle or behind it",
    "angle": "from z to the longer semi-axis, positive towards the gauge side",
    "gauge-face deflection": "of the elastic rail, positive outwards, away from the middle of the track",
    "p0/k": "ratio of the maximum pressure to the shear strength k = yield strength / sqrt(3). Shakedown state of a "
    "circular patch: elastic; shakedown, elastic after the first passages; hardening, the same with kinematic "
    "hardening; yields, in each passage",
    "stresses": "tension positive; maxima are those of the whole volume below a patch",
}


def plane_record(run: PlaneWheelsetRun) -> Report:
    """Return what a run of a plane wheelset found."""
    return run_record(
        run,
        PLANE_FILES,
        GIVEN[:4],
        subtitle=f"{_what(run)}; plane strain, {run.problem.plane.thickness_mm:.4g} mm of length; {_method(run)}",
        facts=wheelset_facts(run),
        tables=[*_tables(run), table_of("Bodies", run.result.model.bodies, MESH)],
        scene=lambda: wheelset_scene(list(part_fields(run.result)), run.result.patches),
        axes=TRACK_AXES,
        pictures=lambda: _plane_pictures(run),
        files=lambda: _plane_files(run),
        **_shared(run),
    )


def wheelset_record(run: SpatialWheelsetRun) -> Report:
    """Return what a run of a wheelset in three dimensions found."""
    rolls = bool(run.result.rolling)
    return run_record(
        run,
        FILES,
        # a curve gives the lateral force
        [key for key in GIVEN if key != "load.lateral_force_kN" or run.case.load.curve is None],
        subtitle=_what(run),
        facts=spatial_facts(run),
        tables=[*_tables(run), *([rails_table(run)] if run.result.rails else [])],
        scene=lambda: pressure_scene(run),
        chapters={"Rolling": _rolling_tables(run)} if rolls else {},
        pictures=lambda: _pictures(run),
        axes=AXES | (ROLLING_AXES if rolls else {}),
        files=lambda: _files(run, {}),
        with_sections=lambda: _files(run, {role: whole_sections(run.result, role) for role in ROLES}),
        **_shared(run),
    )


def _shared(run: AnyWheelsetRun) -> dict[str, Any]:
    """What the report has of both kinds."""
    return {
        "results": results_table(run),
        "warnings": run.warnings,
        "assumptions": run.case.assumptions(run.result),
    }


def _plane_pictures(run: PlaneWheelsetRun) -> Sequence[Picture]:
    from flangeway.report.wheelset.wheelset_figures import plane_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return plane_pictures(run)


def _pictures(run: SpatialWheelsetRun) -> Sequence[Picture]:
    from flangeway.report.wheelset.wheelset_figures import wheelset_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return wheelset_pictures(run)


def _what(run: AnyWheelsetRun) -> str:
    """What was computed, in words: profiles, axle load, way and speed."""
    wheelset, track, case = run.problem.wheels, run.problem.track, run.case
    words = [f"Wheel {wheelset.wheel_of('right').title} on rail {track.rail_of('right').title}"]
    if not case.has_alike_sides:
        words.append(f"left: wheel {wheelset.wheel_of('left').title} on rail {track.rail_of('left').title}")
    words.append(f"axle load {run.problem.forces.vertical_N / 1e3:.4g} kN")
    if case.speed_m_s:
        way, curve = "straight track", case.load.curve
        if curve is not None:
            way = f"curve of {abs(curve.radius_m):.4g} m to the {'left' if curve.radius_m > 0.0 else 'right'}"
        words.append(f"{way} at {3.6 * case.speed_m_s:.4g} km/h")
    return "; ".join(words)


def _method(run: AnyWheelsetRun) -> str:
    problem = run.problem
    words = [
        f"{'linear' if problem.order_of(role) == 1 else 'quadratic'} "
        f"{'finite' if problem.method_of(role) == 'fem' else 'virtual'} elements"
        for role in ROLES
    ]
    elements = words[0] if words[0] == words[1] else f"{words[0]} in the wheels, {words[1]} in the rails"
    return f"{elements}, the {problem.primary[0]}s are the primary surface"


def wheelset_facts(run: AnyWheelsetRun) -> list[tuple[str, str]]:
    """Return the most important numbers with units, and what they are."""
    units = run.case.units
    wheels = [wheel for wheel in run.wheels if wheel.lateral_over_vertical is not None]
    facts = [fact(RATIO, wheel, units, f"{wheel.side} wheel") for wheel in wheels]
    facts += [(wheel.nadal_words, f"Nadal's criterion, {wheel.side} wheel") for wheel in wheels if wheel.nadal_words]
    facts.append(fact(LATERAL, run.result, units))
    return facts + [
        fact(PRESSURE, patch, units, name) for patch, name in zip(run.patches, run.patch_names, strict=True)
    ]


def spatial_facts(run: SpatialWheelsetRun) -> list[tuple[str, str]]:
    """Return the most important numbers of a wheelset in three dimensions, with those of its steel and its rolling."""
    units, facts = run.case.units, wheelset_facts(run)
    for patch in sorted(run.result.patches, key=lambda patch: -patch.max_pressure)[:1]:
        name = patch_name(patch)
        if LOAD_FACTOR.value(patch) is not None:
            facts.append((f"{LOAD_FACTOR.texts(patch)[0]}: {SHAKEDOWN.value(patch)}", f"p0/k and shakedown, {name}"))
        facts.append(fact(MAX_VON_MISES, patch, units, name))
    rolling = present(ROLLING, run.result) if run.result.rolling else []
    return facts + [fact(quantity, run.result, units) for quantity in rolling if quantity.key in SHOWN]


def _of_wheels(quantities: Sequence[Quantity[Any]], run: AnyWheelsetRun) -> dict[str, dict[str, str]]:
    """Texts of numbers of the wheels by names and sides."""
    units = run.case.units
    return {
        quantity.labels(units)[0]: {
            wheel.side: quantity.texts(wheel, units)[0] for wheel in run.wheels if quantity.value(wheel) is not None
        }
        for quantity in quantities
    }


def results_table(run: AnyWheelsetRun) -> SummaryTable:
    """Position, L/V of the wheels and patches, one column a patch; what is of a side is in its first column."""
    units, shown = run.case.units, run.shown
    whole = dict(rows_of(shown.position, run.result, units))
    table = table_across("Results", run.patch_names, run.patches, shown.patches, units=units)
    return with_whole(table, whole, [patch.side for patch in run.patches], _of_wheels(shown.wheels, run))


def _tables(run: AnyWheelsetRun) -> list[SummaryTable]:
    """Further numbers."""
    units, result, shown = run.case.units, run.result, run.shown
    rows = rows_of(shown.further_position, result, units) + rows_of(TRACK, run.problem.track, units)
    rows += rows_of(LOAD, run.problem.forces, units)
    rows += rows_of(RESIDUAL, result.equilibrium.residuals)
    tables = [
        table_across("Patches", run.patch_names, run.patches, shown.further_patches, units=units),
        SummaryTable("Track, position, load and equilibrium", ("", "value"), tuple(rows)),
        table_across("Wheels and rails", SIDES, run.wheels, run.wheel_quantities, units=units),
    ]
    return tables if run.patches else tables[1:]


def _rolling_tables(run: SpatialWheelsetRun) -> list[SummaryTable]:
    """Creep forces and power of the patches, and how the whole wheelset rolls."""
    units, patches = run.case.units, run.result.patches
    theory = run.result.rolling[0][1].theory
    caption = f"Rolling: creep forces by {theory}; the stresses below the patches include their tractions"
    rows = rows_of(present(ROLLING, run.result), run.result, units)
    for wheel in run.wheels:
        rows += rows_of([NADAL_WORDS], wheel, units, f"{wheel.side} wheel") if wheel.nadal_words else []
    return [
        table_across(caption, run.patch_names, patches, (*CREEP_MAIN, *CREEP_FURTHER), units=units),
        SummaryTable("Motion of the wheelset", ("", "value"), tuple(rows)),
    ]


def _files(run: SpatialWheelsetRun, sections: Mapping[Role, Mapping[Side, WholeSection]]) -> dict[str, Writer]:
    """Return functions that write surfaces and tables, by the files' names."""
    writers: dict[str, Writer] = {PATCHES: text_writer(columns(PATCH, run.result.patches, run.case.units).csv(DIGITS))}
    if run.result.rails:
        writers[RAILS] = text_writer(rails_csv(run))
    loaded = {patch.side for patch in run.result.patches}
    for side, role in PARTS:
        name = f"{role}-{side}.vtu"
        writers[name] = partial(write_surface, run.result, side, role)
        if side in sections.get(role, {}):
            writers[f"section-{name}"] = partial(write_section, sections[role][side], side, role)
        if side in loaded:
            writers[f"stresses-{name}"] = partial(write_stresses, run.result, side, role)
    writers[COLLECTION] = collection([*writers])
    writers[BELOW] = text_writer(below_table(run))
    if run.result.patches:
        writers[CELLS] = text_writer(cells_table(run))
    return writers


def _plane_files(run: PlaneWheelsetRun) -> dict[str, Writer]:
    """Return functions that write the fields, by the files' names."""
    result = run.result
    writers: dict[str, Writer] = {f"{name}.vtu": partial(write_part, result=result, name=name) for name in PLANE_PARTS}
    writers[CONTACT] = lambda path: write_contacts(
        path, result.model.system, result.equilibrium.state, {name: result.placements[name] for name in PLANE_PARTS}
    )
    return writers | {COLLECTION: collection(writers)}
