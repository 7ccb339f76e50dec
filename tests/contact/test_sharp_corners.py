"""Sharp corners in segment-to-segment contact."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def pressed(pairing: NodeToSegment | SegmentToSegment) -> ContactSolution:
    """A square of 4 mm on its corner, held by its upper sides, pressed 0.2 mm into a block; elements of 1 mm."""
    r = 2.0 * np.sqrt(2.0)
    corners = [(0.0, 0.0), (0.75 * r, 0.75 * r), (r, r), (0.0, 2.0 * r), (-r, r), (-0.75 * r, 0.75 * r)]
    square = polygon(corners, ["right", "above_right", "upper_right", "upper_left", "above_left", "left"])
    held = {"upper_right": "xy", "upper_left": "xy"}
    die = Part("die", Body("die", triangulate(square, size=1.0), Lagrange(1), STEEL, held))
    ground = triangulate(rectangle(20.0, 10.0, centre=(0.0, -5.0)), size=1.0)
    block = Part("block", Body("block", ground, Lagrange(1), STEEL, "bottom"))
    sides = np.concatenate([die.body.mesh.edge_set(name) for name in ("left", "right")])
    surfaces = Surface(die, sides), Surface(block, ground.edge_set("top"))
    return press([Contact(*surfaces, pairing, Multiplier())], {die: Placement(0.0, (0.0, -0.2))})


def test_sharp_corners() -> None:
    """A square pressed into a block by its corner bears what it bears node by node, and does not overlap it."""
    by_segments, by_nodes = pressed(SegmentToSegment()), pressed(NodeToSegment())
    assert by_segments.status.converged
    assert by_segments.forces[0, 1] == pytest.approx(by_nodes.forces[0, 1], rel=0.03)
    corner = by_segments.state.positions[by_segments.system.nodes_of(by_segments.system.contacts[0].secondary)].min(
        axis=0
    )
    on_block = by_segments.state.positions[by_segments.system.nodes_of(by_segments.system.contacts[0].primary)]
    assert corner[1] >= on_block[:, 1].min() - 1e-9
