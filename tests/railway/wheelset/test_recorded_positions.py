"""Positions of the plane wheelset in several variants, as an independent search for the equilibrium had found them.

Until commit 3bac472 Newton's method for the position ran around one for the contact forces of each position; now forces
and position are unknowns of one system. Both end in the same place.
"""

from typing import Any

import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset

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
    "tangent, fem": (0.0, -0.736932530194, 0.0),
    "curve, fem": (9.59833518515, -0.707225723104, 0.000478277884307),
    "curve, vem": (9.61278467751, -0.708030252655, 0.00047888103651),
}
"""The same with size_scale 1."""


def solved(name: str, size_scale: float) -> WheelsetResult:
    """Solve a variant."""
    track, _, variant = name.partition(", ")
    case = WheelsetTangentCase if track == "tangent" else WheelsetCurveCase
    return solve_wheelset(case.from_values({**INPUTS[variant], "size_scale": size_scale}).problem())


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
    ("method", "case", "primary"), [("fem", WheelsetCurveCase, "wheel"), ("vem", WheelsetTangentCase, "rail")]
)
def test_quadratic_edges_do_not_lock_into_each_other(
    method: str, case: type[WheelsetTangentCase], primary: str
) -> None:
    """Node-to-segment at order 2 with default sizes: one load step, ten iterations at most, near the fine position."""
    inputs = {"method": method, "order": 2, "pairing": "node-to-segment", "primary": primary}
    result = solve_wheelset(case.from_values(inputs).problem())
    assert result.status.converged, result.status.message
    assert result.equilibrium.status.iterations <= 10
    lateral = FINE["tangent, fem" if case is WheelsetTangentCase else "curve, vem"][0]
    assert result.equilibrium.position.lateral_mm == pytest.approx(lateral, rel=1e-3, abs=1e-9)
