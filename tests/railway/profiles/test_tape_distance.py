"""One tape distance for each wheel file, whatever body is joined to it."""

import numpy as np
import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.miniprof import write_miniprof
from flangeway.railway.profiles.joining import joined, on_plain_body
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, Wheelset

TAPE_MM = 72.0


@pytest.fixture
def file(tmp_path):
    """A worn S1002, measured from 3 mm above the flange's tip to the rim, whose file counts from the flange's back."""
    points = wheel("S1002").running_surface.sampled(spacing=0.5)
    points = points[(points[:, 0] > -60.0) | (points[:, 1] < -25.0)]
    points = points[points[:, 0] > -63.0]
    hollow = 0.4 * np.exp(-((points[:, 0] / 25.0) ** 2))
    points = points + np.column_stack([np.zeros(len(points)), hollow])
    path = tmp_path / "worn.whl"
    path.write_text(write_miniprof(points, "wheel", "worn", TAPE_MM), encoding="utf-8")
    return path


def bodies(file):
    """The wheel on every bundled body and on the plain one."""
    measured = read_profile(file, ReadOptions(smooth_mm=5.0))
    return [on_plain_body(measured), *(joined(measured, name).profile for name in ("S1002", "AAR-1B", "heavy-haul"))]


def test_the_joined_body_does_not_move_the_wheel(file):
    """On any body a measured wheel stands its file's tape distance from the inner face, and reaches the same shift."""
    wheels = bodies(file)
    assert [each.flange_back_mm for each in wheels] == [TAPE_MM] * 4
    shifts = []
    for each in wheels:
        axle = Wheelset(each, 1360.0, 460.0 + each.flange_height_mm)
        path = RigidGeometry.of(Track(rail("60E1"), 1435.0), axle).path(40.0)
        shifts.append((path.rail_level - 460.0 * np.sin(path.roll)).max())
    assert np.ptp(shifts) < 0.02
    assert all(f"{TAPE_MM:g} mm from the flange's back (from the file)" in each.certainty for each in wheels)


def test_tape_mm_is_a_key_of_cases(file):
    """``wheel_tape_mm`` moves the wheel on its axle, and the distance stands with its origin in the summary's words."""
    inputs = {"wheel": str(file), "wheel_body": "plain", "rail": "60E1", "gauge_mm": 1435.0}
    places = {}
    for tape in (None, 70.0, 74.0):
        axle = WheelsetTangentCase.from_values({**inputs, "wheel_tape_mm": tape}).wheelset()
        face = axle.placement("right").points(axle.wheel.running_surface.sampled(spacing=0.5))
        places[tape] = axle.back_to_back_mm / 2.0 + axle.wheel.flange_back_mm
        assert axle.wheel.flange_back_mm == (tape or TAPE_MM)
        # the file counts from the flange's back: its points stay where they are, the tape line moves on them
        assert face[:, 0].min() == pytest.approx(680.0 + TAPE_MM - 63.0, abs=0.6)
    assert places[74.0] - places[70.0] == 4.0


def test_a_back_that_is_not_measured_is_assumed_and_said(tmp_path):
    """A file that counts from the tape line and does not show the flange's back gets 70 mm, with a notice."""
    points = wheel("AAR-1B").running_surface.sampled(spacing=0.5)
    path = tmp_path / "half.txt"
    for head, expected in (("", 70.0), ("tape_mm: 77", 77.0)):
        header = f"unit: mm\nkind: wheel\norigin: tape\n{head}"
        np.savetxt(path, points[points[:, 0] > -66.0], "%.5f", header=header)
        measured = read_profile(path)
        assert on_plain_body(measured).flange_back_mm == expected
        assert any("flange's back is not measured" in each for each in measured.notices) == (not head)
    np.savetxt(path, points, "%.5f")
    assert read_profile(path, ReadOptions(unit="mm")).flange_back_mm == pytest.approx(77.7875, abs=0.01)
