"""Fields superposed from those under unit forces."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from flangeway.railway.positions import line_stresses
from flangeway.railway.positions.line_stresses import FieldColumns

Floats = NDArray[np.float64]

N_NODES, N_DOFS = 40, 60


class Counted:
    """A linear body that counts what it solves for."""

    def __init__(self) -> None:
        self.matrix = np.random.default_rng(1).normal(size=(2 * N_DOFS, 2 * N_NODES))
        self.n_solved = 0

    def __call__(self, loads: Floats) -> Floats:
        self.n_solved += len(loads)
        return (loads.reshape(len(loads), -1) @ self.matrix.T).reshape(len(loads), N_DOFS, 2)


@pytest.fixture
def ask() -> Callable[[FieldColumns, Counted, int, int], None]:
    """Ask for a number of fields under forces on five nodes from a given one on, and compare all of them."""
    rng = np.random.default_rng(2)

    def compared(columns: FieldColumns, solve: Counted, n_loads: int, first: int) -> None:
        loads = np.zeros((n_loads, N_NODES, 2))
        loads[:, first : first + 5] = rng.normal(size=(n_loads, 5, 2))
        wanted = [rng.choice(N_DOFS, rng.integers(1, 9), replace=False) for _ in range(n_loads)]
        before = solve.n_solved
        expected = solve(loads)
        solve.n_solved = before
        found = columns.at(loads, wanted, solve)
        assert len(found) == n_loads
        for field, dofs, values in zip(expected, wanted, found, strict=True):
            np.testing.assert_allclose(values, field[dofs], rtol=0.0, atol=1e-13 * np.abs(field).max())

    return compared


def test_fields_are_superposed(ask: Callable[[FieldColumns, Counted, int, int], None]) -> None:
    """Fields are those of the body, to round-off; the block of the forces is solved for once, then never again."""
    columns, solve = FieldColumns(N_NODES, N_DOFS), Counted()
    for n_loads, first, n_solved in ((4, 3, 32), (40, 3, 32), (1, 9, 32), (2, 14, 64), (2, 35, 80)):
        ask(columns, solve, n_loads, first)
        assert solve.n_solved == n_solved


def test_a_field_has_the_same_digits_whatever_was_asked_for_before() -> None:
    """The same load after others, in another order and among them gives the same numbers exactly."""
    rng, solve = np.random.default_rng(4), Counted()
    loads = np.zeros((6, N_NODES, 2))
    for load, first in zip(loads, (0, 7, 14, 21, 28, 34), strict=True):
        load[first : first + 6] = rng.normal(size=(6, 2))
    wanted = [rng.choice(N_DOFS, 7, replace=False) for _ in loads]
    one = FieldColumns(N_NODES, N_DOFS).at(loads, wanted, solve)
    columns = FieldColumns(N_NODES, N_DOFS)
    for number in (5, 2, 0, 4, 1, 3):
        (alone,) = columns.at(loads[[number]], [wanted[number]], solve)
        assert np.array_equal(alone, one[number])


def test_memory_is_bounded(
    ask: Callable[[FieldColumns, Counted, int, int], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With room for two of three blocks some are made again and fields stay right; without room each is solved for."""
    most = 8 * 2 * N_DOFS * 64
    monkeypatch.setattr(line_stresses, "MOST_BYTES", most)
    columns, solve = FieldColumns(N_NODES, N_DOFS), Counted()
    for first in (0, 20, 35, 35, 20, 0):
        ask(columns, solve, 30, first)
        assert columns.n_bytes <= most
    assert solve.n_solved == 32 + 32 + 16 + 32 + 32
    monkeypatch.setattr(line_stresses, "MOST_BYTES", 0)
    columns, solve = FieldColumns(N_NODES, N_DOFS), Counted()
    for _ in range(5):
        ask(columns, solve, 40, 0)
    assert solve.n_solved == 200
