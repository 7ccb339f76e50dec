"""Rigid equilibrium as the start of the elastic search."""

import math

import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.rigid.elastic_start import rigid_start
from flangeway.railway.track.placements import SIDES


@pytest.mark.parametrize("rail_inclination", [1 / 40, 1 / 100])
def test_a_conical_tread_touches_the_crown_where_the_slopes_agree(rail_inclination: float) -> None:
    """A tread of 1:20 touches a crown of radius R at R sin(atan(1/20) - atan(slope)) from its middle, to 1 µm."""
    start = rigid_start(
        WheelsetTangentCase.from_values({"crown_radius_in": 10.0, "rail_inclination": rail_inclination}).problem()
    )
    on_rail = start.near_points(0.01, 0.0)["rail-right"]
    assert on_rail[0, 0] == pytest.approx(-254.0 * math.sin(math.atan(1 / 20) - math.atan(rail_inclination)), abs=1e-3)
    assert start.relative_curvature_per_mm == pytest.approx(1 / 254.0)
    assert (start.motion.lateral_mm, start.motion.roll_rad) == (0.0, pytest.approx(0.0, abs=1e-15))


def test_in_the_curve_the_flange_side_has_a_second_place() -> None:
    """In the curve tread and flange root touch on the right, the tread on the left, each on both curves."""
    problem = WheelsetCurveCase().problem()
    start = rigid_start(problem)
    near = start.near_points(1e-3, 0.0)
    assert [len(near[f"wheel-{side}"]) for side in SIDES] == [1, 2]
    for side in SIDES:
        on_wheel, on_rail = near[f"wheel-{side}"], near[f"rail-{side}"]
        wheel, rail = problem.wheelset.wheel_of(side), problem.track.rail_of(side)
        assert wheel.outline.closest(on_wheel)[2].max() < 1e-6
        assert rail.outline.closest(on_rail)[2].max() < 1e-6


def test_a_prescribed_lateral_motion_is_taken() -> None:
    """The start at a prescribed lateral displacement has it; no equilibrium is computed."""
    start = rigid_start(WheelsetTangentCase.from_values({"lateral_mm": 5.0}).problem())
    assert start.motion.lateral_mm == pytest.approx(5.0, abs=1e-9)
    assert start.equilibrium is None


def test_where_a_rigid_flange_climbs_the_start_is_before_it() -> None:
    """S1002 on 60E1: from 6.9 mm a flange climbs by 70 degrees; a prescribed 8 mm starts before, 5 mm where it is."""
    values = {"rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0, "back_to_back_mm": 1360.0}
    problems = [WheelsetTangentCase.from_values({**values, "lateral_mm": y}).problem() for y in (5.0, 8.0, -8.0)]
    before, right, left = (rigid_start(problem).motion for problem in problems)
    assert before.lateral_mm == pytest.approx(5.0)
    assert 6.5 < right.lateral_mm < 7.0
    assert right.vertical_mm < 0.5
    assert (-left.lateral_mm, left.vertical_mm, -left.roll_rad) == pytest.approx(right.components, abs=1e-8)
