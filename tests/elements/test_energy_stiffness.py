"""Stiffness of one field: consistency and stabilisation together."""

import numpy as np
import pytest

from flangeway.elements import (
    DiagonalStabilisation,
    IdentityStabilisation,
    Lagrange,
    NoStabilisation,
    TraceStabilisation,
    Virtual,
    energy_stiffness,
)

KINDS = [
    None, IdentityStabilisation(), IdentityStabilisation(0.3), DiagonalStabilisation(), TraceStabilisation(),
    NoStabilisation(),
]  # fmt: skip
TRIANGLES = np.array([[[0.0, 0.1], [0.0, 0.2]], [[1.0, 0.9], [0.0, 0.1]], [[0.3, 0.2], [0.8, 1.1]]])


def total(element, cells, moduli):
    consistency = cells.value_energy(moduli)
    added = element.stabilise(cells, consistency[None, None])
    return consistency if added is None else consistency + added


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_it_is_the_sum_of_its_parts(ugly, order, kind):
    """With every stabilisation it is consistency plus stabilisation, symmetric, for cells of any modulus."""
    element, moduli = Virtual(order, kind), np.array([2.5, 80e3])
    cells = element.reconstruct(np.stack((ugly, 3.0 * ugly + 1.0), axis=-1))
    matrices = energy_stiffness(element, cells, moduli)
    size = np.abs(matrices).max(axis=(0, 1))
    assert np.all(np.abs(matrices - total(element, cells, moduli)) <= 1e-10 * size)
    assert np.all(np.abs(matrices - matrices.swapaxes(0, 1)) <= 1e-14 * size)


@pytest.mark.parametrize("order", [1, 2])
def test_triangles_need_no_stabilisation(order):
    """On Lagrange triangles it is the consistency."""
    element, moduli = Lagrange(order), np.array([2.0, 3.0])
    cells = element.reconstruct(TRIANGLES)
    assert np.array_equal(energy_stiffness(element, cells, moduli), cells.value_energy(moduli))
