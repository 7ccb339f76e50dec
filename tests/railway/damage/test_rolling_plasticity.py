"""Repeated rolling with plasticity against Melan's limits and closed forms."""

from functools import cache

import numpy as np
import pytest

from flangeway.exact.shakedown import shakedown_limits
from flangeway.railway.damage.rolling_plasticity import BASE, RepeatedRolling, RollingLine, RollingSteel

STEEL = RollingSteel(300.0)
HARDENING = RollingSteel(300.0, hardening_MPa=20e3)


@cache
def line(load_factor: float, friction: float, steel: RollingSteel = STEEL, cells: int = 8) -> RollingLine:
    """A line contact on a coarse mesh, deep enough for flow below the surface."""
    return RollingLine(load_factor, friction, steel, cells, depth=1.0)


@cache
def repeated(load_factor: float, friction: float, steel: RollingSteel = STEEL) -> RepeatedRolling:
    """Passages until they end in a state."""
    return line(load_factor, friction, steel).repeated()


@pytest.mark.parametrize(
    ("load_factor", "friction", "state"),
    [
        (3.05, 0.0, "elastic"),
        (3.95, 0.0, "shakedown"),
        (4.05, 0.0, "ratchetting"),
        (3.70, 0.1, "ratchetting"),
        (2.80, 0.3, "shakedown"),
        (2.42, 0.4, "shakedown"),
        (2.58, 0.4, "ratchetting"),
        (1.94, -0.5, "shakedown"),
        (2.06, -0.5, "ratchetting"),
    ],
)
def test_passages_show_the_limits_of_melan(load_factor: float, friction: float, state: str) -> None:
    """Perfectly plastic steel shakes down below Melan's limit and ratchets above: 4.0, 3.564, 2.9, and 1 / mu."""
    found = repeated(load_factor, friction)
    assert found.state == state
    limits = shakedown_limits("line", abs(friction))
    assert (load_factor < float(limits.first_yield)) == (state == "elastic")
    assert (load_factor > float(limits.shakedown)) == (state == "ratchetting")


def test_kinematic_hardening_ends_in_closed_loops() -> None:
    """Above the limit for kinematic hardening loops close (Hahn and Kumar): no forward flow, but flow to and fro."""
    below, above = repeated(3.8, 0.1, HARDENING), repeated(4.2, 0.1, HARDENING)
    assert (below.state, above.state) == ("shakedown", "plastic shakedown")
    assert np.abs(above.strains).max() < 1e-6
    assert above.increments[-1] > 0.1


def test_ratchetting_is_at_the_depth_of_the_alternating_shear() -> None:
    """Without friction the shear stress alternates most at half of the half width: there strain grows."""
    found = repeated(4.05, 0.0)
    assert found.ratchetting_depth == pytest.approx(0.5, abs=0.13)


def test_tractions_beyond_yield_in_shear_let_the_surface_flow() -> None:
    """At friction 0.4 and p0/k = 2.58 steel ratchets in the uppermost layer."""
    found = repeated(2.58, 0.4)
    assert found.ratchetting_depth == pytest.approx(0.0, abs=0.02)


def test_residual_stress_is_in_equilibrium_and_within_yield() -> None:
    """After shakedown the elastic stress of a passage with the residual stress is nowhere above yield."""
    rolling, found = line(3.95, 0.0), repeated(3.95, 0.0)
    residual = found.residual_MPa / STEEL.shear_yield_MPa
    none = np.zeros(len(residual))
    whole = rolling.elastic + (np.stack((residual[:, 0], none, residual[:, 1], none), axis=1) @ BASE.T)[:, None]
    assert np.linalg.norm(whole, axis=2).max() <= np.sqrt(2.0) * (1.0 + 1e-4)
    assert np.linalg.norm(rolling.elastic, axis=2).max() > np.sqrt(2.0) * 1.2
