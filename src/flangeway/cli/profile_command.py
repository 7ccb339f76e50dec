"""``flangeway profile``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import Out, Unit, errors_as_exit_status, path_given, progress_shown, stdout

ProfileName = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FILE",
        help="136RE, 136RE-8, 136RE-14, 60E1, AAR-1B, S1002, heavy-haul, or a .ban, .whl, .prr, .prw, .csv, .txt, .dat "
        "or .dxf file.",
    ),
]
ProfileKind = Annotated[
    str | None, typer.Option("--kind", metavar="[rail|wheel]", help="Kind of profile in the file.", show_default=False)
]
ProfileMirror = Annotated[bool, typer.Option("--mirror", help="Reverse the first coordinate: a left-hand rail.")]
ProfileFlip = Annotated[bool, typer.Option("--flip", help="Reverse the second coordinate.")]
ProfileOrigin = Annotated[
    str | None,
    typer.Option(
        "--origin",
        metavar="[top|base|gauge|tape|flange-back|X,Y]",
        help="Position of the file's (0, 0); or X,Y, the position of a rail's top or a wheel's tread in the file.",
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
    typer.Option("--limit", metavar="UM", help="Maximum displacement of a point by smoothing.", show_default=False),
]
ProfileDrop = Annotated[bool, typer.Option("--drop-outliers", help="Leave out single points off the curve.")]
ProfileJoin = Annotated[
    str | None,
    typer.Option("--join", metavar="NAME", help="Bundled rail or wheel that gives the body.", show_default=False),
]
ProfileTo = Annotated[
    Path | None,
    typer.Option(
        "--to",
        metavar="FILE",
        help="Write it in the format of this file's ending.",
        show_default=False,
        parser=path_given,
    ),
]


@app.command()
def profile(
    name_or_file: ProfileName,
    unit: Unit = None,
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
    with errors_as_exit_status():
        from flangeway.cases.profile.profile_run import run_profile  # noqa: PLC0415
        from flangeway.railway.profiles.profile_file import ReadOptions  # noqa: PLC0415
        from flangeway.report.profile.profile_outputs import (  # noqa: PLC0415
            check_profile_folder,
            print_profile,
            refuse_conversion,
            write_profile,
        )

        options = ReadOptions(unit, kind, mirror, flip, origin, tape, smooth, limit, drop_outliers)
        done = run_profile(name_or_file, options, join)
        refuse_conversion(done, to)
        folder = out or Path("out", f"profile-{Path(name_or_file).stem}")
        check_profile_folder(folder, to)
        with progress_shown() as progress:
            files = write_profile(done, folder, to, progress)
        print_profile(stdout(), done.summary, files)
