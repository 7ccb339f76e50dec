"""The comparison of a mesh with the mesh halved."""

from dataclasses import replace

import pytest

from flangeway.cases import Convergence, WheelsetTangentCase, run_halved
from flangeway.errors import InputError


@pytest.fixture(scope="module")
def halved():
    return run_halved(WheelsetTangentCase.from_values({"size_scale": 4.0}))


def test_halving_a_coarse_mesh_changes_little(halved):
    """Approach changes by less than 2 % and positions by less than 0.2 mm when the mesh is halved."""
    scales = [run.case.size_scale for run in halved.runs]
    assert scales == [4.0, 2.0]
    assert halved.within
    assert 0.0 < halved.changes()["approach_change"] < 0.02
    assert 0.0 < halved.changes()["position_change_mm"] < 0.2
    cells = [sum(body.mesh.n_cells for body in run.result.model.bodies) for run in halved.runs]
    assert cells[1] > 2 * cells[0]


@pytest.mark.parametrize("spoil", ["approach", "position", "status", "contacts"])
def test_too_large_a_change_is_not_within(halved, spoil):
    """An approach off by 3 %, a place off by 0.3 mm, a run that did not converge or has no contact fails the check."""
    coarse, fine = halved.runs
    result = fine.result
    if spoil == "approach":
        position = result.equilibrium.position
        lower = replace(position, vertical_mm=position.vertical_mm - 0.03 * result.approach_mm)
        result = replace(result, equilibrium=replace(result.equilibrium, position=lower))
    elif spoil == "position":
        left, right = result.patches
        result = replace(result, patches=(left, replace(right, wheel_point_mm=right.wheel_point_mm + 0.3)))
    elif spoil == "status":
        result = replace(result, status=replace(result.status, converged=False))
    else:
        result = replace(result, patches=())
    spoiled = Convergence((coarse, replace(fine, result=result)))
    assert not spoiled.within
    assert spoiled.to_json()["within"] is False


def test_a_scale_that_cannot_be_halved_is_refused():
    """A size scale whose half is out of range is refused before anything is computed."""
    with pytest.raises(InputError, match=r"size_scale = 0\.03"):
        run_halved(WheelsetTangentCase.from_values({"size_scale": 0.06}))
