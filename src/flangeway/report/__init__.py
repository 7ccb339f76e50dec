"""What people look at: pictures, the HTML report, and files for ParaView."""

from flangeway.report.case_outputs import write_case
from flangeway.report.figures.fields import PartFields, part_fields
from flangeway.report.figures.plots import (
    plot_deformed,
    plot_displacement,
    plot_function,
    plot_mesh,
    plot_result,
    plot_stress,
)
from flangeway.report.figures.series import SeriesFrame, solution_frame, write_frame, write_series
from flangeway.report.page.case_text import command_line

__all__ = [
    "PartFields",
    "SeriesFrame",
    "command_line",
    "part_fields",
    "plot_deformed",
    "plot_displacement",
    "plot_function",
    "plot_mesh",
    "plot_result",
    "plot_stress",
    "solution_frame",
    "write_case",
    "write_frame",
    "write_series",
]
