"""A coarse secondary surface in node-to-segment contact."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def pressed(pairing: NodeToSegment | SegmentToSegment) -> ContactSolution:
    """A box in elements of 2 mm, the secondary side, pressed 0.01 mm on a block in elements of 0.4 mm."""
    box = triangulate(rectangle(8.0, 4.0, centre=(0.0, 2.0)), size=2.0)
    upper = Part("upper", Body("upper", box, Lagrange(1), STEEL, "top"))
    ground = triangulate(rectangle(20.0, 10.0, centre=(0.0, -5.0)), size=0.4)
    lower = Part("lower", Body("lower", ground, Lagrange(1), STEEL, "bottom"))
    surfaces = Surface(upper, box.edge_set("bottom")), Surface(lower, ground.edge_set("top"))
    return press([Contact(*surfaces, pairing, Multiplier())], {upper: Placement(0.0, (0.0, -0.01))})


def test_coarse_secondary() -> None:
    """A coarse secondary bears by nodes what it bears by segments; no node of the block stays inside of it."""
    solution = pressed(NodeToSegment())
    assert solution.status.converged
    assert solution.forces[0, 1] == pytest.approx(pressed(SegmentToSegment()).forces[0, 1], rel=0.005)
    box, block = (
        solution.state.positions[solution.system.nodes_of(side)]
        for side in (
            solution.system.contacts[0].secondary,
            solution.system.contacts[0].primary,
        )
    )
    box = box[np.argsort(box[:, 0])]
    under = block[np.abs(block[:, 0]) < 3.999]
    assert (under[:, 1] - np.interp(under[:, 0], box[:, 0], box[:, 1])).max() < 1e-4
