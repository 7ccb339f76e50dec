"""A sharp corner exactly on a sharp corner."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, polygon
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def pressed(
    pairing: NodeToSegment | SegmentToSegment, lateral_offset: float, motion: tuple[float, float]
) -> ContactSolution:
    """Two blocks of 4 mm whose corners meet at the origin, or one of them aside, of which the upper is moved."""
    points = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (4.0, 4.0), (0.0, 4.0), (0.0, 3.0)])
    upper, lower = (
        polygon(points, ["bottom", "lower_right", "right", "top", "upper_left", "left"]),
        polygon(-points, ["top", "upper_left", "left", "bottom", "lower_right", "right"]),
    )
    die = Part(
        "die", Body("die", triangulate(upper, size=1.0), Lagrange(1), STEEL, {"right": "xy", "top": "xy"}),
        placement=Placement(0.0, (lateral_offset, 0.0)),
    )  # fmt: skip
    block = Part(
        "block", Body("block", triangulate(lower, size=1.0), Lagrange(1), STEEL, {"left": "xy", "bottom": "xy"})
    )
    surfaces = [
        Surface(part, np.concatenate([part.body.mesh.edge_set(name) for name in names]))
        for part, names in ((die, ("left", "bottom")), (block, ("right", "top")))
    ]
    contact = Contact(surfaces[0], surfaces[1], pairing, Multiplier())
    return press([contact], {die: Placement(0.0, motion)})


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
def test_corner_on_corner(pairing: NodeToSegment | SegmentToSegment) -> None:
    """A corner pressed on a corner along the diagonal is said to be arbitrary; beside it nothing is said."""
    for lateral_offset, said in ((0.0, True), (-0.5, False)):
        solution = pressed(pairing, lateral_offset, (-0.01, -0.01))
        assert solution.status.converged
        assert ("a corner meets a corner at (-0.01, -0.01)" in solution.status.message) == said
