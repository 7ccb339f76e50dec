"""Gaps that a barrier leaves, and nodes that slide from those opposite them, are said."""

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
    Surface,
    press,
)
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.post import check_contact, pressure_patches
from flangeway.problems import Body, Part

EDGE_MM, DEPTH_MM = 0.25, 0.01


def pressed(law: Enforcement, pairing: Pairing, *, shift: float = 0.0, friction: float = 0.0) -> ContactSolution:
    """A block of 4 x 4 mm pressed on one of 10 x 10 mm with matching nodes, then moved along it."""
    meshes = {
        "upper": (rectangle_grid(4.0, 4.0, 16, 4, origin=(-2.0, 0.0)), "top"),
        "lower": (rectangle_grid(10.0, 10.0, 40, 8, origin=(-5.0, -10.0)), "bottom"),
    }
    upper, lower = (
        Part(name, Body(name, mesh, Lagrange(1), Elastic(210e3, 0.3), held)) for name, (mesh, held) in meshes.items()
    )
    sides = [Surface(part, part.body.mesh.edge_sets[name]) for part, name in ((upper, "bottom"), (lower, "top"))]
    path = [{upper: Placement(0.0, (0.0, -DEPTH_MM))}, *([{upper: Placement(0.0, (shift, 0.0))}] if shift else [])]
    return press([Contact(*sides, pairing, law, friction)], path)


@pytest.mark.parametrize("law", [Barrier(1.0, 0.01)])
def test_a_gap_under_pressure_is_warned_of(law: Barrier) -> None:
    """The gap of a barrier that makes the force a fifth too large or more is named; multipliers leave none."""
    exact, apart = pressed(Multiplier(), NodeToSegment()), pressed(law, NodeToSegment())
    assert apart.forces[0, 1] > 1.2 * exact.forces[0, 1]
    for solution, warns in ((exact, False), (apart, True)):
        patches = pressure_patches(solution.system, solution.state)
        checks = check_contact(solution.system, solution.state, patches, ["contact"], "finer", "stiffer")
        assert any("apart under pressure" in each for each in checks.warnings) == warns


@pytest.mark.parametrize(("edges", "converged"), [(0.1, True), (1.0, False)])
def test_nodes_that_left_their_partners_have_not_converged(edges: float, converged: bool) -> None:
    """A slide by a tenth of an edge is small; one by an edge or two fails, with the advice to match the boundaries."""
    solution = pressed(Multiplier(), NodeToNode(), shift=edges * EDGE_MM)
    assert solution.status.converged == converged, solution.status.message
    if not converged:
        assert "match the boundaries" in solution.status.message
