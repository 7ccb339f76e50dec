"""The command line.

Exit status 0: done; 1: not converged, a check failed, or a library is missing; 2: the input is wrong; 130: interrupted.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from flangeway.errors import InputError, MissingLibraryError

# dense matrices here are small: on a busy machine the threads of BLAS wait for each other longer than they compute.
# Assembly and sparse factorisation use all cores. Read by OpenBLAS when NumPy is imported; a user's own setting stays.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# numpy, scipy, matplotlib and what needs them are imported inside functions, so that help is quick
if TYPE_CHECKING:
    from flangeway.study import WheelsetCase

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
ProfileName = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FILE",
        help="136RE, 136RE-8, 136RE-14, 60E1, AAR-1B, S1002, heavy-haul, or a .ban, .whl, .prr, .prw, .csv, .txt, .dat "
        "or .dxf file.",
    ),
]
ProfileKind = Annotated[
    str | None, typer.Option("--kind", metavar="[rail|wheel]", help="What the file holds.", show_default=False)
]
ProfileMirror = Annotated[bool, typer.Option("--mirror", help="Reverse the first coordinate: a left-hand rail.")]
ProfileFlip = Annotated[bool, typer.Option("--flip", help="Reverse the second coordinate.")]
ProfileOrigin = Annotated[
    str | None,
    typer.Option(
        "--origin",
        metavar="[top|base|gauge|tape|flange-back|X,Y]",
        help="Where the file's (0, 0) lies; or X,Y, the place in it of a rail's top or a wheel's tread.",
        show_default=False,
    ),
]
ProfileTape = Annotated[
    float | None,
    typer.Option("--tape", metavar="MM", help="From the flange's back to the tape line; 70.", show_default=False),
]
ProfileSmooth = Annotated[
    float | None,
    typer.Option(
        "--smooth", metavar="MM", help="Wavelength to smooth by; 0 for none, 5 for noisy points.", show_default=False
    ),
]
ProfileLimit = Annotated[
    float | None,
    typer.Option("--limit", metavar="UM", help="Largest motion of a point by smoothing.", show_default=False),
]
ProfileDrop = Annotated[bool, typer.Option("--drop-outliers", help="Leave out single points off the curve.")]
ProfileJoin = Annotated[
    str | None,
    typer.Option("--join", metavar="NAME", help="Bundled rail or wheel that gives the body.", show_default=False),
]
ProfileTo = Annotated[
    Path | None,
    typer.Option("--to", metavar="FILE", help="Write it in the format of this file's ending.", show_default=False),
]
GeometryName = Annotated[str, typer.Argument(metavar="[CASE]", help="wheelset-tangent, wheelset-curve, or s1002-60e1.")]
GeometrySet = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="An input, as often as needed: rail, wheel, gauge_mm, lateral_force_kN, largest_lateral_mm, ...; a wrong "
        "key lists all.",
    ),
]
ReproductionName = Annotated[
    str, typer.Argument(metavar="NAME", help="torsion: Tables 4 to 7; elasticity: chapter 5; all: every one.")
]
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
    order: CaseOrder = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case: summary on the terminal; JSON, report, picture and ParaView files in a folder (out/CASE)."""
    with _errors_as_exit_status():
        inputs = _case(case, method, order, size_scale, primary, crown_radius, set_)
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
    order: CaseOrder = None,
    size_scale: SizeScale = None,
    primary: Primary = None,
    crown_radius: Crown = None,
    set_: Set = None,
    out: Out = None,
) -> None:
    """Run a case with its mesh and with the mesh halved, and compare (out/CASE-converge/converge.json)."""
    with _errors_as_exit_status():
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
def profile(
    name_or_file: ProfileName,
    unit: SectionUnit = None,
    kind: ProfileKind = None,
    mirror: ProfileMirror = False,
    flip: ProfileFlip = False,
    origin: ProfileOrigin = None,
    tape: ProfileTape = None,
    smooth: ProfileSmooth = None,
    limit: ProfileLimit = None,
    drop_outliers: ProfileDrop = False,
    join: ProfileJoin = None,
    to: ProfileTo = None,
    out: Out = None,
) -> None:
    """Read a rail or wheel profile: checks, pictures, curvature, conversion, joint to a body (out/profile-NAME)."""
    with _errors_as_exit_status():
        from flangeway.railway.profile_file import ReadOptions  # noqa: PLC0415
        from flangeway.report.profile_outputs import (  # noqa: PLC0415
            check_profile_folder,
            print_profile,
            refuse_conversion,
            write_profile,
        )
        from flangeway.study.profile import run_profile  # noqa: PLC0415

        options = ReadOptions(unit, kind, mirror, flip, origin, tape, smooth, limit, drop_outliers)
        done = run_profile(name_or_file, options, join)
        refuse_conversion(done, to)
        folder = out or Path("out", f"profile-{Path(name_or_file).stem}")
        check_profile_folder(folder, to)
        with _progress() as progress:
            files = write_profile(done, folder, to, progress)
        print_profile(_stdout(), done.summary, files)


@app.command()
def geometry(case: GeometryName = "wheelset-tangent", set_: GeometrySet = None, out: Out = None) -> None:
    """Contact geometry of a rigid wheelset: locus, rolling radii, equivalent conicity, balance (out/geometry-CASE)."""
    with _errors_as_exit_status():
        from flangeway.report.rigid_outputs import (  # noqa: PLC0415
            check_geometry_folder,
            print_geometry,
            write_geometry,
        )
        from flangeway.study.rigid import run_geometry  # noqa: PLC0415
        from flangeway.study.rigid_case import find_geometry_case  # noqa: PLC0415

        inputs = find_geometry_case(case, _settings(set_, "a wrong key lists the right ones"))
        inputs.wheelset()
        folder = out or Path("out", f"geometry-{case}")
        check_geometry_folder(folder)
        with _progress() as progress:
            done = run_geometry(case, inputs, progress)
            files = write_geometry(done, folder, progress)
        print_geometry(_stdout(), done.summary, files)
        raise typer.Exit(DONE if done.equilibrium.status.converged else FAILED)


@app.command()
def reproduce(
    name: ReproductionName,
    quick: Quick = False,
    out: Out = None,
) -> None:
    """Compute published tables again, beside the published numbers (out/reproduce/NAME/table.csv and pictures)."""
    with _errors_as_exit_status():
        from flangeway.report.reproductions import REPRODUCTIONS, find_reproductions  # noqa: PLC0415

        folder = out or Path("out", "reproduce")
        wanted = find_reproductions(name, REPRODUCTIONS)
        for key, reproduction in wanted.items():
            reproduction.check_folder(folder / key)
        passed = True
        for key, reproduction in wanted.items():
            with _progress() as progress:
                found = reproduction.compute(quick=quick, progress=progress)
                files = reproduction.write(found, folder / key, progress)
            reproduction.print_summary(_stdout(), found, files)
            passed = passed and found.passed
        raise typer.Exit(DONE if passed else FAILED)


@app.command()
def cases() -> None:
    """List the cases and their inputs, with defaults and what is allowed."""
    from rich.table import Column, Table  # noqa: PLC0415

    from flangeway.study import CASES  # noqa: PLC0415

    console = _stdout()
    for name, case in CASES.items():
        console.print(f"{name}: {case.title}", style="bold", markup=False)
        table = Table(Column("key", no_wrap=True), "default", "allowed", "meaning", box=None, pad_edge=False)
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
    given |= _settings(settings, f"`flangeway cases` lists the keys of {name}")
    case = find_case(name).from_values(given)
    case.problem()
    return case


def _settings(settings: list[str] | None, advice: str) -> dict[str, Any]:
    """Return what ``--set`` says, by key."""
    given: dict[str, Any] = {}
    for setting in settings or []:
        key, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}", "--set KEY=VALUE", advice)
        given[key.strip()] = value.strip()
    return given


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
