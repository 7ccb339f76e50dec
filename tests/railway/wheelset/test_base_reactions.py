"""Reactions of the rails' bases and of the wheels' cuts."""

import numpy as np
import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.wheelset.plane_contact import PlaneContact
from flangeway.railway.wheelset.support_reactions import holding_force, support_reactions
from flangeway.railway.wheelset.wheelset_result import solve_wheelset
from flangeway.solve import CondensedBodies

COARSE = {"size_scale": 3.0}


def solved(case, **values):
    return solve_wheelset(case.from_values(COARSE | values).problem())


@pytest.fixture(scope="module")
def results():
    """A curve with both orders of both methods, and a held wheelset."""
    return {
        "fem": solved(WheelsetCurveCase),
        "vem": solved(WheelsetCurveCase, method="vem", order=2),
        "held": solved(WheelsetTangentCase, lateral_mm=2.0, roll_rad=1e-4),
    }


@pytest.mark.parametrize("name", ["fem", "vem", "held"])
def test_supports_balance_the_contact_forces(results, name):
    """Force and moment of each support and of the contact forces on its part cancel to 1e-9."""
    reactions = support_reactions(results[name])
    assert {each.part for each in reactions} == set(results[name].model.parts)
    for each in reactions:
        assert each.force_error < 1e-9
        assert each.moment_residual < 1e-9
        assert np.abs(each.force_N + each.contact_force_N).max() < 1e-9 * np.linalg.norm(each.contact_force_N)


@pytest.mark.parametrize("name", ["fem", "vem", "held"])
def test_contact_forces_are_those_of_the_patches(results, name):
    """What the bases do to the rails is what the rails' patches do to the wheels, side by side."""
    for each in support_reactions(results[name]):
        on_wheel = results[name].force_on_wheel_N(each.side)
        sign = -1.0 if each.part.startswith("wheel") else 1.0
        assert np.allclose(each.force_N, sign * on_wheel, rtol=1e-9, atol=1e-6)


def test_the_moment_is_that_of_the_force_at_the_contact(results):
    """A base's moment is the contact force times its arm, but for the wheel's and the rail's small displacement."""
    result = results["fem"]
    for each in support_reactions(result):
        mine = [patch for patch in result.patches if patch.side == each.side]
        sign = 1.0 if each.part.startswith("wheel") else -1.0
        arms = [patch.pressure.centre - each.reference_mm for patch in mine]
        forces = [sign * patch.force_on_wheel_N for patch in mine]
        moment = sum(a[0] * f[1] - a[1] * f[0] for a, f in zip(arms, forces, strict=True))
        size = sum(np.linalg.norm(a) * np.linalg.norm(f) for a, f in zip(arms, forces, strict=True))
        assert each.moment_Nmm == pytest.approx(-moment, abs=0.02 * size)


def test_the_bases_bear_the_load(results):
    """The bases together carry the load of the axle, in both axes of the track."""
    result = results["fem"]
    along, onto = result.model.problem.load.in_track
    total = sum(each.force_N for each in support_reactions(result) if each.part.startswith("rail"))
    assert total == pytest.approx([-along, onto], rel=1e-8)


def test_the_outer_rail_is_pushed_outwards(results):
    """In the curve the resultant on the outer base is farther outside than on the inner one."""
    places = {each.side: each.eccentricity_mm for each in support_reactions(results["fem"]) if "rail" in each.part}
    assert places["right"] > places["left"] + 5.0


def test_eccentricity_is_the_moment_over_the_force(results):
    """On an upright base the force across it acts where force times eccentricity is the moment about the middle."""
    for each in support_reactions(solved(WheelsetTangentCase, rail_inclination=0.0)):
        if each.part.startswith("rail"):
            outwards = 1.0 if each.side == "right" else -1.0
            assert each.moment_Nmm == pytest.approx(outwards * each.eccentricity_mm * each.force_N[1], rel=1e-9)


def test_the_holding_force_is_the_residual_of_the_equilibrium(results):
    """What holds a prescribed motion is the negative residual about the axle's middle, and zero where it is free."""
    held = results["held"]
    response = CondensedBodies(held.model.system.surface_nodes)
    residual, relative = PlaneContact(held.model, response).residuals_of(
        held.equilibrium.position, held.equilibrium.state
    )
    found = holding_force(held)
    assert found.lateral_N == pytest.approx(-residual[0], rel=1e-9)
    assert found.moment_Nmm == pytest.approx(-residual[2], rel=1e-9)
    assert abs(found.vertical_N) < 1e-6
    assert abs(found.lateral_N) > 100.0
    assert relative.equilibrium_residual < 1e-10


def test_a_free_wheelset_is_not_held(results):
    """Without a prescribed motion there is no holding force."""
    assert holding_force(results["fem"]) is None
