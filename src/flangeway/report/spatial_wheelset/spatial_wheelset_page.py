"""Files, report and terminal summary of a wheelset in three dimensions."""

from collections.abc import Callable
from functools import partial

from matplotlib.figure import Figure

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase, SpatialWheelsetRun
from flangeway.cases.wheelset.spatial_wheelset_summary import SpatialWheelsetSummary, WheelPatchSummary
from flangeway.cases.wheelset.wheelset_summary import AXES as WHEELSET_AXES
from flangeway.railway.track.discretisation import ROLES
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.whole_sections import whole_sections
from flangeway.report.figures.series import write_collection
from flangeway.report.page.case_text import run_record
from flangeway.report.page.record import Picture, Record
from flangeway.report.page.tables import Column, SummaryTable, marked, number, table_across, with_whole
from flangeway.report.spatial_wheelset.pressure_scene import pressure_scene
from flangeway.report.spatial_wheelset.rails_along_track import rails_csv, rails_figure, rails_table
from flangeway.report.spatial_wheelset.rolling_patches import AXES as ROLLING_AXES
from flangeway.report.spatial_wheelset.rolling_patches import (
    ROLLING,
    motion_tables,
    rolling_names,
    rolling_pictures,
    rolling_table,
)
from flangeway.report.spatial_wheelset.running_surface_files import (
    PARTS,
    below_table,
    patches_table,
    write_section,
    write_stresses,
    write_surface,
)
from flangeway.report.spatial_wheelset.wheelset_patches import (
    patches_figure,
    pressures_figure,
    section_figure,
    stresses_figure,
)
from flangeway.report.wheelset import wheelset_page
from flangeway.system.output_folder import Writer, text_writer

PICTURES: dict[str, tuple[Callable[[SpatialWheelsetRun], Figure], str, str]] = {
    "wheelset.png": (
        section_figure,
        "Both wheels on their rails in section with contact forces and pressures, and a sketch of the whole between.",
        "The wheelset in the section through its axle. Violet: the maximum pressure of each position across the rail, "
        "drawn into the rail along its normal. Arrows: forces on the wheels.",
    ),
    "patches.png": (
        patches_figure,
        "Pressure maps of the patches on both rails from above, outlined.",
        "The patches from above, the running surface rolled out flat: pressure, outline, and, where the curvatures "
        "allow one, Hertz's ellipse for the same force (dashed).",
    ),
    "pressure.png": (
        pressures_figure,
        "Pressure of each patch across and along the track through its maximum.",
        "Pressure across and along the track through the maximum of each patch; dashed: Hertz's for the same force.",
    ),
    "stresses.png": (
        stresses_figure,
        "Von Mises stress below each patch across and along the track, and stresses over the depth.",
        "The von Mises stress below each patch, across and along the track through its maximum (+), and stresses on "
        "the normal there: x along the surface across the track, y along the normal, z along the track; of a "
        "half-space under the tractions of all cells. Bodies of one material: the rail's; without friction the wheel "
        "has the same.",
    ),
}
"""Pictures of the report by the files' names: what draws them, what they show, and the caption."""
COLLECTION, PATCHES, BELOW = "wheelset.pvd", "patches.csv", "subsurface.csv"
SURFACES = {f"{role}-{side}": (side, role) for side, role in PARTS}
STRESSES = {f"stresses-{name}": part for name, part in SURFACES.items()}
SECTIONS = {f"section-{name}": part for name, part in SURFACES.items()}
RAILS_PICTURE, RAILS = "rails.png", "rails.csv"
RAILS_CAPTION = (
    "The rails along the track: deflection, motion of the gauge face, and stress along the track in the middle of the "
    "foot's underside."
)
NAMES = (
    *PICTURES,
    *(f"{name}.vtu" for name in (*SURFACES, *SECTIONS, *STRESSES)),
    COLLECTION,
    PATCHES,
    BELOW,
    RAILS_PICTURE,
    RAILS,
)
FILES = (
    "The same numbers, for programs, are in `summary.json`; a row for each patch, for a spreadsheet, in `patches.csv`; "
    "the stresses below the patches in `subsurface.csv`; the rails along the track in `rails.csv`; pressures "
    "and gaps on the running surfaces, displacements and stresses of whole sections through the patches, and stresses "
    "in the volumes below the patches, in "
    "`wheelset.pvd`, which ParaView opens with both rails and wheels."
)
AXES = {key: WHEELSET_AXES[key] for key in ("space", "rail", "wheel", "forces")} | {
    "z": "along the track, ahead of the axle: x, y, z are left-handed, so that ParaView shows the VTU files "
    "as seen from ahead; with yaw, patches lie ahead of the axle or behind it",
    "contact angle": "of the plane normal to the force from the track's plane, positive towards the flange",
    "angle": "from z to the longer semi-axis, positive towards the gauge side",
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards",
    "gauge-face deflection": "of the elastic rail, positive outwards, away from the middle of the track",
    "p0/k": "maximum pressure over the shear strength k = yield strength / sqrt(3). Shakedown state of a circular "
    "patch: elastic; shakedown, elastic after the first passages; hardening, the same with kinematic hardening; "
    "yields, in each passage",
    "stresses": "tension positive; maxima are those of the whole volume below a patch",
}


def names(case: SpatialWheelsetCase) -> tuple[str, ...]:
    """Names of the files of a run."""
    if case.model == "plane":
        return wheelset_page.NAMES
    return *NAMES, *(rolling_names(case.rolling_theory) if case.friction else ())


def spatial_wheelset_record(run: SpatialWheelsetRun) -> Record:
    """Return what a run of a wheelset in three dimensions found."""
    summary, problem, rolls = run.summary, run.result.problem, bool(run.result.rolling)
    return run_record(
        run,
        FILES,
        subtitle=f"Wheel {problem.wheelset.wheel.title} on rail {problem.track.rail.title}; axle load "
        f"{problem.load.vertical_N / 1e3:g} kN",
        facts=wheelset_facts(summary),
        results=results_table(summary),
        sentences=[summary.position.reference],
        warnings=summary.warnings,
        assumptions=summary.assumptions,
        scene=lambda: pressure_scene(run),
        pictures=[*_pictures(run), *rolling_pictures(run)],
        chapters={"Rolling": [rolling_table(summary), *motion_tables(summary)]} if rolls else {},
        tables=[
            *([patches_numbers(summary)] if summary.patches else []),
            _position_table(summary),
            _rails_table(summary),
            *([rails_table(run)] if run.result.rails else []),
        ],
        axes=AXES | (ROLLING_AXES if rolls else {}),
        files=lambda: _files(run),
    )


def _pictures(run: SpatialWheelsetRun) -> list[Picture]:
    pictures = [Picture(name, partial(draw, run), *words) for name, (draw, *words) in PICTURES.items()]
    if not run.result.patches:  # a search that found no equilibrium
        del pictures[1:]
    if run.result.rails:
        pictures.append(Picture(RAILS_PICTURE, lambda: rails_figure(run), RAILS_CAPTION))
    return pictures


def _files(run: SpatialWheelsetRun) -> dict[str, Writer]:
    """Return functions that write surfaces and tables, by the files' names."""
    writers: dict[str, Writer] = {PATCHES: text_writer(patches_table(run.summary.patches))}
    if run.result.rails:
        writers[RAILS] = text_writer(rails_csv(run))
    for name, (side, role) in SURFACES.items():
        writers[f"{name}.vtu"] = partial(write_surface, run.result, side, role)
    sections = {role: whole_sections(run.result, role) for role in ROLES}
    found = {name: (side, role) for name, (side, role) in SECTIONS.items() if side in sections[role]}
    for name, (side, role) in found.items():
        writers[f"{name}.vtu"] = partial(write_section, sections[role][side], side, role)
    below = {name: part for name, part in STRESSES.items() if any(p.side == part[0] for p in run.result.patches)}
    for name, (side, role) in below.items():
        writers[f"{name}.vtu"] = partial(write_stresses, run.result, side, role)
    files = [(0.0, name, f"{name}.vtu") for name in (*SURFACES, *found, *below)]
    writers[COLLECTION] = lambda path: write_collection(path, files)
    writers[BELOW] = text_writer(below_table(run))
    return writers


def wheelset_facts(summary: SpatialWheelsetSummary) -> list[tuple[str, str]]:
    """Return the most important numbers with units, and what they are."""
    patches = [(each, f"{each.side} {each.region}") for each in summary.patches]
    return wheelset_page.wheelset_facts(summary, f"{summary.position.lateral_mm:z.2f} mm", patches)


PATCH: tuple[Column, ...] = (
    ("force, kN", "normal_force_kN", ".2f"),
    ("maximum pressure, MPa", lambda p: marked(number(p.max_pressure_MPa, 1), p.max_pressure_remark), ""),
    ("  Hertz, MPa", "hertz_pressure_MPa", ".1f"),
    ("p0/k (load factor)", "pressure_over_shear_strength", ".2f"),
    ("  shakedown state", lambda p: p.shakedown_state or "–", ""),
    ("{longer|shorter} semi-axis, mm", "semi_axes_mm", ".2f"),
    ("contact angle, deg", "contact_angle_deg", ".2f"),
    ("x on the rail, mm", lambda p: p.rail_position_mm[0], "z.2f"),
    ("x on the wheel, mm", lambda p: p.wheel_position_mm[0], "z.2f"),
    ("longitudinal position, mm", lambda p: p.track_position_mm[2], "z.2f"),
    ("max. von Mises{, MPa|: depth, mm}", lambda p: _at(p, "max_von_mises"), ".0f|.2f"),
)
FURTHER: tuple[Column, ...] = (
    ("y on the rail, mm", lambda p: p.rail_position_mm[1], "z.2f"),
    ("y on the wheel, mm", lambda p: p.wheel_position_mm[1], "z.2f"),
    ("von Mises below the centre{, MPa|: depth, mm}", lambda p: _at(p, "von_mises_below_centre"), ".0f|.2f"),
    ("max. Tresca{, MPa|: depth, mm}", lambda p: _at(p, "max_tresca"), ".0f|.2f"),
    ("max. tension{, MPa|: depth, mm}", lambda p: _at(p, "max_tension"), ".0f|.2f"),
    ("Hertz: {longer|shorter} semi-axis, mm", "hertz_semi_axes_mm", ".2f"),
    ("orientation of the major axis, deg", "angle_deg", "z.1f"),
    ("lateral force on the wheel, kN", "lateral_force_kN", ".3f"),
    ("vertical force on the wheel, kN", "vertical_force_kN", ".3f"),
    ("area, mm²", "area_mm2", ".1f"),
    ("change of contact normal across the patch, deg", "conformity_deg", ".1f"),
    ("rolling radius, mm", "rolling_radius_mm", ".3f"),
    ("cells {across|along}", "cells", "d"),
)
"""PATCH, FURTHER: numbers of a patch, those of the table of results and further ones."""


def patches_numbers(summary: SpatialWheelsetSummary) -> SummaryTable:
    """Further numbers of the patches, one column a patch."""
    patches = summary.patches
    return table_across("Patches", [f"{p.side} {p.region}" for p in patches], patches, FURTHER)


def results_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    """Position, L/V of the wheels and patches, one column a patch; what is of a side is in its first column."""
    patches, position = summary.patches, summary.position
    sides = {each.side: number(each.lateral_over_vertical, 4) for each in summary.sides}
    gauge = {each.side: f"{each.gauge_outward_mm:z.3f}" for each in summary.rails}
    whole = {
        "lateral position of the axle, mm": f"{position.lateral_mm:z.3f}",
        "vertical position, mm": f"{position.vertical_mm:z.4f}",
        "roll, mrad": f"{1e3 * position.roll_rad:z.3f}",
    }
    table = table_across(
        "Results",
        [f"{p.side} {p.region}" for p in patches],
        patches,
        (*PATCH, *(ROLLING if any(p.rolling for p in patches) else ())),
    )
    ratios = {"L/V": sides}
    if summary.rolling is not None:
        rolling = summary.rolling
        ratios["  Nadal's limit"] = {
            side: number(value, 3) for side, value in zip(SIDES, rolling.nadal_limits, strict=True)
        }
        ratios["  share of the limit, %"] = {
            side: number(100.0 * share, 0)
            for side, share in zip(SIDES, rolling.shares_of_nadal_limits, strict=True)
            if share is not None
        }
    return with_whole(table, whole, [p.side for p in patches], {**ratios, "gauge-face deflection, mm": gauge})


def _at(patch: WheelPatchSummary, name: str) -> tuple[float, float]:
    """The greater of a stress in rail and wheel, with its depth."""
    return max(
        (getattr(each, f"{name}_MPa"), getattr(each, f"{name}_depth_mm")) for each in (patch.in_rail, patch.in_wheel)
    )


def _position_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    residual, load, position = summary.residual, summary.load, summary.position
    small = [
        (name, "–" if value is None else f"{value:.1e}")
        for name, value in (
            ("equilibrium residual", residual.equilibrium),
            ("  vertical", residual.vertical),
            ("  lateral", residual.lateral),
            ("  moment", residual.moment),
        )
    ]
    rows = [
        ("approach, mm", number(position.approach_mm, 4)),
        ("gauge widened, mm", f"{sum(rail.gauge_outward_mm for rail in summary.rails):z.3f}"),
        ("load normal to the track plane, kN", number(load.onto_track_kN, 3)),
        ("load parallel to the track plane, kN", number(load.lateral_in_track_kN, 3)),
        *(
            (f"{word} force on the {each.side} wheel, kN", f"{getattr(each, f'{word}_force_kN'):z.3f}")
            for each in summary.sides
            for word in ("lateral", "vertical")
        ),
        *small,
    ]
    return SummaryTable("Position, forces and equilibrium", ("", "value"), tuple(rows))


def _rails_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    quantities: list[Column] = [
        ("railhead lateral displacement, mm", "lateral_mm", "z.3f"),
        ("  up, mm", "vertical_mm", "z.3f"),
        ("  roll, mrad", lambda rail: 1e3 * rail.roll_rad, "z.3f"),
        ("gauge-face deflection, mm", "gauge_outward_mm", "z.3f"),
    ]
    return table_across("Heads of the rails at the wheels", (r.side for r in summary.rails), summary.rails, quantities)
