"""Indices of rolling contact fatigue against closed forms."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.damage.rolling_fatigue import DangVan, shakedown_index, t_gamma_damage

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
    found = DangVan(200.0, 0.3).of(history(**stresses))
    assert found.equivalent_MPa == pytest.approx([value], rel=1e-4)
    assert found.index == pytest.approx([value / 200.0], rel=1e-4)


def test_residual_stress_changes_the_hydrostatic_part_alone() -> None:
    """A constant stress moves the ball with the history: only its pressure counts."""
    law, stresses = DangVan(200.0, 0.3), history(xy=100.0 * np.cos(TIMES))
    free, held = law.of(stresses), law.of(stresses, residual=np.array([-90.0, 0.0, -60.0, 0.0, 0.0, 0.0]))
    assert held.equivalent_MPa - free.equivalent_MPa == pytest.approx([-0.3 * 50.0], rel=1e-4)


@pytest.mark.parametrize(
    ("histories", "residual"),
    [(np.zeros((4, 6)), None), (np.full((1, 3, 6), np.nan), None), (np.zeros((2, 3, 6)), np.zeros((3, 6)))],
)
def test_stresses_of_other_shapes_are_refused(histories: np.ndarray, residual: np.ndarray | None) -> None:
    """One history without an axis for points, values that are not finite, residual stresses of other points."""
    with pytest.raises(InputError, match="of shape"):
        DangVan(200.0, 0.3).of(histories, residual)
