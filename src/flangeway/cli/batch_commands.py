"""``flangeway damage``, ``campaign`` and ``creep-table``: commands that compute many cases."""

import time
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    Fresh,
    Out,
    Progress,
    Set,
    Show,
    Workers,
    choices,
    command_typed,
    completion,
    results_folder,
    settings_of,
    shows_results,
)
from flangeway.errors import InputError

if TYPE_CHECKING:
    from flangeway.campaign import CampaignProgress
    from flangeway.cases.damage_file import DamageInputs

# --- ``flangeway damage``.


STEPS_FILE = "damage.sqlite"


@app.command()
@shows_results
def damage(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A file with states, wear laws and an end (.toml).",
            autocompletion=completion(list, ".toml"),
        ),
    ],
    out: Out = None,
    fresh: Fresh = False,
    *,
    show: Show,
) -> bool:
    """Let the profiles of wheels and rails wear over a collective of states: depths, limits, fatigue (out/FILE)."""
    from flangeway.cases.damage_file import DamageFile  # noqa: PLC0415

    return run_strategies(DamageFile.read(file).strategies(), results_folder(out, file.stem), show, fresh=fresh)


def run_strategies(strategies: "dict[str, DamageInputs]", folder: Path, show: Show, *, fresh: bool) -> bool:
    """Let profiles wear by all strategies and show what was found; whether all states converged."""
    from flangeway.report.damage_record import damage_record, strategies_record  # noqa: PLC0415

    units, runs = show.units or "metric", {}
    for name, inputs in strategies.items():
        into = results_folder(folder / name if len(strategies) > 1 else folder, name)
        store = into / STEPS_FILE
        if fresh:
            store.unlink(missing_ok=True)
        begun = time.perf_counter()
        with show.progress(f"what is done is kept in {store}") as progress:
            steps = inputs.evolution.run(store, progress)
        record = damage_record(inputs, steps, command_typed(), time.perf_counter() - begun, units)
        show.record(record, into, partial(list, [store]), last=len(strategies) == 1)
        runs[name] = steps, record
    if len(runs) > 1:
        show.record(strategies_record(strategies, runs, command_typed(), units), folder)
    return all(record.converged for _, record in runs.values())


# --- ``flangeway campaign``.


LINE_EVERY_S = 5.0
"""Time between two lines on how many rows are done."""


@app.command()
@shows_results
def campaign(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A campaign's file (.toml).", autocompletion=completion(list, ".toml")),
    ],
    out: Out = None,
    workers: Workers = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler", metavar="ADDRESS", help="A scheduler of dask.distributed whose workers compute instead."
        ),
    ] = None,
    fresh: Fresh = False,
    export: Annotated[
        str | None,
        typer.Option(
            "--export",
            help="Format of the tables; once all is done, nothing else is written.",
            **choices("csv", "parquet"),
        ),
    ] = None,
    *,
    show: Show,
) -> bool:
    """Run a case, or a damage file, over many inputs: results in SQLite files, tables, pictures (out/FILE)."""
    from flangeway.campaign import Campaign, results, run_campaign  # noqa: PLC0415
    from flangeway.campaign.damage_campaign import DamageCampaign  # noqa: PLC0415
    from flangeway.campaign.database import refuse_format, refuse_unusable  # noqa: PLC0415
    from flangeway.report.campaign_outputs import (  # noqa: PLC0415
        DATABASE,
        campaign_record,
        write_export,
    )

    if "damage" in (given := DamageCampaign.read(file)).data:
        for option, value in (("--workers", workers), ("--scheduler", scheduler), ("--export", export)):
            if value is not None:
                raise InputError(f"{option} with damage", "steps one after the other, in CSV", f"leave out {option}")
        return run_strategies(given.strategies(), results_folder(out, file.stem), show, fresh=fresh)
    if export is not None:
        refuse_format(export)
    wanted = Campaign.from_file(file, units=show.units)
    show = replace(show, units=wanted.units)
    folder = results_folder(out, file.stem)
    database = folder / DATABASE
    if database.is_file() and not fresh:
        refuse_unusable(database)
    begun = time.perf_counter()
    with show.progress(f"what is done is kept in {database}") as progress:
        shown = _rows_shown(progress)
        end = run_campaign(wanted, database, workers=workers, scheduler=scheduler, fresh=fresh, progress=shown)
    table = results(database)
    seconds = time.perf_counter() - begun
    record = campaign_record(end, table, export or "csv", command_typed(), seconds, wanted.units)
    if export is not None and end.seconds_left is None and not show.xlsx:  # no row was computed
        show.files(write_export(table, folder, export, wanted.units))
        show.json(record.summary)
        return end.all_converged
    show.record(record, folder, lambda: [database])
    return end.all_converged


def _rows_shown(show: Progress) -> Callable[["CampaignProgress"], None]:
    """Show how many rows are done and the time left, not more often than a reader wants."""
    last = -LINE_EVERY_S

    def rows(now: "CampaignProgress") -> None:
        nonlocal last
        if time.monotonic() - last >= LINE_EVERY_S or now.n_done == now.n_rows:
            last = time.monotonic()
            show(f"{now.n_done} of {now.n_rows} rows; {_left(now)}")

    return rows


def _left(now: "CampaignProgress") -> str:
    """Time left and the numbers of rows that went wrong."""
    words = []
    if now.n_done == now.n_rows:
        words.append("done")
    elif now.seconds_left is None:
        words.append("time left not known yet")
    else:
        words.append(f"{timedelta(seconds=round(now.seconds_left))} left")
    words += [f"{now.counts[status]} {status}" for status in ("not converged", "failed") if now.counts.get(status)]
    return ", ".join(words)


# --- ``flangeway creep-table``.


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
    from flangeway.cases.wheelset.wheelset_case import Wheelset  # noqa: PLC0415
    from flangeway.report.creep_table_page import creep_table_record  # noqa: PLC0415
    from flangeway.tables.table_build import TableRequest, make_table  # noqa: PLC0415
    from flangeway.tables.table_outputs import refuse_without_compiler, table_writers  # noqa: PLC0415

    wanted = read_case(case, settings_of(set_, "a wrong key lists the right ones"))
    if not isinstance(wanted, Wheelset):
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
    from flangeway.campaign.campaign import range_values  # noqa: PLC0415

    parts = text.split(":")
    try:
        numbers = [float(part) for part in (parts if len(parts) == 3 else text.split(","))]
        if len(parts) != 3:
            return numbers
        return range_values(option, dict(zip(("from", "to", "step"), numbers, strict=True)))
    except (ValueError, OverflowError, ZeroDivisionError, InputError):
        raise InputError(
            f"{option} {text}",
            "FROM:TO:STEP with a step that leads from one to the other, or numbers with commas: -6:6:1, or 150,200",
            f"correct it; a negative number needs an equals sign: {option}=-6:6:1",
        ) from None
