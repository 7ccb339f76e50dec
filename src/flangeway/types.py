"""Names of types that many modules use, and arrays of numbers."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.integer]
"""Numbers of points, cells or unknowns, of any width."""
Complex = NDArray[np.complex128]
Key = tuple[str | int, ...]
"""Path of an input: a name, or in nested tables names and positions in lists."""

Progress = Callable[[str], None]
"""What takes sentences on long computations between others."""


def floats(values: ArrayLike) -> Floats:
    """Return values as an array of floats."""
    return np.asarray(values, dtype=np.float64)
