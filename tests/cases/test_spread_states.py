"""States that stand for all inputs up to halfway to their neighbours."""

import numpy as np
import pytest

from flangeway.cases.damage.damage_file import DamageFile
from flangeway.cases.damage.spread_states import drawn, moved

STATES = [
    {"curve_radius_m": 600.0, "speed_km_h": 80.0, "share": 0.2},
    {"gauge_mm": 1435.0, "yaw_mrad": 0.3, "speed_km_h": 140.0, "share": 0.3},
    {"curve_radius_m": 3000.0, "speed_km_h": 120.0, "share": 0.2},
    {"gauge_mm": 1438.0, "yaw_mrad": -0.1, "speed_km_h": 140.0, "share": 0.2},
    {"curve_radius_m": -500.0, "speed_km_h": 70.0, "flange_friction": 0.2, "share": 0.1},
]


@pytest.mark.parametrize("n_parts", [1, 3])
def test_drawn_offsets_fill_each_part_evenly(n_parts: int) -> None:
    """Offsets of any number of steps lie in their part, and their share of each tenth of it is 0.1 to 0.02."""
    for part in range(n_parts):
        low = part / n_parts - 0.5
        offsets = np.array([drawn(step, part, n_parts) for step in range(200)])
        assert offsets[0] == pytest.approx(low + 0.5 / n_parts)
        assert (offsets >= low).all()
        assert (offsets < low + 1.0 / n_parts).all()
        assert np.histogram(offsets, 10, (low, low + 1.0 / n_parts))[0] == pytest.approx(20, abs=4)


def test_states_move_to_halfway_of_their_neighbours() -> None:
    """Two states of a hand meet at the middle of their curvatures, those on straight track at that of their gauges."""
    up, down = (moved(STATES, offset) for offset in (0.5, -0.5))
    assert up[1]["gauge_mm"] == pytest.approx(1436.5)
    assert down[3] == pytest.approx(up[1] | {"share": 0.2})
    assert 1.0 / up[2]["curve_radius_m"] == pytest.approx(1.5 / 3000.0)  # no curve beyond half of its curvature
    assert 1.0 / down[2]["curve_radius_m"] == pytest.approx(0.5 / 3000.0)
    assert 1.0 / down[0]["curve_radius_m"] == pytest.approx(0.5 * (1.0 / 600.0 + 1.0 / 3000.0))
    assert down[0]["speed_km_h"] == pytest.approx(100.0)
    assert up[4] == STATES[4]  # no neighbour of its hand
    assert moved(STATES, 0.0) == [pytest.approx(state) for state in STATES]


def test_a_file_draws_other_states_in_each_step(tmp_path) -> None:
    """With spread each state becomes that many, with its share in all, elsewhere in each step; without they stay."""
    text = """
[inputs]
friction = 0.3
[[states]]
share = 0.6
speed_km_h = 100
curve_radius_m = 1500
[[states]]
share = 0.4
speed_km_h = 80
curve_radius_m = 800
[wear.wheel]
law = "usfd"
[evolution]
end = 10
"""
    file = tmp_path / "line.toml"
    file.write_text(text)
    assert DamageFile.read(file).damage().evolution.collective.drawn is None
    file.write_text("spread = 2\n" + text)
    collective = DamageFile.read(file).damage().evolution.collective
    radii = []
    for step in range(3):
        states = collective.of_step(step)
        assert [state.share for state in states] == [0.3, 0.2, 0.3, 0.2]
        radii.append([state.model.rolling.curve_radius_m for state in states])
        assert max(radii[-1][::2]) == radii[-1][0] > 1500.0 > radii[-1][2] > radii[-1][1] > 800.0 > radii[-1][3]
    assert len({tuple(each) for each in radii}) == 3
    again = DamageFile.read(file).damage().evolution.collective
    assert [state.model.rolling.curve_radius_m for state in again.of_step(2)] == radii[2]
