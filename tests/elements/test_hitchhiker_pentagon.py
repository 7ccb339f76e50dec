"""The pentagon of Beirao da Veiga et al. (2014), "The Hitchhiker's guide to the virtual element method"."""

from fractions import Fraction as Q

import numpy as np
import pytest

from flangeway.elements import cell_matrices

PENTAGON = [(Q(0), Q(0)), (Q(3), Q(0)), (Q(3), Q(2)), (Q(3, 2), Q(4)), (Q(0), Q(4))]


def test_gram_matrix_of_order_1_is_the_published_one():
    """G of order 1 is 1/1050 [[1050, 30, 40], [0, 441, 0], [0, 0, 441]]."""
    published = np.array([[1050, 30, 40], [0, 441, 0], [0, 0, 441]]) / 1050
    assert pytest.approx(published, abs=1e-15) == cell_matrices(np.array(PENTAGON, dtype=float), 1).G


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_gram_matrix_is_the_product_and_projectors_are_idempotent(order):
    """G = B D, and both projectors leave their own images alone."""
    cell = cell_matrices(np.array(PENTAGON, dtype=float), order)
    assert pytest.approx(cell.B @ cell.D, abs=1e-13) == cell.G
    for projector in (cell.pi_nabla, cell.pi_zero):
        assert projector @ projector == pytest.approx(projector, abs=1e-9)
