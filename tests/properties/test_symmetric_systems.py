"""Random sparse symmetric systems beside dense solutions: every kind is solved, and singular ones are refused."""

import numpy as np
import pytest
import scipy.sparse as sp

from benchmarks.symmetric import REGULAR, SINGULAR, System
from flangeway.errors import InputError
from flangeway.forms import Factor, solve


def test_random_symmetric_systems_are_solved_or_refused_as_their_condition_asks():
    """To 1e-8 up to a condition of 1e8 and refused only above 1e12, of which the singular ones must be: 200 systems."""
    systems = [System.of(number) for number in range(1000, 1200)]
    assert {system.kind for system in systems} == REGULAR.keys() | SINGULAR.keys()
    wrong = {number: outcome for number, system in enumerate(systems) if "wrong" in (outcome := system.outcome())}
    assert wrong == {}


SMALL = [
    [[0, 1, 0], [1, 0, 1], [0, 1, 1]], [[0, 1], [1, 0]], [[0, 0, 2], [0, 3, 0], [2, 0, 0]],
    [[1, 2, 0], [2, 1, 2], [0, 2, 1]],
]  # fmt: skip


@pytest.mark.parametrize("matrix", SMALL)
def test_small_indefinite_matrices_have_exact_solutions(matrix):
    """Integer matrices with zeros on the diagonal: the vector that the load was computed from."""
    exact = np.arange(1.0, len(matrix) + 1.0)
    np.testing.assert_allclose(
        solve(sp.csr_array(np.array(matrix, float)), np.array(matrix) @ exact), exact, rtol=1e-14
    )


@pytest.mark.parametrize(
    "matrix", [[[0, 0], [0, 0]], [[1, 1], [1, 1]], [[0, 1, 0], [1, 0, 1], [0, 1, 0]], [[1, -1], [-1, 1]]]
)
def test_small_singular_matrices_are_refused(matrix):
    """Exactly singular matrices, an empty one too."""
    with pytest.raises(InputError, match="singular"):
        solve(sp.csr_array(np.array(matrix, float)), np.ones(len(matrix)))


def test_an_unstable_factor_is_replaced_and_named():
    """A chain without a diagonal has no stable pivot in blocks of one: LU solves it, also several loads and twice."""
    chain = sp.diags_array([np.ones(39), np.ones(39)], offsets=[-1, 1]).tocsr()
    factor = Factor(chain)
    exact = np.random.default_rng(0).standard_normal(40)
    for _ in range(2):
        np.testing.assert_allclose(factor.solve(chain @ exact), exact, rtol=1e-12, atol=1e-12)
    assert factor.kind == "LU"
