"""Newton's method for contact, condensed or not, of nonlinear materials: it converges quadratically."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp

from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
    Surface,
    press,
    press_nonlinear,
    solve_contact,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Placement, rectangle
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement, fixed
from flangeway.solve import CondensedBodies, NewtonSettings, SparseBodies, follow, solve_nonlinear
from flangeway.solve.status import STALLED, Iteration, is_at_round_off
from flangeway.space import Space
from tests.contact.steel_boxes import BoxDiscretisation, Method, pressed_boxes, surface_of

DEPTH = 0.05
RADIUS, THICKNESS = 50.0, 10.0


def solved(press, way=CondensedBodies, depth=DEPTH, **motion):
    response = way(press.system.surface_nodes)
    state = solve_contact(response, press.system, press.placements(depth, **motion))
    assert state.status.converged, state.status.message
    return response, state


@pytest.mark.parametrize("way", [CondensedBodies, SparseBodies])
def test_the_last_iteration_takes_the_derivatives_of_the_one_before(press, monkeypatch, way) -> None:
    """Bodies answer once less in as many iterations, and the forces are those of iterations with their own."""
    problem, answers, own = press("fem"), [], way.tangent
    response, start = solved(problem, way)
    monkeypatch.setattr(way, "tangent", lambda *given, **named: answers.append(1) or own(*given, **named))
    placements, states, counts = problem.placements(1.2 * DEPTH), [], []
    for close in (1e-6, 0.0):
        monkeypatch.setattr("flangeway.contact.newton.CLOSE", close)
        answers.clear()
        states.append(solve_contact(response, problem.system, placements, start=start))
        counts.append(len(answers))
    assert len(states[0].history) == len(states[1].history)
    assert counts[0] == counts[1] - 1
    assert np.abs(states[0].nodal_forces - states[1].nodal_forces).max() < 1e-10 * states[1].forces.max()


def test_steps_are_halved_and_doubled(press) -> None:
    """A step that fails is tried at half its length, the path ends at one with the same forces."""
    problem = press("fem")
    response = CondensedBodies(problem.system.surface_nodes)
    visited = []

    def solve_at(part, state):
        visited.append(part)
        few = NewtonSettings(max_iterations=1 if part == 1.0 and len(visited) == 1 else 40)
        return solve_contact(response, problem.system, problem.placements(part * DEPTH), start=state, settings=few)

    state = follow(solve_at, None)
    assert visited == [1.0, 0.5, 1.0]
    _, direct = solved(problem)
    assert np.abs(state.nodal_forces - direct.nodal_forces).max() < 1e-9 * direct.forces.max()


def test_bodies_serve_many_places(press) -> None:
    """Condensed bodies that answered at one place answer at another as fresh ones do, with few nodes touched or all."""
    problem = press("fem")
    used, state = solved(problem)
    lin = state.linearisation
    rng = np.random.default_rng(5)
    for turn, nodes in ((0.3, lin.nodes), (0.3, lin.nodes[::3]), (-1.2, np.arange(used.n_nodes))):
        rotations = used.rotations([Placement(turn), Placement(2.0 * turn)])
        loads = sp.csr_array(rng.normal(size=(2 * len(nodes), 2)))
        root = sp.csr_array(rng.normal(size=(2 * len(nodes), 3)))
        tangent = sp.csr_array(root @ root.T)
        fresh = CondensedBodies(problem.system.surface_nodes)
        expected = fresh.tangent(rotations, nodes, tangent)(loads)
        np.testing.assert_array_equal(used.tangent(rotations, nodes, tangent)(loads), expected)
        sparse = SparseBodies(problem.system.surface_nodes).tangent(rotations, nodes, tangent)(loads)
        np.testing.assert_allclose(expected, sparse, atol=1e-9 * np.abs(sparse).max())


def test_corrections_below_the_tolerance_are_not_said_to_be_limited_by_round_off() -> None:
    """Corrections of augmented Lagrange below the tolerance each have simply converged, however many there are."""
    boxes = BoxDiscretisation(0.31, "fem", 1), BoxDiscretisation(0.4, "fem", 1)
    law = AugmentedLagrange(2e3, "length", 1e-9)
    found = pressed_boxes(*boxes, SegmentToSegment(), law, rotation_rad=0.3).solve()
    assert len(found.state.history) > STALLED + 1
    assert found.status.message.endswith("corrections of the forces")


@pytest.mark.parametrize(
    ("residuals", "ended"),
    [((4e-9, 5e-9, 3e-9, 4e-9), True), ((8e-9, 2e-9, 5e-10, 1e-10), False), ((4e-6, 5e-6, 3e-6, 4e-6), False)],
)
def test_a_residual_that_no_longer_falls_is_round_off_where_it_is_small(residuals, ended: bool) -> None:
    """Slender legs with friction stay at 5e-9: they have converged, while what falls or is large has not."""
    assert is_at_round_off([Iteration(1e-9, residual, 3, ()) for residual in residuals]) == ended


def settled_steps(solution: ContactSolution) -> np.ndarray:
    """Residuals before and after each iteration that kept the active set; its square is above round-off.

    Nodes that penetrate after convergence get a constraint, so that the active set may settle more than once.
    """
    history = solution.state.history
    steps = [
        (before.residual, after.residual)
        for before, after in pairwise(history)
        if not (before.changed or after.changed) and before.residual**2 > np.finfo(float).eps / 4.0
    ]
    return np.array(steps)


def orders(steps: np.ndarray) -> np.ndarray:
    """Logarithm of each residual over that of the one before: near 2 for quadratic convergence, near 1 for linear."""
    return np.log(steps[:, 1]) / np.log(steps[:, 0])


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
@pytest.mark.parametrize("enforcement", [Penalty(1e5, per="length"), Multiplier()], ids=["penalty", "multiplier"])
@pytest.mark.parametrize(("method", "order"), [("fem", 1), ("fem", 2), ("vem", 2)])
def test_quadratic_after_the_active_set_has_settled(
    pairing: Pairing, enforcement: Enforcement, method: Method, order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tilted block pressed deep into a long one: the order of every settled iteration is above 1.6.

    Of iterations with their own derivatives: the last one takes those of the one before where this is enough.
    """
    monkeypatch.setattr("flangeway.contact.newton.CLOSE", 0.0)
    short = BoxDiscretisation(0.25, method, order).part("short", rectangle(2.0, 1.0, centre=(0.0, 0.5)), "top")
    long = BoxDiscretisation(0.3, method, order).part("long", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(surface_of(short, "bottom"), surface_of(long, "top"), pairing, enforcement)
    solution = press([contact], {short: Placement(0.03, (0.0, -0.1))})
    assert solution.status.converged, solution.status.message
    assert len(solution.steps) == 1
    steps = settled_steps(solution)
    assert len(steps) >= 2
    assert steps[:, 0].max() > 1e-4  # far enough from round-off to see an order
    assert orders(steps).min() > 1.6, steps


SOFT = Elastic(10.0, 0.3)


def pressed(mesh, element, material, depths):
    """A block under a hard plate that moves down by depths: the solutions."""
    block = Part("block", Body("block", mesh, element, SOFT, "bottom"))
    wide = rectangle_grid(2.0, 1.0, 5, 3)
    plate = Part("plate", Body("plate", wide, Lagrange(1), Elastic(1e8, 0.3), "top"), Placement(0.0, (-0.5, 1.0)))
    surfaces = Surface(block, mesh.edge_sets["top"]), Surface(plate, wide.edge_sets["bottom"])
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
    start = None
    for depth in depths:
        motion = {plate: Placement(0.0, (0.0, -depth))}
        found = press_nonlinear([contact], motion, {block: material}, start=start)
        start = found.states
        yield found.contact, found.displacements[block], found.converged


@pytest.mark.parametrize(
    ("material", "depths", "make", "element"),
    [
        (NeoHooke(SOFT), [0.1], dual, Virtual(1)),
        (J2Plasticity(SOFT, 0.2, isotropic=1.0), [0.04, 0.035], lambda mesh: mesh, Lagrange(2)),
        (J2Plasticity(SOFT, 0.2, kinematic=1.0), [0.04, 0.035], dual, Virtual(3)),
    ],
)
def test_a_block_under_a_hard_plate(material, depths, make, element):
    """Displacements are those of the block alone to 0.3 %, the force to 1e-5: segments touch on average."""
    mesh = make(rectangle_grid(1.0, 1.0, 4, 4))
    supports = [fixed("bottom"), PrescribedDisplacement("top", y=-depths[0])]
    factors = [depth / depths[0] for depth in depths]
    path = solve_nonlinear(Elasticity(Space(mesh, element), SOFT, supports=supports), material, factors)
    top = np.unique(Space(mesh, element).edge_nodes(mesh.edge_set("top")))
    for alone, (contact, field, converged) in zip(path, pressed(mesh, element, material, depths), strict=True):
        assert converged
        np.testing.assert_allclose(field, alone.displacements, atol=3e-3 * depths[0])
        force = alone.nodal_forces[top, 1].sum()
        assert contact.resultants[0, 1, 1] == pytest.approx(-force, rel=1e-5)  # that of the block on the plate
