"""Coulomb friction of bodies in the plane: stick and slip, paths, sizes of load steps, and bad inputs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway import Body, Elastic, Lagrange, Part, Placement
from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.contact import press as press_parts
from flangeway.contact.rolling.friction import Friction
from flangeway.errors import InputError
from flangeway.geometry import polygon
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.mesh.gmsh_mesher import Refinement
from flangeway.solve import StepSettings

PAIRINGS = [NodeToSegment(), SegmentToSegment(), SegmentToSegment(weighting="dual")]
LAWS = [
    *(Penalty(1e6, per="length"), AugmentedLagrange(1e7, per="length", penetration=1e-8), Multiplier()),
    Barrier(1e-3, 1e-3),
]
MU = 0.3


def block(name: str, width: float, n_edges: int, held: float, bottom: float, order: int = 1, turn: float = 0.0) -> Part:
    """A block of steel of 10 mm height, held at one side, turned about the origin."""
    mesh = rectangle_grid(width, 10.0, n_edges, 2, origin=(-width / 2.0, bottom))
    supports = {(float(x), float(y)): "xy" for x, y in mesh.points if y == held}
    body = Body(name, mesh, Lagrange(order), Elastic(210e3, 0.3), supports)
    return Part(name, body, Placement(turn))


def side(part: Part) -> Surface:
    """The side at y = 0."""
    edges, points = part.body.mesh.boundary_edges, part.body.mesh.points
    return Surface(part, edges[(points[edges][:, :, 1] == 0.0).all(axis=1)])


def blocks(pairing=PAIRINGS[0], law=LAWS[2], friction=MU, *, order: int = 1, turn: float = 0.0) -> Contact:
    """A block of 10 mm on one of 20 mm."""
    upper = block("upper", 10.0, 4, 10.0, 0.0, order, turn)
    return Contact(side(upper), side(block("lower", 20.0, 7, -10.0, -10.0, order, turn)), pairing, law, friction)


def pushed(contact: Contact, *motions: tuple[float, float], turn: float = 0.0, **options):
    """Press along a path of shifts of the secondary part, in axes that are turned."""
    shift = [Placement(turn).points(np.array([motion]))[0] for motion in motions]
    path = [{contact.secondary.part: Placement(0.0, (float(x), float(y)))} for x, y in shift]
    return press_parts([contact], path, **options)


def law_error(solution) -> float:
    """Worst violation of Coulomb's law in any step by forces, slips and states, over the maximum force."""
    worst = 0.0
    for step in solution.steps:
        normal, friction = step.state.forces, step.state.friction
        limits = step.state.linearisation.coefficients * normal
        beyond = np.abs(friction.forces) - limits
        at_limit = np.where(friction.slips != 0.0, np.abs(beyond), 0.0)
        worst = max(worst, beyond.max(initial=0.0), at_limit.max(initial=0.0))
        assert (friction.forces * friction.slips <= 0.0).all()
        assert (friction.slips[friction.sticks] == 0.0).all()
    return worst / max(solution.state.forces.max(initial=0.0), 1e-300)


@pytest.mark.parametrize(
    ("pairing", "law"),
    [(PAIRINGS[0], LAWS[0]), (PAIRINGS[1], LAWS[1]), (PAIRINGS[2], LAWS[2]), (PAIRINGS[1], LAWS[3])],
    ids=["nodes-penalty", "segments-augmented", "dual-multiplier", "segments-barrier"],
)
def test_a_block_sticks_slips_and_returns(pairing, law, imbalance) -> None:
    """Pressed, pushed until all slips, and back: forces in the cone, friction mu N in the end, either way."""
    solution = pushed(
        blocks(pairing, law, Friction(MU)), (0.0, -0.01), (0.02, 0.0), (-0.04, 0.0), steps=StepSettings(0.5, 0.5)
    )
    assert solution.status.converged, solution.status.message
    assert max(step.state.status.iterations for step in solution.steps) <= 30
    assert law_error(solution) < 1e-10
    assert imbalance(solution) < 1e-12
    for share, sign in ((2.0, -1.0), (3.0, 1.0)):
        state = next(step.state for step in solution.steps if step.share == share)
        assert state.friction.forces.sum() == pytest.approx(-sign * MU * state.forces.sum(), rel=1e-9)
        along, across = replace(solution, state=state).forces[0]
        assert along == pytest.approx(sign * MU * across, rel=5e-3)  # the surface is not quite straight
    assert (solution.dissipated_work >= 0.0).all()
    assert solution.dissipated_work[-1] > 0.0
    np.testing.assert_allclose(solution.dissipated_by_contact, [solution.dissipated_work.sum()], rtol=1e-12)
    assert not np.array(solution.friction_table.columns["sticks"]).any()


@pytest.mark.parametrize(("pairing", "near"), [(PAIRINGS[0], 0.03), (PAIRINGS[1], 0.02)], ids=["nodes", "segments"])
def test_sliding_dissipates_the_work_of_the_friction(pairing, near: float) -> None:
    """Steps of steady sliding over several edges dissipate mu N times the way, to 3 or 2 % on this coarse mesh."""
    contact = blocks(pairing)
    solution = pushed(contact, (0.0, -0.01), (0.02, 0.0), (3.5, 0.0), steps=StepSettings(0.25, 0.25))
    assert solution.status.converged, solution.status.message
    for step, work in list(zip(solution.steps, solution.dissipated_work, strict=True))[-4:]:
        force = replace(solution, state=step.state).forces[0, 0]
        assert work == pytest.approx(-force * 3.5 / 4.0, rel=near)


def test_all_unknowns_and_any_axes_give_the_same_forces() -> None:
    """The sparse path, and bodies turned by 2 rad, agree with the condensed one to 1e-9; order 2."""
    path = (0.0, -0.01), (0.004, 0.0), (-0.003, 0.0)
    found = pushed(blocks(PAIRINGS[1], order=2), *path)
    sparse = pushed(blocks(PAIRINGS[1], order=2), *path, path="sparse")
    turned = pushed(blocks(PAIRINGS[1], order=2, turn=2.0), *path, turn=2.0)
    assert found.status.converged, found.status.message
    assert found.state.friction.sticks.any()
    assert (found.state.friction.slips != 0.0).any()
    for other in (sparse, turned):
        for one, same in (
            (found.state.forces, other.state.forces),
            (found.state.friction.forces, other.state.friction.forces),
        ):
            np.testing.assert_allclose(one, same, atol=1e-9 * found.state.forces.max())
    np.testing.assert_allclose(turned.forces[0], Placement(2.0).points(found.forces)[0], atol=1e-8 * found.forces.max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("pairing", PAIRINGS[:2], ids=["nodes", "segments"])
def test_convergence_is_quadratic(pairing, order: int) -> None:
    """Bodies that turn by much while they slide: each of the last iterations squares the error, down to round-off."""
    contact = blocks(pairing, LAWS[2], 0.6, order=order)
    solution = pushed(contact, (0.0, -0.5), (0.5, 0.0), steps=StepSettings(0.5, 0.5))
    assert solution.status.converged, solution.status.message
    residuals = [each.residual for each in solution.state.history]
    assert len(residuals) <= 6
    large = [each for each in residuals if each > 1e-7]
    assert residuals[len(large)] < 100.0 * large[-1] ** 2 + 1e-11


def test_no_friction_is_friction_of_nothing() -> None:
    """A coefficient of 0 gives the frictionless forces to the last digit, a tiny one nearly."""
    free, zero, tiny = (pushed(blocks(friction=mu), (0.0, -0.01), (0.001, 0.0)) for mu in (0.0, Friction(0.0), 1e-9))
    np.testing.assert_array_equal(free.state.forces, zero.state.forces)
    np.testing.assert_allclose(free.state.forces, tiny.state.forces, rtol=1e-7)
    assert free.state.friction is None
    assert free.dissipated_work.tolist() == [0.0, 0.0]
    assert not np.array(free.friction_table.columns["traction"]).any()


@settings(max_examples=4, deadline=None)
@given(
    mu=st.floats(0.01, 1.2),
    path=st.lists(st.tuples(st.floats(-0.02, 0.02), st.floats(-0.006, 0.006)), min_size=1, max_size=3),
    pairing=st.sampled_from(PAIRINGS),
    law=st.sampled_from(LAWS),
)
def test_random_paths(mu, path, pairing, law, imbalance) -> None:
    """Whatever the path: what converged has forces within the cone, dissipation >= 0 and equilibrium."""
    solution = pushed(blocks(pairing, law, mu), (0.0, -0.008), *path)
    assert solution.status.converged, solution.status.message
    assert law_error(solution) < 1e-9
    assert (solution.dissipated_work >= 0.0).all()
    assert imbalance(solution) < 1e-10


@pytest.mark.parametrize(
    ("friction", "words"),
    [
        (-0.1, "a number >= 0"),
        ("0.3", "a number >= 0"),
        (Friction(0.3, 0.2, 1.0), "does not depend on the slip velocity"),
        (Friction(np.array([0.3, 0.2])), "one coefficient"),
    ],
)
def test_wrong_friction_is_refused(friction, words: str) -> None:
    """The message names what is allowed."""
    with pytest.raises(InputError, match=words):
        blocks(friction=friction)


def test_contradictory_steps_are_refused() -> None:
    """No motion, and step sizes for another number of motions."""
    contact = blocks()
    with pytest.raises(InputError, match="at least one"):
        press_parts([contact], [])
    with pytest.raises(InputError, match="2 motions for a path of 1"):
        pushed(contact, (0.0, -0.01), steps=[StepSettings(), StepSettings()])
    with pytest.raises(InputError, match="StepSettings"):
        pushed(contact, (0.0, -0.01), steps=[0.5])


FINE_MM, RADIUS_MM, APPROACH_MM, ZONE_MM = 0.5, 50.0, 1.45, 12.0


def surface_of(part: Part, name: str) -> Surface:
    """Edges of a set of the part within the zone of contact."""
    edges = part.body.mesh.edge_sets[name]
    return Surface(part, edges[part.body.mesh.points[edges][:, :, 0].max(axis=1) < ZONE_MM + 0.1])


def rolled(steps: StepSettings | None) -> ContactSolution:
    """Half of a steel roller that is pressed on half of an aluminium block with friction (NAFEMS R0094)."""
    angles = np.append(np.arange(0.0, 0.24, FINE_MM / RADIUS_MM), np.linspace(0.24, np.pi / 2.0, 25))
    arc = [(RADIUS_MM * np.sin(angle), RADIUS_MM * (1.0 - np.cos(angle))) for angle in angles]
    top = [(x, 0.0) for x in np.append(np.arange(0.0, ZONE_MM + 0.01, FINE_MM), (20.0, 40.0, 100.0))][::-1]
    outlines = {
        "roller": polygon([*arc, (0.0, RADIUS_MM)], ["arc"] * (len(arc) - 1) + ["top", "axis"]),
        "block": polygon([(0.0, -200.0), (100.0, -200.0), *top], ["bottom", "side", *["top"] * (len(top) - 1), "axis"]),
    }
    held = {"roller": {"top": "y", "axis": "x"}, "block": {"bottom": "xy", "axis": "x"}}
    fine = [Refinement(np.zeros((1, 2)), FINE_MM)]
    roller, block = (
        Part(
            name,
            Body(
                name,
                triangulate(outlines[name], size=size, refinements=fine),
                Lagrange(1),
                Elastic(young, 0.3),
                held[name],
            ),
        )
        for name, size, young in (("roller", 6.0, 210e3), ("block", 15.0, 70e3))
    )
    contact = Contact(surface_of(roller, "arc"), surface_of(block, "top"), SegmentToSegment(), Multiplier(), 0.1)
    solution = press([contact], {roller: Placement(0.0, (0.0, -APPROACH_MM))}, steps=steps)
    assert solution.status.converged, solution.status.message
    return solution


@pytest.mark.ci
def test_dissipated_work_does_not_depend_on_steps_that_nobody_gave() -> None:
    """The work by default is that of 60 steps within 5 %, in fewer of them; one step is wrong by a factor of 2."""
    fine = rolled(StepSettings(1.0 / 60.0, 1.0 / 60.0)).dissipated_work.sum()
    default = rolled(None)
    assert default.dissipated_work.sum() == pytest.approx(fine, rel=0.05)
    assert 5 < len(default.steps) < 60
    assert rolled(StepSettings()).dissipated_work.sum() > 2.0 * fine
