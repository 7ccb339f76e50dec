"""Connections of cells and points: ragged rows, numbers of edges, and directed pairs in order along chains."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, norms
from flangeway.types import Bools, Floats, Indices, Ints


def next_in_row(offsets: IntArray) -> Ints:
    """Return for every entry the position of the entry after it in its row, cyclically."""
    following = np.arange(1, offsets[-1] + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return following


def row_numbers(offsets: Indices) -> Ints:
    """Return for every entry the number of its row."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def rows_reversed(offsets: IntArray) -> Ints:
    """Return positions that turn every row backwards."""
    rows = row_numbers(offsets)
    return offsets[rows].astype(np.int64) + offsets[rows + 1] - 1 - np.arange(offsets[-1])


def offsets_of(counts: Ints) -> IntArray:
    """Return the offsets (n + 1,) of rows with the given lengths (n,)."""
    offsets = np.zeros(len(counts) + 1, dtype=np.int32)
    np.cumsum(counts, out=offsets[1:])
    return offsets


def entries_of(offsets: IntArray, rows: Indices) -> tuple[Ints, IntArray]:
    """Return the positions of the entries of some rows, one row after the other, and the offsets of these rows."""
    counts = np.diff(offsets)[rows]
    taken = offsets_of(counts)
    return np.arange(taken[-1]) + np.repeat(offsets[rows] - taken[:-1], counts), taken


def places_among(kept: Indices, n: int) -> Ints:
    """Return the place of each of n numbers among some of them, -1 where it is none, (n,)."""
    places = np.full(n, -1, dtype=np.int64)
    places[kept] = np.arange(len(kept))
    return places


def first_connected(pairs: Indices, n: int) -> Ints:
    """Return for each of n numbers the lowest one that pairs (m, 2) connect it with, or itself, (n,)."""
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    groups = connected_components(links, directed=False)[1]
    return np.unique(groups, return_index=True)[1][groups]


@dataclass(frozen=True, eq=False)
class EdgeNumbers:
    """Numbers of the edges that cells travel.

    The keys ``low * n_points + high`` of the edges' points (n_edges,), rising; the edge of each side of a cell
    (n_sides,); the sides that are alone at their edge, rising; and the edges that two cells travel in the same
    direction, or more than two cells.
    """

    keys: Ints
    numbers: IntArray
    single: Ints
    doubled: Ints


def number_edges(start: IntArray, end: IntArray, n_points: int) -> EdgeNumbers:
    """Number the edges of sides given by their start and end (n_sides,)."""
    keys = np.minimum(start, end).astype(np.int64) * n_points + np.maximum(start, end)
    keys, first, numbers, counts = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    edges: IntArray = numbers.astype(np.int32)
    edges.setflags(write=False)
    # two cells that fit together travel their edge in both directions
    net = np.bincount(numbers, np.where(start < end, 1, -1))
    doubled = np.flatnonzero((counts > 2) | ((counts == 2) & (net != 0)))
    return EdgeNumbers(keys, edges, np.sort(first[counts == 1]), doubled)


def edge_places(edges: Indices, others: Indices, n_points: int) -> tuple[Ints, Bools]:
    """Places among other edges (m, 2) of edges (n, 2) in either direction, and whether each is there, both (n,)."""
    wanted, keys = (pairs.min(axis=1).astype(np.int64) * n_points + pairs.max(axis=1) for pairs in (edges, others))
    order = np.argsort(keys)
    places = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)]
    return places, keys[places] == wanted


def shortest_edges(points: Floats, edges: Indices) -> Floats:
    """Return the length of the shortest of some edges (m, 2) at each point, infinite where none is, (n_points,)."""
    lengths = norms(points[edges[:, 1]] - points[edges[:, 0]])
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, edges, lengths[:, None])
    return shortest


def pairs_divided(pairs: Indices, places: Indices, added: Indices) -> IntArray:
    """Return pairs (m, 2) divided at added points (k,), each in the pair at its place (k,), places rising."""
    starts, ends = pairs.astype(np.int32).T
    return np.column_stack((np.insert(starts, places + 1, added), np.insert(ends, places, added)))


def chain_starts(pairs: IntArray) -> Ints:
    """Return the rows of ordered pairs (m, 2) at which a chain starts."""
    breaks = np.ones(len(pairs), dtype=bool)
    breaks[1:] = pairs[1:, 0] != pairs[:-1, 1]
    return np.flatnonzero(breaks)


def ordered_pairs(pairs: IntArray, name: str) -> IntArray:
    """Return directed pairs (m, 2) in order along their chains; an `InputError` names the edge set where they branch.

    Open chains come first, in the order in which their first pairs are given, then closed ones, each from its first
    given pair. Pairs that are in order stay as they are.
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
