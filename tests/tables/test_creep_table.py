"""Reading a table: positions, jumps, ranges, kinematics, and files that are none. Its forces are made up."""

import json
import sys
from importlib.util import module_from_spec, spec_from_file_location
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.rolling.wheelset_creep import WheelsetCreep
from flangeway.railway.wheelset.side_contact import WheelPose
from flangeway.tables import creep_table
from flangeway.tables.creep_table import FORMAT, MIRROR, OF_PATCH, CreepTable, interior, stencil

ANGLES = np.linspace(0.0, np.pi, 9)


def linear_theory(slips, spins, creeps):
    """Forces over slip that saturate, opposite to the creepage: -direction (2 (1 - V) + V)."""
    slip, spin, creep = np.meshgrid(slips, spins, creeps, indexing="ij")
    unit = np.stack((np.cos(spin) * np.cos(creep), np.cos(spin) * np.sin(creep), np.sin(spin)), axis=-1)
    return -unit * (2.0 - slip)[..., None]


def made_up(normal):
    """A table with 3 lateral positions, 1 yaw and 2 loads; normal forces (3, 1, 2, 2, patches)."""
    shape = normal.shape
    slips = np.linspace(0.0, 1.0, 6)
    further = {name: (3,) if name == "position_mm" else (2,) * more for name, more in OF_PATCH.items()}
    values = {name: np.ones((*shape, *size)) for name, size in further.items()}
    values["normal_force_N"] = normal
    values["contact_angle_rad"] = np.full(shape, 0.05)
    values["rolling_radius_mm"] = np.full(shape, 460.0)
    values["position_mm"][..., :] = (750.0, -459.0, 0.0)
    values["position_mm"][..., 0] *= MIRROR[:, None]
    values["stiffness_N"][:] = 1e7
    values["radius_mm"] = np.full(shape, 4.0)
    values["free_creepage"][:] = values["wheel_roll_rad"][:] = 0.0
    values["forces"] = np.tile(linear_theory(slips, ANGLES - np.pi / 2, ANGLES), (*shape, 1, 1, 1, 1)).astype("f4")
    count = (normal > 0.0).sum(axis=-1)
    joined = np.all([count[:-1] == count[1:]], axis=(0, 2, 3))[:, None, None, :]
    values["joined"] = joined
    values |= {"lateral_mm": np.array([-1.0, 0.0, 2.0]), "yaw_mrad": np.zeros(1), "load_kN": np.array([100.0, 200.0])}
    values |= {"slip": slips, "spin_angle_rad": ANGLES - np.pi / 2, "creep_angle_rad": ANGLES}
    return CreepTable(values, {"format": FORMAT})


@pytest.fixture
def table():
    """One patch a side, the right one with two at the last position."""
    normal = np.zeros((3, 1, 2, 2, 2))
    normal[..., 0] = np.array([5e4, 1e5])[:, None]
    normal[2, :, :, 1] = np.array([[3e4, 2e4], [6e4, 4e4]])
    return made_up(normal)


def test_positions_are_interpolated_where_patches_go_over_and_both_are_there_where_they_jump(table):
    """Linear over load; on the right side the one patch of the position before hands its load over to the two."""
    found = table.contacts([-1.0, -0.3, 0.5, 2.0], 0.0, [100.0, 125.0, 100.0, 200.0])["normal_force_N"]
    assert found.shape == (4, 2, 16)
    np.testing.assert_allclose(found[:, 0, 0], (5e4, 6.25e4, 5e4, 1e5))
    part = 0.25**2 * (3.0 - 2.0 * 0.25)  # a quarter of the way from 0 to 2 mm
    np.testing.assert_allclose(np.sort(found[2, 1])[-3:], np.sort([(1.0 - part) * 5e4, part * 3e4, part * 2e4]))
    np.testing.assert_allclose(np.sort(found[3, 1])[-2:], (4e4, 6e4))


@pytest.mark.parametrize(("load", "step"), [(100.0, 2e-3), (120.0, 0.02)])
def test_forces_are_continuous_where_patches_jump(table, load, step):
    """Across an interval of jumping patches, its ends included; between loads up to what interpolation leaves."""
    lateral = np.linspace(-1.0, 2.0, 3001)
    contacts = table.contacts(lateral, 0.0, load)
    creepages = np.broadcast_to([1e-3, -5e-4, 1e-4], (*contacts["normal_force_N"].shape, 3))
    push, moment = table.wrench(contacts, table.forces(lateral, 0.0, load, creepages))
    for values in (push, moment):
        changes = np.abs(np.diff(values, axis=0)).max(axis=0)
        assert (changes <= step * np.abs(values).max(axis=0) + 1e-9).all()
    slopes = np.diff(push[1001:, 1], axis=0)  # inside of the interval
    assert np.abs(np.diff(slopes, axis=0)).max() < 5e-3 * np.abs(slopes).max()


def test_forces_are_those_of_the_reduced_creepages(table):
    """Against -u / sqrt(...) of the made-up law, at many positions at once and one by one."""
    random = np.random.default_rng(5)
    creepages = random.normal(size=(40, 2, 16, 3)) * [1e-3, 1e-3, 2e-4]
    lateral, load = random.uniform(-1.0, 2.0, 40), random.uniform(100.0, 200.0, 40)
    found = table.forces(lateral, 0.0, load, creepages, friction=0.25)
    normal = table.contacts(lateral, 0.0, load)["normal_force_N"]
    limit = np.maximum(0.25 * normal, 1e-300)[..., None]
    scaled = creepages * [1e7, 1e7, 4e7]
    scaled = scaled * table.contacts(lateral, 0.0, load)["stiffness_N"][..., :1] / 1e7
    size = np.maximum(np.linalg.norm(scaled, axis=-1, keepdims=True), 1e-300)
    slip = size / (size + 2.0 * limit)
    expected = -scaled / size * slip * (2.0 - slip) * limit * [1.0, 1.0, 4.0] * (normal > 0.0)[..., None]
    assert np.abs(found - expected).max() < 0.03 * 0.25 * 1e5 * 4.0
    assert np.abs((found - expected)[..., :2]).max() < 0.03 * 0.25 * 1e5
    for number in (0, 17):
        one = table.forces(lateral[number], 0.0, load[number], creepages[number], friction=0.25)
        np.testing.assert_allclose(one[0], found[number], atol=1e-6)
    assert (table.forces(lateral, 0.0, load, creepages, friction=0.0) == 0.0).all()


def test_positions_out_of_range_are_refused_or_those_at_the_end(table):
    """The message names the axis and its range; with clamp the end counts."""
    with pytest.raises(InputError, match=r"lateral_mm = 3(.|\n)*from -1 to 2"):
        table.forces([0.0, 3.0], 0.0, 100.0, np.zeros(3))
    with pytest.raises(InputError, match="yaw_mrad = 1"):
        table.contacts(0.0, 1.0, 100.0)
    with pytest.raises(InputError, match="load_kN = nan"):
        table.contacts(0.0, 0.0, np.nan)
    far, end = table.contacts(9.0, 0.0, 300.0, clamp=True), table.contacts(2.0, 0.0, 200.0)
    np.testing.assert_array_equal(far["normal_force_N"], end["normal_force_N"])


@pytest.mark.parametrize("wrong", [{"creepages": [np.inf, 0.0, 0.0]}, {"friction": -0.1}, {"friction": np.nan}])
def test_numbers_that_have_no_meaning_are_refused(table, wrong):
    with pytest.raises(InputError, match="finite numbers, friction >= 0"):
        table.forces(0.0, 0.0, 100.0, **{"creepages": np.zeros(3), **wrong})


def test_files_that_are_no_table_are_refused(tmp_path):
    """Missing, text, other arrays, or of another format."""
    files = [tmp_path / name for name in ("missing.npz", "text.npz", "other.npz", "later.npz")]
    files[1].write_text("no table", encoding="utf-8")
    np.savez(files[2], a=np.ones(2))
    np.savez(files[3], metadata=np.array(json.dumps({"format": 99})))
    for file in files:
        with pytest.raises(InputError, match=r"(a table of creep forces|format 3)"):
            CreepTable.load(file)


def test_creepages_are_those_of_the_wheelset_that_rolls(table):
    """At random positions, yaws, rolls, curves, speeds and velocities both kinematics give the same numbers."""
    random = np.random.default_rng(11)
    for _ in range(50):
        v, rate, lateral, yaw_rate = random.uniform([1.0, 0.9, -50.0, -0.02], [80.0, 1.1, 50.0, 0.02])
        yaw, roll, angle, radius, ahead = random.uniform(
            [-0.02, -5e-3, -0.05, 300.0, -30.0], [0.02, 5e-3, 1.2, 600.0, 30.0]
        )
        curve = random.choice([-1.0, 1.0]) * random.uniform(100.0, 5000.0)
        problem = WheelsetProblem(
            load={"curve": {"radius_m": curve, "speed_km_h": 3.6 * v}},
            rolling={"yaw_rate_mrad_per_s": 1e3 * yaw_rate, "lateral_velocity_mm_per_s": lateral},
        )
        omega = rate * 1e3 * v / radius
        contacts = table.contacts(-1.0, 0.0, 100.0)
        for number, side in enumerate(("left", "right")):
            sign = (-1.0, 1.0)[number]
            pose = WheelPose(sign * 0.7, 3.0, sign * roll, sign * yaw)
            point = np.array([sign * 0.7 + 750.0, 3.0 - radius, ahead])
            arm = point - [pose.x, pose.y, 0.0]
            contacts["position_mm"][0, number, 0] = arm * [sign, 1.0, 1.0]
            contacts["wheel_roll_rad"][0, number, 0] = pose.roll_rad
            contacts["contact_angle_rad"][0, number, 0] = angle
            contacts["rolling_radius_mm"][0, number, 0] = np.linalg.norm(arm - pose.axis * (arm @ pose.axis))
            rows = point[None, :2], np.array([[-np.sin(angle), np.cos(angle)]])
            patch = SimpleNamespace(places=(np.zeros(1), np.zeros(1)), grid=SimpleNamespace(along=np.array([ahead])))
            expected = WheelsetCreep(problem, omega).creepages(side, pose, omega, rows, patch)
            found = table.creepages(
                contacts, 1e3 * yaw, speed=1e3 * v, rotation=omega, lateral_velocity=lateral,
                yaw_rate=problem.turning_rad_s,
            )[0, number, 0]  # fmt: skip
            wanted = np.concatenate([np.ravel(each) for each in (expected.along, expected.across, expected.spin)])
            np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-12)


def test_forces_are_those_of_creepages_beyond_free_rolling(table):
    """A patch that rolls freely at some creepages has no force there, and the same forces beyond."""
    free = np.array([4e-4, -2e-5, 0.0])
    moved = CreepTable({**table.values, "free_creepage": np.broadcast_to(free[:2], (3, 1, 2, 2, 2, 2))}, {})
    beyond = np.array([1e-4, 2e-4, 1e-6])
    assert np.abs(moved.forces(0.5, 0.0, 150.0, free)).max() < 1e-9
    np.testing.assert_allclose(
        moved.forces(0.5, 0.0, 150.0, free + beyond), table.forces(0.5, 0.0, 150.0, beyond), rtol=1e-9
    )


def test_the_wrench_is_that_of_the_forces_at_their_points(table):
    """Normal forces carry the load and push apart; drive on both wheels turns the axle, on one it yaws."""
    contacts = table.contacts(-1.0, 0.0, 100.0)
    forces = np.zeros((*contacts["normal_force_N"].shape, 3))
    push, moment = table.wrench(contacts, forces)
    np.testing.assert_allclose(push[0, :, 1], 5e4 * np.cos(0.05))
    np.testing.assert_allclose(push[0, :, 0], 5e4 * np.sin(0.05) * np.array([1.0, -1.0]))
    np.testing.assert_allclose(moment[0].sum(axis=0), 0.0, atol=1e-6)
    forces[0, 1, 0, 0] = 1e3
    driven, turned = table.wrench(contacts, forces)
    np.testing.assert_allclose((driven - push)[0, 1], (0.0, 0.0, 1e3))
    np.testing.assert_allclose((turned - moment)[0, 1], (-459.0e3, 750.0e3, 0.0))
    forces[:] = 0.0
    forces[0, :, 0, 1] = 1e3
    np.testing.assert_allclose((table.wrench(contacts, forces)[0] - push)[0, 0, 0], 1e3 * np.cos(0.05))


@given(st.integers(0, 10_000))
def test_the_cubic_of_an_axis_has_a_continuous_derivative(seed):
    """Weights add up to 1, lines are kept, parabolas where all is smooth, and slopes go over at every point."""
    random = np.random.default_rng(seed)
    axis = np.cumsum(random.uniform(0.2, 2.0, 6))
    smooth = interior(axis) & (random.random(6) < 0.7)
    at = np.sort(np.concatenate((axis, random.uniform(axis[0], axis[-1], 20))))

    def value(numbers, where, points):
        nodes, weights = stencil(axis, np.atleast_1d(where), points)
        return (numbers[nodes] * weights).sum(axis=-1)

    np.testing.assert_allclose(value(np.ones(6), at, smooth), 1.0, rtol=1e-12)
    np.testing.assert_allclose(value(3.0 * axis - 1.0, at, smooth), 3.0 * at - 1.0, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(value(axis**2, at, interior(axis)), at**2, rtol=1e-9)
    numbers, step = random.normal(size=6), 1e-7
    np.testing.assert_allclose(value(numbers, axis, smooth), numbers, atol=1e-9)
    for place in axis[smooth]:
        low, high = ((value(numbers, place + s, smooth) - value(numbers, place, smooth)) / s for s in (-step, step))
        # the step times a second derivative of some hundreds; a kink would be of the size of the numbers
        np.testing.assert_allclose(low, high, atol=1e-4)


def test_a_copy_of_the_reader_needs_numpy_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where flangeway is not installed the copied module is imported, and refuses what it refuses as a ValueError."""
    monkeypatch.setitem(sys.modules, "flangeway.errors", None)
    spec = spec_from_file_location("copied_reader", creep_table.__file__)
    copied = module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "copied_reader", copied)
    spec.loader.exec_module(copied)
    assert copied.InputError is ValueError
    assert copied.within_cone(np.array([[2.0, 0.0, 1.0]]))[0, 0] == pytest.approx(1.0)
