"""All files of ``flangeway reproduce hertz``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from flangeway.report.figures.picture_files import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.system.output_folder import write_together
from flangeway.validation.hertz import hertz_figures
from flangeway.validation.hertz.hertz_reproduced import (
    CODES,
    REFERENCE_FORCE,
    VARIANTS,
    HertzReproduction,
    HertzRow,
    Variant,
)
from flangeway.validation.published_numbers import ReproducedNumber, write_rows

TABLE = "table.csv"
FIGURES: dict[str, Callable[[HertzReproduction], Figure]] = {
    "contact_forces.png": hertz_figures.forces_figure,
    "pressure_node_to_segment.png": lambda found: hertz_figures.pressure_figure(found, "halved"),
    "pressure_penalty_as_printed.png": lambda found: hertz_figures.pressure_figure(found, "printed"),
    "pressure_segment_to_segment.png": lambda found: hertz_figures.pressure_figure(found, "segments"),
    "symmetry_line.png": hertz_figures.symmetry_figure,
    "extremes.png": hertz_figures.extremes_figure,
}
SMOOTH_FIELDS = "stresses_VVO2_segment_to_segment.png"
FILES = (*FIGURES, *(f"stresses_{code}.png" for code in CODES), SMOOTH_FIELDS, TABLE)
"""Names of all files."""


def write(found: HertzReproduction, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write pictures and the table into a folder, together or not at all.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    writers: dict[str, Callable[[Path], None]] = {}
    for name, draw in FIGURES.items():
        progress(f"drawing {name}")
        writers |= picture_writers({name: draw(found)})
    for row in hertz_figures.finest_rows(found):
        name = f"stresses_{row.code}.png" if row.variant == "halved" else SMOOTH_FIELDS
        progress(f"drawing {name}")
        writers |= picture_writers({name: hertz_figures.fields_figure(row)})
    writers[TABLE] = lambda path: write_rows(path, found.numbers, ReproducedNumber)
    return write_together(folder, writers)


def print_summary(console: Console, found: HertzReproduction, files: list[Path]) -> None:
    """Print what is within its limits, what is not with its reason, and each configuration in a line."""
    failed = [row for row in found.rows if not row.status.converged]
    for row in failed:
        console.print(f"{row.name}, {VARIANTS[row.variant]}: {row.status.message}", style="bold red", markup=False)
    for numbers, what in (
        (
            found.forces,
            f"forces are within 0.5 % (order 2 on M3 and M4) or 1 % of {REFERENCE_FORCE} kN, penalty as printed",
        ),
        (
            found.bounded_extremes,
            "extreme stresses of VVO1 and VVO2 are within 3 %, penalty halved with each refinement",
        ),
        (found.other_extremes, "extreme stresses of the other codes are, without a bound"),
        (found.printed_extremes, "extreme stresses of all codes are with the penalty as printed, without a bound"),
        (found.exact, "numbers of segment-to-segment contact at M3 and M4 are within their limits of Hertz's theory"),
    ):
        if numbers:
            n_within = sum(number.within for number in numbers)
            style = "green" if n_within == len(numbers) else "yellow"
            console.print(f"{n_within} of {len(numbers)} {what}.", style=style, markup=False)
    for number in (*found.forces, *found.bounded_extremes, *found.exact):
        if not number.within:
            _print_outside(console, number)
    console.print("Passed." if found.passed else "Not passed.", style="bold green" if found.passed else "bold red")
    for variant in VARIANTS:
        console.print(_table(found.of(variant), variant))
    print_files(console, files, found.seconds)


def _print_outside(console: Console, number: ReproducedNumber) -> None:
    console.print(
        f"  {number.code}, {number.quantity}: {number.computed:.4g} for {number.published:.4g} "
        f"({100.0 * number.relative_difference:+.1f} %): {number.note}",
        markup=False,
        soft_wrap=True,
    )


def _table(rows: tuple[HertzRow, ...], variant: Variant) -> Table:
    shown = plain_table(
        "", title=f"{VARIANTS[variant]}; kN, cm; oscillation and difference of the pressure from Hertz's in %"
    )
    for name in (
        "unknowns",
        "force kN",
        "sigma_3",
        "tau_1",
        "von Mises",
        "oscillation",
        "difference",
        "iterations",
        "s",
    ):
        shown.add_column(name, justify="right", min_width=6 if name == "force kN" else None)
    for row in rows:
        shown.add_row(
            row.name,
            f"{row.n_unknowns}",
            f"{row.force:.2f}",
            *(f"{row.extremes[name]:.1f}" for name in ("principal_3", "in_plane_shear", "von_mises")),
            f"{100.0 * row.pressure.oscillation:.2f}",
            f"{100.0 * row.pressure_difference:.2f}",
            f"{sum(row.iterations)}",
            f"{sum(row.timings_s.values()):.1f}",
        )
    return shown
