"""Linear complementarity: ``s = M p + q``, ``p >= 0``, ``s >= 0``, ``p . s = 0``."""

import numpy as np
from numpy.typing import NDArray

from flangeway.types import Floats

MAX_CHANGES = 60


def solve(matrix: Floats, offset: Floats, active: NDArray[np.bool_]) -> Floats | None:
    """Solve a complementarity problem by a primal-dual active set, from a guess of where p > 0, shape (n,).

    Each round solves the equations of the active set and moves every unknown of wrong sign (Hintermueller, Ito and
    Kunisch, 2002, SIAM J. Optim. 13). If the rounds cycle and the matrix (n, n) is positive definite, the equivalent
    non-negative least squares problem is solved by Lawson and Hanson's finite method. Returns p, shape (n,), or None.
    """
    active = active.copy()
    for _ in range(MAX_CHANGES):
        pressure = np.zeros(len(offset))
        if active.any():
            pressure[active] = equations(matrix[np.ix_(active, active)], -offset[active])
        slack = matrix @ pressure + offset
        changed = np.where(active, pressure > 0.0, slack < 0.0)
        if (changed == active).all():
            return pressure
        active = changed
    return _least_squares(matrix, offset)


def equations(matrix: Floats, right: Floats) -> Floats:
    """Solution of equations, the least one where constraints repeat each other.

    NumPy's solver and not SciPy's: each has its own threads, and where both wake in turn they wait for each other.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)


def _least_squares(matrix: Floats, offset: Floats) -> Floats | None:
    """With ``M = L L^T``, p minimises ``|L^T p + L^-1 q|`` over p >= 0."""
    from scipy.optimize import nnls  # noqa: PLC0415 (slow to import, seldom needed)

    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return None
    target = -np.linalg.solve(lower, offset)
    pressure: Floats = nnls(lower.T, target)[0]
    return pressure
