"""Report and files of the run of any case: one table says what makes the record for each kind of case."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from flangeway.campaign import CampaignTable
from flangeway.cases import BodiesRun, WheelsetRun
from flangeway.cases.bodies.bodies_run import BodiesCase
from flangeway.cases.case import Case
from flangeway.cases.profile_run import ProfileRun
from flangeway.cases.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.rolling_patch_case import RollingPatchCase, RollingPatchRun
from flangeway.cases.section_run import SectionRun, TorsionCase
from flangeway.cases.spatial_case import SpatialCase, SpatialPreset, SpatialRun
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError
from flangeway.report import bodies_page, rolling_patch_page, section_page, spatial_page
from flangeway.report.bodies_page import stress_figure
from flangeway.report.campaign_figures import campaign_figures
from flangeway.report.figures.plots import plot_result
from flangeway.report.page.html_page import command_line, record_html, write_record
from flangeway.report.page.record import SUMMARY, Report
from flangeway.report.profile_outputs import shape_figure
from flangeway.report.rigid_outputs import conicity_figure, locus_figure
from flangeway.report.section_figures import warping_figure
from flangeway.report.wheelset import wheelset_page
from flangeway.report.wheelset.wheelset_patches import section_figure
from flangeway.results import Result
from flangeway.types import Progress

RECORDS: dict[type[Case], Callable[[Any], Report]] = {
    Wheelset: wheelset_page.wheelset_record,
    BodiesCase: bodies_page.bodies_record,
    SpatialCase: spatial_page.spatial_record,
    SpatialPreset: spatial_page.spatial_record,
    RollingPatchCase: rolling_patch_page.rolling_patch_record,
    TorsionCase: lambda run: section_page.section_record(run, command_line(run.case), SUMMARY),
}
"""What a run found, by the kind of its case; a new kind adds its line."""


def _first_of_campaign(table: CampaignTable) -> Figure:
    for draw in campaign_figures(table).values():
        return draw()
    raise InputError(
        f"a picture of the campaign {table.name}", "one of wheelsets in which a number varies", "draw its table"
    )


PLOTS: dict[type[Result], Callable[[Any], Figure]] = {
    WheelsetRun: section_figure,
    BodiesRun: stress_figure,
    SpatialRun: spatial_page.patch_figure,
    RollingPatchRun: rolling_patch_page.main_figure,
    SectionRun: warping_figure,
    GeometryRun: locus_figure,
    ConicityRun: conicity_figure,
    ProfileRun: shape_figure,
    CampaignTable: _first_of_campaign,
}
for _kind, _draw in PLOTS.items():
    plot_result.register(_kind, _draw)


def case_record(run: RunResult) -> Report:
    """Return what a run found, for the terminal, the report and programs."""
    return next(RECORDS[kind] for kind in type(run.case).__mro__ if kind in RECORDS)(run)


def run_html(run: RunResult) -> str | None:
    """Return how a run ended, its warnings and its table of results for a notebook; None if its case has no report."""
    return record_html(case_record(run)) if any(kind in RECORDS for kind in type(run.case).__mro__) else None


def write_case(run: RunResult, folder: Path, progress: Progress = lambda _: None) -> list[Path]:
    """Write all files of a run, ``summary.json`` last, together or not at all.

    It is an `InputError` if the folder cannot be written.
    """
    return write_record(case_record(run), folder, progress)
