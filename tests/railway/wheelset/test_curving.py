"""Conical wheels on points: steady curving and Klingel's motion without creepage, against the closed forms.

With the conicity c, the distance b of the contacts from the middle and the radius r, a wheelset in a curve of radius R
rolls without longitudinal creepage at y = r b / (c R), and on straight track with a wavelength of 2 pi sqrt(r b / c).
Both hold for contacts that stay at their distance, without roll: to first order in y.
"""

import numpy as np
import pytest

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.materials import Elastic
from flangeway.railway.rigid.conicity import klingel_wavelength
from flangeway.railway.track.placements import SIDE_SIGN, SIDES
from flangeway.railway.wheelset.rolling.rolling_motion import RollingMotion
from flangeway.railway.wheelset.rolling.wheelset_creep import WheelsetCreep
from flangeway.railway.wheelset.side_contact import WheelPose

CONICITY, RADIUS, ARM, SPEED = 0.05, 460.0, 750.0, 20.0


def creepages(lateral, yaw=0.0, **motion):
    """Longitudinal and lateral creepage of both wheels, (2, 2), the lateral one to the right."""
    steel = Elastic(210e3, 0.3)
    grid = PatchGrid(np.linspace(-1.0, 1.0, 3), 1.0, 2)
    patch = RollingContact.between_half_spaces(grid, np.ones((2, 2)), Friction(0.3), (steel, steel))
    rate = 1e3 * SPEED / RADIUS
    creep = WheelsetCreep(RollingMotion(SPEED, Friction(0.3), **motion), rate, "exact")
    found = []
    for side in SIDES:
        sign = SIDE_SIGN[side]
        pose = WheelPose(sign * lateral, RADIUS, 0.0, sign * yaw)
        points = np.tile([ARM, -sign * CONICITY * lateral], (2, 1))
        points[:, 0] += sign * lateral  # the arm is that from the axle's middle
        each = creep.creepages(side, pose, rate, (points, np.tile([0.0, 1.0], (2, 1))), patch)
        at = each.rigid(*patch.places).mean(axis=(0, 2))
        found.append((at[1], -sign * at[0]))
    return np.array(found)


@pytest.mark.parametrize("curve_m", [300.0, -1000.0])
def test_steady_position_of_cones_in_a_curve(curve_m):
    """There is no longitudinal creepage at y = r b / (c R); in the middle it is b / R, of the other sign inside."""
    lateral = RADIUS * ARM / (CONICITY * 1e3 * curve_m)
    assert creepages(lateral, curve_radius_m=curve_m)[:, 0] == pytest.approx([0.0, 0.0], abs=1e-12)
    middle = creepages(0.0, curve_radius_m=curve_m)[:, 0]
    assert np.abs(middle) == pytest.approx(ARM / (1e3 * abs(curve_m)), rel=1e-9)
    assert middle[0] == pytest.approx(-middle[1])


def test_klingels_motion_of_cones():
    """Without creepage y' = -V psi and psi' = V c y / (r b): a wave of Klingel's length."""
    lateral, yaw = 2.0, 1e-5
    unit = np.array(
        [
            creepages(lateral)[1, 0],
            creepages(0.0, yaw_rate_rad_s=1.0)[1, 0],
            creepages(0.0, yaw)[1, 1] / yaw,
            creepages(0.0, lateral_velocity_m_s=1.0)[1, 1],
        ]
    )
    turning, moving = -unit[0] / unit[1] / lateral, -unit[2] / unit[3]
    # mm/s by yaw, and yaw rate by mm
    omega = np.sqrt(-turning * 1e3 * moving)
    length = 2.0 * np.pi * 1e3 * SPEED / omega
    assert length == pytest.approx(2.0 * np.pi * np.sqrt(RADIUS * ARM / CONICITY), rel=1e-9)
    assert length == pytest.approx(float(klingel_wavelength(CONICITY, 2.0 * ARM, RADIUS)), rel=1e-9)
