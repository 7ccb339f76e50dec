"""All files of ``flangeway reproduce wheel-rail``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from flangeway.report.figures.fields import part_fields
from flangeway.report.figures.picture_files import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.report.wheelset.contact_figure import contact_figure
from flangeway.report.wheelset.rigid_elastic_figure import rigid_elastic_figure
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.system.output_folder import write_together
from flangeway.validation.published_numbers import ReproducedNumber, write_rows
from flangeway.validation.wheel_rail.wheel_rail_figures import (
    positions_figure,
    pressures_figure,
    refinement_figure,
    rigid_limit_figure,
    root_figure,
)
from flangeway.validation.wheel_rail.wheel_rail_reproduced import (
    WheelRailPatchRow,
    WheelRailReproduction,
    n_predicted,
    patch_rows,
)

TABLE, PATCHES = "table.csv", "patches.csv"
FIGURES = {
    "positions.png": positions_figure,
    "flange_root.png": root_figure,
    "rigid_limit.png": rigid_limit_figure,
    "refinement.png": refinement_figure,
}
PRESSURES = {situation: f"pressures_{situation}.png" for situation in ("tangent", "curve")}
FIELDS = ("curve.png", "curve_left_contact.png", "curve_right_contacts.png", "curve_rigid_and_elastic.png")
FILES = (*FIGURES, *PRESSURES.values(), *FIELDS, PATCHES, TABLE)
"""Names of all files."""


def write(found: WheelRailReproduction, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write pictures and tables into a folder, together or not at all.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    progress("drawing the pictures")
    figures = {name: draw(found) for name, draw in FIGURES.items()}
    figures |= {name: pressures_figure(found, situation) for situation, name in PRESSURES.items()}
    run = found.rows[-1].run
    parts = list(part_fields(run.result))
    figures |= dict(
        zip(
            FIELDS,
            (
                wheelset_figure(run, parts),
                contact_figure(run, parts, "left"),
                contact_figure(run, parts, "right"),
                rigid_elastic_figure(run, parts),
            ),
            strict=True,
        )
    )
    writers = picture_writers(figures)
    writers[PATCHES] = lambda path: write_rows(path, patch_rows(found.rows), WheelRailPatchRow)
    writers[TABLE] = lambda path: write_rows(path, found.numbers, ReproducedNumber)
    return write_together(folder, writers)


def print_summary(console: Console, found: WheelRailReproduction, files: list[Path]) -> None:
    """Print the rows with their contacts, what is outside of its limit, and the verdict."""
    console.print(_rows_table(found))
    console.print(_patches_table(found))
    console.print(
        f"The flange root is fitted to one published number; {n_predicted(found)} others are predicted (table.csv, "
        "positions.png, flange_root.png).",
        soft_wrap=True,
        markup=False,
    )
    required = [number for number in found.numbers if number.required]
    n_within = sum(number.within for number in required)
    console.print(
        f"{n_within} of {len(required)} numbers with a limit are within: positions, balance, agreement of the methods, "
        "contact regions, rigid limit, refinement, Hertz.",
        style="bold green" if found.passed else "bold red",
        markup=False,
        soft_wrap=True,
    )
    for number in required:
        if not number.within:
            console.print(
                f"  {number.table}, {number.code}, {number.quantity}: {number.computed:.5g} for {number.published:.5g} "
                f"{number.unit} ({number.note})",
                markup=False,
                soft_wrap=True,
            )
    print_files(console, files, found.seconds)


def _rows_table(found: WheelRailReproduction) -> Table:
    shown = plain_table("row")
    for name in ("vertical, mm", "lateral, mm", "roll, mrad", "error", "seconds"):
        shown.add_column(name, justify="right")
    for row in found.rows:
        motion = row.result.position_in_space
        shown.add_row(
            f"{row.situation} {row.code}",
            f"{motion.vertical_mm:.4f}",
            f"{motion.lateral_mm:.4f}",
            f"{1e3 * motion.roll_rad:.4f}",
            f"{row.result.equilibrium.residuals.equilibrium_residual:.0e}",
            f"{row.seconds:.1f}",
        )
        if not row.result.status.converged:
            shown.add_row(row.result.status.message)
    return shown


def _patches_table(found: WheelRailReproduction) -> Table:
    shown = plain_table("contact")
    for name in ("force, kN", "angle, degrees", "half width, mm", "rail x, mm", "shear, MPa"):
        shown.add_column(name, justify="right")
    for row in patch_rows(found.rows):
        numbers = (row.force_kN, row.angle_deg, row.half_width_mm, row.rail_x_mm, row.max_shear_rail_MPa)
        digits = (2, 1, 2, 2, 0)
        texts = [f"{np.round(number, n):.{n}f}" for number, n in zip(numbers, digits, strict=True)]
        shown.add_row(f"{row.situation} {row.code} {row.contact}", *texts)
    return shown
