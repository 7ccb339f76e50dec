"""The page of validation, ``docs/validation.md``, with all numbers in a CSV file beside it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from flangeway.report.page.record import SummaryTable, plain_table
from flangeway.results import ResultTable
from flangeway.system.output_folder import text_writer, write_together
from flangeway_studies.study import COMPARED, Computed

HEAD = """# Validation

*Written by `{command}`; all numbers on this page are generated.*

Numbers computed by flangeway, compared with published numbers and with exact solutions. "Moherdaui (2021)" is T. F.
Moherdaui, *The Virtual Element Method for Wheel-Rail Contact Problems*, São Paulo, 2021. Everything is computed anew:
the cache is not used. The tables show the largest deviation of each quantity with a limit; [all numbers]({numbers})
are in a CSV file. The same command writes a report of each part, with pictures and all numbers, into `out/reproduce`,
and ends with status 1 if a part is not passed.

{extent}

A *difference* is the relative difference of the computed number from the published one, or the computed number less the
published one where the limit is a number without "%" or zero is published. A number with a *limit* must be within this
limit; one that is *shown only* has none. Round-off is shown as `< 1e-10`, a relative difference below 1e-5 as
`< 0.001 %`.
"""
WHOLE = "All meshes of all parts are computed."
QUICK = (
    "With `--quick` the finest meshes of Hertz's problem and of bars under short waves, the search for the wheel's\n"
    "flange root, further crowns, meshes and moduli of wheel and rail, and four in five positions and the elements of\n"
    "order 1 of the wheelset in three dimensions, corners with elements of other orders than 2 and two of their five\n"
    "refinements, and Cook's membrane on cells that are not convex are left out;\n"
    "without it they are computed as well."
)


def write_page(page: Path, computed: Sequence[Computed], command: str, *, quick: bool) -> list[Path]:
    """Write the page, and all its numbers as CSV beside it; return the files.

    It is an `InputError` if they cannot be written.
    """
    lines = [(done.study.template[0], *row) for done in computed for row in done.numbers().rows]
    columns = zip(("part", "quantity", "code", *COMPARED), zip(*lines, strict=True), strict=True)
    csv_name = page.with_suffix(".csv").name
    head = HEAD.format(command=command, extent=QUICK if quick else WHOLE, numbers=csv_name)
    rows = tuple(
        (done.study.template[0], *map(str, done.counts), "passed" if done.passed else "**not passed**")
        for done in computed
    )
    verdicts = SummaryTable("", ("part", "numbers with a limit", "within", "shown only", "verdict"), rows).markdown()
    text = "\n".join([head, verdicts, "", *(done.chapter for done in computed)])
    return write_together(
        page.parent, {csv_name: text_writer(ResultTable(dict(columns)).csv()), page.name: text_writer(text)}
    )


def print_verdicts(console: Console, computed: Mapping[str, Computed]) -> None:
    """Print a line for each study: numbers with a limit, those within, others, verdict and time."""
    shown = plain_table("reproduction")
    for name in ("with a limit", "within", "shown only", "verdict", "seconds"):
        shown.add_column(name, justify="right")
    for name, done in computed.items():
        word, style = ("passed", "green") if done.passed else ("not passed", "bold red")
        shown.add_row(name, *map(str, done.counts), word, f"{done.seconds:.1f}", style=style)
    console.print(shown)
