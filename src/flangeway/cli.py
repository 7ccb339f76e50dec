"""The command line.

Exit status 0: done; 1: not converged, a check failed, or a library is missing; 2: the input is wrong; 130: interrupted.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from flangeway.errors import InputError, MissingLibraryError

# numpy, scipy, matplotlib and what needs them are imported inside functions, so that help is quick
if TYPE_CHECKING:
    from flangeway.study import WheelsetTangentCase

Progress = Callable[[str], None]

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

app = typer.Typer(
    help="Elastic contact in two dimensions with finite and virtual elements, up to a wheelset on two rails.",
    add_completion=False,
    pretty_exceptions_enable=False,
)

CaseName = Annotated[str, typer.Argument(metavar="CASE", help="Name of a case; `flangeway cases` lists them.")]
# text, not numbers or choices: the case checks all values, with one kind of message
Method = Annotated[
    str | None,
    typer.Option("--method", metavar="[fem|vem]", help="Triangles, or polygons with virtual elements."),
]
SizeScale = Annotated[
    str | None,
    typer.Option("--size-scale", metavar="NUMBER", help="Factor on all element sizes; 0.5 halves them."),
]
Primary = Annotated[
    str | None,
    typer.Option("--primary", metavar="[rail|wheel]", help="Bodies that give the segments of contact."),
]
Crown = Annotated[
    str | None,
    typer.Option("--crown-radius", metavar="[8|10|14]", help="Radius of the rail's crown in inches."),
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Any other input of the case, as often as needed."),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for the results.", show_default=False),
]

SectionName = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FILE", help="136RE, 136RE-8, 136RE-14, 60E1, or an outline in a .toml, .csv or .dxf file."
    ),
]
SectionSize = Annotated[
    float | None,
    typer.Option("--size", metavar="LENGTH", help="Element size in the outline's unit.", show_default=False),
]
SectionOrder = Annotated[int, typer.Option("--order", metavar="K", help="Order of the elements.")]
SectionMethod = Annotated[str, typer.Option("--method", metavar="[fem|vem]", help="Triangles, or virtual polygons.")]
SectionPoisson = Annotated[
    float | None,
    typer.Option(
        "--poisson", metavar="NU", help="Poisson's ratio for the shear centre; 0 if left out.", show_default=False
    ),
]
SectionUnit = Annotated[
    str | None,
    typer.Option("--unit", metavar="[mm|cm|m|in|ft]", help="Unit of a file that names none.", show_default=False),
]
SectionMirror = Annotated[bool, typer.Option("--mirror", help="The CSV file holds one half, up to x = 0.")]
ReproductionName = Annotated[str, typer.Argument(metavar="NAME", help="torsion: Tables 4 to 7.")]
Quick = Annotated[bool, typer.Option("--quick", help="Compute the coarser half of the meshes only.")]


def _show_version(wanted: bool) -> None:
    if wanted:
        from flangeway.study.versions import versions  # noqa: PLC0415

        typer.echo(f"flangeway {versions()['flangeway']}")
        raise typer.Exit(DONE)


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version),
    ] = False,
) -> None:
    pass


@app.command()
def run(
    case: CaseName,
    method: Method = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case: summary on the terminal; JSON, report, picture and ParaView files in a folder (out/CASE)."""
    with _errors_as_exit_status():
        inputs = _case(case, method, size_scale, primary, crown_radius, set_)
        from flangeway.report import check_folder, write_outputs  # noqa: PLC0415
        from flangeway.report.terminal import print_summary  # noqa: PLC0415
        from flangeway.study import run_case  # noqa: PLC0415

        folder = out or Path("out", case)
        check_folder(folder)
        with _progress() as progress:
            done = run_case(inputs, progress)
            files = write_outputs(done, folder, progress)
        print_summary(_stdout(), done.summary, files)
        raise typer.Exit(DONE if done.result.status.converged else FAILED)


@app.command()
def converge(
    case: CaseName,
    method: Method = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case with its mesh and with the mesh halved, and compare (out/CASE-converge/converge.json)."""
    with _errors_as_exit_status():
        inputs = _case(case, method, size_scale, primary, crown_radius, set_)
        from flangeway.report.terminal import print_convergence  # noqa: PLC0415
        from flangeway.study import (  # noqa: PLC0415
            refuse_unwritable,
            run_halved,
            write_summary,
            write_together,
        )

        folder, name = out or Path("out", f"{case}-converge"), "converge.json"
        refuse_unwritable(folder, (name,))
        with _progress() as progress:
            found = run_halved(inputs, progress)
        file = write_together(folder, {name: lambda path: write_summary(path, found.to_json())})[0]
        print_convergence(_stdout(), found, file)
        raise typer.Exit(DONE if found.within else FAILED)


@app.command()
def section(
    name_or_file: SectionName,
    size: SectionSize = None,
    order: SectionOrder = 2,
    method: SectionMethod = "fem",
    poisson: SectionPoisson = None,
    unit: SectionUnit = None,
    mirror: SectionMirror = False,
    out: Out = None,
) -> None:
    """Compute the constants of a cross-section; JSON, pictures and a VTU file in a folder (out/section-NAME)."""
    with _errors_as_exit_status():
        from flangeway.report.section_outputs import (  # noqa: PLC0415
            check_section_folder,
            print_section,
            write_section,
        )
        from flangeway.study.section import SectionOptions, find_section, run_section  # noqa: PLC0415

        drawn = find_section(name_or_file, unit=unit, mirrored=mirror)
        options = SectionOptions(size, order, method, poisson)
        folder = out or Path("out", f"section-{Path(name_or_file).stem}")
        check_section_folder(folder)
        with _progress() as progress:
            done = run_section(drawn, options, progress)
            files = write_section(done, folder, progress)
        print_section(_stdout(), done.summary, files)


@app.command()
def reproduce(
    name: ReproductionName,
    quick: Quick = False,
    out: Out = None,
) -> None:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    with _errors_as_exit_status():
        from flangeway.report.reproduction import (  # noqa: PLC0415
            check_reproduction_folder,
            print_torsion,
            write_torsion,
        )
        from flangeway.study.reproduce import refuse_unknown_reproduction, reproduce_torsion  # noqa: PLC0415

        refuse_unknown_reproduction(name)
        folder = (out or Path("out", "reproduce")) / name
        check_reproduction_folder(folder)
        with _progress() as progress:
            found = reproduce_torsion(quick=quick, progress=progress)
            files = write_torsion(found, folder, progress)
        print_torsion(_stdout(), found, files)
        raise typer.Exit(DONE if found.passed else FAILED)


@app.command()
def cases() -> None:
    """List the cases and their inputs, with defaults and what is allowed."""
    from rich.table import Table  # noqa: PLC0415

    from flangeway.study import CASES  # noqa: PLC0415

    console = _stdout()
    for name, case in CASES.items():
        console.print(f"{name}: {case.title}", style="bold", markup=False)
        table = Table("key", "default", "allowed", "meaning", box=None, pad_edge=False)
        for row in case.inputs():
            table.add_row(*row)
        console.print(table)


def main() -> None:
    """Run the command line and exit with its status."""
    # the class is typer's own or click's, as typer's version wants it
    usage_error = cast(type[Exception], typer.BadParameter.__base__)
    try:
        status = app(prog_name="flangeway", standalone_mode=False)
    except usage_error as error:
        _complain(_usage_message(error))
        status = WRONG_INPUT
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    sys.exit(status or DONE)


def _case(
    name: str,
    method: str | None,
    size_scale: str | None,
    primary: str | None,
    crown_radius: str | None,
    settings: list[str] | None,
) -> "WheelsetTangentCase":
    """Return the case with what the options say, checked as far as possible before computing."""
    from flangeway.study import find_case  # noqa: PLC0415

    values = {
        "method": method,
        "size_scale": size_scale,
        "primary": primary,
        "crown_radius_in": crown_radius,
    }
    given: dict[str, Any] = {key: value for key, value in values.items() if value is not None}
    for setting in settings or []:
        key, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}", "--set KEY=VALUE", f"`flangeway cases` lists the keys of {name}")
        given[key.strip()] = value.strip()
    case = find_case(name).from_values(given)
    case.problem()
    return case


@contextmanager
def _errors_as_exit_status() -> Iterator[None]:
    """Turn the errors that users can meet into a message and an exit status."""
    try:
        yield
    except InputError as error:
        _complain(str(error))
        raise typer.Exit(WRONG_INPUT) from None
    except MissingLibraryError as error:
        _complain(str(error))
        raise typer.Exit(FAILED) from None
    except KeyboardInterrupt:
        _complain("interrupted; nothing was written")
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def _progress() -> Iterator[Progress]:
    """Show sentences on stderr: one changing line on a terminal, a line each elsewhere."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress as Bar  # noqa: PLC0415
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda sentence: print(sentence, file=sys.stderr, flush=True)
        return
    columns = (SpinnerColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda sentence: bar.update(task, description=sentence)


def _stdout() -> Any:
    from rich.console import Console  # noqa: PLC0415

    return Console(highlight=False)


def _complain(message: str) -> None:
    typer.echo(f"flangeway: {message}", err=True)


def _usage_message(error: Any) -> str:
    """Return a usage error in the three parts of all messages."""
    given, context = error.format_message().rstrip("."), error.ctx
    if context is None:
        return str(given)
    command = context.command
    words = [*getattr(command, "commands", {})] or command.collect_usage_pieces(context)[1:]
    options = [name for parameter in command.params for name in parameter.opts if name[0] == "-"]
    known = ", ".join([*(word.strip("{}") for word in words), *options, "--help"])
    return str(InputError(given, known, f"`{context.command_path} --help` explains them"))
