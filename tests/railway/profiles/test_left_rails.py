"""A left rail that is read as a right one is noticed, and every profile takes mirror, unit and tape_mm."""

import numpy as np
import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.miniprof import write_miniprof


def head(corner_mm=0.0, face_mm=0.0, lean=0.0):
    """A 60E1's head from its top, from the field side: corner worn, face cut upright down to 16 mm, inclined."""
    points = rail("60E1").running_surface.sampled(spacing=0.3) - [0.0, 172.0]
    points[:, 1] -= corner_mm * np.exp(-(((points[:, 0] + 27.0) / 9.0) ** 2)) * (points[:, 1] > -12.0)
    high = points[:, 1] > -16.0
    points[high, 0] = np.maximum(points[high, 0], -36.0 + face_mm) if face_mm else points[high, 0]
    turn = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
    points = points @ turn.T
    return points[np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > 0.02])]


def saved(folder, points, name="rail.ban"):
    path = folder / name
    path.write_text(write_miniprof(points, "rail", "a rail"), encoding="utf-8")
    return path


@pytest.mark.parametrize("case", [WheelsetTangentCase, GeometryCase])
def test_mirror_unit_and_tape_are_keys_of_cases(case, tmp_path):
    """Every case takes ``rail_mirror``, ``rail_unit``, ``wheel_tape_mm`` and those of the left side."""
    right = head(corner_mm=2.0)
    left = saved(tmp_path, right * [-1.0, 1.0], "left.ban")
    inches = tmp_path / "inches.txt"
    inches.write_text("\n".join(f"{x:.6f} {y:.6f}" for x, y in right / 25.4), encoding="utf-8")
    tread = wheel("S1002").running_surface.sampled(spacing=0.5) / 25.4
    wheels = tmp_path / "wheel.txt"
    wheels.write_text("\n".join(f"{x:.6f} {y:.6f}" for x, y in tread), encoding="utf-8")
    values = {
        "rail": str(inches), "rail_unit": "in", "left_rail": str(left), "left_rail_mirror": True, "rail_body": "60E1",
        "wheel": str(wheels), "wheel_unit": "in", "wheel_tape_mm": 71.0, "wheel_body": "S1002", "gauge_mm": 1435.0,
    }  # fmt: skip
    made = case.from_values(values)
    track, axle = made.track(), made.wheelset()
    outlines = [track.rail_of(side).outline.sampled(spacing=1.0) for side in ("left", "right")]
    assert track.rail_of("right").outline.closest(outlines[0])[2].max() < 0.02
    assert not any("field side" in each for side in ("left", "right") for each in track.rail_of(side).notices)
    assert axle.wheel.flange_back_mm == 71.0
    wrong = case.from_values({**values, "left_rail_mirror": False}).track()
    assert any("left_rail_mirror" in each for each in wrong.rail_of("left").notices)


def test_a_key_for_no_file_is_refused():
    """What is said of the file of a bundled or missing profile is refused, with the key."""
    for values in ({"rail_mirror": True}, {"wheel_tape_mm": 70.0}, {"left_rail_unit": "in"}):
        with pytest.raises(InputError, match=next(iter(values))):
            WheelsetTangentCase.from_values(values).problem()
