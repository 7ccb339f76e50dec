"""Beams that loads press on stops which they do not touch before: beam theory, in any number of steps."""

import pytest

from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.elements import Lagrange
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part, PrescribedDisplacement, Pressure, TemperatureChange, Traction
from flangeway.solve import StepSettings

YOUNG, EXPANSION = 210e3, 12e-6
STEEL = Elastic(YOUNG, 0.3, "plane_stress", expansion=EXPANSION)
LENGTH, HEIGHT, GAP = 100.0, 5.0, 0.2
STIFFNESS = 3.0 * YOUNG * HEIGHT**3 / 12.0 / LENGTH**3
"""Of the tip of a cantilever 1 mm thick, N/mm."""

PAIRINGS = {
    "nodes": (NodeToSegment(), Multiplier()),
    "segments": (SegmentToSegment(), AugmentedLagrange(5e6, per="length", penetration=1e-6)),
}


def rectangle(name: str, corner: tuple[float, float], sides: tuple[float, float], size: float, held, order: int = 2):
    """A rectangle of quadratic elements with its left lower corner at a point."""
    cells = [max(1, round(side / size)) for side in sides]
    mesh = rectangle_grid(*sides, *cells, origin=corner)
    return Part(name, Body(name, mesh, Lagrange(order), STEEL, held))


def cantilever() -> Part:
    """A beam that is held at its left end."""
    return rectangle("beam", (0.0, 0.0), (LENGTH, HEIGHT), 2.5, "left")


def on_stop(beam: Part, stop: Part, pairing: str = "segments", friction: float = 0.0) -> Contact:
    """The beam's lower side on the stop's upper one."""
    edges = beam.body.mesh.edge_sets["bottom"]
    edges = edges[~beam.body.supported[edges].any(axis=(1, 2))]
    return Contact(Surface(beam, edges), Surface(stop, stop.body.mesh.edge_sets["top"]), *PAIRINGS[pairing], friction)


def loaded(contact: Contact, loads, n: int = 1) -> ContactSolution:
    """Loads on the beam, in n steps."""
    steps = StepSettings(1.0 / n, 1.0 / n)
    solution = press([contact], {}, body_loads={contact.secondary.part: loads}, steps=steps)
    assert solution.status.converged, solution.status.message
    return solution


@pytest.mark.parametrize("thickness", [0.3, 10.0])
@pytest.mark.parametrize(("force", "n"), [(40.0, 1), (200.0, 1), (500.0, 1), (500.0, 5)])
@pytest.mark.parametrize("pairing", list(PAIRINGS))
def test_a_force_on_the_tip_goes_into_the_stop_below(pairing: str, force: float, n: int, thickness: float) -> None:
    """A stop 0.2 mm below the tip carries the force but for 3 E I / L^3 times the gap, thin or thick, in 1 or 5 steps.

    Without contact the tip would go down by up to 76 mm, far beyond the stop.
    """
    stop = rectangle("stop", (95.0, -GAP - thickness), (10.0, thickness), 1.0, "bottom", order=1)
    solution = loaded(on_stop(cantilever(), stop, pairing), [Traction("right", (0.0, -force / HEIGHT))], n)
    # the mean gap of a segment closes within half an edge of the tip, 1.25 mm
    assert solution.forces[0, 1] == pytest.approx(force - GAP * STIFFNESS, abs=0.015 * force + 0.1)


def test_friction_changes_nothing_of_that() -> None:
    """With friction the stop carries the same upward force, and a tangential one within the cone."""
    stop = rectangle("stop", (95.0, -GAP - 5.0), (10.0, 5.0), 1.0, "bottom", order=1)
    solution = loaded(on_stop(cantilever(), stop, friction=0.3), [Traction("right", (0.0, -100.0))], 5)
    x, y = solution.forces[0]
    assert y == pytest.approx(500.0 - GAP * STIFFNESS, rel=0.02)
    assert abs(x) <= 0.31 * y


@pytest.mark.parametrize("n", [1, 5])
def test_a_pressure_bends_a_beam_on_a_stop(n: int) -> None:
    """Under a uniform pressure the stop, which is touched at its left corner, holds back the beam's deflection there.

    That is q a^2 (6 L^2 - 4 L a + a^2) / 24 E I less the gap, and the stiffness is 3 E I / a^3; free, the tip sinks 57
    mm.
    """
    a, pressure = 98.0, 10.0
    stop = rectangle("stop", (a, -GAP - 5.0), (4.0, 5.0), 1.0, "bottom", order=1)
    solution = loaded(on_stop(cantilever(), stop), [Pressure("top", pressure)], n)
    bending = STIFFNESS * LENGTH**3 / 3.0
    free = pressure * a**2 * (6.0 * LENGTH**2 - 4.0 * LENGTH * a + a**2) / (24.0 * bending)
    assert solution.forces[0, 1] == pytest.approx((free - GAP) * 3.0 * bending / a**3, rel=0.02)


def test_a_temperature_bends_a_beam_on_a_stop() -> None:
    """A curvature by a gradient of temperature moves the tip by kappa L^2 / 2: the stop holds it but for the gap."""
    stop = rectangle("stop", (98.0, -GAP - 5.0), (4.0, 5.0), 1.0, "bottom", order=1)
    curvature = 10.0 * GAP / LENGTH**2
    change = TemperatureChange(lambda points: curvature / EXPANSION * (points[:, 1] - HEIGHT / 2.0))
    solution = loaded(on_stop(cantilever(), stop), [change])
    assert solution.forces[0, 1] == pytest.approx((curvature * LENGTH**2 / 2.0 - GAP) * STIFFNESS, rel=0.03)


@pytest.mark.parametrize("n", [1, 5])
@pytest.mark.parametrize("friction", [0.05, 0.2, 0.5])
def test_a_hot_bar_presses_on_a_wall_with_friction(friction: float, n: int) -> None:
    """Its expansion less the gap to the wall is its shortening F L / E h; it hardly resists a push across.

    The wall, 0.3 mm thick, shortens by less than a part in 300 of that.
    """
    height, wall = 6.0, rectangle("wall", (LENGTH + GAP, -10.0), (0.3, 20.0), 0.3, "right", order=1)
    mesh = rectangle_grid(LENGTH, height, 25, 4, origin=(0.0, -height / 2.0))
    bar = Part("bar", Body("bar", mesh, Lagrange(2), STEEL, {"left": "x", (0.0, -height / 2.0): "y"}))
    surfaces = Surface(bar, mesh.edge_sets["right"]), Surface(wall, wall.body.mesh.edge_sets["left"])
    contact = Contact(*surfaces, *PAIRINGS["segments"], friction)
    solution = loaded(contact, [TemperatureChange(400.0)], n)
    force = (EXPANSION * 400.0 * LENGTH - GAP) * YOUNG * height / LENGTH
    assert solution.forces[0, 0] == pytest.approx(-force, rel=0.005)


def test_a_displaced_root_presses_the_tip_on_a_stop() -> None:
    """The held end is displaced by 8 mm, beyond a stop 2 mm thick: the tip is bent by all but the gap."""
    stop = rectangle("stop", (99.0, -GAP - 2.0), (4.0, 2.0), 1.0, "bottom", order=1)
    solution = loaded(on_stop(cantilever(), stop), [PrescribedDisplacement("left", 0.0, -8.0)])
    assert solution.forces[0, 1] == pytest.approx((8.0 - GAP) * STIFFNESS * (LENGTH / 99.0) ** 3, rel=0.02)


@pytest.mark.parametrize("n", [1, 5])
def test_two_cantilevers_carry_a_force_by_their_stiffnesses(n: int) -> None:
    """A force on one tip above another tip: k_1 w_1 + k_2 w_2 = P with w_1 - w_2 = gap; free, w_1 would be 15 mm."""
    other = rectangle("other", (98.0, -GAP - HEIGHT), (LENGTH, HEIGHT), 2.5, "right")
    solution = loaded(on_stop(cantilever(), other), [Traction("right", (0.0, -20.0))], n)
    # the other one is touched 2 mm from its end: stiffer by the cube of the lengths
    stiffness = STIFFNESS * (LENGTH / (LENGTH - 2.0)) ** 3
    right = stiffness * (100.0 - STIFFNESS * GAP) / (STIFFNESS + stiffness)
    assert solution.forces[0, 1] == pytest.approx(right, rel=0.03)


def strip_on_plate(n: int) -> float:
    """Force of a plate 40 mm wide, 0.5 mm below a strip of 200 x 1 x 10 mm under 0.05 MPa, in n steps."""
    material = Elastic(YOUNG, 0.3, "plane_stress")
    grids = (
        rectangle_grid(200.0, 1.0, 200, 1, origin=(-100.0, 0.0)),
        rectangle_grid(40.0, 4.0, 40, 4, origin=(-20.0, -4.5)),
    )
    strip, plate = (
        Part(name, Body(name, mesh, Lagrange(order), material, held, thickness=10.0))
        for name, mesh, order, held in zip(
            ("strip", "plate"), grids, (2, 1), ({"left": "xy", "right": "xy"}, "bottom"), strict=True
        )
    )
    law = AugmentedLagrange(5e6, per="length", penetration=1e-6)
    edges = strip.body.mesh.edge_sets["bottom"][1:-1]
    contact = Contact(Surface(strip, edges), Surface(plate, plate.body.mesh.edge_sets["top"]), SegmentToSegment(), law)
    return float(loaded(contact, [Pressure("top", 0.05)], n).forces[0, 1])


@pytest.mark.parametrize("n", [1, 5, pytest.param(40, marks=pytest.mark.ci)])
def test_a_strip_lies_on_a_plate_in_any_number_of_steps(n: int) -> None:
    """A clamped strip under pressure rests on both ends of the plate, as a beam on two supports 0.5 mm below it."""
    inertia, length, a = 10.0 / 12.0, 200.0, 80.0
    by_pressure = 0.5 * a**2 * (length - a) ** 2 / (24.0 * YOUNG * inertia)

    def by_force(at: float, x: float) -> float:
        """Deflection at x <= at by a unit force: both ends are clamped."""
        b = length - at
        return b**2 * x**2 * (3.0 * at * length - (3.0 * at + b) * x) / (6.0 * YOUNG * inertia * length**3)

    each = (by_pressure - 0.5) / (by_force(a, a) + by_force(length - a, a))
    assert strip_on_plate(n) == pytest.approx(2.0 * each, rel=0.01)


def test_what_passes_beside_a_stop_does_not_touch_it() -> None:
    """A stop beyond the end of the beam carries nothing, although the tip goes far below it; the message says so."""
    stop = rectangle("stop", (103.0, -GAP - 5.0), (10.0, 5.0), 1.0, "bottom", order=1)
    solution = loaded(on_stop(cantilever(), stop), [Traction("right", (0.0, -20.0))])
    assert not solution.forces.any()
    assert "nothing touches" in solution.status.message


def test_edges_that_may_not_touch_are_passed_only_with_an_error() -> None:
    """A stop of which only the lower side may touch is passed by its upper one: not converged, both bodies named."""
    stop = rectangle("stop", (95.0, -GAP - 5.0), (10.0, 5.0), 1.0, "bottom", order=1)
    stop = Part("stop", Body("stop", stop.body.mesh, Lagrange(1), STEEL, "right"))
    beam = cantilever()
    sides = Surface(beam, beam.body.mesh.edge_sets["bottom"][1:]), Surface(stop, stop.body.mesh.edge_sets["bottom"])
    contact = Contact(*sides, NodeToSegment(), Multiplier())
    solution = press([contact], {}, body_loads={beam: [Traction("right", (0.0, -50.0))]})
    assert not solution.status.converged
    assert "beam" in solution.status.message
    assert "stop" in solution.status.message
