"""Dense algebra on many small symmetric matrices, element index last."""

import numpy as np

from flangeway.types import Floats


def cholesky(matrices: Floats) -> Floats:
    """Lower Cholesky factors of matrices of shape (n, n, n_cells), NaN where one is not positive definite."""
    n = matrices.shape[0]
    factor = np.zeros_like(matrices)
    for j in range(n):
        row = factor[j, :j]
        pivot = matrices[j, j] - np.einsum("ke,ke->e", row, row)
        factor[j, j] = np.sqrt(np.where(pivot > 0.0, pivot, np.nan))
        if j + 1 < n:
            below = matrices[j + 1 :, j] - np.einsum("ike,ke->ie", factor[j + 1 :, :j], row)
            factor[j + 1 :, j] = below / factor[j, j]
    return factor


def solve(matrices: Floats, rhs: Floats, out: Floats | None = None) -> Floats:
    """Solve systems with symmetric positive definite matrices by Cholesky's method.

    Parameters
    ----------
    matrices
        Shape (n, n, n_cells).
    rhs
        Right-hand sides, shape (n, m, n_cells).
    out
        Where the solutions go, shape (n, m, n_cells), if not into a new array.

    Returns
    -------
    Floats
        Shape (n, m, n_cells).

    """
    factor = cholesky(matrices)
    return solve_upper(factor, solve_lower(factor, rhs, out), out)


def _room(factor: Floats, rhs: Floats, out: Floats | None) -> Floats:
    """Array for solutions (n, m, n_cells)."""
    return np.empty((*rhs.shape[:-1], factor.shape[-1])) if out is None else out


def solve_lower(factor: Floats, rhs: Floats, out: Floats | None = None) -> Floats:
    """Solve ``L x = rhs`` with factors of `cholesky`; arguments and result as of `solve`."""
    x = _room(factor, rhs, out)
    x[:] = rhs
    for j in range(len(factor)):
        if j:
            x[j] -= np.einsum("ke,kme->me", factor[j, :j], x[:j])
        x[j] /= factor[j, j]
    return x


def solve_upper(factor: Floats, rhs: Floats, out: Floats | None = None) -> Floats:
    """Solve ``L^T x = rhs``, in the same way; `out` may be `rhs`."""
    x = _room(factor, rhs, out)
    if x is not rhs:
        x[:] = rhs
    for j in reversed(range(len(factor))):
        if j + 1 < len(factor):
            x[j] -= np.einsum("ke,kme->me", factor[j + 1 :, j], x[j + 1 :])
        x[j] /= factor[j, j]
    return x


def cross(a: Floats, b: Floats) -> Floats:
    """Component out of the plane of the cross products of vectors (..., 2, n_cells), shape (..., n_cells)."""
    return a[..., 0, :] * b[..., 1, :] - a[..., 1, :] * b[..., 0, :]


def turned_right(vectors: Floats) -> Floats:
    """Vectors (..., 2, n_cells) turned clockwise by a right angle: outwards, of edges with their cell on the left."""
    return np.stack((vectors[..., 1, :], -vectors[..., 0, :]), axis=-2)


def symmetric_product(left: Floats, right: Floats) -> Floats:
    """Products ``left^T right`` that are known to be symmetric, at half the cost.

    Parameters
    ----------
    left, right
        Shape (m, n, n_cells).

    Returns
    -------
    Floats
        Shape (n, n, n_cells).

    """
    n = left.shape[1]
    product = np.empty((n, n, left.shape[2]))
    for i in range(n):
        row = product[i, : i + 1]
        np.einsum("ae,aje->je", left[:, i], right[:, : i + 1], out=row)
        product[:i, i] = row[:i]
    return product
