"""First touch of wheels that are lowered on rails, as rigid curves."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.curvature import relative_curvature
from flangeway.railway.track import SIDES, Side, Track, Wheelset, WheelsetMotion

Floats = NDArray[np.float64]

SPACING_MM = 0.02
WINDOW_MM = 3.0  # about the coarse touch, where the curves are graphs over x


@dataclass(frozen=True)
class FirstTouch:
    """Where a wheel that is lowered without roll first touches its rail.

    Parameters
    ----------
    side
        Side of the track.
    vertical_mm
        Vertical motion from the reference position to the touch, up.
    point_mm
        Point of touch in space.
    wheel_point_mm, rail_point_mm
        The same point in the frames of the wheel's and the rail's profile.
    relative_curvature_per_mm
        Sum of the curvatures of the two profiles there.

    """

    side: Side
    vertical_mm: float
    point_mm: tuple[float, float]
    wheel_point_mm: tuple[float, float]
    rail_point_mm: tuple[float, float]
    relative_curvature_per_mm: float


def first_touch(track: Track, wheelset: Wheelset, side: Side, lateral_mm: float = 0.0) -> FirstTouch:
    """Lower a wheel on its rail, moved to the right by `lateral_mm`.

    Raises
    ------
    InputError
        If no point of the wheel's running surface stands over the rail's head.

    """
    wheel_placement = Placement(translation=(lateral_mm, 0.0)).after(wheelset.placement(side))
    rail_placement = track.placement(side)
    wheel_profile, rail_profile = wheelset.wheel_of(side), track.rail_of(side)
    wheel_curve = wheel_profile.outline.part(wheel_profile.running_names)
    rail_curve = rail_profile.outline.part(rail_profile.head_names)
    wheel = wheel_placement.points(wheel_curve.sampled(spacing=SPACING_MM))
    rail = rail_placement.points(rail_curve.sampled(spacing=SPACING_MM))
    x = np.arange(
        max(wheel[:, 0].min(), rail[:, 0].min()),
        min(wheel[:, 0].max(), rail[:, 0].max()),
        SPACING_MM,
    )
    if len(x) < 2:
        raise InputError(
            f"a {side} wheel that spans x = {wheel[:, 0].min():.1f} to {wheel[:, 0].max():.1f} mm over a "
            f"rail head from {rail[:, 0].min():.1f} to {rail[:, 0].max():.1f} mm",
            "a wheel that stands over its rail",
            "check gauge_mm and back_to_back_mm",
        )
    gap = _envelope(wheel, x, lowest=True) - _envelope(rail, x, lowest=False)
    place = int(np.argmin(gap))
    if place in (0, len(x) - 1):
        raise InputError(
            f"a {side} wheel whose first touch is at the edge of its running surface, x = {x[place]:.1f} mm",
            "a touch inside the rail's head and the wheel's running surface",
            "check gauge_mm and back_to_back_mm",
        )
    near = x[place] + np.linspace(-WINDOW_MM, WINDOW_MM, 6001)
    on_rail_near = _graph(rail, near, float(_envelope(rail, x, lowest=False)[place]))
    exact = _graph(wheel, near, float(_envelope(wheel, x, lowest=True)[place])) - on_rail_near
    touching = int(np.argmin(exact))
    vertical = -float(exact[touching])
    point = (float(near[touching]), float(on_rail_near[touching]))
    on_wheel = wheel_placement.inverse().points([(point[0], point[1] - vertical)])[0]
    on_rail = rail_placement.inverse().points([point])[0]
    return FirstTouch(
        side,
        vertical,
        point,
        (float(on_wheel[0]), float(on_wheel[1])),
        (float(on_rail[0]), float(on_rail[1])),
        relative_curvature(wheel_profile, on_wheel, rail_profile, on_rail),
    )


def touching_motion(track: Track, wheelset: Wheelset) -> tuple[WheelsetMotion, list[FirstTouch]]:
    """Vertical motion at which the first of the two wheels touches, and both sides' touches."""
    touches = [first_touch(track, wheelset, side) for side in SIDES]
    return WheelsetMotion(vertical_mm=max(touch.vertical_mm for touch in touches)), touches


def _graph(points: Floats, x: Floats, height: float) -> Floats:
    """Height over each x of the branch of a curve that runs near a height, its chords interpolated."""
    close = (np.abs(points[:, 0] - x.mean()) < 2.0 * WINDOW_MM) & (np.abs(points[:, 1] - height) < WINDOW_MM)
    branch = points[close][np.argsort(points[close, 0])]
    return np.interp(x, branch[:, 0], branch[:, 1])


def _envelope(points: Floats, x: Floats, *, lowest: bool) -> Floats:
    """Lowest or highest height of a curve over each x, by cells of the grid, gaps interpolated."""
    sign = 1.0 if lowest else -1.0
    cell = np.rint((points[:, 0] - x[0]) / SPACING_MM).astype(int)
    inside = (cell >= 0) & (cell < len(x))
    height = np.full(len(x), np.inf)
    np.minimum.at(height, cell[inside], sign * points[inside, 1])
    known = np.isfinite(height)
    return sign * np.interp(x, x[known], height[known])
