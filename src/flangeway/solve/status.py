"""How a computation ended."""

from dataclasses import dataclass

from flangeway.errors import NotConvergedError


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

    def require(self) -> None:
        """Raise `NotConvergedError` unless converged."""
        if not self.converged:
            raise NotConvergedError(self.message)
