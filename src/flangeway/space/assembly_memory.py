"""Memory of the assembly, estimated before it begins."""

from collections.abc import Iterable

from flangeway.system.memory_limits import refuse_beyond_memory

BYTES_AN_ENTRY = 21
"""Of the cells' matrices (8), packed (4), and the assembled one with its pattern; measured 15 to 22."""


def refuse_large_assembly(cells: Iterable[tuple[int, int]]) -> None:
    """Refuse to assemble matrices without memory for them: unknowns of a cell and number of such cells, for each batch.
    """
    entries = sum(n_local**2 * n_cells for n_local, n_cells in cells)
    refuse_beyond_memory("the assembly of the stiffness", BYTES_AN_ENTRY * entries)
