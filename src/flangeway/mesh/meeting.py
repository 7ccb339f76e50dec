"""Segments that touch or cross, found by a sweep, and how many cells of a mesh lie on each other."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flangeway.geometry.arrays import IntArray, cross_product
from flangeway.types import Bools, Floats, Ints

TOUCHING = 1e-6
"""Distance of a point from a segment, over the shorter of it and the point's own, up to which they touch."""

ROUNDING = 1e-9
"""Distance over the size of the mesh up to which they touch where the segments are short, by files' few digits."""

DIRECTIONS = (0.6, 1.4, 2.2, 3.0)
"""Angles in radians of the sweeps, of which the one with the fewest candidates is taken."""

MOST_CANDIDATES = 2_000_000  # pairs of segments that are examined at a time


def touching_distance(lengths: Floats, points: Floats) -> Floats:
    """Distance up to which segments of some lengths (n,) touch in a mesh of points (n_points, 2)."""
    rounding = ROUNDING * float(np.ptp(points, axis=0).max())
    return np.clip(rounding, TOUCHING * lengths, 0.01 * lengths)


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where segments come together other than at a common end.

    Segments ``on`` which a point of another one lies, the other segments ``of``, and these points, each (n_touches,);
    pairs (n_crossings, 2) of segments that cross and do not touch.
    """

    on: Ints
    of: Ints
    points: Ints
    crossing: Ints


def meeting(points: Floats, segments: IntArray, groups: Ints | None = None) -> Meeting:
    """Find the segments, numbers of start and end (n, 2) among points (n_points, 2), that touch or cross.

    They may meet at a point that is an end of both. Only segments of one group (n,) are compared.
    """
    reach = touching_distance(np.hypot(*(points[segments[:, 1]] - points[segments[:, 0]]).T), points)
    parts = [_examined(points, segments, reach, i, j) for i, j in _candidates(points[segments], reach, groups)]
    on, of, met, crossing = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Meeting(on, of, met, crossing)


def _candidates(ends: Floats, reach: Floats, groups: Ints | None) -> list[tuple[Ints, Ints]]:
    """Pairs of segments whose shadows overlap in the direction with the fewest, in parts of limited size."""
    n = len(ends)
    low, high = ends.min(axis=1), ends.max(axis=1)
    best: tuple[int, Ints, Ints] | None = None
    middle = 0.5 * (low.min(axis=0) + high.max(axis=0))
    size = float((high - low).max()) + float(np.ptp(high, axis=0).max())
    for angle in DIRECTIONS:
        shadow = (ends - middle) @ np.array([np.cos(angle), np.sin(angle)])
        if groups is not None:  # one after the other, so that no two overlap
            shadow = shadow + 3.0 * size * groups[:, None]
        start, stop = shadow.min(axis=1), shadow.max(axis=1)
        order = np.argsort(start)
        margin = reach[order] + 1e-12 * np.abs(shadow).max()
        last = np.searchsorted(start[order], stop[order] + margin, side="right")
        counts = np.maximum(last - np.arange(n) - 1, 0)
        if best is None or counts.sum() < best[0]:
            best = (int(counts.sum()), order, counts)
    assert best is not None
    _, order, counts = best
    parts = []
    bounds = np.searchsorted(np.cumsum(counts), np.arange(0, best[0], MOST_CANDIDATES), side="left").tolist()
    for first, stop_row in zip(bounds, [*bounds[1:], n], strict=True):
        mine = counts[first:stop_row]
        rows = np.repeat(np.arange(first, stop_row), mine)
        others = rows + 1 + np.arange(len(rows)) - np.repeat(np.cumsum(mine) - mine, mine)
        i, j = order[rows], order[others]
        margin = reach[i, None]
        near = np.all((low[i] <= high[j] + margin) & (low[j] <= high[i] + margin), axis=1)
        parts.append((i[near], j[near]))
    return parts or [(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))]


def _examined(points: Floats, segments: IntArray, reach: Floats, i: Ints, j: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Touches (on, of, point) and crossings of the pairs (i, j)."""
    (a, b), (c, d) = segments[i].T, segments[j].T
    u, v = points[b] - points[a], points[d] - points[c]
    nearest = np.minimum(reach[i], reach[j])
    touched = np.zeros(len(i), dtype=bool)
    found = []
    turns = []
    for on, of, p, start, end, step in ((i, j, c, a, b, u), (i, j, d, a, b, u), (j, i, a, c, d, v), (j, i, b, c, d, v)):
        away = points[p] - points[start]
        turns.append(cross_product(step, away))
        along = np.einsum("ni,ni->n", away, step) / np.maximum(np.einsum("ni,ni->n", step, step), 1e-300)
        off = away - np.clip(along, 0.0, 1.0)[:, None] * step
        touches = (np.hypot(*off.T) <= nearest) & (p != start) & (p != end)
        touched |= touches
        found.append((on[touches], of[touches], p[touches]))
    shared = (a == c) | (a == d) | (b == c) | (b == d)
    crosses = (turns[0] * turns[1] < 0.0) & (turns[2] * turns[3] < 0.0) & ~touched & ~shared
    on, of, met = (np.concatenate(part).astype(np.int64) for part in zip(*found, strict=True))
    return on, of, met, np.column_stack([i[crosses], j[crosses]])


def layers(points: Floats, rim: IntArray) -> tuple[Ints, Ints]:
    """Count the cells that lie on each other along the boundary, edges (m, 2) with the body on their left.

    The edges do not cross. Cells that are positive and fit together edge by edge cover a place as many times as the
    boundary goes around it, and this number is constant along a chain of edges. Returned are one edge of each chain
    between points where the boundary touches itself, and the number of cells beside it on its left; 1 is right.
    """
    m = len(rim)
    leaving, counts = np.zeros(len(points), dtype=np.int64), np.bincount(rim[:, 0], minlength=len(points))
    leaving[rim[:, 0]] = np.arange(m)
    simple = counts[rim[:, 1]] == 1
    links = (np.ones(int(simple.sum())), (np.flatnonzero(simple), leaving[rim[simple, 1]]))
    n_chains, chain = connected_components(coo_array(links, shape=(m, m)), directed=False)
    if n_chains == 1:  # one closed curve, which positive cells fill once
        return np.zeros(1, dtype=np.int64), np.ones(1, dtype=np.int64)
    angle = DIRECTIONS[0]
    turned = points[rim] @ np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    start, step = turned[:, 0], turned[:, 1] - turned[:, 0]
    order = np.lexsort((-np.abs(step[:, 0]), chain))
    rows = order[np.searchsorted(chain[order], np.arange(n_chains))]
    rows = rows[np.argsort(turned[rows].mean(axis=1)[:, 0])]
    places = turned[rows].mean(axis=1)
    first = np.searchsorted(places[:, 0], turned[..., 0].min(axis=1))
    hits = np.searchsorted(places[:, 0], turned[..., 0].max(axis=1)) - first
    edge = np.repeat(np.arange(m), hits)
    probe = np.repeat(first - np.cumsum(hits) + hits, hits) + np.arange(len(edge))
    away = places[probe] - start[edge]
    height = step[edge, 0] * away[:, 1] - step[edge, 1] * away[:, 0]  # times the edge's length: of the probe over it
    forward = np.sign(step[edge, 0])
    own = np.sign(step[rows, 0])[probe]  # the ray goes to the left: up where the probe's edge goes forward
    lengths = np.hypot(*step.T)
    reach = touching_distance(lengths[rows], points)
    apart = np.abs(height) > 2.0 * lengths[edge] * reach[probe]
    hit: Bools = apart & (np.sign(height) * forward * own < 0.0)
    sums = np.bincount(probe, weights=np.where(hit, -own * forward, 0.0), minlength=len(rows))
    return rows, np.rint(sums).astype(np.int64)
