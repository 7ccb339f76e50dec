"""Report, files and terminal summary of a wheelset, in three dimensions or in the plane."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from flangeway.cases.wheelset.wheelset_quantities import (
    APPROACH,
    CREEP_FURTHER,
    CREEP_MAIN,
    GAUGE,
    LATERAL,
    LOAD,
    LOAD_FACTOR,
    MAX_VON_MISES,
    MESH,
    MOTION,
    NADAL,
    NADAL_WORDS,
    PATCH,
    PLANE_FURTHER,
    PLANE_MAIN,
    PRESSURE,
    RATIO,
    REFERENCE,
    RESIDUAL,
    ROLLING,
    SHAKEDOWN,
    SPATIAL_FURTHER,
    SPATIAL_MAIN,
    AnyResult,
    WheelResult,
)
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.quantities import Quantity, columns, measured, present
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.whole_sections import whole_sections
from flangeway.report.figures.fields import part_fields, write_part
from flangeway.report.figures.series import collection, write_contacts
from flangeway.report.page.case_text import run_record
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import SummaryTable, fact, rows_of, table_across, table_of, with_whole
from flangeway.report.scenes import wheelset_scene
from flangeway.report.wheelset.pressure_scene import pressure_scene
from flangeway.report.wheelset.rails_along_track import rails_csv, rails_figure, rails_table
from flangeway.report.wheelset.rolling_patches import AXES as ROLLING_AXES
from flangeway.report.wheelset.rolling_patches import rolling_pictures
from flangeway.report.wheelset.running_surface_files import (
    DIGITS,
    PARTS,
    below_table,
    write_section,
    write_stresses,
    write_surface,
)
from flangeway.report.wheelset.wheelset_patches import (
    contact_figure,
    nodes_figure,
    patches_figure,
    section_figure,
    stresses_figure,
)
from flangeway.system.output_folder import Writer, text_writer

Described = tuple[str, Callable[[WheelsetRun], Figure], str]
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
        section_figure,
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
        "Contact pressure along the surface: nodal forces over their areas, and Hertz's theory for the same force "
        "and the profiles' radii at the contact, where the profiles are not conforming.",
    ),
)
"""PICTURES, RAILS_PICTURE, PLANE_PICTURES: pictures of a wheelset in three dimensions, and in the plane."""
GIVEN = (
    *("wheel", "rail", "axle_load_kN", "lateral_force_kN"),
    *("curve_radius_m", "speed_km_h", "superelevation_mm", "friction", "yaw_mrad"),
)
"""Inputs that the first page has in any case; a plane wheelset has the first of them."""
SHOWN = ("yaw", "t_gamma", "power")
"""Numbers of the rolling at the top of the page."""
COLLECTION, PATCHES, BELOW, RAILS, CONTACT = "wheelset.pvd", "patches.csv", "subsurface.csv", "rails.csv", "contact.vtu"
PLANE_PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
FILES = (
    "The same numbers, for programs, are in `summary.json`; a row for each patch, for a spreadsheet, in `patches.csv`; "
    "the stresses below the patches in `subsurface.csv`; the rails along the track in `rails.csv`; pressures "
    "and gaps on the running surfaces, displacements and stresses of whole sections through the patches, and stresses "
    "in the volumes below the patches, in "
    "`wheelset.pvd`, which ParaView opens with both rails and wheels."
)
PLANE_FILES = (
    "The same numbers, for programs, are in `summary.json`; the fields are in `wheelset.pvd`, which ParaView opens "
    "with all four parts."
)
TRACK_AXES = {
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
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards",
    "contact angle": "of the plane normal to the force from the track's plane, positive towards the flange",
}
AXES = TRACK_AXES | {
    "a, b": "longer and shorter semi-axis of the ellipse with the same second moments of pressure as Hertz's",
    "z": "along the track, ahead of the axle: x, y, z are left-handed, so that ParaView shows the VTU files "
    "as seen from ahead; with yaw, patches lie ahead of the axle or behind it",
    "angle": "from z to the longer semi-axis, positive towards the gauge side",
    "gauge-face deflection": "of the elastic rail, positive outwards, away from the middle of the track",
    "p0/k": "maximum pressure over the shear strength k = yield strength / sqrt(3). Shakedown state of a circular "
    "patch: elastic; shakedown, elastic after the first passages; hardening, the same with kinematic hardening; "
    "yields, in each passage",
    "stresses": "tension positive; maxima are those of the whole volume below a patch",
}


def wheelset_record(run: WheelsetRun) -> Record:
    """Return what a run of a wheelset found."""
    shared = {
        "facts": wheelset_facts(run),
        "results": results_table(run),
        "sentences": [REFERENCE],
        "warnings": run.warnings,
        "assumptions": run.case.assumptions(run.result),
        "tables": _tables(run),
    }
    if run.in_space is None:
        length = measured(run.problem.thickness_mm, "mm", run.case.units)
        return run_record(
            run,
            PLANE_FILES,
            GIVEN[:4],
            subtitle=f"{_what(run)}; plane strain, {length} of length; {_method(run)}",
            scene=lambda: wheelset_scene(list(part_fields(run.plane)), run.plane.patches),
            pictures=_pictures(run, PLANE_PICTURES[: None if run.patches else 1]),
            axes=TRACK_AXES,
            files=lambda: _plane_files(run),
            **shared,
        )
    rolls = bool(run.space.rolling)
    # a search that found no equilibrium has no patches
    described = [*PICTURES[: None if run.space.patches else 1], *([RAILS_PICTURE] if run.space.rails else [])]
    return run_record(
        run,
        FILES,
        # a curve gives the lateral force
        [key for key in GIVEN if key != "lateral_force_kN" or run.case.curve_radius_m is None],
        subtitle=_what(run),
        scene=lambda: pressure_scene(run),
        pictures=[*_pictures(run, described), *rolling_pictures(run)],
        chapters={"Rolling": _rolling_tables(run)} if rolls else {},
        axes=AXES | (ROLLING_AXES if rolls else {}),
        files=lambda: _files(run),
        **shared,
    )


def _pictures(run: WheelsetRun, described: Sequence[Described]) -> list[Picture]:
    return [Picture(name, partial(draw, run), caption) for name, draw, caption in described]


def _what(run: WheelsetRun) -> str:
    """What was computed, in words: profiles, axle load, way and speed."""
    wheelset, track, case = run.problem.wheelset, run.problem.track, run.case
    words = [f"Wheel {wheelset.wheel.title} on rail {track.rail.title}"]
    if not (wheelset.is_symmetric and track.is_symmetric):
        words.append(f"left: wheel {wheelset.wheel_of('left').title} on rail {track.rail_of('left').title}")
    words.append(f"axle load {measured(run.problem.load.vertical_N / 1e3, 'kN', case.units)}")
    if case.speed_km_h is not None:
        radius = case.curve_radius_m
        way = "straight track"
        if radius:
            way = f"curve of {measured(abs(radius), 'm', case.units)} to the {'left' if radius > 0.0 else 'right'}"
        words.append(f"{way} at {measured(case.speed_km_h, 'km/h', case.units)}")
    return "; ".join(words)


def _method(run: WheelsetRun) -> str:
    problem = run.problem
    settings = problem.discretisation
    words = []
    for role in ("wheel", "rail"):
        kind: Role = "wheel" if role == "wheel" else "rail"
        order = "linear" if settings.order_of(kind) == 1 else "quadratic"
        words.append(f"{order} {'finite' if settings.method_of(kind) == 'fem' else 'virtual'} elements")
    elements = words[0] if words[0] == words[1] else f"{words[0]} in the wheels, {words[1]} in the rails"
    return f"{elements}, the {problem.primary[0]}s are the primary surface"


def wheelset_facts(run: WheelsetRun) -> list[tuple[str, str]]:
    """Return the most important numbers with units, and what they are."""
    units = run.case.units
    wheels = [wheel for wheel in run.wheels if wheel.lateral_over_vertical is not None]
    facts = [fact(RATIO, wheel, units, f"{wheel.side} wheel") for wheel in wheels]
    facts += [(wheel.nadal_words, f"Nadal's criterion, {wheel.side} wheel") for wheel in wheels if wheel.nadal_words]
    facts.append(fact(LATERAL, run.result, units))
    facts += [fact(PRESSURE, patch, units, name) for patch, name in zip(run.patches, run.patch_names, strict=True)]
    names = {id(patch): name for patch, name in zip(run.patches, run.patch_names, strict=True)}
    for patch in sorted(run.spatial_patches, key=lambda patch: -patch.max_pressure)[:1]:
        name = names[id(patch)]
        if LOAD_FACTOR.value(patch) is not None:
            facts.append((f"{LOAD_FACTOR.texts(patch)[0]}: {SHAKEDOWN.value(patch)}", f"p0/k and shakedown, {name}"))
        facts.append(fact(MAX_VON_MISES, patch, units, name))
    if run.in_space is not None and run.space.rolling:
        facts += [fact(quantity, run.space, units) for quantity in present(ROLLING, run.space) if quantity.key in SHOWN]
    return facts


def _of_wheels(quantities: Sequence[Quantity[WheelResult]], run: WheelsetRun) -> dict[str, dict[str, str]]:
    """Texts of numbers of the wheels by names and sides."""
    units = run.case.units
    return {
        quantity.labels(units)[0]: {
            wheel.side: quantity.texts(wheel, units)[0] for wheel in run.wheels if quantity.value(wheel) is not None
        }
        for quantity in quantities
    }


def results_table(run: WheelsetRun) -> SummaryTable:
    """Position, L/V of the wheels and patches, one column a patch; what is of a side is in its first column."""
    units, sides = run.case.units, [patch.patch.side for patch in run.patches]
    position: Sequence[Quantity[AnyResult]] = (LATERAL, APPROACH)
    quantities: Sequence[Quantity[Any]] = PLANE_MAIN
    wheels: Sequence[Quantity[WheelResult]] = (RATIO,)
    if run.in_space is not None:
        rolls = bool(run.space.rolling)
        position, quantities = MOTION, (*SPATIAL_MAIN, *(CREEP_MAIN if rolls else ()))
        wheels = (RATIO, *(NADAL if rolls else ()), GAUGE)
    whole = dict(rows_of(position, run.result, units))
    table = table_across("Results", run.patch_names, run.patches, quantities, units=units)
    return with_whole(table, whole, sides, _of_wheels(wheels, run))


def _tables(run: WheelsetRun) -> list[SummaryTable]:
    """Further numbers."""
    units, result, in_space = run.case.units, run.result, run.in_space is not None
    further = SPATIAL_FURTHER if in_space else PLANE_FURTHER
    position = (*MOTION, APPROACH)[3 if in_space else 1 :]
    rows = rows_of(position, result, units) + rows_of(LOAD, run.problem.load, units)
    rows += rows_of(RESIDUAL, result.equilibrium.residuals)
    tables = [
        table_across("Patches", run.patch_names, run.patches, further, units=units),
        SummaryTable("Position, load and equilibrium", ("", "value"), tuple(rows)),
        table_across("Wheels and rails", SIDES, run.wheels, run.wheel_quantities, units=units),
    ]
    if not in_space:
        tables.append(table_of("Bodies", run.plane.model.bodies, MESH))
    elif run.space.rails:
        tables.append(rails_table(run))
    return tables if run.patches else tables[1:]


def _rolling_tables(run: WheelsetRun) -> list[SummaryTable]:
    """Creep forces and power of the patches, and how the whole wheelset rolls."""
    units, patches = run.case.units, run.spatial_patches
    theory = next(patch.creep.theory for patch in patches if patch.creep is not None)
    caption = f"Rolling: creep forces by {theory}; the stresses below the patches include their tractions"
    rows = rows_of(present(ROLLING, run.space), run.space, units)
    for wheel in run.wheels:
        rows += rows_of([NADAL_WORDS], wheel, units, f"{wheel.side} wheel") if wheel.nadal_words else []
    return [
        table_across(caption, run.patch_names, patches, (*CREEP_MAIN, *CREEP_FURTHER), units=units),
        SummaryTable("Motion of the wheelset", ("", "value"), tuple(rows)),
    ]


def _files(run: WheelsetRun) -> dict[str, Writer]:
    """Return functions that write surfaces and tables, by the files' names."""
    writers: dict[str, Writer] = {PATCHES: text_writer(columns(PATCH, run.spatial_patches, run.case.units).csv(DIGITS))}
    if run.space.rails:
        writers[RAILS] = text_writer(rails_csv(run))
    sections, loaded = {role: whole_sections(run.space, role) for role in ROLES}, {p.side for p in run.space.patches}
    for side, role in PARTS:
        name = f"{role}-{side}.vtu"
        writers[name] = partial(write_surface, run.space, side, role)
        if side in sections[role]:
            writers[f"section-{name}"] = partial(write_section, sections[role][side], side, role)
        if side in loaded:
            writers[f"stresses-{name}"] = partial(write_stresses, run.space, side, role)
    writers[COLLECTION] = collection([*writers])
    writers[BELOW] = text_writer(below_table(run))
    return writers


def _plane_files(run: WheelsetRun) -> dict[str, Writer]:
    """Return functions that write the fields, by the files' names."""
    result = run.plane
    writers: dict[str, Writer] = {f"{name}.vtu": partial(write_part, result=result, name=name) for name in PLANE_PARTS}
    writers[CONTACT] = lambda path: write_contacts(
        path, result.model.system, result.equilibrium.state, {name: result.placements[name] for name in PLANE_PARTS}
    )
    return writers | {COLLECTION: collection(writers)}
