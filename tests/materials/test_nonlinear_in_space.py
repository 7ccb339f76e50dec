"""Nonlinear materials in space: plane strain, patch tests on polyhedra, Hill's plastic ball."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.problems import Elasticity, PrescribedDisplacement, Spring, Traction
from flangeway.solve import solve_elasticity, solve_nonlinear
from flangeway.space import Space
from flangeway_studies.polyhedra import HILL, plastic_ball
from tests.polyhedra import voronoi_box

ELASTIC = Elastic(200.0, 0.3)
MATERIALS = {
    "neo-Hooke": NeoHooke(ELASTIC),
    "perfect": J2Plasticity(ELASTIC, 0.3),
    "hardening": J2Plasticity(ELASTIC, 0.3, isotropic=7.0, kinematic=11.0),
}
RNG = np.random.default_rng(5)
GRADIENTS = 0.01 * RNG.standard_normal((20, 3, 3))


@pytest.mark.parametrize("name", MATERIALS)
def test_plane_strain_is_strain_in_space_without_that_along_z(name):
    """With a gradient in the plane alone stress and history of two steps are those of the plane."""
    material, plane = MATERIALS[name], np.zeros((20, 3, 3))
    histories = (np.zeros((20, material.n_history)),) * 2
    for factor in (1.0, -2.0):
        plane[:, :2, :2] = factor * GRADIENTS[:, :2, :2]
        one, other = material.respond(plane[:, :2, :2], histories[0]), material.respond(plane, histories[1])
        assert other.stress[:, :2, :2] == pytest.approx(one.stress, rel=1e-12, abs=1e-13)
        assert other.history == pytest.approx(one.history, rel=1e-12, abs=1e-15)
        histories = one.history, other.history


@pytest.mark.parametrize("name", MATERIALS)
def test_a_uniform_gradient_strains_every_polyhedron_alike(name):
    """A linear displacement on the boundary of Voronoi cells gives their points inside, and one stress."""
    gradient = 0.02 * np.array([[1.0, 0.4, -0.3], [0.2, -0.5, 0.6], [0.3, 0.1, 0.7]])
    mesh = voronoi_box(30)
    mesh = mesh.with_face_set("all", mesh.boundary_faces)
    x, y, z = (lambda p, row=row: p @ row for row in gradient)
    problem = Elasticity(Space(mesh, Virtual(1)), ELASTIC, supports=[PrescribedDisplacement("all", x, y, z=z)])
    material = MATERIALS[name]
    (solution,) = solve_nonlinear(problem, material)
    assert solution.status.converged
    assert np.abs(solution.displacements - mesh.points @ gradient.T).max() < 1e-10
    exact = material.respond(gradient[None], np.zeros((1, material.n_history))).stress
    assert np.abs(solution.stress - exact).max() < 1e-8 * np.abs(exact).max()


def test_at_small_loads_it_is_the_elastic_solution():
    """Below the yield stress loads, springs and supports give the solution of linear elasticity."""
    mesh = voronoi_box(30)
    problem = Elasticity(
        Space(mesh, Virtual(1)),
        ELASTIC,
        loads=[Traction("z+", (0.01, 0.0, 0.02))],
        supports=[PrescribedDisplacement("z-", 0.0, 0.0, z=0.0), Spring("x+", x=1.0, y=1.0, z=1.0)],
    )
    (solution,) = solve_nonlinear(problem, J2Plasticity(ELASTIC, 1.0))
    linear = solve_elasticity(problem).displacements
    assert np.abs(solution.displacements - linear).max() < 1e-9 * np.abs(linear).max()


def test_a_ball_yields_as_hill_says():
    """The displacement inside of a hollow ball that yields up to a tenth of its radius is within 2 % of Hill's."""
    inside, outside = plastic_ball(180.0, 4, 16)
    assert (inside, outside) == pytest.approx(HILL[180.0], rel=0.02)
