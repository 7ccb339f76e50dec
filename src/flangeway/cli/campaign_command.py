"""``flangeway campaign``."""

import time
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    Fresh,
    Out,
    Progress,
    Show,
    Workers,
    choices,
    command_typed,
    completion,
    results_folder,
    shows_results,
)
from flangeway.cli.damage_command import run_strategies
from flangeway.errors import InputError

if TYPE_CHECKING:
    from flangeway.campaign import CampaignProgress

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
    from flangeway.campaign.database import refuse_format  # noqa: PLC0415
    from flangeway.report.campaign.campaign_outputs import (  # noqa: PLC0415
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
    show.units = wanted.units
    folder = results_folder(out, file.stem)
    database = folder / DATABASE
    had_all = not fresh and database.is_file() and results(database).is_done
    begun = time.perf_counter()
    with show.progress(f"what is done is kept in {database}") as progress:
        shown = _rows_shown(progress)
        end = run_campaign(wanted, database, workers=workers, scheduler=scheduler, fresh=fresh, progress=shown)
    table = results(database)
    seconds = time.perf_counter() - begun
    record = campaign_record(end, table, export or "csv", command_typed(), seconds, wanted.units)
    if export is not None and had_all and not show.xlsx:
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
