"""Pressures of a contact patch from a CSV file, as ``cells.csv`` of a patch that rolls has them."""

from pathlib import Path

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.system.file_content import number_table
from flangeway.types import Floats, Ints
from flangeway.units import sentence

COLUMNS = ("right_mm", "ahead_mm", "pressure_MPa")
WANTED = f"a CSV file with the columns {', '.join(COLUMNS)}: middles of even cells, and mean pressures"
OFF_GRID = 0.02
"""Distance of a place from the regular grid, over the size of the cells, that digits explain."""
MAX_CELLS = 120


def read_pressures(path: Path) -> tuple[PatchGrid, Floats]:
    """Return the cells of a file and their pressures, shape (n_cells, n_strips); those that it leaves out have none.

    Raises
    ------
    InputError
        If it cannot be read, lacks a column, has what is no number, or its places are on no regular grid.

    """
    values = number_table(path, COLUMNS, WANTED)
    (row, bounds), (strip, ends) = (_on_grid(path, name, values[:, axis]) for axis, name in enumerate(COLUMNS[:2]))
    pressures = np.full((len(bounds) - 1, len(ends) - 1), np.nan)
    pressures[row, strip] = values[:, 2]
    if np.isfinite(pressures).sum() < len(values):
        raise InputError(f"{path}: a cell for the second time", "each cell once", "leave the other one out")
    width = float(ends[1] - ends[0])
    return PatchGrid(bounds, width, len(ends) - 1, float(ends[0] + ends[-1]) / 2.0), np.nan_to_num(pressures)


def _on_grid(path: Path, name: str, values: Floats) -> tuple[Ints, Floats]:
    """Numbers of the cells in which places are, and the ends of these cells."""
    different = np.unique(values)
    if len(different) < 2 or not np.ptp(values) < MAX_CELLS * np.diff(different).min():
        raise _uneven(path, name, different)
    # digits are lost in single differences, not in the whole length
    n = round(float(np.ptp(values) / np.diff(different).min())) + 1
    step = float(np.ptp(values)) / (n - 1)
    exact = (values - different[0]) / step
    cells = np.rint(exact).astype(np.int64)
    if np.abs(exact - cells).max() > OFF_GRID:
        raise _uneven(path, name, different)
    return cells, different[0] + step * (np.arange(n + 1, dtype=np.float64) - 0.5)


def _uneven(path: Path, name: str, different: Floats) -> InputError:
    steps = sentence(" in steps from {:g mm}", np.diff(different).min()) if len(different) > 1 else ""
    return InputError(
        sentence("{}: {} different {}{}", path, len(different), name, steps),
        f"places on a regular grid of 2 to {MAX_CELLS} cells",
        "interpolate them to even cells",
    )
