"""``flangeway run``, ``converge`` and ``cases``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flangeway.cli.app import app
from flangeway.cli.common import DONE, FAILED, Out, errors_as_exit_status, progress_shown, settings_of, stdout

if TYPE_CHECKING:
    from flangeway.study import WheelsetCase

CaseName = Annotated[str, typer.Argument(metavar="CASE", help="Name of a case; `flangeway cases` lists them.")]
# text, not numbers or choices: the case checks all values, with one kind of message
Method = Annotated[
    str | None,
    typer.Option("--method", metavar="[fem|vem]", help="Triangles, or polygons with virtual elements."),
]
CaseOrder = Annotated[
    str | None, typer.Option("--order", metavar="[1|2]", help="Order of the elements of a case.", show_default=False)
]
SizeScale = Annotated[
    str | None,
    typer.Option("--size-scale", metavar="NUMBER", help="Factor on all element sizes; 0.5 halves them."),
]
Primary = Annotated[
    str | None,
    typer.Option("--primary", metavar="[auto|rail|wheel]", help="Bodies that give the segments of contact."),
]
Crown = Annotated[
    str | None,
    typer.Option("--crown-radius", metavar="[8|10|14]", help="Radius of the rail's crown in inches."),
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Any other input of the case, as often as needed."),
]


@app.command()
def run(
    case: CaseName,
    method: Method = None,
    order: CaseOrder = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case: summary on the terminal; JSON, report, picture and ParaView files in a folder (out/CASE)."""
    with errors_as_exit_status():
        inputs = _case(case, method, order, size_scale, primary, crown_radius, set_)
        from flangeway.report import check_folder, write_outputs  # noqa: PLC0415
        from flangeway.report.terminal import print_summary  # noqa: PLC0415
        from flangeway.study import run_case  # noqa: PLC0415

        folder = out or Path("out", case)
        check_folder(folder)
        with progress_shown() as progress:
            done = run_case(inputs, progress)
            files = write_outputs(done, folder, progress)
        print_summary(stdout(), done.summary, files)
        raise typer.Exit(DONE if done.result.status.converged else FAILED)


@app.command()
def converge(
    case: CaseName,
    method: Method = None,
    order: CaseOrder = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case with its mesh and with the mesh halved, and compare (out/CASE-converge/converge.json)."""
    with errors_as_exit_status():
        inputs = _case(case, method, order, size_scale, primary, crown_radius, set_)
        from flangeway.report.terminal import print_convergence  # noqa: PLC0415
        from flangeway.study import (  # noqa: PLC0415
            refuse_unwritable,
            run_halved,
            write_summary,
            write_together,
        )

        folder, name = out or Path("out", f"{case}-converge"), "converge.json"
        refuse_unwritable(folder, (name,))
        with progress_shown() as progress:
            found = run_halved(inputs, progress)
        file = write_together(folder, {name: lambda path: write_summary(path, found.to_json())})[0]
        print_convergence(stdout(), found, file)
        raise typer.Exit(DONE if found.within else FAILED)


@app.command()
def cases() -> None:
    """List the cases and their inputs, with defaults and what is allowed."""
    from rich.table import Column, Table  # noqa: PLC0415

    from flangeway.study import CASES  # noqa: PLC0415

    console = stdout()
    for name, case in CASES.items():
        console.print(f"{name}: {case.title}", style="bold", markup=False)
        table = Table(Column("key", no_wrap=True), "default", "allowed", "meaning", box=None, pad_edge=False)
        for row in case.inputs():
            table.add_row(*row)
        console.print(table)


def _case(
    name: str,
    method: str | None,
    order: str | None,
    size_scale: str | None,
    primary: str | None,
    crown_radius: str | None,
    settings: list[str] | None,
) -> "WheelsetCase":
    """Return the case with what the options say, checked as far as possible before computing."""
    from flangeway.study import find_case  # noqa: PLC0415

    values = {
        "method": method,
        "order": order,
        "size_scale": size_scale,
        "primary": primary,
        "crown_radius_in": crown_radius,
    }
    given: dict[str, Any] = {key: value for key, value in values.items() if value is not None}
    given |= settings_of(settings, f"`flangeway cases` lists the keys of {name}")
    case = find_case(name).from_values(given)
    case.problem()
    return case
