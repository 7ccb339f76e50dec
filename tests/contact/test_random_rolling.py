"""Random patches that roll or shift at random creepages: the law of friction, symmetries and energy."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.materials import Elastic

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


def forces(found: Rolling) -> np.ndarray:
    return np.array([found.along, found.across, found.moment])


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
