"""Rolling contact fatigue and plasticity of repeated rolling against closed forms and Melan's limits."""

from functools import cache

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.exact.shakedown import shakedown_limits
from flangeway.railway.damage.rolling_fatigue import DangVan, shakedown_index, t_gamma_damage
from flangeway.railway.damage.rolling_plasticity import BASE, RepeatedRolling, RollingLine, RollingSteel

TIMES = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)


def history(**components: np.ndarray) -> np.ndarray:
    """One point's stresses over `TIMES`, (1, m, 6)."""
    names = ("xx", "yy", "zz", "xy", "yz", "xz")
    return np.stack([components.get(name, np.zeros(len(TIMES))) for name in names], axis=1)[None]


def test_t_gamma_damage_has_the_points_of_the_whole_life_rail_model() -> None:
    """0 to 15 N, 1e-5 at 65 N, 0 at 175 N, and negative beyond; cracks and wear are apart."""
    found = t_gamma_damage(np.array([0.0, 15.0, 40.0, 65.0, 120.0, 175.0, 285.0]))
    assert 1e6 * found.net == pytest.approx([0.0, 0.0, 5.0, 10.0, 5.0, 0.0, -10.0])
    assert 1e6 * found.cracks == pytest.approx([0.0, 0.0, 5.0, 10.0, 10.0, 10.0, 10.0])
    assert 1e6 * found.wear == pytest.approx([0.0, 0.0, 0.0, 0.0, 5.0, 10.0, 20.0])


def test_shakedown_index_is_one_at_the_limits() -> None:
    """A circle without friction shakes down up to p0 = 4.7 k, and up to 1 / mu at high friction."""
    assert shakedown_index(4.7 * 300.0, 300.0, 0.0) == pytest.approx(1.0, rel=0.01)
    assert shakedown_index(2.0 * 300.0, 300.0, 0.5) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("stresses", "value"),
    [
        ({"xy": 100.0 * np.cos(TIMES)}, 100.0),  # alternating shear: its amplitude
        ({"xy": 50.0 * (1.0 + np.cos(TIMES))}, 50.0),  # pulsating shear: half of its range
        ({"xx": 100.0 * np.cos(TIMES)}, 50.0 + 0.3 * 100.0 / 3.0),  # alternating tension, at its maximum
        ({"xx": 50.0 * (1.0 + np.cos(TIMES))}, 25.0 + 0.3 * 100.0 / 3.0),  # pulsating tension
        ({"xx": -50.0 * (1.0 + np.cos(TIMES))}, 25.0),  # pulsating compression: without load
        ({"xy": 100.0 * np.cos(TIMES), "yz": 100.0 * np.sin(TIMES)}, 100.0),  # turning shear on one plane
    ],
)
def test_dang_van_has_closed_forms(stresses: dict[str, np.ndarray], value: float) -> None:
    """Equivalent stress and index of simple histories are those of closed forms, to 1e-4."""
    found = DangVan(limit_MPa=200.0, slope=0.3).of(history(**stresses))
    assert found.equivalent_MPa == pytest.approx([value], rel=1e-4)
    assert found.index == pytest.approx([value / 200.0], rel=1e-4)


def test_residual_stress_changes_the_hydrostatic_part_alone() -> None:
    """A constant stress moves the ball with the history: only its pressure counts."""
    law, stresses = DangVan(limit_MPa=200.0, slope=0.3), history(xy=100.0 * np.cos(TIMES))
    free, held = law.of(stresses), law.of(stresses, residual=np.array([-90.0, 0.0, -60.0, 0.0, 0.0, 0.0]))
    assert held.equivalent_MPa - free.equivalent_MPa == pytest.approx([-0.3 * 50.0], rel=1e-4)


@pytest.mark.parametrize(
    ("histories", "residual"),
    [(np.zeros((4, 6)), None), (np.full((1, 3, 6), np.nan), None), (np.zeros((2, 3, 6)), np.zeros((3, 6)))],
)
def test_stresses_of_other_shapes_are_refused(histories: np.ndarray, residual: np.ndarray | None) -> None:
    """One history without an axis for points, values that are not finite, residual stresses of other points."""
    with pytest.raises(InputError, match="of shape"):
        DangVan(limit_MPa=200.0, slope=0.3).of(histories, residual)


STEEL = RollingSteel(shear_yield_MPa=300.0)
HARDENING = RollingSteel(shear_yield_MPa=300.0, hardening_MPa=20e3)


@cache
def line(load_factor: float, friction: float, steel: RollingSteel = STEEL, cells: int = 8) -> RollingLine:
    """A line contact on a coarse mesh, deep enough for flow below the surface."""
    return RollingLine(load_factor=load_factor, friction=friction, steel=steel, cells=cells, depth=1.0)


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
        pytest.param(3.70, 0.1, "ratchetting", marks=pytest.mark.ci),
        pytest.param(2.80, 0.3, "shakedown", marks=pytest.mark.ci),
        (2.42, 0.4, "shakedown"),
        (2.58, 0.4, "ratchetting"),
        pytest.param(1.94, -0.5, "shakedown", marks=pytest.mark.ci),
        pytest.param(2.06, -0.5, "ratchetting", marks=pytest.mark.ci),
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
