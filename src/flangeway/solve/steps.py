"""Adaptive steps along a path (Moherdaui 2021, 3.5.7.1)."""

from collections.abc import Callable
from dataclasses import dataclass

from flangeway.checks import are_finite
from flangeway.errors import InputError, short
from flangeway.solve.newton import ContactState

FEW_ITERATIONS = 8
MANY_ITERATIONS = 15


@dataclass(frozen=True)
class StepSettings:
    """Sizes of steps on a path from 0 to 1.

    Parameters
    ----------
    first
        First step, 0 < first <= 1.
    maximum
        Maximum step; equal to ``first`` for equal steps where all converge.
    smallest
        Step below which the path is given up.

    """

    first: float = 1.0
    maximum: float = 1.0
    smallest: float = 1.0 / 1024.0

    def __post_init__(self) -> None:
        sizes = self.smallest, self.first, self.maximum
        if not (are_finite(sizes, 3) and 0.0 < sizes[0] <= sizes[1] <= sizes[2] <= 1.0):
            raise InputError(
                "StepSettings(smallest={}, first={}, maximum={})".format(*map(short, sizes)),
                "0 < smallest <= first <= maximum <= 1",
                "for n equal steps take first=1/n, maximum=1/n",
            )


def follow(
    solve_at: Callable[[float, ContactState | None], ContactState],
    start: ContactState | None,
    settings: StepSettings | None = None,
) -> ContactState:
    """Follow a solution along a path from 0 (excluded) to 1.

    A step that needed few iterations is followed by one of twice its length, one that needed many by one of half; a
    step that failed is tried again at half its length from the last solution.

    Parameters
    ----------
    solve_at
        Solves at a position of the path, starting from a neighbouring solution.
    start
        Solution at 0, if there is one.
    settings
        Sizes of the steps.

    Returns
    -------
    ContactState
        The solution at 1, or the failed attempt where the smallest step did not converge.

    """
    settings = settings or StepSettings()
    state, position, size = start, 0.0, settings.first
    while True:
        target = position + size
        if target > 1.0 - settings.smallest / 2.0:  # no sliver at the end
            target = 1.0
        attempt = solve_at(target, state)
        if not attempt.status.converged:
            size = (target - position) / 2.0
            if size < settings.smallest:
                return attempt
            continue
        if target >= 1.0:
            return attempt
        state, position = attempt, target
        if attempt.status.iterations <= FEW_ITERATIONS:
            size = min(2.0 * size, settings.maximum)
        elif attempt.status.iterations > MANY_ITERATIONS:
            size /= 2.0
