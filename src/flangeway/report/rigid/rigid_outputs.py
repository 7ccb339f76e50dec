"""All files of ``flangeway geometry``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from flangeway.cases import write_summary
from flangeway.cases.rigid.rigid_run import ConicityRun, GeometryRun
from flangeway.report.figures.drawing import picture_writers
from flangeway.report.page.tables import plain_table, print_files, print_notices
from flangeway.report.rigid.rigid_figures import conicity_figure, flange_root_figure, locus_figure, rolling_figure
from flangeway.system.output_folder import write_together

CONICITY_PICTURE = "conicity.png"
PICTURES: dict[str, Callable[[GeometryRun], Figure]] = {
    "contact_locus.png": locus_figure,
    "rolling_radius_difference.png": rolling_figure,
    CONICITY_PICTURE: conicity_figure,
}
FLANGE_ROOT, TABLE, CONICITY, SUMMARY = "flange_root_radius.png", "table.csv", "conicity.csv", "geometry.json"
NAMES = (*PICTURES, FLANGE_ROOT, TABLE, CONICITY, SUMMARY)
CONICITY_NAMES = (CONICITY_PICTURE, CONICITY, SUMMARY)


def write_geometry(run: GeometryRun, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write pictures, ``table.csv``, ``conicity.csv`` and ``geometry.json``, together or not at all.

    It is an `InputError` if the folder cannot be written.
    """
    progress("drawing the pictures and writing the files")
    figures: dict[str, Figure] = {name: draw(run) for name, draw in PICTURES.items()}
    if run.flange_root is not None:
        figures[FLANGE_ROOT] = flange_root_figure(run.flange_root)
    writers = picture_writers(figures)
    writers[TABLE] = run.table.to_csv
    return write_together(folder, writers | _conicity_writers(run))


def write_conicity(run: ConicityRun, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write picture, ``conicity.csv`` and ``geometry.json`` of a rolling radius difference; as `write_geometry`."""
    progress("drawing the picture and writing the files")
    return write_together(folder, picture_writers({CONICITY_PICTURE: conicity_figure(run)}) | _conicity_writers(run))


def _conicity_writers(run: GeometryRun | ConicityRun) -> dict[str, Callable[[Path], None]]:
    found = run.conicities
    return {
        CONICITY: found.table.to_csv,
        SUMMARY: lambda path: write_summary(path, run.summary),
    }


def print_geometry(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print equilibrium, contacts with Hertz's estimate, jumps, conicity, notices and files."""
    console.print(f"{summary['case']}: {summary['title']}", style="bold", markup=False)
    console.print(summary["status"]["message"], markup=False, soft_wrap=True)
    position = summary["equilibrium"]
    if position is not None:
        console.print(
            f"Position in space: lateral {_clean(position['lateral_mm']):.4f} mm, vertical "
            f"{_clean(position['vertical_mm']):.4f} mm, roll {_clean(1e3 * position['roll_rad']):.5f} mrad; "
            f"L/V left {position['lateral_over_vertical']['left']:.3f}, "
            f"right {position['lateral_over_vertical']['right']:.3f}",
            markup=False,
            soft_wrap=True,
        )
        console.print(_contact_table(position["contacts"]))
    jumps = ", ".join(f"{jump['lateral_mm']:.3f} ({jump['side']})" for jump in summary["jumps"])
    console.print(f"Jumps of the contact point at lateral displacements in mm: {jumps or 'none'}", markup=False)
    _print_end(console, summary, files)


def print_conicity(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print the conicity of a file, the position without difference, notices and files."""
    console.print(f"{summary['case']}: {summary['title']}", style="bold", markup=False)
    middle = summary["lateral_without_difference_mm"]
    if middle is not None:
        console.print(f"Lateral displacement without a difference of the radii: {_clean(middle):.3f} mm", markup=False)
    _print_end(console, summary, files)


def _print_end(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    conicity = summary["equivalent_conicity"]
    if conicity is not None:
        console.print(
            f"Equivalent conicity at {conicity['amplitude_mm']:g} mm: {conicity['integration']:.4f} by integration, "
            f"{conicity['regression']:.4f} by linear regression",
            markup=False,
            soft_wrap=True,
        )
    print_notices(console, summary["notices"])
    print_files(console, files, summary["timings_s"]["total"])


def _contact_table(contacts: list[dict[str, Any]]) -> Table:
    yawed = any(contact["ahead_of_axle_mm"] for contact in contacts)
    table = plain_table(
        *("side", "force kN", "angle deg", "wheel x mm", "rail x mm", "radius mm", *(["ahead mm"] if yawed else [])),
        *("Hertz a mm", "Hertz p0 MPa"),
    )
    for contact in contacts:
        hertz = contact["hertz_half_width_mm"], contact["hertz_max_pressure_MPa"]
        table.add_row(
            contact["side"],
            f"{contact['normal_force_kN']:.2f}",
            f"{contact['contact_angle_deg']:.2f}",
            f"{contact['wheel_point_mm'][0]:.2f}",
            f"{contact['rail_point_mm'][0]:.2f}",
            f"{contact['rolling_radius_mm']:.2f}",
            *([f"{contact['ahead_of_axle_mm']:.2f}"] if yawed else []),
            *("conforming" if value is None else f"{value:.4g}" for value in hertz),
        )
    return table


def _clean(value: float) -> float:
    """Zero for noise of rounding."""
    return 0.0 if abs(value) < 1e-7 else value
