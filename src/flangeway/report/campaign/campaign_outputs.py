"""All files that a campaign leaves beside its database, and its end on the terminal."""

import json
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from flangeway.campaign import Campaign, CampaignProgress, CampaignTable
from flangeway.campaign.database import FORMATS, export_writers
from flangeway.report.campaign.campaign_figures import NAMES as PICTURES
from flangeway.report.campaign.campaign_figures import campaign_figures
from flangeway.report.campaign.sweep_animation import NAME as SWEEP
from flangeway.report.campaign.sweep_animation import is_sweep, sweep_frames, sweep_gif
from flangeway.report.figures.drawing import picture_writers
from flangeway.report.page.tables import print_files, print_notices
from flangeway.system.output_folder import bytes_writer, refuse_unwritable, write_together

DATABASE = "campaign.sqlite"
TABLES = tuple(f"{name}.{kind}" for kind in FORMATS for name in ("results", "patches"))
MOST_REASONS = 10
MOST_NUMBERS = 8


def check_campaign_folder(folder: Path) -> None:
    """Refuse a folder that cannot take a campaign's files (`flangeway.system.output_folder.refuse_unwritable`)."""
    refuse_unwritable(folder, (DATABASE, *TABLES, *PICTURES, SWEEP))


def write_export(table: CampaignTable, folder: Path, kind: str) -> list[Path]:
    """Write the tables of a campaign as CSV or Parquet, together or not at all."""
    return write_together(folder, export_writers(table, kind))


def write_campaign(
    campaign: Campaign,
    table: CampaignTable,
    folder: Path,
    kind: str = "csv",
    progress: Callable[[str], None] = lambda _: None,
) -> list[Path]:
    """Write all files of a finished campaign, tables as CSV and as `kind`, together or not at all."""
    writers = export_writers(table, "csv") | (export_writers(table, kind) if kind != "csv" else {})
    progress("drawing the pictures")
    writers |= picture_writers({name: draw() for name, draw in campaign_figures(table).items()})
    if is_sweep(campaign, table):
        progress("drawing the animation")
        writers[SWEEP] = bytes_writer(sweep_gif(sweep_frames(campaign, table), table.name))
    progress("writing the files")
    return write_together(folder, writers)


def print_campaign(console: Console, end: CampaignProgress, table: CampaignTable, files: list[Path]) -> None:
    """Print the numbers of rows by status, failures by reason, warnings, and the files."""
    counts = ", ".join(f"{number} {status}" for status, number in end.counts.items() if number)
    console.print(f"{table.name}: {end.n_rows} rows of {table.case}: {counts}", style="bold", markup=False)
    failures = sorted(table.failures().items(), key=lambda each: -len(each[1]))
    for (status, message), rows in failures[:MOST_REASONS]:
        console.print(f"{len(rows)} {status}: {message}", style="red", markup=False, soft_wrap=True)
        console.print(f"  rows {_numbers(rows)}", markup=False, soft_wrap=True)
    if len(failures) > MOST_REASONS:
        console.print(f"and {len(failures) - MOST_REASONS} other reasons: column message of results.csv", markup=False)
    warned: dict[str, int] = {}
    for text in table.rows["warnings"]:
        for warning in json.loads(str(text or "[]")):
            warned[warning] = warned.get(warning, 0) + 1
    for warning, number in sorted(warned.items(), key=lambda each: -each[1])[:MOST_REASONS]:
        print_notices(console, [warning], f"Warning in {number} rows")
    print_files(console, files)


def _numbers(rows: list[int]) -> str:
    shown = ", ".join(str(row) for row in rows[:MOST_NUMBERS])
    return shown if len(rows) <= MOST_NUMBERS else f"{shown}, and {len(rows) - MOST_NUMBERS} more"
