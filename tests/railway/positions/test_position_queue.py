"""The order in which many positions are solved."""

import numpy as np
import pytest

from flangeway.railway.positions.position_queue import (
    FARTHEST,
    MOST_STATES,
    MOST_TRIES,
    SMALL_SHARES,
    Continuation,
    PositionQueue,
)
from flangeway.railway.positions.positions_newton import PositionState
from flangeway.railway.positions.surface_positions import Targets
from flangeway.railway.wheelset.residual import AxleLoads

STATE = PositionState(np.zeros(3), ())


def grid(lateral_mm: np.ndarray, loads_N: np.ndarray) -> Targets:
    lateral, load = (each.ravel() for each in np.meshgrid(lateral_mm, loads_N, indexing="ij"))
    given = np.full((len(load), 3), np.nan)
    given[:, 0] = lateral
    return Targets(AxleLoads(np.zeros(len(load)), load, load, 0.0, 1.0), given)


def queue(targets: Targets, n_first: int = 1) -> PositionQueue:
    return PositionQueue(targets, np.ones(len(targets.loads.onto), dtype=np.bool_), n_first)


@pytest.fixture
def dense() -> Targets:
    """Thirty lateral positions by sixty loads, neighbours less than three steps apart."""
    return grid(np.linspace(0.0, 5.8, 30), np.linspace(100e3, 300e3, 60))


def test_each_position_is_given_once_from_a_neighbour(dense: Targets) -> None:
    """Where all are found, each position is given once, from one found before; only the first are begun anew."""
    order = queue(dense, n_first=4)
    at: list[Continuation | None] = [order.next(None) for _ in range(4)]
    found: list[int] = []
    while any(at):
        for slot, continuation in enumerate(at):
            if continuation is None:
                continue
            assert continuation.origin in found or (continuation.origin is None and len(found) < 4)
            if continuation.origin is not None:
                steps = np.abs(order.features[continuation.number] - order.features[continuation.origin]).sum()
                assert steps <= FARTHEST
                assert continuation.follows or continuation.origin in order.states
            found.append(continuation.number)
            order.arrived(continuation.number, STATE)
            at[slot] = order.next(continuation.number)
    assert sorted(found) == list(range(len(dense.loads.onto)))


def test_states_that_serve_no_more_are_dropped(dense: Targets) -> None:
    """Of 1800 positions fewer states than that are kept, and those of the nearest found are among them."""
    order = queue(dense)
    continuation, most = order.next(None), 0
    while continuation is not None:
        order.arrived(continuation.number, STATE)
        most = max(most, len(order.states))
        assert set(order.nearest[order.open]) <= set(order.states)
        continuation = order.next(continuation.number)
    assert most <= MOST_STATES + 1 < order.found.sum()


def test_a_lane_goes_on_to_the_nearest() -> None:
    """A slot that has found a position goes on from it to the nearest that is open, without being moved."""
    order = queue(grid(np.array([0.0]), np.array([100e3, 101e3, 103e3])))
    first = order.next(None)
    assert first is not None
    assert (first.number, first.origin) == (1, None)
    order.arrived(1, STATE)
    assert order.next(1) == Continuation(0, 1, follows=True)
    order.arrived(0, STATE)
    assert order.next(0) == Continuation(2, 0, follows=True)


def test_ways_to_a_lost_position() -> None:
    """A lost position is begun from other neighbours, then with stops, then by small loads, and then left."""
    order = queue(grid(np.array([0.0]), 100e3 + 1e3 * np.arange(5.0)))
    lost: list[Continuation] = []
    continuation = order.next(None)
    while continuation is not None:
        if continuation.number == 0:
            lost.append(continuation)
            order.lost(continuation)
            continuation = order.next(None)
        else:
            order.arrived(continuation.number, STATE)
            continuation = order.next(None)
    direct = [each.origin for each in lost if each.shares == (1.0,) and each.origin is not None]
    assert 1 <= len(direct) <= MOST_TRIES
    assert len(set(direct)) == len(direct)
    begun, stops, small = lost[-3:]
    assert begun.origin is None
    assert stops.origin == 1
    assert stops.shares[-1] == 1.0
    assert len(stops.shares) > 1
    assert (small.origin, small.shares) == (None, SMALL_SHARES)
    assert order.open.tolist() == [True, False, False, False, False]


def test_a_stop_lies_between_two_positions() -> None:
    """A stop at a quarter of the way has a quarter of the difference in load and position, or of the load alone."""
    targets = grid(np.array([0.0, 2.0]), np.array([100e3]))
    slot = targets.take(np.array([0]))
    stop = slot.changed(0, targets, 1, 0.25, 0)
    assert (stop.loads.onto[0], stop.loads.weight[0], stop.prescribed[0, 0]) == (100e3, 100e3, 0.5)
    begun = slot.changed(0, targets, 1, 0.25, None)
    assert (begun.loads.onto[0], begun.loads.weight[0], begun.prescribed[0, 0]) == (25e3, 25e3, 2.0)
    assert slot.prescribed[0, 0] == 0.0
