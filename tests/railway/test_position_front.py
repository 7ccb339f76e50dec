"""The order in which many positions are solved."""

import numpy as np
import pytest

from flangeway.railway.positions.position_queue import FARTHEST, MOST_STATES, MOST_TRIES, SMALL_SHARES, Front, Journey
from flangeway.railway.positions.positions_newton import LaneState
from flangeway.railway.positions.surface_positions import Demands

STATE = LaneState(np.zeros(3), ())


def grid(lateral_mm: np.ndarray, loads_N: np.ndarray) -> Demands:
    lateral, load = (each.ravel() for each in np.meshgrid(lateral_mm, loads_N, indexing="ij"))
    given = np.full((len(load), 3), np.nan)
    given[:, 0] = lateral
    return Demands(np.zeros(len(load)), load, load, given, 0.0)


def front(demands: Demands, n_first: int = 1) -> Front:
    return Front(demands, np.ones(len(demands.onto), dtype=np.bool_), n_first)


@pytest.fixture
def dense() -> Demands:
    """Thirty lateral motions by sixty loads, neighbours less than three steps apart."""
    return grid(np.linspace(0.0, 5.8, 30), np.linspace(100e3, 300e3, 60))


def test_each_position_is_given_once_from_a_neighbour(dense: Demands) -> None:
    """Where all are found, each position is given once, from one found before; only the first are begun anew."""
    order = front(dense, n_first=4)
    at: list[Journey | None] = [order.next(None) for _ in range(4)]
    found: list[int] = []
    while any(at):
        for lane, journey in enumerate(at):
            if journey is None:
                continue
            assert journey.origin in found or (journey.origin is None and len(found) < 4)
            if journey.origin is not None:
                steps = np.abs(order.features[journey.number] - order.features[journey.origin]).sum()
                assert steps <= FARTHEST
                assert journey.follows or journey.origin in order.states
            found.append(journey.number)
            order.arrived(journey.number, STATE)
            at[lane] = order.next(journey.number)
    assert sorted(found) == list(range(len(dense.onto)))


def test_states_that_serve_no_more_are_dropped(dense: Demands) -> None:
    """Of 1800 positions fewer states than that are kept, and those of the nearest found are among them."""
    order = front(dense)
    journey, most = order.next(None), 0
    while journey is not None:
        order.arrived(journey.number, STATE)
        most = max(most, len(order.states))
        assert set(order.nearest[order.open]) <= set(order.states)
        journey = order.next(journey.number)
    assert most <= MOST_STATES + 1 < order.found.sum()


def test_a_lane_goes_on_to_the_nearest() -> None:
    """A lane that has found a position goes on from it to the nearest that is open, without being moved."""
    order = front(grid(np.array([0.0]), np.array([100e3, 101e3, 103e3])))
    first = order.next(None)
    assert first is not None
    assert (first.number, first.origin) == (1, None)
    order.arrived(1, STATE)
    assert order.next(1) == Journey(0, 1, follows=True)
    order.arrived(0, STATE)
    assert order.next(0) == Journey(2, 0, follows=True)


def test_ways_to_a_lost_position() -> None:
    """A lost position is begun from other neighbours, then with stops, then by small loads, and then left."""
    order = front(grid(np.array([0.0]), 100e3 + 1e3 * np.arange(5.0)))
    lost: list[Journey] = []
    journey = order.next(None)
    while journey is not None:
        if journey.number == 0:
            lost.append(journey)
            order.lost(journey)
            journey = order.next(None)
        else:
            order.arrived(journey.number, STATE)
            journey = order.next(None)
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
    """A stop at a quarter of the way has a quarter of the difference in load and motion; from rigid wheels, of load."""
    demands = grid(np.array([0.0, 2.0]), np.array([100e3]))
    lane = demands.take(np.array([0]))
    stop = lane.changed(0, demands, 1, 0.25, 0)
    assert (stop.onto[0], stop.weight[0], stop.given[0, 0]) == (100e3, 100e3, 0.5)
    begun = lane.changed(0, demands, 1, 0.25, None)
    assert (begun.onto[0], begun.weight[0], begun.given[0, 0]) == (25e3, 25e3, 2.0)
    assert lane.given[0, 0] == 0.0
