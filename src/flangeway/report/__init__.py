"""What people look at: pictures, the HTML report, and files for ParaView."""

from flangeway.report.case_outputs import RECORDS, run_html, write_case
from flangeway.report.figures.display import SeriesFrame, solution_frame, write_frame, write_series
from flangeway.report.figures.drawing import name_axes, panels
from flangeway.report.figures.plots import (
    part_fields,
    plot_deformed,
    plot_displacement,
    plot_function,
    plot_mesh,
    plot_result,
    plot_stress,
)
from flangeway.report.page.html_page import command_line, run_record
from flangeway.report.page.record import Picture, SummaryTable, fact, rows_of

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
