"""A primary that is narrower than the distance of the secondary's nodes."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def force(pairing: NodeToSegment | SegmentToSegment) -> float:
    """Force of a punch 1 mm wide, pressed 0.05 mm between two nodes of a block that are 4 mm apart."""
    tool = triangulate(rectangle(1.0, 2.0, centre=(1.2, 1.0)), size=0.5)
    punch = Part("punch", Body("punch", tool, Lagrange(1), STEEL, "top"))
    ground = rectangle_grid(40.0, 20.0, 10, 5).placed(Placement(0.0, (-20.0, -20.0)))
    block = Part("block", Body("block", ground, Lagrange(1), STEEL, "bottom"))
    surfaces = Surface(block, ground.edge_set("top")), Surface(punch, tool.edge_set("bottom"))
    solution = press([Contact(*surfaces, pairing, Multiplier())], {punch: Placement(0.0, (0.0, -0.05))})
    assert isinstance(solution, ContactSolution)
    assert solution.status.converged
    return float(solution.forces[0, 1])


def test_narrow_punch() -> None:
    """A punch between two secondary nodes bears by nodes what it bears by segments."""
    by_nodes = force(NodeToSegment())
    assert np.isfinite(by_nodes)
    assert by_nodes == pytest.approx(force(SegmentToSegment()), rel=0.01)
