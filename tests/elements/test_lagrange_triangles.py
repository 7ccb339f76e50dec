"""Lagrange triangles of order 1 to 3."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError

TRIANGLE = np.array([[0.3, 0.1], [2.0, 0.4], [0.9, 1.7]])


def stiffness(element, points):
    cell = element.reconstruct(points[:, :, None])
    consistency = np.einsum("aime,abe,bine->mne", cell.value_gradient, cell.mass, cell.value_gradient)
    extra = element.stabilise(cell, consistency[None, None])
    return (consistency if extra is None else consistency + extra)[..., 0]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_shape_functions_are_one_at_their_node_and_zero_at_others(order):
    """The value's polynomials at the nodes are the identity."""
    cell = Lagrange(order).reconstruct(TRIANGLE[:, :, None])
    at_nodes = cell.monomial_dofs[..., 0] @ cell.value[..., 0]
    assert at_nodes == pytest.approx(np.eye(cell.n_local), abs=1e-12)


def test_linear_triangle_has_the_cotangent_stiffness():
    """Off-diagonal entries of the linear triangle are minus half the cotangents of the opposite angles."""
    matrix = stiffness(Lagrange(1), TRIANGLE)
    for i in range(3):
        a, b = TRIANGLE[(i + 1) % 3] - TRIANGLE[i], TRIANGLE[(i + 2) % 3] - TRIANGLE[i]
        cotangent = a @ b / (a[0] * b[1] - a[1] * b[0])
        assert matrix[(i + 1) % 3, (i + 2) % 3] == pytest.approx(-cotangent / 2.0, abs=1e-14)


def test_virtual_triangle_of_order_one_is_the_linear_triangle():
    """Order 1 on a triangle: both methods have the same stiffness."""
    assert stiffness(Virtual(1), TRIANGLE) == pytest.approx(stiffness(Lagrange(1), TRIANGLE), abs=1e-13)


@pytest.mark.parametrize("order", [0, 4])
def test_other_orders_are_refused(order):
    """Orders outside 1 to 3 are refused with the way out."""
    with pytest.raises(InputError, match="orders 1 to 3"):
        Lagrange(order)
