"""How a computation ended."""

from dataclasses import dataclass


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

    """

    converged: bool
    message: str
    iterations: int
