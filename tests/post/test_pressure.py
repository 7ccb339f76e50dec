"""Contact pressure from nodal forces."""

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, solve_contact
from flangeway.contact import press as press_parts
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part
from flangeway.solve import CondensedBodies


@pytest.mark.parametrize("primary", ["block", "disc"])
def test_a_patch_carries_the_whole_force(press, primary: str) -> None:
    """One patch: its pressures times areas are the contact force, centred where the disc points."""
    problem = press("vem", primary=primary)
    response = CondensedBodies(problem.system.surface_nodes)
    state = solve_contact(response, problem.system, problem.placements(0.05, shift=0.4))
    (patch,) = pressure_patches(problem.system, state)
    assert patch.normal_forces.sum() == pytest.approx(state.forces.sum(), rel=1e-12)
    areas = problem.system.contacts[0].node_areas
    assert patch.normal_forces / patch.pressures == pytest.approx(
        areas[state.linearisation.pairs[0].nodes][state.forces > 0]
    )
    assert patch.centre[0] == pytest.approx(0.4, abs=0.05)
    sign = -1.0 if primary == "disc" else 1.0
    assert sign * patch.force[1] > 0.0
    on_block = patch.secondary_point if primary == "disc" else patch.primary_point
    on_disc = patch.primary_point if primary == "disc" else patch.secondary_point
    assert on_block[1] == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(on_disc[0], on_disc[1] - 50.0) == pytest.approx(50.0, abs=0.02)
    assert not patch.at_edge


def test_a_patch_at_the_end_of_its_surface_says_so(press) -> None:
    """A disc shifted to the end of the candidate zone makes a patch that reaches the edge."""
    problem = press("fem")
    response = CondensedBodies(problem.system.surface_nodes)
    state = solve_contact(response, problem.system, problem.placements(0.05, shift=-6.6))
    assert any(patch.at_edge for patch in pressure_patches(problem.system, state))


def test_a_corner_just_beyond_a_node_has_no_pressure_without_limit() -> None:
    """A block whose corner stands a little beyond a node of the wider secondary one: how little does not matter."""
    steel = Elastic(210e3, 0.3)
    upper, lower = (
        Body(name, rectangle_grid(width, 2.0, n, 4), Lagrange(1), steel, held=held)
        for name, width, n, held in (("upper", 4.0, 8, "top"), ("lower", 8.0, 16, "bottom"))
    )
    ground = Part("lower", lower)
    maximum = []
    for beyond in (1e-5, 1e-3, 0.05, 0.2):
        block = Part("upper", upper, Placement(0.0, (2.0 + beyond, 2.0)))
        above, below = Surface(block, upper.mesh.edge_set("bottom")), Surface(ground, lower.mesh.edge_set("top"))
        contact = Contact(below, above, SegmentToSegment(), Multiplier())
        solution = press_parts([contact], motion={block: Placement(0.0, (0.0, -0.01))})
        assert solution.status.converged
        patches = pressure_patches(solution.system, solution.state)
        assert sum(patch.force for patch in patches) == pytest.approx(solution.forces[0])
        maximum.append(max(patch.pressures.max() for patch in patches))
    assert max(maximum) < 1.5 * min(maximum)
