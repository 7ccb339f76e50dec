"""Files, report and terminal summary of a wheelset in three dimensions."""

from collections.abc import Callable
from functools import partial

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetRun
from flangeway.cases.wheelset.spatial_wheelset_summary import SpatialWheelsetSummary, WheelPatchSummary
from flangeway.cases.wheelset.wheelset_summary import AXES as WHEELSET_AXES
from flangeway.report.figures.drawing import png
from flangeway.report.figures.series import write_collection
from flangeway.report.page.case_text import case_text, command_line, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture, report_page
from flangeway.report.page.tables import (
    Column,
    SummaryTable,
    marked,
    number,
    print_notices,
    print_rows,
    print_status,
    print_table,
    table_across,
    timings_table,
)
from flangeway.report.spatial_wheelset.pressure_scene import pressure_scene
from flangeway.report.spatial_wheelset.rails_along_track import rails_csv, rails_figure, rails_table
from flangeway.report.spatial_wheelset.running_surface_files import (
    PARTS,
    below_table,
    patches_table,
    write_surface,
)
from flangeway.report.spatial_wheelset.wheelset_patches import (
    depths_figure,
    patches_figure,
    pressures_figure,
    section_figure,
)
from flangeway.system.output_folder import Writer, bytes_writer, text_writer

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
    "depth.png": (
        depths_figure,
        "Stresses over the depth below each patch.",
        "Stresses on the normal below the centre of each patch, of a half-space under the patch's pressures: x along "
        "the surface across the track, y along the normal, z along the track. Rail and wheel of one material have the "
        "same.",
    ),
}
"""Pictures of the report by the files' names: what draws them, what they show, and the caption."""
REPORT, COLLECTION, PATCHES, BELOW = "report.html", "wheelset.pvd", "patches.csv", "subsurface.csv"
SURFACES = {f"{role}-{side}": (side, role) for side, role in PARTS}
RAILS_PICTURE, RAILS = "rails.png", "rails.csv"
RAILS_CAPTION = (
    "The rails along the track: deflection, motion of the gauge face, and stress along the track in the middle of the "
    "foot's underside."
)
NAMES = (*PICTURES, *(f"{name}.vtu" for name in SURFACES), COLLECTION, PATCHES, BELOW, RAILS_PICTURE, RAILS, REPORT)
AT_ONCE = 3
"""Patches in one table on a terminal."""
FILES = (
    "The same numbers, for programs, are in `summary.json`; a row for each patch, for a spreadsheet, in `patches.csv`; "
    "the stresses below the patches in `subsurface.csv`; the rails along the track in `rails.csv`; pressures "
    "and gaps on the running surfaces in `wheelset.pvd`, "
    "which ParaView opens with both rails and wheels."
)
AXES = {key: WHEELSET_AXES[key] for key in ("space", "rail", "wheel", "forces")} | {
    "z": "along the track, ahead of the axle: x, y, z are left-handed, so that ParaView shows the VTU files "
    "as seen from ahead; with yaw, patches lie ahead of the axle or behind it",
    "contact angle": "of the plane normal to the force from the track's plane, positive towards the flange",
    "angle": "from z to the longer semi-axis, positive towards the gauge side",
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards; without creep forces",
    "stresses": "tension positive",
}


def wheelset_writers(run: SpatialWheelsetRun, progress: Callable[[str], None]) -> dict[str, Writer]:
    """Return functions that write pictures, surfaces, tables and report, by the files' names."""
    progress("drawing the pictures and writing the files")
    pictures = [Picture(png(draw(run)), words, caption) for draw, words, caption in PICTURES.values()]
    names = list(PICTURES)
    if run.result.rails:
        pictures.append(Picture(png(rails_figure(run)), RAILS_CAPTION, RAILS_CAPTION))
        names.append(RAILS_PICTURE)
    writers = {name: bytes_writer(each.png) for name, each in zip(names, pictures, strict=True)}
    if run.result.rails:
        writers[RAILS] = text_writer(rails_csv(run))
    for name, (side, role) in SURFACES.items():
        writers[f"{name}.vtu"] = partial(write_surface, run.result, side, role)
    writers[COLLECTION] = lambda path: write_collection(path, [(0.0, name, f"{name}.vtu") for name in SURFACES])
    writers[PATCHES] = text_writer(patches_table(run.summary.patches))
    writers[BELOW] = text_writer(below_table(run))
    writers[REPORT] = text_writer(report_page(_page(run, pictures)))
    return writers


def _page(run: SpatialWheelsetRun, pictures: list[Picture]) -> Page:
    summary, problem = run.summary, run.result.problem
    return Page(
        title=run.case.title,
        subtitle=f"Wheel {problem.wheelset.wheel.title} on rail {problem.track.rail.title}; axle load "
        f"{problem.load.vertical_N / 1e3:g} kN",
        converged=summary.status.converged,
        message=summary.status.message,
        facts=_facts(summary),
        again=Again(command_line(run.case), case_text(run.case), files=FILES),
        versions=summary.versions,
        sentences=[summary.position.reference],
        warnings=summary.warnings,
        assumptions=summary.assumptions,
        scene=pressure_scene(run),
        pictures=pictures,
        tables=[
            *patch_tables(summary),
            _position_table(summary),
            _rails_table(summary),
            *([rails_table(run)] if run.result.rails else []),
            timings_table(summary.timings_s),
        ],
        axes=AXES,
        inputs=inputs_tables(run.case),
    )


def _facts(summary: SpatialWheelsetSummary) -> list[tuple[str, str]]:
    facts = []
    for patch in summary.patches:
        pressure = marked(number(patch.max_pressure_MPa, 0) + " MPa", patch.max_pressure_remark or None)
        facts.append((pressure, f"maximum pressure, {patch.side} {patch.region}"))
    ratios = " and ".join(number(side.lateral_over_vertical, 3) for side in summary.sides)
    facts += [
        (ratios, "L/V, left and right"),
        (number(summary.position.lateral_mm, 2) + " mm", "lateral position of the axle"),
    ]
    residual = summary.residual.equilibrium
    return [*facts, ("–" if residual is None else f"{residual:.0e}", "equilibrium residual")]


def patch_tables(
    summary: SpatialWheelsetSummary, at_once: int | None = None, *, short: bool = False
) -> list[SummaryTable]:
    """Numbers of the patches, one column a patch, in tables of some patches each."""
    quantities: list[Column] = [
        ("force, kN", "normal_force_kN", ".2f"),
        ("maximum pressure, MPa", _pressure, ""),
        ("  Hertz", "hertz_pressure_MPa", ".1f"),
        ("semi-axes, mm", "semi_axes_mm", ".2f"),
        ("  Hertz", "hertz_semi_axes_mm", ".2f"),
        ("angle from z, deg", "angle_deg", "z.1f"),
        ("contact angle, deg", "contact_angle_deg", ".2f"),
        ("on the rail, mm", "rail_position_mm", ".2f"),
        ("on the wheel, mm", "wheel_position_mm", ".2f"),
        ("ahead of the axle, mm", lambda p: p.track_position_mm[2], "z.2f"),
        ("von Mises, MPa (at mm)", lambda p: _at(p, "max_von_mises"), ""),
    ]
    if not short:
        quantities += [
            ("maximum shear, MPa (at mm)", lambda p: _at(p, "max_shear"), ""),
            ("lateral force on the wheel, kN", "lateral_force_kN", ".3f"),
            ("vertical force on the wheel, kN", "vertical_force_kN", ".3f"),
            ("area, mm²", "area_mm2", ".1f"),
            ("conformity: turn of the rail's normal, deg", "conformity_deg", ".1f"),
            ("rolling radius, mm", "rolling_radius_mm", ".3f"),
            ("cells across, along", "cells", "d"),
        ]
    patches = summary.patches
    step = at_once or max(len(patches), 1)
    return [
        table_across("Patches", [f"{p.side}\n{p.region}" for p in part], part, quantities)
        for part in (patches[first : first + step] for first in range(0, len(patches), step))
    ]


def _pressure(patch: WheelPatchSummary) -> str:
    return marked(number(patch.max_pressure_MPa, 1), patch.max_pressure_remark or None)


def _at(patch: WheelPatchSummary, name: str) -> str:
    """The greater of a stress in rail and wheel, with its depth."""
    found = [
        (getattr(each, f"{name}_MPa"), getattr(each, f"{name}_depth_mm")) for each in (patch.in_rail, patch.in_wheel)
    ]
    value, depth = max(found)
    return f"{value:.0f} ({depth:.2f})"


def _position_rows(summary: SpatialWheelsetSummary) -> list[tuple[str, str]]:
    position = summary.position
    return [
        ("lateral position of the axle, mm", f"{position.lateral_mm:z.3f}"),
        ("vertical position, mm", f"{position.vertical_mm:z.4f}"),
        ("roll, mrad", f"{1e3 * position.roll_rad:z.3f}"),
        ("gauge widened, mm", f"{sum(rail.gauge_outward_mm for rail in summary.rails):z.3f}"),
        ("L/V, left and right", " and ".join(number(side.lateral_over_vertical, 4) for side in summary.sides)),
    ]


def _position_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    residual, load = summary.residual, summary.load
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
        *_position_rows(summary),
        ("approach, mm", number(summary.position.approach_mm, 4)),
        ("load onto the track, kN", number(load.onto_track_kN, 3)),
        ("load in the track's plane, kN", number(load.lateral_in_track_kN, 3)),
        *(
            (
                f"force on the {each.side} wheel (lateral, vertical), kN",
                f"({each.lateral_force_kN:.3f}, {each.vertical_force_kN:.3f})",
            )
            for each in summary.sides
        ),
        *small,
    ]
    return SummaryTable("Position, forces and equilibrium", ("", "value"), tuple(rows))


def _rails_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    quantities: list[Column] = [
        ("top of the head to the right, mm", "lateral_mm", "z.3f"),
        ("  up, mm", "vertical_mm", "z.3f"),
        ("  roll, mrad", lambda rail: 1e3 * rail.roll_rad, "z.3f"),
        ("gauge face outwards, mm", "gauge_outward_mm", "z.3f"),
    ]
    return table_across("Heads of the rails at the wheels", (r.side for r in summary.rails), summary.rails, quantities)


def print_spatial_wheelset(console: Console, run: SpatialWheelsetRun) -> None:
    """Print status, patches, position, L/V and warnings."""
    summary = run.summary
    print_status(console, run.case.name, run.status)
    for table in patch_tables(summary, AT_ONCE, short=True):
        print_table(console, table)
    print_rows(console, _position_rows(summary))
    print_notices(console, summary.warnings, "Warning")
