"""Friction that falls with slip velocity and with flash temperature, and reduced slopes of creep forces."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import derivatives, roll
from flangeway.contact.rolling.rolling_contact import SLIPS, Rolling
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.rolling import (
    Creepages,
    Friction,
    Heat,
    Heating,
    RollingContact,
    SlopeReduction,
    fastrip,
    fastsim,
    linear_theory,
    polach,
)

STEEL = Elastic(210e3, 0.28)
FAST = Friction(0.36, 0.137, decay=1.4)
STAINLESS = {
    "temperature_C": 50.0, "conductivity_W_per_m_K": 16.0, "density_kg_m3": 7900.0, "capacity_J_per_kg_K": 500.0,
}  # fmt: skip
WARM = Friction(0.4, 0.1, heating=Heating(falls=(80.0, 200.0)))


def ellipse(friction: Friction, n: int = 20) -> RollingContact:
    return RollingContact.under_hertz((6.0, 5.0), 80e3, (n, n), friction, (STEEL, STEEL))


def test_a_moving_band_has_its_closed_form() -> None:
    """Even heat q over the length x ahead: 2 q / k sqrt(kappa x / (pi V)), shared by the effusivities; both ways."""
    steel, other = Heat(temperature_C=10.0), Heat(**STAINLESS)
    heating, n, strip, speed = Heating(steel, other), 40, 0.2, 25.0
    rises = heating.rises(np.full((1, n), 30.0), strip, speed)
    x = 1e-3 * strip * (n - np.arange(n) - 0.5)
    share = steel.effusivity / (steel.effusivity + other.effusivity)
    diffusivity = steel.conductivity_W_per_m_K / (steel.density_kg_m3 * steel.capacity_J_per_kg_K)
    exact = 2.0 * share * 30e6 / steel.conductivity_W_per_m_K * np.sqrt(diffusivity * x / (np.pi * speed))
    np.testing.assert_allclose(rises[0], exact, rtol=1e-12)
    np.testing.assert_allclose(heating.rises(np.full((1, n), 30.0), strip, -speed)[0], exact[::-1], rtol=1e-12)
    assert heating.temperature == pytest.approx(10.0 * share + 50.0 * (1.0 - share))


@pytest.mark.parametrize(("falls", "speed"), [((20.0, 800.0), 30.0), ((150.0, 151.0), -30.0)])
def test_friction_falls_with_temperature(falls, speed) -> None:
    """What slips has the coefficient of its own temperature, which the heat ahead gives."""
    contact = ellipse(Friction(0.4, 0.1, heating=Heating(falls=falls)))
    found = roll(contact, Creepages(0.05, 0.01, speed=speed), tolerance=1e-6)
    assert found.status.converged
    heat = np.linalg.norm(found.tractions, axis=2) * np.linalg.norm(found.slip_velocities, axis=2)
    rises = contact.friction.heating.rises(heat, contact.grid.strip, speed)
    np.testing.assert_allclose(found.flash_temperatures, rises, rtol=1e-9, atol=1e-6 * rises.max())
    coefficient = np.interp(20.0 + rises, falls, (0.4, 0.1))
    slips = found.states == SLIPS
    assert coefficient[slips].min() < 0.39
    size = np.linalg.norm(found.tractions, axis=2)
    np.testing.assert_allclose(size[slips], (coefficient * contact.pressures)[slips], rtol=0.01)


@pytest.mark.parametrize("theory", [fastsim, fastrip])
@pytest.mark.parametrize("friction", [FAST, WARM])
def test_fast_theories_fall_as_the_exact_one(theory, friction) -> None:
    """Forces are within 5 % of the limit of the exact ones, the highest temperatures within 20 %."""
    contact = ellipse(friction)
    for creepage in (0.005, 0.03, 0.1):
        exact, fast = (one(contact, Creepages(creepage, speed=30.0)) for one in (roll, theory))
        assert fast.along == pytest.approx(exact.along, abs=0.05 * 0.4 * contact.force)
        if friction is WARM:
            assert fast.flash_temperatures.max() == pytest.approx(exact.flash_temperatures.max(), rel=0.2)


@pytest.mark.parametrize(("friction", "creepage"), [(FAST, 0.01), (Friction(0.36, 0.14, decay=0.1), 0.005)])
def test_transient_steps_with_falling_friction_converge(friction, creepage) -> None:
    """Each of 12 steps from rest ends within the law of friction, also where the patch slips away at once."""
    contact, state = ellipse(friction, 14), None
    for _ in range(12):
        motion = Creepages(creepage if state else 0.0, speed=20.0 if state else 0.0)
        state = roll(contact, motion, before=state, start=state)
        assert state.status.converged, state.status.message
        slips = state.states == SLIPS
        velocity = np.linalg.norm(state.slip_velocities, axis=2)
        law = friction.kinetic + (friction.static - friction.kinetic) * np.exp(-velocity / friction.decay)
        size = np.linalg.norm(state.tractions, axis=2)
        np.testing.assert_allclose(size[slips], (law * contact.pressures)[slips], rtol=0.02)
    assert slips.any()


REMAINS = SlopeReduction(initial=0.8, remaining=0.3, rate=2.0)


@pytest.mark.parametrize(
    ("friction", "size"),
    [
        (Friction(0.3), 1.0), (replace(FAST, slope=SlopeReduction(initial=0.5)), 1.0),
        (Friction(0.3, slope=REMAINS), 0.3), (replace(WARM, slope=REMAINS), 1.0),
    ],
)  # fmt: skip
def test_derivatives_are_those_of_forces_that_fall(friction, size) -> None:
    """Derivatives by the creepages agree with differences where limits depend on slip and heat, slopes on creepages."""
    contact, step = ellipse(friction, 16), 1e-7
    motion = Creepages(0.006 * size, 0.002 * size, 1e-4 * size, 30.0)
    found = roll(contact, motion, tolerance=1e-9)
    for number, name in enumerate(("along", "across", "spin")):
        near = [replace(motion, **{name: getattr(motion, name) + part * step}) for part in (-1.0, 1.0)]
        low, high = (
            np.array([one.along, one.across])
            for one in (roll(contact, each, start=found, tolerance=1e-10) for each in near)
        )
        slopes = derivatives(found)[:2]
        scale = np.abs(slopes[:, :2] if name != "spin" else slopes).max()
        np.testing.assert_allclose(slopes[:, number], (high - low) / (2.0 * step), atol=5e-3 * scale)


@pytest.mark.parametrize("reduction", [SlopeReduction(initial=0.4), REMAINS])
@pytest.mark.parametrize("theory", [roll, fastsim, fastrip, polach, linear_theory])
def test_a_reduced_slope_is_that_of_reduced_creepages(theory, reduction) -> None:
    """Forces at k times the creepages, and power of the forces and the whole creepages."""
    plain, motion = ellipse(Friction(0.3)), Creepages(0.002, 0.001, 2e-4)
    reduced = ellipse(Friction(0.3, slope=reduction))
    k = EllipticContact.slope_of(reduced, motion)
    slower = Creepages(k * motion.along, k * motion.across, k * motion.spin)
    one, other = theory(reduced, motion), theory(plain, slower)
    np.testing.assert_allclose(
        (one.along, one.across, one.moment), (other.along, other.across, other.moment), rtol=2e-3, atol=1e-9
    )
    if isinstance(one, Rolling):
        assert one.frictional_power == pytest.approx(sum(one.products(motion)), rel=1e-6)
        assert one.displacements[0].max() == pytest.approx(other.displacements[0].max() / k, rel=2e-3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: Heating(falls=(200.0, 100.0)), "second temperature"),
        (lambda: Heat(conductivity_W_per_m_K=0.0), "conductivity_W_per_m_K"),
        (lambda: SlopeReduction(initial=1.5), "initial"),
        (lambda: polach(ellipse(WARM), Creepages(0.01)), "theory with tractions"),
        (lambda: roll(ellipse(WARM), Creepages(0.01, speed=0.0)), "steady rolling"),
    ],
)
def test_wrong_inputs(wrong, message) -> None:
    """Impossible numbers, and theories that have no temperatures, are refused."""
    with pytest.raises(InputError, match=message):
        wrong()
