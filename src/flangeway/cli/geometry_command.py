"""``flangeway geometry``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from flangeway.cli.app import app
from flangeway.cli.common import DONE, FAILED, Out, errors_as_exit_status, progress_shown, settings_of, stdout
from flangeway.system.file_content import is_file

GeometryName = Annotated[
    str,
    typer.Argument(
        metavar="[CASE_OR_FILE]",
        help="wheelset-tangent, wheelset-curve, or s1002-60e1; a case file of a wheelset (.toml); or a file of two "
        "columns, lateral displacement and rolling radius difference, for its conicity.",
    ),
]
GeometrySet = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="An input, as often as needed: rail, wheel, gauge_mm, lateral_force_kN, maximum_lateral_mm, ...; a wrong "
        "key lists all.",
    ),
]


@app.command()
def geometry(case: GeometryName = "wheelset-tangent", set_: GeometrySet = None, out: Out = None) -> None:
    """Contact geometry of a rigid wheelset: locus, rolling radii, conicity, equilibrium (out/geometry-CASE)."""
    with errors_as_exit_status():
        settings = settings_of(set_, "a wrong key lists the right ones")
        file = Path(case)
        is_toml = file.suffix.lower() == ".toml"
        if not is_toml and (file.suffix or is_file(file)):
            _conicity(file, settings, out)
            return
        from flangeway.cases.rigid.rigid_case import find_geometry_case, read_geometry_case  # noqa: PLC0415
        from flangeway.cases.rigid.rigid_run import run_geometry  # noqa: PLC0415
        from flangeway.report.rigid.rigid_outputs import NAMES, print_geometry, write_geometry  # noqa: PLC0415
        from flangeway.system.output_folder import refuse_unwritable  # noqa: PLC0415

        inputs, notices = read_geometry_case(file, settings) if is_toml else (find_geometry_case(case, settings), ())
        inputs.load()
        name = file.stem if is_toml else case
        folder = out or Path("out", f"geometry-{name}")
        refuse_unwritable(folder, NAMES)
        with progress_shown() as progress:
            done = run_geometry(name, inputs, progress, notices)
            files = write_geometry(done, folder, progress)
        print_geometry(stdout(), done.summary, files)
        raise typer.Exit(DONE if done.equilibrium.status.converged else FAILED)


def _conicity(file: Path, settings: dict[str, Any], out: Path | None) -> None:
    """Conicity of a rolling radius difference from a file."""
    from flangeway.cases.rigid.conicities import run_conicity  # noqa: PLC0415
    from flangeway.report.rigid.rigid_outputs import CONICITY_NAMES, print_conicity, write_conicity  # noqa: PLC0415
    from flangeway.system.output_folder import refuse_unwritable  # noqa: PLC0415

    done = run_conicity(file, settings)
    folder = out or Path("out", f"geometry-{file.stem}")
    refuse_unwritable(folder, CONICITY_NAMES)
    with progress_shown() as progress:
        files = write_conicity(done, folder, progress)
    print_conicity(stdout(), done.summary, files)
