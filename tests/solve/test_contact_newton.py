"""Newton's method for contact, of nonlinear materials too, converges quadratically; forces obey their laws."""

from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

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
from flangeway.contact.contact_state import ContactProblem
from flangeway.contact.contact_step import after, step
from flangeway.contact.newton import _first_state
from flangeway.contact.pairs import Enforcement
from flangeway.contact.system import ContactLinearisation
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Placement, rectangle
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement, fixed
from flangeway.solve import CondensedBodies, NewtonSettings, SparseBodies, follow, solve_nonlinear
from flangeway.solve.active_set import Answer, DenseEquations, Laws, Motions, solve
from flangeway.solve.handles import Handle, Handles
from flangeway.solve.status import STALLED_ITERATIONS, Iteration, is_at_round_off
from flangeway.space import Space
from flangeway.types import Floats
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
        monkeypatch.setattr("flangeway.contact.contact_step.OLD_DERIVATIVES_RESIDUAL", close)
        answers.clear()
        states.append(solve_contact(response, problem.system, placements, start=start))
        counts.append(len(answers))
    assert len(states[0].history) == len(states[1].history)
    assert counts[0] == counts[1] - 1
    assert np.abs(states[0].nodal_forces - states[1].nodal_forces).max() < 1e-10 * states[1].forces.max()


def arrays_in(value) -> list[np.ndarray]:
    """Copies of all arrays in a value and in its parts."""
    if isinstance(value, np.ndarray):
        return [value.copy()]
    if sp.issparse(value):
        return [value.toarray()]
    parts = value if isinstance(value, tuple) else ()
    if isinstance(value, ContactLinearisation):  # without what is computed when it is first asked for
        parts = [getattr(value, field.name) for field in fields(value)]
    return [array for part in parts for array in arrays_in(part)]


def test_steps_are_functions_of_a_state(press) -> None:
    """A step and the state after it, whole or in part, are the same when taken again, and leave the state as it was."""
    problem = press("fem")
    response, placements = CondensedBodies(problem.system.surface_nodes), problem.placements(DEPTH)
    handle = Handle((problem.system.parts[0],), np.zeros(2), np.array([[0.0, 1.0]]), turns=False, load=[0.0, -1.0, 0.0])
    handles = Handles(response, placements, [handle, None])
    contact = ContactProblem(response, problem.system, handles, NewtonSettings(), None, None)
    state = _first_state(contact)
    for _ in range(4):
        before, first, second = arrays_in(state), step(contact, state), step(contact, state)
        halves = [after(contact, state, taken, 0.5, settle=False) for taken in (first, second)]
        following = after(contact, state, first, 1.0, settle=False)
        for one, other in ((before, arrays_in(state)), (arrays_in(first), arrays_in(second)), map(arrays_in, halves)):
            assert len(one) == len(other)
            assert all(map(np.array_equal, one, other))
        assert len(following.history) == len(state.history) + 1
        state = following
    assert state.history[-1].residual < 1e-6 * state.history[0].residual


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
    assert len(found.state.history) > STALLED_ITERATIONS + 1
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
    monkeypatch.setattr("flangeway.contact.contact_step.OLD_DERIVATIVES_RESIDUAL", 0.0)
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


def motions(by_motion: Floats, residual: Floats, stiffness: Floats | None = None) -> Motions:
    """Motions of one part of the size 1, without friction."""
    n = by_motion.shape[1]
    stiffness = np.zeros((n, n)) if stiffness is None else stiffness
    return Motions(by_motion, by_motion.T, stiffness, residual, np.zeros(n, dtype=np.int64), np.ones(n))


def forces_of(
    matrix: Floats,
    offset: Floats,
    mu: Floats | None = None,
    barriers: Floats | None = None,
    guess: Floats | None = None,
) -> Floats | None:
    """Forces of constraints with coefficients of friction (m,), or without friction, by the law of each."""
    m = len(offset) if mu is None else len(mu)
    none = np.column_stack((np.zeros(m), np.full(m, np.inf)))
    laws = Laws(np.zeros(m) if mu is None else mu, none if barriers is None else barriers, matrix.diagonal())
    held = motions(np.zeros((len(offset), 0)), np.zeros(0))
    answer = solve(laws, DenseEquations(matrix, offset, laws, held), np.zeros(len(offset)) if guess is None else guess)
    return None if answer is None else answer.forces


def test_an_unsolvable_problem_has_no_solution() -> None:
    """An indefinite matrix without a solution gives None, not a wrong answer."""
    assert forces_of(np.array([[-1.0]]), np.array([-1.0])) is None


def test_repeated_constraints_share_one_force() -> None:
    """Two equal constraints under load have a solution whose forces add up to that of one of them."""
    matrix = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    forces = forces_of(matrix, np.array([-1.0, -1.0, 4.0]), guess=np.array([1.0, 1.0, 0.0]))
    assert forces is not None
    assert forces[:2].sum() == pytest.approx(1.0)
    assert (forces >= 0.0).all()
    assert forces[2] == 0.0


@given(seed=st.integers(0, 10**6), n=st.integers(1, 25), mu=st.floats(0.0, 1.0), closed=st.booleans())
def test_forces_satisfy_coulombs_law(seed: int, n: int, mu: float, closed: bool) -> None:
    """From any guess, complementarity of forces and gaps, and friction against slip at its limit: random matrices."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2 * n, 2 * n))
    matrix = root @ root.T / n + np.eye(2 * n)
    matrix, offset = matrix + 1e-3 * rng.normal(size=matrix.shape), rng.normal(size=2 * n)
    forces = forces_of(matrix, offset, np.full(n, mu), guess=np.repeat([float(closed), 0.0], n))
    assert forces is not None
    gaps, slips = np.split(matrix @ forces + offset, 2)
    normal, tangential = np.split(forces, 2)
    assert normal.min() >= 0.0
    assert gaps.min() > -1e-9
    assert np.abs(normal * gaps).max() < 1e-9
    limit = mu * normal
    assert (np.abs(tangential) <= limit + 1e-9).all()
    assert np.abs(tangential - np.clip(tangential - slips, -limit, limit)).max() < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_forces_satisfy_the_law_of_a_barrier(seed: int) -> None:
    """A force leaves the gap w / (p + w / r), none leaves at least the reach; a small w is complementarity."""
    rng = np.random.default_rng(seed)
    n = 30
    factor = rng.standard_normal((n, n))
    matrix, offset = factor @ factor.T + 0.01 * np.eye(n), rng.standard_normal(n)
    products, reaches = 10.0 ** rng.uniform(-6.0, -1.0, n), rng.uniform(0.1, 2.0, n)
    forces = forces_of(matrix, offset, barriers=np.column_stack((products, reaches)))
    assert forces is not None
    gaps, closed = matrix @ forces + offset, forces > 0.0
    # gaps, not forces, are compared: a small gap is a difference of large numbers
    np.testing.assert_allclose(gaps[closed], (products / (forces + products / reaches))[closed], atol=1e-10)
    assert (gaps[~closed] >= reaches[~closed] * (1.0 - 1e-10)).all()
    limit, near = (
        forces_of(matrix, offset, barriers=each) for each in (None, np.column_stack((np.full(n, 1e-12), reaches)))
    )
    assert limit is not None
    assert near == pytest.approx(limit, abs=1e-5 * np.abs(limit).max())


def test_a_motion_takes_the_forces_to_its_load() -> None:
    """Two springs of stiffness 1 and 3 under a load of 2 on a common motion carry 0.5 and 1.5."""
    matrix = np.diag([1.0, 1.0 / 3.0])
    moved = motions(np.array([[-1.0], [-1.0]]), np.array([2.0]))
    laws = Laws(np.zeros(2), np.column_stack((np.zeros(2), np.full(2, np.inf))), matrix.diagonal())
    answer = solve(laws, DenseEquations(matrix, np.zeros(2), laws, moved), np.ones(2))
    assert answer is not None
    np.testing.assert_allclose(answer.forces, (0.5, 1.5), rtol=1e-12)
    np.testing.assert_allclose(answer.motions, 0.5, rtol=1e-12)


def test_neutral_and_loose_motions_are_seen() -> None:
    """A motion without stiffness and force is neutral; without stiffness but under force nothing holds it."""
    matrix = np.eye(1)
    laws = Laws(np.zeros(1), np.array([[0.0, np.inf]]), matrix.diagonal())
    for load, loose in ((0.0, False), (5.0, True)):
        moved = motions(np.array([[-1.0, 0.0]]), np.array([2.0, load]))
        equations = DenseEquations(matrix, np.zeros(1), laws, moved)
        left, right, is_loose = equations.free_motions(Answer(np.array([2.0]), np.zeros(1), np.array([2.0, 0.0])))
        assert is_loose == loose
        assert left.shape == right.shape == (2, 0 if loose else 1)
        if not loose:
            np.testing.assert_allclose(np.abs(right[:, 0] / np.linalg.norm(right)), (0.0, 1.0), atol=1e-12)
