"""A wheelset that rolls with friction: equilibrium with creep forces, symmetry, power, and limits that are known."""

import numpy as np
import pytest

from flangeway.cases.case_file import bodies_key
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import Creepages, RollingContact
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.railway.rigid.conicity import klingel_wavelength
from flangeway.railway.track.placements import SIDE_SIGN, SIDES
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.rolling.wheelset_creep import WheelsetCreep, patches_of
from flangeway.railway.wheelset.side_contact import WheelPose
from flangeway.railway.wheelset.side_newton import MOTIONS
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.wheelset_newton import RollingPlace
from tests.railway.wheelset.conftest import coarse_case

ROLLS = {"rolling.speed_km_h": 72.0, "friction": 0.3, "theory": "fastsim"}
IN_CURVE = {key: value for key, value in ROLLS.items() if key != "rolling.speed_km_h"}


def curve(radius_m, **more):
    """A curve at the same speed."""
    return {"curve": {"radius_m": radius_m, "speed_km_h": 72.0} | more}


def solved(wheelset, **inputs):
    found = solve_position(wheelset.at(coarse_case(**inputs)), {})
    assert found.status.converged, found.status.message
    return found


def resultants(found):
    return np.array([found.equilibrium.state.rolled.creep[side].resultant for side in SIDES])


def test_in_the_middle_of_straight_track_it_rolls_without_longitudinal_forces(wheelset):
    """Equal wheels: spin alone, whose lateral forces cancel; without friction the position is the same."""
    found, plain = solved(wheelset, **ROLLS), solved(wheelset)
    assert found.equilibrium.position.lateral_mm == pytest.approx(0.0, abs=1e-4)
    left, right = found.patches
    assert left.creep_force_on_wheel_N == pytest.approx(right.creep_force_on_wheel_N * (-1, 1, 1), abs=1.0)
    assert abs(right.creep_force_on_wheel_N[2]) < 10.0
    # the axle bends: the wheel's axis is not level
    level = right.force @ right.state.pose.axis[:2] / right.normal_force_N
    assert right.creep.spin_creepage_per_m == pytest.approx(-1e3 * level / 460.0, rel=0.01)
    assert right.creep_force_on_wheel_N[0] > 500.0
    assert plain.rolling == []
    assert found.equilibrium.position.vertical_mm == pytest.approx(plain.equilibrium.position.vertical_mm, abs=0.01)


def test_a_position_and_its_mirror_image(wheelset):
    """Lateral position, yaw and curve of the other sign exchange left and right."""
    one = solved(wheelset, lateral_mm=2.0, yaw_mrad=1.0, **curve(800.0), **IN_CURVE)
    other = solved(wheelset, lateral_mm=-2.0, yaw_mrad=-1.0, **curve(-800.0), **IN_CURVE)
    forces, mirrored = resultants(one), resultants(other)[::-1]
    assert forces == pytest.approx(mirrored, rel=1e-3, abs=1e-4 * np.abs(forces).max())
    rolled, opposite = one.equilibrium.state.rolled, other.equilibrium.state.rolled
    assert rolled.yaw_moment_Nmm == pytest.approx(-opposite.yaw_moment_Nmm, rel=1e-3)
    # the yaw to the left pushes the wheelset to the left, and what holds it acts to the right
    assert sum(found.creep_force_on_wheel_N[0] for found in one.patches) < -10e3


@pytest.mark.parametrize(
    ("conformity_deg", "inputs"),
    [
        (6.0, {"lateral_mm": 2.0, "yaw_mrad": 2.0, "torque_kNm": 3.0} | curve(500.0) | IN_CURVE),
        (16.0, {"yaw_mrad": -4.0} | ROLLS),
    ],
    ids=["crown", "flange root"],
)
def test_power_of_friction_is_the_work_on_the_wheelset(wheelset, conformity_deg, inputs):
    """Power of tractions and slip on the cells is that of torque, traction, lateral velocity and yaw rate to 1e-9.

    Friction moves pressures ahead or back: their torque is that by which they resist rolling.
    """
    moving = {"yaw_rate_mrad_per_s": 5.0, "lateral_velocity_mm_per_s": 20.0}
    found = solved(wheelset, **inputs | {"theory": "exact"}, **moving)
    problem, rolled = found.problem, found.equilibrium.state.rolled
    assert max(each.conformity_deg for each in found.patches) == pytest.approx(conformity_deg, rel=0.3)
    work = 0.0
    for side in SIDES:
        force, moment, torque = np.split(rolled.creep[side].resultant, [3, 6])
        sign = SIDE_SIGN[side]
        work -= force[2] * problem.speed_m_s + sign * force[0] * 1e-3 * problem.rolling.lateral_velocity_mm_per_s
        work -= 1e-3 * (rolled.rate_rad_s * float(torque[0]) - sign * moment[1] * problem.turning_rad_s)
    power = sum(creep.power_W for _, creep in found.rolling)
    assert power > 1000.0
    assert power == pytest.approx(work, rel=1e-9)
    for _, creep in found.rolling:
        assert creep.forces.frictional_power == pytest.approx(creep.power_W, rel=1e-9)
    for side, state in found.equilibrium.state.sides.items():
        normals = np.pad(state.normals, ((0, 0), (0, 1)))[:, None]
        torque = 1e-3 * float(np.sum(state.forces * (np.cross(state.gap.arms, normals) @ state.pose.axis)))
        resisting = sum(creep.forces.rolling_power for patch, creep in found.rolling if patch.side == side)
        assert resisting == pytest.approx(-rolled.rate_rad_s * torque, abs=0.05 * abs(resisting) + 1e-3 * power)
    torque = 1e6 * inputs.get("torque_kNm", 0.0)
    assert rolled.torque_Nmm == pytest.approx(-torque, abs=1e-4 * 200e3 * 460.0)
    traction = sum(each.creep_force_on_wheel_N[2] for each in found.patches)
    assert traction == pytest.approx(torque / 460.0, rel=0.05, abs=500.0)


def test_creepages_do_not_depend_on_the_speed(wheelset):
    """On straight track all forces are those of another speed, and the rate of rotation grows with it."""
    slow = solved(wheelset, lateral_mm=3.0, yaw_mrad=1.0, **ROLLS)
    fast = solved(wheelset, lateral_mm=3.0, yaw_mrad=1.0, **ROLLS | {"rolling.speed_km_h": 216.0})
    assert resultants(slow) == pytest.approx(resultants(fast), rel=1e-4, abs=10.0)
    rates = [each.equilibrium.state.rolled.rate_rad_s for each in (slow, fast)]
    assert rates[1] == pytest.approx(3.0 * rates[0], rel=1e-6)


@pytest.mark.parametrize("theory", ["fastsim", pytest.param("exact", marks=pytest.mark.ci)])
def test_the_uncertainty_of_the_position_holds_another_start(wheelset, theory):
    """A search from 0.5 mm beside ends within 0.02 mm or the uncertainty; a prescribed position has none."""
    found = solved(wheelset, **curve(800.0), **IN_CURVE | {"theory": theory})
    uncertainty, place = found.lateral_uncertainty_mm, RollingPlace.of(found.equilibrium)
    assert 1e-6 < uncertainty < 0.1
    other = found.wheelset.solve(near=place._replace(lateral_mm=place.lateral_mm + 0.5))
    assert other.status.converged
    assert abs(other.position.lateral_mm - place.lateral_mm) < max(0.02, uncertainty)
    assert solved(wheelset, lateral_mm=2.0, **ROLLS).lateral_uncertainty_mm is None


def test_little_friction_is_nearly_none(wheelset):
    """At a coefficient of 1e-4 position and forces are those without friction; at 0 they are the same."""
    plain = solved(wheelset, lateral_mm=3.0)
    found = solved(wheelset, lateral_mm=3.0, **ROLLS | {"friction": 1e-4})
    one, other = (np.array(each.equilibrium.position.components) for each in (plain, found))
    assert one == pytest.approx(other, abs=1e-4)
    assert all(creep.used_friction <= 1e-4 * (1.0 + 1e-6) for _, creep in found.rolling)
    none = solved(wheelset, lateral_mm=3.0, **ROLLS | {"friction": 0.0})
    assert none.equilibrium.position == plain.equilibrium.position
    assert none.rolling == []


@pytest.mark.ci
def test_the_exact_theory_is_linear_at_small_yaw(wheelset):
    """The lateral force by a yaw of 0.05 mrad is that of linear theory within 10 %, which coarse cells leave."""
    slopes = []
    for theory in ("exact", "linear"):
        ends = [
            solved(wheelset, lateral_mm=0.0, yaw_mrad=yaw, **ROLLS | {"theory": theory, "friction": 0.9})
            for yaw in (-0.05, 0.05)
        ]
        slopes.append(sum(each.creep_force_on_wheel_N[0] for each in ends[1].patches))
        slopes[-1] -= sum(each.creep_force_on_wheel_N[0] for each in ends[0].patches)
    assert slopes[0] < 0.0
    assert slopes[0] == pytest.approx(slopes[1], rel=0.1)


def test_free_in_a_wide_curve_it_rolls_kinematically(wheelset):
    """Without yaw stiffness, radii differ by ``r (x_right - x_left) / R`` (Redtenbacher, 1855); the yaw is radial."""
    balanced = curve(3000.0, superelevation_mm="from-speed")
    found = solved(wheelset, **balanced, yaw_stiffness_kNm_per_mrad=0.0, **IN_CURVE)
    radii = {each.side: each.rolling_radius_mm for each in found.patches}
    places = {each.side: each.centre_mm[0] for each in found.patches}
    wanted = 460.0 * (places["right"] - places["left"]) / 3e6
    assert radii["right"] - radii["left"] == pytest.approx(wanted, rel=0.02)
    rolled = found.equilibrium.state.rolled
    assert abs(rolled.yaw_rad) < 1e-4
    assert abs(rolled.yaw_moment_Nmm) < 1e-5 * 200e3 * 680.0
    assert found.equilibrium.position.lateral_mm > 0.5


def test_the_yaw_follows_its_stiffness(wheelset):
    """The yaw moment is the stiffness times the yaw beyond the one that guides it."""
    found = solved(wheelset, lateral_mm=2.0, yaw_mrad=1.0, yaw_stiffness_kNm_per_mrad=20.0, **ROLLS)
    rolled = found.equilibrium.state.rolled
    assert rolled.yaw_moment_Nmm == pytest.approx(20e9 * (rolled.yaw_rad - 1e-3), rel=1e-3)
    assert abs(rolled.yaw_rad - 1e-3) > 1e-6


def test_a_flange_in_contact_has_nadals_limit_beside_it(wheelset):
    """A yaw that points to the right rail pushes the flange on it; L/V stays below the limit."""
    found = solved(wheelset, yaw_mrad=-4.0, **ROLLS)
    steepest = max(p.contact_angle_rad for p in found.patches if p.side == "right")
    assert steepest > 0.35
    # the flange of S1002 has 70 degrees
    slope = np.tan(np.deg2rad(70.0))
    assert found.nadal_limit("right") == pytest.approx((slope - 0.3) / (1.0 + 0.3 * slope), rel=1e-3)
    assert 0.1 < found.lateral_over_vertical("right") < found.nadal_limit("right")
    power = [creep.power_W for patch, creep in found.rolling if patch.side == "right"]
    assert max(power) > 1e3


def test_a_driven_axle_holds_its_torque_by_friction_that_falls_in_a_tight_curve(wheelset):
    """Both wheels slip against each other, and the torque rises with the rate at first: beyond that it is held.

    Forces of the patches times the tape radius carry it to 2 %, and a faster axle is driven less.
    """
    falling = {"kinetic": 0.039, "decay_m_per_s": 2.0}
    rolling = {"friction": 0.09, "falling": falling, "theory": "fastsim"}
    torques = {}
    for torque in (1.6, 1.7):
        inputs = curve(-120.0, speed_km_h=40.0) | {"rolling": rolling | {"torque_kNm": torque}}
        found = solved(wheelset, lateral_mm=0.0, **inputs)
        creep = sum(each.creep_force_on_wheel_N[2] for each in found.patches)
        assert creep == pytest.approx(1e6 * torque / 460.0, rel=0.02)
        torques[torque] = found.equilibrium.state.rolled.rate_rad_s
    assert torques[1.7] > torques[1.6]


@pytest.mark.ci
def test_a_torque_above_friction_is_no_equilibrium(wheelset):
    """Friction cannot transmit it: the status says so."""
    found = solve_position(wheelset.at(coarse_case(lateral_mm=0.0, torque_kNm=80.0, **ROLLS)), {})
    assert not found.status.converged
    assert "torque" in found.status.message


@pytest.mark.ci
def test_a_flange_pushed_up_its_rail_ends_with_a_message(wheelset):
    """With a yaw of 15 mrad and friction 0.9 its flange is pushed up, or climbs, its rail: the message says so."""
    problem = coarse_case(yaw_mrad=-15.0, axle_load_kN=60.0, **ROLLS | {"friction": 0.9})
    found = solve_position(wheelset.at(problem), {})
    assert not found.status.converged
    assert any(words in found.status.message for words in ("up its rail", "climbs its rail"))


def test_friction_of_the_gauge_face():
    """Rows steeper than 45 degrees have their own coefficient, and a kinetic one that is less by the same factor."""
    problem = coarse_case(**ROLLS, flange_friction=0.1, falling={"kinetic": 0.15})
    friction = problem.friction.friction_on(np.array([[0.0, 1.0], [-0.9, np.sqrt(0.19)]]), problem.friction_of("left"))
    np.testing.assert_allclose(friction.limits[0], [0.3, 0.1])
    np.testing.assert_allclose(friction.limits[1], [0.15, 0.05])
    assert problem.friction.torque == 0.0


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ({"friction": 0.3}, "rolling.speed_km_h"),
        ({"torque_kNm": 1.0}, "rolling.speed_km_h"),
        (ROLLS | {"rolling.speed_km_h": 0.0}, "rolling.speed_km_h"),
        (ROLLS | curve(500.0), "load.curve.speed_km_h"),
        (ROLLS | {"falling": {"kinetic": 0.4}}, "kinetic"),
        (ROLLS | {"falling": {"kinetic": 0.2}, "track.left.friction": 0.1}, "kinetic"),
    ],
)
def test_rolling_needs_one_speed_and_friction_that_falls(inputs, words):
    """No speed, or two, and a kinetic coefficient above the static one of a side are refused before bodies are made."""
    with pytest.raises(InputError, match=words):
        coarse_case(**inputs).check()


def test_friction_along_the_track(tmp_path):
    """Linear between the distances of a file, constant beyond; other inputs of friction go with it."""
    file = tmp_path / "friction.csv"
    file.write_text("distance_m,friction,weather\n0,0.4,dry\n100,0.4,dry\n120,0.1,wet\n")
    for distance, expected in ((-5.0, 0.4), (50.0, 0.4), (110.0, 0.25), (500.0, 0.1)):
        friction = {"file": str(file), "distance_m": distance}
        case = coarse_case(**ROLLS | {"friction": friction}, flange_friction=0.05)
        assert case.friction_of("right") == pytest.approx(expected)
        assert case.friction.flange_friction == 0.05
        assert bodies_key(case) == bodies_key(coarse_case())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("distance_m,friction\n0,0.3\n0,0.2\n", "do not rise"),
        ("distance_m,friction\n0,1.3\n", "out of range"),
        ("distance_m,mu\n0,0.3\n", "no column friction"),
        (None, "rolling.friction.file"),
    ],
)
def test_wrong_friction_along_the_track_is_refused(tmp_path, text, words):
    """Distances that do not rise, coefficients out of range, missing columns; a distance without a file."""
    friction = {"distance_m": 5.0}
    if text:
        friction["file"] = str(tmp_path / "friction.csv")
        (tmp_path / "friction.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        coarse_case(**ROLLS | {"friction": friction}).check()


@pytest.mark.parametrize("theory", [pytest.param("exact", marks=pytest.mark.ci), "fastsim"])
def test_friction_that_falls_with_the_flash_temperature(wheelset, theory):
    """The wheelset is in equilibrium, has a flash temperature, and less friction than without."""
    inputs = {**ROLLS, "rolling.speed_km_h": 120.0, "yaw_mrad": 8.0, "lateral_mm": 0.0, "theory": theory}
    falls = {"falling": {"kinetic": 0.1, "between_C": [25.0, 60.0]}}
    plain, warm = (solved(wheelset, **inputs, **more) for more in ({}, falls))
    rises = [max(creep.flash_temperature for _, creep in found.rolling) for found in (plain, warm)]
    assert rises[0] > rises[1] > 5.0
    used = [max(creep.used_friction for _, creep in found.rolling) for found in (plain, warm)]
    assert used[1] < 0.9 * used[0]


def test_patches_that_touch_are_divided_where_little_is_carried():
    """Two heaps of forces: apart below 0.1 of the lesser, below 0.25 if they were apart before, else one patch."""
    heaps = np.array([0.0, 2.0, 4.0, 2.0, 0.0, 2.0, 3.0, 1.0, 0.0])[:, None] * np.ones(3)
    between = np.arange(9)[:, None] == 4
    before = patches_of(heaps)
    assert [int(each[:, 0].sum()) for each in before] == [3, 3]
    for least, alone, after in ((0.2, 2, 2), (0.6, 1, 2), (0.8, 1, 1)):
        forces = np.where(between, least, heaps)
        assert (len(patches_of(forces)), len(patches_of(forces, before))) == (alone, after)


@pytest.mark.parametrize("theory", [pytest.param("exact", marks=pytest.mark.ci), "fastsim"])
def test_derivatives_have_the_change_of_a_slope_that_falls(wheelset, theory):
    """By the rate of rotation and by normal forces that shift in the patch, as differences of the forces have them."""
    slope = {"slope": {"initial": 0.8, "remaining": 0.3, "rate": 2.0}}
    rolls = ROLLS | slope | {"theory": theory, "lateral_mm": 2.0, "yaw_mrad": 2.0}
    found, problem = solved(wheelset, **rolls).equilibrium, coarse_case(**rolls)
    side, rate = found.state.sides["right"], 1e3 * problem.speed_m_s / 460.0

    def forces(normal, share=0.0):
        creep = WheelsetCreep(problem, rate * (1.0 + share))
        return creep, creep.of_side("right", side, normal)

    normal, step = side.forces, 1e-4
    rows, strips = np.nonzero(normal)
    shape = np.zeros(normal.shape)
    shape[rows, strips] = 0.5 + (rows - rows.mean()) / np.ptp(rows) - (strips - strips.mean()) / np.ptp(strips)
    creep, now = forces(normal)
    slopes = creep.derivatives("right", side, normal, now)
    for inputs, derivative in (
        (((normal, share) for share in (-step, step)), slopes.motion[:7, MOTIONS.index("rate")] * rate),
        (((normal * (1.0 + share * shape),) for share in (-step, step)),
         slopes.shape[:7] @ np.tensordot(slopes.weights, normal * shape, axes=2)),
    ):  # fmt: skip
        low, high = (forces(*given)[1].resultant for given in inputs)
        difference = (high - low) / (2.0 * step)
        np.testing.assert_allclose(derivative[:3], difference[:3], atol=0.01 * np.abs(difference[:3]).max())


def test_patches_of_a_side_move_each_others_surfaces(wheelset):
    """At the crown and the gauge corner at once: creep forces do not depend on how wide the free cell between is."""
    found = solved(wheelset, lateral_mm=6.6, **ROLLS | {"theory": "exact"})
    assert len([patch for patch in found.patches if patch.side == "right"]) == 2
    (creep,) = found.equilibrium.state.rolled.creep["right"].patches
    contact, motion = creep.contact, creep.forces.motion
    rows = np.flatnonzero(contact.pressures.any(axis=1))
    (last,) = np.flatnonzero(np.diff(rows) > 1)
    between = slice(rows[last] + 1, rows[last + 1])

    def rolled(ends, kept):
        bounds = np.sort(
            np.concatenate((contact.grid.bounds[: between.start + 1], ends, contact.grid.bounds[between.stop :]))
        )
        pressures = np.zeros((len(bounds) - 1, contact.grid.n_strips))
        pressures[: between.start] = contact.pressures[: between.start] * kept[0]
        pressures[between.stop - len(contact.pressures) :] = contact.pressures[between.stop :] * kept[1]
        grid = PatchGrid(bounds, contact.grid.strip, contact.grid.n_strips, contact.grid.middle)
        half_spaces = RollingContact.between_half_spaces(grid, pressures, Friction(0.3), contact.materials)
        return roll(half_spaces, Creepages(-5e-4, 2e-4, 0.0, motion.speed), tolerance=1e-9)

    low, high = contact.grid.bounds[[between.start, between.stop]]
    one, many = rolled([], (1, 1)), rolled(np.linspace(low, high, 8)[1:-1], (1, 1))
    assert (one.along, one.across) == pytest.approx((many.along, many.across), rel=1e-6)
    apart = rolled([], (1, 0)).along + rolled([], (0, 1)).along
    assert abs(one.along / apart - 1.0) > 0.02


CONICITY, RADIUS, ARM, SPEED = 0.05, 460.0, 750.0, 20.0  # ARM b: distance of the contacts from the middle


def creepages(lateral, yaw=0.0, curve_m=None, **motion):
    """Longitudinal and lateral creepage of both wheels, (2, 2), the lateral one to the right."""
    steel = Elastic(210e3, 0.3)
    grid = PatchGrid(np.linspace(-1.0, 1.0, 3), 1.0, 2)
    patch = RollingContact.between_half_spaces(grid, np.ones((2, 2)), Friction(0.3), (steel, steel))
    rate = 1e3 * SPEED / RADIUS
    speed = {"speed_km_h": 3.6 * SPEED}
    load = {} if curve_m is None else {"curve": {"radius_m": curve_m} | speed}
    problem = WheelsetProblem(load=load, rolling=motion if load else motion | speed)
    creep = WheelsetCreep(problem, rate)
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
    assert creepages(lateral, curve_m=curve_m)[:, 0] == pytest.approx([0.0, 0.0], abs=1e-12)
    middle = creepages(0.0, curve_m=curve_m)[:, 0]
    assert np.abs(middle) == pytest.approx(ARM / (1e3 * abs(curve_m)), rel=1e-9)
    assert middle[0] == pytest.approx(-middle[1])


def test_klingels_motion_of_cones():
    """Without creepage y' = -V psi and psi' = V c y / (r b): a wave of Klingel's length."""
    lateral, yaw = 2.0, 1e-5
    unit = np.array(
        [
            creepages(lateral)[1, 0],
            creepages(0.0, yaw_rate_mrad_per_s=1e3)[1, 0],
            creepages(0.0, yaw)[1, 1] / yaw,
            creepages(0.0, lateral_velocity_mm_per_s=1e3)[1, 1],
        ]
    )
    turning, moving = -unit[0] / unit[1] / lateral, -unit[2] / unit[3]
    # mm/s by yaw, and yaw rate by mm
    omega = np.sqrt(-turning * 1e3 * moving)
    length = 2.0 * np.pi * 1e3 * SPEED / omega
    assert length == pytest.approx(2.0 * np.pi * np.sqrt(RADIUS * ARM / CONICITY), rel=1e-9)
    assert length == pytest.approx(float(klingel_wavelength(CONICITY, 2.0 * ARM, RADIUS)), rel=1e-9)
