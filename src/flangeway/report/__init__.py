"""What people look at: pictures, the HTML report, and files for ParaView."""

from flangeway.report.command import command_line
from flangeway.report.fields import PartFields, part_fields
from flangeway.report.outputs import check_folder, write_outputs

__all__ = ["PartFields", "check_folder", "command_line", "part_fields", "write_outputs"]
