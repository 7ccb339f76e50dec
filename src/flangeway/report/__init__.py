"""What people look at: pictures, the HTML report, and files for ParaView."""

from flangeway.report.case_outputs import RECORDS, run_html, write_case
from flangeway.report.figures.drawing import name_axes, panels
from flangeway.report.figures.fields import part_fields
from flangeway.report.figures.plots import (
    plot_deformed,
    plot_displacement,
    plot_function,
    plot_mesh,
    plot_result,
    plot_stress,
)
from flangeway.report.figures.series import SeriesFrame, solution_frame, write_frame, write_series
from flangeway.report.page.case_text import command_line, run_record
from flangeway.report.page.record import Picture
from flangeway.report.page.tables import SummaryTable, fact, rows_of

__all__ = [
    "RECORDS",
    "Picture",
    "SeriesFrame",
    "SummaryTable",
    "command_line",
    "fact",
    "name_axes",
    "panels",
    "part_fields",
    "plot_deformed",
    "plot_displacement",
    "plot_function",
    "plot_mesh",
    "plot_result",
    "plot_stress",
    "rows_of",
    "run_html",
    "run_record",
    "solution_frame",
    "write_case",
    "write_frame",
    "write_series",
]
