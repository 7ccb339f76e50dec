"""The picture of each kind of result, see `flangeway.report.plot_result`."""

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.figure import Figure

from flangeway.campaign import CampaignTable
from flangeway.cases.profile_run import ProfileRun
from flangeway.cases.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.summary import RunResult
from flangeway.errors import InputError
from flangeway.report.campaign_figures import campaign_figures
from flangeway.report.case_outputs import case_record
from flangeway.report.figures.plots import plot_result
from flangeway.report.profile_outputs import shape_figure
from flangeway.report.rigid_outputs import conicity_figure, locus_figure
from flangeway.results import Result

__all__ = ["plot_result"]


def _first_picture(run: RunResult) -> Figure:
    """Draw the first picture of the report of a run."""
    return _first([picture.draw for picture in case_record(run).pictures()], run.case.name)


def _first_of_campaign(table: CampaignTable) -> Figure:
    return _first([*campaign_figures(table).values()], f"the campaign {table.name}")


def _first(draws: Sequence[Callable[[], Figure]], name: str) -> Figure:
    if not draws:
        raise InputError(f"a picture of {name}", "inputs that vary, or results that have one", "draw its table")
    return draws[0]()


PLOTS: dict[type[Result], Callable[[Any], Figure]] = {
    RunResult: _first_picture,
    GeometryRun: locus_figure,
    ConicityRun: conicity_figure,
    ProfileRun: shape_figure,
    CampaignTable: _first_of_campaign,
}
for _kind, _draw in PLOTS.items():
    plot_result.register(_kind, _draw)
