"""``flangeway reproduce``."""

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import INTERRUPTED, Out, Show, complain, completion, path_given, shows_results, stdout
from flangeway.errors import InputError

NAMES = (
    *("torsion", "elasticity", "hertz", "contact-patch", "wheel-rail", "spatial", "rolling", "wheelset3d", "conicity"),
    *("curved", "friction", "vem-contact"),
)
ReproductionName = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help=f"{', '.join(NAMES)}; all: every one, summarised.",
        autocompletion=completion(lambda: [*NAMES, "all"]),
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
        help="Write the page of validation, with all numbers in FILE.csv; of one NAME: its chapter of a page.",
        show_default=False,
        parser=path_given,
    ),
]


@app.command()
@shows_results
def reproduce(name: ReproductionName, quick: Quick = False, page: Page = None, out: Out = None, *, show: Show) -> bool:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    _find_studies()
    from studies.registry import REPRODUCTIONS  # noqa: PLC0415
    from studies.reproduction import (  # noqa: PLC0415
        Verdict,
        check_page,
        find_reproductions,
        make_section,
        print_verdicts,
        replace_chapters,
        write_page,
    )

    folder = out or Path("out", "reproduce")
    wanted = find_reproductions(name, REPRODUCTIONS)
    for key, reproduction in wanted.items():
        reproduction.check_folder(folder / key)
    if page is not None:
        if len(wanted) < len(REPRODUCTIONS) and not page.is_file():
            raise InputError(
                f"--page {page} with {name}, a page that does not exist",
                "a page of all, whose chapter is replaced",
                f"flangeway reproduce all --page {page}",
            )
        check_page(page)
    verdicts: dict[str, Verdict] = {}
    sections, summaries = [], {}
    for key, reproduction in wanted.items():
        try:
            with show.progress() as progress:
                found = reproduction.compute(quick=quick and not reproduction.brief, progress=progress)
        except KeyboardInterrupt:
            if not verdicts:
                raise
            complain(f"interrupted during {key}; written are {', '.join(verdicts)}")
            raise typer.Exit(INTERRUPTED) from None
        record = reproduction.record(key, found, f"flangeway reproduce {key}{' --quick' * quick}")
        show.record(record, folder / key, last=False)
        if page is not None:
            sections.append(make_section(reproduction.chapter, found))
        verdicts[key], summaries[key] = Verdict.of(found), record.summary
    if page is not None:
        every = len(wanted) == len(REPRODUCTIONS)
        show.files((write_page(page, sections, quick=quick) if every else replace_chapters(page, sections))[-1:])
    if len(verdicts) > 1 and not show.as_json:
        print_verdicts(stdout(), verdicts)
    show.json(summaries if len(summaries) > 1 else summaries[name])
    return all(verdict.passed for verdict in verdicts.values())


def _find_studies() -> None:
    """Make the package `studies` importable from the checkout if flangeway is run from its sources.

    A wheel has it beside the package. It is an `InputError` if there is none.
    """
    root = Path(__file__).parents[3]
    if (root / "studies" / "registry.py").is_file() and str(root) not in sys.path:
        sys.path.insert(0, str(root))
    if find_spec("studies") is None or find_spec("studies.registry") is None:
        raise InputError(
            f"no folder of studies in {root}",
            "a checkout of flangeway or an installation from its wheel, both of which have the folder `studies`",
            "install flangeway again from its wheel",
        )
