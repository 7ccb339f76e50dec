"""Choice of the cells to refine from their errors."""

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, is_finite, refused
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray


def doerfler_marking(cell_errors: ArrayLike, share: float = 0.5) -> IntArray:
    """Return the fewest cells that hold a share of the sum of the squared errors, in rising order.

    Source: Doerfler, 1996, SIAM J. Numer. Anal. 33, with the share of the squares (theta squared there).

    Parameters
    ----------
    cell_errors
        Estimated error of each cell (n_cells,), zero or more.
    share
        Between 0 and 1: a small one refines few cells a step, 1 all cells with an error.

    Raises
    ------
    InputError
        If an error is negative or not finite, or the share is out of its range.

    """
    errors = as_numbers("cell errors", cell_errors)
    if errors.ndim != 1 or not len(errors) or not (np.isfinite(errors).all() and (errors >= 0.0).all()):
        raise InputError(
            f"cell errors of shape {errors.shape}, or with one below zero or not finite",
            "one number for each cell, zero or more",
            "look at the estimate",
        )
    if not (is_finite(share) and 0.0 < share <= 1.0):
        raise refused("doerfler_marking", "share", share, "a number above 0, up to 1", "leave 0.5")
    order = np.argsort(-errors, kind="stable")
    sums = np.cumsum(errors[order] ** 2)
    if not sums[-1] > 0.0:
        return np.zeros(0, dtype=np.int32)
    n_marked = int(np.searchsorted(sums, share * sums[-1] * (1.0 - 1e-12))) + 1
    n_marked = min(n_marked, int(np.count_nonzero(errors)))
    return np.sort(order[:n_marked]).astype(np.int32)
