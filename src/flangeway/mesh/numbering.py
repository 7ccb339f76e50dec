"""Edges of cells numbered by two passes of a counting sort, in time proportional to their number."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flangeway.geometry.arrays import IntArray
from flangeway.mesh.ragged import IndexArray


@dataclass(frozen=True, eq=False)
class EdgeNumbers:
    """Numbers of the edges that cells travel.

    Parameters
    ----------
    keys
        ``low * n_points + high`` of each edge's points (n_edges,), rising.
    numbers
        Edge of each side of a cell (n_sides,).
    single
        Sides that are alone at their edge, rising.
    doubled
        Edges that two cells travel in the same direction, or more than two cells.

    """

    keys: IndexArray
    numbers: IntArray
    single: IndexArray
    doubled: IndexArray


def number_edges(start: IntArray, end: IntArray, n_points: int) -> EdgeNumbers:
    """Number the edges of sides given by their start and end (n_sides,)."""
    forward = start < end
    low, high = np.where(forward, start, end), np.where(forward, end, start)
    order = _counting_sort(high, n_points)
    order = order[_counting_sort(low[order], n_points)]
    low, high = low[order], high[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    first = np.flatnonzero(new)
    numbers = np.empty(len(order), dtype=np.int32)
    numbers[order] = np.cumsum(new, dtype=np.int32) - 1
    numbers.setflags(write=False)
    counts = np.diff(first, append=len(order))
    forward = forward[order]
    doubled = counts > 2
    two = np.flatnonzero(counts == 2)
    doubled[two] = forward[first[two]] == forward[first[two] + 1]
    return EdgeNumbers(
        low[first].astype(np.int64) * n_points + high[first],
        numbers,
        np.sort(order[first[counts == 1]]).astype(np.int64),
        np.flatnonzero(doubled),
    )


def _counting_sort(values: IntArray, n_values: int) -> NDArray[np.int32]:
    """Stable order of integers in [0, n_values), which a change of sparse storage finds."""
    n = len(values)
    one_a_row = csr_array((np.empty(n, dtype=np.int8), values, np.arange(n + 1, dtype=np.int32)), shape=(n, n_values))
    order: NDArray[np.int32] = one_a_row.tocsc().indices
    return order
