"""Wheelsets of the random campaign that did not find their position, and step limits that let them."""

import pytest

from benchmarks.standing import MAX_FORCE, checks, combinations, stand
from flangeway.railway.wheelset.equilibrium import Reach
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from tests.railway.wheelset.conftest import coarse_case

DRAWN = combinations()


@pytest.mark.ci
@pytest.mark.parametrize("number", [92, 116, 330, 387, 576])
def test_a_wheelset_with_friction_finds_its_position(number):
    """What each depends on.

    Creep forces that jump on coarse cells of a conforming pair (92), an upright gauge face (116), steps of the rate
    that keep their sense (330), a flange that holds a guided wheelset (387), and one that comes close beside the patch
    on the tread (576).
    """
    end = stand(DRAWN[number])
    assert end["end"] == "converged", end["message"]


@pytest.mark.ci
def test_wheels_that_slip_everywhere_find_the_yaw_of_their_guidance():
    """A wheelset that turns fast in a soft guidance: from the frictionless position it yaws back by 12 mrad."""
    case = coarse_case(
        wheel="R-519-C", lateral_force_kN=-21.05, speed_km_h=153.3, friction=0.18, yaw_stiffness_kNm_per_mrad=1,
        yaw_rate_mrad_per_s=18, yaw_mrad=10.7,
    )  # fmt: skip
    problem, model = case.problem(), case.spatial_model()
    found = solve_position(SpatialWheelset(problem, running_surfaces(problem, model), model), {})
    assert found.status.converged
    assert checks(found)["force"] < MAX_FORCE
    rolled = found.equilibrium.state.rolled
    assert rolled.yaw_moment_Nmm == pytest.approx(1e9 * (rolled.yaw_rad - 10.7e-3), rel=1e-4)


def test_a_step_limit_shrinks_with_the_sense_of_steps_and_recovers():
    """After four changes of sense it is below a tenth of the first; steps of one sense bring it back, no farther."""
    reach = Reach(1.0, 1.0)
    for sense in (1.0, -1.0, 1.0, -1.0, 1.0):
        reach.last = sense * reach.limit_of(sense, halved=False)
    assert reach.limit < 0.1
    for _ in range(30):
        reach.last = reach.limit_of(1.0, halved=False)
    assert reach.limit == pytest.approx(1.0)
