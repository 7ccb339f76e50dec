"""Virtual elements of high orders keep their digits."""

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval2d

from flangeway import BodyForce, Elastic, Elasticity, PrescribedDisplacement, Space, Virtual, dual, solve_elasticity
from flangeway.elements import monomials
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, triangulate
from flangeway.types import Floats

MATERIAL = Elastic(1.0, 0.3)


class PolynomialField:
    """A displacement of a polynomial of a total degree in 2 x and 2 y, its stresses and loads."""

    def __init__(self, degree: int) -> None:
        powers = np.arange(degree + 1)
        inside = powers[:, None] + powers <= degree
        self.displacement = np.random.default_rng(3).standard_normal((2, degree + 1, degree + 1)) * inside
        (u, v), d = self.displacement, self.derivative
        strain = np.stack((d(u, 0), d(v, 1), d(u, 1) + d(v, 0)))
        self.stress = np.einsum("ij,jab->iab", MATERIAL.matrix[:3, :3], strain)
        xx, yy, xy = self.stress
        self.force = -np.stack((d(xx, 0) + d(xy, 1), d(xy, 0) + d(yy, 1)))

    @staticmethod
    def derivative(values: Floats, axis: int) -> Floats:
        return 2.0 * np.insert(polyder(values, axis=axis), values.shape[axis] - 1, 0.0, axis=axis)

    @staticmethod
    def at(points: Floats, values: Floats) -> Floats:
        """Components (m, a, b) at points (n, 2), shape (n, m)."""
        return polyval2d(2.0 * points[:, 0], 2.0 * points[:, 1], np.moveaxis(values, 0, -1)).T


def stress_error(mesh: PolyMesh, order: int) -> float:
    """Maximum error of stresses at the cells' vertices relative to the maximum stress, of a polynomial solution."""
    field = PolynomialField(order)
    supports = [
        PrescribedDisplacement(
            name, lambda p: field.at(p, field.displacement)[:, 0], lambda p: field.at(p, field.displacement)[:, 1]
        )
        for name in mesh.edge_sets
    ]
    load = BodyForce(lambda p: field.at(p, field.force))
    problem = Elasticity(Space(mesh, Virtual(order)), MATERIAL, loads=[load], supports=supports)
    solution = solve_elasticity(problem)
    assert solution.status.converged
    differences, maximum = [], 0.0
    for batch in problem.space.batches():
        reconstruction, stress = problem.cell_stresses(batch, solution.displacements)
        values = monomials.evaluate(order - 1, reconstruction.frame.local(batch.vertices))
        computed = np.einsum("sae,ave->ves", stress[:3], values)
        exact = field.at(np.moveaxis(batch.vertices, 1, -1).reshape(-1, 2), field.stress).reshape(computed.shape)
        differences.append(np.abs(computed - exact).max())
        maximum = max(maximum, np.abs(exact).max())
    return float(max(differences) / maximum)


@pytest.mark.parametrize("order", [4, 10])
def test_polynomials_on_dual_polygons(order: int) -> None:
    """Stresses of a polynomial of the element's degree are exact to 1e-10, where order 10 kept seven digits."""
    assert stress_error(dual(triangulate(square(1.0), size=0.3)), order) < 1e-10


def test_no_digit_is_lost_by_refinement() -> None:
    """Order 8 has ten digits on smaller cells too."""
    assert stress_error(dual(triangulate(square(1.0), size=0.15)), 8) < 1e-10
