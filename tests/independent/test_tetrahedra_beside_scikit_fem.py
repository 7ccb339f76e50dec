"""Virtual elements of order 1 on tetrahedra beside scikit-fem's linear tetrahedra: displacements to 1e-10."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.materials import Elastic
from flangeway.mesh import PolyhedralMesh
from flangeway.problems import BodyForce, Elasticity, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.polyhedra import tetrahedra, with_sides

skfem = pytest.importorskip("skfem")


def test_a_clamped_block_bends_as_in_scikit_fem():
    """A block that is clamped at its base bends alike under a shear traction and a force per volume."""
    points, cells = tetrahedra()
    mesh = with_sides(PolyhedralMesh.from_elements(points, cells))
    loads = [Traction("z+", (3.0, 1.0, -2.0)), BodyForce((0.5, -1.0, 2.0))]
    ours = solve_elasticity(
        Elasticity(Space(mesh, Virtual(1)), Elastic(1000.0, 0.3), loads=loads, supports=[fixed("z-", 3)])
    )
    theirs = skfem.MeshTet(points.T, cells.T).with_boundaries(
        {"base": lambda x: x[2] < 1e-9, "top": lambda x: x[2] > 1.5 - 1e-9}
    )
    element = skfem.ElementVector(skfem.ElementTetP1())
    basis = skfem.Basis(theirs, element, intorder=2)
    top = skfem.FacetBasis(theirs, element, facets=theirs.boundaries["top"], intorder=2)

    def load(force):
        return skfem.LinearForm(lambda v, _: sum(f * v[i] for i, f in enumerate(force)))

    elasticity = pytest.importorskip("skfem.models.elasticity")
    lame = elasticity.lame_parameters(1000.0, 0.3)
    stiffness = elasticity.linear_elasticity(*lame).assemble(basis)
    rhs = load((0.5, -1.0, 2.0)).assemble(basis) + load((3.0, 1.0, -2.0)).assemble(top)
    exact = skfem.solve(*skfem.condense(stiffness, rhs, D=basis.get_dofs("base")))
    difference = np.abs(ours.displacements - exact[basis.nodal_dofs].T).max()
    assert difference < 1e-10 * np.abs(exact).max()
