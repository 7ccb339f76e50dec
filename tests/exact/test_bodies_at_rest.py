"""Bodies that fall onto bodies that fall, with gaps and friction: each contact carries the weight above it."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, circle, polygon
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, BodyForce, Part

STEEL = Elastic(210e3, 0.3)
WEIGHT = 7850e-12 * 9810.0
"""Of steel, N/mm^3; bodies are 1 mm thick."""


def block(name: str, left: float, bottom: float, width: float, height: float, held=None) -> Part:
    """A rectangle of linear triangles."""
    mesh = rectangle_grid(width, height, round(width / 0.5), max(2, round(height / 0.5)), origin=(left, bottom))
    return Part(name, Body(name, mesh, Lagrange(1), STEEL, held))


def on(upper: Part, lower: Part, friction: float = 0.3) -> Contact:
    """The lower side of one on the upper side of the other."""
    sides = [Surface(part, part.body.mesh.edge_sets[name]) for part, name in ((upper, "bottom"), (lower, "top"))]
    return Contact(*sides, SegmentToSegment(), Multiplier(), friction)


def at_rest(contacts: list[Contact], falling: list[Part]) -> ContactSolution:
    """Weights on some parts."""
    loads = {part: [BodyForce((0.0, -WEIGHT))] for part in falling}
    solution = press(contacts, {}, body_loads=loads)
    assert solution.status.converged, solution.status.message
    return solution


@pytest.mark.parametrize("gap", [0.01, 0.4, 7.0])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_blocks_fall_on_blocks_that_fall(gap: float, friction: float) -> None:
    """Two blocks above a base with the same gap between all: the lower contact carries both, the upper one its own."""
    base, lower, upper = (
        block("base", -5.0, -2.0, 10.0, 2.0, "bottom"),
        block("lower", -2.0, gap, 4.0, 2.0),
        block("upper", -1.5, 2.0 + 2.0 * gap, 3.0, 2.0),
    )
    solution = at_rest([on(lower, base, friction), on(upper, lower, friction)], [lower, upper])
    np.testing.assert_allclose(solution.forces[:, 1], [14.0 * WEIGHT, 6.0 * WEIGHT], rtol=1e-6)
    np.testing.assert_allclose(solution.forces[:, 0], 0.0, atol=1e-6 * WEIGHT)
    np.testing.assert_allclose(solution.placement(upper).translation, (0.0, -2.0 * gap), atol=1e-5)


def test_a_plate_comes_to_rest_on_two_blocks_of_which_one_is_shorter() -> None:
    """It tips about the higher block onto the one that is 0.01 mm shorter; each carries half of it, and itself."""
    base, left, right, plate = (
        block("base", -8.0, -2.0, 16.0, 2.0, "bottom"),
        block("left", -5.0, 0.0, 2.0, 2.0),
        block("right", 3.0, 0.0, 2.0, 1.99),
        block("plate", -6.0, 2.0, 12.0, 1.0),
    )
    solution = at_rest([on(left, base), on(right, base), on(plate, left), on(plate, right)], [left, right, plate])
    x, y = solution.forces.T
    assert y[0] + y[1] == pytest.approx((4.0 + 3.98 + 12.0) * WEIGHT, rel=1e-6)
    assert y[2] + y[3] == pytest.approx(12.0 * WEIGHT, rel=1e-6)
    # it is touched at the corners at -3 and +5 or +3, left and right of its centre of gravity
    assert 3.0 / 8.0 - 0.03 <= y[3] / (12.0 * WEIGHT) <= 0.5 + 0.03
    assert (np.abs(x) <= 0.3 * y * (1.0 + 1e-6)).all()
    assert solution.placement(plate).rotation_rad == pytest.approx(-0.01 / 6.0, rel=0.4)


def test_a_pile_of_cylinders_comes_to_rest() -> None:
    """A cylinder falls between two that lie in a trough: it presses each by half of its weight over cos 30 degrees."""
    mesh = triangulate(circle(2.0), size=0.5)

    def cylinder(name: str, x: float, y: float) -> Part:
        return Part(name, Body(name, mesh, Lagrange(1), STEEL), placement=Placement(0.0, (x, y)))

    trough = block("trough", -4.0, -2.0, 8.0, 2.0, "bottom")
    walls = [block("wall 0", -6.0, -2.0, 2.0, 6.0, "left"), block("wall 1", 4.0, -2.0, 2.0, 6.0, "right")]
    lower = [cylinder("left", -2.0, 2.02), cylinder("right", 2.0, 2.02)]
    upper = cylinder("upper", 0.0, 2.02 + np.sqrt(12.0) + 0.05)

    def round_on(one: Part, other: Part, side: str = "") -> Contact:
        edges = other.body.mesh.edge_sets[side] if side else other.body.boundary_edges
        drawn = circle(2.0)
        surfaces = Surface(one, one.body.boundary_edges, drawn), Surface(other, edges, None if side else drawn)
        return Contact(*surfaces, SegmentToSegment(), Multiplier(), 0.1)

    contacts = [round_on(upper, part) for part in lower]
    contacts += [round_on(part, trough, "top") for part in lower]
    contacts += [round_on(lower[0], walls[0], "right"), round_on(lower[1], walls[1], "left")]
    solution = at_rest(contacts, [*lower, upper])
    each = WEIGHT * float(np.pi) * 4.0
    y = solution.forces[:, 1]
    np.testing.assert_allclose(y[:2].sum(), each, rtol=0.02)
    assert y[2:].sum() == pytest.approx(3.0 * each, rel=0.02)


def test_no_equilibrium_is_said_with_the_motion_that_nothing_holds() -> None:
    """A load of 0.4 of the weight slides a block on friction 0.3; a block beside its base falls: few solutions."""
    base, falls = block("base", -5.0, -2.0, 10.0, 2.0, "bottom"), block("falls", -2.0, 0.01, 4.0, 2.0)
    beside = block("beside", 20.0, 0.01, 4.0, 2.0)
    for part, load in ((falls, (0.4 * WEIGHT, -WEIGHT)), (beside, (0.0, -WEIGHT))):
        messages: list[str] = []
        loads = {part: [BodyForce(load)]}
        solution = press([on(part, base)], {}, body_loads=loads, progress=messages.append)
        assert not solution.status.converged
        assert len(messages) <= 5
        assert f"`{part.name}` can slide" in solution.status.message
        assert "smaller steps" not in solution.status.message


@pytest.mark.parametrize("turn", [0.0, 0.1])
def test_a_wheel_of_twelve_sides_falls_on_one_of_them_on_a_slope(turn: float) -> None:
    """A slope of 0.2 rad, below friction and half the angle of a side: it comes to rest, and nothing slides away."""
    corners = 1.5 * np.exp(1j * (2.0 * np.pi * (np.arange(12) + 0.5) / 12.0 - np.pi / 2.0))
    mesh = triangulate(polygon(np.column_stack((corners.real, corners.imag)).tolist()), size=0.5)
    base = block("base", -15.0, -2.0, 30.0, 2.0, "bottom")
    wheel = Part("wheel", Body("wheel", mesh, Lagrange(1), STEEL), placement=Placement(turn, (0.0, 1.55)))
    sides = Surface(wheel, mesh.boundary_edges), Surface(base, base.body.mesh.edge_sets["top"])
    contact = Contact(*sides, NodeToSegment(), Multiplier(), 0.4)
    load = BodyForce((WEIGHT * np.sin(0.2), -WEIGHT * np.cos(0.2)))
    solution = press([contact], {}, body_loads={wheel: [load]})
    assert solution.status.converged, solution.status.message
    weight = 0.5 * 12.0 * 1.5**2 * np.sin(np.pi / 6.0) * WEIGHT
    np.testing.assert_allclose(solution.forces, [[-weight * np.sin(0.2), weight * np.cos(0.2)]], rtol=1e-5)
