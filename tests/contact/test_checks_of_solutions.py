"""Paths through bodies, large strains, gaps under pressure, nodes that left their partners."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.contact import (
    Barrier,
    Contact,
    ContactSolution,
    Enforcement,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Pairing,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.post import check_contact, pressure_patches
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def blocks(pairing: Pairing, law: Enforcement | None = None, friction: float = 0.0, n: int = 8) -> Contact:
    """A block of 4 x 4 mm above one of 10 x 10 mm, held at its top and its bottom."""
    upper = rectangle_grid(4.0, 4.0, n, 4, origin=(-2.0, 0.0))
    lower = rectangle_grid(10.0, 10.0, 20, 8, origin=(-5.0, -10.0))
    top = Part("upper", Body("upper", upper, Lagrange(1), STEEL, "top"))
    base = Part("lower", Body("lower", lower, Lagrange(1), STEEL, "bottom"))
    sides = Surface(top, upper.edge_sets["bottom"]), Surface(base, lower.edge_sets["top"])
    return Contact(*sides, pairing, law or Multiplier(), friction)


def moved(contact: Contact, *shifts: tuple[float, float]) -> ContactSolution:
    """The upper part moved by shifts, one after the other."""
    return press([contact], [{contact.secondary.part: Placement(0.0, shift)} for shift in shifts])


def test_a_body_that_moved_through_another_has_not_converged() -> None:
    """Below the plate nothing touches, but the way leads through it; beside and above it leads nowhere."""
    contact = blocks(SegmentToSegment())
    through = moved(contact, (0.0, -100.0))
    assert not through.status.converged
    assert "moved through" in through.status.message or through.status.checks is None
    for shifts in ([(0.0, 50.0)], [(50.0, 0.0), (0.0, -100.0)], [(0.0, -0.01), (0.0, 0.02)]):
        assert moved(contact, *shifts).status.converged


def test_strains_beyond_the_linear_range_are_said_with_their_size() -> None:
    """The largest strain grows with the motion; a notice names it from 5 % on."""
    small, large = (moved(blocks(NodeToSegment()), (0.0, -depth)) for depth in (0.01, 1.0))
    assert small.status.checks is not None
    assert large.status.checks is not None
    assert small.status.checks.warnings == ()
    assert large.status.checks.max_strain == pytest.approx(100.0 * small.status.checks.max_strain, rel=0.1)
    assert large.status.checks.max_strain > 0.05
    assert "not linear" in large.status.message


def test_an_unbalanced_solution_is_refused() -> None:
    """A nodal force changed by a thousandth in a state that had converged is an error of balance."""
    contact = blocks(NodeToSegment())
    solution = moved(contact, (0.0, -0.01))
    forces = solution.state.nodal_forces.copy()
    forces[np.abs(forces).sum(axis=1).argmax()] *= 1.001
    wrong = replace(solution, state=replace(solution.state, nodal_forces=forces))
    given = [(part.placement, None) for part in solution.system.parts]
    assert wrong.checked(given).status.converged is False
    assert solution.checked(given).status.converged


def test_a_gap_under_pressure_is_warned_of() -> None:
    """The gap of a barrier that makes the force a fifth too large or more is named; multipliers leave none."""
    exact, apart = (moved(blocks(NodeToSegment(), law), (0.0, -0.01)) for law in (Multiplier(), Barrier(1.0, 0.01)))
    assert apart.forces[0, 1] > 1.2 * exact.forces[0, 1]
    for solution, warns in ((exact, False), (apart, True)):
        patches = pressure_patches(solution.system, solution.state)
        checks = check_contact(solution.system, solution.state, patches, ["contact"], "finer", "stiffer")
        assert any("apart under pressure" in each for each in checks.warnings) == warns


@pytest.mark.parametrize(("slide", "converged"), [(0.05, True), (0.5, False)])
def test_nodes_that_left_their_partners_have_not_converged(slide: float, converged: bool) -> None:
    """A slide by a tenth of an edge is small; one by an edge or two fails, with the advice to match the boundaries."""
    solution = moved(blocks(NodeToNode()), (0.0, -0.01), (slide, 0.0))
    assert solution.status.converged == converged, solution.status.message
    if not converged:
        assert "match the boundaries" in solution.status.message
