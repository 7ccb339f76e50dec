"""Monomials, their derivatives and their integrals."""

import numpy as np
import pytest

from flangeway.elements import monomials


def test_index_is_the_inverse_of_exponents():
    """The position of each monomial is found from its exponents."""
    assert monomials.index(monomials.exponents(6)).tolist() == list(range(28))


def test_derivatives_agree_with_differences():
    """The derivative matrices give central differences of the values."""
    point, step = np.array([0.3, -0.7])[:, None], 1e-6
    for axis in range(2):
        shift = step * np.eye(2)[axis][:, None]
        slope = (monomials.evaluate(4, point + shift) - monomials.evaluate(4, point - shift)) / (2.0 * step)
        exact = monomials.derivatives(4)[axis].T @ monomials.evaluate(3, point)
        assert slope == pytest.approx(exact, abs=1e-9)


def test_integrals_over_the_unit_square_are_known():
    """The integral of x^a y^b over the unit square is 1 / ((a + 1)(b + 1))."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[:, :, None]
    powers = monomials.exponents(9)
    exact = 1.0 / ((powers[:, 0] + 1.0) * (powers[:, 1] + 1.0))
    assert monomials.integrals(9, square, np.ones(1))[:, 0] == pytest.approx(exact, rel=1e-13)
