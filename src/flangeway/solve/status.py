"""How a computation ended, the limits and the history of Newton's method, and adaptive steps along a path."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from flangeway.checks import are_finite, check_integer, check_positive, check_tolerance
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import norms
from flangeway.types import Floats

# --- How a computation ended, and the limits and the history of Newton's method.


ROUND_OFF = 1e-7
"""Residual below which an iteration has converged if it no longer falls: where slender bodies bend, round-off of their
stiffness is above the tolerance."""

STALLED_ITERATIONS = 3
"""Iterations without a change of constraints, none of which halves the residual, after which it no longer falls."""


MIN_DIGITS, FEW_DIGITS = 2.0, 6.0
"""Decimal digits below which a solution is not accepted, and below which its message names them."""


MAX_STABILISATION = 0.05
"""Fraction of the work that is the stabilisation's above which the message names it."""


@dataclass(frozen=True)
class Checks:
    """What was measured on a solution, apart from the iteration that found it; see `contact.solution_checks`.

    Parameters
    ----------
    force_residual
        Sum of the contact forces of all bodies, or of a handle's forces and loads, over the maximum nodal force.
    moment_residual
        The same of moments, over the maximum nodal force and the bodies' size.
    gap_under_pressure
        Mean distance of surfaces under force, weighted by the force, over the surfaces' maximum displacement.
    slide
        Maximum tangential distance of paired nodes under force, over the edge's length; of node-to-node only.
    overlap
        Maximum overlap of deformed bodies beyond the sagittas of drawn curves and the law of contact.
    inverted_cells
        Number of cells that the displacements turn inside out.
    max_strain
        Maximum mean strain of a cell.
    max_turn
        Maximum mean rotation of a cell in its body's frame, rad.
    force_error
        Maximum estimated error of a region's contact force by law and mesh, relative to it, where no force is
        prescribed; see `flangeway.contact.force_errors`.
    approach_error
        The same of the approach under a prescribed force, a length.
    errors
        Sentences about what makes the solution wrong.
    warnings
        Sentences about what makes it less exact.

    """

    force_residual: float
    moment_residual: float
    gap_under_pressure: float
    slide: float
    overlap: float
    inverted_cells: int
    max_strain: float
    max_turn: float
    force_error: float = 0.0
    approach_error: float = 0.0
    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Status:
    """Outcome of an iteration: not converging is a result, not an exception.

    Parameters
    ----------
    converged
        Whether the tolerance was reached.
    message
        A sentence: what happened and, on failure, what to try.
    iterations
        Number of Newton iterations.
    digits
        Decimal digits of the displacements that round-off leaves; None where they are not estimated.
    checks
        What was measured on a contact solution whose iteration converged; None where nothing was.
    stabilisation
        Fraction of the work of internal forces that is that of the elements' stabilisation, of nonlinear problems; None
        where it was not measured.
    residual
        Residual of the last iteration, see `Iteration`; infinite where there was none.
    is_unheld
        Whether there is no equilibrium, as nothing holds a rigid motion: no shorter step has one.

    """

    converged: bool
    message: str
    iterations: int
    digits: float | None = None
    checks: Checks | None = None
    stabilisation: float | None = None
    residual: float = np.inf
    is_unheld: bool = False

    def with_notices(self, *notices: str | None) -> "Status":
        """Add sentences to the message, each once; None is no sentence."""
        return replace(self, message="; ".join(filter(None, dict.fromkeys((self.message, *notices)))))

    def with_stabilisation(self, fraction: float) -> "Status":
        """Take the fraction over; the message names it above `MAX_STABILISATION`."""
        message = self.message
        if fraction > MAX_STABILISATION:
            message += (
                f"; the stabilisation does {100.0 * fraction:.0f} % of the work: take a finer mesh or a higher order"
            )
        return replace(self, message=message, stabilisation=fraction)

    def with_digits(self, digits: float | None) -> "Status":
        """Take the digits over, not converged below `MIN_DIGITS`; the message names fewer than `FEW_DIGITS`."""
        if digits is None or digits >= FEW_DIGITS:
            return replace(self, digits=digits)
        count = "less than two digits are" if digits < MIN_DIGITS else f"about {digits:.0f} digits are"
        cause = "the body is slender, or its cells or moduli are of very different sizes"
        message = self.message + f"; {count} left by round-off: {cause}"
        return replace(self, converged=self.converged and digits >= MIN_DIGITS, message=message, digits=digits)


@dataclass(frozen=True)
class NewtonSettings:
    """Limits of the iteration.

    Parameters
    ----------
    max_iterations
        Iterations before giving up, those with further constraints for nodes that penetrate included; each correction
        of the forces has as many.
    tolerance
        Maximum residual of forces over the total force, and maximum violation of the contact law over the maximum
        displacement.

    """

    max_iterations: int = 30
    tolerance: float = 1e-11

    def __post_init__(self) -> None:
        check_integer("NewtonSettings", "max_iterations", self.max_iterations, 1, advice="leave it out")
        check_tolerance("NewtonSettings", self.tolerance)


@dataclass(frozen=True)
class Iteration:
    """What one iteration did.

    Parameters
    ----------
    change
        Maximum change of a displacement over the maximum displacement.
    residual
        Maximum residual over the total force, or violation of the contact law over the maximum displacement.
    n_active
        Number of constraints under force.
    changed
        Keys of the constraints that came under force, left it, changed their partner, or between stick and slip.
    correction
        Number of corrections of the forces before it.

    """

    change: float
    residual: float
    n_active: int
    changed: tuple[int, ...]
    correction: int = 0


def is_at_round_off(history: Sequence[Iteration]) -> bool:
    """Whether the residual is small and has not fallen in the last iterations, while no constraint changed."""
    last = [iteration for iteration in history[-STALLED_ITERATIONS - 1 :] if not iteration.changed]
    small = len(last) > STALLED_ITERATIONS and max(iteration.residual for iteration in last) <= ROUND_OFF
    return small and min(iteration.residual for iteration in last[1:]) > last[0].residual / 2.0


# --- Adaptive steps along a path (Moherdaui 2021, 3.5.7.1).


FEW_ITERATIONS = 8
MANY_ITERATIONS = 15
HELPFUL_DECREASE = 0.75
"""Iterations of a step relative to those of the last one that was halved for their number, up to which that helped."""
MAX_FAILURES = 5
"""Solutions of half a step each that fail, with no smaller residual than those before, after which halving has not
helped."""
SMALL_ERROR = 0.2
"""Error of a step, relative to its limit, below which the next one is longer: that of a step grows with its square."""


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
    error
        Maximum error of the nodal forces of a step, over the maximum total force of the path, where the solution
        depends on the path: each step is also taken as two halves, and made shorter until both agree. None: no control.

    """

    first: float = 1.0
    maximum: float = 1.0
    smallest: float = 1.0 / 1024.0
    error: float | None = None

    def __post_init__(self) -> None:
        sizes = self.smallest, self.first, self.maximum
        if not (are_finite(sizes, 3) and 0.0 < sizes[0] <= sizes[1] <= sizes[2] <= 1.0):
            raise InputError(
                "StepSettings(smallest={}, first={}, maximum={})".format(*map(short, sizes)),
                "0 < smallest <= first <= maximum <= 1",
                "for n equal steps take first=1/n, maximum=1/n",
            )
        if self.error is not None:
            check_positive("StepSettings", "error", self.error, "a number > 0", "take 0.01, or leave it out")


class PathState(Protocol):
    """What a path asks of the solutions on it: how they ended, and forces (n, 2) to compare."""

    @property
    def status(self) -> Status: ...  # noqa: D102
    @property
    def nodal_forces(self) -> Floats: ...  # noqa: D102


State = TypeVar("State", bound=PathState)


def follow(
    solve_at: Callable[[float, State | None], State],
    start: State | None,
    settings: StepSettings | None = None,
    accepted: Callable[[float, State], None] = lambda *_: None,
    uncertain: Callable[[State], float] = lambda _: 0.0,
) -> State:
    """Follow a solution along a path from 0 (excluded) to 1.

    A step that needed few iterations, and whose error is far below its limit, is followed by one of twice its length,
    one that needed many by one of half, as long as that lowers their number; a step that failed, or whose error is too
    large, is tried again at half its length from the last solution, until `MAX_FAILURES` have failed with no smaller
    residual than those before. Where nothing holds a motion none is halved.

    Parameters
    ----------
    solve_at
        Solves at a position of the path, starting from a neighbouring solution.
    start
        Solution at 0, if there is one.
    settings
        Sizes of the steps.
    accepted
        Called with each position and solution of the path.
    uncertain
        Sum of the nodal forces that a solution leaves open, as within the tolerance of its laws: no smaller error is
        asked of a step.

    Returns
    -------
    State
        The solution at 1, or the failed attempt where the smallest step did not converge.

    """
    settings = settings or StepSettings()
    state, position, size, at_halving = start, 0.0, settings.first, np.inf
    attempt: State | None = None
    maximum_total, failures, residual = 0.0, 0, 0.0
    while True:
        target = position + size
        if target > 1.0 - settings.smallest / 2.0:  # no sliver at the end
            target = 1.0
        size = target - position
        attempt = attempt or solve_at(target, state)
        reached, error = [(target, attempt)], 0.0
        if attempt.status.converged and settings.error is not None:
            middle = solve_at(position + size / 2.0, state)
            end = solve_at(target, middle) if middle.status.converged else middle
            maximum_total = max(maximum_total, _total(attempt))
            allowed = settings.error * maximum_total + uncertain(attempt) or 1.0
            error = _total(attempt, end) / allowed if end.status.converged else np.inf
            reached = [(position + size / 2.0, middle), (target, end)]
        shorter = reached[0][1] if settings.error is not None and reached[0][1].status.converged else None
        if not attempt.status.converged or (error > 1.0 and size / 2.0 >= settings.smallest):
            size = size / 2.0
            if not attempt.status.converged:
                failures += not attempt.status.residual < residual
                residual = attempt.status.residual if failures == 1 else min(residual, attempt.status.residual)
            if size < settings.smallest or failures == MAX_FAILURES or attempt.status.is_unheld:
                return attempt
            attempt = shorter if attempt.status.converged else None
            continue
        for reached_position, reached_state in reached:
            accepted(reached_position, reached_state)
        position, state, attempt, failures, residual = *reached[-1], None, 0, 0.0
        if target >= 1.0:
            return state
        if max(state.status.iterations for _, state in reached) <= FEW_ITERATIONS and error <= SMALL_ERROR:
            size = min(2.0 * size, settings.maximum)
        elif MANY_ITERATIONS < state.status.iterations <= HELPFUL_DECREASE * at_halving:
            size, at_halving = size / 2.0, state.status.iterations
        elif state.status.iterations <= MANY_ITERATIONS:
            at_halving = np.inf


def _total(state: PathState, other: PathState | None = None) -> float:
    """Sum of the nodal forces' norms, or of those of their differences from another state at the same position."""
    forces = state.nodal_forces if other is None else state.nodal_forces - other.nodal_forces
    return float(norms(forces).sum())
