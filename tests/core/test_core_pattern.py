"""The sparsity pattern of ragged cells and the sum of their matrices."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from flangeway._core import Pattern


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
