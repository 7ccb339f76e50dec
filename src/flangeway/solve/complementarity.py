"""Linear complementarity: ``s = M p + q``, ``p >= 0``, ``s >= 0``, ``p . s = 0``."""

import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, LinAlgWarning, cho_factor, lstsq, solve_triangular
from scipy.linalg import solve as solve_dense

Floats = NDArray[np.float64]

MAX_CHANGES = 60


def solve(matrix: Floats, offset: Floats, active: NDArray[np.bool_]) -> Floats | None:
    """Solve a complementarity problem by a primal-dual active set.

    Each round solves the equations of the active set and moves every unknown of wrong sign (Hintermueller, Ito and
    Kunisch, 2002, SIAM J. Optim. 13). If the rounds cycle and the matrix is positive definite, the equivalent
    non-negative least squares problem is solved by Lawson and Hanson's finite method.

    Parameters
    ----------
    matrix
        Symmetric matrix M, shape (n, n).
    offset
        Vector q, shape (n,).
    active
        First guess of where p > 0, shape (n,).

    Returns
    -------
    Floats or None
        The solution p, shape (n,); None if none was found.

    """
    active = active.copy()
    for _ in range(MAX_CHANGES):
        pressure = np.zeros(len(offset))
        if active.any():
            pressure[active] = _equations(matrix[np.ix_(active, active)], -offset[active])
        slack = matrix @ pressure + offset
        changed = np.where(active, pressure > 0.0, slack < 0.0)
        if (changed == active).all():
            return pressure
        active = changed
    return _least_squares(matrix, offset)


def _equations(matrix: Floats, right: Floats) -> Floats:
    """Solution of symmetric equations, the least one where constraints repeat each other."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", LinAlgWarning)
        try:
            return np.asarray(solve_dense(matrix, right, assume_a="sym"))
        except (LinAlgError, LinAlgWarning):
            return np.asarray(lstsq(matrix, right)[0])


def _least_squares(matrix: Floats, offset: Floats) -> Floats | None:
    """With ``M = L L^T``, p minimises ``|L^T p + L^-1 q|`` over p >= 0."""
    from scipy.optimize import nnls  # noqa: PLC0415 (slow to import, seldom needed)

    try:
        lower = np.tril(cho_factor(matrix, lower=True)[0])
    except LinAlgError:
        return None
    target = -solve_triangular(lower, offset, lower=True)
    pressure: Floats = nnls(lower.T, target)[0]
    return pressure
