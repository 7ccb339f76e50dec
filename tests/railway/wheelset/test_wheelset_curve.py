"""A wheelset in a curve, hung on its flanges, overloaded, prescribed, and where no equilibrium exists."""

import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.track.wheelset_problem import Prescribed
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset

S1002_ON_60E1: dict[str, str | float] = {
    "rail": "60E1",
    "wheel": "S1002",
    "gauge_mm": 1435.0,
    "back_to_back_mm": 1360.0,
}


def solve(case, **values) -> WheelsetResult:
    return solve_wheelset(case.from_values({"size_scale": 2.0, **values}).problem())


def test_the_curve_is_in_equilibrium_from_a_cold_start() -> None:
    """The resulting error is below 1e-10, with two contacts on the outer rail and one on the inner one."""
    result = solve(WheelsetCurveCase)
    assert result.status.converged, result.status.message
    assert result.equilibrium.residuals.equilibrium_residual < 1e-10
    regions = sorted((patch.side, patch.region) for patch in result.patches)
    assert regions == [("left", "crown"), ("right", "crown"), ("right", "gauge corner")]
    along, onto = result.model.problem.load.in_track
    assert sum(patch.force_on_wheel_N for patch in result.patches) == pytest.approx([-along, onto], rel=1e-9)


def test_flanges_push_the_rails_apart() -> None:
    """At gauge 1580.5 mm, which the flanges fill, both sides touch on tread and flange, the same on both sides."""
    result = solve(WheelsetTangentCase, gauge_mm=1580.5, back_to_back_mm=1515.0)
    assert result.status.converged, result.status.message
    assert sorted((patch.side, patch.region) for patch in result.patches) == [
        ("left", "crown"), ("left", "gauge corner"), ("right", "crown"), ("right", "gauge corner"),
    ]  # fmt: skip
    assert abs(result.equilibrium.position.lateral_mm) < 1e-6


@pytest.mark.ci
def test_thirty_times_the_load_is_found() -> None:
    """At 9 MN an axle, many steps' limit below first touch, the equilibrium is found as well."""
    result = solve(WheelsetTangentCase, axle_load_kN=9000.0)
    assert result.status.converged, result.status.message
    assert result.equilibrium.residuals.equilibrium_residual < 1e-10


def test_a_prescribed_shift_is_held_by_a_force_at_the_axle() -> None:
    """At a lateral shift of 5 mm the shift is exact and weight and roll are in equilibrium to 1e-9."""
    result = solve(WheelsetTangentCase, lateral_mm=5.0)
    assert result.status.converged, result.status.message
    assert result.equilibrium.position.lateral_mm == pytest.approx(5.0, abs=1e-12)
    relative = result.equilibrium.residuals
    assert abs(relative.vertical_residual) + abs(relative.moment_residual) < 1e-9
    assert abs(relative.lateral_residual) > 1e-4
    assert result.model.problem.prescribed == Prescribed(lateral_mm=5.0)


def test_elastic_rails_let_a_flange_go_on_where_rigid_ones_lift_it() -> None:
    """S1002 on 60E1 held beyond the place where a rigid flange climbs: found, not climbed."""
    result = solve(WheelsetTangentCase, lateral_mm=-7.5, **S1002_ON_60E1, size_scale=6.0)
    assert result.status.converged, result.status.message
    motion = result.equilibrium.position
    assert -motion.roll_rad == pytest.approx(0.29e-3, abs=0.05e-3)
    assert abs(motion.vertical_mm) < 1.0
    assert result.lateral_over_vertical("left") == pytest.approx(0.25, abs=0.05)


def test_mirrored_loads_have_mirrored_results() -> None:
    """S1002 on 60E1 in a curve to the left and to the right: the same numbers with sides exchanged, to 1e-7."""
    left, right = (
        solve(
            WheelsetTangentCase,
            **S1002_ON_60E1,
            size_scale=6.0,
            speed_km_h=80.0,
            curve_radius_m=radius,
            superelevation_mm=0.0,
        )
        for radius in (500.0, -500.0)
    )
    assert left.equilibrium.position.lateral_mm > 4.0
    assert left.equilibrium.position.lateral_mm == pytest.approx(-right.equilibrium.position.lateral_mm, rel=1e-7)
    ours, theirs = (sorted(patch.pressure.pressures.max() for patch in each.patches) for each in (left, right))
    assert ours == pytest.approx(theirs, rel=1e-7)


def test_superelevation_that_balances_the_force_takes_the_flange_off() -> None:
    """With no force along the track the wheelset stays within 0.05 mm of the middle."""
    result = solve(WheelsetTangentCase, speed_km_h=70.0, curve_radius_m=400.0, superelevation_mm="from-speed")
    assert result.status.converged, result.status.message
    assert abs(result.equilibrium.position.lateral_mm) < 0.05
