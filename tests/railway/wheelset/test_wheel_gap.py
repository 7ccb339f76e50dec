"""Gaps to a wheel as a true surface of revolution."""

import numpy as np
import pytest

from flangeway.railway.rigid.rigid_curve import RigidCurve
from flangeway.railway.wheelset.side_contact import FAR_MM, wheel_gap

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
