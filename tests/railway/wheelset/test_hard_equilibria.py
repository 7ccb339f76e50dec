"""Wheelsets in space that stood without being found, and gaps to a wheel as a true surface of revolution."""

from functools import lru_cache

import numpy as np
import pytest

from benchmarks.standing import MAX_FORCE, Combination, checks, combinations, stand
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.rigid.rigid_side import RigidCurve
from flangeway.railway.track.placements import SIDE_SIGN
from flangeway.railway.wheelset.equilibrium import load_on_axle
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import FAR_MM, wheel_gap
from flangeway.railway.wheelset.spatial_result import solve_position, solve_spatial
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_newton import RollingPlace
from flangeway.railway.wheelset.whole_sections import whole_sections
from tests.railway.wheelset.conftest import coarse_case


@lru_cache(maxsize=8)
def surfaces_of(wheel, rail, inclination):
    """Running surfaces of a bundled pair on coarse meshes."""
    return running_surfaces(coarse_case(wheel=wheel, rail=rail, inclination=inclination))


def solved(wheel, rail, **inputs):
    """The wheelset in equilibrium."""
    case = coarse_case(wheel=wheel, rail=rail, **inputs)
    return solve_position(SpatialWheelset(case, surfaces_of(wheel, rail, case.track.inclination)), {})


def unbalanced(found):
    """Sum of the cells' normal forces and the load, over the load, (2,)."""
    position = found.equilibrium.position
    total = load_on_axle(found.problem, position.roll_rad)[:2]
    for side, state in found.equilibrium.state.sides.items():
        total = total + (state.forces.sum(axis=1) @ state.normals) * (SIDE_SIGN[side], 1.0)
    return total / found.problem.forces.vertical_N


@pytest.mark.parametrize(("force_kN", "lateral_mm"), [(10.0, 5.60), pytest.param(30.0, 6.84, marks=pytest.mark.ci)])
def test_a_heavy_haul_wheel_stands_on_136re_under_small_and_large_forces(force_kN, lateral_mm):
    """Stable on the side to which it is pushed, where an independent Newton's method had found it, in 18 steps."""
    found = solved("heavy-haul", "136RE", axle_load_kN=200, lateral_force_kN=force_kN)
    assert found.status.converged
    assert found.status.iterations <= 18
    assert found.equilibrium.stable
    assert np.abs(unbalanced(found)).max() < 1e-8
    lateral = found.equilibrium.position.lateral_mm
    assert lateral == pytest.approx(lateral_mm, abs=0.04)


@pytest.mark.ci
@pytest.mark.parametrize(("wheel", "inputs"), [("S1002", {"lateral_mm": 8.5}), ("R-519-A", {"lateral_force_kN": 60})])
def test_a_steep_flange_stands_on_136re(wheel, inputs):
    """A singular matrix, forces that changed without end: now in equilibrium, the flange loaded."""
    found = solved(wheel, "136RE", axle_load_kN=200, **inputs)
    assert found.status.converged
    assert np.abs(unbalanced(found))[1] < 1e-8
    held = "lateral_mm" in inputs
    assert held or abs(unbalanced(found)[0]) < 1e-8
    assert found.flange_touches("right")


def test_an_upright_gauge_face_is_touched_beyond_the_rigid_range():
    """A face of 1:20 on a rail inclined by 1:20 belongs to the running surface; there the flange is 2.7 mm further."""
    found = solved("AAR-1B", "60E2", inclination=0.05, axle_load_kN=160, lateral_mm=8.0)
    assert found.status.converged
    assert abs(unbalanced(found)[1]) < 1e-8
    assert found.flange_touches("right")
    surfaces = surfaces_of("AAR-1B", "60E2", 0.05)["right"]
    points, normals = surfaces.rail_points(np.sort(surfaces.rail_stations[[0, -1], 1]))
    assert normals[1] == pytest.approx((-1.0, 0.0), abs=1e-4)
    # the flat sides of the head are equally long: both faces end at one depth across the rail's own axis
    assert points[0, 1] - points[1, 1] == pytest.approx(0.05 * np.ptp(points[:, 0]), rel=1e-2)


def test_sections_of_wheels_on_heads_that_are_worn_flat(tmp_path):
    """Normals of a corner sharper than the overlap cross below the wheel's surface: its cells keep their order."""
    points = rail("60E1").running_surface.sampled(spacing=0.25)
    points = points - [0.0, points[:, 1].max()]
    path = tmp_path / "flat.ban"
    path.write_text(write_miniprof(np.minimum(points, [np.inf, -5.0]), "rail", "flat"), encoding="utf-8")
    found = solve_spatial(coarse_case(rail=str(path), wheel="S1002", lateral_force_kN=5.0, axle_load_kN=200))
    assert found.status.converged
    for patch in found.patches:
        section = whole_sections(found, "wheel")[patch.side]
        greatest = int(np.nanargmax(section.stresses.von_mises))
        at = section.positions[section.mesh.cell_points[greatest]]
        assert np.linalg.norm(at[:2] - patch.centre_mm[:2]) < 3.0
        assert section.displacement[:, 1].max() > 0.05


@pytest.mark.ci
def test_a_wheelset_with_free_yaw_runs_on_the_rolling_line():
    """Cones in a balanced curve stand at r0 l / (R gamma) with yaw 0."""
    radius_m = 4000.0
    curve = {"radius_m": radius_m, "speed_km_h": 72.0, "superelevation_mm": "from-speed"}
    rolling = {"friction": 0.3, "yaw_stiffness_kNm_per_mrad": 0.0, "theory": "fastsim"}
    found = solved("AAR-1B", "136RE", curve=curve, rolling=rolling)
    assert found.status.converged
    assert found.equilibrium.state.rolled.yaw_rad == pytest.approx(0.0, abs=2e-5)
    distance = np.mean([abs(patch.centre_mm[0]) for patch in found.patches])
    rigid = 460.0 * distance / (1e3 * radius_m * 0.05)
    assert found.equilibrium.position.lateral_mm == pytest.approx(rigid, rel=0.06)


DRAWN = combinations()


@pytest.mark.ci
@pytest.mark.parametrize("number", [92, 116, 251, 308, 330, 377, 387, 470, 576])
def test_a_wheelset_with_friction_finds_its_position(number):
    """What each depends on.

    Creep forces that jump on coarse cells of a conforming pair (92), an upright gauge face (116), a free yaw on the
    flange (251, 470), a flange that is apart where cells are chosen and reached on the way (308), steps of the rate
    that keep their sense (330), a flange root that touches as the patch on the tread wanders (377), a flange that holds
    a guided wheelset (387), and one that comes close beside the patch on the tread (576).
    """
    end = stand(DRAWN[number])
    assert end["end"] == "converged", end["message"]


@pytest.mark.ci
@pytest.mark.parametrize("number", [2, 8, 9, 20])
def test_searches_from_two_starts_end_at_one_position(number):
    """With friction, from 0.5 mm apart: to 0.02 mm or the uncertainty of the position, whichever is larger."""
    wheelset = [drawn for drawn in DRAWN if drawn.friction][number].wheelset
    found = solve_position(wheelset, {})
    place, ends = RollingPlace.of(found.equilibrium), [found.equilibrium]
    ends += [wheelset.solve(near=place._replace(lateral_mm=place.lateral_mm + way)) for way in (-0.25, 0.25)]
    assert all(end.status.converged for end in ends)
    lateral = [end.position.lateral_mm for end in ends]
    assert np.ptp(lateral) < max(0.02, found.lateral_uncertainty_mm)


@pytest.mark.ci
@pytest.mark.parametrize(
    "wheelset",
    [
        Combination("R-519-B", "49E1", 0.0, 313.6, 0.1, 0.22, None, None),
        Combination("R-519-H", "136RE", 0.05, 160.9, 54.85, 0.28, 150.0, 0.0),
    ],
    ids=["steps-across-the-middle", "free-yaw-on-the-flange"],
)
def test_a_wheelset_does_not_go_to_and_fro(wheelset):
    """Neither by long steps across the middle with short ones between, nor by its yaw while the flange holds it."""
    end = stand(wheelset)
    assert end["end"] == "converged", end["message"]


@pytest.mark.ci
def test_wheels_that_slip_everywhere_find_the_yaw_of_their_guidance():
    """A wheelset that turns fast in a soft guidance: from the frictionless position it yaws back by 12 mrad."""
    rolling = {"speed_km_h": 153.3, "friction": 0.18, "yaw_stiffness_kNm_per_mrad": 1, "yaw_rate_mrad_per_s": 18}
    problem = coarse_case(wheel="R-519-C", lateral_force_kN=-21.05, rolling=rolling, yaw_mrad=10.7)
    found = solve_position(SpatialWheelset(problem, running_surfaces(problem)), {})
    assert found.status.converged
    assert checks(found)["force"] < MAX_FORCE
    rolled = found.equilibrium.state.rolled
    assert rolled.yaw_moment_Nmm == pytest.approx(1e9 * (rolled.yaw_rad - 10.7e-3), rel=1e-4)


def cells_of_the_middle():
    """The wheelset S1002 on 60E1, its rigid position, and coarse cells there."""
    case = coarse_case()
    wheelset = SpatialWheelset(case, surfaces_of("S1002", "60E1", case.track.inclination))
    position = wheelset.start.motion
    return wheelset, position, wheelset.whole(position, None, {})


def test_cells_farther_apart_than_the_compliances_are_tabulated_have_coefficients():
    """Those of a wheelset at a large yaw, half a metre apart along the track: they fall with the distance."""
    _, _, grids = cells_of_the_middle()
    grid = grids["right"]
    coefficients = grid.coefficients_of((1,), slice(10, 14), int(500.0 / grid.grid.strip))
    near, middle, far = (coefficients[place].diagonal() for place in (0, len(coefficients) // 2, -1))
    assert (near > middle).all()
    assert (middle > far).all()
    assert (far > 0.0).all()


X = np.linspace(-30.0, 30.0, 601)
POINTS = np.stack((np.linspace(-8.0, 8.0, 5), np.full(5, -1.0)), axis=1)
UP = np.tile([0.0, 1.0], (5, 1))
Z = np.linspace(-15.0, 15.0, 7)


def sphere(radius):
    return RigidCurve.from_graph(X, -np.sqrt(radius**2 - X**2), X / np.sqrt(radius**2 - X**2))


@pytest.mark.parametrize("roll", [0.0, 0.02])
@pytest.mark.parametrize("yaw", [0.0, 0.05])
def test_the_gap_to_a_sphere_does_not_depend_on_its_axis(roll, yaw) -> None:
    """A sphere is one of revolution about any axis: the gap is ``c - sqrt(R^2 - x^2 - z^2)`` to 1e-6 mm."""
    middle = np.array([1.0, 99.5])
    axis = np.array([np.cos(roll) * np.cos(yaw), np.sin(roll), np.cos(roll) * np.sin(yaw)])
    found = wheel_gap(sphere(100.0), middle, axis, POINTS, UP, Z)
    x, z = np.meshgrid(POINTS[:, 0] - 1.0, Z, indexing="ij")
    assert found.gaps == pytest.approx(99.5 + 1.0 - np.sqrt(100.0**2 - x**2 - z**2), abs=1e-6)


def test_gaps_change_with_the_wheel_as_their_derivatives_say() -> None:
    """Derivatives by translations and roll agree with differences to 1e-6."""
    wheel = RigidCurve.from_graph(X, -460.0 - 0.001 * X**2, -0.002 * X)
    axis = np.array([1.0, 0.0, 0.0])
    middle = np.array([0.5, 459.8])
    found = wheel_gap(wheel, middle, axis, POINTS, UP, Z)
    step = 1e-5
    for direction in range(2):
        moved = [
            wheel_gap(wheel, middle + sign * step * np.eye(2)[direction], axis, POINTS, UP, Z).gaps
            for sign in (1.0, -1.0)
        ]
        assert (moved[0] - moved[1]) / (2.0 * step) == pytest.approx(found.by_motion[..., direction], abs=1e-6)
    rolled = [
        wheel_gap(wheel, middle, np.array([np.cos(angle), np.sin(angle), 0.0]), POINTS, UP, Z).gaps
        for angle in (1e-6, -1e-6)
    ]
    by, arms = found.by_motion, found.arms
    expected = by[..., 1] * arms[..., 0] - by[..., 0] * arms[..., 1]
    assert (rolled[0] - rolled[1]) / 2e-6 == pytest.approx(expected, abs=1e-3)


def test_points_beside_the_wheel_have_no_gap() -> None:
    """Rays that pass the wheel do not meet it."""
    beside = POINTS + np.array([100.0, 0.0])
    found = wheel_gap(sphere(100.0), np.array([0.0, 99.0]), np.array([1.0, 0.0, 0.0]), beside, UP, Z)
    assert (found.gaps == FAR_MM).all()


def test_an_axle_below_the_rails_has_not_converged():
    """Rigid wheels stand at 0, so that rails that are not touched a kilometre lower have been passed through."""
    run = coarse_case(vertical_mm=-1e6, lateral_mm=0.0).run()
    assert not run.result.status.converged
    assert "below" in run.result.status.message


def test_an_axle_in_the_air_touches_nothing():
    """Half a millimetre above the rails there is no force, and no error."""
    run = coarse_case(vertical_mm=0.5, lateral_mm=0.0).run()
    assert run.result.status.converged, run.result.status.message
    assert not run.result.patches
