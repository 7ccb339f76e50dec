"""Monomials, their derivatives, and quadrature on polygons, against exact integrals."""

import numpy as np
import pytest

from flangeway.elements import monomials, polygon_quadrature


@pytest.mark.parametrize("degree", [0, 1, 4, 7])
def test_polynomials_are_integrated_exactly_with_positive_weights_inside(ugly, degree):
    """Monomials up to the degree are exact; every weight is positive or of an empty triangle, every point inside."""
    points, weights = polygon_quadrature(ugly[:, :, None], degree)
    exact = monomials.integrals(degree, ugly[:, :, None], np.ones(1))
    values = monomials.evaluate(degree, points)
    scale = np.abs(values).max(axis=(1, 2)) * weights.sum()
    assert np.einsum("aqe,qe->a", values, weights) / scale == pytest.approx(exact[:, 0] / scale, abs=1e-13)
    assert weights.min() >= 0.0
    assert all(inside(ugly, p) for p in points[weights[:, 0] > 0.0, :, 0])


def inside(polygon, point):
    """Crossing number of a ray to the right."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    straddles = (start[:, 1] > point[1]) != (end[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = start[:, 0] + (point[1] - start[:, 1]) / (end[:, 1] - start[:, 1]) * (end[:, 0] - start[:, 0])
    return np.sum(straddles & (x > point[0])) % 2 == 1


def test_cells_of_a_batch_do_not_disturb_each_other():
    """A convex and a non-convex cell in one batch each get their own integral."""
    convex = np.array([(0, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2)], dtype=float)
    angle = np.array([(0, 0), (2, 0), (2, 1), (0.2, 1), (0.2, 2), (0, 2)], dtype=float)
    _, weights = polygon_quadrature(np.stack((convex, angle), axis=-1), 2)
    assert weights.sum(axis=0) == pytest.approx([4.0, 2.2], abs=1e-14)


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
