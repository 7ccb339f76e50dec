"""Gap between a wheel, a true surface of revolution, and points of a rail, along the rail's normals."""

from typing import NamedTuple

import numpy as np

from flangeway.railway.rigid.rigid_curve import RigidCurve
from flangeway.types import Floats

MOST_STEPS = 12
MAX_STEP_MM = 3.0
MET_MM = 1e-11
"""Distance from the wheel's surface at which a ray has met it."""
FAR_MM = 1e3
"""Gap of what does not meet."""


class WheelGap(NamedTuple):
    """Gaps and where they end, arrays (n, n_z) or (n, n_z, 3).

    - `gaps`: distances along the normals, `FAR_MM` where a ray does not meet the wheel.
    - `along`: position of the hit along the axle from its middle.
    - `by_motion`: derivative of the gap by a translation of the wheel: its outward normal over the share of that along
      the ray.
    - `arms`: from the wheel's origin on its axis to the hit.
    """

    gaps: Floats
    along: Floats
    by_motion: Floats
    arms: Floats


def wheel_gap(
    wheel: RigidCurve,
    middle: Floats,
    axis: Floats,
    points: Floats,
    normals: Floats,
    z: Floats,
    guess: Floats | None = None,
) -> WheelGap:
    """Distances from points of a rail to a wheel along the rail's normals.

    Parameters
    ----------
    wheel
        Profile about the middle of the axle: x along it, -y the rolling radius.
    middle, axis
        Origin of the profile on the wheel's axis (2,), in the plane z = 0, and the axis' direction, a unit vector (3,).
    points, normals
        Of the rail, each (n, 2); normals towards the wheel.
    z
        Planes along the track, shape (n_z,).
    guess
        Gaps from close by to start from, shape (n, n_z).

    """
    shape = (len(points), len(z))
    places = np.empty((*shape, 3))
    places[..., :2] = (points - middle)[:, None]
    places[..., 2] = z
    start: Floats = places.reshape(-1, 3)
    rays = np.repeat(np.pad(normals, ((0, 0), (0, 1))), len(z), axis=0)
    gaps: Floats = np.zeros(len(rays)) if guess is None else np.where(guess < FAR_MM, guess, 0.0).ravel()
    arms, gradient = np.empty_like(start), np.empty_like(start)
    along, error, slope = np.empty_like(gaps), np.empty_like(gaps), np.empty_like(gaps)
    left = np.arange(len(rays))  # rays that have not met the wheel
    for _ in range(MOST_STEPS):
        ray = rays[left]
        arms[left] = arm = start[left] + gaps[left, None] * ray
        along[left] = place = arm @ axis
        radial = arm - place[:, None] * axis
        radius = np.sqrt((radial**2).sum(axis=1))
        at = wheel.over(place)
        # f = r + y(x): positive outside of the wheel
        error[left] = wrong = radius + at.y
        gradient[left] = steepest = radial / radius[:, None] + np.tan(at.angle)[:, None] * axis
        slope[left] = falling = (steepest * ray).sum(axis=1)
        further = np.abs(wrong) >= MET_MM
        if not further.any():
            break
        wrong, falling, left = wrong[further], falling[further], left[further]
        step = np.where(falling < 0.0, -wrong / np.minimum(falling, -1e-3), MAX_STEP_MM * np.sign(wrong))
        gaps[left] += np.clip(step, -MAX_STEP_MM, MAX_STEP_MM)
    first, last = wheel.joints[[0, -1]]
    met = (np.abs(error) < 1e4 * MET_MM) & (slope < 0.0) & (along > first) & (along < last)
    by_motion = gradient / np.where(met, slope, -1.0)[:, None]
    each = (np.where(met, gaps, FAR_MM), along, by_motion, arms)
    return WheelGap(*(values.reshape(*shape, *values.shape[1:]) for values in each))
