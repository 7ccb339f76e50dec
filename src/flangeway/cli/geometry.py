"""``flangeway geometry``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import DONE, FAILED, Out, errors_as_exit_status, progress_shown, settings_of, stdout

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


@app.command()
def geometry(case: GeometryName = "wheelset-tangent", set_: GeometrySet = None, out: Out = None) -> None:
    """Contact geometry of a rigid wheelset: locus, rolling radii, equivalent conicity, balance (out/geometry-CASE)."""
    with errors_as_exit_status():
        from flangeway.report.rigid_outputs import NAMES, print_geometry, write_geometry  # noqa: PLC0415
        from flangeway.study import refuse_unwritable  # noqa: PLC0415
        from flangeway.study.rigid import run_geometry  # noqa: PLC0415
        from flangeway.study.rigid_case import find_geometry_case  # noqa: PLC0415

        inputs = find_geometry_case(case, settings_of(set_, "a wrong key lists the right ones"))
        inputs.load()
        inputs.curves()
        folder = out or Path("out", f"geometry-{case}")
        refuse_unwritable(folder, NAMES)
        with progress_shown() as progress:
            done = run_geometry(case, inputs, progress)
            files = write_geometry(done, folder, progress)
        print_geometry(stdout(), done.summary, files)
        raise typer.Exit(DONE if done.equilibrium.status.converged else FAILED)
