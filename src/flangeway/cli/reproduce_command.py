"""``flangeway reproduce``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    INTERRUPTED,
    Out,
    Show,
    complain,
    completion,
    path_given,
    results_folder,
    shows_results,
    stdout,
)
from flangeway.errors import InputError, MissingLibraryError

NAMES = (
    *("torsion", "elasticity", "hertz", "contact-patch", "wheel-rail", "spatial", "rolling", "wheelset3d", "conicity"),
    *("curved", "friction", "vem-contact", "forms", "damage"),
)
ALL = "all"


@app.command()
@shows_results
def reproduce(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help=f"{', '.join(NAMES)}; {ALL}: every one, summarised.",
            autocompletion=completion(lambda: [*NAMES, ALL]),
        ),
    ],
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="Leave out what takes minutes: Hertz's finest mesh, the search for the flange root."
        ),
    ] = False,
    page: Annotated[
        Path | None,
        typer.Option(
            "--page",
            metavar="FILE.md",
            help="Write what is computed as a page of validation, with all its numbers in FILE.csv.",
            parser=path_given,
        ),
    ] = None,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    from flangeway.records import closest  # noqa: PLC0415
    from flangeway.system.output_folder import refuse_unwritable  # noqa: PLC0415

    try:
        from flangeway_studies.page import print_verdicts, write_page  # noqa: PLC0415
        from flangeway_studies.registry import STUDIES  # noqa: PLC0415
        from flangeway_studies.study import Computed  # noqa: PLC0415
    except ModuleNotFoundError as reason:
        if reason.name != "flangeway_studies":
            raise
        raise MissingLibraryError(
            "the published studies are the package flangeway-studies, which is not installed\n"
            "  what to do: pip install flangeway-studies; in a checkout of flangeway: pip install ./studies"
        ) from reason

    names = [*STUDIES, ALL]
    if name not in names:
        raise InputError(f"a reproduction called {name!r}", f"one of: {', '.join(names)}", closest(name, names))
    folder = results_folder(out, "reproduce")
    wanted = list(STUDIES.values()) if name == ALL else [STUDIES[name]]
    for study in wanted:
        results_folder(folder / study.name, study.name)
    if page is not None:
        refuse_unwritable(page.parent, (page.name, page.with_suffix(".csv").name))
    options = " --quick" * quick
    computed: dict[str, Computed] = {}
    summaries = {}
    for study in wanted:
        try:
            with show.progress() as progress:
                done = study.compute(quick=quick, progress=progress)
        except KeyboardInterrupt:
            if not computed:
                raise
            complain(f"interrupted during {study.name}; written are {', '.join(computed)}")
            raise typer.Exit(INTERRUPTED) from None
        record = done.record(f"flangeway reproduce {study.name}{options}")
        show.record(record, folder / study.name, last=False)
        computed[study.name], summaries[study.name] = done, record.summary
    if page is not None:
        command = f"flangeway reproduce {name}{options} --page {page.as_posix()}"
        show.files(write_page(page, list(computed.values()), command, quick=quick)[-1:])
    if name == ALL and not show.as_json:
        print_verdicts(stdout(), computed)
    show.json(summaries if name == ALL else summaries[name])
    return all(done.passed for done in computed.values())
