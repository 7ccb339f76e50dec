"""A wheel that is turned about the vertical: its outline across the track, and what it touches there.

A wheel is a surface of revolution, a rail is a prism. In the longitudinal view the wheel is bounded below by the points
whose normal lies across the track: where the profile has the angle ``a``, the point of its circle that is the angle
``t`` ahead of the lowest one, ``sin t = -tan a tan yaw``. Their outline has the angle ``b``,
``sin b = sin a / cos yaw``, and is a plane curve that comes down on the rail as a profile without yaw does. Roll turns
the outline about the axis of the view.

On a flange the points lie some millimetres to centimetres ahead of the axle, or behind it. Where the profile is so
hollow that the outline would turn back, as in the flange root at large yaw, the lower envelope is taken: what turns
back lies inside the wheel.
"""

import math

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.railway.rigid.rigid_curve import RigidCurve
from flangeway.types import Floats

MAX_YAW_RAD = 0.2  # maximum yaw; beyond it steep flanges touch at the height of the axle

_SPACING_MM = 0.1
_EDGE_STEP_RAD = 0.02
_MAX_SINE = 0.95
_SAME_MM = 1e-9
_APART_MM = 1e-5


def outline_across(profile: RigidCurve, yaw_rad: float) -> RigidCurve:
    """Outline of a yawed wheel in the longitudinal view.

    Returned: about the middle of the axle: x across the track, y up. Without yaw the profile itself. An `InputError` if
    the yaw is larger than `MAX_YAW_RAD`.

    - `profile`: about the middle of the axle: x along it to the field side, -y the rolling radius.
    - `yaw_rad`: rotation about the axis that is normal to the axle and to the track; its sign does not matter.
    """
    if not abs(yaw_rad) <= MAX_YAW_RAD:
        raise InputError(
            f"a yaw of {yaw_rad:g} rad", f"-{MAX_YAW_RAD:g} to {MAX_YAW_RAD:g} rad", "give 5 mrad as 0.005"
        )
    if yaw_rad == 0.0:
        return profile
    x, y, angle = _with_edges(profile)
    sine = np.tan(angle) * math.tan(abs(yaw_rad))
    seen = np.abs(sine) < _MAX_SINE
    x, y, angle, sine = x[seen], y[seen], angle[seen], sine[seen]
    across = x * math.cos(yaw_rad) - y * sine * math.sin(abs(yaw_rad))
    height = y * np.sqrt(1.0 - sine**2)
    kept = _lowest(across, height)
    across, height = across[kept], height[kept]
    slope = np.tan(np.arcsin(np.sin(angle[kept]) / math.cos(yaw_rad)))
    apart = np.concatenate(([True], np.diff(across) > _APART_MM))
    return RigidCurve.from_graph(across[apart], height[apart], slope[apart])


def on_profile(across: Floats, height: Floats, angle: Floats, yaw_rad: float) -> tuple[Floats, Floats, Floats]:
    """Where points of the outline lie on the wheel.

    Returned: position along the axle, rolling radius, and longitudinal distance by which the point is ahead of the
    axle.

    - `across`, `height`, `angle`: points of `outline_across` and angles of its tangent, any shape.
    - `yaw_rad`: the yaw; positive where this wheel is ahead of the other one.
    """
    tangent = math.tan(yaw_rad)
    sine = -np.tan(np.arcsin(np.sin(angle) * math.cos(yaw_rad))) * tangent
    radius = -height / np.sqrt(1.0 - sine**2)
    along = across / math.cos(yaw_rad) + radius * sine * tangent
    return along, radius, radius * sine / math.cos(yaw_rad)


def _with_edges(profile: RigidCurve) -> tuple[Floats, Floats, Floats]:
    """Dense points of a profile; at an edge with the angles between those of its sides."""
    points = profile.sampled(_SPACING_MM)
    turn = np.diff(points.angle)
    counts = np.where(np.hypot(np.diff(points.x), np.diff(points.y)) < _SAME_MM, turn / _EDGE_STEP_RAD, 0.0)
    repeats = np.append(1 + np.maximum(np.floor(counts), 0.0).astype(np.int64), 1)
    source = np.repeat(np.arange(len(repeats)), repeats)
    number = np.arange(len(source)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    angle = points.angle[source] + np.append(turn, 0.0)[source] * number / repeats[source]
    return points.x[source], points.y[source], angle


def _lowest(x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Which points of a chain that may turn back belong to its lower envelope."""
    steps = np.diff(x)
    if (steps > -_SAME_MM).all():
        return np.ones(len(x), dtype=np.bool_)
    low, high = np.minimum(x[1:], x[:-1]), np.maximum(x[1:], x[:-1])
    lowest = np.full(len(x), np.inf)
    for part in np.array_split(np.arange(len(x)), max(len(x) // 256, 1)):
        below = (x[part, None] >= low) & (x[part, None] <= high) & (high - low > _SAME_MM)
        heights = y[:-1] + (x[part, None] - x[:-1]) * np.divide(np.diff(y), steps, where=steps != 0.0, out=0.0 * steps)
        lowest[part] = np.where(below, heights, np.inf).min(axis=1)
    kept: NDArray[np.bool_] = y <= lowest + _SAME_MM
    forward = np.concatenate((steps[:1], steps)) > -_SAME_MM
    return kept & (forward | np.append(forward[1:], True))
