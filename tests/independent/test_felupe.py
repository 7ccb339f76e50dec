"""Nonlinear materials beside FElupe on the same triangles: displacements to 1e-8, forces of a contact to 0.5 %."""

from itertools import pairwise

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press_nonlinear
from flangeway.elements import Lagrange
from flangeway.geometry import Line, Outline, Placement
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement, fixed
from flangeway.solve import StepSettings, solve_nonlinear
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


def their_force(mesh, rubber, depth):
    """Force on the held edge, from a penalty at the nodes that pass a rigid plane."""
    plane = mesh.n_points
    their_mesh = felupe.Mesh(
        np.vstack((mesh.points, [0.0, mesh.points[:, 1].min() - 1e-9])), mesh.cell_points.reshape(-1, 3), "triangle"
    )
    field = felupe.FieldContainer([felupe.FieldPlaneStrain(felupe.RegionTriangle(their_mesh), dim=2)])
    wall = felupe.MultiPointContact(
        field, points=np.unique(mesh.edge_set("arc")), centerpoint=plane, skip=(True, False), multiplier=1e3
    )
    lame = float(rubber.matrix[0, 1])
    body = felupe.SolidBody(felupe.NeoHookeCompressible(mu=rubber.shear_modulus, lmbda=lame), field)
    top = np.unique(mesh.edge_set("top"))
    held, moved = np.isin(np.arange(plane + 1), top), np.arange(plane + 1) == plane
    bounds = {
        "top": felupe.Boundary(field[0], mask=held),
        "across": felupe.Boundary(field[0], mask=moved, skip=(0, 1)),
        "along": felupe.Boundary(field[0], mask=moved, skip=(1, 0)),
    }
    for bounds["along"].value in np.linspace(0.0, depth, 25)[1:]:
        fixed_dofs, free = felupe.dof.partition(field, bounds)
        values = felupe.dof.apply(field, bounds, fixed_dofs)
        felupe.newtonraphson(items=[body, wall], dof0=fixed_dofs, dof1=free, ext0=values, verbose=0, tol=1e-6)
    return -body.assemble.vector(field).toarray().reshape(-1, 2)[top, 1].sum()


def test_a_rubber_roller_on_a_rigid_plane():
    """Half a roller of radius 20 that is pressed by 6: the force to 0.5 %."""
    angles, rubber, depth = np.linspace(np.pi, 2.0 * np.pi, 41), Elastic(1.0, 0.45), 6.0
    points = 20.0 * np.column_stack((np.cos(angles), np.sin(angles)))
    chords = [("arc", Line(tuple(a), tuple(b))) for a, b in pairwise(points)]
    mesh = triangulate(Outline.named([*chords, ("top", Line(tuple(points[-1]), tuple(points[0])))]), size=3.0)
    roller = Part("roller", Body("roller", mesh, Lagrange(1), rubber, "top"))
    plate = rectangle_grid(60.0, 2.0, 30, 1, origin=(-30.0, -22.0))
    plane = Part("plane", Body("plane", plate, Lagrange(1), Elastic(1e6, 0.3), "bottom"))
    surfaces = Surface(roller, mesh.edge_set("arc")), Surface(plane, plate.edge_set("top"))
    result = press_nonlinear(
        [Contact(*surfaces, SegmentToSegment(), Multiplier())],
        {plane: Placement(0.0, (0.0, depth))},
        {roller: NeoHooke(rubber)},
        steps=StepSettings(first=0.25, maximum=0.5, smallest=1 / 64),
    )
    assert result.status.converged
    assert "not linear" not in result.status.message
    assert result.contact.forces[0, 1] == pytest.approx(their_force(mesh, rubber, depth), rel=5e-3)
