"""``flangeway creep-table``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    Out,
    Set,
    Show,
    Workers,
    command_typed,
    completion,
    results_folder,
    settings_of,
    shows_results,
)
from flangeway.errors import InputError


@app.command("creep-table")
@shows_results
def creep_table(
    case: Annotated[
        str,
        typer.Argument(
            metavar="[CASE_OR_FILE]",
            help="wheelset, or a case file of a wheelset in three dimensions.",
            autocompletion=completion(lambda: ["wheelset"], ".toml"),
        ),
    ] = "wheelset",
    set_: Set = None,
    lateral: Annotated[
        str, typer.Option("--lateral", metavar="VALUES", help="Lateral positions in mm: FROM:TO:STEP, or A,B,C.")
    ] = "-6:6:1",
    yaw: Annotated[str, typer.Option("--yaw", metavar="VALUES", help="Yaw in mrad, as --lateral.")] = "-5:5:5",
    load: Annotated[
        str, typer.Option("--load", metavar="VALUES", help="Axle loads in kN, as --lateral.")
    ] = "120:280:80",
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="SHARE", help="Refinement tolerance, relative to mu N.")
    ] = 0.1,
    workers: Workers = None,
    fmu: Annotated[bool, typer.Option("--fmu", help="Write FMUs too (FMI 2 and 3); needs a C compiler.")] = False,
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Tabulate creep forces for multibody programs: npz, CSV, FMU, errors and report (out/creep-table-CASE)."""
    from flangeway.cases.case_file import read_case  # noqa: PLC0415
    from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase  # noqa: PLC0415
    from flangeway.report.rolling.creep_table_page import creep_table_record  # noqa: PLC0415
    from flangeway.tables.fmu import refuse_without_compiler  # noqa: PLC0415
    from flangeway.tables.table_build import TableRequest, make_table  # noqa: PLC0415
    from flangeway.tables.table_outputs import table_writers  # noqa: PLC0415

    wanted = read_case(case, settings_of(set_, "a wrong key lists the right ones"))
    if not isinstance(wanted, SpatialWheelsetCase):
        raise InputError(f"a table of {wanted.name}", "a case wheelset", "give wheelset, or a case file of one")
    axes = values_of(lateral, "--lateral"), values_of(yaw, "--yaw"), values_of(load, "--load")
    request = TableRequest(wanted, *axes, tolerance)
    if fmu:
        refuse_without_compiler()
    folder = results_folder(out, f"creep-table-{Path(case).stem}")
    with show.progress("positions that are done are kept in the cache") as progress:
        table = make_table(request, workers=workers, progress=progress)
    return show.record(creep_table_record(table, request, command_typed(), table_writers(table, fmu=fmu)), folder)


def values_of(text: str, option: str) -> list[float]:
    """Numbers of ``FROM:TO:STEP`` or ``A,B,C``; an `InputError` for what is neither."""
    from flangeway.campaign.varying import range_values  # noqa: PLC0415

    parts = text.split(":")
    try:
        numbers = [float(each) for each in (parts if len(parts) == 3 else text.split(","))]
        if len(parts) != 3:
            return numbers
        return range_values(option, dict(zip(("from", "to", "step"), numbers, strict=True)))
    except (ValueError, OverflowError, ZeroDivisionError, InputError):
        raise InputError(
            f"{option} {text}",
            "FROM:TO:STEP with a step that leads from one to the other, or numbers with commas: -6:6:1, or 150,200",
            f"correct it; a negative number needs an equals sign: {option}=-6:6:1",
        ) from None
