"""Loads, springs and given displacements of bodies in contact: exact solutions, and the same by other routes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway import Body, Elastic, Lagrange, Part, Placement, Virtual
from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.errors import InputError
from flangeway.mesh import rectangle_grid
from flangeway.problems import (
    BodyForce,
    Gravity,
    PointForce,
    PrescribedDisplacement,
    Pressure,
    Spring,
    TemperatureChange,
    Traction,
)
from flangeway.solve import Handle, StepSettings

STEEL = Elastic(210e3, 0.3, density=7.85e-9, expansion=1.2e-5)


def block(
    name, width, height, cells, origin=(0.0, 0.0), held=None, *, element=None, placement=None, springs=()
) -> Part:
    mesh = rectangle_grid(width, height, *cells, origin=origin)
    body = Body(name, mesh, element or Lagrange(1), STEEL, held, springs=springs)
    return Part(name, body, placement or Placement())


def on(upper: Part, lower: Part, friction: float = 0.0, pairing=None) -> Contact:
    faces = [Surface(part, part.body.mesh.edge_sets[name]) for part, name in ((upper, "bottom"), (lower, "top"))]
    return Contact(*faces, pairing or SegmentToSegment(), Multiplier(), friction)


def base(placement=None) -> Part:
    return block("base", 20.0, 5.0, (20, 5), (-10.0, -5.0), "bottom", placement=placement)


@settings(max_examples=12, deadline=None)
@given(
    order=st.sampled_from([1, 2]),
    virtual=st.booleans(),
    path=st.sampled_from(["condensed", "sparse"]),
    turn=st.floats(-3.0, 3.0),
    push=st.floats(-0.25, 0.25),
    gap=st.sampled_from([0.0, 0.3, 7.0]),
)
def test_contact_carries_the_loads_of_a_floating_body(order, virtual, path, turn, push, gap) -> None:
    """Weight, pressure, traction and a point force, in any direction: forces and moment are in balance to 1e-9."""
    element, turned = Virtual(order) if virtual else Lagrange(order), Placement(turn)
    top = block("top", 10.0, 4.0, (7, 3), (-5.0, gap), element=element, placement=turned)
    lower = base(turned)
    push = push if gap < 1.0 else 0.0  # a body far away moves along its load, which has to lead to the base
    down = -turned.matrix[:, 1]
    along = turned.matrix[:, 0]
    loads = [
        BodyForce(tuple(0.5 * down)),
        Traction("left", tuple(push * 40.0 * along / 4.0)),
        PointForce((-5.0, gap + 4.0), tuple(10.0 * down)),
        Pressure("top", 2.0),
    ]
    found = press([on(top, lower, 0.5)], {}, body_loads={top: loads}, path=path, steps=StepSettings())
    assert found.status.converged, found.status.message
    field, moved = found.field(top), found.placement(top)
    n = len(top.body.nodes)
    places = moved.points(top.body.nodes + field.displacements[:n])
    forces = found.nodal_forces(top) + moved.vectors(_at_nodes(field))
    total = 0.5 * 40.0 + 10.0 + 20.0
    # pressures keep the direction of the edges as placed by the motions, here by none
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-9 * total)
    moment = (places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]).sum()
    np.testing.assert_allclose(moment, 0.0, atol=2e-4 * total if virtual and order == 2 else 1e-8 * total)


def _at_nodes(field):
    """Loads at nodes; those on unknowns inside of cells are moved to the nodes of the cell by its condensation."""
    return field.problem.condensed_stiffness().condense(field.problem.load_vector())


def test_sparse_and_condensed_bodies_agree() -> None:
    """Temperature, springs and a given displacement in one problem: both routes give the same fields to 1e-9."""
    fields = {}
    for path in ("condensed", "sparse"):
        upper = block("upper", 10.0, 4.0, (6, 3), held="top", element=Lagrange(2))
        lower = block("lower", 20.0, 4.0, (9, 3), (-5.0, -4.0), springs=[Spring("bottom", x=50.0, y=400.0)])
        loads = {
            upper: [PrescribedDisplacement("top", x=0.0, y=lambda points: -0.01 - 1e-3 * points[:, 0])],
            lower: [TemperatureChange(lambda points: 20.0 + points[:, 1]), Gravity((0.0, -9810.0))],
        }
        found = press([on(upper, lower, 0.2)], {}, body_loads=loads, path=path)
        assert found.status.converged, found.status.message
        fields[path] = [found.field(part).displacements for part in (upper, lower)]
        assert found.forces[0, 1] > 100.0
    for one, other in zip(*fields.values(), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(one).max())


def test_springs_carry_what_presses_on_them() -> None:
    """A block on a spring foundation under a pressed one sinks by the pressure over the stiffness, to 1e-3."""
    lower = block("lower", 10.0, 4.0, (5, 2), (0.0, -4.0), {"left": "x"}, springs=[Spring("bottom", y=10.0)])
    upper = block("upper", 10.0, 4.0, (5, 2))
    found = press([on(upper, lower)], {}, body_loads={upper: [Pressure("top", 5.0)]})
    assert found.status.converged, found.status.message
    bottom = np.abs(lower.body.nodes[:, 1] + 4.0) < 1e-9
    np.testing.assert_allclose(found.field(lower).displacements[bottom, 1], -0.5, rtol=1e-3)


def test_a_body_on_springs_approaches_what_it_is_pressed_against() -> None:
    """A loaded handle 7 mm away on springs: the contact carries what the springs leave at its way."""
    upper = block("upper", 10.0, 4.0, (5, 2), (0.0, 7.0), "top")
    lower = block("lower", 10.0, 4.0, (5, 2), (0.0, -4.0), "bottom")
    handle = Handle(
        (upper,), np.array([5.0, 11.0]), load=np.array([0.0, -30.0, 0.0]), stiffness=np.diag([9.0, 3.0, 99.0])
    )
    found = press([on(upper, lower)], {}, handles=[handle])
    assert found.status.converged, found.status.message
    assert found.forces[0, 1] == pytest.approx(30.0 - 3.0 * 7.0, rel=1e-4)
    soft = press([on(upper, lower)], {}, handles=[replace(handle, stiffness=np.diag([9.0, 5.0, 99.0]))])
    assert soft.status.converged, soft.status.message
    np.testing.assert_allclose(soft.placement(upper).translation, (0.0, -6.0), atol=1e-9)
    assert not soft.forces.any()


@pytest.mark.ci
def test_displacements_do_not_move_a_body_through_another() -> None:
    """What is held of a block moves below the plate: not converged. Beside the plate it passes."""
    lower = base()
    for left, through in ((-2.0, True), (28.0, False)):
        upper = block("upper", 4.0, 2.0, (4, 2), (left, 0.5), "top")
        given = {upper: [PrescribedDisplacement("top", 0.0, -8.5)]}
        assert press([on(upper, lower)], {}, body_loads=given).status.converged is not through


def test_loads_that_pull_a_body_away_are_said() -> None:
    """Nothing within twice the size of the bodies: the message names the part and its motion, and nothing converged."""
    top = block("top", 10.0, 4.0, (5, 2), (-5.0, 1.0))
    found = press([on(top, base())], {}, body_loads={top: [Traction("top", (0.0, 1.0))]})
    assert not found.status.converged
    assert "`top` can slide in y" in found.status.message


@pytest.mark.parametrize(
    ("items", "given"),
    [
        ([Traction("nowhere", (1.0, 0.0))], "nowhere"),
        ([Pressure("top", 1.0), Spring("left", x=1.0)], "Spring"),
        ([PrescribedDisplacement("left", x=0.1)], "left"),
        ([TemperatureChange(1.0, cells="core")], "core"),
        (Pressure("top", 1.0), "body_loads"),
    ],
)
def test_loads_that_do_not_fit_are_refused(items, given) -> None:
    """Unknown sets, supports among loads, displacements of what is free: the error names what was given."""
    top = block("top", 10.0, 4.0, (5, 2), (-5.0, 0.0))
    with pytest.raises(InputError) as caught:
        press([on(top, base())], {}, body_loads={top: items})
    assert given in f"{caught.value.given} {caught.value.allowed}"
