"""What people look at: pictures, the HTML report, and files for ParaView."""

from flangeway.report.command import command_line
from flangeway.report.fields import PartFields, part_fields
from flangeway.report.outputs import write_outputs
from flangeway.report.plots import plot_deformed, plot_displacement, plot_function, plot_mesh, plot_stress
from flangeway.report.series import Frame, solution_frame, write_frame, write_series

__all__ = [
    "Frame",
    "PartFields",
    "command_line",
    "part_fields",
    "plot_deformed",
    "plot_displacement",
    "plot_function",
    "plot_mesh",
    "plot_stress",
    "solution_frame",
    "write_frame",
    "write_outputs",
    "write_series",
]
