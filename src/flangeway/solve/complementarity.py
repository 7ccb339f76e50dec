"""Linear complementarity: ``s = M p + q``, ``p >= 0``, ``s >= 0``, ``p . s = 0``."""

import numpy as np
from numpy.typing import NDArray

from flangeway.types import Floats

MAX_CHANGES = 60

MAX_STEPS = 200
"""Steps of the interior-point method for one active set."""

SHRINK = 0.1
"""Factor of the mean product of force and gap that the next step aims at, until it is the barrier's own."""

EXACT = 1e-13
"""Misfit of gaps over the maximum one, and of products over themselves, at which they are found."""

TO_BOUNDARY = 0.995
"""Share of the way to a zero force or gap that a step may go."""


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


def standoffs(forces: Floats, products: Floats, reaches: Floats) -> Floats:
    """Gaps at which forces (m,) act by a barrier ``p = w (1 / g - 1 / r)``; see `solve_barrier`."""
    shifts = products / reaches
    loaded = products > 0.0
    return np.divide(products, forces + shifts, out=np.zeros(len(forces)), where=loaded)


def solve_barrier(matrix: Floats, offset: Floats, products: Floats, reaches: Floats) -> Floats | None:
    """Solve ``s = M p + q > 0``, ``p = max(0, w / s - w / r)`` with products w > 0 and reaches r, all shape (n,).

    Forces of gaps below the reach are found by a primal-dual interior-point method from any start (S. J. Wright, 1997,
    Primal-dual interior-point methods, SIAM), the set of them as in `solve`. Returns p, shape (n,), or None.
    """
    active = offset < reaches
    for _ in range(MAX_CHANGES):
        forces = np.zeros(len(offset))
        if active.any():
            inner = matrix[np.ix_(active, active)], offset[active], products[active], (products / reaches)[active]
            found = _interior(*inner)
            if found is None:
                return None
            forces[active] = found
        gaps = matrix @ forces + offset
        changed = np.where(active, forces > 0.0, gaps < reaches)
        if (changed == active).all():
            return forces
        active = changed
    return None


def _interior(matrix: Floats, offset: Floats, products: Floats, shifts: Floats) -> Floats | None:
    """Solve ``s = M p + q``, ``(p + c) s = w`` with ``p + c > 0`` and ``s > 0``."""
    gaps = np.maximum(offset, np.abs(offset).max())
    raised = products / gaps  # p + c
    scale = float(np.abs(offset).max())
    for _ in range(MAX_STEPS):
        misfit = matrix @ (raised - shifts) + offset - gaps
        apart = raised * gaps - products
        if np.abs(misfit).max() <= EXACT * scale and (np.abs(apart) <= EXACT * products).all():
            return raised - shifts
        aims = np.maximum(products, SHRINK * float((raised * gaps / products).mean()) * products)
        try:
            step = np.linalg.solve(matrix + np.diag(gaps / raised), aims / raised - gaps - misfit)
        except np.linalg.LinAlgError:
            return None
        opened = (aims - gaps * step) / raised - gaps
        shrink = np.concatenate((-step / raised, -opened / gaps)).max()
        share = min(1.0, TO_BOUNDARY / shrink) if shrink > 0.0 else 1.0
        raised, gaps = raised + share * step, gaps + share * opened
    return None
