"""Where rails and wheels stand."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid_run import GeometryCase
from flangeway.cases.wheelset.wheelset_notes import derived
from flangeway.railway.track.placements import Track, WheelPair, WheelsetPosition
from flangeway.railway.track.wheelset_loads import WheelsetLoad

WHEELS = WheelPair(wheel="AAR-1B", back_to_back_mm=1515.0, radius_mm=500.0, radius_at="flange-tip")


def head_points(track: Track, side: str) -> np.ndarray:
    rail = track.rail_of("right")
    curve = rail.outline.part(rail.running_names)
    return track.placement(side).points(curve.sampled(spacing=0.01))


def wheel_points(wheelset: WheelPair, side: str, motion: WheelsetPosition | None = None) -> np.ndarray:
    placement = (motion or WheelsetPosition()).placement(wheelset, side)
    return placement.points(wheelset.wheel_of("right").outline.sampled(spacing=0.01))


@pytest.mark.parametrize(("gauge", "inclination"), [(1435.0, 1 / 20), (1600.0, 0.0)])
def test_gauge_is_the_distance_of_the_closest_head_points(gauge: float, inclination: float) -> None:
    """Two canted heads are the gauge apart at their closest if it is measured there, with their tops at height zero."""
    track = Track(rail="136RE", gauge_mm=gauge, inclination=inclination, gauge_at="narrowest")
    left, right = head_points(track, "left"), head_points(track, "right")
    assert right[:, 0].min() - left[:, 0].max() == pytest.approx(gauge, abs=1e-4)
    assert right[:, 1].max() == pytest.approx(0.0, abs=1e-4)
    assert left[:, 1].max() == pytest.approx(0.0, abs=1e-4)


def test_rails_lean_to_the_middle() -> None:
    """With a rail inclination of 1:40 the base's middle line is inclined by that slope, its top towards the track."""
    track = Track(rail="136RE", gauge_mm=1600.0, inclination=1 / 40)
    foot, top = track.placement("right").points([[0.0, 0.0], [0.0, 100.0]])
    assert (foot - top)[0] / (top - foot)[1] == pytest.approx(1 / 40)


def test_back_to_back_and_radius() -> None:
    """The wheels' backs are the given distance apart, and the flange tip is the radius from the axle."""
    left, right = wheel_points(WHEELS, "left"), wheel_points(WHEELS, "right")
    assert right[:, 0].min() - left[:, 0].max() == pytest.approx(1515.0, abs=1e-9)
    axle = WheelsetPosition().axle(WHEELS)
    assert axle[1] - right[:, 1].min() == pytest.approx(500.0, abs=1e-3)


def test_a_motion_is_rigid_and_about_the_axle() -> None:
    """A roll keeps the axle's middle, lowers the left wheel if positive, moves the centre of gravity to the left."""
    motion = WheelsetPosition(lateral_mm=3.0, vertical_mm=-1.0, roll_rad=1e-3)
    before, after = wheel_points(WHEELS, "right"), wheel_points(WHEELS, "right", motion)
    assert np.linalg.norm(after[0] - after[500]) == pytest.approx(np.linalg.norm(before[0] - before[500]))
    assert motion.axle(WHEELS) == pytest.approx((3.0, 500.0 - 25.4 - 1.0))
    assert after[:, 1].min() > before[:, 1].min() - 1.0
    assert wheel_points(WHEELS, "left", motion)[:, 1].min() < before[:, 1].min() - 1.0
    x, y = WheelsetLoad(1.0, offset_mm=20.0).centre_of_gravity(motion.roll_rad)
    assert x == pytest.approx(20.0 * math.cos(1e-3) - 1457.7 * math.sin(1e-3))
    assert y == pytest.approx(20.0 * math.sin(1e-3) + 1457.7 * math.cos(1e-3))


def test_left_mirrors_right() -> None:
    """Without motion the left wheel and rail are the mirror images of the right ones."""
    mirror = np.array([-1.0, 1.0])
    track = Track(rail="136RE")
    assert wheel_points(WHEELS, "left") * mirror == pytest.approx(wheel_points(WHEELS, "right"))
    assert head_points(track, "left") * mirror == pytest.approx(head_points(track, "right"))


@pytest.mark.parametrize(("gauge", "distance"), [(1435, 1360), (1445, 1360), (1600, 1515)])
def test_the_distance_of_the_wheels_follows_from_the_gauge(gauge, distance):
    """Without ``back_to_back_mm`` a usual gauge, widened or not, has its usual wheelset, and the words say which."""
    made = GeometryCase(track={"gauge_mm": gauge})
    assert made.wheels.back_to_back_mm == distance
    assert any(f"Back to back {distance} mm" in each and f"{gauge} mm" in each for each in derived(made))
    own = made.replaced(wheelset={"back_to_back_mm": 1400.0})
    assert not any("Back to back" in each for each in derived(own))
