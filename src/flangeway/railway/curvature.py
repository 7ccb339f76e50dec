"""Curvatures of profiles at points of contact."""

import numpy as np
from numpy.typing import ArrayLike

from flangeway.railway.profiles import RailProfile, WheelProfile


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
