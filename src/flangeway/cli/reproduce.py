"""``flangeway reproduce``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import DONE, FAILED, Out, Quick, errors_as_exit_status, progress_shown, stdout

ReproductionName = Annotated[
    str, typer.Argument(metavar="NAME", help="torsion: Tables 4 to 7; elasticity: chapter 5; all: every one.")
]


@app.command()
def reproduce(
    name: ReproductionName,
    quick: Quick = False,
    out: Out = None,
) -> None:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    with errors_as_exit_status():
        from flangeway.report.reproductions import REPRODUCTIONS, find_reproductions  # noqa: PLC0415

        folder = out or Path("out", "reproduce")
        wanted = find_reproductions(name, REPRODUCTIONS)
        for key, reproduction in wanted.items():
            reproduction.check_folder(folder / key)
        passed = True
        for key, reproduction in wanted.items():
            with progress_shown() as progress:
                found = reproduction.compute(quick=quick, progress=progress)
                files = reproduction.write(found, folder / key, progress)
            reproduction.print_summary(stdout(), found, files)
            passed = passed and found.passed
        raise typer.Exit(DONE if passed else FAILED)
