"""All files of ``flangeway reproduce torsion``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table

from flangeway.report.figures.picture_files import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.system.output_folder import write_together
from flangeway.validation.published_numbers import ReproducedNumber, write_rows
from flangeway.validation.torsion.torsion_figures import convergence_figure, fields_figure
from flangeway.validation.torsion.torsion_reproduced import LIMITS, ReproducedRate, TorsionReproduction

TABLE, RATES = "table.csv", "rates.csv"
PICTURES = ("convergence_h.png", "convergence_unknowns.png", "warping.png", "prandtl.png")
FILES = (*PICTURES, RATES, TABLE)
"""Names of all files."""


def write(found: TorsionReproduction, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write pictures and tables into a folder, together or not at all; no rates if none were computed.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    progress("drawing the pictures")
    figures = (
        convergence_figure(found, "h"),
        convergence_figure(found, "n_dof"),
        fields_figure(found, "warping"),
        fields_figure(found, "prandtl"),
    )
    writers = picture_writers(dict(zip(PICTURES, figures, strict=True)))
    if found.rates:
        writers[RATES] = lambda path: write_rows(path, found.rates, ReproducedRate)
    writers[TABLE] = lambda path: write_rows(path, found.numbers, ReproducedNumber)
    return write_together(folder, writers)


def print_summary(console: Console, found: TorsionReproduction, files: list[Path]) -> None:
    """Print how many errors are within the limit, those that are not with their reason, and the rates."""
    limit = 100.0 * LIMITS["relative_error"]
    console.print(
        f"{found.n_within} of {len(found.errors)} errors of the torsion constant are within {limit:g} % of the "
        "published ones.",
        style="bold green" if found.passed else "bold red",
        markup=False,
    )
    for row in found.errors:
        if not row.within:
            console.print(
                f"  table {row.table}, {row.code}: {row.computed:.3g} for {row.published:.3g} "
                f"({100.0 * row.relative_difference:+.0f} %): {row.note}",
                markup=False,
                soft_wrap=True,
            )
    if found.rates:
        console.print(_rates_table(found))
    print_files(console, files, found.seconds)


def _rates_table(found: TorsionReproduction) -> Table:
    shown = plain_table("rates over unknowns")
    for name in ("theory", "published", "computed", "over h: published", "computed"):
        shown.add_column(name, justify="right")
    for rate in found.rates:
        shown.add_row(
            f"table {rate.table}, {rate.code}",
            f"{rate.expected}",
            *(f"{v:.2f}" for v in (rate.published, rate.computed, rate.published_over_h, rate.computed_over_h)),
            style=None if rate.within else "red",
        )
    return shown
