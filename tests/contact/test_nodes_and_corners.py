"""Meshes and corners that simple searches miss: coarse secondaries, narrow punches, corners, surfaces left out."""

import numpy as np
import pytest

from flangeway.contact import (
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
    press,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.elements import Lagrange
from flangeway.geometry import Outline, Placement, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid, triangulate
from flangeway.problems import Body, Part
from tests.contact.steel_boxes import surface_of

STEEL = Elastic(210e3, 0.3)
PAIRINGS = NodeToSegment(), SegmentToSegment()


def part(name: str, shape: Outline | PolyMesh, held, size: float = 1.0, **where) -> Part:
    """A body of linear triangles of a mesh, or of an outline that is meshed."""
    mesh = shape if isinstance(shape, PolyMesh) else triangulate(shape, size=size)
    return Part(name, Body(name, mesh, Lagrange(1), STEEL, held), **where)


def pressed(
    secondary: tuple[Part, tuple[str, ...]],
    primary: tuple[Part, tuple[str, ...]],
    moved: tuple[Part, tuple[float, float]],
    pairing: Pairing,
    law: Enforcement | None = None,
) -> ContactSolution:
    """Parts along edge sets in contact, one of them moved."""
    sides = (surface_of(body, *names) for body, names in (secondary, primary))
    return press([Contact(*sides, pairing, law or Multiplier())], {moved[0]: Placement(0.0, moved[1])})


def positions(solution: ContactSolution) -> tuple[np.ndarray, np.ndarray]:
    """Moved nodes of the secondary and the primary surface."""
    contact, nodes_of = solution.system.contacts[0], solution.system.nodes_of
    return solution.state.positions[nodes_of(contact.secondary)], solution.state.positions[nodes_of(contact.primary)]


def test_a_coarse_secondary_bears_by_nodes_what_it_bears_by_segments() -> None:
    """A box in elements of 2 mm on a block in elements of 0.4 mm: no node of the block stays inside of the box."""
    box = part("upper", rectangle(8.0, 4.0, centre=(0.0, 2.0)), "top", 2.0)
    block = part("lower", rectangle(20.0, 10.0, centre=(0.0, -5.0)), "bottom", 0.4)
    by_nodes, by_segments = (
        pressed((box, ("bottom",)), (block, ("top",)), (box, (0.0, -0.01)), pairing) for pairing in PAIRINGS
    )
    assert by_nodes.status.converged
    assert by_nodes.forces[0, 1] == pytest.approx(by_segments.forces[0, 1], rel=0.005)
    above, below = positions(by_nodes)
    above = above[np.argsort(above[:, 0])]
    under = below[np.abs(below[:, 0]) < 3.999]
    assert (under[:, 1] - np.interp(under[:, 0], *above.T)).max() < 1e-4


def test_a_narrow_punch_between_two_secondary_nodes_bears_by_nodes_what_it_bears_by_segments() -> None:
    """A punch 1 mm wide, pressed 0.05 mm between nodes of a block that are 4 mm apart."""
    punch = part("punch", rectangle(1.0, 2.0, centre=(1.2, 1.0)), "top", 0.5)
    block = part("block", rectangle_grid(40.0, 20.0, 10, 5, origin=(-20.0, -20.0)), "bottom")
    by_nodes, by_segments = (
        pressed((block, ("top",)), (punch, ("bottom",)), (punch, (0.0, -0.05)), pairing) for pairing in PAIRINGS
    )
    assert by_nodes.status.converged
    assert by_segments.status.converged
    assert by_nodes.forces[0, 1] == pytest.approx(by_segments.forces[0, 1], rel=0.01)


def test_a_square_on_its_corner_bears_by_segments_what_it_bears_by_nodes() -> None:
    """Held by its upper sides and pressed 0.2 mm into a block, it does not overlap the block; elements of 1 mm."""
    r = 2.0 * np.sqrt(2.0)
    corners = [(0.0, 0.0), (0.75 * r, 0.75 * r), (r, r), (0.0, 2.0 * r), (-r, r), (-0.75 * r, 0.75 * r)]
    names = ["right", "above_right", "upper_right", "upper_left", "above_left", "left"]
    die = part("die", polygon(corners, names), {"upper_right": "xy", "upper_left": "xy"})
    block = part("block", rectangle(20.0, 10.0, centre=(0.0, -5.0)), "bottom")
    by_nodes, by_segments = (
        pressed((die, ("left", "right")), (block, ("top",)), (die, (0.0, -0.2)), pairing) for pairing in PAIRINGS
    )
    assert by_segments.status.converged
    assert by_segments.forces[0, 1] == pytest.approx(by_nodes.forces[0, 1], rel=0.03)
    of_die, of_block = positions(by_segments)
    assert of_die[:, 1].min() >= of_block[:, 1].min() - 1e-9


@pytest.mark.parametrize("pairing", PAIRINGS, ids=["nodes", "segments"])
def test_a_corner_pressed_on_a_corner_along_the_diagonal_is_said_to_be_arbitrary(pairing: Pairing) -> None:
    """Two blocks of 4 mm whose corners meet at the origin; with one of them aside nothing is said."""
    points = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (4.0, 4.0), (0.0, 4.0), (0.0, 3.0)])
    upper = polygon(points, ["bottom", "lower_right", "right", "top", "upper_left", "left"])
    lower = polygon(-points, ["top", "upper_left", "left", "bottom", "lower_right", "right"])
    for aside, said in ((0.0, True), (-0.5, False)):
        die = part("die", upper, {"right": "xy", "top": "xy"}, placement=Placement(0.0, (aside, 0.0)))
        block = part("block", lower, {"left": "xy", "bottom": "xy"})
        solution = pressed((die, ("left", "bottom")), (block, ("right", "top")), (die, (-0.01, -0.01)), pairing)
        assert solution.status.converged
        assert ("a corner meets a corner at (-0.01, -0.01)" in solution.status.message) == said


def test_bodies_that_overlap_where_no_contact_was_looked_for_have_not_converged() -> None:
    """A box of which the sides alone are named, pressed into a block: the message has the place and the depth."""
    outline = polygon(
        [(-8.0, 0.0), (8.0, 0.0), (8.0, 24.0), (-8.0, 24.0), (-8.0, 20.0)], ["bottom", "right", "top", "above", "left"]
    )
    for depth, converges in ((1.9, False), (1e-5, False), (-0.1, True)):
        box = part("upper", outline, "top", 8.0)
        block = part("lower", rectangle(64.0, 32.0, centre=(0.0, -16.0)), "bottom", 8.0)
        law = Penalty(1e6, per="length")
        found = pressed((box, ("left",)), (block, ("top",)), (box, (0.0, -depth)), SegmentToSegment(), law)
        assert found.status.converged == converges
        if depth > 1.0:
            for word in ("overlap by 1.9", " at (", "edges"):
                assert word in found.status.message
            assert max(each.depth for each in found.overlaps) == pytest.approx(1.9, rel=0.05)
