"""Fast theories of rolling: creep coefficients, linear theory, Polach's formula, FASTSIM and FaStrip."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.elliptic_contact import EllipticContact, creep_coefficients
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.fast_theories import fastrip, fastsim, fastsim_forces, linear_theory, polach
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, STICKS, Creepages, CreepForces, RollingContact
from flangeway.errors import InputError
from flangeway.materials import Elastic

STEEL = Elastic(2.56 * 82000.0, 0.28)
FORCE, MU = 82000.0, 0.3
THEORIES = (linear_theory, polach, fastsim, fastrip)


def ellipse(along: float, across: float, n: int = 24, friction: Friction | None = None) -> RollingContact:
    """Hertz's pressure on n x n cells about an ellipse."""
    grid = PatchGrid(1.1 * across * np.linspace(-1.0, 1.0, n + 1), 2.2 * along / n, n)
    s = (grid.bounds[1:] + grid.bounds[:-1]) / 2.0 / across
    pressures = np.sqrt(np.maximum(1.0 - s[:, None] ** 2 - (grid.along / along) ** 2, 0.0))
    pressures *= FORCE / float((pressures * grid.widths[:, None] * grid.strip).sum())
    return RollingContact.between_half_spaces(grid, pressures, friction or Friction(MU), (STEEL, STEEL))


def values(found: CreepForces) -> np.ndarray:
    return np.array([found.along, found.across, found.moment]) / (MU * FORCE)


@pytest.mark.parametrize(
    ("ratio", "published"),
    [
        (0.1, (3.31, 2.52, 0.473, 8.28)),
        (0.5, (3.62, 3.01, 0.929, 1.93)),
        (1.0, (4.12, 3.67, 1.47, 1.19)),
        (2.0, (5.10, 4.90, 2.62, 0.819)),
        (10.0, (11.7, 12.8, 14.6, 0.526)),
    ],
)
def test_creep_coefficients_are_those_of_kalker(ratio, published) -> None:
    """Kalker (1990), table E.3, nu = 0.25: within 1 %."""
    found = creep_coefficients(ratio, 0.25)
    np.testing.assert_allclose((found.c11, found.c22, found.c23, found.c33), published, rtol=0.01)


def test_creep_coefficients_of_incompressible_and_other_bodies() -> None:
    """At nu = 0 both directions are equal; between and beyond the table coefficients are smooth and rise with a/b."""
    assert creep_coefficients(0.7, 0.0).c11 == pytest.approx(creep_coefficients(0.7, 0.0).c22, rel=1e-4)
    ratios = np.geomspace(0.01, 100.0, 60)
    curves = np.array(
        [[getattr(creep_coefficients(each, 0.3), name) for name in ("c11", "c22", "c23")] for each in ratios]
    )
    assert (np.diff(curves, axis=0) > 0.0).all()
    # Kalker's limit of slender ellipses across: pi^2 / (4 (1 - nu)) and pi^2 / 4
    np.testing.assert_allclose(curves[0, :2], (np.pi**2 / 2.8, np.pi**2 / 4.0), rtol=0.02)


@pytest.mark.parametrize("shape", [(8.0, 4.0), (4.0, 4.0), (3.0, 8.0)])
def test_at_small_creepages_all_theories_agree(shape) -> None:
    """Forces of linear theory, and of the exact one to 2 %."""
    contact = ellipse(*shape)
    motion = Creepages(2e-6, 1e-6, 1e-7)
    wanted = values(linear_theory(contact, motion))
    np.testing.assert_allclose(values(roll(contact, motion)), wanted, atol=0.02 * np.abs(wanted).max())
    for theory in (fastsim, fastrip):
        np.testing.assert_allclose(values(theory(contact, motion))[:2], wanted[:2], atol=0.04 * np.abs(wanted).max())
    pure = values(polach(contact, Creepages(2e-6)))
    np.testing.assert_allclose(pure, values(linear_theory(contact, Creepages(2e-6))), atol=1e-3 * abs(pure[0]))
    spun = values(polach(contact, Creepages(spin=1e-7)))
    np.testing.assert_allclose(spun[1], values(linear_theory(contact, Creepages(spin=1e-7)))[1], rtol=1e-3)


@pytest.mark.parametrize("motion", [Creepages(1e-3), Creepages(0.0, 2e-3), Creepages(1e-3, 1e-3), Creepages(-4e-3)])
def test_without_spin_fast_theories_are_near_the_exact_one(motion) -> None:
    """Within 6 % of the limit of friction."""
    for shape in ((8.0, 4.0), (3.0, 8.0)):
        contact = ellipse(*shape)
        exact = values(roll(contact, motion))
        for theory in (polach, fastsim, fastrip):
            found = values(theory(contact, motion))
            assert np.hypot(*(found - exact)[:2]) < 0.06, theory


@pytest.mark.parametrize(
    "motion", [Creepages(0.0, -6.25e-4, -6.25e-4), Creepages(1e-3, 1e-3, 3e-4), Creepages(spin=2e-3)]
)
def test_with_spin_strip_theories_are_near_the_exact_one(motion) -> None:
    """Within 11 % of the limit of friction; the moment within 30 %."""
    contact = ellipse(8.0, 4.0)
    exact = values(roll(contact, motion))
    for theory in (fastsim, fastrip):
        found = values(theory(contact, motion))
        assert np.hypot(*(found - exact)[:2]) < 0.11
        assert found[2] == pytest.approx(exact[2], rel=0.3)


@pytest.mark.parametrize("theory", [fastsim, fastrip])
def test_strip_theories_give_fields(theory) -> None:
    """Tractions on the cells have the forces, lie within the limit, and oppose slip; states say where there is slip."""
    contact, motion = ellipse(8.0, 4.0, 40), Creepages(2e-3, -1e-3, -3e-4, speed=1e3)
    found = theory(contact, motion)
    sums = (found.tractions * contact.areas[:, :, None]).sum(axis=(0, 1))
    np.testing.assert_allclose(sums, (found.across, found.along), rtol=0.01)
    size = np.linalg.norm(found.tractions, axis=2)
    assert (size <= 1.34 * MU * contact.pressures.max()).all()
    assert set(np.unique(found.states)) == {NO_CONTACT, STICKS, SLIPS}
    assert not found.tractions[found.states == NO_CONTACT].any()
    assert np.abs(found.slip_velocities[found.states == SLIPS]).max() > 0.0
    assert found.power_density.min() >= -0.05 * found.power_density.max()
    assert (found.power_density * contact.areas).sum() == pytest.approx(found.frictional_power, rel=0.15)


@pytest.mark.parametrize("theory", THEORIES)
def test_fast_theories_have_the_symmetries_of_the_exact_one(theory) -> None:
    """Rolling to -z and mirrored motions turn the forces over; nothing follows from no creepage."""
    contact = ellipse(8.0, 4.0)
    found = values(theory(contact, Creepages(1e-3, 5e-4, 2e-4)))
    back = values(theory(contact, Creepages(-1e-3, 5e-4, -2e-4, -1.0)))
    np.testing.assert_allclose(back, found * [-1.0, 1.0, -1.0], atol=1e-12)
    mirrored = values(theory(contact, Creepages(1e-3, -5e-4, -2e-4)))
    np.testing.assert_allclose(mirrored, found * [1.0, -1.0, -1.0], atol=1e-9)
    np.testing.assert_array_equal(values(theory(contact, Creepages())), 0.0)


@pytest.mark.parametrize("theory", [polach, fastsim, fastrip])
def test_large_creepages_give_the_limit(theory) -> None:
    """The force is the limit of friction against the creepage; without friction it is 0."""
    contact = ellipse(6.0, 5.0)
    found = values(theory(contact, Creepages(0.5)))
    np.testing.assert_allclose(found[:2], (-1.0, 0.0), atol=0.02)
    assert "percent" in theory(contact, Creepages(0.5)).notices[0]
    smooth = theory(ellipse(6.0, 5.0, friction=Friction(0.0)), Creepages(0.5, 0.1, 1e-3))
    np.testing.assert_array_equal(values(smooth), 0.0)


def test_limits_of_linear_theory() -> None:
    """Linear theory beyond the limit says so; a shift is refused."""
    contact = ellipse(6.0, 5.0)
    assert "times the limit" in linear_theory(contact, Creepages(0.05)).notices[0]
    with pytest.raises(InputError, match="speed of 0"):
        linear_theory(contact, Creepages(1e-3, speed=0.0))


def test_the_origin_moves_moments_but_not_the_motion() -> None:
    """Creepages and moments about another origin describe the same motion and the same power."""
    plain = ellipse(6.0, 5.0)
    moved = RollingContact(
        plain.grid, plain.pressures, plain.friction, plain.materials, plain.coefficients, origin=(1.5, -2.0)
    )
    motion = Creepages(1e-3, 5e-4, 2e-4)
    other = Creepages(1e-3 + 2e-4 * 1.5, 5e-4 + 2e-4 * 2.0, 2e-4)
    for theory in (roll, *THEORIES):
        first, second = theory(plain, motion), theory(moved, other)
        np.testing.assert_allclose(values(first)[:2], values(second)[:2], rtol=1e-3)
        assert second.t_gamma == pytest.approx(first.t_gamma, rel=1e-3)


def test_many_creepages_at_once_have_the_forces_of_each() -> None:
    """`fastsim_forces` is `fastsim` with Hertz's limit, also about another origin than the centre of pressure."""
    contact = replace(ellipse(6.0, 3.5), origin=(0.4, -0.7))
    creepages = np.random.default_rng(2).normal(size=(12, 3)) * [2e-3, 2e-3, 5e-4]
    each = [fastsim(contact, Creepages(*motion), parabolic=False) for motion in creepages.tolist()]
    found = fastsim_forces(contact, creepages) / (MU * FORCE)
    np.testing.assert_allclose(found, [values(one) for one in each], atol=1e-12)


def test_longitudinal_creepage_of_a_cone_on_a_round_rail_is_that_of_its_radius() -> None:
    """Rows whose spin turns with the rail's normal, slip by the mean radius: b^2 / (5 r R) was added to it."""
    contact, radius, rail, cone = ellipse(6.0, 5.0, 16), 460.0, 254.0, 0.05
    s = contact.places[0]
    # a row at s, with the contact angle cone + s / rail, turns about its normal by the sine over the radius
    spin = np.sin(cone + s / rail) / radius
    slip = 1.0 - (radius - cone * s) / radius + 3e-4
    motion = Creepages(slip - spin * s, 1e-4, spin, 1.0)
    state = linear_theory(contact, motion)
    patch = CreepState(state, contact)
    shares = contact.row_shares
    assert patch.longitudinal_creepage == pytest.approx(
        float(shares @ slip) - float(shares @ s * (shares @ spin)), abs=1e-12
    )
    assert patch.longitudinal_creepage == pytest.approx(3e-4, abs=1e-9)
    biased = float(motion.along @ shares)
    assert patch.longitudinal_creepage - biased == pytest.approx(5.0**2 / (5.0 * radius * rail), rel=0.02)


MOTIONS = [(4e-3, 0.0, 0.0), (-5e-4, 5e-4, -1e-3)]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("theory", [fastsim, fastrip])
def test_t_gamma_is_the_power_of_the_tractions_over_the_speed(theory, motion) -> None:
    """The sum of the power densities of the cells is T-gamma times the speed, if the ellipse leaves the grid too."""
    contact = RollingContact.under_hertz((4.0, 6.0), FORCE, (12, 12), Friction(MU), (STEEL, STEEL))
    assert EllipticContact.of(contact, Creepages()).along > 6.0
    found = theory(contact, Creepages(*motion, 20.0))
    power = float(np.sum(found.power_density * contact.areas))
    assert power == pytest.approx(20.0 * found.t_gamma, rel=1e-9)
    assert found.frictional_power == pytest.approx(20.0 * found.t_gamma, rel=1e-12)


@pytest.mark.parametrize("motion", [(3e-5, 0.0, 0.0), (0.0, 0.0, 1e-5), (4e-4, -2e-4, 1e-4), *MOTIONS])
def test_fastrip_dissipates_forces_times_creepages(motion) -> None:
    """As half-spaces of one material do, also where nearly all sticks; within 12 % of the exact theory."""
    contact, creepages = ellipse(6.0, 4.0, 24), Creepages(*motion, 20.0)
    found = fastrip(contact, creepages)
    assert found.t_gamma == pytest.approx(sum(found.products(creepages)), rel=1e-9)
    assert found.t_gamma == pytest.approx(roll(contact, creepages).t_gamma, rel=0.12)


def test_no_theory_dissipates_less_than_nothing() -> None:
    """On 60 random ellipses and motions T-gamma is not negative, nor Polach's above the exact limit of full slip."""
    random = np.random.default_rng(7)
    for _ in range(60):
        along, across = np.exp(random.uniform(np.log(2.0), np.log(12.0), 2))
        contact = ellipse(along, across, 16)
        unit = MU * FORCE / (FORCE * along * across)
        xi, eta, phi = random.normal(size=3) * unit * 10.0 ** random.uniform(-1.0, 0.7, 3)
        motion = Creepages(xi, eta, phi / np.sqrt(along * across))
        for theory in (polach, linear_theory, fastsim, fastrip):
            assert theory(contact, motion).t_gamma >= 0.0
        assert polach(contact, motion).t_gamma <= MU * FORCE * np.hypot(xi, eta) * (1.0 + 1e-9)
