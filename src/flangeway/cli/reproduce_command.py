"""``flangeway reproduce``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import DONE, FAILED, Out, errors_as_exit_status, path_given, progress_shown, stdout
from flangeway.errors import InputError

ReproductionName = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="torsion, elasticity, hertz, contact-patch, wheel-rail, spatial, rolling, wheelset3d or "
        "conicity; all: every one, summarised.",
    ),
]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="Leave out what takes minutes: Hertz's finest mesh, the search for the flange root."),
]
Page = Annotated[
    Path | None,
    typer.Option(
        "--page",
        metavar="FILE.md",
        help="Write the page of validation with its pictures in images/ beside it; for all.",
        show_default=False,
        parser=path_given,
    ),
]


@app.command()
def reproduce(name: ReproductionName, quick: Quick = False, page: Page = None, out: Out = None) -> None:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    with errors_as_exit_status():
        from flangeway.validation.registry import REPRODUCTIONS  # noqa: PLC0415
        from flangeway.validation.reproduction import (  # noqa: PLC0415
            Verdict,
            check_page,
            find_reproductions,
            make_section,
            print_verdicts,
            write_page,
        )

        folder = out or Path("out", "reproduce")
        wanted = find_reproductions(name, REPRODUCTIONS)
        for key, reproduction in wanted.items():
            reproduction.check_folder(folder / key)
        if page is not None:
            if len(wanted) < len(REPRODUCTIONS):
                raise InputError(f"--page with {name}", "a page of all", f"flangeway reproduce all --page {page}")
            check_page(page, [reproduction.chapter for reproduction in wanted.values()])
        verdicts, sections = {}, []
        for key, reproduction in wanted.items():
            with progress_shown() as progress:
                found = reproduction.compute(quick=quick and not reproduction.brief, progress=progress)
                files = reproduction.write(found, folder / key, progress)
                if page is not None:
                    sections.append(make_section(reproduction.chapter, found, page))
            reproduction.print_summary(stdout(), found, files)
            verdicts[key] = Verdict.of(found)
        if page is not None:
            stdout().print(f"Page: {write_page(page, sections, quick=quick)[-1]}", markup=False, soft_wrap=True)
        if len(verdicts) > 1:
            print_verdicts(stdout(), verdicts)
        raise typer.Exit(DONE if all(verdict.passed for verdict in verdicts.values()) else FAILED)
