"""The picture of each kind of result, see `flangeway.report.plot_result`."""

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from flangeway.campaign import CampaignTable
from flangeway.cases import BodiesRun, WheelsetRun
from flangeway.cases.profile_run import ProfileRun
from flangeway.cases.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.rolling_patch_case import RollingPatchRun
from flangeway.cases.section_run import SectionRun
from flangeway.cases.spatial_case import SpatialRun
from flangeway.errors import InputError
from flangeway.report.bodies_figures import stress_figure
from flangeway.report.campaign_figures import campaign_figures
from flangeway.report.figures.plots import plot_result
from flangeway.report.profile_outputs import shape_figure
from flangeway.report.rigid_outputs import conicity_figure, locus_figure
from flangeway.report.rolling_patch_figures import main_figure
from flangeway.report.section_figures import warping_figure
from flangeway.report.spatial_figures import patch_figure
from flangeway.report.wheelset.wheelset_figures import section_figure
from flangeway.results import Result

__all__ = ["plot_result"]


def _first_of_campaign(table: CampaignTable) -> Figure:
    for draw in campaign_figures(table).values():
        return draw()
    raise InputError(
        f"a picture of the campaign {table.name}", "one of wheelsets in which a number varies", "draw its table"
    )


PLOTS: dict[type[Result], Callable[[Any], Figure]] = {
    WheelsetRun: section_figure,
    BodiesRun: stress_figure,
    SpatialRun: patch_figure,
    RollingPatchRun: main_figure,
    SectionRun: warping_figure,
    GeometryRun: locus_figure,
    ConicityRun: conicity_figure,
    ProfileRun: shape_figure,
    CampaignTable: _first_of_campaign,
}
for _kind, _draw in PLOTS.items():
    plot_result.register(_kind, _draw)
