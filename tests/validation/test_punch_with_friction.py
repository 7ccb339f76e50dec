"""A punch pressed on a half-plane with friction: the integral equations and the finite elements."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

from studies.friction.punch_with_friction import (
    COUPLING,
    POISSON,
    STICKING,
    flat_punch_pressed,
    half_of,
    pressed_punch,
    sticking_pull,
)


@pytest.mark.parametrize("friction", [0.15, 0.3])
def test_without_coupling_the_stick_zone_obeys_spences_equation(friction: float) -> None:
    """K'(c) / K(c) = b / mu of complete elliptic integrals, with the parameter c^2."""
    exact = brentq(lambda c: ellipk(1.0 - c**2) / ellipk(c**2) - COUPLING / friction, 0.01, 0.99)
    assert pressed_punch(friction, ratio=1.2, coupled=False).stick == pytest.approx(exact, rel=1e-4)


def test_finer_intervals_give_the_same_stick_zone_and_pull() -> None:
    """Intervals in the ratio 1.1 and 1.3: the stick zone within 1e-4, the pull within 2e-3."""
    fine, coarse = pressed_punch(0.3), pressed_punch(0.3, ratio=1.3)
    assert coarse.stick == pytest.approx(fine.stick, rel=1e-4)
    assert coarse.pull == pytest.approx(fine.pull, rel=2e-3)
    assert coarse.widths @ coarse.pressures == pytest.approx(0.5)


def test_all_tractions_obey_the_law_of_friction() -> None:
    """Below mu p where it sticks (up to 1e-3 of the zone's end), mu p where it slips, and outwards everywhere."""
    half = pressed_punch(0.3, ratio=1.2)
    limit = 0.3 * half.pressures
    slips = half.x > half.stick
    np.testing.assert_allclose(half.tractions[slips], limit[slips])
    inside = half.x < 0.999 * half.stick
    assert (half.tractions[inside] < limit[inside]).all()
    assert (half.tractions > 0.0).all()


def test_much_friction_gives_the_pull_of_the_punch_that_sticks() -> None:
    """The integral equations with the coefficient 1 stick to 0.3 % of the end: within 0.2 % of Muskhelishvili's."""
    half = pressed_punch(1.0, ratio=1.2)
    assert half.stick > 0.997
    assert half.pull == pytest.approx(sticking_pull(), rel=2e-3)


def test_the_pressure_in_the_middle_of_a_punch_that_sticks_is_muskhelishvilis() -> None:
    """Finite elements, friction 10: 2 (1 - nu) / sqrt(3 - 4 nu) / pi of the force per half-width."""
    solution = flat_punch_pressed(STICKING, cells=20)
    assert solution.status.converged, solution.status.message
    assert solution.friction_table.columns["sticks"].all()
    _, _, (x, pressures, _) = half_of(solution)
    assert x[0] < 0.06
    assert pressures[0] == pytest.approx(2.0 * (1.0 - POISSON) / np.sqrt(3.0 - 4.0 * POISSON) / np.pi, rel=0.01)
