"""Patch recovery converges faster than the stresses, so that its difference from them is their error."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual, polygon_quadrature
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid, triangulate
from flangeway.post import RecoveredStresses, recovered_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.given_displacement import solved
from tests.rates import test_elasticity_rates as elastic


def stress(points):
    """Exact stresses xx, yy, xy, shape (n, 3)."""
    tensor = np.einsum("ijkl,nkl->nij", elastic.MATERIAL.stiffness, elastic.gradient(points))
    return tensor[:, [0, 1, 0], [0, 1, 1]]


def recovered(mesh, element) -> RecoveredStresses:
    return recovered_stresses(solved(Space(mesh, element), elastic.MATERIAL, elastic.exact, elastic.body_force))


def cell_errors(recovery: RecoveredStresses) -> np.ndarray:
    """True errors of the cells' stresses in the energy norm."""
    solution = recovery.solution
    squares = np.empty(solution.problem.space.mesh.n_cells)
    compliance = np.linalg.inv(elastic.MATERIAL.matrix[:3, :3])
    for batch in solution.problem.space.batches():
        reconstruction, coefficients = solution.problem.cell_stresses(batch, solution.displacements)
        points, weights = polygon_quadrature(batch.outline, 8)
        values = reconstruction.at(points)[: coefficients.shape[1]]
        computed = np.einsum("sae,aqe->qes", coefficients[:3], values)
        wanted = stress(points.swapaxes(1, 2).reshape(-1, 2)).reshape(computed.shape)
        difference = wanted - computed
        squares[batch.cells] = np.einsum("qes,st,qet,qe->e", difference, compliance, difference, weights)
    return np.sqrt(squares)


def delaunay(size):
    return triangulate(square(1.0), size=size)


CASES = {
    "T3": (delaunay, Lagrange(1)),
    "T6": (delaunay, Lagrange(2)),
    "T10": (delaunay, Lagrange(3)),
    "polygons 1": (lambda size: dual(delaunay(size)), Virtual(1)),
    "polygons 2": (lambda size: dual(delaunay(size)), Virtual(2)),
    "polygons 3": (lambda size: dual(delaunay(size)), Virtual(3)),
    "squares 1": (
        lambda size: rectangle_grid(1.0, 1.0, round(1 / size), round(1 / size), cells="quadrilaterals"),
        Virtual(1),
    ),
}


@pytest.mark.parametrize("name", sorted(CASES))
def test_the_estimate_is_the_error(name: str) -> None:
    """The estimated error is the true one of the stresses within 15 %, and in most cells within a factor of 2."""
    make, element = CASES[name]
    recovery = recovered(make(0.05), element)
    true = cell_errors(recovery)
    assert recovery.error == pytest.approx(np.linalg.norm(true), rel=0.15)
    ratio = recovery.cell_errors / true
    assert np.mean((ratio > 0.5) & (ratio < 2.0)) > 0.9
    assert recovery.relative_error < 0.1


@pytest.mark.parametrize("name", ["T3", "T6", "polygons 1", "polygons 2"])
def test_recovered_stresses_converge_faster(name: str) -> None:
    """At the mesh's points, the recovered stresses gain at least half an order on the reconstructed ones."""
    make, element = CASES[name]
    results = []
    for size in (0.12, 0.04):
        recovery = recovered(make(size), element)
        mesh = recovery.solution.problem.space.mesh
        used = np.unique(mesh.cell_points)
        misfit = recovery.nodal.components[used, :3] - stress(mesh.points[used])
        results.append((np.sqrt(np.mean(misfit**2)), recovery.error))
    gain, own = np.log(np.divide(*results)) / np.log(3.0)
    assert gain > own + 0.5


def test_two_materials_are_recovered_apart() -> None:
    """Layers of different stiffness, stretched together, have no estimated error, though their stresses jump."""
    mesh = rectangle_grid(2.0, 1.0, 8, 4)
    upper = mesh.cell_centroids[:, 1] > 0.5
    mesh = mesh.with_cell_set("upper", upper).with_cell_set("lower", ~upper)
    materials = {"upper": Elastic(30.0, 0.0), "lower": Elastic(10.0, 0.0)}
    supports = [
        PrescribedDisplacement("left", x=0.0),
        PrescribedDisplacement("right", x=0.1),
        fixed((0.0, 0.0)),
    ]
    solution = solve_elasticity(Elasticity(Space(mesh, Lagrange(2)), materials, supports=supports))
    recovery = recovered_stresses(solution)
    assert recovery.relative_error < 1e-8
    corners = recovery.corners.components[:, 0].reshape(-1, 3)
    assert corners[upper] == pytest.approx(1.5)
    assert corners[~upper] == pytest.approx(0.5)
