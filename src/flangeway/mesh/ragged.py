"""Index arithmetic on ragged rows: cells with different numbers of points."""

import numpy as np
from numpy.typing import NDArray

from flangeway.geometry.arrays import IntArray

IndexArray = NDArray[np.int64]


def next_in_row(offsets: IntArray) -> IndexArray:
    """Return for every entry the position of the entry after it in its row, cyclically."""
    following = np.arange(1, offsets[-1] + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return following


def row_numbers(offsets: IntArray) -> IndexArray:
    """Return for every entry the number of its row."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def rows_reversed(offsets: IntArray) -> IndexArray:
    """Return positions that turn every row backwards."""
    rows = row_numbers(offsets)
    return offsets[rows].astype(np.int64) + offsets[rows + 1] - 1 - np.arange(offsets[-1])


def offsets_of(counts: NDArray[np.int64]) -> IntArray:
    """Return the offsets (n + 1,) of rows with the given lengths (n,)."""
    offsets = np.zeros(len(counts) + 1, dtype=np.int32)
    np.cumsum(counts, out=offsets[1:])
    return offsets
