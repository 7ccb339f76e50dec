"""Random polygons pressed on each other by motions and loads: what converged is right, by a judge of its own."""

from dataclasses import replace

import pytest

from benchmarks.polygons import Case, faults, outcome


def in_ci(*numbers: int) -> list:
    """Cases that take a second or more each."""
    return [pytest.param(number, marks=pytest.mark.ci) for number in numbers]


@pytest.mark.parametrize("number", [3, 5, *in_ci(1, 6, 9, 10)])
def test_what_converged_is_right(number: int) -> None:
    """Bodies do not overlap, forces balance and carry the load, nothing pulls, friction dissipates."""
    assert not outcome(number).wrong


def test_the_judge_sees_a_wrong_solution() -> None:
    """To a solution without fault a load that is one per cent larger is a fault."""
    number = next(n for n in range(100) if Case.of(n).drive == "slide")
    case = Case.of(number)
    solution = case.solve()
    assert solution.status.converged
    assert list(faults(solution, case)) == []
    assert any("load" in each for each in faults(solution, replace(case, depth=1.01 * case.depth)))


@pytest.mark.parametrize("number", [69, *in_ci(40, 105, 200, 212, 332)])
def test_a_corner_that_is_pressed_by_a_load_on_a_handle_stays_outside(number: int) -> None:
    """Sharp corners under loads on handles: from step to step they stay on the face that they press on."""
    found = outcome(number)
    assert found.converged, found.message
    assert found.touches
    assert not found.wrong
