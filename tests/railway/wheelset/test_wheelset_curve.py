"""A wheelset in a curve, overloaded, prescribed, where no equilibrium exists, and at recorded positions.

Until commit 3bac472 an independent search around one for the contact forces had found these positions.
"""

from typing import Any

import pytest

from flangeway.cases.case_file import load_case
from flangeway.railway.track.wheelset_loads import Position
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult, solve_wheelset

S1002_ON_60E1: dict[str, str | float] = {
    "rail": "60E1",
    "wheel": "S1002",
    "gauge_mm": 1435.0,
    "back_to_back_mm": 1360.0,
}


def solve(case: str, **values) -> WheelsetResult:
    return solve_wheelset(load_case(case, **{"size_scale": 2.0, **values}))


def test_the_curve_is_in_equilibrium_from_a_cold_start() -> None:
    """The resulting error is below 1e-10, with two contacts on the outer rail and one on the inner one."""
    result = solve("wheelset-curve")
    assert result.status.converged, result.status.message
    assert result.equilibrium.residuals.equilibrium_residual < 1e-10
    regions = sorted((patch.side, patch.region) for patch in result.patches)
    assert regions == [("left", "crown"), ("right", "crown"), ("right", "gauge corner")]
    along, onto = result.model.problem.forces.in_track
    assert sum(patch.force_on_wheel_N for patch in result.patches) == pytest.approx([-along, onto], rel=1e-9)


def test_flanges_push_the_rails_apart() -> None:
    """At gauge 1580.5 mm, which the flanges fill, both sides touch on tread and flange, the same on both sides."""
    result = solve("wheelset-tangent", gauge_mm=1580.5, back_to_back_mm=1515.0)
    assert result.status.converged, result.status.message
    assert sorted((patch.side, patch.region) for patch in result.patches) == [
        ("left", "crown"), ("left", "gauge corner"), ("right", "crown"), ("right", "gauge corner"),
    ]  # fmt: skip
    assert abs(result.equilibrium.position.lateral_mm) < 1e-6


@pytest.mark.ci
def test_thirty_times_the_load_is_found() -> None:
    """At 9 MN an axle, many steps' limit below first touch, the equilibrium is found as well."""
    result = solve("wheelset-tangent", axle_load_kN=9000.0)
    assert result.status.converged, result.status.message
    assert result.equilibrium.residuals.equilibrium_residual < 1e-10


def test_a_prescribed_shift_is_held_by_a_force_at_the_axle() -> None:
    """At a lateral shift of 5 mm the shift is exact and weight and roll are in equilibrium to 1e-9."""
    result = solve("wheelset-tangent", lateral_mm=5.0)
    assert result.status.converged, result.status.message
    assert result.equilibrium.position.lateral_mm == pytest.approx(5.0, abs=1e-12)
    relative = result.equilibrium.residuals
    assert abs(relative.vertical_residual) + abs(relative.moment_residual) < 1e-9
    assert abs(relative.lateral_residual) > 1e-4
    assert result.model.problem.position == Position(lateral_mm=5.0)


def test_elastic_rails_let_a_flange_go_on_where_rigid_ones_lift_it() -> None:
    """S1002 on 60E1 held beyond the place where a rigid flange climbs: found, not climbed."""
    result = solve("wheelset-tangent", lateral_mm=-7.5, **S1002_ON_60E1, size_scale=6.0)
    assert result.status.converged, result.status.message
    motion = result.equilibrium.position
    assert -motion.roll_rad == pytest.approx(0.29e-3, abs=0.05e-3)
    assert abs(motion.vertical_mm) < 1.0
    assert result.lateral_over_vertical("left") == pytest.approx(0.25, abs=0.05)


def test_mirrored_loads_have_mirrored_results() -> None:
    """S1002 on 60E1 in a curve to the left and to the right: the same numbers with sides exchanged, to 1e-7."""
    left, right = (
        solve(
            "wheelset-tangent",
            **S1002_ON_60E1,
            size_scale=6.0,
            curve={"speed_km_h": 80.0, "radius_m": radius},
        )
        for radius in (500.0, -500.0)
    )
    assert left.equilibrium.position.lateral_mm > 4.0
    assert left.equilibrium.position.lateral_mm == pytest.approx(-right.equilibrium.position.lateral_mm, rel=1e-7)
    ours, theirs = (sorted(patch.max_pressure for patch in each.patches) for each in (left, right))
    assert ours == pytest.approx(theirs, rel=1e-7)


def test_superelevation_that_balances_the_force_takes_the_flange_off() -> None:
    """With no force along the track the wheelset stays within 0.05 mm of the middle."""
    curve = {"speed_km_h": 70.0, "radius_m": 400.0, "superelevation_mm": "from-speed"}
    result = solve("wheelset-tangent", curve=curve)
    assert result.status.converged, result.status.message
    assert abs(result.equilibrium.position.lateral_mm) < 0.05


INPUTS: dict[str, dict[str, Any]] = {
    "fem": {},
    "vem": {"method": "vem"},
    "fem, nodes, penalty": {"pairing": "node-to-segment"},
    "vem, nodes, multiplier": {"method": "vem", "pairing": "node-to-segment", "enforcement": "multiplier"},
    "R-519-A on 136RE": {"wheel": "R-519-A"},
}
COARSE = {
    "tangent, fem": (0.0, -0.731958587055, 0.0),
    "curve, fem, nodes, penalty": (9.43156440242, -0.701169332057, 0.000470316778734),
    "curve, vem, nodes, multiplier": (9.60067832186, -0.707260965972, 0.000478097625967),
    "curve, R-519-A on 136RE": (7.67158498886, -0.887461669692, 0.000181177736231),
}
"""Lateral and vertical displacement in mm and roll in rad, with size_scale 4."""
FINE = {
    "tangent, fem": (0.0, -0.736932528313, 0.0),
    "curve, fem": (9.59832900538, -0.707225775247, 0.000478277419114),
    "curve, vem": (9.61278452682, -0.708030266116, 0.000478881018004),
}
"""The same with size_scale 1."""


def solved(name: str, size_scale: float) -> WheelsetResult:
    """Solve a variant."""
    track, _, variant = name.partition(", ")
    return solve_wheelset(load_case(f"wheelset-{track}", **INPUTS[variant], size_scale=size_scale))


@pytest.mark.parametrize(
    ("name", "size_scale", "recorded"),
    [(name, 4.0, recorded) for name, recorded in COARSE.items()]
    + [pytest.param(name, 1.0, recorded, marks=pytest.mark.ci) for name, recorded in FINE.items()],
)
def test_the_position_is_the_recorded_one(name: str, size_scale: float, recorded: tuple[float, ...]) -> None:
    """The position agrees to 1e-9, is stable, and takes one load step of at most 20 iterations."""
    result = solved(name, size_scale)
    assert result.status.converged, result.status.message
    assert result.equilibrium.position.components == pytest.approx(recorded, rel=1e-9, abs=1e-10)
    assert result.equilibrium.stable is True
    assert result.equilibrium.status.iterations <= 20


@pytest.mark.ci
@pytest.mark.parametrize(
    ("method", "case", "primary"), [("fem", "wheelset-curve", "wheel"), ("vem", "wheelset-tangent", "rail")]
)
def test_quadratic_edges_do_not_lock_into_each_other(method: str, case: str, primary: str) -> None:
    """Node-to-segment at order 2 with default sizes: one load step, ten iterations at most, near the fine position."""
    inputs = {"method": method, "order": 2, "pairing": "node-to-segment", "primary": primary}
    result = solve_wheelset(load_case(case, **inputs))
    assert result.status.converged, result.status.message
    assert result.equilibrium.status.iterations <= 10
    lateral = FINE["tangent, fem" if case == "wheelset-tangent" else "curve, vem"][0]
    assert result.equilibrium.position.lateral_mm == pytest.approx(lateral, rel=1e-3, abs=1e-9)
