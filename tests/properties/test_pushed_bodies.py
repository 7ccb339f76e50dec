"""Random elastic bodies pushed by loads onto stops: `benchmarks.pushed` without the finest steps."""

import pytest

from benchmarks.pushed import outcome


@pytest.mark.parametrize(
    "number", [0, 5, 123, 242, *(pytest.param(n, marks=pytest.mark.ci) for n in (3, 8, *range(9, 25)))]
)
def test_a_body_pushed_onto_stops_has_the_same_forces_in_one_and_in_five_steps(number: int) -> None:
    """Equilibrium of each body, no overlap, forces within the cone and equal in 1 and 5 steps, or not converged."""
    result = outcome(number, (1, 5))
    assert result.wrong == ()
    may_fail = {3, *range(9, 25)}  # the body of row 3 turns by 1.1 rad, where it is not linear
    assert number in may_fail or all(result.converged), result.messages
