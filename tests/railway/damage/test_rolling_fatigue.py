"""Indices of rolling contact fatigue against closed forms."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.damage.rolling_fatigue import DangVan, ball_centres, shakedown_index, t_gamma_damage

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


def test_balls_hold_all_points_and_are_the_smallest() -> None:
    """The ball around a square is its circle; no centre nearby has a smaller ball around random points."""
    square = np.array([[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 0.5]]])
    assert ball_centres(square) == pytest.approx(np.array([[1.0, 1.0]]), abs=1e-4)
    points = np.random.default_rng(1).normal(size=(50, 40, 5))
    centres = ball_centres(points)
    radius = np.linalg.norm(points - centres[:, None], axis=2).max(axis=1)
    steps = 1e-2 * np.random.default_rng(2).normal(size=(200, 50, 5))
    moved = np.linalg.norm(points - (centres + steps)[:, :, None], axis=3).max(axis=2)
    assert (moved.min(axis=0) >= radius * (1.0 - 1e-5)).all()


def test_line_contact_rolling_below_has_its_shear_range() -> None:
    """Dang Van's shear stress at half of the half width below a rolling line contact is p0 / 4, as Johnson's shakedown.

    Without hydrostatic weight: the static maximum is 0.3 p0, the amplitude of the shear along the path a quarter.
    """
    # McEwen's stresses at x for Hertz's pressure of half width 1 and p0 = 1 at depth 0.5
    x, z = np.linspace(-4.0, 4.0, 321), 0.5
    u = np.linspace(-1.0, 1.0, 1001)
    p = np.sqrt(1.0 - u**2) * (u[1] - u[0])
    d = x[:, None] - u
    r4 = (d**2 + z**2) ** 2
    xx, yy, xy = (-2.0 / np.pi * (p * each / r4).sum(axis=1) for each in (d**2 * z, np.full_like(d, z**3), d * z**2))
    zz = 0.3 * (xx + yy)
    none = np.zeros_like(xx)
    found = DangVan(1.0, 0.0).of(np.stack((xx, yy, zz, xy, none, none), axis=1)[None])
    assert np.ptp(xy) / 2.0 == pytest.approx(0.25, rel=1e-3)
    assert found.equivalent_MPa == pytest.approx([0.25], rel=1e-3)
