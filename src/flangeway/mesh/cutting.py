"""Cutting of polygons of any shape along chords, until their diameters are halved and their notches are gone."""

import numpy as np
import shapely

from flangeway.geometry.arrays import angles_of, chain_lengths, cross_product, norms, sides_of, steps_around
from flangeway.types import Bools, Floats

HALVED = 0.55
"""Diameter of a part, relative to that of the whole polygon, that counts as half of it."""
NOTCH_REACH = 0.25
"""Length of the boundary beside a corner, relative to the diameter, whose chords make the angle of a notch."""
NOTCH_ANGLE = np.deg2rad(210.0)
"""Interior angle of these chords above which a corner is a notch: smaller ones are ragged boundaries."""
MIN_PART = 0.25
"""Diameter of a part relative to the whole below which it is not cut further."""
GOOD_ANGLE = np.deg2rad(40.0)
"""Angle between a chord and the boundary below which the chord counts as worse."""
MIN_AREA = 0.02
"""Area of the smaller part relative to the polygon below which a chord is not taken."""


def cut_polygon(corners: Floats, divisible: Bools) -> tuple[list[list[int]], Floats]:
    """Cut a simple counter-clockwise polygon into parts of about half its diameter, without notches.

    Every cut is the chord between two corners or middles of edges that leaves the rounder parts: area over squared
    diameter of the worse one, times the balance of areas and the angles with the boundary. At notches it begins there.

    Parameters
    ----------
    corners
        Shape (n, 2).
    divisible
        Edges, from each corner to the next one, whose middle may be an end of a chord, (n,).

    Returns
    -------
    tuple
        Parts as numbers of points in order, and all points: n corners, n middles of edges, then middles of chords.

    """
    points = np.vstack((corners, 0.5 * (corners + np.roll(corners, -1, axis=0))))
    n, whole = len(corners), diameter(corners)
    # middle of each edge (a, b), a < b, that may be divided
    middles = {tuple(sorted((i, (i + 1) % n))): n + i for i in np.flatnonzero(divisible).tolist()}
    middles = {edge: middle for edge, middle in middles.items() if _length(points, edge) > MIN_PART * whole}
    chords: dict[tuple[int, ...], int] = {}
    used: set[int] = set()
    open_parts, parts = [list(range(n))], []
    while open_parts:
        ring = open_parts.pop()
        size, notches = diameter(points[ring]), _notches(points[ring])
        if size <= MIN_PART * whole or (size <= HALVED * whole and not notches.any()):
            parts.append(ring)
            continue
        candidates: list[int] = []
        for a, b in sides_of(ring):
            middle = middles.get((min(a, b), max(a, b)))
            candidates += [a] if middle is None else [a, middle]
        at_notch = np.isin(candidates, np.array(ring)[notches])
        chord = best_chord(points[candidates], at_notch)
        if chord is None:
            parts.append(ring)
            continue
        first, last = chord
        kept = set(ring) | {candidates[first], candidates[last]}
        used |= {candidates[first], candidates[last]}
        for piece in (candidates[first : last + 1], candidates[last:] + candidates[: first + 1]):
            open_parts.append([point for point in piece if point in kept])  # noqa: PERF401 (a list for each part)
        edge = tuple(sorted((candidates[first], candidates[last])))
        if _length(points, edge) > MIN_PART * whole:
            middles[edge] = chords[edge] = len(points)
            points = np.vstack((points, points[list(edge)].mean(axis=0)))
    # a chord whose middle one of its parts has used has it in both
    for part in parts:
        for a, b in list(sides_of(part)):
            middle = chords.get((min(a, b), max(a, b)))
            if middle in used:
                part.insert(part.index(a) + 1, middle)
    return parts, points


def _length(points: Floats, edge: tuple[int, ...]) -> float:
    return float(norms(points[edge[0]] - points[edge[1]]))


def diameter(corners: Floats) -> float:
    """Maximum distance of two corners (n, 2)."""
    return float(norms(corners[:, None] - corners).max())


def has_notch(corners: Floats) -> bool:
    """Whether a polygon has a corner that must be cut."""
    return bool(_notches(corners).any())


def _notches(corners: Floats) -> Bools:
    """Corners with an interior angle that is reflex also at the scale of the polygon, (n,)."""
    steps = steps_around(corners)
    reflex = cross_product(np.roll(steps, 1, axis=0), steps) < 0.0
    result = np.zeros(len(corners), dtype=bool)
    if not reflex.any():
        return result
    closed, reach = np.vstack((corners, corners[:1])), NOTCH_REACH * diameter(corners)
    along = chain_lengths(closed)
    for i in np.flatnonzero(reflex):
        sides = []
        for shift in (reach, -reach):
            at = (along[i] + shift) % along[-1]
            sides.append([np.interp(at, along, closed[:, axis]) for axis in range(2)] - corners[i])
        result[i] = _angle(*sides) > NOTCH_ANGLE
    return result


def _angle(forward: Floats, back: Floats) -> Floats:
    """Counter-clockwise angle from one direction to another, 0 to 2 pi."""
    turn = angles_of(back) - angles_of(forward)
    return np.mod(turn, 2.0 * np.pi)


def best_chord(x: Floats, at_notch: Bools) -> tuple[int, int] | None:
    """The chord (i, j), i < j, inside a polygon with the highest score; None if there is none."""
    n = len(x)
    i, j = np.triu_indices(n, 2)
    terms = cross_product(x, np.roll(x, -1, axis=0))
    sums = np.concatenate(([0.0], np.cumsum(terms)))
    area = 0.5 * sums[-1]
    first = 0.5 * (sums[j] - sums[i] + cross_product(x[j], x[i]))
    small = np.minimum(first, area - first)
    forward, back = steps_around(x), np.roll(x, 1, axis=0) - x
    total, opening = _angle(forward, back), np.full(len(i), np.inf)
    cuts_notch = np.zeros(len(i), dtype=bool)
    for start, end in ((i, j), (j, i)):
        part = _angle(forward[start], x[end] - x[start])
        opening = np.minimum(opening, np.minimum(part, total[start] - part))
        widest = np.maximum(part, total[start] - part)
        cuts_notch |= at_notch[start] & (widest < NOTCH_ANGLE - 0.2)
    diameters = _part_diameters(x)
    round_first = first / diameters[i, j - i] ** 2
    round_second = (area - first) / diameters[j, n - (j - i)] ** 2
    score = np.minimum(round_first, round_second) * np.sqrt(np.maximum(small, 0.0) / area)
    score = score * np.clip(opening / GOOD_ANGLE, 0.0, 1.0)
    score[small <= MIN_AREA * area] = 0.0
    score = np.where(cuts_notch, score + 1.0, score) * (score > 0.0)
    ring = shapely.linearrings(x)
    shapely.prepare(ring)
    for pair in np.argsort(-score, kind="stable"):
        if score[pair] <= 0.0:
            break
        ends = int(i[pair]), int(j[pair])
        # the inside of the chord meets no point of the boundary
        if shapely.relate_pattern(shapely.linestrings(x[list(ends)]), ring, "F********"):
            return ends
    return None


def _part_diameters(x: Floats) -> Floats:
    """Diameters (n, n) of the points i to i + l, cyclically: that of the longest of both shorter runs, or its ends."""
    n = len(x)
    distances = norms(x[:, None] - x)
    every, result = np.arange(n), np.zeros((n, n))
    for length in range(1, n):
        shorter = result[:, length - 1]
        ends = distances[every, (every + length) % n]
        result[:, length] = np.maximum(np.maximum(shorter, np.roll(shorter, -1)), ends)
    return result
