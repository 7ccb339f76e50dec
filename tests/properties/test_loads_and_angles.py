"""Loads that do nothing and angles in degrees are refused; what is beside them is accepted and has its effect."""

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import (
    Body,
    Elasticity,
    Part,
    PointForce,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
    Traction,
    fixed,
)
from flangeway.solve import solve_elasticity
from flangeway.space import Space

MESH = rectangle_grid(2.0, 1.0, 4, 2)
STEEL = Elastic(210e3, 0.3)
SPACE = Space(MESH, Lagrange(2))
ROLLER = PrescribedDisplacement("bottom", y=0.0)
PIN = PrescribedDisplacement((0.0, 0.0), x=0.0)

IDLE = {
    "pressure on a clamped edge": ([Pressure("bottom", 3.0)], [fixed("bottom")]),
    "pressure across a roller": ([Pressure("bottom", 3.0)], [ROLLER, PIN]),
    "traction on a clamped edge": ([Traction("left", (1.0, 2.0))], [fixed("left")]),
    "point force on a held point": ([PointForce((0.0, 0.0), (5.0, 0.0))], [ROLLER, PIN]),
    "one of two": ([Pressure("top", 3.0), Pressure("bottom", 3.0)], [fixed("bottom")]),
}
ACTING = {
    "pressure on a free edge": ([Pressure("top", 3.0)], [fixed("bottom")]),
    "traction along a roller": ([Traction("bottom", (1.0, 0.0))], [ROLLER, PIN]),
    "an edge with one held end": ([Pressure("left", 3.0)], [fixed("bottom")]),
    "a free handle": ([Pressure("top", 3.0)], [fixed("bottom"), RigidHandle("top")]),
    "a turned roller": ([Pressure("top", 3.0)], [fixed("bottom"), PrescribedDisplacement("top", x=0.0, angle=0.3)]),
}


@pytest.mark.parametrize("name", IDLE)
def test_loads_on_held_edges_are_refused(name):
    """All that they act on is held: the load would only change a reaction."""
    loads, supports = IDLE[name]
    with pytest.raises(InputError, match="held"):
        solve_elasticity(Elasticity(SPACE, STEEL, loads=loads, supports=supports))


@pytest.mark.parametrize("name", ACTING)
def test_loads_that_displace_anything_are_accepted(name):
    """The body moves, and more with twice the load."""
    loads, supports = ACTING[name]
    solution = solve_elasticity(Elasticity(SPACE, STEEL, loads=loads, supports=supports))
    twice = solve_elasticity(Elasticity(SPACE, STEEL, loads=loads * 2, supports=supports))
    assert np.abs(solution.displacements).max() > 0.0
    np.testing.assert_allclose(twice.displacements, 2.0 * solution.displacements, atol=1e-12)


def _pressed(loads, motion):
    lower = Part("lower", Body("lower", MESH, Lagrange(1), STEEL, "bottom"))
    upper = Part("upper", Body("upper", MESH, Lagrange(1), STEEL, "top"), Placement(0.0, (0.0, 1.0)))
    sides = [Surface(part, MESH.edge_sets[name]) for part, name in ((upper, "bottom"), (lower, "top"))]
    return press([Contact(*sides, SegmentToSegment(), Multiplier())], {upper: motion}, body_loads={upper: loads})


def test_a_contact_refuses_a_pressure_on_a_held_edge():
    """The top of the upper block is held and moved: a pressure there is refused, one on its side is not."""
    down = Placement(0.0, (0.0, -0.001))
    with pytest.raises(InputError, match="held"):
        _pressed([Pressure("top", 3.0)], down)
    assert _pressed([Pressure("left", 3.0)], down).status.converged


@pytest.mark.parametrize("degrees", [90.0, -45.0, 30.0, 180.0, 360.0])
def test_angles_in_degrees_are_refused(degrees):
    """Placements of parts, motions, frames of supports and rotations of handles: the message has np.deg2rad."""
    body = Body("block", MESH, Lagrange(1), STEEL, "bottom")
    for wrong in (
        lambda angle: Part("block", body, Placement(angle)),
        lambda angle: _pressed([], Placement(angle, (0.0, -0.001))),
        lambda angle: PrescribedDisplacement("left", x=0.0, angle=angle),
        lambda angle: Spring("left", x=1.0, angle=angle),
        lambda angle: RigidHandle("left", rotation=angle),
    ):
        with pytest.raises(InputError, match="deg2rad"):
            wrong(degrees)
    assert Part("block", body, Placement(np.deg2rad(degrees))).placement.rotation_rad == np.deg2rad(degrees)
