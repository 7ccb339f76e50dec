"""Reactions balance the loads and are shared by the supports that hold; nodes are in equilibrium."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid, triangulate
from flangeway.post import reactions, relative_nodal_residual
from flangeway.problems import (
    BodyForce,
    ElasticField,
    Elasticity,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.solve import solve_elasticity
from flangeway.space import Space

GRID = rectangle_grid(2.0, 1.0, 8, 4)
MATERIAL = Elastic(100.0, 0.3)


@pytest.mark.parametrize("space", [Space(GRID, Lagrange(1)), Space(dual(GRID), Virtual(2)), Space(GRID, Lagrange(3))])
def test_all_reactions_balance_the_loads(space: Space) -> None:
    """Forces and moments of every kind of support and of all loads add up to nothing."""
    supports = [
        PrescribedDisplacement("bottom", y=0.01, angle=0.2),
        Spring("right", x=30.0, y=5.0, angle=-0.4),
        PrescribedDisplacement((2.0, 0.0), x=0.003),
        RigidHandle("top", y=-0.02, moment=0.4, pivot=(0.5, 1.0)),
        PrescribedDisplacement("left", x=0.0),
    ]
    loads = [Traction("left", (1.0, 2.0)), BodyForce((0.5, -0.25)), Pressure("right", 0.3)]
    solution = solve_elasticity(Elasticity(space, MATERIAL, loads=loads, supports=supports))
    answer = reactions(solution)
    assert [reaction.support for reaction in answer] == supports
    applied = np.array([1.0 + 1.0 - 0.3, 2.0 - 0.5])
    assert sum(reaction.force for reaction in answer) == pytest.approx(-applied, abs=1e-9)
    moments = -0.5 * 1.0 + (1.0 * -0.5 - 0.5 * 1.0) + 0.5 * 0.3 + 0.4
    assert sum(reaction.moment for reaction in answer) == pytest.approx(-moments, abs=1e-9)


def test_a_corner_held_by_two_supports_is_shared_by_direction() -> None:
    """At a corner, the horizontal force belongs to the support that holds x and the vertical one to that of y."""
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement("bottom", y=0.0)]
    loads = [Traction("right", (3.0, 0.0)), Traction("top", (0.0, 2.0))]
    solution = solve_elasticity(Elasticity(Space(GRID, Lagrange(2)), MATERIAL, loads=loads, supports=supports))
    left, bottom = reactions(solution)
    assert left.force == pytest.approx([-3.0, 0.0], abs=1e-10)
    assert left.moment == pytest.approx(0.5 * 3.0)
    assert bottom.force == pytest.approx([0.0, -4.0], abs=1e-10)
    assert bottom.moment == pytest.approx(-4.0)


def test_supports_that_hold_the_same_share_equally() -> None:
    """Two supports of the same edges carry half each."""
    loads = [Traction("right", (3.0, 1.0))]
    solution = solve_elasticity(
        Elasticity(Space(GRID, Lagrange(1)), MATERIAL, loads=loads, supports=[fixed("left"), fixed("left")])
    )
    first, second = reactions(solution)
    assert first.force == pytest.approx(second.force)
    assert first.force == pytest.approx([-1.5, -0.5])


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
