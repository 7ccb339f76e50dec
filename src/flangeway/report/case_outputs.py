"""Report and files of the run of any case: one table says what makes the record for each kind of case."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.rolling_patch_case import RollingPatchRun
from flangeway.cases.section_run import SectionRun
from flangeway.cases.spatial_case import SpatialRun
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_case import PlaneWheelsetRun, SpatialWheelsetRun
from flangeway.report import bodies_page, rolling_patch_page, section_page, spatial_page
from flangeway.report.page.html_page import command_line, record_html, write_record
from flangeway.report.page.record import SUMMARY, Report
from flangeway.report.wheelset import wheelset_page
from flangeway.types import Progress

RECORDS: dict[type[RunResult], Callable[[Any], Report]] = {
    PlaneWheelsetRun: wheelset_page.plane_record,
    SpatialWheelsetRun: wheelset_page.wheelset_record,
    BodiesRun: bodies_page.bodies_record,
    SpatialRun: spatial_page.spatial_record,
    RollingPatchRun: rolling_patch_page.rolling_patch_record,
    SectionRun: lambda run: section_page.section_record(run, command_line(run.case), SUMMARY),
}
"""What a run found, by its kind; a new kind adds its line."""


def case_record(run: RunResult) -> Report:
    """Return what a run found, for the terminal, the report and programs."""
    return RECORDS[type(run)](run)


def run_html(run: RunResult) -> str | None:
    """Return how a run ended, its warnings and its table of results for a notebook; None if its case has no report."""
    return record_html(case_record(run)) if type(run) in RECORDS else None


def write_case(
    run: RunResult, folder: Path, progress: Progress = lambda _: None, *, whole_sections: bool = False
) -> list[Path]:
    """Write all files of a run, ``summary.json`` last, together or not at all.

    - `whole_sections`: whether stresses in whole sections of rails and wheels are among them, for ParaView.

    It is an `InputError` if the folder cannot be written, or the case has no whole sections.
    """
    if whole_sections:
        run.case.check_sections()
    return write_record(case_record(run), folder, progress, whole_sections=whole_sections)
