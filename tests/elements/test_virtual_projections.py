"""Projections of virtual elements on polygons of all kinds, and Lagrange triangles.

The pentagon is that of Beirao da Veiga et al. (2014), "The Hitchhiker's guide to the virtual element method".
"""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual, cell_matrices, monomials
from flangeway.errors import InputError

ORDERS = [1, 2, 3, 4, 5]


def worst_reproduction(points, order):
    """Maximum error with which the projections reproduce the monomials and their gradients."""
    cell = Virtual(order).reconstruct(points[:, :, None])
    dofs = cell.monomial_dofs[:, :, 0]
    identity = np.eye(dofs.shape[1])
    local = np.einsum("jab,ji->aib", monomials.derivatives(order), cell.frame.map[:, :, 0])
    gradient = np.einsum("aim,mb->aib", cell.gradient[..., 0], dofs)
    scale = np.abs(local).max()
    return max(
        np.abs(cell.value[..., 0] @ dofs - identity).max(),
        np.abs(cell.projected_value[..., 0] @ dofs - identity).max(),
        np.abs(gradient - local).max() / scale,
    )


@pytest.mark.parametrize("order", ORDERS)
def test_projections_reproduce_every_monomial(ugly, order):
    """All three projections reproduce every monomial up to degree k to 1e-10, whatever the polygon."""
    assert worst_reproduction(ugly, order) < 1e-10


@pytest.mark.parametrize("order", ORDERS)
def test_projections_do_not_depend_on_the_distance_from_the_origin(ugly, order):
    """At a million diameters from the origin the projections still reproduce every monomial to 1e-10."""
    moved = ugly * np.ptp(ugly, axis=0).max() ** -1 + np.array([1e6, -1e6])
    # coordinates rounded at 1e-10: the shape changes a little, its own monomials do not care
    assert worst_reproduction(moved, order) < 1e-10


@pytest.mark.parametrize(("order", "allowed"), [(1, 1e-12), (2, 1e-12), (3, 1e-10), (4, 1e-9), (5, 1e-7)])
def test_stretched_cells_lose_few_digits(ugly, order, allowed):
    """Cells stretched 1:1000 obliquely to the axes reproduce monomials to 1e-12 (k = 1) up to 1e-7 (k = 5)."""
    cosine, sine = np.cos(0.3), np.sin(0.3)
    stretched = ugly * [1.0, 1e-3] @ np.array([[cosine, sine], [-sine, cosine]])
    assert worst_reproduction(stretched, order) < allowed


def test_projected_value_keeps_the_moments(ugly):
    """The L2 projection has the moments that are degrees of freedom (order 4)."""
    cell = Virtual(4).reconstruct(ugly[:, :, None])
    n_inner = 6
    mass = monomials.mass(4, cell.moments)[:n_inner, :, 0] / cell.areas
    moments = mass @ cell.projected_value[..., 0]
    expected = np.zeros_like(moments)
    expected[:, -n_inner:] = cell.inner[..., 0]  # monomials in terms of the polynomials of the unknowns
    assert moments == pytest.approx(expected, abs=1e-8)


def test_value_and_projected_value_agree_up_to_order_two():
    """Energy and L2 projection are the same for k = 1 and 2 in the enhanced space (Moherdaui 3.80), not for k = 3."""
    pentagon = np.array([(0, 0), (3, 0), (3, 2), (1.5, 4), (0, 4)], dtype=float)[:, :, None]
    for order in (1, 2):
        cell = Virtual(order).reconstruct(pentagon)
        mass = monomials.mass(order, cell.moments)
        means = np.einsum("abe,bme->ame", mass, cell.value)[0, :, 0] / cell.areas
        assert cell.projected_value == pytest.approx(cell.value)
        if order == 2:
            assert means == pytest.approx(np.eye(cell.n_local)[-1], abs=1e-13)
    cell = Virtual(3).reconstruct(pentagon)
    assert np.abs(cell.projected_value - cell.value).max() > 1e-4


def test_energy_projection_is_orthogonal(ugly):
    """The energy projection's error is orthogonal to all gradients of polynomials (order 3)."""
    cell = Virtual(3).reconstruct(ugly[:, :, None])
    missed = cell.gradient - cell.value_gradient
    local = np.einsum("jab,ji->aib", monomials.derivatives(3), cell.frame.map[:, :, 0])
    products = np.einsum("aib,ac,cim->bm", local, cell.mass[..., 0], missed[..., 0])
    size = np.einsum("aib,ac,cid->bd", local, cell.mass[..., 0], local).max()
    assert np.abs(products).max() < 1e-11 * size


def test_batches_equal_single_cells(ugly):
    """A batch of cells gives what its cells give one by one, to the last digit of a few operations."""
    cells = np.stack([ugly, 2.0 * ugly + 1.0, ugly[:, ::-1][::-1]], axis=-1)
    together = Virtual(3).reconstruct(cells)
    for i in range(3):
        alone = Virtual(3).reconstruct(cells[:, :, i : i + 1])
        assert together.value[..., i] == pytest.approx(alone.value[..., 0], rel=1e-9, abs=1e-9)


PENTAGON = [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (1.5, 4.0), (0.0, 4.0)]


def test_gram_matrix_of_order_1_is_the_published_one():
    """G of order 1 is 1/1050 [[1050, 30, 40], [0, 441, 0], [0, 0, 441]]."""
    published = np.array([[1050, 30, 40], [0, 441, 0], [0, 0, 441]]) / 1050
    assert pytest.approx(published, abs=1e-15) == cell_matrices(PENTAGON, 1).G


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
