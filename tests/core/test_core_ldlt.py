"""The factor of symmetric indefinite matrices."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from flangeway._core import Ldlt, SingularMatrixError


def int32(values):
    return np.array(values, dtype=np.int32)


def singles(n):
    return np.arange(n, dtype=np.int32)


def test_a_pair_of_zeros_on_the_diagonal_is_solved(lower):
    """The exchange matrix, which has no pivot of its own, exchanges its right-hand side."""
    factor = Ldlt(*lower(np.array([[0.0, 1.0], [1.0, 0.0]])), singles(2))
    assert factor.n == 2
    assert factor.solve(np.array([3.0, 5.0])).tolist() == [5.0, 3.0]


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 30), n_ties=st.integers(0, 8))
def test_saddle_points_agree_with_dense_algebra(lower, seed, n, n_ties):
    """A positive definite block tied by full-rank constraints is solved as by NumPy."""
    rng = np.random.default_rng(seed)
    n_ties = min(n_ties, n)
    root = rng.standard_normal((n, n)) * (rng.random((n, n)) < 0.3)
    ties = np.eye(n_ties, n) + 0.1 * rng.standard_normal((n_ties, n))
    matrix = np.block([[root @ root.T + np.eye(n), ties.T], [ties, np.zeros((n_ties, n_ties))]])
    shuffle = rng.permutation(n + n_ties)
    matrix = matrix[np.ix_(shuffle, shuffle)]
    rhs = rng.standard_normal((n + n_ties, 2))
    solution = Ldlt(*lower(matrix), singles(n + n_ties)).solve(rhs)
    expected = np.linalg.solve(matrix, rhs)
    bound = 1e-13 * np.linalg.cond(matrix) * abs(expected).max()
    assert np.allclose(solution, expected, rtol=0, atol=bound)


@pytest.mark.parametrize("size", [3, 10, 30])
@pytest.mark.parametrize("modulus", [1.0, 2e11])
def test_multipliers_hold_a_floating_body_in_any_units(lower, elastic_grid, size, modulus):
    """A singular stiffness, in any units, held by multipliers alone is solved to 1e-10."""
    stiffness = modulus * elastic_grid(size, size, held=False)
    n = stiffness.shape[0]
    held = np.r_[np.arange(size + 1) * 2 * (size + 1) + 1, 0]
    ties = sp.csr_matrix((np.ones(held.size), (np.arange(held.size), held)), shape=(held.size, n))
    matrix = sp.bmat([[stiffness, ties.T], [ties, None]], format="csc")
    groups = int32(np.r_[np.arange(n) // 2, n + np.arange(held.size)])
    factor = Ldlt(*lower(matrix), groups)
    exact = np.r_[np.sin(np.arange(n)), modulus * np.cos(np.arange(held.size))]
    solution = factor.solve(matrix @ exact)
    assert np.allclose(solution[:n], exact[:n], rtol=0, atol=1e-10)
    assert np.allclose(solution[n:], exact[n:], rtol=0, atol=1e-10 * modulus)


def test_a_shifted_grid_agrees_with_dense_algebra(lower, elastic_grid):
    """A stiffness shifted below zero in part is solved for many columns, in any memory order."""
    matrix = elastic_grid(9, 7, held=True)
    n = matrix.shape[0]
    matrix = (matrix - 1.234 * sp.eye(n)).tocsc()
    eigenvalues = np.linalg.eigvalsh(matrix.toarray())
    assert eigenvalues[0] < 0 < eigenvalues[-1]
    rhs = np.random.default_rng(0).standard_normal((80, n)).T
    factor = Ldlt(*lower(matrix), int32(np.arange(n) // 2))
    solution = factor.solve(rhs)
    assert np.allclose(matrix @ solution, rhs, atol=1e-12)
    assert np.allclose(factor.solve(rhs[:, 70]), solution[:, 70], rtol=1e-10, atol=1e-12)
    assert factor.solve(np.zeros((n, 0))).shape == (n, 0)
    assert not factor.solve(np.zeros(n)).any()


TIE_GIVEN_TWICE = np.array([[2.0, 1.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@pytest.mark.parametrize("size", [None, 2, 10, 60])
def test_singular_matrices_have_no_solution(lower, elastic_grid, size):
    """A stiffness that nothing holds, and one with a tie given twice, are refused, not solved."""
    matrix = TIE_GIVEN_TWICE if size is None else elastic_grid(size, size, held=False)
    n = matrix.shape[0]
    factor = Ldlt(*lower(matrix), singles(n) if size is None else int32(np.arange(n) // 2))
    with pytest.raises(SingularMatrixError, match="singular"):
        factor.solve(np.random.default_rng(0).standard_normal(n))
    assert issubclass(SingularMatrixError, ArithmeticError)


def test_wrong_arguments_raise_a_value_error(lower):
    """A wrong count of groups, a wrong right-hand side and a NaN are refused by name."""
    parts = lower(np.array([[1.0, 2.0], [2.0, 1.0]]))
    with pytest.raises(ValueError, match="groups must have 2 entries, got 3"):
        Ldlt(*parts, singles(3))
    with pytest.raises(ValueError, match="values must be finite"):
        Ldlt(parts[0], parts[1], parts[2] * np.nan, singles(2))
    factor = Ldlt(*parts, singles(2))
    with pytest.raises(ValueError, match=r"shape \(2,\) or \(2, m\)"):
        factor.solve(np.ones(3))
    with pytest.raises(ValueError, match="rhs must be finite"):
        factor.solve(np.array([np.inf, 0.0]))
