"""Outlines of rolled and built-up sections by their dimensions, their frame from the origin to width and depth."""

import math
from collections.abc import Sequence

from flangeway.checks import check_positive
from flangeway.errors import InputError
from flangeway.geometry.arrays import Point
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region
from flangeway.geometry.segments import Arc, Line
from flangeway.geometry.shapes import circle, rectangle


def rounded_polygon(corners: Sequence[Point], radii: Sequence[float]) -> Outline:
    """Return the polygon with counter-clockwise corners, each rounded by an arc of its radius where that is not zero.

    Sides are named ``side_0``, ``side_1``, ..., arcs ``corner_0``, ...

    Raises
    ------
    InputError
        If a radius is negative, or arcs are longer than the side between them.

    """
    n, ends, arcs, cut = len(corners), [], [], [0.0] * len(corners)
    if len(radii) != n or min(radii) < 0.0:
        raise InputError(f"radii {list(radii)} for {n} corners", "a number >= 0 for each", "give 0 for sharp corners")
    for i, ((x, y), radius) in enumerate(zip(corners, radii, strict=True)):
        (ax, ay), (bx, by) = corners[i - 1], corners[(i + 1) % n]
        before, after = math.atan2(ay - y, ax - x), math.atan2(by - y, bx - x)
        half = math.remainder(before - after, 2.0 * math.pi) / 2.0  # negative where the corner is reentrant
        cut[i] = radius / math.tan(abs(half))
        first, last = ((x + cut[i] * math.cos(a), y + cut[i] * math.sin(a)) for a in (before, after))
        middle, reach = after + half, radius / math.sin(abs(half))
        centre = (x + reach * math.cos(middle), y + reach * math.sin(middle))
        ends.append((first, last))
        arcs.append(Arc(first, last, centre, counter_clockwise=half > 0.0) if radius else None)
    sides: list[Line | Arc] = []
    names = []
    for i in range(n):
        if cut[i] + cut[(i + 1) % n] >= math.dist(corners[i], corners[(i + 1) % n]):
            raise InputError(f"radii {radii[i]} and {radii[(i + 1) % n]} on side {i}", "smaller ones", "reduce them")
        sides.append(Line(ends[i][1], ends[(i + 1) % n][0]))
        names.append(f"side_{i}")
        arc = arcs[(i + 1) % n]
        if arc is not None:
            sides.append(arc)
            names.append(f"corner_{(i + 1) % n}")
    return Outline.from_segments(sides, names)


def i_section(depth: float, width: float, flange: float, web: float, radius: float = 0.0) -> Outline:
    """Return an I or H section with equal flanges; thicknesses of flange and web, radius of the roots."""
    left, right = (width - web) / 2.0, (width + web) / 2.0
    low, high = _room("i_section", flange, depth - flange), depth - flange
    _room("i_section", left, right, width)
    corners = [(0, 0), (width, 0), (width, low), (right, low), (right, high), (width, high),
               (width, depth), (0, depth), (0, high), (left, high), (left, low), (0, low)]  # fmt: skip
    return rounded_polygon(corners, [0, 0, 0, radius, radius, 0] * 2)


def channel_section(depth: float, width: float, flange: float, web: float, radius: float = 0.0) -> Outline:
    """Return a channel open to the right."""
    low, high = _room("channel_section", flange, depth - flange), depth - flange
    _room("channel_section", web, width)
    corners = [(0, 0), (width, 0), (width, low), (web, low), (web, high), (width, high), (width, depth), (0, depth)]
    return rounded_polygon(corners, [0, 0, 0, radius, radius, 0, 0, 0])


def tee_section(depth: float, width: float, flange: float, web: float, radius: float = 0.0) -> Outline:
    """Return a T section with its flange on top."""
    left, right, low = (width - web) / 2.0, (width + web) / 2.0, depth - flange
    _room("tee_section", left, right, width)
    _room("tee_section", low, depth)
    corners = [(left, 0), (right, 0), (right, low), (width, low), (width, depth), (0, depth), (0, low), (left, low)]
    return rounded_polygon(corners, [0, 0, radius, 0, 0, 0, 0, radius])


def angle_section(depth: float, width: float, thickness: float, root: float = 0.0, toe: float = 0.0) -> Outline:
    """Return an angle with its corner at the origin; radius of the root and of the toes."""
    _room("angle_section", thickness, width)
    _room("angle_section", thickness, depth)
    t = thickness
    corners = [(0, 0), (width, 0), (width, t), (t, t), (t, depth), (0, depth)]
    return rounded_polygon(corners, [0, 0, toe, root, toe, 0])


def box_section(depth: float, width: float, wall: float) -> Region:
    """Return a rectangular hollow section with sharp corners."""
    _room("box_section", wall, depth - wall)
    _room("box_section", wall, width - wall)
    centre = (width / 2.0, depth / 2.0)
    return Region(rectangle(width, depth, centre), (rectangle(width - 2.0 * wall, depth - 2.0 * wall, centre),))


def pipe_section(diameter: float, wall: float) -> Region:
    """Return a circular hollow section about the origin."""
    _room("pipe_section", wall, diameter / 2.0)
    return Region(circle(diameter / 2.0), (circle(diameter / 2.0 - wall),))


def _room(owner: str, *lengths: float) -> float:
    """Check that lengths are positive and rise, and return the first."""
    for before, after in zip((0.0, *lengths), lengths, strict=False):
        check_positive(owner, "a dimension", after - before, advice="walls must fit into width and depth")
    return lengths[0]
