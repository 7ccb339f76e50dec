"""All files of ``flangeway reproduce elasticity``, and its summary on the terminal."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from flangeway.report.figures.picture_files import picture_writers
from flangeway.report.page.console import plain_table, print_files
from flangeway.system.output_folder import write_together
from flangeway.validation.elasticity.elasticity_figures import (
    cook_convergence_figure,
    cook_deformed_figure,
    cook_stress_figure,
    incompressible_figure,
    patch_figure,
)
from flangeway.validation.elasticity.elasticity_reproduced import COOK, ElasticityReproduction, IncompressibleRow
from flangeway.validation.elasticity.refinement_figures import (
    adaptive_meshes_figure,
    estimate_figure,
    refinement_convergence_figure,
)
from flangeway.validation.published_numbers import ReproducedNumber, write_rows

FIGURES = {
    "patch_test.png": patch_figure,
    "cook_convergence.png": cook_convergence_figure,
    "cook_stresses.png": cook_stress_figure,
    "cook_deformed.png": cook_deformed_figure,
    "nearly_incompressible.png": incompressible_figure,
    "error_estimate.png": estimate_figure,
    "adaptive_meshes.png": adaptive_meshes_figure,
    "refinement.png": refinement_convergence_figure,
}
TABLE, INCOMPRESSIBLE, REFINEMENT = "table.csv", "nearly_incompressible.csv", "refinement.csv"
FILES = (*FIGURES, INCOMPRESSIBLE, REFINEMENT, TABLE)
"""Names of all files."""


@dataclass(frozen=True)
class RefinementLine:
    """A row of ``refinement.csv``.

    Parameters
    ----------
    body, order, refinement
        What is refined, with which order, and how.
    n_cells, n_unknowns
        Size of the mesh.
    error, estimated_error
        Relative errors in the energy norm, see `flangeway.post.refinement.RefinementRow`.

    """

    body: str
    order: int
    refinement: str
    n_cells: int
    n_unknowns: int
    error: float
    estimated_error: float


def write(found: ElasticityReproduction, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write pictures and tables into a folder, together or not at all.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    writers: dict[str, Callable[[Path], None]] = {}
    for name, draw in FIGURES.items():
        progress(f"drawing {name}")
        writers |= picture_writers({name: draw(found)})
    writers[INCOMPRESSIBLE] = lambda path: write_rows(path, found.incompressible_rows, IncompressibleRow)
    writers[REFINEMENT] = lambda path: write_rows(path, list(_refinement_lines(found)), RefinementLine)
    writers[TABLE] = lambda path: write_rows(path, found.numbers, ReproducedNumber)
    return write_together(folder, writers)


def _refinement_lines(found: ElasticityReproduction) -> Iterator[RefinementLine]:
    for case in found.refinements:
        for row in (*case.uniform, *case.adaptive):
            yield RefinementLine(
                case.body, case.order, row.refinement, row.mesh.n_cells, row.n_unknowns, row.error, row.estimated_error
            )


def print_summary(console: Console, found: ElasticityReproduction, files: list[Path]) -> None:
    """Print how many numbers are within their limits, those that are not, and the tables in short."""
    n_within = sum(number.within for number in found.numbers)
    console.print(
        f"{n_within} of {len(found.numbers)} numbers of plane elasticity are within their limits.",
        style="bold green" if found.passed else "bold red",
        markup=False,
    )
    for number in found.numbers:
        if not number.within:
            console.print(
                f"  {number.table}, {number.code}, {number.quantity}: {number.computed:.6g} for {number.published:.6g} "
                f"({100.0 * number.relative_difference:+.2g} %): {number.note}",
                markup=False,
                soft_wrap=True,
            )
    worst = max(row.stress_error for row in found.patch)
    console.print(
        f"Patch test: {len(found.patch)} configurations, stresses wrong by {worst:.0e} of the tension at most."
    )
    console.print(_cook_table(found))
    console.print(_locking(found), markup=False, soft_wrap=True)
    for case in found.refinements:
        console.print(_saving(case.body, case.order, case.saving), markup=False, soft_wrap=True)
    print_files(console, files, found.seconds)


def _cook_table(found: ElasticityReproduction) -> Table:
    shown = plain_table("Cook's membrane")
    for name in ("unknowns", "energy", "uy (48, 52)", "uy (48, 60)", "work at ν = 0.4999"):
        shown.add_column(name, justify="right")
    numbers = {(n.code, n.quantity): n for n in found.numbers if n.table == COOK}
    quantities = dict.fromkeys(n.quantity for n in numbers.values())
    for row, soft in zip(found.cook, found.incompressible_rows, strict=True):
        differences = [100.0 * numbers[str(row.code), name].relative_difference for name in quantities]
        soft_text = f"{100.0 * soft.relative_difference:+.3f} %"
        shown.add_row(str(row.code), f"{row.n_unknowns:,}", *(f"{d:+.4f} %" for d in differences), soft_text)
    return shown


def _locking(found: ElasticityReproduction) -> str:
    finest = max(row.code.level for row in found.cook)
    lacks = {
        row.code: -100.0 * row.relative_difference for row in found.incompressible_rows if f"M{finest}" in row.code
    }
    order_2 = max(abs(lack) for code, lack in lacks.items() if code.endswith("O2"))
    return (
        f"Nearly incompressible, on M{finest}: triangles of order 1 lock, they lack {lacks[f'FCM{finest}O1']:.1f} % of "
        f"the load's work; polygons of order 1 lack {lacks[f'VCM{finest}O1']:.1f} %, order 2 differs by "
        f"{order_2:.2f} % at most."
    )


def _saving(body: str, order: int, saving: float) -> str:
    name = "Cook's membrane" if body == "Cook" else "L-shaped body"
    if not saving > 0.0:
        return f"{name}, order {order}: adaptive refinement ended above the least error of uniform refinement."
    compared = f"{saving:.1f} times fewer unknowns" if saving >= 1.0 else f"{1.0 / saving:.1f} times as many unknowns"
    return f"{name}, order {order}: adaptive refinement reaches the least error of uniform refinement with {compared}."
