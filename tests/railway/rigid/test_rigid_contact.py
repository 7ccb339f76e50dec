"""Rigid contact against closed forms, brute force and published contact points, with yaw, and its curves."""

import json
import math
import re

import numpy as np
import pytest

from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Outline, Placement
from flangeway.railway.profiles.bundled import RailProfile, rail, wheel
from flangeway.railway.profiles.smoothing import STEEPEST_RAD
from flangeway.railway.rigid.conicity import read_rolling_radius_difference
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.rigid.rigid_side import RigidCurve, RigidSide, outline_across
from flangeway.railway.track.placements import Track, WheelPair
from flangeway.railway.track.wheelset_loads import WheelsetLoad

HEAVY_HAUL = (
    Track(rail="136RE", gauge_mm=1600.0, gauge_at="narrowest"),
    WheelPair(wheel="AAR-1B", back_to_back_mm=1515.0, radius_mm=500.0, radius_at="flange-tip"),
)

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
    track = Track(rail=RailProfile("corners", outline, ("gauge", "top", "field"), ("base",), "", ""))
    geometry = RigidGeometry.of(track, WheelPair(back_to_back_mm=1360.0))
    position = rigid_equilibrium(geometry, WheelsetLoad(2e5, 2e4)).reached()
    assert np.sum([point.force_on_wheel_N for point in position.contacts], axis=0) == pytest.approx(
        (-2e4, 2e5), abs=20.0
    )
    for point in position.contacts:
        assert point.rail_point_mm == pytest.approx((-30.0, 167.32), abs=1e-6)
        assert 0.1 < point.contact_angle_rad < 0.5


@pytest.fixture(scope="module")
def heavy_haul():
    return RigidGeometry.of(*HEAVY_HAUL)


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
    track, wheelset = HEAVY_HAUL
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
    with pytest.raises(InputError, match="right flange climbs"):
        heavy_haul.locus([0.0, 11.5])


def test_without_roll_each_wheel_comes_down_by_itself(heavy_haul):
    """Without roll cones have the rolling radius difference of twice the cone times the motion, whatever the rails."""
    locus = cones_on_round_rails(20.0).locus([-3.0, 2.0], roll=False)
    assert locus.rolling_radius_difference_mm == pytest.approx([-0.3, 0.2], abs=1e-10)
    assert (locus.roll_rad == 0.0).all()


def test_a_flange_root_that_conforms_to_the_gauge_corner_is_followed():
    """An S1002's flange root touches a 60E1's gauge corner within 1e-7 mm over millimetres: jumps are found."""
    values = {"radius_mm": 460.0, "wheelset.left.radius_mm": 459.0, "radius_at": "tape-line"}
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


@pytest.fixture(params=["rail", "wheel"])
def contour(request):
    if request.param == "rail":
        profile = rail("136RE")
        return profile.outline.part(profile.running_names)
    profile = wheel("AAR-1B")
    return profile.outline.part(profile.running_names)


def test_points_along_the_curve_are_on_the_contour(contour):
    """Every place along a rigid curve is a point of its contour, with the contour's tangent and curvature."""
    curve = RigidCurve.from_contour(contour)
    places = curve.at(np.linspace(0.0, curve.length, 997))
    number, parameter, distance = contour.closest(np.column_stack((places.x, places.y)))
    assert distance.max() < 1e-11
    for i in range(0, 997, 13):
        segment = contour.segments[number[i]]
        tangent = segment.tangent(parameter[i])[0]
        assert abs(tangent[0] * np.sin(places.angle[i]) - tangent[1] * np.cos(places.angle[i])) < 1e-5
        sign = 1.0 if tangent[0] * np.cos(places.angle[i]) > 0.0 else -1.0
        if 1e-6 < parameter[i] < 1.0 - 1e-6:
            assert places.curvature[i] == pytest.approx(sign * segment.curvature)


def test_the_curve_as_a_graph_is_the_curve(contour):
    """Height, angle and curvature over x agree with those along the curve."""
    curve = RigidCurve.from_contour(contour)
    along = curve.at(np.linspace(0.0, curve.length, 1001)[1:-1])
    over = curve.over(along.x)
    # near its steep ends an error of x counts sixty times in y
    assert np.abs(over.y - along.y).max() < 1e-10
    assert np.abs(over.angle - along.angle).max() < 1e-6


def test_x_grows_and_steep_parts_are_left_out(contour):
    """A rigid curve runs from the gauge side to the field side and is nowhere steeper than the limit."""
    for given in (contour, contour.reversed()):
        curve = RigidCurve.from_contour(given)
        assert (np.diff(curve.joints) > 0.0).all()
        places = curve.at(np.linspace(0.0, curve.length, 5001))
        assert np.abs(places.angle).max() <= STEEPEST_RAD + 1e-12


def test_a_graph_is_met_by_arcs_with_its_slopes():
    """Arcs through the points of a sine leave it by no more than the third power of their length."""
    errors = []
    for n_points in (41, 81):
        x = np.linspace(-2.0, 2.0, n_points)
        curve = RigidCurve.from_graph(x, np.sin(x), np.cos(x))
        between = np.linspace(-1.99, 1.99, 2000)
        errors.append(np.abs(curve.over(between).y - np.sin(between)).max())
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] > 7.0


def test_a_placed_contour_is_turned_before_it_is_cut():
    """A vertical line that is turned by 10 degrees is not vertical any more and stays."""
    upright = Contour.from_segments([Line((0.0, 0.0), (0.0, 1.0)), Line((0.0, 1.0), (5.0, 1.0))], ["side", "top"])
    assert len(RigidCurve.from_contour(upright).lengths) == 1
    assert len(RigidCurve.from_contour(upright, Placement(-math.radians(10.0))).lengths) == 2


def test_an_overhang_is_refused():
    """A surface that turns back between two running parts is an error that names the place."""
    hook = [
        Line((0.0, 0.0), (10.0, 0.0)),
        Arc((10.0, 0.0), (10.0, 4.0), (10.0, 2.0), True),
        Line((10.0, 4.0), (6.0, 4.0)),
        Line((6.0, 4.0), (6.0, 8.0)),
        Line((6.0, 8.0), (20.0, 8.0)),
    ]
    with pytest.raises(InputError, match="overhang"):
        RigidCurve.from_contour(Contour.from_segments(hook, ["a", "b", "c", "d", "e"]))


WHEEL_I = {0.0: 0.0, 1.7: 0.0, 1.8: 2.353, 2.4: 2.729, 2.8: 2.996, 4.0: 3.875, 5.0: 4.696, 6.0: 5.025, 6.5: 5.194}
"""Rolling radius difference of wheel I on rail A over the lateral motion, EN 15302:2021, annex J, a part."""


@pytest.mark.parametrize(
    ("header", "scale", "separator"),
    [
        ("y [m]; dr [m]\n", 1e-3, ";"),
        ("# unit = in\n", 1 / 25.4, "\t"),
    ],
)
def test_conicity_from_a_file(header, scale, separator, tmp_path, call):
    """A file of lateral motion and rolling radius difference gives the standard's conicity, in any unit."""
    both = [(-y, -dr) for y, dr in reversed(WHEEL_I.items()) if y] + list(WHEEL_I.items())
    file = tmp_path / "wheel-i.csv"
    rows = "\n".join(f"{scale * y:.10f}{separator}{scale * dr:.10f}" for y, dr in both)
    file.write_text(header + rows + "\n", encoding="utf-8")
    code, out, _ = call("geometry", str(file), "--out", str(tmp_path / "out"))
    assert code == 0
    assert re.search(r"equivalent conicity at 3 mm +0\.49", out)
    found = json.loads((tmp_path / "out" / "geometry.json").read_text(encoding="utf-8"))
    assert found["equivalent_conicity"]["integration"] == pytest.approx(0.493, abs=0.01)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("-5 -1\n5 1\n", "no unit"),
        ("# unit: mm\n-70 20\n0 0\n60 -2\n", "lateral displacements up to 70 mm"),
        ("# unit: mm\n-5 1\n5 -1\n", None),
        ("# unit: mm\n1 0\nx y\n", "line 3"),
    ],
)
def test_files_that_are_none(text, message, tmp_path, call):
    """What is no rolling radius difference ends in a sentence with the file's name; one that does not steer is said."""
    file = tmp_path / "difference.txt"
    file.write_text(text, encoding="utf-8")
    code, out, errors = call("geometry", str(file), "--out", str(tmp_path / "out"))
    if message is None:
        assert code == 0
        assert "no equivalent conicity" in out
    else:
        assert code == 2
        assert message in errors
        assert "difference.txt" in errors


def test_rows_in_falling_order(tmp_path):
    """Rows from right to left hold the same difference."""
    file = tmp_path / "falling.txt"
    file.write_text("# unit: mm\n5 1\n0 0\n-5 -1\n", encoding="utf-8")
    assert read_rolling_radius_difference(file).lateral_mm.tolist() == [-5.0, 0.0, 5.0]


def smallest_gap(curves, profile, rail_curve, sign, locus, yaw):
    """Least vertical gap of a wheel of revolution over a rail, by brute force over its surface, and where it is."""
    arcs, turns = np.linspace(0.0, profile.length, 4001), np.linspace(-1.15, 1.15, 2301)
    places = profile.at(arcs)
    roll, lateral = sign * float(locus.roll_rad[0]), sign * float(locus.lateral_mm[0])
    height = float(locus.vertical_mm[0]) + curves.reference_height_mm
    # yawed first, then rolled about the axis along the track
    axle = np.array([math.cos(roll) * math.cos(yaw), math.sin(roll) * math.cos(yaw), sign * math.sin(yaw)])
    down = axle * axle[1] - np.array([0.0, 1.0, 0.0])
    down /= np.linalg.norm(down)
    ahead = np.cross(axle, down) * sign
    ahead *= math.copysign(1.0, ahead[2])
    best = (math.inf, 0.0, 0.0)
    for rows in np.array_split(np.arange(len(arcs)), 20):
        x, radius = places.x[rows, None, None], -places.y[rows, None, None]
        ray = np.cos(turns)[:, None] * down + np.sin(turns)[:, None] * ahead
        points = np.array([lateral, height, 0.0]) + x * axle + radius * ray
        gap = points[..., 1] - rail_curve.over(points[..., 0]).y
        gap[(points[..., 0] < rail_curve.joints[0]) | (points[..., 0] > rail_curve.joints[-1])] = math.inf
        row, column = np.unravel_index(int(np.argmin(gap)), gap.shape)
        if gap[row, column] < best[0]:
            on_rail = points[row, column, 0]
            behind = (on_rail - lateral) * axle[2] / axle[0]  # the axle over the same place of the rail
            best = (float(gap[row, column]), float(places.x[rows][row]), float(points[row, column, 2] - behind))
    return best


def test_yaw_against_brute_force():
    """Wheels of revolution, yawed, touch prismatic rails where brute force over their surfaces finds the least gap."""
    yaw, lateral = 0.2, 3.0
    track, wheelset = Track(), WheelPair(back_to_back_mm=1360.0)
    plain, curves = (RigidGeometry.of(track, wheelset, each) for each in (0.0, yaw))
    locus = curves.locus([lateral])
    for side, sign in (("right", 1.0), ("left", -1.0)):
        gap, _, ahead = smallest_gap(curves, plain.side(side).wheel, plain.side(side).rail, sign, locus, yaw)
        assert -2e-6 < gap < 2e-4
        assert locus.side(side).ahead_mm[0, 0] == pytest.approx(ahead, abs=0.7)


def test_contact_ahead_of_the_axle():
    """An outer wheel that is behind, so that it runs against its rail, touches ahead of the axle at the flange."""
    track, wheelset = Track(), WheelPair(back_to_back_mm=1360.0)
    attack = RigidGeometry.of(track, wheelset, -0.02).locus([6.5])
    angle = float(attack.right.contact_angles_rad[0, 0] - attack.roll_rad[0])
    profile_angle = math.asin(math.sin(angle) * math.cos(0.02))
    radius = float(attack.right.rolling_radii_mm[0, 0])
    assert attack.right.ahead_mm[0, 0] == pytest.approx(
        radius * math.tan(profile_angle) * math.tan(0.02) / math.cos(0.02), rel=1e-6
    )
    assert attack.right.ahead_mm[0, 0] > 15.0
    assert abs(attack.left.ahead_mm[0, 0]) < 0.5


def test_a_cone_across_the_track():
    """The outline of a yawed cone is a line whose angle has the sine of the cone's over the cosine of the yaw."""
    cone, yaw = math.atan(1.0 / 20.0), 0.15
    ends = RigidCurve.from_graph([700.0, 800.0], [-460.0, -455.0], [math.tan(cone)] * 2)
    outline = outline_across(ends, yaw)
    assert np.abs(np.sin(outline.angles) - math.sin(cone) / math.cos(yaw)).max() < 1e-10
    assert np.abs(outline.curvatures).max() < 1e-8


def test_an_end_of_a_yawed_wheel_that_turns_back_is_left_out():
    """A steep outer face that becomes flat is seen farther out than its end: on the tread the outline is the cone's."""
    tread = RigidCurve.from_graph([700.0, 800.0], [-460.0, -455.0], [0.05, 0.05])
    ends = [700.0, 800.0, 803.0, 803.6], [-460.0, -455.0, -440.0, -436.0], [0.05, 0.05, 15.0, 0.1]
    alone, both = (outline_across(each, 0.03).starts for each in (tread, RigidCurve.from_graph(*ends)))
    assert both[both[:, 0] < 799.0] == pytest.approx(alone[alone[:, 0] < 799.0], abs=1e-6)
    assert (both[:, 0].max(), both[:, 1].min()) == pytest.approx((813.7, -460.0), abs=0.2)
