"""An independent program on the same triangles: scikit-fem."""

from typing import Any

import numpy as np
import pytest

from flangeway.elements import Lagrange
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import BodyForce, Elasticity, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space

skfem = pytest.importorskip("skfem")
helpers = pytest.importorskip("skfem.models.elasticity")

FORCE, TRACTION = (0.3, -1.1), (0.7, 0.4)


def by_scikit_fem(mesh, order: int, material: Elastic) -> tuple[np.ndarray, np.ndarray]:
    """Points and displacements, both (n, 2), of the same problem by scikit-fem."""
    theirs = skfem.MeshTri(mesh.points.T.copy(), mesh.cell_points.reshape(-1, 3).T.astype(np.int64).copy())
    element = skfem.ElementVector({1: skfem.ElementTriP1, 2: skfem.ElementTriP2}[order]())
    basis = skfem.Basis(theirs, element, intorder=4)
    lame, shear = helpers.lame_parameters(material.young, material.poisson)
    stiffness = skfem.asm(helpers.linear_elasticity(lame, shear), basis)
    body = skfem.LinearForm(lambda v, _: FORCE[0] * v[0] + FORCE[1] * v[1])
    edge = skfem.LinearForm(lambda v, _: TRACTION[0] * v[0] + TRACTION[1] * v[1])
    right = theirs.facets_satisfying(lambda x: np.isclose(x[0], 0.5))
    load = skfem.asm(body, basis) + skfem.asm(edge, skfem.FacetBasis(theirs, element, facets=right, intorder=4))
    held = basis.get_dofs(lambda x: np.isclose(x[0], -0.5))
    solution = skfem.solve(*skfem.condense(stiffness, load, D=held))
    first, second = np.arange(0, basis.N, 2), np.arange(1, basis.N, 2)
    assert np.array_equal(basis.doflocs[:, first], basis.doflocs[:, second])
    return basis.doflocs[:, first].T, np.stack((solution[first], solution[second]), axis=1)


@pytest.mark.parametrize("order", [1, 2])
def test_same_displacements(order: int) -> None:
    """On the same triangles, displacements of both programs agree at all nodes to 1e-10."""
    mesh, material = triangulate(square(1.0), size=0.1), Elastic(100.0, 0.3)
    problem = Elasticity(
        Space(mesh, Lagrange(order)),
        material,
        loads=[BodyForce(FORCE), Traction("right", TRACTION)],
        supports=[fixed("left")],
    )
    ours = solve_elasticity(problem).displacements
    points, theirs = by_scikit_fem(mesh, order, material)
    apart = np.linalg.norm(points[:, None] - problem.space.nodes, axis=2)
    nodes = apart.argmin(axis=1)
    assert apart.min(axis=1).max() < 1e-12
    assert len(np.unique(nodes)) == problem.space.n_nodes
    assert np.abs(ours[nodes] - theirs).max() < 1e-10 * np.abs(theirs).max()


def revolved_stiffness(points: np.ndarray, triangles: np.ndarray, material: Elastic) -> tuple[Any, Any]:
    """Basis and stiffness about y by scikit-fem; one point of quadrature has our mean hoop strain."""
    lame, shear = helpers.lame_parameters(material.young, material.poisson)

    @skfem.BilinearForm
    def form(u, v, w):
        radius = w.x[0]
        strains = [(a.grad[0][0], a.grad[1][1], a[0] / radius, a.grad[0][1] + a.grad[1][0]) for a in (u, v)]
        (a_r, a_y, a_t, a_s), (b_r, b_y, b_t, b_s) = strains
        work = lame * (a_r + a_y + a_t) * (b_r + b_y + b_t) + 2.0 * shear * (a_r * b_r + a_y * b_y + a_t * b_t)
        return 2.0 * np.pi * radius * (work + shear * a_s * b_s)

    mesh = skfem.MeshTri(points.T.copy(), triangles.T.astype(np.int64).copy())
    middle = np.full((2, 1), 1.0 / 3.0), np.array([0.5])
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()), quadrature=middle)
    return basis, form.assemble(basis)


def test_same_stiffness_of_a_body_of_revolution() -> None:
    """On the same triangles, the stiffness about an axis that the body touches is theirs to 1e-10."""
    steel, mesh = Elastic(210e3, 0.3, "axisymmetric"), triangulate(square(1.0, (0.5, 0.0)), size=0.2)
    basis, theirs = revolved_stiffness(mesh.points, mesh.cell_points.reshape(-1, 3), steel)
    ours = Elasticity(Space(mesh, Lagrange(1)), steel).stiffness().full()
    rows = basis.nodal_dofs.T.ravel()
    assert abs(theirs[rows][:, rows] - ours).max() < 1e-10 * abs(ours).max()
