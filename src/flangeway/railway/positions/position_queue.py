"""The order in which many positions are solved: each from a neighbour that has been found."""

import math
from dataclasses import dataclass

import numpy as np

from flangeway.railway.positions.positions_newton import PositionState
from flangeway.railway.positions.surface_positions import Targets
from flangeway.types import Bools, Floats

NEAR = np.array([0.1, 0.02, 0.02])  # one step: lateral position in mm, relative load, lateral over vertical force
NEXT = 3.0  # steps within which a slot goes on from the position where it is, and between stops on a way
FARTHEST = 8.0  # steps beyond which a position is not begun from another at once
MOST_TRIES = 3  # how often a position is begun from neighbours, each time from another one
MOST_POINTS = 24  # most stops on the way to a position that was lost
MOST_STATES = 512  # states that are kept before those are dropped that serve no more

SHARES = (0.1, 0.3, 1.0)
SMALL_SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0)
"""Parts of its load under which a position is come to from rigid wheels, at first and when all else failed."""


@dataclass(frozen=True)
class Continuation:
    """How a slot comes to a position.

    - `origin`: position that has been found and where the way begins; None: rigid wheels, and a way of increasing load.
    - `shares`: parts of the way at which it is stopped, the last is 1.
    - `follows`: whether the slot is already where the next part of the way begins.
    """

    number: int
    origin: int | None
    shares: tuple[float, ...] = (1.0,)
    follows: bool = False

    @property
    def arrives(self) -> bool:
        """Whether the next stop is the position itself."""
        return len(self.shares) == 1

    def on(self) -> "Continuation":
        """What is left of it after the next stop."""
        return Continuation(self.number, self.origin, self.shares[1:], follows=True)


class PositionQueue:
    """Positions that are open, and where they may be begun from.

    A few positions are begun from rigid wheels. All others are begun from the nearest that has been found, as soon as
    there is one; if they are lost, from others that are found later, then with stops on the way, then once more from
    rigid wheels.

    - `possible`: which of them are wanted, shape (n,).
    - `n_first`: how many are begun from rigid wheels at first.
    """

    def __init__(self, targets: Targets, possible: Bools, n_first: int) -> None:
        self.features = _features(targets)
        n = len(self.features)
        self.open, self.found = possible.copy(), ~possible
        self.distance, self.nearest = np.full(n, np.inf), np.full(n, -1)
        self.lost_from, self.tries = np.full(n, -1), np.zeros(n, dtype=np.int64)
        self.begun, self.stopped, self.tried_all = (np.zeros(n, dtype=np.bool_) for _ in range(3))
        self.states: dict[int, PositionState] = {}
        self.most_states = MOST_STATES
        order = np.lexsort(self.features.T[[1, 2, 0]])
        order = order[possible[order]]
        spread = (np.arange(n_first) + 0.5) / n_first * len(order)
        self.first = np.unique(order[spread.astype(np.int64)]).tolist() if len(order) else []

    def arrived(self, number: int, state: PositionState) -> None:
        """Note that a position has been found, and its state."""
        self.states[number], self.found[number] = state, True
        away = self._away(number)
        closer = away < self.distance
        self.distance[closer], self.nearest[closer] = away[closer], number
        if len(self.states) > self.most_states:
            serving = set(self.nearest[~self.found].tolist())
            self.states = {each: state for each, state in self.states.items() if each in serving}
            self.most_states = max(MOST_STATES, 2 * len(self.states))

    def lost(self, continuation: Continuation) -> None:
        """Note that a position was not found that way."""
        self.open[continuation.number] = True
        if continuation.origin is not None:
            self.lost_from[continuation.number] = continuation.origin

    def next(self, at: int | None) -> Continuation | None:
        """How a slot goes on.

        None if all ways to all open positions have been tried.

        - `at`: the position that it has just found; None if it has not.
        """
        if self.first:
            return self._begin(self.first.pop(), SHARES)
        return self._neighbour(at) or self._far_one()

    def _neighbour(self, at: int | None) -> Continuation | None:
        """The way to a position close to one that has been found."""
        willing = self.open & (self.tries < MOST_TRIES)
        if at is not None:
            away = np.where(willing & (self.lost_from != at), self._away(at), np.inf)
            number = int(np.argmin(away))
            if away[number] <= NEXT:
                self.tries[number] += 1
                return self._go(number, at, follows=True)
        away = np.where(willing & (self.lost_from != self.nearest), self.distance, np.inf)
        number = int(np.argmin(away))
        if away[number] > FARTHEST:
            return None
        self.tries[number] += 1
        return self._go(number, int(self.nearest[number]))

    def _far_one(self) -> Continuation | None:
        """The way to a position that has no neighbours, or was lost from those that it has."""
        for number in np.flatnonzero(self.open & ~self.begun)[:1]:
            return self._begin(int(number), SHARES)
        for number in np.flatnonzero(self.open & ~self.stopped & (self.nearest >= 0))[:1]:
            self.stopped[number] = True
            n_points = min(math.ceil(self.distance[number] / NEXT) + 1, MOST_POINTS)
            shares = tuple((each + 1) / n_points for each in range(n_points))
            return self._go(int(number), int(self.nearest[number]), shares)
        for number in np.flatnonzero(self.open & ~self.tried_all)[:1]:
            self.tried_all[number] = True
            return self._begin(int(number), SMALL_SHARES)
        return None

    def _begin(self, number: int, shares: tuple[float, ...]) -> Continuation:
        self.open[number], self.begun[number] = False, True
        return Continuation(number, None, shares)

    def _go(
        self, number: int, origin: int, shares: tuple[float, ...] = (1.0,), *, follows: bool = False
    ) -> Continuation:
        self.open[number] = False
        return Continuation(number, origin, shares, follows)

    def _away(self, number: int) -> Floats:
        """Steps from a position to all, shape (n,)."""
        away: Floats = np.abs(self.features - self.features[number]) @ np.ones(3)
        return away


def _features(targets: Targets) -> Floats:
    """Positions in a space where neighbours are about one apart, shape (n, 3)."""
    lateral = np.where(np.isnan(targets.prescribed[:, 0]), 1e3, targets.prescribed[:, 0])
    ratio = np.where(np.isnan(targets.prescribed[:, 0]), targets.loads.along / targets.loads.onto, 0.0)
    return np.stack((lateral, np.log(targets.loads.onto), ratio), axis=1) / NEAR
