"""A wheelset in three dimensions: equilibrium, symmetry, fine grids and contact outside of them."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.sweep import energy_sweep, moved_to, noise, pressures_and_areas
from flangeway.cases.case_file import load_case
from flangeway.cases.wheelset.wheelset_case import SpatialWheelsetRun
from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset import fine_cells, spatial_wheelset
from flangeway.railway.wheelset.equilibrium import load_on_axle
from flangeway.railway.wheelset.fine_cells import divided, finer
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, WheelPose
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import spatial_patch
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, build_model
from tests.railway.wheelset.conftest import coarse_case


def solved(wheelset, **inputs):
    return solve_position(wheelset.at(coarse_case(**inputs)), {})


def test_contact_forces_are_in_equilibrium_with_the_load_and_a_curve_is_mirrored(wheelset):
    """Forces and moment of the load to 1e-8; a curve to the other side exchanges left and right."""
    curve = {"speed_km_h": 80, "superelevation_mm": 60}
    left, right = (solved(wheelset, curve=curve | {"radius_m": radius}) for radius in (500, -500))
    assert left.status.converged
    assert left.equilibrium.stable
    total = np.zeros(3)
    for patch in left.patches:
        force, place = (
            patch.force_on_wheel_N[:2],
            patch.centre_mm[:2] - left.equilibrium.position.axle(left.problem.wheels),
        )
        total += (*force, place[0] * force[1] - place[1] * force[0])
    load = load_on_axle(left.problem, left.equilibrium.position.roll_rad)
    assert total[:2] == pytest.approx(-load[:2], abs=1e-8 * 200e3)
    # the centre of pressure is a mean of points on a curved rail: the moment to less
    assert total[2] == pytest.approx(-load[2], abs=1e-4 * 200e3 * 750.0)
    one, other = left.equilibrium.position.components, right.equilibrium.position.components
    assert one == pytest.approx((-other[0], other[1], -other[2]), abs=1e-7)
    pressures = {(p.side, round(p.max_pressure, 3)) for p in left.patches}
    opposite = {"left": "right", "right": "left"}
    assert pressures == {(opposite[p.side], round(p.max_pressure, 3)) for p in right.patches}


def test_more_cells_across_a_patch_change_it_by_their_error(wheelset):
    """Patches have as many cells as the input says; twice as many move the maximum pressure by less than 1 %."""
    found = {}
    for cells in (13, 26):
        found[cells] = solved(wheelset, lateral_mm=1.0, patch_cells=cells)
    for few, many in zip(found[13].patches, found[26].patches, strict=True):
        counts = [patch.n_cells for patch in (few, many)]
        assert min(counts[0]) >= 10
        assert max(counts[0]) < 20 <= max(counts[1])
        assert few.max_pressure == pytest.approx(many.max_pressure, rel=0.01)


@pytest.mark.ci
def test_pressure_and_area_change_smoothly_as_the_wheelset_moves(wheelset):
    """In steps of 0.05 mm across a jump of the rail's curvature their noise is below 0.3 %."""
    found = noise(pressures_and_areas([moved_to(wheelset, lateral) for lateral in np.arange(1.1, 1.58, 0.05).tolist()]))
    assert found.max() < 3e-3


@pytest.mark.ci
def test_the_lateral_force_does_the_work_that_the_energy_changes_by(wheelset):
    """As the flange climbs to more than 40 kN, by Gauss's rule over steps of 0.5 mm: to 0.1 %, on a rigid axle."""
    rigid = wheelset.at(coarse_case(axle="rigid"))
    sweep = energy_sweep(rigid, step=0.5, lateral=7.5, farthest=8.5)
    assert not sweep.failures
    assert sweep.error < 1e-3
    assert moved_to(rigid, 8.5).equilibrium.residual[0] < -40e3


@pytest.mark.ci
def test_a_wheelset_is_held_at_a_lateral_position_where_rails_deflect_and_not_where_a_wheel_lifts(wheelset):
    """Between 16 and 22 mm the force that holds it grows evenly; 35 mm ends where it has derailed, in a few steps."""
    held = [-solved(wheelset, lateral_mm=lateral).equilibrium.residual[0] for lateral in (16.0, 18.0, 20.0, 22.0)]
    np.testing.assert_allclose(np.diff(held), 39.1e3, rtol=0.02)
    steps, beside = [], wheelset.at(coarse_case(lateral_mm=35.0))
    lost = solve_position(beside, {}, steps.append).status
    assert not lost.converged
    assert re.match(r"lateral_mm = 35: derailed, at \d\d\.\d mm", lost.message)
    assert len(steps) < 60


def test_a_patch_outside_of_the_fine_cells_is_found(wheelset, monkeypatch):
    """The smaller of two patches is left out of the first fine grid: the end of the search finds and adds it."""
    whole = solved(wheelset, lateral_mm=6.8)
    assert sum(patch.side == "right" for patch in whole.patches) == 2
    usual, calls = spatial_wheelset.finer, []

    def without_the_smaller(state, *more):
        calls.append(state)
        if len(calls) <= 2:
            windows = fine_cells._windows(state, None)
            largest = max(windows, key=lambda each: each.share)
            stations = state.grid.grid.stations[:, None]
            inside = (stations > largest.ends[0]) & (stations < largest.ends[1])
            return usual(replace(state, forces=np.where(inside, state.forces, 0.0)), *more)
        return usual(state, *more)

    monkeypatch.setattr(spatial_wheelset, "finer", without_the_smaller)
    again = solved(wheelset, lateral_mm=6.8)
    assert again.status.converged
    # `finer` asked anew: both sides of the first grid, of the one found too large or fine, and after the check
    assert len(calls) > 4
    for one, other in zip(whole.patches, again.patches, strict=True):
        assert one.max_pressure == pytest.approx(other.max_pressure, rel=0.02)
        assert one.force_on_wheel_N == pytest.approx(other.force_on_wheel_N, rel=5e-3, abs=50.0)


def test_a_position_is_no_equilibrium_while_wheel_and_rail_overlap_outside_of_its_cells(wheelset, monkeypatch):
    """However often cells are added: the last ones are checked too."""
    one = wheelset.at(coarse_case(lateral_mm=2.0))
    monkeypatch.setattr(SpatialWheelset, "beyond", lambda _, found, touching: {"right": touching["right"]})
    never = one.solve()
    assert not never.status.converged
    assert "patch_cells" in never.status.message


@pytest.mark.ci
def test_on_fixed_rails_and_a_rigid_axle_it_is_the_contact_of_one_wheel():
    """In the middle of straight track each wheel carries half: pressures of `press_patch` within 2 %."""
    problem = coarse_case(support="fixed", axle="rigid", size_scale=1.8)
    found = solve_position(SpatialWheelset(problem, running_surfaces(problem)), {})
    left, right = (next(p for p in found.patches if p.side == side) for side in SIDES)
    assert left.force_on_wheel_N == pytest.approx(right.force_on_wheel_N * (-1.0, 1.0, 1.0), rel=1e-6, abs=0.1)
    assert right.force_on_wheel_N[1] == pytest.approx(100e3, rel=1e-7)
    assert found.equilibrium.position.lateral_mm == pytest.approx(0.0, abs=1e-6)
    pressed = spatial_patch(build_model(problem), "right", 100e3)
    assert right.max_pressure == pytest.approx(pressed.pressures.max(), rel=0.02)


def test_tractions_on_the_wheel_act_below_a_patch_in_both_bodies(wheelset):
    """A traction of 0.3 p ahead on the wheel is its shear stress at the surface, and the opposite one of the rail's."""
    patch = solved(wheelset, lateral_mm=0.0).patches[0]
    pressures = patch.cells.pressures
    tractions = np.stack((np.zeros_like(pressures), 0.3 * pressures), axis=2)
    for role, sign in (("wheel", 1.0), ("rail", -1.0)):
        without, found = patch.lines[role], replace(patch, tractions=tractions).lines[role]
        change = found.stresses.components - without.stresses.components
        # the line begins at a twentieth of the shorter semi-axis, where it is 0.84 of it
        assert change[0, 4] == pytest.approx(sign * 0.3 * patch.max_pressure, rel=0.2)
        # what changes at the place itself is odd along z: normal stresses do not change below the middle
        assert np.abs(change[:, :3]).max() < 0.02 * patch.max_pressure
        assert found.stresses.von_mises.max() > 1.005 * without.stresses.von_mises.max()


FORCE = 150e3  # N


def model_of(method: str, order: int, size: float) -> WheelsetModel:
    values = {"method": method, "order": order, "contact_size_mm": size, "axle_load_kN": 300.0, "body_size_mm": 12.0}
    return build_model(load_case("wheelset-tangent", **values))


def patch_of(method: str, order: int, size: float) -> PatchContact:
    """AAR-1B on 136RE under 150 kN."""
    return spatial_patch(
        model_of(method, order, size), "right", FORCE, cell_mm=0.5, window_mm=(13.0, 20.0), tolerance=5e-3
    )


@pytest.mark.ci
def test_finite_and_virtual_elements_agree() -> None:
    """Maximum pressure, semi-axes and centre of triangles of order 2 and polygons of order 1 agree to 0.3 %."""
    (fem,), (vem,) = (found.patches for found in (patch_of("fem", 2, 0.25), patch_of("vem", 1, 0.5)))
    assert fem.max_pressure == pytest.approx(vem.max_pressure, rel=3e-3)
    np.testing.assert_allclose(fem.semi_axes, vem.semi_axes, rtol=3e-3)
    np.testing.assert_allclose(fem.centre, vem.centre, atol=0.02)


def state_of(bounds, loaded, gaps=1.0):
    """Contact on cells of a flat surface, nine strips of 1 mm: even forces on loaded rows and inner strips."""
    grid = PatchGrid.on_planes(bounds, 1.0, -4, 4)
    forces = np.zeros((len(grid.widths), 9))
    forces[np.ix_(loaded, range(1, 8))] = grid.widths[loaded, None]
    points, normals = np.column_stack((grid.stations, np.zeros(len(forces)))), np.tile((0.0, 1.0), (len(forces), 1))
    surfaces = SimpleNamespace(rail_stations=np.array([[-50.0, -50.0], [50.0, 50.0]]), modulus=1e5)
    side = GriddedSide(surfaces, grid, WheelPose(0.0, 460.0, 0.0))
    gaps = np.where(forces > 0.0, 0.0, gaps)
    creep = np.zeros((len(forces), 2))
    return SideState(side, side.pose, forces, points, normals, SimpleNamespace(gaps=gaps), gaps, creep)


def covered(cells, low, high):
    """Length of an interval that cells cover."""
    return np.maximum(np.minimum(cells[:, 1], high) - np.maximum(cells[:, 0], low), 0.0).sum()


def test_a_narrow_patch_that_lies_in_the_cells_of_another_one_has_none_of_its_own():
    """A patch of 0.1 mm, 1.2 mm beside one of 8 mm whose cells are 1 mm wide: both covered, no cell empty or twice."""
    bounds = np.append(np.arange(11.0), [10.1, 10.2, 10.3, 10.4])
    found = finer(state_of(bounds, [*range(1, 9), 12]), 8).grid.cells
    assert (np.diff(found, axis=1) > 0.0).all()
    assert (np.diff(found.ravel()) > -1e-12).all()
    for low, high in ((1.0, 9.0), (10.2, 10.3)):
        assert np.isclose(covered(found, low, high), high - low)


def test_a_gap_within_reach_has_cells_before_it_closes():
    """What is 0.2 mm apart on coarse cells has cells where 0.3 mm is asked for, and none without."""
    gaps = np.full((40, 1), 1.0)
    gaps[34:37] = 0.2
    state = state_of(np.arange(-20.0, 21.0), range(5, 15), gaps)
    near, far = (finer(state, 26, None, state, (within, 0.0)).grid.cells for within in (0.3, 0.1))
    assert np.isclose(covered(near, 14.0, 17.0), 3.0)
    assert covered(far, 14.0, 17.0) == 0.0


def test_a_flange_that_the_wheelset_can_reach_has_cells():
    """What is 1 mm apart has cells where the wheelset may come 1.5 mm nearer along its normal, and not across it."""
    gaps = np.full((40, 1), 5.0)
    gaps[34:37] = 1.0
    flat = state_of(np.arange(-20.0, 21.0), range(5, 15), gaps)
    steep = replace(flat, normals=np.tile((np.sin(1.2), np.cos(1.2)), (40, 1)))
    on_steep, on_flat = (finer(state, 26, None, state, (0.3, 1.5)).grid.cells for state in (steep, flat))
    assert np.isclose(covered(on_steep, 14.0, 17.0), 3.0)
    assert covered(on_flat, 14.0, 17.0) == 0.0


def test_cells_at_a_narrow_peak_are_divided_once():
    """Pressure of a patch of 30 mm with a parabola of 4 mm on it: cells of 1.25 mm are divided by four there, once."""
    even = np.linspace(-20.0, 20.0, 33)

    def pressed(bounds, peak):
        state = state_of(bounds, np.flatnonzero(np.abs(bounds[1:] + bounds[:-1]) < 30.0))
        s = state.grid.grid.stations
        pressure = 1.0 - (s / 16.0) ** 2 + peak * np.maximum(1.0 - (s / 2.0) ** 2, 0.0)
        return replace(state, forces=state.forces * pressure[:, None])

    smooth, first = pressed(even, 0.0), pressed(even, 4.0)
    assert divided(smooth, 20) is smooth.grid
    found = divided(first, 20).grid
    near = np.abs(found.stations) < 1.2
    assert np.allclose(found.widths[near], 1.25 / 4.0)
    assert np.allclose(found.widths[np.abs(found.stations) > 4.0], 1.25)
    again = pressed(found.bounds, 4.0)
    assert divided(again, 20) is again.grid


@pytest.mark.parametrize("rolling", [{}, {"friction": 0.3, "speed_km_h": 80.0, "theory": "fastsim"}])
def test_a_start_gives_the_same_equilibrium_in_fewer_iterations(rolling):
    """From the run under a similar load the search is shorter, and ends at the same position with the same patches."""
    case = coarse_case(load={"lateral_force_kN": 40.0}, **({"rolling": rolling} if rolling else {}))
    other = case.replaced(load={"lateral_force_kN": 41.0})
    anew, again = other.run(), other.run(start=case.run())
    assert anew.status.converged
    assert again.status.converged
    assert again.status.iterations < anew.status.iterations
    positions = [run.result.equilibrium.position.components for run in (again, anew)]
    assert positions[0] == pytest.approx(positions[1], abs=2e-3)
    pressures = [[patch.max_pressure for patch in run.patches] for run in (again, anew)]
    assert pressures[0] == pytest.approx(pressures[1], rel=0.01)


def test_a_plane_wheelset_takes_no_start():
    """A start from three dimensions would have no effect in a plane, and is refused."""
    plane = load_case("wheelset-tangent")
    with pytest.raises(InputError, match="start"):
        plane.run(start=SpatialWheelsetRun(plane, None, 0.0))
