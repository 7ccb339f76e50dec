"""Matrices for the tests of the sparse machinery."""

from collections.abc import Callable

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

Triangle = tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]


def _lower(matrix: object) -> Triangle:
    whole = sp.csc_matrix(matrix)
    n = whole.shape[0]
    # a diagonal of ones and its removal keep explicit zeros there
    lower = (sp.tril(whole) + sp.diags(2.0 * abs(whole).max() + 1.0 + np.zeros(n))).tocsc()
    lower.sort_indices()
    indptr = lower.indptr.astype(np.int64)
    values = lower.data.copy()
    values[indptr[:-1]] = whole.diagonal()
    return indptr, lower.indices.astype(np.int32), values


@pytest.fixture(scope="session")
def lower() -> Callable[[object], Triangle]:
    """Lower triangle in compressed columns of a symmetric matrix, its diagonal complete."""
    return _lower


def _elastic_grid(n_across: int, n_up: int, *, held: bool) -> sp.csc_matrix:
    # two displacements a node: springs along the edges and one diagonal of each cell
    x, y = np.meshgrid(np.arange(n_across + 1), np.arange(n_up + 1), indexing="ij")
    number = x * (n_up + 1) + y
    pairs = [
        (number[:-1, :], number[1:, :], (1.0, 0.0)),
        (number[:, :-1], number[:, 1:], (0.0, 1.0)),
        (number[:-1, :-1], number[1:, 1:], (np.sqrt(0.5), np.sqrt(0.5))),
    ]
    n = 2 * number.size
    stiffness = sp.csc_matrix((n, n))
    for one_end, other_end, (c, s) in pairs:
        first, second = one_end.ravel(), other_end.ravel()
        row = np.arange(first.size)
        columns = np.concatenate([2 * first, 2 * first + 1, 2 * second, 2 * second + 1])
        weights = np.repeat([-c, -s, c, s], first.size)
        elongation = sp.csr_matrix((weights, (np.tile(row, 4), columns)), shape=(first.size, n))
        stiffness = stiffness + elongation.T @ elongation
    if held:
        base = np.concatenate([2 * number[:, 0], 2 * number[:, 0] + 1])
        ground = np.zeros(n)
        ground[base] = 1.0
        stiffness = stiffness + sp.diags(ground)
    return stiffness.tocsc()


@pytest.fixture(scope="session")
def elastic_grid() -> Callable[..., sp.csc_matrix]:
    """Stiffness of a braced grid of springs, unknowns 2 i and 2 i + 1 at node i."""
    return _elastic_grid
