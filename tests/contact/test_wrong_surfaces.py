"""Bodies that overlap where no contact was looked for."""

import numpy as np

from flangeway.contact import Contact, ContactSolution, Penalty, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)


def pressed(depth: float) -> ContactSolution:
    """A box whose upper sides alone are named, pressed into a block; elements of 8 mm."""
    box = triangulate(rectangle(16.0, 24.0, centre=(0.0, 12.0)), size=8.0)
    upper = Part("upper", Body("upper", box, Lagrange(1), STEEL, "top"))
    ground = triangulate(rectangle(64.0, 32.0, centre=(0.0, -16.0)), size=8.0)
    lower = Part("lower", Body("lower", ground, Lagrange(1), STEEL, "bottom"))
    left = box.edge_set("left")
    wrong = left[(box.points[left][..., 1] < 20.0).all(axis=1)]
    surfaces = Surface(upper, wrong), Surface(lower, ground.edge_set("top"))
    contact = Contact(*surfaces, SegmentToSegment(), Penalty(1e6, per="length"))
    return press([contact], {upper: Placement(0.0, (0.0, -depth))})


def test_wrong_surfaces() -> None:
    """Bodies that overlap off the listed surfaces have not converged: the message has the place and the depth."""
    solution = pressed(1.9)
    assert not solution.status.converged
    for word in ("overlap by 1.9", " at (", "edges"):
        assert word in solution.status.message
    assert np.isclose(max(each.depth for each in solution.overlaps), 1.9, rtol=0.05)
    assert not pressed(1e-5).status.converged
    assert pressed(-0.1).status.converged
