"""States of a collective that stand for all inputs up to halfway to their neighbours."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

RADIUS, SHARE = "curve_radius_m", "share"


def moved(states: Sequence[Mapping[str, Any]], offset: float) -> list[dict[str, Any]]:
    """Return the inputs of states (n,) towards their neighbours, with their shares as they are.

    Neighbours are next in gauge and yaw on straight track, and next in curvature in curves of one hand. All inputs that
    these have as numbers move together, by an offset in the mean distance of both neighbours, along curvature and not
    radius. An offset up to 1/2 leads no curve beyond half of its curvature.
    """
    found = [dict(state) for state in states]
    groups: dict[float, list[int]] = {}
    for number, state in enumerate(states):
        groups.setdefault(float(np.sign(state.get(RADIUS, 0.0))), []).append(number)
    for hand, members in groups.items():
        members.sort(key=lambda number: _order(states[number]))
        common = [key for key in states[members[0]] if all(_is_number(states[number].get(key)) for number in members)]
        linear = [key for key in common if key != SHARE]
        rows = np.array([[_linear(key, states[number][key]) for key in linear] for number in members])
        slopes = np.gradient(rows, axis=0) if len(members) > 1 else np.zeros_like(rows)
        for number, row, slope in zip(members, rows, slopes, strict=True):
            share = 1.0
            if hand and slope[linear.index(RADIUS)]:
                at = linear.index(RADIUS)
                share = min(1.0, abs(row[at] / slope[at]))
            inputs = (row + offset * share * slope).tolist()
            found[number] |= {key: _linear(key, value) for key, value in zip(linear, inputs, strict=True)}
    return found


def _order(state: Mapping[str, Any]) -> tuple[float, ...]:
    return (1.0 / state[RADIUS],) if RADIUS in state else (state.get("gauge_mm", 0.0), state.get("yaw_mrad", 0.0))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _linear(key: str, value: float) -> float:
    """Curvature of a radius, and radius of a curvature; other inputs as they are."""
    return 1.0 / value if key == RADIUS else float(value)


def drawn(step: int, part: int, n_parts: int) -> float:
    """Return the offset of all states in a step, in one part of the interval from -1/2 to 1/2: its middle in step 0.

    Multiples of the golden ratio, which fill a part evenly for every number of steps (Niederreiter, 1992, Random Number
    Generation and Quasi-Monte Carlo Methods, chapter 3).
    """
    within = (0.5 + 0.5 * (np.sqrt(5.0) - 1.0) * step) % 1.0
    return float((part + within) / n_parts - 0.5)
