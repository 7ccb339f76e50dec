"""Directed pairs of points put in order along their chains."""

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray


def chain_starts(pairs: IntArray) -> NDArray[np.int64]:
    """Return the rows of ordered pairs (m, 2) at which a chain starts."""
    breaks = np.ones(len(pairs), dtype=bool)
    breaks[1:] = pairs[1:, 0] != pairs[:-1, 1]
    return np.flatnonzero(breaks)


def ordered_pairs(pairs: IntArray, name: str) -> IntArray:
    """Return directed pairs (m, 2) in order along their chains.

    Open chains come first, in the order in which their first pairs are given, then closed ones,
    each from its first given pair. Pairs that are in order stay as they are.

    Raises
    ------
    InputError
        If a point has two pairs that leave it or two that reach it.

    """
    for column, what in ((0, "leave"), (1, "reach")):
        values, counts = np.unique(pairs[:, column], return_counts=True)
        if np.any(counts > 1):
            raise InputError(
                f"edge set '{name}': {counts.max()} edges {what} point {values[counts.argmax()]}",
                "chains that do not branch",
                "give each edge once, with the body on its left",
            )
    starts = chain_starts(pairs)
    ends = pairs[np.append(starts[1:], len(pairs)) - 1, 1]
    by_start = np.argsort(pairs[:, 0])
    places = np.minimum(np.searchsorted(pairs[by_start, 0], ends), len(pairs) - 1)
    following = by_start[places]
    # in order if nothing leaves the end of a chain but, where it is closed, its own first pair
    if np.all((pairs[following, 0] != ends) | (following == starts)):
        return pairs
    return pairs[_order(pairs.tolist())]


def _order(pairs: list[list[int]]) -> list[int]:
    """Return the rows of the pairs in order along the chains."""
    leaving = {pair[0]: row for row, pair in enumerate(pairs)}
    reached = {pair[1] for pair in pairs}
    open_first = sorted(range(len(pairs)), key=lambda row: pairs[row][0] in reached)
    order: list[int] = []
    seen = [False] * len(pairs)
    for first in open_first:
        row: int | None = first
        while row is not None and not seen[row]:
            seen[row] = True
            order.append(row)
            row = leaving.get(pairs[row][1])
    return order
