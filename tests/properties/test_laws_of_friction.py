"""Laws of contact and friction of few constraints, beside the enumeration of all their states."""

import itertools

import numpy as np
import pytest

from flangeway.solve.active_set import DenseEquations, Laws, Motions
from flangeway.types import Floats

NO_BARRIER = (0.0, np.inf)


def enumerated(matrix: Floats, offset: Floats, friction: float) -> list[Floats]:
    """Forces of all states that satisfy the laws: each constraint is open, sticks, or slips to either side."""
    m, solutions = len(offset) // 2, []
    for states in itertools.product((None, 0, 1, -1), repeat=m):
        closed = [i for i in range(m) if states[i] is not None]
        rows = closed + [m + i for i in closed if states[i] == 0]
        unknowns = np.eye(2 * m)[:, rows]
        for column, i in enumerate(closed):
            unknowns[m + i, column] += friction * states[i]
        forces = unknowns @ np.linalg.solve((matrix @ unknowns)[rows], -offset[rows])
        gaps, slips = np.split(matrix @ forces + offset, 2)
        normal, tangential = np.split(forces, 2)
        right = (normal >= 0.0).all() and (np.abs(tangential) <= friction * normal * (1.0 + 1e-9)).all()
        right &= all(gaps[i] >= 0.0 for i in range(m) if i not in closed)
        if right and all(slips[i] * states[i] <= 0.0 for i in closed if states[i]):
            solutions.append(forces)
    return solutions


def bar(random: np.random.Generator, m: int) -> tuple[Floats, Floats]:
    """Compliance and offsets of points of the end of a bar, 10 to 20 heights long, that heat presses on a wall.

    Beam theory: with y from -1 to 1 across the bar, its end is displaced by axial forces, turned by their moments and
    by forces across, which bend it; each point sinks in besides. It has expanded across from its lower side.
    """
    y, length = np.linspace(-1.0, 1.0, m), random.uniform(20.0, 40.0)
    axial, turned, across = np.full((m, m), length), 3.0 * length * np.outer(y, y), np.full((m, m), length**3)
    coupled = -1.5 * length**2 * np.outer(y, np.ones(m))
    matrix = np.block([[axial + turned, coupled], [coupled.T, across]]) + random.uniform(0.1, 0.3) * np.eye(2 * m)
    return matrix, np.concatenate((np.full(m, -length), -random.uniform(0.1, 1.0) * (1.2 + y)))


@pytest.mark.parametrize("friction", [0.05, 0.2, 0.5])
def test_the_only_solution_is_the_one_that_is_found(friction: float) -> None:
    """Twenty ends of four points at each friction: where enumeration finds one solution, it is that one."""
    random, compared = np.random.default_rng(49), 0
    for _ in range(20):
        matrix, offset = bar(random, 4)
        solutions = enumerated(matrix, offset, friction)
        laws = Laws(np.full(4, friction), np.tile(NO_BARRIER, (4, 1)), matrix.diagonal())
        nothing = Motions(np.zeros((8, 0)), np.zeros((0, 8)), *(np.zeros(shape) for shape in ((0, 0), 0, 0, 0)))
        answer = DenseEquations(matrix, offset, laws, nothing).answer(np.zeros(8))
        if len(solutions) == 1:
            compared += 1
            assert answer is not None
            np.testing.assert_allclose(answer.forces, solutions[0], atol=1e-9 * np.abs(solutions[0]).max())
    assert compared > 10
