"""Where rails and wheels stand."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid_run import GeometryCase
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.placements import Track, Wheelset, WheelsetPosition


def head_points(track: Track, side: str) -> np.ndarray:
    curve = track.rail.outline.part(track.rail.running_names)
    return track.placement(side).points(curve.sampled(spacing=0.01))


def wheel_points(wheelset: Wheelset, side: str, motion: WheelsetPosition | None = None) -> np.ndarray:
    placement = (motion or WheelsetPosition()).placement(wheelset, side)
    return placement.points(wheelset.wheel.outline.sampled(spacing=0.01))


@pytest.mark.parametrize(("gauge", "rail_inclination"), [(1435.0, 1 / 20), (1600.0, 0.0)])
def test_gauge_is_the_distance_of_the_closest_head_points(gauge: float, rail_inclination: float) -> None:
    """Two canted heads are the gauge apart at their closest if it is measured there, with their tops at height zero."""
    track = Track(rail(), gauge_mm=gauge, rail_inclination=rail_inclination, gauge_at="narrowest")
    left, right = head_points(track, "left"), head_points(track, "right")
    assert right[:, 0].min() - left[:, 0].max() == pytest.approx(gauge, abs=1e-4)
    assert right[:, 1].max() == pytest.approx(0.0, abs=1e-4)
    assert left[:, 1].max() == pytest.approx(0.0, abs=1e-4)


def test_rails_lean_to_the_middle() -> None:
    """With a rail inclination of 1:40 the base's middle line is inclined by that slope, its top towards the track."""
    track = Track(rail(), rail_inclination=1 / 40)
    foot, top = track.placement("right").points([[0.0, 0.0], [0.0, 100.0]])
    assert (foot - top)[0] / (top - foot)[1] == pytest.approx(1 / 40)


def test_back_to_back_and_radius() -> None:
    """The wheels' backs are the given distance apart, and the flange tip is the radius from the axle."""
    wheelset = Wheelset(wheel(), back_to_back_mm=1515.0, radius_mm=500.0)
    left, right = wheel_points(wheelset, "left"), wheel_points(wheelset, "right")
    assert right[:, 0].min() - left[:, 0].max() == pytest.approx(1515.0, abs=1e-9)
    axle = WheelsetPosition().axle(wheelset)
    assert axle[1] - right[:, 1].min() == pytest.approx(500.0, abs=1e-3)


def test_a_motion_is_rigid_and_about_the_axle() -> None:
    """A roll keeps the axle's middle, lowers the left wheel if positive, moves the centre of gravity to the left."""
    wheelset = Wheelset(wheel())
    motion = WheelsetPosition(lateral_mm=3.0, vertical_mm=-1.0, roll_rad=1e-3)
    before, after = wheel_points(wheelset, "right"), wheel_points(wheelset, "right", motion)
    assert np.linalg.norm(after[0] - after[500]) == pytest.approx(np.linalg.norm(before[0] - before[500]))
    assert motion.axle(wheelset) == pytest.approx((3.0, 500.0 - 25.4 - 1.0))
    assert after[:, 1].min() > before[:, 1].min() - 1.0
    assert wheel_points(wheelset, "left", motion)[:, 1].min() < before[:, 1].min() - 1.0
    x, y = motion.centre_of_gravity(wheelset)
    assert x == pytest.approx(3.0 - 1457.7 * math.sin(1e-3))
    assert y == pytest.approx(500.0 - 25.4 - 1.0 + 1457.7 * math.cos(1e-3))


def test_left_mirrors_right() -> None:
    """Without motion the left wheel and rail are the mirror images of the right ones."""
    mirror = np.array([-1.0, 1.0])
    wheelset, track = Wheelset(wheel()), Track(rail())
    assert wheel_points(wheelset, "left") * mirror == pytest.approx(wheel_points(wheelset, "right"))
    assert head_points(track, "left") * mirror == pytest.approx(head_points(track, "right"))


@pytest.mark.parametrize(("gauge", "distance"), [(1435, 1360), (1445, 1360), (1600, 1515)])
def test_the_distance_of_the_wheels_follows_from_the_gauge(gauge, distance):
    """Without ``back_to_back_mm`` a usual gauge, widened or not, has its usual wheelset, and the words say which."""
    made = GeometryCase.from_values({"gauge_mm": gauge, "wheel": "S1002", "rail": "60E1"})
    assert made.wheelset().back_to_back_mm == distance
    assert any(f"Back to back {distance} mm" in each and f"{gauge} mm" in each for each in made.derived())
    assert not any("Back to back" in each for each in made.model_copy(update={"back_to_back_mm": 1400.0}).derived())
