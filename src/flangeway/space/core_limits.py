"""Threads and memory of the compiled core, checked before it begins."""

import os
from collections.abc import Iterable

from flangeway.errors import InputError, short
from flangeway.system.memory_limits import refuse_beyond_memory

VARIABLES = ("RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS")
MAX_THREADS = 256
"""More threads than this take longer to start than they save."""


def refuse_many_threads() -> None:
    """Refuse numbers of threads in the environment with which the core would hang before it begins."""
    for name in VARIABLES:
        value = os.environ.get(name, "")
        if value and not (value.isdecimal() and int(value[:9]) <= MAX_THREADS):
            raise InputError(
                f"{name} = {short(value)}",
                f"a whole number from 0 up to {MAX_THREADS}",
                "leave it out to use all cores",
            )


BYTES_AN_ENTRY = 21
"""Of the cells' matrices (8), packed (4), and the assembled one with its pattern; measured 15 to 22."""


def refuse_large_assembly(cells: Iterable[tuple[int, int]]) -> None:
    """Refuse an assembly without memory for it: unknowns of a cell and number of such cells, for each batch."""
    entries = sum(n_local**2 * n_cells for n_local, n_cells in cells)
    refuse_beyond_memory("the assembly of the stiffness", BYTES_AN_ENTRY * entries)
