"""Creep forces of one patch at all creepages: exact at the nodes and at both ends of slip, checked between."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import Creepages
from flangeway.tables import creep_sampling
from flangeway.tables.creep_sampling import (
    AXES,
    SampledPatch,
    check,
    exact_forces,
    random_points,
    refined,
    sample,
)
from flangeway.tables.creep_table import SATURATED, ForceAxes, reduced
from tests.contact.test_rolling import ellipse

DIRECTIONS, LEVELS = 6, creep_sampling.DIRECTIONS
TOLERANCE = 0.05


@pytest.fixture(scope="module")
def patch():
    return SampledPatch(ellipse(8, 0.6))


@pytest.fixture(scope="module")
def sampled(patch):
    return sample(patch, DIRECTIONS)


def at(sampled, *point):
    """Forces over the limit of friction at one reduced creepage."""
    return ForceAxes.of(sampled.forces, AXES).at((), tuple(np.atleast_1d(np.asarray(point, float)[:, None])))[0]


def test_the_table_has_the_exact_forces_at_its_nodes(patch, sampled):
    """At the creepages of exact solutions the table has their forces, also at the opposite creepages."""
    slips, spins, creeps = AXES
    step = (len(spins) - 1) // DIRECTIONS
    for place, row, column in ((1, 2, 0), (4, 3, 2), (8, 4, 5), (6, 1, 3)):
        point = slips[place], spins[step * row], creeps[step * column]
        exact = patch.over_limit(roll(patch.contact, patch.motion(*map(float, point))))
        np.testing.assert_allclose(at(sampled, *point), exact, atol=1e-3)
        np.testing.assert_allclose(at(sampled, point[0], -point[1], point[2] - np.pi), -exact, atol=1e-3)
    assert patch.n_exact == (len(slips) - 2) * ((DIRECTIONS - 1) * DIRECTIONS + 1)
    assert patch.n_failed == 0


def test_finer_directions_keep_the_solutions_of_coarser_ones(patch, monkeypatch):
    """Two intervals have 3 directions, four have 13, of which those 3 are not solved again."""
    solved, fresh = [], SampledPatch(patch.bodies)
    none = SimpleNamespace(along=0.0, across=0.0, moment=0.0, status=SimpleNamespace(converged=True))
    monkeypatch.setattr(SampledPatch, "exact", lambda _, *point: solved.append(point[1:3]) or none)
    for directions, n_rays in ((2, 3), (4, 13), (2, 13)):
        sample(fresh, directions)
        assert (len(set(solved)), fresh.n_exact) == (n_rays, len(solved))
    assert len(solved) == 13 * (len(AXES[0]) - 2)


def test_small_creepages_have_the_derivatives_of_a_patch_that_sticks(patch, sampled):
    """Slopes at the origin are exact in any direction."""
    for spin, creep in ((0.0, 0.0), (0.0, np.pi / 2), (-np.pi / 2, 0.0), (0.3, 1.0)):
        slip = 1e-7
        size = SATURATED * slip / (1.0 - slip)
        expected = patch.slopes @ (size * patch.direction(spin, creep)) / patch.limit / [1.0, 1.0, patch.radius]
        np.testing.assert_allclose(at(sampled, slip, spin, creep) / slip, expected / slip, atol=1e-5 * SATURATED)


def cartesian(sampled, creepage):
    """Forces over the limit of friction at a reduced creepage (3,) that is not over the limit's."""
    size = np.linalg.norm(creepage)
    angles = np.arctan2(creepage[2], np.hypot(*creepage[:2])), np.arctan2(creepage[1], creepage[0])
    return at(sampled, size / (size + SATURATED), *angles)


@pytest.mark.parametrize("spin", [0.0, -1.5])
def test_the_derivative_is_the_same_from_all_sides(sampled, spin):
    """Without creepage and in pure spin: forward differences along three axes give those of any direction."""
    step, centre = 1e-6 * max(1.0, abs(spin)), np.array([0.0, 0.0, spin])
    base = cartesian(sampled, centre)

    def change(along):
        return (cartesian(sampled, centre + step * along) - base) / step

    axes = np.array([change(along) for along in np.eye(3)])
    scale = np.abs(axes).max()
    for along in np.random.default_rng(2).normal(size=(20, 3)):
        np.testing.assert_allclose(change(along), along @ axes, atol=3e-5 * scale * np.linalg.norm(along))


def test_the_bound_holds_at_fresh_random_creepages(patch, sampled):
    """At 50 creepages that the table does not know the force is within 5 % of the limit, 1.5 % on average."""
    points = random_points(50, np.random.default_rng(7))
    found = check(sampled, points, exact_forces(patch, points))
    assert found.force.max() < TOLERANCE
    assert np.sqrt((found.force**2).mean()) < 0.015
    assert found.moment.max() < 1.5 * TOLERANCE


def test_a_similar_patch_saves_exact_solutions(patch, sampled, monkeypatch):
    """Forces beyond FASTSIM's of an ellipse serve a slightly different one; without any it gets its own solutions."""
    monkeypatch.setattr(creep_sampling, "AXES", AXES)
    monkeypatch.setattr(creep_sampling, "DIRECTIONS", LEVELS)
    points, wider = random_points(12, np.random.default_rng(3)), SampledPatch(ellipse(8, 0.63))
    found, errors, directions = refined(wider, points, 0.1, sampled.beyond)
    assert (directions, wider.n_exact) == (0, 0)
    assert errors.size < 0.1 / 6.0
    np.testing.assert_allclose(found.beyond, sampled.beyond)
    found, errors, directions = refined(wider, points, 0.1, np.zeros(sampled.beyond.shape))
    assert directions > 0
    assert wider.n_exact > 0
    assert errors.size < 0.1 / 6.0


@given(st.floats(0.0, 1.0), st.floats(-np.pi / 2, np.pi / 2), st.floats(-np.pi, np.pi))
@settings(settings.get_profile("costly"))
def test_forces_stay_within_the_cone_and_are_odd(sampled, slip, spin, creep):
    """No force exceeds the limit of friction; opposite creepages have opposite forces."""
    found = at(sampled, slip, spin, creep)
    assert np.hypot(*found[:2]) <= 1.0 + 1e-12
    opposite = at(sampled, slip, -spin, creep - np.pi if creep >= 0.0 else creep + np.pi)
    np.testing.assert_allclose(opposite, -found, atol=1e-6)


def test_forces_over_friction_depend_on_creepages_over_friction(patch):
    """Half of the friction and half of the creepages give half of the forces: friction needs no axis."""
    half = ellipse(8, 0.6, Friction(0.5 * float(patch.contact.friction.limits[0][0])))
    motion = patch.motion(0.5, 0.4, 1.0)
    whole = patch.over_limit(roll(patch.contact, motion))
    found = roll(half, Creepages(*(0.5 * np.array([motion.along, motion.across, motion.spin])).tolist()))
    np.testing.assert_allclose(SampledPatch(half).over_limit(found), whole, atol=1e-5)


def test_reduced_creepages_are_those_of_the_patch(patch):
    """`reduced` is the inverse of `SampledPatch.motion`; without a limit all slides."""
    motion = patch.motion(0.7, -0.6, -2.0)
    creepages = np.array([motion.along, motion.across, motion.spin])
    found = reduced(creepages, patch.stiffness, np.float64(patch.radius), np.float64(patch.limit))
    np.testing.assert_allclose(found, (0.7, -0.6, -2.0))
    assert reduced(creepages, patch.stiffness, np.float64(patch.radius), np.float64(0.0))[0] == 1.0


@pytest.mark.parametrize("axis", range(3))
def test_derivatives_are_continuous(sampled, axis):
    """On both sides of the table's points, and where the angles close, differences by each creepage agree."""
    step, points = 1e-6, np.array([0.4, 0.3, 1.1])
    places = [*AXES[axis][2:-2:3], *([np.pi - 1e-12, 0.0] if axis == 2 else [])]
    for place in places:
        values = []
        for shift in (-2.0, -1.0, 1.0, 2.0):
            points[axis] = place + shift * step
            if axis == 2 and points[2] > np.pi:
                points[2] -= 2.0 * np.pi
            values.append(at(sampled, *points))
        low, high = (values[1] - values[0]) / step, (values[3] - values[2]) / step
        np.testing.assert_allclose(low, high, atol=1e-3)
