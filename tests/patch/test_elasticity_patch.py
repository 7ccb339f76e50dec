"""Patch tests of plane elasticity: what a method must reproduce exactly."""

import math
from functools import cache

import numpy as np
import pytest

from flangeway.elements import (
    DiagonalStabilisation,
    IdentityStabilisation,
    Lagrange,
    SpectralStabilisation,
    Stabilisation,
    TraceStabilisation,
    Virtual,
)
from flangeway.geometry import Placement, square
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.post import corner_stresses
from flangeway.space import Space
from tests.given_displacement import solved
from tests.rates.test_elasticity_rates import mixed


def mixed_mesh() -> PolyMesh:
    """Quadrilaterals on the left, triangles on the right, inner points moved off the grid."""
    grid = mixed(4)
    inside = ((grid.points > 0.0) & (grid.points < 1.0)).all(axis=1)
    points = grid.points.copy()
    points[inside] += np.random.default_rng(1).uniform(-0.05, 0.05, (inside.sum(), 2))
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, cell_sets=grid.cell_sets)


@cache
def triangles() -> PolyMesh:
    return triangulate(square(1.0), size=0.3)


def space_of(name: str, order: int) -> Space:
    if name == "fem":
        return Space(triangles(), Lagrange(order))
    if name == "vem":
        return Space(dual(triangles()), Virtual(order))
    if name == "vem on triangles":
        return Space(triangles(), Virtual(order))
    return Space(mixed_mesh(), {"polygons": Virtual(order), "triangles": Lagrange(order)})


NAMES = ("fem", "vem", "vem on triangles", "mixed")
CASES = [(name, order) for name in NAMES for order in (1, 2, 3, 4) if order < 4 or name.startswith("vem")] + [
    ("vem", 5),
    ("vem", 6),
]  # there is no Lagrange triangle of order 4


def polynomial(order: int, centre: float = 0.0):
    """A displacement of a degree with random coefficients: itself, its gradient (n, 2, 2) and second derivatives.

    It is one of twice the distances from a place on the diagonal, which are up to 1 in a square of side 1 about it.
    """
    coefficients = 1e-3 * np.random.default_rng(order).normal(size=(2, (order + 1) * (order + 2) // 2))
    powers = [(total - j, j) for total in range(order + 1) for j in range(total + 1)]

    def derivative(points: np.ndarray, dx: int, dy: int) -> np.ndarray:
        x, y = 2.0 * (points.T - centre)
        result = np.zeros((len(points), 2))
        for column, (a, b) in zip(coefficients.T, powers, strict=True):
            if a >= dx and b >= dy:
                factor = 2.0 ** (dx + dy) * math.perm(a, dx) * math.perm(b, dy)
                result += factor * (x ** (a - dx) * y ** (b - dy))[:, None] * column
        return result

    def gradient(points: np.ndarray) -> np.ndarray:
        return np.stack((derivative(points, 1, 0), derivative(points, 0, 1)), axis=2)

    def second(points: np.ndarray) -> np.ndarray:
        mixed = derivative(points, 1, 1)
        rows = [[derivative(points, 2, 0), mixed], [mixed, derivative(points, 0, 2)]]
        return np.moveaxis(np.array(rows), (0, 1), (2, 3))

    return lambda points: derivative(points, 0, 0), gradient, second


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress"])
@pytest.mark.parametrize(("name", "order"), CASES)
def test_a_polynomial_of_the_order_is_reproduced(name: str, order: int, hypothesis: str) -> None:
    """With the boundary values and the body force of a polynomial of degree k, the solution is it, to 1e-9 at nodes."""
    space = space_of(name, order)
    material = Orthotropic((200.0, 80.0, 60.0), (0.3, 0.2, 0.25), 50.0, 0.4, hypothesis)
    exact, gradient, second = polynomial(order)

    def force(points: np.ndarray) -> np.ndarray:
        return -np.einsum("ijkl,nklj->ni", material.stiffness, second(points))

    solution = solved(space, material, exact, force)
    at_nodes = exact(space.nodes)
    assert np.abs(solution.displacements[: space.n_nodes] - at_nodes).max() < 1e-9 * np.abs(at_nodes).max()
    corners = corner_stresses(solution.problem, solution.displacements).components
    stress = np.einsum("ijkl,nkl->nij", material.stiffness, gradient(space.mesh.points[space.mesh.cell_points]))
    expected = np.stack((stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1]), axis=1)
    assert np.abs(corners[:, :3] - expected).max() < 1e-8 * np.abs(expected).max()


STABILISATIONS = [
    IdentityStabilisation(),
    DiagonalStabilisation(0.5),
    SpectralStabilisation(0.5),
    TraceStabilisation(0.1),
    TraceStabilisation(2.0),
]


@pytest.mark.parametrize("stabilisation", STABILISATIONS, ids=repr)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_every_stabilisation_passes(stabilisation: Stabilisation, order: int) -> None:
    """A polynomial of degree k is reproduced whatever the stabilisation and its factor, compressible or nearly not."""
    space = Space(dual(triangles()), Virtual(order, stabilisation))
    exact, _, second = polynomial(order)
    for material in (Elastic(70.0, 0.2), Elastic(70.0, 0.499)):

        def force(points: np.ndarray, tensor: np.ndarray = material.stiffness) -> np.ndarray:
            return -np.einsum("ijkl,nklj->ni", tensor, second(points))

        solution = solved(space, material, exact, force)
        at_nodes = exact(space.nodes)
        assert np.abs(solution.displacements[: space.n_nodes] - at_nodes).max() < 1e-9 * np.abs(at_nodes).max()


@pytest.mark.parametrize("shift", [0.5, 3.0])
@pytest.mark.parametrize(("name", "order"), CASES)
def test_a_body_of_revolution_swells_uniformly(name: str, order: int, shift: float) -> None:
    """About an axis, touching it or not, u_r = r and u_z = z are reproduced to 1e-10, with three equal strains."""
    space = space_of(name, order)
    space = Space(space.mesh.placed(Placement(0.0, (shift, 0.0))), space.element)
    material = Elastic(210e3, 0.3, "axisymmetric")
    solution = solved(space, material, lambda points: points)
    assert np.abs(solution.displacements[: space.n_nodes] - space.nodes).max() < 1e-10
    bulk = 210e3 / (1.0 - 2.0 * 0.3)
    corners = corner_stresses(solution.problem, solution.displacements).components
    assert np.abs(corners - bulk * np.array([1.0, 1.0, 0.0, 1.0])).max() < 1e-8 * bulk
    volume = 2.0 * np.pi * space.mesh.cell_areas @ space.mesh.cell_centroids[:, 0]
    assert solution.energy == pytest.approx(1.5 * bulk * volume, rel=1e-9)
