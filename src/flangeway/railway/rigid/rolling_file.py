"""Files of a rolling radius difference: lateral motion and difference, two numbers a line."""

from pathlib import Path

import numpy as np

from flangeway.errors import InputError
from flangeway.railway.profiles.formats.two_column import read_two_column
from flangeway.railway.profiles.orientation import UNITS_MM
from flangeway.railway.rigid.rolling_radii import RollingRadiusDifference
from flangeway.system.file_content import file_content

MAX_LATERAL_MM = 50.0
"""Lateral motion beyond which a file is of something else, as a profile."""


def read_rolling_radius_difference(file: str | Path, unit: str | None = None) -> RollingRadiusDifference:
    """Read lateral motions and rolling radius differences from a text file of two columns.

    Parameters
    ----------
    file
        Lateral motion to the right, and radius of the right wheel less that of the left one; separators, decimal commas
        and comments as in profiles of two columns. Rows in either order.
    unit
        Unit of both columns, one of `flangeway.railway.profiles.orientation.UNITS_MM`; by default what the file says in
        a comment such as ``# unit: mm`` or in the names of its columns such as ``y_mm, delta_r_mm``.

    Raises
    ------
    InputError
        If the file cannot be read, names no unit, or does not hold a rolling radius difference.

    """
    path = Path(file)
    try:
        found = read_two_column(file_content(path, "a rolling radius difference").decode("utf-8-sig", "replace"))
        chosen = found.unit if unit is None else unit
        if chosen not in UNITS_MM:
            raise InputError(
                "no unit of its two columns" if chosen is None else f"unit = {chosen!r}",
                f"one of: {', '.join(UNITS_MM)}",
                "add a line `# unit: mm` at the top, name the columns y_mm and delta_r_mm, or give --set unit=mm",
            )
        rows = found.points * UNITS_MM[chosen]
        if len(rows) and np.abs(rows[:, 0]).max() > MAX_LATERAL_MM:
            raise InputError(
                f"lateral motions up to {np.abs(rows[:, 0]).max():.4g} mm",
                f"up to {MAX_LATERAL_MM:g} mm: a column of lateral motions and one of rolling radius differences",
                "check the unit; a profile is given in a case file as wheel or rail",
            )
        return RollingRadiusDifference(*(rows if len(rows) < 2 or rows[0, 0] <= rows[-1, 0] else rows[::-1]).T)
    except InputError as error:
        raise InputError(f"{path}: {error.given}", error.allowed, error.advice) from error
