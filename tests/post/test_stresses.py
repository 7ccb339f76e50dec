"""Stresses inside cells and what is derived from them."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.forms import interpolate
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.post import Stresses, cell_stresses, corner_stresses
from flangeway.problems import Elasticity
from flangeway.space import Space


def test_invariants_of_known_states() -> None:
    """Uniaxial tension, pure shear and hydrostatic pressure have the textbook's invariants."""
    states = Stresses(np.array([[100.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0, 0.0], [-7.0, -7.0, 0.0, -7.0]]))
    assert states.von_mises == pytest.approx([100.0, 40.0 * np.sqrt(3.0), 0.0])
    assert states.in_plane_shear == pytest.approx([50.0, 40.0, 0.0])
    assert states.principal == pytest.approx(np.array([[100.0, 0.0, 0.0], [40.0, 0.0, -40.0], [-7.0, -7.0, -7.0]]))


def test_principal_stresses_are_eigenvalues() -> None:
    """For random states the principal stresses are the eigenvalues of the tensor, zz included."""
    components = np.random.default_rng(0).normal(size=(50, 4))
    for row, principal in zip(components, Stresses(components).principal, strict=True):
        tensor = np.array([[row[0], row[2], 0.0], [row[2], row[1], 0.0], [0.0, 0.0, row[3]]])
        assert np.linalg.eigvalsh(tensor)[::-1] == pytest.approx(principal)


@pytest.mark.parametrize("method", [Lagrange, Virtual])
def test_a_quadratic_displacement_has_linear_stresses(method) -> None:
    """Order 2 has, in every cell, exactly the stresses at corners and the means of a quadratic displacement."""
    mesh = triangulate(square(1.0), size=0.4)
    if method is Virtual:
        mesh = dual(mesh)
    material = Elastic(100.0, 0.3)
    problem = Elasticity(Space(mesh, method(2)), material)

    def exact(points: np.ndarray) -> np.ndarray:
        x, y = points.T
        return np.stack((x**2 - x * y, 0.5 * y**2 + 2.0 * x * y), axis=1)

    def stress(points: np.ndarray) -> np.ndarray:
        x, y = points.T
        gradient = np.array([[2.0 * x - y, -x], [2.0 * y, y + 2.0 * x]])
        tensor = np.einsum("ijkl,kln->ijn", material.stiffness, gradient)
        normal = np.einsum("kl,kln->n", material.out_of_plane, gradient)
        return np.stack((tensor[0, 0], tensor[1, 1], tensor[0, 1], normal), axis=1)

    displacement = interpolate(problem.space, exact)
    corners = corner_stresses(problem, displacement).components
    assert corners == pytest.approx(stress(mesh.points[mesh.cell_points]), abs=1e-9)
    means = cell_stresses(problem, displacement).components
    assert means == pytest.approx(stress(mesh.cell_centroids), abs=1e-9)
