"""Sparsity patterns of ragged cells, the Cholesky factor, and the factor of symmetric indefinite matrices."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from flangeway._core import Cholesky, FactorTooLargeError, Ldlt, NotPositiveDefiniteError, Pattern, SingularMatrixError


def int32(values):
    return np.array(values, dtype=np.int32)


def random_spd(rng, n, density):
    sparse = np.where(rng.random((n, n)) < density, rng.standard_normal((n, n)), 0.0)
    return sparse @ sparse.T + np.eye(n)


def schur_of(matrix, trailing):
    interior = np.setdiff1d(np.arange(len(matrix)), trailing)
    coupling = matrix[np.ix_(interior, trailing)]
    inner = np.linalg.solve(matrix[np.ix_(interior, interior)], coupling)
    return matrix[np.ix_(trailing, trailing)] - coupling.T @ inner


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 40),
    density=st.floats(0.0, 0.5),
    share=st.floats(0.0, 1.0),
)
def test_random_matrices_agree_with_dense_algebra(lower, seed, n, density, share):
    """Solution, Schur complement, condensation and recovery meet NumPy's for any split."""
    rng = np.random.default_rng(seed)
    matrix = random_spd(rng, n, density)
    trailing = rng.permutation(n)[: round(share * n)].astype(np.int32)
    factor = Cholesky(*lower(matrix), int32(rng.integers(0, n, n)), trailing)
    assert (factor.n, factor.n_trailing) == (n, trailing.size)
    schur = factor.schur()
    assert np.allclose(schur, schur_of(matrix, trailing), rtol=0, atol=1e-12 * abs(matrix).max())
    assert np.array_equal(schur, schur.T)
    rhs = rng.standard_normal((n, 3))
    solution = factor.solve(rhs)
    expected = np.linalg.solve(matrix, rhs)
    condition = np.linalg.cond(matrix)
    assert np.allclose(solution, expected, rtol=0, atol=1e-14 * condition * abs(expected).max())
    recovered = factor.recover(solution[trailing], rhs)
    assert np.allclose(recovered, solution, rtol=0, atol=1e-14 * condition * abs(expected).max())
    missed = schur @ solution[trailing] - factor.condense(rhs)
    assert np.all(abs(missed) < 1e-11 * condition)


def test_many_columns_equal_one_by_one(lower, elastic_grid):
    """A hundred columns at once, in any memory order, give what each gives alone."""
    matrix = elastic_grid(6, 5, held=True)
    n = matrix.shape[0]
    factor = Cholesky(*lower(matrix), int32(np.arange(n) // 2), int32([5, 4, 70]))
    rhs = np.random.default_rng(0).standard_normal((100, n)).T
    together = factor.solve(rhs)
    condensed = factor.condense(rhs)
    recovered = factor.recover(together[[5, 4, 70]], rhs)
    assert together.shape == (n, 100)
    for k in range(100):
        assert np.allclose(together[:, k], factor.solve(rhs[:, k]), rtol=1e-12, atol=1e-12)
        assert np.allclose(condensed[:, k], factor.condense(rhs[:, k]), rtol=1e-12, atol=1e-12)
    assert np.allclose(recovered, together, rtol=0, atol=1e-11)
    assert factor.solve(np.empty((n, 0))).shape == (n, 0)
    assert factor.condense(np.empty((n, 0))).shape == (3, 0)


def test_a_floating_body_is_condensed_and_held_by_its_trailing_unknowns(lower, elastic_grid):
    """Rigid motions of a floating body cost its surface no force, and holding it solves it."""
    matrix = elastic_grid(12, 9, held=False)
    n = matrix.shape[0]
    x, y = np.meshgrid(np.arange(13.0), np.arange(10.0), indexing="ij")
    trailing = int32(np.arange(n).reshape(13, 10, 2)[:, 9].ravel())
    factor = Cholesky(*lower(matrix), int32(np.arange(n) // 2), trailing)
    rigid = np.zeros((n, 3))
    rigid[0::2, 0], rigid[1::2, 1] = 1.0, 1.0
    rigid[0::2, 2], rigid[1::2, 2] = -y.ravel(), x.ravel()
    schur = factor.schur()
    assert np.allclose(schur @ rigid[trailing], 0.0, atol=1e-12)
    assert np.linalg.eigvalsh(schur)[3] > 1e-3
    recovered = factor.recover(rigid[trailing], np.zeros((n, 3)))
    assert np.allclose(recovered, rigid, atol=1e-11)
    with pytest.raises(NotPositiveDefiniteError) as error:
        factor.solve(np.ones(n))
    assert error.value.args[1] in trailing


def test_an_indefinite_schur_complement_is_given_but_not_solved(lower):
    """Only the interior must be positive definite, however negative the Schur complement is."""
    matrix = np.array([[1.0, 1000.0, 2.0], [1000.0, 1.0, 0.0], [2.0, 0.0, 0.0]])
    factor = Cholesky(*lower(matrix), int32([0, 1, 2]), int32([1, 2]))
    assert np.allclose(factor.schur(), schur_of(matrix, [1, 2]), rtol=1e-12)
    with pytest.raises(NotPositiveDefiniteError) as error:
        factor.solve(np.ones(3))
    assert error.value.args[1] == 1


def test_the_ordering_bounds_the_fill(lower, elastic_grid):
    """A grid of 5,000 nodes fills to less than 100 entries a column, a band to 100 and more."""
    matrix = elastic_grid(99, 49, held=True)
    n = matrix.shape[0]
    factor = Cholesky(*lower(matrix), int32(np.arange(n) // 2), int32([]))
    assert sp.tril(matrix).nnz < factor.factor_nonzeros < 100 * n


def test_an_unknown_without_stiffness_is_named():
    """A zero on the diagonal of the interior fails at that very unknown."""
    indptr, indices = np.arange(5, dtype=np.int64), int32([0, 1, 2, 3])
    with pytest.raises(NotPositiveDefiniteError, match="unknown 2 ") as error:
        Cholesky(indptr, indices, np.array([1.0, 1.0, 0.0, 1.0]), indices, int32([3]))
    assert error.value.args[1] == 2
    assert issubclass(NotPositiveDefiniteError, ArithmeticError)


def test_a_negative_pivot_is_named(lower):
    """An indefinite pair fails at one of its two unknowns, not at the sound one."""
    matrix = np.array([[4.0, 0.0, 0.0], [0.0, 1.0, 2.0], [0.0, 2.0, 1.0]])
    with pytest.raises(NotPositiveDefiniteError) as error:
        Cholesky(*lower(matrix), int32([0, 1, 2]), int32([]))
    assert error.value.args[1] in (1, 2)


@pytest.mark.parametrize("size", [2, 10, 60])
def test_a_body_that_nothing_holds_is_refused(lower, elastic_grid, size):
    """A floating body without trailing unknowns fails although rounding leaves pivots positive."""
    matrix = elastic_grid(size, size, held=False)
    n = matrix.shape[0]
    with pytest.raises(NotPositiveDefiniteError):
        Cholesky(*lower(matrix), int32(np.arange(n) // 2), int32([]))


def test_too_large_a_factor_is_refused():
    """A dense trailing block of more than 2^31 entries raises an error before any work."""
    n = 50_000
    unknowns = np.arange(n, dtype=np.int32)
    with pytest.raises(FactorTooLargeError, match="2\\^31"):
        Cholesky(np.arange(n + 1, dtype=np.int64), unknowns, np.ones(n), unknowns, unknowns)
    assert issubclass(FactorTooLargeError, MemoryError)


def test_bodies_are_factorised_side_by_side(lower, elastic_grid):
    """Factors made and used in several threads at once equal the one made alone, bit by bit."""
    matrix = elastic_grid(20, 15, held=True)
    n = matrix.shape[0]
    parts = lower(matrix)
    groups, trailing, rhs = int32(np.arange(n) // 2), int32(np.arange(0, n, 17)), np.ones(n)

    def work(_):
        factor = Cholesky(*parts, groups, trailing)
        return factor.schur(), factor.solve(rhs)

    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(work, range(8)))
    schur, solution = work(0)
    assert all(np.array_equal(s, schur) and np.array_equal(x, solution) for s, x in results)


VALID = {
    "indptr": np.array([0, 2, 3], dtype=np.int64),
    "indices": int32([0, 1, 1]),
    "values": np.array([2.0, -1.0, 2.0]),
    "groups": int32([0, 0]),
    "trailing": int32([1]),
}


def changed(**changes):
    return Cholesky(**(VALID | changes))


def indefinite(**changes):
    return Ldlt(**({name: VALID[name] for name in ("indptr", "indices", "values", "groups")} | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: changed(indptr=int32([0, 2, 3])), r"indptr must be int64 of shape \(n \+ 1,\), got int32"),
        (lambda: changed(indptr=np.array([0, 2, 2], dtype=np.int64)), "end with len"),
        (lambda: changed(indices=np.array([0, 1, 1])), "indices must be int32"),
        (lambda: changed(indices=int32([1, 0, 1])), "begin with its diagonal"),
        (lambda: changed(indices=int32([0, 5, 1])), "outside of"),
        (lambda: changed(indices=int32([0, 9, 1, 9, 1])[::2]), "contiguous"),
        (lambda: changed(values=np.array([2.0, -1.0, 2.0], dtype=np.float32)), "values must be float64"),
        (lambda: changed(values=np.array([2.0, np.inf, 2.0])), "values must be finite"),
        (lambda: changed(groups=int32([0])), "groups must have 2 entries, got 1"),
        (lambda: changed(trailing=int32([2])), r"unknowns in 0\.\.2, got 2"),
        (lambda: changed(trailing=int32([1, 1])), "1 twice"),
        (lambda: changed().recover(np.ones(2), np.ones(2)), "trailing_values must be"),
        (lambda: changed().recover(np.ones((1, 2)), np.ones((2, 3))), "equally many columns"),
        (lambda: changed().recover(np.ones(1), np.ones((2, 1))), "both be vectors"),
        (lambda: changed().recover(np.array([np.nan]), np.ones(2)), "trailing_values must be finite"),
        (lambda: changed().recover(np.ones(1), np.array([np.nan, 1.0])), "rhs must be finite"),
        (lambda: indefinite(groups=int32([0, 1, 2])), "groups must have 2 entries, got 3"),
        (lambda: indefinite(values=np.full(3, np.nan)), "values must be finite"),
        (lambda: indefinite().solve(np.ones(3)), r"shape \(2,\) or \(2, m\)"),
        (lambda: indefinite().solve(np.array([np.inf, 0.0])), "rhs must be finite"),
    ],
)
def test_wrong_arguments_raise_a_value_error(make, message):
    """Each argument with a wrong dtype, shape, order, structure or number is named, of the recovery as well."""
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("method", ["solve", "condense"])
@pytest.mark.parametrize(
    ("rhs", "message"),
    [
        (np.ones(3), r"rhs must be float64 of shape \(2,\) or \(2, m\), got float64 of shape \[3\]"),
        (np.ones(2, dtype=int), "got int64"),
        (np.array([1.0, np.nan]), "rhs must be finite"),
    ],
)
def test_wrong_right_hand_sides_raise_a_value_error(method, rhs, message):
    """A right-hand side with a wrong shape, dtype or a NaN is refused by name."""
    with pytest.raises(ValueError, match=message):
        getattr(changed(), method)(rhs)


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


def reference(n_dofs, batches, matrices):
    rows, columns, values = [np.arange(n_dofs)], [np.arange(n_dofs)], [np.zeros(n_dofs)]
    for dofs, matrix in zip(batches, matrices, strict=True):
        i = np.broadcast_to(dofs[:, None, :], matrix.shape).ravel()
        j = np.broadcast_to(dofs[None, :, :], matrix.shape).ravel()
        used = (j >= 0) & (i >= j)
        rows.append(i[used])
        columns.append(j[used])
        values.append(matrix.ravel()[used])
    entries = (np.concatenate(rows), np.concatenate(columns))
    summed = sp.coo_matrix((np.concatenate(values), entries), shape=(n_dofs, n_dofs)).tocsc()
    summed.sort_indices()
    return summed


def sample(rng, n_dofs, sizes):
    batches = [rng.integers(-1, n_dofs, size=size, dtype=np.int32) for size in sizes]
    matrices = []
    for n_local, n_cells in sizes:
        matrix = rng.standard_normal((n_local, n_local, n_cells))
        matrices.append(np.ascontiguousarray(matrix + matrix.transpose(1, 0, 2)))
    return batches, matrices


@given(
    seed=st.integers(0, 2**32 - 1),
    n_dofs=st.integers(1, 30),
    sizes=st.lists(st.tuples(st.integers(0, 7), st.integers(0, 9)), max_size=4),
)
def test_pattern_and_sum_equal_those_of_scipy(seed, n_dofs, sizes):
    """For any ragged cells, repeated and eliminated unknowns included, SciPy's sum is met."""
    batches, matrices = sample(np.random.default_rng(seed), n_dofs, sizes)
    pattern = Pattern(n_dofs, batches)
    expected = reference(n_dofs, batches, matrices)
    assert np.array_equal(pattern.indptr, expected.indptr)
    assert np.array_equal(pattern.indices, expected.indices)
    assert np.allclose(pattern.scatter(matrices), expected.data, rtol=1e-13, atol=1e-12)


def test_a_large_pattern_is_cut_into_parts_without_a_seam():
    """With tens of thousands of unknowns, gathered in several parts, SciPy's sum is met."""
    n_dofs = 30_000
    batches, matrices = sample(np.random.default_rng(3), n_dofs, [(6, 9_000), (4, 12_000)])
    pattern = Pattern(n_dofs, batches)
    expected = reference(n_dofs, batches, matrices)
    assert np.array_equal(pattern.indptr, expected.indptr)
    assert np.array_equal(pattern.indices, expected.indices)
    values = pattern.scatter(matrices)
    assert np.allclose(values, expected.data, rtol=1e-13, atol=1e-12)
    assert np.array_equal(values, pattern.scatter(matrices))


def test_the_arrays_outlive_the_pattern_and_cannot_be_written():
    """Index arrays stay valid after the pattern is gone, and refuse to be changed."""
    pattern = Pattern(4, [np.array([[0], [3]], dtype=np.int32)])
    indptr, indices = pattern.indptr, pattern.indices
    del pattern
    assert indptr.tolist() == [0, 2, 3, 4, 5]
    assert indices.tolist() == [0, 3, 1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        indices[0] = 1


def two_unknowns(cells=((0,), (1,)), dtype=np.int32):
    return Pattern(2, [np.array(cells, dtype=dtype)])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: two_unknowns([[0], [2]]), r"cell 0: unknown 2 is outside of 0\.\.2"),
        (lambda: two_unknowns(dtype=np.int64), r"int32 of shape .* got int64"),
        (lambda: Pattern(2, [np.zeros((2, 6), dtype=np.int32)[:, ::2]]), "contiguous"),
        (lambda: two_unknowns().scatter([]), "one array for each of the 1 batches, got 0"),
        (lambda: two_unknowns().scatter([np.zeros((2, 2, 2))]), r"\(2, 2, 1\), got float64 of shape \[2, 2, 2\]"),
        (lambda: two_unknowns().scatter([np.zeros((2, 2, 2))[:, :, :1]]), "contiguous"),
        (lambda: two_unknowns().scatter([np.full((2, 2, 1), np.nan)]), "finite"),
    ],
)
def test_wrong_cells_and_matrices_are_refused(make, message):
    """A wrong number, count, dtype, shape or memory order and a NaN raise a ValueError that names it."""
    with pytest.raises(ValueError, match=message):
        make()
