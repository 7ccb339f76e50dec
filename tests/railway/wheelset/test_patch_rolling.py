"""Patches of a wheelset that roll with friction: coefficients in three axes, forces in the track's axes, power."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases.case_file import load_case
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.fast_theories import polach
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import STRIPS_BEYOND, Creepages, Rolling, RollingContact, box_of
from flangeway.railway.track.placements import SIDE_SIGN
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import rolling_contact_of
from flangeway_studies.wheelset3d_study import as_half_spaces


@pytest.fixture(scope="module")
def bodies(wheelset):
    """A wheelset in the middle of the track on a continuous foundation."""
    return solve_position(wheelset, {})


def test_the_normal_part_is_that_of_normal_contact_and_forces_are_reciprocal(bodies):
    """One code gives one and three axes; coefficients at no distance are symmetric, and positive definite."""
    patch = bodies.patches[0]
    contact = rolling_contact_of(patch, Friction(0.3))
    rows, strips = box_of(patch.inside)
    assert contact.pressures.shape == (rows.stop - rows.start, strips.stop - strips.start)
    normal = patch.state.grid.coefficients[: contact.grid.n_strips, rows, rows]
    found = contact.coefficients[: contact.grid.n_strips, 1::3, 1::3]
    np.testing.assert_allclose(found, normal, rtol=0.0, atol=1e-10 * normal.max())
    assert len(contact.coefficients) == contact.grid.n_strips + 2 * STRIPS_BEYOND
    np.testing.assert_allclose(contact.coefficients[0], contact.coefficients[0].T, atol=1e-6 * normal.max())
    assert np.linalg.eigvalsh(contact.coefficients[0]).min() > 0.0
    # the wheel's own elastic surface is not in the plane of the patch: only the pressures of this patch count
    assert contact.force == pytest.approx(np.linalg.norm(patch.force), rel=1e-3)


def test_half_spaces_on_a_tread_are_flat_half_spaces(wheelset):
    """Creep forces of cells on a curved rail are those of a plane patch to 0.5 % of the limit of friction."""
    half = {side: as_half_spaces(each) for side, each in wheelset.surfaces.items()}
    found = solve_position(SpatialWheelset(wheelset.problem, half), {})
    contact = rolling_contact_of(found.patches[0], Friction(0.3))
    plane = RollingContact.between_half_spaces(contact.grid, contact.pressures, contact.friction, contact.materials)
    motion = Creepages(5e-4, -1e-3, 2e-5)
    one, other = roll(contact, motion), roll(plane, motion)
    limit = 0.3 * contact.force
    assert (one.along, one.across) == pytest.approx((other.along, other.across), abs=5e-3 * limit)
    assert one.moment == pytest.approx(other.moment, rel=0.02)


@pytest.mark.parametrize("theory", [roll, polach])
def test_creep_forces_in_the_axes_of_the_track(bodies, theory):
    """Mirrored wheels: equal forces ahead, opposite ones to the right, spin counter-clockwise on the right one.

    The force on the wheel is opposite to its slip, and the power is the slip times the force, with that of pressures
    which resist rolling.
    """
    found = {}
    for patch in bodies.patches:
        sign = -1.0 if patch.side == "right" else 1.0
        contact = rolling_contact_of(patch, Friction(0.3))
        state = theory(contact, Creepages(2e-3, 1e-3, sign * 0.0))
        found[patch.side] = replace(patch, creep=CreepState(state, contact, sign, 20.0))
    left, right = found["left"], found["right"]
    creep = right.creep
    assert left.creep_force_on_wheel_N == pytest.approx(right.creep_force_on_wheel_N * (-1.0, 1.0, 1.0), rel=1e-4)
    assert right.creep_force_on_wheel_N[2] < 0.0 < creep.longitudinal_creepage
    assert right.creep_force_on_wheel_N[0] > 0.0 > creep.lateral_creepage
    # almost level: the tread is inclined 1:40
    assert right.creep_force_on_wheel_N[:2] == pytest.approx(
        -creep.forces.across * np.array([np.cos(right.contact_angle_rad), np.sin(right.contact_angle_rad)]),
        abs=2e-3 * abs(creep.forces.across),
    )
    assert right.force_on_wheel_N[1] == pytest.approx(100e3, rel=0.02)
    assert creep.used_friction <= 0.3 * (1.0 + 1e-6)
    power = -20.0 * (right.creep_force_on_wheel_N[2] * creep.longitudinal_creepage + creep.forces.across * 1e-3)
    resisting = creep.forces.rolling_power if isinstance(creep.forces, Rolling) else 0.0
    assert creep.power_W == pytest.approx(power + 20.0 * resisting, rel=1e-3)


def test_spin_is_counter_clockwise_from_above(bodies):
    """A moment against the spin on either side."""
    for patch in bodies.patches:
        contact = rolling_contact_of(patch, Friction(0.3))
        found = CreepState(roll(contact, Creepages(spin=1e-4)), contact, -SIDE_SIGN[patch.side])
        assert found.spin_creepage_per_m == pytest.approx(-0.1 if patch.side == "right" else 0.1)
        assert found.spin_moment_Nm * found.spin_creepage_per_m < 0.0


@pytest.mark.ci
def test_different_materials_find_their_pressures_anew():
    """A softer wheel: pressures change with friction, their resultant does not."""
    softer = load_case(
        "wheelset", order=1, size_scale=6.0, gauge_at="narrowest",
        contact={"kind": "plane", "wheel_material": {"young_MPa": 100e3, "poisson": 0.33}},
    )  # fmt: skip
    found = solve_position(SpatialWheelset(softer.replaced(contact="spatial"), running_surfaces(softer)), {})
    contact = rolling_contact_of(found.patches[0], Friction(0.3))
    assert contact.pressed is not None
    state = roll(contact, Creepages(2e-3))
    assert state.status.converged
    assert state.contact.force == pytest.approx(contact.force, rel=1e-3)
    assert np.abs(state.contact.pressures - contact.pressures).max() > 1e-3 * contact.pressures.max()


def test_friction_of_each_row_is_cut_out_with_the_rows(bodies):
    """Coefficients of all rows of the side go with their cells."""
    patch = bodies.patches[0]
    rows, _ = box_of(patch.inside)
    static = np.linspace(0.1, 0.5, len(patch.inside))
    contact = rolling_contact_of(patch, Friction(static))
    np.testing.assert_array_equal(contact.friction.limits[0], static[rows])
