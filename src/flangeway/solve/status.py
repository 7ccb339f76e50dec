"""How a computation ended, and the limits and the history of Newton's method."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flangeway.checks import check_integer, check_tolerance

ROUND_OFF = 1e-7
"""Residual below which an iteration has converged if it no longer falls: where slender bodies bend, round-off of their
stiffness is above the tolerance."""

STALLED = 3
"""Iterations without a change of constraints, none of which halves the residual, after which it no longer falls."""


MIN_DIGITS, FEW_DIGITS = 2.0, 6.0
"""Decimal digits below which a solution is not accepted, and below which its message names them."""


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

    """

    converged: bool
    message: str
    iterations: int
    digits: float | None = None
    checks: Checks | None = None

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
    last = [each for each in history[-STALLED - 1 :] if not each.changed]
    small = len(last) > STALLED and max(each.residual for each in last) <= ROUND_OFF
    return small and min(each.residual for each in last[1:]) > last[0].residual / 2.0
