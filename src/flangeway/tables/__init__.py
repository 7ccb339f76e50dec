"""Tables of creep forces for multibody programs: made by many processes, checked between their points, as an FMU."""

from flangeway.tables.creep_table import CreepTable
from flangeway.tables.table_build import TableRequest, make_table
from flangeway.tables.table_outputs import write_table

__all__ = ["CreepTable", "TableRequest", "make_table", "write_table"]
