"""Loads beside the middle of the axle by statics, and sides that differ: exchanged they give the mirror image."""

import numpy as np
import pytest

from flangeway.cases import Wheelset
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.plane_wheelset import solve_wheelset
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset

WEIGHT, OFFSET, HEIGHT = 200e3, 60.0, 1457.7  # N, mm, mm
MESH = {"size_scale": 3.0, "order": 1}
BODIES = {}
"""Elastic bodies that several tests share."""


def solved(track=None, **inputs):
    """Position in three dimensions, on fixed rails unless they are said."""
    problem = Wheelset(track={"support": "fixed"} | (track or {}), mesh=MESH, **inputs)
    found = solve_position(SpatialWheelset(problem, running_surfaces(problem, done=BODIES)), {})
    assert found.status.converged, found.status.message
    return found


def weight_moment(roll_rad: float) -> float:
    """Moment of the weight about the middle of the axle, counter-clockwise, N mm: down, to the right of it."""
    return -WEIGHT * (OFFSET * np.cos(roll_rad) - HEIGHT * np.sin(roll_rad))


def test_a_rigid_wheelset_bears_an_eccentric_weight_by_statics():
    """Forces and moments of the contacts are those of the weight to 1e-9; right of the middle it loads the right."""
    problem = Wheelset(load={"axle_load_kN": 1e-3 * WEIGHT, "offset_mm": OFFSET})
    geometry = RigidGeometry.of(problem.track, problem.wheels)
    position = rigid_equilibrium(geometry, problem.forces).reached()
    axle = np.array(position.motion.axle(problem.wheels))
    force, moment, carried = np.zeros(2), 0.0, dict.fromkeys(SIDES, 0.0)
    for point in position.contacts:
        one, arm = np.array(point.force_on_wheel_N), np.array(point.point_mm) - axle
        force, moment = force + one, moment + arm[0] * one[1] - arm[1] * one[0]
        carried[point.side] += one[1]
    assert force == pytest.approx((0.0, WEIGHT), abs=1e-9 * WEIGHT)
    assert moment == pytest.approx(-weight_moment(position.motion.roll_rad), rel=1e-7)
    assert carried["right"] - carried["left"] == pytest.approx(2.0 * WEIGHT * OFFSET / 1500.0, rel=0.05)


@pytest.mark.parametrize("axle", ["rigid", "elastic"])
def test_an_elastic_wheelset_bears_an_eccentric_weight_by_statics(axle):
    """The contacts' forces are the weight, their moment is its to 1e-3; opposite offsets are mirror images."""
    load = {"axle_load_kN": 1e-3 * WEIGHT}
    right, left = (solved(load=load | {"offset_mm": offset}, wheelset={"axle": axle}) for offset in (OFFSET, -OFFSET))
    force, moment, motion = np.zeros(2), 0.0, right.equilibrium.position
    for patch in right.patches:
        one, arm = patch.force_on_wheel_N[:2], patch.centre_mm[:2] - motion.axle(right.problem.wheels)
        force, moment = force + one, moment + arm[0] * one[1] - arm[1] * one[0]
    assert force == pytest.approx((0.0, WEIGHT), abs=1e-6 * WEIGHT)
    assert moment == pytest.approx(-weight_moment(motion.roll_rad), rel=1e-3)
    assert right.force_on_wheel_N("right")[1] > right.force_on_wheel_N("left")[1] + 0.07 * WEIGHT
    assert_mirrored(right, left)


def test_a_plane_wheelset_bears_an_eccentric_weight_by_statics():
    """The difference of both wheels' loads is that of the weight's moment over their distance, to 2 %."""
    problem = Wheelset(contact="plane", mesh=MESH, load={"axle_load_kN": 1e-3 * WEIGHT, "offset_mm": OFFSET})
    found = solve_wheelset(problem)
    assert found.status.converged, found.status.message
    assert found.equilibrium.residuals.equilibrium_residual < 1e-9
    by_side = {side: sum(p.force_on_wheel_N for p in found.patches if p.side == side) for side in SIDES}
    (left, left_up), (right, right_up) = by_side["left"], by_side["right"]
    assert right_up + left_up == pytest.approx(WEIGHT, rel=1e-9)
    # forces across act 460 mm below the axle, and cancel
    assert right + left == pytest.approx(0.0, abs=1e-6 * WEIGHT)
    moment = -weight_moment(found.equilibrium.position.roll_rad)
    assert right_up - left_up == pytest.approx(2.0 * moment / 1500.0, rel=0.02)


def assert_mirrored(one, other):
    """Two positions are mirror images: motion, forces on the wheels, and pressures of the patches."""
    (x, y, roll), (other_x, other_y, other_roll) = (each.equilibrium.position.components for each in (one, other))
    assert (x, y, roll) == pytest.approx((-other_x, other_y, -other_roll), abs=1e-6)
    for side, opposite in zip(SIDES, SIDES[::-1], strict=True):
        force, mirrored = one.force_on_wheel_N(side), other.force_on_wheel_N(opposite)
        assert force == pytest.approx(mirrored * (-1.0, 1.0), rel=1e-5, abs=1.0)
        pressures = [sorted(p.max_pressure for p in each.patches if p.side == at) for each, at in
                     ((one, side), (other, opposite))]  # fmt: skip
        assert pressures[0] == pytest.approx(pressures[1], rel=1e-4)


def test_unlike_friction_exchanged_is_the_mirror_image():
    """The wheel on a greased rail uses its own coefficient; the yaw moment has the other sign on the other side."""
    found = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        rolling = {"friction": 0.4, "speed_km_h": 72.0, "theory": "fastsim"}
        position = {"lateral_mm": sign * 1.0, "yaw_mrad": sign * 4.0}
        found[side] = solved(track={side: {"friction": 0.1}}, rolling=rolling, position=position)
    for side, each in found.items():
        for patch, creep in each.rolling:
            assert creep.used_friction <= (0.1 if patch.side == side else 0.4) * (1.0 + 1e-6)
            assert creep.used_friction > (0.05 if patch.side == side else 0.1)
    assert_mirrored(found["left"], found["right"])
    moments = [found[side].equilibrium.state.rolled.yaw_moment_Nmm for side in SIDES]
    assert abs(moments[0]) > 1e6
    assert moments[0] == pytest.approx(-moments[1], rel=1e-3)


@pytest.mark.parametrize(
    ("own", "least"),
    [({"inclination": 0.05}, 0.02), ({"support": "continuous"}, 0.5)],
    ids=["inclination", "support"],
)
def test_unlike_rails_exchanged_are_the_mirror_image(own, least):
    """Another inclination moves the wheelset aside, a softer support of one rail rolls it to that side."""
    load = {"axle_load_kN": 1e-3 * WEIGHT}
    found = {side: solved(track={side: own}, load=load, wheelset={"axle": "rigid"}) for side in SIDES}
    assert_mirrored(found["left"], found["right"])
    motion = found["left"].equilibrium.position
    assert abs(motion.lateral_mm) > least
    if "support" in own:
        assert motion.roll_rad > 0.5e-3  # the left wheel is lower
        assert found["left"].head_motion("left")[1] < -0.5 < found["left"].head_motion("right")[1]


def test_plane_rails_of_unlike_inclination_exchanged_are_the_mirror_image():
    """Position, forces and pressures of the slice, to 1e-6."""
    problems = [Wheelset(track={side: {"inclination": 0.05}}, contact="plane", mesh=MESH) for side in SIDES]
    found = [solve_wheelset(problem) for problem in problems]
    (x, y, roll), (other_x, other_y, other_roll) = (each.equilibrium.position.components for each in found)
    assert abs(x) > 0.01
    assert (x, y, roll) == pytest.approx((-other_x, other_y, -other_roll), rel=1e-6, abs=1e-9)
    for one, other in zip(found[0].patches, found[1].patches[::-1], strict=True):
        assert one.force_on_wheel_N == pytest.approx(other.force_on_wheel_N * (-1.0, 1.0), rel=1e-6)


@pytest.mark.parametrize("wheels", ["joined", "independent"])
def test_cones_in_a_curve_roll_at_rates_of_their_own_if_they_are_independent(wheels):
    """Independent: V (1 + x / R) / r to 1e-5, and of the longitudinal forces only what balances the moment of spin.

    Both forces are ``-M sin(gamma) / r`` with the contact angle gamma: without torque about the axle. Wheels that are
    joined slip by half of the difference of these rates, with opposite forces of 33 kN.
    """
    curve = {"radius_m": 300.0, "speed_km_h": 36.0, "superelevation_mm": "from-speed"}
    found = solved(
        track={"rail": "136RE"},
        wheelset={"wheel": "AAR-1B", "axle": "rigid", "wheels": wheels},
        load={"axle_load_kN": 200.0, "curve": curve},
        position={"lateral_mm": 1.0},
        rolling={"friction": 0.3, "theory": "linear"},
    )
    rolled, speed = found.equilibrium.state.rolled, 1e3 * found.problem.speed_m_s
    free = wheels == "independent"
    assert (rolled.rate_difference_rad_s is not None) == free
    forces, slips, own_rates = [], [], []
    for patch, creep in found.rolling:
        outwards = 1.0 if patch.side == "right" else -1.0
        rate = rolled.rate_rad_s + outwards * (rolled.rate_difference_rad_s or 0.0) / 2.0
        own = speed * (1.0 + patch.centre_mm[0] / 300e3) / patch.rolling_radius_mm
        slips.append(rate / own - 1.0)
        own_rates.append(own)
        forces.append(patch.creep_force_on_wheel_N[2])
        if free:
            spin = creep.forces.moment * np.sin(patch.contact_angle_rad) / patch.rolling_radius_mm
            assert forces[-1] == pytest.approx(-spin, rel=0.01)
    left, right = slips
    if free:
        assert (left, right) == pytest.approx((0.0, 0.0), abs=1e-5)
        return
    half = np.ptp(own_rates) / np.sum(own_rates)
    assert half > 2e-3
    assert (left, right) == pytest.approx((half, -half), rel=0.01)
    assert forces[0] == pytest.approx(-forces[1], rel=1e-3)
    assert forces[0] > 30e3


def test_unlike_friction_under_independent_wheels_exchanged_is_the_mirror_image():
    """An eccentric load, a torque and a greased rail: each wheel transmits half of the torque, on both sides."""
    found, torque = {}, 2.0e6
    for side, sign in (("left", 1.0), ("right", -1.0)):
        found[side] = solved(
            track={side: {"friction": 0.1}},
            wheelset={"wheels": "independent"},
            load={"axle_load_kN": 1e-3 * WEIGHT, "offset_mm": sign * OFFSET},
            position={"lateral_mm": sign * 1.0, "yaw_mrad": sign * 2.0},
            rolling={"friction": 0.4, "speed_km_h": 72.0, "theory": "fastsim", "torque_kNm": 1e-6 * torque},
        )
    assert_mirrored(found["left"], found["right"])
    left, right = (found[side].equilibrium.state.rolled for side in SIDES)
    assert left.rate_rad_s == pytest.approx(right.rate_rad_s, rel=1e-8)
    assert left.rate_difference_rad_s == pytest.approx(-right.rate_difference_rad_s, abs=1e-6)
    assert abs(left.rate_difference_rad_s) > 1e-3
    for rolled in (left, right):
        of_wheels = [float(rolled.creep[side].resultant[6]) for side in SIDES]
        assert of_wheels == pytest.approx([-torque / 2.0] * 2, rel=1e-5)
