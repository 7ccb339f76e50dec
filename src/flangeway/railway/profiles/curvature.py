"""Curvatures of profiles at points of contact."""

import numpy as np
from numpy.typing import ArrayLike

from flangeway.geometry import Contour, FloatArray
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile

MAX_WIDTH = 0.5
"""Half width of a contact over a radius of its bodies above which these are no half planes for it."""

MAX_CHANGE = 1.5
"""Factor between the gap at an end of the contact and that of constant curvature up to which it is one of Hertz's."""

_N_ALONG = 50


def relative_curvature(wheel: WheelProfile, wheel_point: ArrayLike, rail: RailProfile, rail_point: ArrayLike) -> float:
    """Sum of the curvatures of a wheel and a rail at points in their own frames, 1/mm; convex is positive."""
    total = 0.0
    for outline, names, point in (
        (wheel.outline, wheel.running_names, wheel_point),
        (rail.outline, rail.head_names, rail_point),
    ):
        curve = outline.part(names)
        segment = int(curve.closest(np.atleast_2d(point))[0][0])
        total += curve.segments[segment].curvature
    return total


def conforming(
    wheel: WheelProfile, wheel_point: ArrayLike, rail: RailProfile, rail_point: ArrayLike, half_width_mm: float
) -> bool:
    """Whether a contact is none of Hertz's, whose curvatures are constant and whose width is small against the radii.

    It is one where Hertz's own half width a exceeds `MAX_WIDTH` times the smallest radius of either profile over
    it, or the gap of the profiles at either end of it, ``int_0^a (a - s) k(s) ds`` with the relative curvature k along
    the surfaces, is not that of the curvature at the middle, ``k(0) a^2 / 2``, within a factor of `MAX_CHANGE`.

    Parameters
    ----------
    wheel, wheel_point, rail, rail_point
        Profiles, and the points of contact in their frames, each (2,).
    half_width_mm
        Hertz's half width for the curvatures at these points, > 0.

    """
    along = half_width_mm * (np.arange(_N_ALONG) + 0.5) / _N_ALONG
    along = np.concatenate([-along[::-1], along])
    # both surfaces have their steel at the left: one runs against the other
    of_wheel, of_rail = (
        _curvatures(wheel.running_surface, wheel_point, along),
        _curvatures(rail.running_surface, rail_point, -along),
    )
    if half_width_mm * max(np.abs(of_wheel).max(), np.abs(of_rail).max()) > MAX_WIDTH:
        return True
    weights = half_width_mm - np.abs(along)
    middle = relative_curvature(wheel, wheel_point, rail, rail_point)
    ends = [
        float((weights * (of_wheel + of_rail))[side].sum() / weights[side].sum()) for side in (along < 0, along > 0)
    ]
    return not all(1.0 / MAX_CHANGE <= end / middle <= MAX_CHANGE for end in ends)


def _curvatures(surface: Contour, point: ArrayLike, along: FloatArray) -> FloatArray:
    """Curvatures (n,) of a surface at lengths (n,) along it from a point; those of its ends beyond them."""
    lengths = np.cumsum([segment.length for segment in surface.segments])
    numbers, parameters, _ = surface.closest(np.atleast_2d(point))
    i = int(numbers[0])
    place = lengths[i] - (1.0 - float(parameters[0])) * surface.segments[i].length
    found = np.minimum(np.searchsorted(lengths, place + along), len(lengths) - 1)
    curvatures: FloatArray = np.array([segment.curvature for segment in surface.segments])[found]
    return curvatures
