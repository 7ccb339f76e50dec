"""Linear complementarity problems."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.solve import complementarity


def problem(seed: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(n, n))
    return factor @ factor.T + 0.1 * np.eye(n), rng.normal(size=n)


@given(seed=st.integers(0, 10_000), n=st.integers(1, 12), guess=st.booleans())
def test_conditions_hold(seed: int, n: int, guess: bool) -> None:
    """P >= 0, s = M p + q >= 0 and p s = 0, whatever the first guess."""
    matrix, offset = problem(seed, n)
    p = complementarity.solve(matrix, offset, np.full(n, guess))
    assert p is not None
    s = matrix @ p + offset
    assert p.min() >= 0.0
    assert s.min() > -1e-8
    assert np.abs(p * s).max() < 1e-8


@pytest.mark.parametrize("seed", range(20))
def test_enumeration_agrees(seed: int) -> None:
    """The only active set of all 2^5 that satisfies the conditions is the one found."""
    matrix, offset = problem(seed, 5)
    p = complementarity.solve(matrix, offset, offset < 0.0)
    solutions = []
    for active in itertools.product([False, True], repeat=5):
        mask = np.array(active)
        trial = np.zeros(5)
        trial[mask] = np.linalg.solve(matrix[np.ix_(mask, mask)], -offset[mask])
        if trial.min() >= 0.0 and (matrix @ trial + offset)[~mask].min(initial=0.0) >= 0.0:
            solutions.append(trial)
    assert len(solutions) == 1
    assert p == pytest.approx(solutions[0], abs=1e-10)


def test_cycling_active_sets_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """With no round of the active set allowed, non-negative least squares gives the same solution."""
    matrix, offset = problem(3, 8)
    expected = complementarity.solve(matrix, offset, offset < 0.0)
    monkeypatch.setattr(complementarity, "MAX_CHANGES", 0)
    assert complementarity.solve(matrix, offset, offset < 0.0) == pytest.approx(expected, abs=1e-9)


def test_an_unsolvable_problem_has_no_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """An indefinite matrix without a solution gives None, not a wrong answer."""
    assert complementarity.solve(np.array([[-1.0]]), np.array([-1.0]), np.array([False])) is None


def test_repeated_constraints_share_one_force() -> None:
    """Two equal constraints under load have a solution whose forces add up to that of one of them."""
    matrix = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    forces = complementarity.solve(matrix, np.array([-1.0, -1.0, 4.0]), np.array([True, True, False]))
    assert forces is not None
    assert forces[:2].sum() == pytest.approx(1.0)
    assert (forces >= 0.0).all()
    assert forces[2] == 0.0
