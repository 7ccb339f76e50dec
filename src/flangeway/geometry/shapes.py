"""Outlines of simple shapes with named sides, and of rolled and built-up sections by their dimensions."""

import itertools
import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_between, check_integer, check_positive, is_finite
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point, as_point, as_points, norms, point_text, sides_of
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region
from flangeway.geometry.segments import Arc, Line, segment_of

# --- Outlines of simple shapes with named sides.


def _refuse_not_positive(owner: str, **lengths: float) -> None:
    for name, value in lengths.items():
        check_positive(owner, name, value, "a positive length")


def polygon(points: ArrayLike, names: Sequence[str] | None = None) -> Outline:
    """Return the polygon with corners (n, 2); a clockwise one is reversed.

    Parameters
    ----------
    points
        Corners (n, 2), the first not repeated at the end.
    names
        Name of the side from corner i to corner i + 1; ``side_0``, ``side_1``, ... by default.

    Raises
    ------
    InputError
        If corners coincide, sides meet elsewhere than at corners, or there is no area.
    """
    corners = as_points(points, "corners")
    if len(corners) < 3:
        raise InputError(f"{len(corners)} corners", "three corners or more", "add corners")
    if np.array_equal(corners[0], corners[-1]):
        raise InputError(
            f"corner 0 repeated as corner {len(corners) - 1}", "corners that differ", "leave the closing corner out"
        )
    labels = [f"side_{i}" for i in range(len(corners))] if names is None else names
    ends = [as_point(corner) for corner in corners]
    sides = [Line(a, b) for a, b in sides_of(ends)]
    return Outline.from_segments(sides, labels)


def rectangle(width: float, height: float, centre: Point = (0.0, 0.0)) -> Outline:
    """Return the rectangle with sides ``bottom``, ``right``, ``top``, ``left``."""
    _refuse_not_positive("rectangle", width=width, height=height)
    x, y = as_point(centre, "centre")
    a, b = 0.5 * width, 0.5 * height
    corners = [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]
    return polygon(corners, ("bottom", "right", "top", "left"))


def square(side: float, centre: Point = (0.0, 0.0)) -> Outline:
    """Return the square with sides ``bottom``, ``right``, ``top``, ``left``."""
    _refuse_not_positive("square", side=side)
    return rectangle(side, side, centre)


def circle(radius: float, centre: Point = (0.0, 0.0), n_arcs: int = 4, name: str = "circle") -> Outline:
    """Return the circle made of equal arcs of one name, the first from angle zero.

    Raises
    ------
    InputError
        If the radius is not positive or there are fewer than two arcs.
    """
    _refuse_not_positive("circle", radius=radius)
    check_integer("circle", "n_arcs", n_arcs, 2, advice="take two arcs or more: a closed arc has no ends")
    x, y = as_point(centre, "centre")
    angles = 2.0 * np.pi * np.arange(n_arcs) / n_arcs
    ends = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]
    arcs = [Arc(a, b, (x, y), True) for a, b in sides_of(ends)]
    return Outline.from_segments(arcs, [name] * n_arcs)


def half_disc(
    radius: float,
    centre: Point = (0.0, 0.0),
    half: Literal["lower", "upper"] = "lower",
    arc: float | None = None,
) -> Outline:
    """Return the half of a disc below or above its centre: the arc ``rim`` and the straight side ``cut``.

    Parameters
    ----------
    radius, centre
        Of the disc.
    half
        Which half.
    arc
        Angle in radians of a part of the rim about its middle, which gets the name ``arc``; None: there is none.

    Raises
    ------
    InputError
        If the radius is not positive, the half is none of both, or the arc is not below half a turn.
    """
    _refuse_not_positive("half_disc", radius=radius)
    if half not in ("lower", "upper"):
        raise InputError(f"half_disc(half={half!r})", "'lower' or 'upper'", "choose one of these")
    x, y = as_point(centre, "centre")
    sign = 1.0 if half == "upper" else -1.0
    first, last = (x + sign * radius, y), (x - sign * radius, y)
    if arc is None:
        corners, names = [(x, y + sign * radius)], ["rim", "rim"]
    else:
        check_between("half_disc", "arc", arc, 0.0, math.pi)
        angles = np.pi / 2.0 + arc / 2.0 * np.array([-1.0, 1.0])
        ends = centre + sign * radius * np.column_stack((np.cos(angles), np.sin(angles)))
        corners, names = [(float(a), float(b)) for a, b in ends], ["rim", "arc", "rim"]
    arcs = [Arc(a, b, (x, y), counter_clockwise=True) for a, b in itertools.pairwise([first, *corners, last])]
    return Outline.from_segments([Line(last, first), *arcs], ["cut", *names])


# --- Outlines of rolled and built-up sections by their dimensions, their frame from the origin to width and depth.


Side = tuple[Point, Point, Point | None, bool, str]
"""Start, end and, of an arc, centre and whether it runs counter-clockwise; and its name."""


def rounded_sides(corners: Sequence[Point], radii: Sequence[float], names: Sequence[str]) -> list[Side]:
    """Return the sides of a polygon with an arc at each corner, of the radius there; none for zero.

    An arc is named after its corner, from ``corner_1`` on, a side after the corner where it starts. An `InputError` if
    a radius is negative, where there is no corner, or too large for its sides.
    """
    n = len(corners)
    arcs = [_fillet(corners[i - 1], corners[i], corners[(i + 1) % n], radii[i], f"corner_{i + 1}") for i in range(n)]
    drawn: list[Side] = []
    for i, arc in enumerate(arcs):
        following, corner, other = arcs[(i + 1) % n], corners[i], corners[(i + 1) % n]
        if arc[2] is not None:
            drawn.append(arc)
        side, cut = math.dist(corner, other), math.dist(arc[1], corner) + math.dist(following[0], other)
        if cut > side * (1.0 + 1e-9):
            raise InputError(
                f"radii {radii[i]:g} and {radii[(i + 1) % n]:g} at {point_text(corner)} and {point_text(other)}, "
                f"which cut {cut:.6g} off a side of {side:.6g}",
                "radii that leave room on the side",
                "reduce one of both",
            )
        if cut < side * (1.0 - 1e-9):
            drawn.append((arc[1], following[0], None, True, names[i]))
    # arcs that meet exactly share their end
    return [(before[1], *side[1:]) for before, side in itertools.pairwise([drawn[-1], *drawn])]


def _fillet(before: Point, corner: Point, after: Point, radius: float, name: str) -> Side:
    """Return the arc that rounds a corner; one of no length, without a centre, for radius zero."""
    if not (is_finite(radius) and radius >= 0.0):
        raise InputError(
            f"{point_text(corner)}: radius {short(radius)}", "zero or a positive length", "give 0 for sharp corners"
        )
    if radius == 0.0:
        return corner, corner, None, True, name
    u, v = np.subtract(before, corner), np.subtract(after, corner)
    u, v = u / norms(u), v / norms(v)
    turn = float(u[1] * v[0] - u[0] * v[1])
    half_angle = 0.5 * math.atan2(abs(turn), float(u @ v))
    if abs(turn) < 1e-9:
        raise InputError(
            f"{point_text(corner)}: radius {radius:g} where there is no corner", "a radius at a corner", "remove it"
        )
    reach, bisector = radius / math.tan(half_angle), (u + v) / norms(u + v)
    start, end = as_point(corner + reach * u), as_point(corner + reach * v)
    return start, end, as_point(corner + radius / math.sin(half_angle) * bisector), turn > 0.0, name


def rounded_polygon(corners: Sequence[Point], radii: Sequence[float]) -> Outline:
    """Return the polygon with counter-clockwise corners, each rounded by an arc of its radius where that is not zero.

    Sides are named ``side_1``, ``side_2``, ..., arcs ``corner_1``, ...; errors as of `rounded_sides`.
    """
    if len(radii) != len(corners):
        raise InputError(f"{len(radii)} radii for {len(corners)} corners", "one for each", "give 0 for sharp corners")
    sides = rounded_sides(corners, radii, [f"side_{i + 1}" for i in range(len(corners))])
    return Outline.from_segments([segment_of(*side[:4]) for side in sides], [side[4] for side in sides])


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
