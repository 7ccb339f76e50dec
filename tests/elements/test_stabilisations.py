"""Stabilisations of virtual elements."""

import numpy as np
import pytest

from flangeway.elements import (
    DiagonalStabilisation,
    IdentityStabilisation,
    SpectralStabilisation,
    TraceStabilisation,
    Virtual,
)

KINDS = [IdentityStabilisation(), DiagonalStabilisation(), SpectralStabilisation(), TraceStabilisation()]


def consistency_of(cell, modulus=1.0):
    return modulus * np.einsum("aime,abe,bine->mne", cell.value_gradient, cell.mass, cell.value_gradient)[None, None]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_stiffness_has_one_free_motion(ugly, order, kind):
    """With a stabilisation exactly the constant has no energy, on every polygon."""
    element = Virtual(order, kind)
    cell = element.reconstruct(ugly[:, :, None])
    consistency = consistency_of(cell)
    stiffness = consistency[0, 0, :, :, 0] + element.stabilise(cell, consistency)[..., 0]
    energies = np.linalg.eigvalsh(stiffness)
    assert abs(energies[0]) < 1e-10
    assert energies[1] > 1e-8


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_stabilisation_vanishes_on_polynomials(ugly, order, kind):
    """No stabilisation adds energy to a polynomial of degree k."""
    cell = Virtual(order).reconstruct(ugly[:, :, None])
    matrix = kind.matrices(cell, consistency_of(cell))[..., 0]
    assert np.abs(matrix @ cell.monomial_dofs[..., 0]).max() < 1e-10 * max(np.abs(matrix).max(), 1.0)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: type(kind).__name__)
def test_stabilisation_scales_with_the_modulus_and_not_with_size(ugly, kind):
    """Twice the modulus gives twice the matrix; another unit of length gives the same matrix."""
    small = Virtual(2).reconstruct(ugly[:, :, None])
    large = Virtual(2).reconstruct(1000.0 * ugly[:, :, None])
    base = kind.matrices(small, consistency_of(small))
    assert kind.matrices(small, consistency_of(small, 2.0)) == pytest.approx(2.0 * base, rel=1e-12, abs=1e-12)
    assert kind.matrices(large, consistency_of(large)) == pytest.approx(base, rel=1e-9, abs=1e-9)


def test_identity_is_the_published_formula(ugly):
    """The identity stabilisation is (I - D Pi)^T (I - D Pi)."""
    cell = Virtual(2).reconstruct(ugly[:, :, None])
    missed = np.eye(cell.n_local) - cell.monomial_dofs[..., 0] @ cell.value[..., 0]
    matrix = IdentityStabilisation().matrices(cell, consistency_of(cell))[..., 0]
    assert matrix == pytest.approx(missed.T @ missed, abs=1e-12)


def test_published_choice_depends_on_the_number_of_components():
    """Without a choice, one field gets the identity and a displacement gets the spectral one."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[:, :, None]
    cell = Virtual(1).reconstruct(square)
    scalar = consistency_of(cell)
    vector = np.zeros((2, 2, *scalar.shape[2:]))
    vector[0, 0] = vector[1, 1] = scalar[0, 0]
    assert np.array_equal(Virtual(1).stabilise(cell, scalar), IdentityStabilisation().matrices(cell, scalar))
    assert np.array_equal(Virtual(1).stabilise(cell, vector), SpectralStabilisation().matrices(cell, vector))
