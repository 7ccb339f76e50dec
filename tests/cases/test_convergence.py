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
    scales = [summary.case["size_scale"] for summary in halved.summaries]
    assert scales == [4.0, 2.0]
    assert halved.within
    assert 0.0 < halved.changes()["approach_change"] < 0.02
    assert 0.0 < halved.changes()["position_change_mm"] < 0.2
    cells = [sum(body.elements for body in summary.bodies) for summary in halved.summaries]
    assert cells[1] > 2 * cells[0]


@pytest.mark.parametrize("spoil", ["approach", "position", "status", "contacts"])
def test_too_large_a_change_is_not_within(halved, spoil):
    """An approach off by 3 %, a place off by 0.3 mm, a run that did not converge or has no contact fails the check."""
    coarse, fine = halved.summaries
    if spoil == "approach":
        position = replace(fine.position, approach_mm=1.03 * fine.position.approach_mm)
        fine = replace(fine, position=position)
    elif spoil == "position":
        left, right = fine.contacts
        x, y = right.wheel_position_mm
        fine = replace(fine, contacts=[left, replace(right, wheel_position_mm=[x + 0.3, y])])
    elif spoil == "status":
        coarse = replace(coarse, status=replace(coarse.status, converged=False))
    else:
        fine = replace(fine, contacts=[])
    spoiled = Convergence((coarse, fine))
    assert not spoiled.within
    assert spoiled.to_json()["within"] is False


def test_a_scale_that_cannot_be_halved_is_refused():
    """A size scale whose half is out of range is refused before anything is computed."""
    with pytest.raises(InputError, match=r"size_scale = 0\.03"):
        run_halved(WheelsetTangentCase.from_values({"size_scale": 0.06}))
