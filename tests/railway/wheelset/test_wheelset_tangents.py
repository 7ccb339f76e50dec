"""The tangent of a wheelset in three dimensions: it has the symmetry of a potential."""

import pytest

from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_newton import WheelsetNewton
from tests.railway.wheelset.conftest import coarse_case


@pytest.mark.parametrize("axle", ["rigid", "elastic"])
def test_the_stiffness_across_and_upwards_is_symmetric(axle):
    """Without friction K_xy = K_yx to 1e-3 of K_yy, roll and axle in equilibrium: the axle has an energy too."""
    case = coarse_case(axle=axle, lateral_force_kN=30.0)
    wheelset = SpatialWheelset(case, running_surfaces(case))
    equilibrium = solve_position(wheelset, {}).equilibrium
    state = equilibrium.state
    newton = WheelsetNewton(case, state.grids, equilibrium.position, wheelset.compliance, state, None)
    newton.linearise(1e-8)
    whole = -newton.condensed
    (_, k_xy), (k_yx, k_yy) = whole[:2, :2] - whole[:2, 2:] @ whole[2:, :2] / whole[2, 2]
    assert k_xy == pytest.approx(k_yx, abs=1e-3 * k_yy)
