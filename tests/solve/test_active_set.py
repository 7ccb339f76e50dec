"""Forces by the laws of contact and friction of linear problems."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.solve.active_set import Answer, DenseEquations, Laws, Motions, solve
from flangeway.types import Floats


def motions(by_motion: Floats, residual: Floats, stiffness: Floats | None = None) -> Motions:
    """Motions of one part of the size 1, without friction."""
    n = by_motion.shape[1]
    stiffness = np.zeros((n, n)) if stiffness is None else stiffness
    return Motions(by_motion, by_motion.T, stiffness, residual, np.zeros(n, dtype=np.int64), np.ones(n))


def forces_of(
    matrix: Floats,
    offset: Floats,
    mu: Floats | None = None,
    barriers: Floats | None = None,
    guess: Floats | None = None,
) -> Floats | None:
    """Forces of constraints with coefficients of friction (m,), or without friction, by the law of each."""
    m = len(offset) if mu is None else len(mu)
    none = np.column_stack((np.zeros(m), np.full(m, np.inf)))
    laws = Laws(np.zeros(m) if mu is None else mu, none if barriers is None else barriers, matrix.diagonal())
    held = motions(np.zeros((len(offset), 0)), np.zeros(0))
    answer = solve(laws, DenseEquations(matrix, offset, laws, held), np.zeros(len(offset)) if guess is None else guess)
    return None if answer is None else answer.forces


def test_an_unsolvable_problem_has_no_solution() -> None:
    """An indefinite matrix without a solution gives None, not a wrong answer."""
    assert forces_of(np.array([[-1.0]]), np.array([-1.0])) is None


def test_repeated_constraints_share_one_force() -> None:
    """Two equal constraints under load have a solution whose forces add up to that of one of them."""
    matrix = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    forces = forces_of(matrix, np.array([-1.0, -1.0, 4.0]), guess=np.array([1.0, 1.0, 0.0]))
    assert forces is not None
    assert forces[:2].sum() == pytest.approx(1.0)
    assert (forces >= 0.0).all()
    assert forces[2] == 0.0


@given(seed=st.integers(0, 10**6), n=st.integers(1, 25), mu=st.floats(0.0, 1.0), closed=st.booleans())
def test_forces_satisfy_coulombs_law(seed: int, n: int, mu: float, closed: bool) -> None:
    """From any guess, complementarity of forces and gaps, and friction against slip at its limit: random matrices."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2 * n, 2 * n))
    matrix = root @ root.T / n + np.eye(2 * n)
    matrix, offset = matrix + 1e-3 * rng.normal(size=matrix.shape), rng.normal(size=2 * n)
    forces = forces_of(matrix, offset, np.full(n, mu), guess=np.repeat([float(closed), 0.0], n))
    assert forces is not None
    gaps, slips = np.split(matrix @ forces + offset, 2)
    normal, tangential = np.split(forces, 2)
    assert normal.min() >= 0.0
    assert gaps.min() > -1e-9
    assert np.abs(normal * gaps).max() < 1e-9
    limit = mu * normal
    assert (np.abs(tangential) <= limit + 1e-9).all()
    assert np.abs(tangential - np.clip(tangential - slips, -limit, limit)).max() < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_forces_satisfy_the_law_of_a_barrier(seed: int) -> None:
    """A force leaves the gap w / (p + w / r), none leaves at least the reach; a small w is complementarity."""
    rng = np.random.default_rng(seed)
    n = 30
    factor = rng.standard_normal((n, n))
    matrix, offset = factor @ factor.T + 0.01 * np.eye(n), rng.standard_normal(n)
    products, reaches = 10.0 ** rng.uniform(-6.0, -1.0, n), rng.uniform(0.1, 2.0, n)
    forces = forces_of(matrix, offset, barriers=np.column_stack((products, reaches)))
    assert forces is not None
    gaps, closed = matrix @ forces + offset, forces > 0.0
    # gaps, not forces, are compared: a small gap is a difference of large numbers
    np.testing.assert_allclose(gaps[closed], (products / (forces + products / reaches))[closed], atol=1e-10)
    assert (gaps[~closed] >= reaches[~closed] * (1.0 - 1e-10)).all()
    limit, near = (
        forces_of(matrix, offset, barriers=each) for each in (None, np.column_stack((np.full(n, 1e-12), reaches)))
    )
    assert limit is not None
    assert near == pytest.approx(limit, abs=1e-5 * np.abs(limit).max())


def test_a_motion_takes_the_forces_to_its_load() -> None:
    """Two springs of stiffness 1 and 3 under a load of 2 on a common motion carry 0.5 and 1.5."""
    matrix = np.diag([1.0, 1.0 / 3.0])
    moved = motions(np.array([[-1.0], [-1.0]]), np.array([2.0]))
    laws = Laws(np.zeros(2), np.column_stack((np.zeros(2), np.full(2, np.inf))), matrix.diagonal())
    answer = solve(laws, DenseEquations(matrix, np.zeros(2), laws, moved), np.ones(2))
    assert answer is not None
    np.testing.assert_allclose(answer.forces, (0.5, 1.5), rtol=1e-12)
    np.testing.assert_allclose(answer.motions, 0.5, rtol=1e-12)


def test_neutral_and_loose_motions_are_seen() -> None:
    """A motion without stiffness and force is neutral; without stiffness but under force nothing holds it."""
    matrix = np.eye(1)
    laws = Laws(np.zeros(1), np.array([[0.0, np.inf]]), matrix.diagonal())
    for load, loose in ((0.0, False), (5.0, True)):
        moved = motions(np.array([[-1.0, 0.0]]), np.array([2.0, load]))
        equations = DenseEquations(matrix, np.zeros(1), laws, moved)
        left, right, is_loose = equations.free_motions(Answer(np.array([2.0]), np.zeros(1), np.array([2.0, 0.0])))
        assert is_loose == loose
        assert left.shape == right.shape == (2, 0 if loose else 1)
        if not loose:
            np.testing.assert_allclose(np.abs(right[:, 0] / np.linalg.norm(right)), (0.0, 1.0), atol=1e-12)
