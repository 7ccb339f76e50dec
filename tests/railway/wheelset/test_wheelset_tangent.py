"""The main job: a wheelset in equilibrium on tangent track (Moherdaui 2021, 7.3.1)."""

import numpy as np
import pytest

from flangeway.materials import Elastic
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset, WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import search_equilibrium
from flangeway.railway.wheelset.plane_contact import PlaneContact
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from flangeway.solve import CondensedBodies, SparseBodies


def problem(load_n: float = 300e3, **settings) -> WheelsetProblem:
    return WheelsetProblem(
        Track(rail()),
        Wheelset(wheel()),
        WheelsetLoad(load_n),
        Elastic(210e3, 0.3),
        discretisation=Discretisation(**settings),
    )


@pytest.fixture(scope="module", params=["fem", "vem"])
def solved(request) -> WheelsetResult:
    return solve_wheelset(problem(method=request.param))


@pytest.fixture(scope="module")
def coarse():
    model = build_model(problem(size_scale=3.0))
    return model, CondensedBodies(model.system.surface_nodes)


def test_the_load_is_balanced(solved: WheelsetResult) -> None:
    """The equilibrium residual is below 1e-10 (Moherdaui (2021): 1e-5 by hand)."""
    assert solved.status.converged, solved.status.message
    assert solved.equilibrium.residuals.equilibrium_residual < 1e-10
    vertical = sum(patch.force_on_wheel_N[1] for patch in solved.patches)
    assert vertical == pytest.approx(300e3, rel=1e-10)


def test_both_sides_are_alike(solved: WheelsetResult) -> None:
    """Left and right forces agree to 0.1 %; lateral motion and roll are below 1e-3 of the approach."""
    left, right = solved.patches
    assert (left.side, right.side) == ("left", "right")
    assert left.force_on_wheel_N[1] == pytest.approx(right.force_on_wheel_N[1], rel=1e-3)
    assert left.force_on_wheel_N[0] == pytest.approx(-right.force_on_wheel_N[0], rel=1e-3)
    motion = solved.equilibrium.position
    assert abs(motion.lateral_mm) < 1e-3 * solved.approach_mm
    assert abs(motion.roll_rad) * 1000.0 < 1e-3 * solved.approach_mm


def test_pressure_and_width_are_hertzian(solved: WheelsetResult) -> None:
    """Maximum pressure and half width are within 10 % of Hertz's for the local radii."""
    for patch in solved.patches:
        assert patch.pressure.pressures.max() == pytest.approx(patch.hertz.max_pressure, rel=0.1)
        assert patch.pressure.half_width == pytest.approx(patch.hertz.half_width, rel=0.1)


def test_the_approach_is_elastic(solved: WheelsetResult) -> None:
    """From first touch the wheelset sinks about 0.7 mm, as an independent computation found (errata)."""
    assert solved.approach_mm == pytest.approx(0.7, abs=0.05)


def test_methods_agree_on_the_position() -> None:
    """Contact positions of fem and vem differ by less than 0.5 mm, approaches by less than 1 %."""
    fem, vem = (solve_wheelset(problem(method=method, size_scale=2.0)) for method in ("fem", "vem"))
    assert fem.approach_mm == pytest.approx(vem.approach_mm, rel=0.01)
    for one, other in zip(fem.patches, vem.patches, strict=True):
        assert np.abs(one.rail_point_mm - other.rail_point_mm).max() < 0.5
        assert np.abs(one.wheel_point_mm - other.wheel_point_mm).max() < 0.5


def test_halving_the_mesh_changes_little() -> None:
    """From scale 2 to 1 the approach changes by less than 2 % and the contact position by less than 0.2 mm."""
    coarse, fine = (solve_wheelset(problem(size_scale=scale)) for scale in (2.0, 1.0))
    assert coarse.approach_mm == pytest.approx(fine.approach_mm, rel=0.02)
    for one, other in zip(coarse.patches, fine.patches, strict=True):
        assert np.abs(one.rail_point_mm - other.rail_point_mm).max() < 0.2


def test_roles_can_be_exchanged() -> None:
    """With the wheel as primary side the equilibrium is the same within 0.2 % and 0.1 mm."""
    rail_first, wheel_first = (solve_wheelset(problem(size_scale=2.0, primary=role)) for role in ("rail", "wheel"))
    assert wheel_first.status.converged
    assert wheel_first.approach_mm == pytest.approx(rail_first.approach_mm, rel=2e-3)
    for one, other in zip(rail_first.patches, wheel_first.patches, strict=True):
        assert one.force_on_wheel_N == pytest.approx(other.force_on_wheel_N, rel=0.02)
        assert np.abs(one.rail_point_mm - other.rail_point_mm).max() < 0.1


def test_the_whole_sparse_system_agrees(coarse) -> None:
    """At the equilibrium, a cold start has the same nodal forces, condensed and with all unknowns, to 1e-9."""
    model, response = coarse
    motion = search_equilibrium(PlaneContact(model, response)).position
    condensed = PlaneContact(model, response).contact_at(motion)
    sparse = PlaneContact(model, SparseBodies(model.system.surface_nodes)).contact_at(motion)
    assert sparse.status.converged
    scale = np.abs(condensed.nodal_forces).max()
    assert np.abs(sparse.nodal_forces - condensed.nodal_forces).max() < 1e-9 * scale


def test_the_forces_hardly_depend_on_the_path(coarse) -> None:
    """A cold start at the equilibrium has the total force of the search to 1e-4, though pairs are kept for a while."""
    model, response = coarse
    found = search_equilibrium(PlaneContact(model, response))
    cold = PlaneContact(model, response).contact_at(found.position)
    assert cold.forces.sum() == pytest.approx(found.state.forces.sum(), rel=1e-4)


@pytest.mark.parametrize("motion", [WheelsetPosition(0.0, -0.6, 0.0), WheelsetPosition(1.5, -0.7, 2e-4)])
def test_jacobian_of_the_equilibrium(coarse, motion: WheelsetPosition) -> None:
    """The exact Jacobian of the equilibrium agrees with central differences to 1e-5."""
    model, response = coarse
    motion = model.rigid_position.moved(motion)
    state = PlaneContact(model, response).contact_at(motion)
    exact = PlaneContact(model, response).jacobian_of(motion, state)
    steps = (1e-6, 1e-6, 1e-9)
    for column, change in enumerate(np.eye(3) * steps):
        ends = []
        for sign in (1.0, -1.0):
            at = motion.moved(WheelsetPosition(*change), sign)
            moved = PlaneContact(model, response).contact_at(at, (motion, state))
            ends.append(PlaneContact(model, response).residuals_of(at, moved)[0])
        difference = (ends[0] - ends[1]) / (2.0 * steps[column])
        assert difference == pytest.approx(exact[:, column], rel=1e-5, abs=1e-5 * np.abs(exact[:, column]).max())


def test_a_heavier_car_sinks_deeper() -> None:
    """Approach and half width grow with the load, half width as its root within one element of the lighter one's."""
    light, heavy = (solve_wheelset(problem(load_n=load, size_scale=2.0)) for load in (75e3, 300e3))
    assert heavy.approach_mm > 2.0 * light.approach_mm
    ratio = heavy.patches[0].pressure.half_width / light.patches[0].pressure.half_width
    assert ratio == pytest.approx(2.0, abs=2.0 * 0.5 / light.patches[0].pressure.half_width)
