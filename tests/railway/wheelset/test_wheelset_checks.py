"""Every result is checked on its way out: what is wrong is not called converged, what is rough is said."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases.case_file import load_case
from flangeway.contact.solution_checks import BodyOverlap, body_overlaps
from flangeway.railway.wheelset.plane_wheelset import solve_wheelset
from flangeway.railway.wheelset.wheelset_checks import checked
from flangeway.solve import CondensedBodies

COARSE = {"size_scale": 3.0}


def solved(**values):
    return solve_wheelset(load_case("wheelset-tangent", **COARSE | values))


@pytest.fixture(scope="module")
def coarse():
    return solved()


def judge(result, *, state=None, patches=None, overlaps=(), displacements=None, **changed):
    """Judge a result of which something was changed."""
    if state is not None:
        changed["state"] = replace(result.equilibrium.state, **state)
    return checked(
        result.model,
        replace(result.equilibrium, **changed),
        result.patches if patches is None else patches,
        overlaps,
        result.displacements if displacements is None else displacements,
    )


def test_a_good_result_stays_converged(coarse):
    """A default load on a mesh that is fine enough has one warning: that the steel would yield below the contacts."""
    status, warnings = judge(coarse)
    assert status == coarse.status
    assert status.converged
    assert coarse.warnings == warnings
    assert len(warnings) == 1
    assert "510 MPa" in warnings[0]
    assert "2.0 times in the rail" in warnings[0]


def test_no_overlap_is_unexplained(coarse):
    """The penalty and the chords of curves explain all overlap of the bodies of a good result."""
    response = CondensedBodies(coarse.model.system.surface_nodes)
    found = body_overlaps(coarse.model.system, response, coarse.equilibrium.state)
    assert found
    assert all(each.is_explained for each in found)


def test_forces_that_do_not_balance_are_an_error(coarse):
    """Contact forces that miss the load by a millionth are not converged, whatever the iteration said."""
    first = coarse.patches[0]
    for share, converged in ((1e-5, False), (1e-9, True)):
        wrong = replace(first, forces=first.forces * (1.0 + share))
        status, _ = judge(coarse, patches=(wrong, *coarse.patches[1:]))
        assert status.converged == converged
    status, _ = judge(coarse, patches=coarse.patches[1:])
    assert "vertical contact forces and load differ by 1.5e+05 N" in status.message


def test_what_is_not_a_number_is_an_error(coarse):
    """A force, a displacement or a resultant that is not finite is not converged."""
    forces = coarse.equilibrium.state.forces.copy()
    forces[0] = np.inf
    assert "not finite" in judge(coarse, state={"forces": forces})[0].message
    field = next(iter(coarse.displacements.values())).copy()
    field[3, 0] = np.nan
    name = next(iter(coarse.displacements))
    assert "not finite" in judge(coarse, displacements=coarse.displacements | {name: field})[0].message
    lost = replace(coarse.patches[0], forces=np.nan * coarse.patches[0].forces)
    assert not judge(coarse, patches=(lost, coarse.patches[1]))[0].converged


def test_contact_that_pulls_is_an_error(coarse):
    """One node in tension, small against the others, is not converged; rounding is no tension."""
    forces = coarse.equilibrium.state.forces.copy()
    open_node = int(np.flatnonzero(forces == 0.0)[0])
    forces[open_node] = -1e-3 * forces.max()
    assert "pulls with" in judge(coarse, state={"forces": forces})[0].message
    forces[open_node] = -1e-12 * forces.max()
    assert judge(coarse, state={"forces": forces})[0].converged


def test_contact_at_the_edge_or_outside_of_the_zone_is_an_error(coarse):
    """Contact at the end of the candidate zone and overlap outside of it are not converged, and both are reported."""
    left = coarse.patches[0]
    cut = replace(left, at_edge=True)
    overlap = BodyOverlap(("wheel-right", "rail-right"), 0.5, (800.0, -1.0), 0.01)
    status, _ = judge(coarse, patches=(cut, coarse.patches[1]), overlaps=(overlap, replace(overlap, depth=0.009)))
    assert not status.converged
    assert "the left contact reaches the edge of the candidate zone" in status.message
    assert status.message.count("wheel-right and rail-right overlap by 0.5 mm at (800, -1)") == 1
    assert "0.009" not in status.message


def test_penetration_is_held_against_the_sinking():
    """A soft penalty is warned of, and one softer than the bodies is not converged."""
    soft = solved(penalty_factor=0.8)
    assert soft.status.converged
    assert any("raise penalty_factor" in warning for warning in soft.warnings)
    softest = solved(penalty_factor=0.02)
    assert not softest.status.converged
    assert "raise penalty_factor" in softest.status.message


def test_a_contact_of_few_segments_is_warned_of():
    """A load whose contact is narrower than 8 segments, here one, is warned of; no yield where stresses are low."""
    light = solved(axle_load_kN=0.01, size_scale=4.0)
    assert light.status.converged
    assert any("wide, fewer than 8; lower size_scale" in warning for warning in light.warnings)
    assert not any("yield" in warning for warning in light.warnings)


def test_a_rough_pressure_is_told_with_its_scatter(coarse):
    """A pressure that jumps from node to node is warned of, with the oscillation in percent."""
    left = coarse.patches[0]
    factors = 1.0 + 0.2 * (-1.0) ** np.arange(len(left.pressures))
    rough = replace(left, pressures=left.pressures * factors)
    _, warnings = judge(coarse, patches=(rough, coarse.patches[1]))
    percent = f"{100.0 * rough.oscillation:.0f} %"
    assert any(f"the left contact oscillates by {percent}" in warning for warning in warnings)


def test_a_balance_that_cannot_last_is_warned_of(coarse):
    """An unstable equilibrium is reported; so is a failure kept as it is, without further words about yield."""
    assert any("unstable" in warning for warning in judge(coarse, stable=False)[1])
    failed = replace(coarse.status, converged=False, message="no equilibrium")
    status, warnings = judge(coarse, status=failed)
    assert status == failed
    assert warnings == ()


def test_stresses_are_over_the_given_strength(coarse):
    """Nothing is reported where it is above all stresses, nor of other materials than steel without one."""
    assert not any("yield" in warning for warning in solved(young_MPa=70e3, size_scale=6.0).warnings)
    for strength, factor in ((920.0, "1.1 times in the rail"), (2000.0, None)):
        model = replace(coarse.model, problem=coarse.model.problem.replaced(material={"yield_MPa": strength}))
        _, warnings = judge(replace(coarse, model=model))
        assert (factor is None and warnings == ()) or factor in warnings[0]


@pytest.mark.parametrize(("share", "reported"), [(0.04, False), (0.06, True)])
def test_a_rail_that_deflects_too_far_is_reported(coarse, share, reported):
    """A rail moved by more than 5 % of its height is still converged, with a warning that names side and way."""
    field = coarse.displacements["rail-right"]
    height = float(np.ptp(coarse.model.rail.mesh.points[:, 1]))
    far = coarse.displacements | {"rail-right": field * share * height / np.linalg.norm(field, axis=1).max()}
    status, warnings = judge(coarse, displacements=far)
    assert status.converged
    assert any(f"the right rail deflects by {share * height:.1f} mm" in warning for warning in warnings) == reported
    assert not any("the left rail deflects" in warning for warning in warnings)
