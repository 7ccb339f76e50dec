"""The comparison of a mesh with the mesh halved."""

import copy

import pytest

from flangeway.cases import Convergence, WheelsetTangentCase, run_halved
from flangeway.errors import InputError


@pytest.fixture(scope="module")
def halved():
    return run_halved(WheelsetTangentCase.from_values({"size_scale": 4.0}))


def test_halving_a_coarse_mesh_changes_little(halved):
    """Approach changes by less than 2 % and positions by less than 0.2 mm when the mesh is halved."""
    scales = [summary["case"]["size_scale"] for summary in halved.summaries]
    assert scales == [4.0, 2.0]
    assert halved.within
    assert 0.0 < halved.changes()["approach_change"] < 0.02
    assert 0.0 < halved.changes()["position_change_mm"] < 0.2
    cells = [sum(body["cells"] for body in summary["bodies"]) for summary in halved.summaries]
    assert cells[1] > 2 * cells[0]


@pytest.mark.parametrize("spoil", ["approach", "position", "status", "contacts"])
def test_too_large_a_change_is_not_within(halved, spoil):
    """An approach off by 3 %, a place off by 0.3 mm, a run that did not converge or has no contact fails the check."""
    coarse, fine = copy.deepcopy(halved.summaries)
    if spoil == "approach":
        fine["motion"]["approach_mm"] *= 1.03
    elif spoil == "position":
        fine["contacts"][1]["wheel_position_mm"][0] += 0.3
    elif spoil == "status":
        coarse["status"]["converged"] = False
    else:
        fine["contacts"] = []
    spoiled = Convergence((coarse, fine))
    assert not spoiled.within
    assert spoiled.to_json()["within"] is False


def test_a_scale_that_cannot_be_halved_is_refused():
    """A size scale whose half is out of range is refused before anything is computed."""
    with pytest.raises(InputError, match=r"size_scale = 0\.03"):
        run_halved(WheelsetTangentCase.from_values({"size_scale": 0.06}))
