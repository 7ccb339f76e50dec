"""Outlines of simple shapes with named sides."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_integer, check_positive
from flangeway.errors import InputError
from flangeway.geometry.arrays import Point, as_point, as_points, sides_of
from flangeway.geometry.outline import Outline
from flangeway.geometry.segments import Arc, Line


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


def circle(radius: float, centre: Point = (0.0, 0.0), n_arcs: int = 4) -> Outline:
    """Return the circle made of equal arcs, all named ``circle``, the first from angle zero.

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
    return Outline.from_segments(arcs, ["circle"] * n_arcs)
