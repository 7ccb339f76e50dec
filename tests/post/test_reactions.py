"""Reactions balance the loads and are shared by the supports that hold."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.post import reactions
from flangeway.problems import (
    BodyForce,
    Elasticity,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
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
