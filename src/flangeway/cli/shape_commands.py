"""``flangeway geometry``, ``section``, ``profile`` and ``live``."""

import os
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    DONE,
    PROFILE_FILES,
    PROFILES_ALONE,
    Out,
    Set,
    Show,
    Unit,
    Units,
    choices,
    command_typed,
    completion,
    errors_as_exit_status,
    geometry_names,
    path_given,
    profile_names,
    results_folder,
    section_names,
    settings_of,
    shows_results,
    stdout,
    units_given,
)
from flangeway.errors import InputError

# --- ``flangeway geometry``, ``section`` and ``profile``.


def _bundled(flag: str, meaning: str) -> Any:
    """Option that names a bundled profile."""
    return typer.Option(flag, metavar="NAME", help=meaning, autocompletion=completion(profile_names))


@app.command()
@shows_results
def geometry(
    case: Annotated[
        str,
        typer.Argument(
            metavar="[CASE_OR_FILE]",
            help="wheelset, wheelset-tangent, wheelset-curve, s1002-60e1 or en15302; a case file of a wheelset "
            "(.toml); or a file of lateral displacements and rolling radius differences, for its conicity.",
            autocompletion=completion(geometry_names, ".toml", ".csv"),
        ),
    ] = "s1002-60e1",
    set_: Set = None,
    wheel: Annotated[
        list[str] | None,
        typer.Option(
            "--wheel",
            metavar="NAME_OR_FILE",
            help="A wheel; several: one table and one picture of all pairs.",
            autocompletion=completion(lambda: profile_names("wheel"), *PROFILE_FILES),
        ),
    ] = None,
    rail: Annotated[
        list[str] | None,
        typer.Option(
            "--rail",
            metavar="NAME_OR_FILE",
            help="A rail, as often as needed.",
            autocompletion=completion(lambda: profile_names("rail"), *PROFILE_FILES),
        ),
    ] = None,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Contact geometry of a rigid wheelset: locus, rolling radii, conicity, equilibrium (out/geometry-CASE)."""
    from flangeway.system.file_content import is_file  # noqa: PLC0415

    settings = settings_of(set_, "a wrong key lists the right ones")
    file = Path(case)
    is_toml = file.suffix.lower() == ".toml"
    if file.suffix.lower() in PROFILES_ALONE:
        raise InputError(
            f"expected a case, got the profile file {case}", "a case", f"give it with --wheel or --rail: --wheel {case}"
        )
    if not is_toml and (file.suffix or is_file(file)):
        return _conicity(file, settings, out, show)
    from flangeway.cases.rigid_run import (  # noqa: PLC0415
        find_geometry_case,
        read_geometry_case,
        run_geometry,
    )
    from flangeway.report.rigid_outputs import (  # noqa: PLC0415
        geometries_record,
        geometry_record,
    )

    name = file.stem if is_toml else case
    records = []
    for pair in product(*([(key, e) for e in given] for key, given in (("wheel", wheel), ("rail", rail)) if given)):
        values = settings | dict(pair) | ({"units": show.units} if show.units else {})
        inputs, notices = read_geometry_case(file, values) if is_toml else (find_geometry_case(case, values), ())
        show = replace(show, units=show.units or inputs.units)
        records.append((inputs, notices))
    many = len(records) > 1
    folder = results_folder(out, f"geometry-{name}")
    runs = []
    with show.progress() as progress:
        for inputs, notices in records:
            runs.append(run_geometry(name, inputs, progress, notices))
    command = command_typed()
    record = geometries_record(runs, command) if many else geometry_record(runs[0], command)
    return show.record(record, folder)


def _conicity(file: Path, settings: dict[str, Any], out: Path | None, show: Show) -> bool:
    """Conicity of a rolling radius difference from a file."""
    from flangeway.cases.rigid_run import run_conicity  # noqa: PLC0415
    from flangeway.report.rigid_outputs import conicity_record  # noqa: PLC0415

    with show.progress():
        done = run_conicity(file, settings)
    folder = results_folder(out, f"geometry-{file.stem}")
    return show.record(conicity_record(done, command_typed(), show.units or "metric"), folder)


@app.command()
@shows_results
def section(
    name_or_file: Annotated[
        str,
        typer.Argument(
            metavar="NAME_OR_FILE",
            help="136RE, 136RE-8, 136RE-10, 136RE-14, 60E1, 60E2, 54E1, 49E1, or an outline in a .toml, .csv or .dxf "
            "file.",
            autocompletion=completion(section_names, ".toml", ".csv", ".dxf"),
        ),
    ],
    size: Annotated[
        float | None,
        typer.Option("--size", metavar="LENGTH", help="Element size in the outline's unit."),
    ] = None,
    order: Annotated[int, typer.Option("--order", metavar="K", help="Order of the elements.")] = 2,
    method: Annotated[
        str, typer.Option("--method", help="Triangles, or virtual polygons.", **choices("fem", "vem"))
    ] = "fem",
    poisson: Annotated[
        float | None,
        typer.Option("--poisson", metavar="NU", help="Poisson's ratio for the shear centre; 0 if left out."),
    ] = None,
    axial: Annotated[float, typer.Option("--axial", metavar="N", help="Axial force, tension positive.")] = 0.0,
    shear: Annotated[
        tuple[float, float], typer.Option("--shear", metavar="VX VY", help="Shear forces through the shear centre.")
    ] = (0.0, 0.0),
    moments: Annotated[
        tuple[float, float], typer.Option("--moments", metavar="MX MY", help="Bending moments, N times the unit.")
    ] = (0.0, 0.0),
    torque: Annotated[float, typer.Option("--torque", metavar="T", help="Torque, N times the unit.")] = 0.0,
    unit: Unit = None,
    mirror: Annotated[bool, typer.Option("--mirror", help="The CSV file contains one half, up to x = 0.")] = False,
    layer: Annotated[
        list[str] | None,
        typer.Option("--layer", metavar="NAME", help="Layer of a DXF file, shown or hidden; repeat it for several."),
    ] = None,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Compute the constants of a cross-section; report, JSON, pictures and VTU in a folder (out/section-NAME)."""
    from flangeway.cases.section_run import TorsionCase  # noqa: PLC0415
    from flangeway.report.section_page import section_record  # noqa: PLC0415

    inputs = {"section": name_or_file, "unit": unit, "half": mirror, "layers": layer or []}
    mesh = {"method": method, "order": order, "size": size, "poisson": poisson}
    forces = {"axial_N": axial, "shear_N": shear, "moments": moments, "torque": torque}
    case = TorsionCase.from_values({**inputs, **mesh, **forces, "units": show.units or "metric"})
    case.check()
    folder = results_folder(out, f"section-{Path(name_or_file).stem}")
    with show.progress() as progress:
        done = case.run(progress)
    show.record(section_record(done, command_typed()), folder)
    return True


@app.command()
@shows_results
def profile(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME_OR_FILE...",
            help="136RE, 136RE-8, 136RE-10, 136RE-14, 60E1, 60E2, 54E1, 49E1, S-519-A, AAR-1B, S1002, heavy-haul, "
            "R-519-A, or a .ban, .whl, .prr, .prw, .rail, .wheel, .csv, .txt, .dat, .json, .dxf, .slcs or .slcw file; "
            "several: one table and picture of all.",
            autocompletion=completion(profile_names, *PROFILE_FILES),
        ),
    ],
    unit: Unit = None,
    kind: Annotated[
        str | None,
        typer.Option("--kind", help="Kind of profile in the file.", **choices("rail", "wheel")),
    ] = None,
    mirror: Annotated[
        bool | None,
        typer.Option(
            "--mirror/--no-mirror",
            help="Reverse the first coordinate: a left-hand rail; left out: if its field side is worn more.",
        ),
    ] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Reverse the second coordinate.")] = False,
    origin: Annotated[
        str | None,
        typer.Option(
            "--origin",
            help="Position of the file's (0, 0); or X,Y, the position of a rail's top or a wheel's tread in the file.",
            **choices("top", "base", "gauge", "tape", "flange-back", "X,Y"),
        ),
    ] = None,
    tape: Annotated[
        float | None,
        typer.Option("--tape", metavar="MM", help="From the flange's back to the tape line; 70."),
    ] = None,
    smooth: Annotated[
        float | None,
        typer.Option("--smooth", metavar="MM", help="Wavelength to smooth by; 0 for none, 5 for noisy points."),
    ] = None,
    limit: Annotated[
        float | None,
        typer.Option("--limit", metavar="UM", help="Maximum displacement of a point by smoothing."),
    ] = None,
    position: Annotated[
        float | None,
        typer.Option("--position", metavar="X", help="Section of a .slcs file in mm, of a .slcw file in degrees."),
    ] = None,
    join: Annotated[
        str | None,
        _bundled("--join", "Bundled rail or wheel that gives the body."),
    ] = None,
    nominal: Annotated[
        str | None,
        _bundled("--nominal", "Nominal (new) profile that a measured one is drawn over (default: nearest)."),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            metavar="FILE",
            help="Write it in the format of this file's ending.",
            parser=path_given,
        ),
    ] = None,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Read a rail or wheel profile: checks, pictures, curvature, conversion, joint to a body (out/profile-NAME)."""
    from flangeway.cases.profile_run import run_profiles  # noqa: PLC0415
    from flangeway.railway.profiles.orientation import ReadOptions  # noqa: PLC0415
    from flangeway.report.profile_outputs import (  # noqa: PLC0415
        checked_conversion,
        profile_record,
        profiles_record,
    )
    from flangeway.system.output_folder import write_text  # noqa: PLC0415

    options = ReadOptions(unit, kind, mirror, flip, origin, tape, smooth, limit, position)
    with show.progress():
        runs = run_profiles(names, options, join)
    folder = results_folder(out, f"profile-{Path(names[0]).stem}" if len(names) == 1 else "profiles")
    if len(runs) > 1:
        if to is not None:
            raise InputError(f"--to {to} for {len(runs)} profiles", "one profile", "convert them one by one")
        show.record(profiles_record(runs, command_typed(), show.units or "metric"), folder)
        return True
    (done,) = runs
    conversion = checked_conversion(done, to)

    def convert() -> list[Path]:
        return [] if to is None else write_text(to, conversion)

    show.record(profile_record(done, command_typed(), show.units or "metric", nominal), folder, convert)
    return True


@app.command()
@shows_results
def profiles(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder with files of wheels or rails.", parser=path_given)
    ],
    partner: Annotated[
        str | None,
        _bundled(
            "--partner",
            "Bundled rail for the wheels, or wheel for the rails; 60E1 or S1002, of American bodies 136RE or AAR-1B",
        ),
    ] = None,
    nominal: Annotated[
        str | None,
        _bundled(
            "--nominal",
            "Bundled rail or wheel that the rails or wheels were when new; the nearest one of each if left out.",
        ),
    ] = None,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Wear, gauge measures and conicity of all profiles in a folder, the most worn first (out/profiles-FOLDER)."""
    from flangeway.cases.profile_run import run_folder  # noqa: PLC0415
    from flangeway.report.profile_outputs import folder_record  # noqa: PLC0415

    name = folder.resolve().name
    target = results_folder(out, f"profiles-{name}")
    with show.progress() as progress:
        done = run_folder(folder, partner, nominal, progress)
    return show.record(folder_record(done, name, command_typed(), show.units or "metric"), target)


# --- ``flangeway live``.


@app.command()
@errors_as_exit_status()
def live(
    profiles: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[WHEEL] [RAIL]",
            help="Files of measured profiles to begin with.",
            autocompletion=completion(list, *PROFILE_FILES),
        ),
    ] = None,
    port: Annotated[
        int, typer.Option("--port", metavar="NUMBER", help="Port on this machine; a free one if left out.")
    ] = 0,
    units: Units = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Move a wheelset on its rails with the mouse: a page in the browser, from this machine alone (Ctrl-C ends)."""
    try:
        from flangeway.live.server import LiveServer  # noqa: PLC0415
    except ModuleNotFoundError as reason:
        raise InputError(
            f"the live page without the package {reason.name}",
            "an installation with the extra `live`",
            "pip install 'flangeway[live]'",
        ) from reason
    server = LiveServer(profiles or [], port, units_given(units) or "metric")
    stdout().print(f"{server.address}\nThe page is served on this machine alone; Ctrl-C ends it.", soft_wrap=True)
    if browser:
        import webbrowser  # noqa: PLC0415 (only where one is opened)

        webbrowser.open(server.opener().as_uri())
    server.run()
    sys.stdout.flush()
    os._exit(DONE)  # without waiting for a position that is being computed
