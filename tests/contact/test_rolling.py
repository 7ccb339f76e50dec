"""Rolling and shifting with friction by the exact theory, on ellipses and on random patches."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.contact.patch.patch_contact import press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchGrid
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.fast_theories import fastsim
from flangeway.contact.rolling.friction import Friction, Heating, SlopeReduction
from flangeway.contact.rolling.friction_solver import _solved
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, Creepages, Rolling, RollingContact
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.problems import Elasticity, Harmonic
from tests.contact.test_patch_contact import TURNED, block

SOFT = Elastic(2.5, 0.25)
MU = 0.3


def ellipse(
    n: int, wide: float = 1.0, friction: Friction | None = None, materials: tuple[Elastic, Elastic] = (SOFT, SOFT)
) -> RollingContact:
    """A Hertzian pressure of maximum 1 on n x n cells, semi-axes 1 along z and `wide` across, two more cells around."""
    sides = np.linspace(-1.0, 1.0, n + 1)
    bounds = np.concatenate((sides[:2] - 4.0 / n, sides, sides[-2:] + 4.0 / n))
    grid = PatchGrid(wide * bounds, 2.0 / n, n + 4)
    s = (bounds[1:] + bounds[:-1]) / 2.0
    pressures = np.sqrt(np.maximum(1.0 - s[:, None] ** 2 - grid.along**2, 0.0))
    return RollingContact.between_half_spaces(grid, pressures, friction or Friction(MU), materials)


@given(seed=st.integers(0, 10**6), n_right=st.integers(1, 3))
@settings(settings.get_profile("costly"))
def test_linear_equations_without_an_inverse_nearby_need_many_krylov_vectors(seed, n_right) -> None:
    """More than there is room for at first: the residual is that asked for, also of right-hand sides alike."""
    random = np.random.default_rng(seed)
    matrix = np.diag(np.geomspace(1.0, 1e3, 70)) + random.normal(size=(70, 70))
    right = random.normal(size=(n_right, 70))
    right[-1] = 2.0 * right[0]
    solution = _solved(lambda values: values @ matrix.T, lambda values: values, right, 1e-8)
    assert np.linalg.norm(solution @ matrix.T - right, axis=1).max() < 1.1e-8 * np.linalg.norm(right, axis=1).max()


@pytest.fixture(scope="module")
def circle() -> RollingContact:
    return ellipse(16)


def forces(found: Rolling) -> np.ndarray:
    return np.array([found.along, found.across, found.moment])


def check_friction(found: Rolling, tolerance: float = 1e-3) -> None:
    """Tractions lie within the cone, and oppose slip where there is any."""
    assert found.status.converged
    limits = found.contact.friction.limits[0][:, None] * found.contact.pressures
    size = np.linalg.norm(found.tractions, axis=2)
    assert (size <= limits * (1.0 + 1e-12)).all()
    assert max(found.residuals.values()) <= tolerance
    np.testing.assert_array_equal(found.states == NO_CONTACT, found.contact.pressures == 0.0)
    slips = found.states == SLIPS
    np.testing.assert_allclose(size[slips], limits[slips], rtol=1e-9)


def test_transient_rolling_becomes_steady(circle) -> None:
    """From a start without tractions, rolling over some patches gives the forces of steady rolling to 1 %."""
    motion = Creepages(0.1, 0.05, 0.1)
    state = roll(circle, Creepages(speed=0.0))
    assert not state.tractions.any()
    size = [0.0]
    for _ in range(60):
        state = roll(circle, motion, before=state, start=state, tolerance=1e-5)
        size.append(abs(state.along))
    check_friction(state)
    assert size[1] < size[5] < size[20]
    np.testing.assert_allclose(forces(state), forces(roll(circle, motion)), rtol=0.01)
    steady = roll(circle, motion, tolerance=1e-8)
    onwards = roll(circle, motion, before=steady, start=steady, tolerance=1e-8)
    np.testing.assert_allclose(onwards.tractions, steady.tractions, atol=1e-6)
    shifted = roll(circle, Creepages(0.01, speed=0.0), before=state)
    assert shifted.along < state.along


def test_prescribed_forces_are_met(circle) -> None:
    """Creepages are found for two forces, for one with the other creepage known, and with spin."""
    limit = MU * circle.force
    both = roll(circle, Creepages(spin=0.1), force_along=-0.5 * limit, force_across=0.3 * limit)
    assert both.status.converged
    np.testing.assert_allclose([both.along, both.across], [-0.5 * limit, 0.3 * limit], atol=1e-5 * limit)
    np.testing.assert_allclose(forces(roll(circle, both.motion)), forces(both), rtol=1e-3)
    one = roll(circle, Creepages(across=0.05), force_along=-0.9 * limit)
    assert one.motion.across == 0.05
    assert one.along == pytest.approx(-0.9 * limit, rel=1e-5)


def test_a_kinetic_coefficient_acts_as_soon_as_cells_slip(circle) -> None:
    """With decay 0 slipping cells have the kinetic limit, sticking ones up to the static one."""
    found = roll(replace(circle, friction=Friction(0.4, 0.3)), Creepages(0.15))
    assert found.status.converged
    size, slips = np.linalg.norm(found.tractions, axis=2), found.states == SLIPS
    np.testing.assert_allclose(size[slips], 0.3 * circle.pressures[slips], rtol=1e-9)
    assert slips.any()
    assert (size > 0.31 * circle.pressures).any()


def test_different_materials_roll_freely_with_creepage() -> None:
    """Bentall and Johnson (1967): rollers of aluminium and steel creep without a force; nearly no friction, 1.5 %."""
    grid = PatchGrid(np.array([-50.0, 50.0]), 0.005, 50)
    metals = Elastic(2.62 * 23000.0, 0.31), Elastic(2.56 * 82000.0, 0.28)
    contact = RollingContact.of_half_spaces(grid, grid.along[None] ** 2 / 50.0, Friction(1e-4), metals, force=1620.19)
    slipping = roll(contact, Creepages(), force_along=0.0)
    assert slipping.status.converged
    assert slipping.motion.along == pytest.approx(5.26e-4, rel=0.015)
    sticking = roll(replace(contact, friction=Friction(10.0)), Creepages(), force_along=0.0)
    assert sticking.status.converged
    assert sticking.motion.along == pytest.approx(3.591e-4, rel=0.015)
    assert "above 1" in sticking.notices[0]
    change = np.abs(sticking.contact.pressures - contact.pressures).max()
    assert 0.001 < change / contact.pressures.max() < 0.2


def test_bodies_roll_nearly_as_half_spaces() -> None:
    """A steel crown below an aluminium wheel: forces are within 5 % of those of half-spaces, coupling to 10 %."""
    low, high = block(60.0, 0.15), block(None, 0.15, placement=TURNED, axis=Axis((0.0, -60.0)))
    aluminium = Elasticity(high.problem.elasticity.space, Elastic(70e3, 0.33), name="wheel")
    high = replace(high, problem=Harmonic(aluminium, held={"base": "xyz"}))
    found = press_patch(low, high, force=10e3, tolerance=1e-2)
    bodies = RollingContact.of_bodies(found, Friction(MU))
    grid, materials, n = bodies.grid, bodies.materials, len(bodies.pressures)
    spaces = RollingContact.between_half_spaces(grid, bodies.pressures, bodies.friction, materials)
    own, plain = (each.coefficients.reshape(-1, n, 3, n, 3)[1:3] for each in (bodies, spaces))
    for i, j in ((0, 1), (1, 0), (1, 2), (2, 1), (0, 2)):
        exact = plain[:, :, i, :, j]
        np.testing.assert_allclose(own[:, :, i, :, j], exact, atol=0.1 * np.abs(exact).max())
    motion = Creepages(5e-4, 5e-4, 1e-4)
    real, plain = (roll(each, motion) for each in (bodies, spaces))
    check_friction(real)
    np.testing.assert_allclose(forces(real), forces(plain), rtol=0.05)
    assert real.frictional_power == pytest.approx(real.t_gamma, rel=1e-9)


def test_a_grid_that_cuts_the_patch_off_is_named() -> None:
    """Pressures that reach the edge of the grid are noticed."""
    gaps = np.linspace(-1.0, 1.0, 8)[:, None] ** 2 + np.linspace(-1.0, 1.0, 8) ** 2
    for force, cut in ((0.1, False), (10.0, True)):
        contact = RollingContact.of_half_spaces(
            PatchGrid(np.linspace(-1.0, 1.0, 9), 0.25, 8), gaps, Friction(0.3), (SOFT, SOFT), force=force
        )
        assert any("edge of the grid" in each for each in roll(contact, Creepages(1e-3)).notices) == cut


def test_bad_inputs(circle) -> None:
    """Friction 0 is none; negative and rising friction, forces beyond the limit, and wrong shapes end in an error."""
    smooth = roll(replace(circle, friction=Friction(0.0)), Creepages(0.1))
    assert smooth.status.converged
    assert not smooth.tractions.any()
    assert "percent" in roll(circle, Creepages(0.2)).notices[0]
    assert roll(circle, Creepages(0.2, speed=0.0)).notices == ()
    for wrong, said in (
        (lambda: Friction(0.2, 0.3), "not above the static"),
        (lambda: Friction(0.2, 0.1, decay=-1.0), "slip velocity >= 0"),
        (lambda: Creepages(np.nan), "finite"),
        (lambda: replace(circle, friction=Friction([0.1, 0.2])), "one for each row"),
        (lambda: roll(circle, Creepages(np.full(2, 1e-3))), "2 creepages for"),
        (lambda: RollingContact.under_hertz((1.0, 1.0), -1.0, (4, 4), Friction(0.3), circle.materials), "positive"),
        (lambda: replace(circle, pressures=0.0 * circle.pressures), "press the bodies"),
        (lambda: roll(circle, Creepages(), force_along=circle.force), "limit of friction"),
        (lambda: roll(circle, Creepages(), start=roll(ellipse(4), Creepages(0.1))), "same grid"),
        (lambda: roll(circle, Creepages(0.1), before=fastsim(circle, Creepages(0.1))), "a result of roll"),
        (lambda: roll(circle, Creepages(0.1), differences=(1.0, 1.0)), "two or three weights of sum 0"),
        (lambda: PatchGrid(np.array([0.0, 1.0, 0.5]), 0.1, 4), "rising ends"),
        (lambda: fastsim(circle, Creepages(0.1), flexibilities=(1e-4, 0.0, 1e-4)), "L1, L2 and L3"),
        (lambda: fastsim(circle, Creepages(0.1), n_steps=2.5), "n_steps"),  # type: ignore[arg-type]
        (lambda: SlopeReduction(initial="half"), "initial = 'half'"),  # type: ignore[arg-type]
        (lambda: Heating(falls=(100.0, 200.0, 300.0)), "two temperatures"),  # type: ignore[arg-type]
        (
            lambda: RollingContact.under_hertz((1.0,), 1.0, (4, 4), Friction(0.3), circle.materials),  # type: ignore[arg-type]
            "give both",
        ),
    ):
        with pytest.raises(InputError, match=said):
            wrong()


COSTLY = settings.get_profile("costly")
EXACT = 1e-9


@dataclass(frozen=True)
class Patch:
    """A grid, pressures and friction from a seed."""

    n_cells: int
    n_strips: int
    wide: float
    seed: int
    varying: bool
    ratio: float

    def contact(self) -> RollingContact:
        """Smooth pressures for even seeds, any for odd ones; the second body is `ratio` times as stiff."""
        random = np.random.default_rng(self.seed)
        grid = PatchGrid(np.linspace(-self.wide, self.wide, self.n_cells + 1), 2.0 / self.n_strips, self.n_strips)
        s = np.linspace(-1.0, 1.0, self.n_cells + 2)[1:-1, None]
        pressures = np.sqrt(np.maximum(1.0 - s**2 - grid.along**2, 0.0)) + 1e-3
        if self.seed % 2:
            pressures = random.uniform(size=pressures.shape) * (random.uniform(size=pressures.shape) < 0.8) + 1e-3
        coefficient = random.uniform(0.0, 1.0, self.n_cells if self.varying else 1)
        materials = Elastic(1.0, random.uniform(0.0, 0.49)), Elastic(self.ratio, random.uniform(0.0, 0.49))
        if self.ratio == 1.0:
            materials = materials[0], materials[0]
        return RollingContact.between_half_spaces(grid, pressures, Friction(coefficient), materials)


PATCHES = st.builds(
    Patch,
    st.integers(2, 9),
    st.integers(2, 9),
    st.floats(0.2, 5.0),
    st.integers(0, 1000),
    st.booleans(),
    st.sampled_from([1.0, 1.0, 0.1, 5.0]),
)
PARTS = st.one_of(st.just(0.0), st.floats(0.01, 1.0), st.floats(-1.0, -0.01))
MOTIONS = st.builds(
    lambda size, along, across, spin, speed: Creepages(10**size * along, 10**size * across, 10**size * spin, speed),
    st.floats(-4.0, 2.0), PARTS, PARTS, PARTS, st.sampled_from([1.0, -1.0, 30.0, 0.0]),
)  # fmt: skip


def limit(contact: RollingContact) -> np.ndarray:
    return contact.friction.limits[0][:, None] * contact.pressures


@pytest.mark.hypothesis
@given(PATCHES, MOTIONS)
def test_the_law_of_friction_holds_and_power_is_that_of_the_motion(patch, motion) -> None:
    """Each search converges; tractions lie within the cone and oppose slip; power is forces times creepages."""
    contact = patch.contact()
    found = roll(contact, motion)
    assert found.status.converged, found.status.message
    assert (np.linalg.norm(found.tractions, axis=2) <= limit(contact) * (1.0 + 1e-12)).all()
    assert max(found.residuals.values()) <= 0.01
    if motion.rolls:
        power = abs(motion.speed) * found.t_gamma
        size = abs(power) + abs(found.rolling_power)
        assert abs(found.frictional_power - power) <= EXACT * size


@pytest.mark.hypothesis
@COSTLY
@given(PATCHES, MOTIONS)
def test_mirrored_and_reversed_motions_give_mirrored_and_reversed_tractions(patch, motion) -> None:
    """Turned over across, and rolling to the other end: tractions and forces turn over."""
    contact = patch.contact()
    tolerance, size = 1e-9, float(limit(contact).max()) + 1e-12
    found = roll(contact, motion, tolerance=tolerance)
    mirrored = replace(
        contact,
        pressures=contact.pressures[::-1],
        friction=Friction(np.broadcast_to(contact.friction.limits[0], (patch.n_cells,))[::-1]),
    )
    other = roll(mirrored, replace(motion, across=-motion.across, spin=-motion.spin), tolerance=tolerance)
    np.testing.assert_allclose(other.tractions[::-1] * [-1.0, 1.0], found.tractions, atol=1e-4 * size)
    np.testing.assert_allclose(forces(other), forces(found) * [1.0, -1.0, -1.0], atol=1e-4 * size * 10.0 * patch.wide)
    back = replace(contact, pressures=contact.pressures[:, ::-1])
    turned = Creepages(-motion.along, motion.across, -motion.spin, -motion.speed)
    other = roll(back, turned, tolerance=tolerance)
    np.testing.assert_allclose(other.tractions[:, ::-1] * [1.0, -1.0], found.tractions, atol=1e-4 * size)


@pytest.mark.hypothesis
@COSTLY
@given(PATCHES, MOTIONS, MOTIONS)
def test_forces_fall_with_creepages_and_are_saturated(patch, motion, other) -> None:
    """Friction is monotone: (F1 - F2) . (xi1 - xi2) <= 0; large creepages of one direction give the whole limit."""
    contact = patch.contact()
    speed = motion.speed
    first, second = (roll(contact, replace(each, speed=speed), tolerance=1e-8) for each in (motion, other))
    apart = [first.motion.along - second.motion.along, first.motion.across - second.motion.across]
    apart.append(first.motion.spin - second.motion.spin)
    whole = float((limit(contact) * contact.areas).sum()) * (1.0 + patch.wide)
    assert (forces(first) - forces(second)) @ apart <= 1e-5 * whole * (1e-12 + float(np.linalg.norm(apart)))
    sliding = roll(contact, Creepages(1e6, speed=speed))
    assert -sliding.along == pytest.approx(float((limit(contact) * contact.areas).sum()), rel=1e-3)
