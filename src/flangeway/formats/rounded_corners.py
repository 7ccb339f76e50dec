"""Polygons with rounded corners, and arcs through three points."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from flangeway.checks import is_finite
from flangeway.errors import InputError, short
from flangeway.formats.outline_repair import DrawnSegment
from flangeway.geometry.arrays import Point, point_text


def rounded_polygon(
    corners: Sequence[Point], radii: Sequence[float], names: Sequence[str], what: str
) -> list[DrawnSegment]:
    """Return the sides of a polygon with an arc at each corner, of the radius there; none for zero.

    An arc is named after its corner, a side after the corner where it starts. An `InputError` if a radius is negative
    or too large for its sides.
    """
    n = len(corners)
    arcs = [
        _fillet(corners[i - 1], corners[i], corners[(i + 1) % n], radii[i], f"{what}: {point_text(corners[i])}", i)
        for i in range(n)
    ]
    drawn: list[DrawnSegment] = []
    for i, arc in enumerate(arcs):
        following = arcs[(i + 1) % n]
        if arc.centre is not None:
            drawn.append(arc)
        side = math.dist(corners[i], corners[(i + 1) % n])
        cut = math.dist(arc.end, corners[i]) + math.dist(following.start, corners[(i + 1) % n])
        if cut > side * (1.0 + 1e-9):
            raise InputError(
                f"{what}: radii {radii[i]:g} and {radii[(i + 1) % n]:g} at {point_text(corners[i])} and "
                f"{point_text(corners[(i + 1) % n])}, which cut {cut:.6g} off a side of {side:.6g}",
                "radii that leave room on the side",
                "reduce one of both",
            )
        if cut < side * (1.0 - 1e-9):
            drawn.append(DrawnSegment(arc.end, following.start, name=names[i]))
    # arcs that meet exactly share their end
    return [
        DrawnSegment(before.end, s.end, s.centre, s.counter_clockwise, s.name)
        for before, s in itertools.pairwise([drawn[-1], *drawn])
    ]


def through_arc(start: Point, middle: Point, end: Point, name: str, what: str) -> DrawnSegment:
    """Return the arc from `start` through `middle` to `end`; points on one line are an `InputError`."""
    a, b = np.subtract(middle, start), np.subtract(end, start)
    cross = float(a[0] * b[1] - a[1] * b[0])
    if not abs(cross) > 1e-9 * float(np.hypot(*a) * np.hypot(*b)):
        raise InputError(
            f"{what}: an arc through three points on one line, {short(start)}, {short(middle)}, {short(end)}",
            "a point that is off the line from start to end",
            "use line_to, or move the point",
        )
    rays = np.array([[b[1], -a[1]], [-b[0], a[0]]]) @ np.array([a @ a, b @ b]) / (2.0 * cross)
    centre = (start[0] + float(rays[0]), start[1] + float(rays[1]))
    return DrawnSegment(start, end, centre, cross > 0.0, name)


def _fillet(before: Point, corner: Point, after: Point, radius: float, what: str, number: int) -> DrawnSegment:
    """Return the arc that rounds a corner; one of no length, without a centre, for radius zero."""
    if not (is_finite(radius) and radius >= 0.0):
        raise InputError(f"{what}: radius {short(radius)}", "zero or a positive length", "correct it")
    if radius == 0.0:
        return DrawnSegment(corner, corner)
    u, v = np.subtract(before, corner), np.subtract(after, corner)
    u, v = u / np.hypot(*u), v / np.hypot(*v)
    turn = float(u[1] * v[0] - u[0] * v[1])
    half_angle = 0.5 * math.acos(float(np.clip(u @ v, -1.0, 1.0)))
    if abs(turn) < 1e-9:
        raise InputError(f"{what}: radius {radius:g} where there is no corner", "a radius at a corner", "remove it")
    reach = radius / math.tan(half_angle)
    bisector = (u + v) / np.hypot(*(u + v))
    start, end = corner + reach * u, corner + reach * v
    centre = corner + radius / math.sin(half_angle) * bisector
    return DrawnSegment(
        (float(start[0]), float(start[1])),
        (float(end[0]), float(end[1])),
        (float(centre[0]), float(centre[1])),
        turn > 0.0,
        f"corner_{number + 1}",
    )
