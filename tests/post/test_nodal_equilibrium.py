"""The equilibrium of nodes, checked from displacements alone."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.post import relative_nodal_residual
from flangeway.problems import BodyForce, ElasticField, Elasticity, TemperatureChange, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space


def solved(element):
    """A square under traction, weight and warmth, and which of its components are held."""
    mesh = triangulate(square(1.0), size=0.25)
    space = Space(mesh if isinstance(element, Lagrange) else dual(mesh), element)
    steel = Elastic(210e3, 0.3, expansion=1e-5)
    loads = [Traction("right", (3.0, 5.0)), BodyForce((0.0, -2.0)), TemperatureChange(20.0)]
    solution = solve_elasticity(Elasticity(space, steel, loads=loads, supports=[fixed("left")]))
    held = np.zeros((space.n_nodes, 2), dtype=np.bool_)
    held[solution.problem.support_nodes(fixed("left"))] = True
    return solution, held


@pytest.mark.parametrize("element", [Lagrange(1), Lagrange(2), Virtual(1), Virtual(2), Virtual(3)], ids=str)
def test_a_solution_is_in_equilibrium_at_every_node(element):
    """Loads on edges, in cells and by warmth are in equilibrium with stresses at nodes and in cells to round-off."""
    solution, held = solved(element)
    nothing = np.zeros((solution.problem.space.n_nodes, 2))
    assert relative_nodal_residual(solution, nothing, held) < 1e-11
    assert relative_nodal_residual(solution, nothing, np.zeros_like(held)) > 0.1  # what the support carries


def test_a_moved_node_and_a_missing_force_are_seen():
    """One node moved by a millionth of the size, and a force that is not in the displacements, are no equilibrium."""
    solution, held = solved(Virtual(2))
    space = solution.problem.space
    node = int(np.flatnonzero(~held.any(axis=1))[0])
    wrong = solution.displacements.copy()
    wrong[node] += 1e-6
    nothing, force = np.zeros((space.n_nodes, 2)), np.zeros((space.n_nodes, 2))
    force[node] = 0.1
    assert relative_nodal_residual(ElasticField(solution.problem, wrong), nothing, held) > 1e-3
    assert relative_nodal_residual(solution, force, held) > 1e-3
