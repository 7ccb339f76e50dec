"""What `flangeway geometry` takes: rolling radius differences, case files, yaw."""

import json
import math
import re

import numpy as np
import pytest

from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.rigid.conicity import read_rolling_radius_difference
from flangeway.railway.rigid.rigid_curve import RigidCurve, outline_across
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, Wheelset

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
    track, wheelset = Track(rail("60E1"), 1435.0, gauge_depth_mm=14.0), Wheelset(wheel("S1002"), 1360.0, 488.0)
    plain, curves = (RigidGeometry.of(track, wheelset, each) for each in (0.0, yaw))
    locus = curves.locus([lateral])
    for side, sign in (("right", 1.0), ("left", -1.0)):
        gap, _, ahead = smallest_gap(curves, plain.side(side).wheel, plain.side(side).rail, sign, locus, yaw)
        assert -2e-6 < gap < 2e-4
        assert locus.side(side).ahead_mm[0, 0] == pytest.approx(ahead, abs=0.7)


def test_contact_ahead_of_the_axle():
    """An outer wheel that is behind, so that it runs against its rail, touches ahead of the axle at the flange."""
    track, wheelset = Track(rail("60E1"), 1435.0, gauge_depth_mm=14.0), Wheelset(wheel("S1002"), 1360.0, 488.0)
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
