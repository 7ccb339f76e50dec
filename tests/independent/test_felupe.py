"""Nonlinear materials of bodies beside FElupe on the same triangles: displacements to 1e-8."""

import numpy as np
import pytest

from flangeway.elements import Lagrange
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, fixed
from flangeway.solve import solve_nonlinear
from flangeway.space import Space

felupe = pytest.importorskip("felupe")

MESH = rectangle_grid(2.0, 1.0, 6, 4)
FACTORS = [0.5, 1.0, 0.9, 0.6]


def theirs(material, shear):
    """Displacements of the sheared rectangle at each factor."""
    mesh = felupe.Mesh(MESH.points, MESH.cell_points.reshape(-1, 3), "triangle")
    field = felupe.FieldContainer([felupe.FieldPlaneStrain(felupe.RegionTriangle(mesh), dim=2)])
    held = {
        "left": felupe.Boundary(field[0], fx=0.0),
        "across": felupe.Boundary(field[0], fx=2.0, skip=(0, 1)),
        "along": felupe.Boundary(field[0], fx=2.0, skip=(1, 0)),
    }
    body, found = felupe.SolidBody(material, field), []
    for factor in FACTORS:
        held["along"].value = factor * shear
        fixed_dofs, free = felupe.dof.partition(field, held)
        values = felupe.dof.apply(field, held, fixed_dofs)
        felupe.newtonraphson(items=[body], dof0=fixed_dofs, dof1=free, ext0=values, verbose=0, tol=1e-8)
        found.append(field[0].values.copy())
    return found


MATERIALS = {
    "neo-Hooke": (
        NeoHooke(Elastic(100.0, 0.3)),
        lambda e: felupe.NeoHookeCompressible(mu=e.shear_modulus, lmbda=float(e.matrix[0, 1])),
        0.8,
    ),
    "J2": (
        J2Plasticity(Elastic(200.0, 0.3), 0.2, isotropic=5.0),
        lambda e: felupe.LinearElasticPlasticIsotropicHardening(E=e.young, nu=e.poisson, sy=0.2, K=5.0),
        0.01,
    ),
}


@pytest.mark.parametrize("name", MATERIALS)
def test_a_sheared_rectangle(name):
    """Loaded in two steps and unloaded in two, beyond yield and at finite strain: the same displacements."""
    material, make, shear = MATERIALS[name]
    supports = [fixed("left"), PrescribedDisplacement("right", x=0.0, y=shear)]
    problem = Elasticity(Space(MESH, Lagrange(1)), material.elastic, supports=supports)
    for ours, expected in zip(
        solve_nonlinear(problem, material, FACTORS), theirs(make(material.elastic), shear), strict=True
    ):
        np.testing.assert_allclose(ours.displacements, expected, atol=1e-8 * shear)
