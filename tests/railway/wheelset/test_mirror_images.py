"""A symmetric wheelset that stands beside the middle of the track: its other equilibria are named."""

import re

import pytest

from flangeway.cases.case_file import bodies_key
from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.railway.track.placements import SIDES
from tests.railway.wheelset.conftest import coarse_case

PAIR = {"wheel": "heavy-haul", "rail": "136RE"}


def pushed(case, bodies) -> float:
    """Lateral force of the rails on the wheelset, N."""
    result = case.run_on(bodies).result
    assert result.status.converged
    return sum(float(result.force_on_wheel_N(side)[0]) for side in SIDES)


def test_an_elastic_wheelset_beside_the_middle():
    """Mirror image and middle are in equilibrium, at a tenth of the distance it is pushed outwards by what is said."""
    case = coarse_case(**PAIR)
    bodies = case.prepared()
    result = case.run_on(bodies).result
    lateral = result.equilibrium.position.lateral_mm
    assert abs(lateral) > 1.0
    (said,) = [warning for warning in result.warnings if "mirror image" in warning]
    at, mirrored, near, force = (float(number) for number in re.findall(r"-?\d+\.?\d*(?:e\+\d+)?", said))
    assert (at, mirrored) == pytest.approx((abs(lateral), -lateral), abs=0.006)
    others = [coarse_case(**PAIR, lateral_mm=value) for value in (-lateral, 0.0, 0.1 * lateral)]
    assert len({bodies_key(other) for other in (case, *others)}) == 1
    forces = [pushed(other, bodies) for other in others]
    # the cells depend on the path of the search: here by 10 N, or 0.001 mm
    assert forces[:2] == pytest.approx((0.0, 0.0), abs=20.0)
    assert near == pytest.approx(0.1 * abs(lateral), abs=0.006)
    assert forces[2] * lateral > 0.0
    assert force == pytest.approx(abs(forces[2]), rel=0.01)
    assert "leaves the middle" in said


def test_a_pushed_wheelset_has_no_mirror_image():
    """Under a lateral force nothing is said."""
    run = coarse_case(**PAIR, lateral_force_kN=10.0).run()
    assert not any("mirror image" in warning for warning in run.warnings)


def test_a_rigid_wheelset_beside_the_middle():
    """The notice lists the mirror image and the middle with their stability, as the list of equilibria has them."""
    run = run_geometry("wheelset", find_geometry_case("wheelset", PAIR | {"step_mm": 0.5}))
    lateral = run.equilibrium.position.motion.lateral_mm
    (said,) = [notice for notice in run.summary["notices"] if "both sides are alike" in notice]
    assert f"{-lateral:.2f} mm (stable)" in said
    assert "0.00 mm (not stable)" in said
    assert not any("both sides are alike" in notice for notice in _of_bundled().summary["notices"])


def _of_bundled():
    return run_geometry("wheelset", find_geometry_case("wheelset", {"step_mm": 0.5}))
