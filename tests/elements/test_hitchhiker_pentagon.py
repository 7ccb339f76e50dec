"""The pentagon of Beirao da Veiga et al. (2014), "The Hitchhiker's guide to the virtual element method"."""

import numpy as np
import pytest

from flangeway.elements import cell_matrices

PENTAGON = [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (1.5, 4.0), (0.0, 4.0)]


def test_gram_matrix_of_order_1_is_the_published_one():
    """G of order 1 is 1/1050 [[1050, 30, 40], [0, 441, 0], [0, 0, 441]]."""
    published = np.array([[1050, 30, 40], [0, 441, 0], [0, 0, 441]]) / 1050
    assert pytest.approx(published, abs=1e-15) == cell_matrices(PENTAGON, 1).G


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_gram_matrix_is_the_product_and_projectors_are_idempotent(order):
    """G = B D, and both projectors leave their own images alone."""
    cell = cell_matrices(PENTAGON, order)
    assert pytest.approx(cell.B @ cell.D, abs=1e-13) == cell.G
    for projector in (cell.pi_nabla, cell.pi_zero):
        assert projector @ projector == pytest.approx(projector, abs=1e-9)
