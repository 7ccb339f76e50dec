"""Positions in which rigid wheels touch rigid rails, against closed forms, brute force and published contact points."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import run_geometry
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Outline
from flangeway.railway.profiles.bundled import RailProfile, rail, wheel
from flangeway.railway.rigid.rigid_curve import RigidCurve
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.rigid.rigid_side import RigidSide
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad

HALF_DISTANCE, RADIUS, CONE = 750.0, 460.0, math.atan(1.0 / 20.0)


def cone(half_width=60.0):
    """A conical wheel about the middle of the axle, rolling radius 460 mm at 750 mm."""
    ends = [(HALF_DISTANCE + x, -RADIUS + math.tan(CONE) * x) for x in (-half_width, half_width)]
    return RigidCurve.from_contour(Contour.from_segments([Line(*ends)], ["tread"]))


def round_rail(radius):
    """Upper half of a circle with its top at (750, 0)."""
    middle = (HALF_DISTANCE, -radius)
    arc = Arc((HALF_DISTANCE + radius, -radius), (HALF_DISTANCE - radius, -radius), middle, True)
    return RigidCurve.from_contour(Contour.from_segments([arc], ["head"]))


def cones_on_round_rails(radius):
    side = RigidSide(cone(), round_rail(radius))
    return RigidGeometry(side, side, RADIUS)


def test_a_sharp_corner_of_a_rail_is_touched_with_the_angle_of_the_wheel():
    """A flat head with faces of 60 degrees and no rounding between: forces in equilibrium under L/V 0.1."""
    x, y = np.array(
        [[-70.0, 70.0, 70.0, 40.0, 30.0, -30.0, -40.0, -70.0], [0.0, 0.0, 140.0, 150.0, 167.32, 167.32, 150.0, 140.0]]
    )
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    names = ["base", "side", "shoulder", "field", "top", "gauge", "shoulder", "side"]
    outline = Outline.from_segments([Line(*ends) for ends in zip(points, [*points[1:], points[0]], strict=True)], names)
    track = Track(RailProfile("corners", outline, ("gauge", "top", "field"), ("base",), "", ""), 1435.0)
    geometry = RigidGeometry.of(track, Wheelset(wheel("S1002"), 1360.0, 488.0))
    position = rigid_equilibrium(geometry, WheelsetLoad(2e5, 2e4)).reached()
    assert np.sum([point.force_on_wheel_N for point in position.contacts], axis=0) == pytest.approx(
        (-2e4, 2e5), abs=20.0
    )
    for point in position.contacts:
        assert point.rail_point_mm == pytest.approx((-30.0, 167.32), abs=1e-6)
        assert 0.1 < point.contact_angle_rad < 0.5


@pytest.fixture(scope="module")
def heavy_haul():
    return RigidGeometry.of(Track(rail("136RE")), Wheelset(wheel("AAR-1B")))


@pytest.mark.parametrize("radius", [0.01, 300.0])
def test_cones_on_round_rails_in_closed_form(radius):
    """Roll, lateral and vertical motion, contact points and rolling radii of cones on circular rails are exact.

    Moved outward by the rails' radius the cones slide on two fixed points: a bar of fixed length between two lines.
    """
    slope, b = math.tan(CONE), HALF_DISTANCE
    delta = np.array([-5.0, -1.0, 0.0, 0.3, 4.0])
    mean = np.sqrt(b**2 - (slope * delta) ** 2)
    roll = np.arctan2(slope * delta, mean)
    depth = RADIUS + radius / math.cos(CONE)
    below = slope * (mean - b) - depth
    lateral = delta * np.cos(roll) + below * np.sin(roll)
    height = -radius + delta * np.sin(roll) - below * np.cos(roll)

    locus = cones_on_round_rails(radius).locus(lateral)

    assert np.abs(locus.lateral_mm - lateral).max() < 1e-10
    assert np.abs(locus.roll_rad - roll).max() < 1e-12
    assert np.abs(locus.vertical_mm - (height - RADIUS)).max() < 1e-9
    assert np.abs(locus.rolling_radius_difference_mm - 2.0 * slope * delta).max() < 1e-9
    on_right_wheel = mean - delta - radius * math.sin(CONE)
    assert np.abs(locus.right.wheel_points_mm[:, 0, 0] - on_right_wheel).max() < 1e-8
    assert np.abs(locus.right.contact_angles_rad[:, 0] - (CONE + roll)).max() < 1e-10
    assert locus.left.relative_curvatures_per_mm[:, 0] == pytest.approx(1.0 / radius)


def brute_gap(side, lateral, height, roll):
    """Vertical gaps of densely sampled wheel points over the rail."""
    points = side.wheel.at(np.linspace(0.0, side.wheel.length, 400_001))
    x = lateral + math.cos(roll) * points.x - math.sin(roll) * points.y
    y = height + math.sin(roll) * points.x + math.cos(roll) * points.y
    over = (x >= side.rail.joints[0]) & (x <= side.rail.joints[-1])
    return y[over] - side.rail.over(x[over]).y


@pytest.mark.parametrize("lateral", [-9.7, 0.0, 7.99])
def test_both_wheels_touch_and_none_penetrates(heavy_haul, lateral):
    """In every position the smallest gap of either wheel, by brute force, is zero."""
    locus = heavy_haul.locus([lateral])
    height = float(locus.vertical_mm[0]) + heavy_haul.reference_height_mm
    for side, sign in ((heavy_haul.right, 1.0), (heavy_haul.left, -1.0)):
        gap = brute_gap(side, sign * lateral, height, sign * float(locus.roll_rad[0])).min()
        assert -1e-10 < gap < 2e-7


def test_points_agree_in_all_frames(heavy_haul):
    """Points of contact in the frames of both profiles are the same point of the track."""
    track, wheelset = Track(rail("136RE")), Wheelset(wheel("AAR-1B"))
    locus = heavy_haul.locus([-8.6, 3.0, 9.5])
    for number in range(3):
        motion = locus.motion(number)
        for side in ("left", "right"):
            at = locus.side(side)
            from_rail = track.placement(side).points(at.rail_points_mm[number, :1])
            from_wheel = motion.placement(wheelset, side).points(at.wheel_points_mm[number, :1])
            assert from_rail[0] == pytest.approx(at.points_mm[number, 0], abs=1e-9)
            assert from_wheel[0] == pytest.approx(at.points_mm[number, 0], abs=1e-8)


def test_at_a_jump_a_side_touches_in_two_points(heavy_haul):
    """At the place of a jump both points touch, and beside it only the nearer one does."""
    right = [jump for jump in heavy_haul.jumps(9.0) if jump.side == "right"]
    assert len(right) == 1
    inner, outer = right[0].wheel_points_mm
    assert outer[0] < inner[0] - 10.0
    place = right[0].motion.lateral_mm
    locus = heavy_haul.locus([place - 0.01, place, place + 0.01])
    assert locus.right.gaps_mm[1, 1] < 1e-9
    assert (locus.right.gaps_mm[[0, 2], 1] > 1e-3).all()
    assert locus.right.wheel_points_mm[0, 0, 0] == pytest.approx(inner[0], abs=0.05)
    assert locus.right.wheel_points_mm[2, 0, 0] == pytest.approx(outer[0], abs=0.3)


def test_the_climbing_flange_turns_the_axle_back(heavy_haul):
    """Along the climbing flange the axle's lateral motion has a maximum value; beyond it is refused with that value."""
    path = heavy_haul.located(heavy_haul.path(12.0))
    assert (np.diff(path.lateral_mm[path.rail_level_mm > 0.0]) < 0.0).any()
    with pytest.raises(InputError, match="climbing flanges"):
        heavy_haul.locus([0.0, 11.5])


def test_without_roll_each_wheel_comes_down_by_itself(heavy_haul):
    """Without roll cones have the rolling radius difference of twice the cone times the motion, whatever the rails."""
    locus = cones_on_round_rails(20.0).locus([-3.0, 2.0], roll=False)
    assert locus.rolling_radius_difference_mm == pytest.approx([-0.3, 0.2], abs=1e-10)
    assert (locus.roll_rad == 0.0).all()


def test_a_flange_root_that_conforms_to_the_gauge_corner_is_followed():
    """An S1002's flange root touches a 60E1's gauge corner within 1e-7 mm over millimetres: jumps are found."""
    values = {"wheel_radius_mm": 460.0, "left_wheel_radius_mm": 459.0, "wheel_radius_at": "tape-line"}
    wheelset = find_geometry_case("s1002-60e1", values).geometry()
    jumps = wheelset.jumps(6.7)
    assert {jump.side for jump in jumps} == {"left", "right"}
    last = min(jumps, key=lambda jump: jump.motion.lateral_mm)
    assert (last.side, last.motion.lateral_mm) == ("left", pytest.approx(-6.6, abs=0.2))


@pytest.mark.parametrize("maximum", [8.0, 60.0])
def test_a_scan_ends_where_a_flange_climbs(maximum):
    """A scan beyond what the flange allows ends at the flange, with a notice."""
    inputs = {"gauge_mm": 1590.0, "back_to_back_mm": 1515.0, "step_mm": 0.1, "maximum_amplitude_mm": 2.0}
    case = find_geometry_case("wheelset-tangent", inputs | {"maximum_lateral_mm": maximum})
    run = run_geometry("wheelset-tangent", case)
    reached = float(run.locus.lateral_mm[-1])
    assert 3.0 < reached < maximum - 0.5
    said = [notice for notice in run.summary["notices"] if "stops at" in notice]
    assert len(said) == 1
    assert f"{-reached:.2f} and {reached:.2f} mm" in said[0]
    assert run.locus.right.contact_angles_rad[-1, 0] > 0.5
    assert run.equilibrium.status.converged
