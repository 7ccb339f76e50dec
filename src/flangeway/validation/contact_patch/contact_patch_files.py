"""All files of ``flangeway reproduce contact-patch``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table

from flangeway.report.figures.picture_files import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.system.output_folder import write_together
from flangeway.validation.contact_patch.contact_patch_figures import (
    KINDS,
    comparison_figure,
    forces_figure,
    pressures_figure,
    stresses_figure,
)
from flangeway.validation.contact_patch.contact_patch_reproduced import (
    PASSED,
    PUBLISHED,
    ContactPatchReproduction,
    PatchRow,
)
from flangeway.validation.published_numbers import ReproducedNumber, write_rows

TABLE, PASSES = "table.csv", "passes.csv"
FORCES, PRESSURES, COMPARISON = "contact_forces.png", "pressures.png", "comparison.png"
STRESSES = {kind: f"stresses_{kind.lower()}.png" for kind in KINDS}
FILES = (TABLE, PASSES, FORCES, PRESSURES, COMPARISON, *STRESSES.values())
"""Names of all files."""


def write(
    found: ContactPatchReproduction, folder: Path, progress: Callable[[str], None] = lambda _: None
) -> list[Path]:
    """Write pictures and tables into a folder, together or not at all.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    progress("drawing the pictures")
    figures = {
        FORCES: forces_figure(found),
        PRESSURES: pressures_figure(found),
        COMPARISON: comparison_figure(found),
        **{name: stresses_figure(found, kind) for kind, name in STRESSES.items()},
    }
    writers = picture_writers(figures)
    writers[PASSES] = lambda path: write_rows(path, found.rows, PatchRow)
    writers[TABLE] = lambda path: write_rows(path, found.numbers, ReproducedNumber)
    return write_together(folder, writers)


def print_summary(console: Console, found: ContactPatchReproduction, files: list[Path]) -> None:
    """Print how far node-to-segment is off, what segment-to-segment leaves, and what did not pass."""
    for run in (*found.published, *found.proper):
        if not run.converged:
            console.print(f"  {run.code}, {run.law}: {run.solution.status.message}", style="red", markup=False)
    off = [run.stress_error for run in found.published]
    console.print(
        f"Node-to-segment fails the test, as published: stresses are up to {100.0 * min(off):.1f} to "
        f"{100.0 * max(off):.0f} % off {PUBLISHED:g} kN/cm². The published pictures give no numbers to compare with.",
        style="bold green" if all(row.within for row in found.numbers) else "bold red",
        markup=False,
        soft_wrap=True,
    )
    console.print(_published_table(found))
    passing = sum(run.passes for run in found.proper)
    worst = max(max(run.pressure_error, run.stress_error) for run in found.proper)
    console.print(
        f"Segment-to-segment passes the test in {passing} of {len(found.proper)} cases: pressures and stresses are "
        f"within {worst:.1e} of uniform (limit {PASSED:g}).",
        style="bold green" if passing == len(found.proper) else "bold red",
        markup=False,
        soft_wrap=True,
    )
    for run in found.proper:
        if not run.passes:
            console.print(
                f"  {run.code}, {run.pairing}, {run.law}: pressure {run.pressure_error:.1e}, stress "
                f"{run.stress_error:.1e} off",
                style="red",
                markup=False,
            )
    print_files(console, files, found.seconds)


def _published_table(found: ContactPatchReproduction) -> Table:
    shown = plain_table("node-to-segment")
    for name in ("mean", "least", "maximum", "maximum deviation", "root mean square", "pressure of nodes"):
        shown.add_column(name, justify="right")
    for run in found.published:
        least, maximum = (100.0 * (value - 1.0) for value in run.pressure_range)
        shown.add_row(
            run.code,
            *(f"{value:.1f}" for value in (run.mean_stress, *run.stress_range)),
            f"{100.0 * run.stress_error:.1f} %",
            f"{100.0 * run.stress_oscillation:.2f} %",
            f"{least:+.0f} to {maximum:+.0f} %",
        )
    return shown
