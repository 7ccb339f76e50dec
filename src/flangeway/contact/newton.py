"""Newton's method for placed linear bodies in unilateral contact.

Unknowns are the contact forces p >= 0. Every iteration linearises the gaps ``g(x)`` and the direction of the forces
about the current positions and solves the linear complementarity problem that follows: with the bodies' stiffness K and
the geometric stiffness ``G = -sum p d2g`` of the *current* forces,

    (K + G) u' = B^T p' + G u,   0 <= p',   0 <= g + B (u' - u) + C p',   p' . (...) = 0,

where ``B = dg/du`` and C is the compliance of the contact law (0: no penetration; 1/penalty: Moherdaui (2021) 2.66 with
the sign of the errata). Once the active set has settled this is Newton's method with the consistent tangent (Moherdaui
2021, 3.118).

Near the solution K + G and B hardly change from one iteration to the next, and the last iteration takes those of the
one before (the chord method; C. T. Kelley, 1995, Iterative Methods for Linear and Nonlinear Equations, 5.4.1): only
gaps and forces are new.

With a barrier of the product w and the reach r, forces act at a gap: ``0 <= g + ... - w / (p' + w / r)``.

A step is halved until the residual is below the maximum of the last steps (L. Grippo, F. Lampariello and S. Lucidi,
1986, SIAM J. Numer. Anal. 23). What this does not reach from the start is reached along a path of smaller motions and
loads (`flangeway.solve.status`).

Where a penetration is to be within a tolerance (augmented Lagrange), C acts on ``p' - p0`` instead. Until it is, the
forces p0 are corrected to those found (Uzawa's method), and the penalty grows with each correction (D. P. Bertsekas,
1982, Constrained Optimization and Lagrange Multiplier Methods, 2.2): with one penalty, patterns of forces that hardly
displace the bodies are corrected hardly at all.

With friction, tangential forces q are added. The slips w since the last converged step are linearised as the gaps are,
with ``S = dw/du``, and their forces act along T, so that the linear problem is

    (K + G) u' = B^T p' + T^T q' + G u,   |q'| <= mu p',   w + S (u' - u) + C q' + e = 0 or against q' at the limit,

with Coulomb's law in place of the complementarity (`flangeway.solve.active_set`). The geometric stiffness has the turn
of the tangential forces, ``-sum q dT``, and is not symmetric. C is the same as for the gaps; e is the slip ``-C q``
that it had let back before.
"""

import itertools
from collections.abc import Sequence

import numpy as np

from flangeway.contact.contact_state import ContactIterate, ContactProblem, ContactState, HeldMotions, bending
from flangeway.contact.contact_step import ContactStep, after, step
from flangeway.contact.search import MAX_ROTATION_STEP, on_path
from flangeway.contact.system import ContactLinearisation, ContactSystem, Entry, carried_forces
from flangeway.geometry import Placement
from flangeway.geometry.arrays import max_magnitude, norms
from flangeway.solve.active_set import friction_state
from flangeway.solve.body_response import BodyResponse
from flangeway.solve.handles import Handle, Handles
from flangeway.solve.status import NewtonSettings, Status, is_at_round_off
from flangeway.space.symmetric import EPS
from flangeway.types import Bools

MEMORY, MAX_GROWTH, MIN_FRACTION = 12, 2.0, 1.0 / 32.0
"""A step is halved while its residual is above the maximum of so many iterations before it, times the growth, until the
fraction of the step. Active sets change in the first iterations, so that the residual need not fall in each; without
any limit nodes on edges far shorter than their share of the surface, which are not stable under pressure, run away.
After as many, pairs of a node and an edge are held by a wider margin, so that none changes for ever, and nodes that
penetrate are guarded before the equations are solved: without that of a sharp corner, nodes beside it may go in and out
of its body for ever."""

START_DISTANCE = 0.5
"""Part of the maximum displacement by which bodies may have moved since a start whose gaps are linearised anew only
after the first iteration."""

MAX_UNBALANCED_FORCE = 1e-9
"""Force left on a floating part relative to the maximum load, or the total force, above which a message names it."""

MAX_FORCE_ALONG_MOTION = 1e-6
"""Force along a motion relative to the maximum load, above which a message names it."""

ROUND_OFF = 1e-13
"""Force relative to the maximum one below which it is round-off of the solved equations: its constraint is open."""

MAX_ROUND_OFF = 1e-3
"""Residual that round-off of the positions excuses, at most: where nothing moves it would excuse any force."""

MAX_SLIDE, MAX_TURN = 0.4, 1.0
"""Way relative to the size of a part, and angle in rad, after which it slides away if friction has not held its load
meanwhile: a wheel of eight sides turns by 0.8 from one to the next."""

MAX_NAMED = 3
"""How many constraints a message names."""

MAX_TRAVEL = 2.0
"""Way relative to the size of the largest part after which no surface comes within reach of a part that nothing
touches."""

MAX_STOPS = 12
"""Steps of an iteration that stop where a node enters another surface."""

MAX_DEFORMATION = 1.0
"""Deformation relative to the size of the largest body that is not sought: bodies are linear."""

MAX_ROUNDS = 20
"""Rounds of further constraints for nodes that penetrate."""

MAX_CORRECTIONS = 10
"""Corrections of the forces after which round-off hides the tolerance."""


def solve_contact(
    response: BodyResponse,
    constraints: ContactSystem,
    placements: tuple[Placement, ...],
    *,
    handles: Sequence[Handle | None] | None = None,
    start: ContactState | None = None,
    settings: NewtonSettings | None = None,
    origin: Sequence[Placement] | None = None,
) -> ContactState:
    """Find the contact forces of placed bodies.

    Parameters
    ----------
    response
        The bodies.
    constraints
        The contacts among them.
    placements
        Placement of each body.
    handles
        Handle of each body, the same object for all that share it, whose motion after the placements is unknown; None
        for a body or all: there is none.
    start
        A solution of the same constraints for a neighbouring position, whose forces are the first guess. Where the
        bodies have moved by little since, the first iteration also takes its linearisation. With friction it is the
        converged step before: slip is counted from its positions.
    settings
        Limits of the iteration.
    origin
        Placements from which the undeformed bodies come, and slip is counted, without a start; left out: those given.

    Returns
    -------
    ContactState
        Its status says whether it converged.

    """
    parts = Handles(response, placements, handles)
    return _solved(ContactProblem(response, constraints, parts, settings or NewtonSettings(), start, origin))


def _solved(problem: ContactProblem) -> ContactState:
    """Solve, and guard nodes that penetrate, until none does and penetrations are within their tolerance."""
    state, rounds = _first_state(problem), 0
    while state.status is None and (state := _iterated(problem, state)).status is None:
        if state.excess > 1.0 and state.corrections == MAX_CORRECTIONS:
            state = state.ended(
                f"not converged in {MAX_CORRECTIONS} corrections of the forces: the penetration is "
                f"{state.excess:.3g} times the tolerated one, which is below round-off; take a larger tolerance"
            )
        elif state.excess > 1.0:
            state = state.corrected(1)
        elif (further := _with_constraints(problem, state)) is None:
            break
        else:
            state, rounds = further, rounds + 1
            if rounds == MAX_ROUNDS:
                state = state.ended(f"not converged: nodes still penetrate after {rounds} rounds; take a finer mesh")
    return _result(problem, state)


def _first_state(problem: ContactProblem) -> ContactIterate:
    """State from which the iteration starts, up to where nodes enter another surface on the way."""
    start, placed, n = problem.start, problem.begun, problem.parts.n
    held = HeldMotions((np.zeros((n, 0)), np.zeros((n, 0))), np.zeros(n), None)
    if start is None:
        lin = after = problem.constraints.linearise(placed.reference, None)
        zeros, forces = np.zeros_like(placed.reference), np.zeros(len(lin.keys))
        state = ContactIterate(placed, zeros, zeros, lin, forces, forces, (lin, forces, forces), held)
    else:
        tangential = np.zeros_like(start.forces) if start.friction is None else start.friction.forces
        anchor = start.linearisation, start.forces, tangential
        displacements = start.positions - placed.reference
        state = ContactIterate(placed, displacements, start.nodal_forces, *anchor, anchor, held)
        after = _unguarded(problem, state)
        travel = np.abs(placed.reference - (start.positions - start.displacements)).max()
        # after little travel the first iteration uses the gaps of the start
        if travel > START_DISTANCE * np.abs(start.displacements).max():
            everywhere = np.arange(problem.response.n_nodes)
            displacements = problem.response.displacements(placed.rotations, everywhere, start.nodal_forces)
            state = state._replace(displacements=displacements)
            after = problem.constraints.linearise(state.positions, after)
    return _up_to_entry(problem, state, after).corrected()


def _up_to_entry(problem: ContactProblem, state: ContactIterate, after: ContactLinearisation) -> ContactIterate:
    """Come from where slip is counted, with the placements there, up to where nodes enter another surface.

    Rigid motions turn along their arcs, and bodies deform straight. The linearisation there is ``after``, that
    about the state, where nothing is in the way.
    """
    (come_from, slip_origin), placements = problem.slip_origin, state.placed.placements
    end, ends = state.positions, list(zip(come_from, placements, strict=True))
    both = np.stack((slip_origin, end))
    bodies = [both[:, first:last] for first, last in itertools.pairwise(problem.response.offsets.tolist())]
    n_pieces = 1 + int(max(abs(last.rotation_rad - first.rotation_rad) for first, last in ends) / MAX_ROTATION_STEP)
    path = [
        np.concatenate([on_path(*of_body, body, piece / n_pieces) for of_body, body in zip(ends, bodies, strict=True)])
        for piece in range(1, n_pieces)
    ]
    at = slip_origin
    for following in (*path, end):
        lin = after if following is end else problem.constraints.linearise(following, after)
        if (entry := problem.constraints.entered(at, following, lin)) is not None:
            at = at + entry.time * (following - at)
            state = state._replace(displacements=at - state.placed.reference, is_guarded=True)
            remaining = np.abs(at - problem.response.undeformed(placements)).max()
            if remaining > MAX_DEFORMATION * problem.parts.size:
                state = _passes(problem, state, entry, "")
            return problem.at(state, problem.constraints.guarded_too(at, lin, entry.guards))
        at = following
    return problem.at(state, after)


def _with_constraints(problem: ContactProblem, state: ContactIterate) -> ContactIterate | None:
    """Without the constraints of nodes that entered on the way, which the solution may not need.

    Where there are none, with those of nodes that overlap although the present ones hold; None if there are none.
    """
    lin = (_unguarded(problem, state) if state.is_guarded else None) or _guarded(problem, state)
    return None if lin is None else problem.at(state._replace(is_guarded=False), lin).corrected()


def _guarded(problem: ContactProblem, state: ContactIterate) -> ContactLinearisation | None:
    """Linearisation about a state with constraints of nodes that overlap; None if there are no further ones."""
    maximum = bending(problem.response, state.placed.placements, state.positions, state.displacements)
    return problem.constraints.guarded(state.positions, state.lin, state.forces, maximum)


def _unguarded(problem: ContactProblem, state: ContactIterate) -> ContactLinearisation:
    """Linearisation about a state without guarded nodes.

    Bodies that slide along a path leave the places where nodes penetrated in earlier steps; but without the nodes
    that hold it a part on a handle would go where its load takes it.
    """
    return state.lin if problem.parts.n else problem.constraints.unguarded(state.positions, state.lin)


def _iterated(problem: ContactProblem, state: ContactIterate) -> ContactIterate:
    """After Newton's method with the forces corrected last; with an outcome where it did not converge.

    A loop of its own: surfaces may stop a step, parts may fall or slide, and constraints come and go within it.
    """
    first, slid_from, pressed = len(state.history), state.placed.motions, _pressed(problem, state)
    state = state._replace(sliding=0)
    while state.n_iterations < problem.settings.max_iterations:
        state = _in_reach(problem, state)
        if state.status is not None:
            return state
        if state.n_iterations >= MEMORY and (lin := _guarded(problem, state)) is not None:
            state = problem.at(state._replace(equations=None), lin)
        way = np.where(pressed, np.abs(state.placed.motions - slid_from) / problem.parts.lengths, 0.0)
        if state.sliding and ((way > MAX_TURN) | (problem.parts.without_turns(way) > MAX_SLIDE)).any():
            return _slides_away(problem, state)
        # deep in first overlaps the geometric stiffness can make the tangent indefinite: K on stiff springs is not
        whole = step(problem, state) or step(problem, state, bend=False)
        if whole is None:
            return state.ended(
                "not converged: the contact laws of a linearised step have no solution: "
                f"{_worst(problem, state)}; check the direction and the size of loads and motions, or "
                "take a finer mesh or a softer penalty"
            )
        settle, fraction = len(state.history) >= MEMORY, 1.0
        limit = MAX_GROWTH * max((iteration.residual for iteration in state.history[-MEMORY:]), default=np.inf)
        trial = after(problem, state, whole, fraction, settle=settle)
        if (entry := problem.constraints.entered(state.positions, trial.positions, trial.lin)) is not None:
            if state.stops == MAX_STOPS:
                return _passes(problem, trial, entry, f", again after {MAX_STOPS} stops")
            state = _stopped(problem, state, whole, entry)
            continue
        while trial.history[-1].residual > limit and fraction > MIN_FRACTION:
            fraction /= 2.0
            trial = after(problem, state, whole, fraction, settle=settle)
        last_pressed, pressed = pressed, _pressed(problem, trial)
        if trial.held.unheld[pressed].any() and np.array_equal(pressed, last_pressed):
            state = trial._replace(sliding=state.sliding + 1)
        else:
            state, slid_from = trial._replace(sliding=0), trial.placed.motions
        # the residual is that of the new state, its law of contact included, whatever changed on the way there
        met = state.history[-1].residual <= _limit(problem, state) and fraction == 1.0
        if met or is_at_round_off(state.history[first:]):
            return state
    # parts without contact still fall, and where it comes and goes it may hold less of the load
    falls = _without_contact(problem, state, pressed) if not state.history[-1].changed else state
    return state.ended(_explain(problem, state)) if falls.status is None else falls


def _limit(problem: ContactProblem, state: ContactIterate) -> float:
    """Residual of a state that has converged: the tolerance, or round-off of its positions."""
    round_off = 64.0 * EPS * max_magnitude(state.placed.reference) / problem.scale(state)
    return max(problem.settings.tolerance, min(round_off, MAX_ROUND_OFF))


def _pressed(problem: ContactProblem, state: ContactIterate) -> Bools:
    """Which motions move a part under contact forces, shape (n,): the others' parts still fall."""
    nodes = np.flatnonzero(state.nodal.any(axis=1)) if problem.parts.n else np.zeros(0, dtype=np.int64)
    return problem.parts.of_bodies(np.unique(problem.response.body_of_node[nodes]))


def _stopped(problem: ContactProblem, state: ContactIterate, whole: ContactStep, entry: Entry) -> ContactIterate:
    """Go only as far along a step as no node enters another surface, and guard those that do."""
    state = after(problem, state, whole, entry.time, settle=False)
    state = problem.at(state, problem.constraints.guarded_too(state.positions, state.lin, entry.guards))
    return state._replace(equations=None, stops=state.stops + 1)


def _in_reach(problem: ContactProblem, state: ContactIterate) -> ContactIterate:
    """Move handles that nothing touches along their loads until a surface is within reach; ends if none comes.

    Their equations have no contact that answers: springs alone, or nothing but the way to the next surface.
    """
    parts, reach, travel = problem.parts, problem.constraints.reach, 0.0
    if not parts.n:
        return state
    scale = MAX_FORCE_ALONG_MOTION * max_magnitude(parts.load)
    while travel <= MAX_TRAVEL * parts.size:
        alone, motions = parts.untouched(state.lin.nodes), state.placed.motions
        left = np.where(alone, parts.forces(motions), 0.0)
        if not (np.abs(left) > scale).any():
            return state
        stiffness, step = parts.springs[np.ix_(alone, alone)], np.zeros(parts.n)
        step[alone] = np.linalg.lstsq(stiffness, left[alone], rcond=None)[0]
        left[alone] -= stiffness @ step[alone]
        velocities = parts.velocities(motions, state.placed.reference)
        if (np.abs(left) > scale).any():  # no spring holds it: as far as the next surface is found
            left = parts.without_turns(left) if (parts.without_turns(np.abs(left)) > scale).any() else left
            step += left * reach / float(norms(velocities @ left).max())
        length = float(norms(velocities @ step).max())
        travel += min(length, reach)
        state = state._replace(placed=problem.placed(motions + step * min(1.0, reach / length)))
        state = problem.at(state, problem.constraints.linearise(state.positions, state.lin))
    return _without_contact(problem, state, np.ones(parts.n, dtype=np.bool_))


def _without_contact(problem: ContactProblem, state: ContactIterate, among: Bools) -> ContactIterate:
    """Ends with the parts that move away because nothing answers to their loads, by ``among`` the motions, (n,)."""
    left, motions = problem.along_motions(state), state.placed.motions
    velocities = problem.parts.velocities(motions, state.positions)
    held = np.einsum("niq,ni->q", np.abs(velocities), np.abs(state.nodal))
    limit = MAX_FORCE_ALONG_MOTION * max_magnitude(problem.parts.load)
    pushed = np.where(among & (np.abs(left) > limit) & (held < limit), left, 0.0)
    words = problem.parts.describe(motions, pushed[:, None] / np.abs(pushed).max()) if pushed.any() else []
    if not words:
        return state
    return state.ended(
        f"no contact holds a load: {'; '.join(words)}; check its direction and its size, place the part "
        "before what is to hold it, hold it in Body(held=...), or leave its load out",
        is_unheld=True,
    )


def _slides_away(problem: ContactProblem, state: ContactIterate) -> ContactIterate:
    """Ends with the motion against which friction does not hold a part."""
    words = "; ".join(problem.parts.describe(state.placed.motions, state.held.unheld[:, None]))
    what = "a load" if problem.parts.load.any() else "what the motion presses"
    return state.ended(
        f"no friction holds {what}: {words}; take a smaller load or motion, a larger coefficient of friction, or "
        "hold the part in Body(held=...)",
        is_unheld=True,
    )


def _passes(problem: ContactProblem, state: ContactIterate, entry: Entry, again: str) -> ContactIterate:
    """Ends with bodies of which one goes into the other, at once or although constraints hold it back."""
    words = problem.constraints.describe_entry(entry, state.positions)
    return state.ended(
        f"not converged: {words}{again}; move or load the bodies less, give all edges that may "
        "touch, or take a finer mesh there",
        is_unheld=not again,
    )


def _explain(problem: ContactProblem, state: ContactIterate) -> str:
    last = state.history[-1]
    advice = "take a softer penalty or a finer mesh"
    if not last.changed:
        reason = f"the displacements still change by {last.change:.1e} of the maximum one"
    else:
        named = [problem.constraints.describe(key, state.positions) for key in last.changed[:MAX_NAMED]]
        more = f" and {len(last.changed) - MAX_NAMED} more" if len(last.changed) > MAX_NAMED else ""
        reason = f"contact still comes and goes at {'; '.join(named)}{more}"
        advice += (
            "; with node-to-segment contact, nodes opposite each other change between two edges: take elements of "
            "another size on one side, as half of it, or segment-to-segment"
        )
    count = _counted(len(state.history), "iteration")
    return f"not converged in {count}: {reason}; {_worst(problem, state)}; {advice}"


def _worst(problem: ContactProblem, state: ContactIterate) -> str:
    """Words for the motion or node that is in equilibrium least, or the node whose laws are violated most."""
    laws, nodes, motions = problem.residuals(state)
    names, positions = problem.constraints, state.positions
    if motions.max(initial=0.0) > max(laws.max(initial=0.0), nodes.max()):
        worst = np.eye(problem.parts.n)[motions.argmax()]
        words = "; ".join(problem.parts.describe(state.placed.motions, worst[:, None]))
        force = abs(float(problem.along_motions(state) @ worst))
        return f"a force of {force:.3g} is not balanced, under which {words}"
    if laws.max(initial=0.0) > nodes.max():
        return f"the laws are violated most at {names.describe(int(state.lin.keys[laws.argmax()]), positions)}"
    node = int(nodes.argmax())
    force = float(np.linalg.norm((state.nodal - state.applied)[node]))
    return f"a force of {force:.3g} is not balanced at {names.describe_node(node, positions)}"


def _converged(problem: ContactProblem, state: ContactIterate) -> tuple[Status, bool | None]:
    """Outcome with the motions that nothing holds in the solution, and whether handles come back after a push."""
    n, motions, stable = problem.parts.n, state.placed.motions, None
    message = f"converged in {_counted(len(state.history), 'iteration')}"
    if state.corrections:
        message += f" and {_counted(state.corrections, 'correction')} of the forces"
    if state.history[-1].residual > _limit(problem, state):
        message += f", to round-off: the residual is {state.history[-1].residual:.1e}"
    if not n:
        return state.outcome(message, converged=True), None
    (kept, free), unstable = state.held.neutral, np.zeros((n, 0))
    if not state.forces.any():
        kept = free = np.eye(n)
    elif free.shape[1] < n and state.slides is None and state.held.tangent is not None:
        matrix, rigid, active = state.held.tangent  # of the last step, which changes nothing any more
        unstable = rigid.unstable(matrix, active, kept)
        stable = False if unstable.size else None if free.size else True
    size = max_magnitude(kept.T @ problem.along_motions(state))
    why = "nothing prevents"
    if size > MAX_UNBALANCED_FORCE * state.forces.sum():
        why = f"hardly anything prevents: it is kept in place, against a force of {size:.2g}"
    named = [f"{words}, which {why}" for words in problem.parts.describe(motions, free)]
    named += [f"{words} out of an unstable equilibrium" for words in problem.parts.describe(motions, unstable)]
    return state.outcome("; ".join((message, *named)), converged=True), stable


def _result(problem: ContactProblem, state: ContactIterate) -> ContactState:
    """The solution of a state that has converged, or has another outcome."""
    status, stable = _converged(problem, state) if state.status is None else (state.status, None)
    # which constraints are said to be closed must not rest on the last digit of the others' forces
    forces = np.where(state.forces > ROUND_OFF * state.forces.max(initial=0.0), state.forces, 0.0)
    state, friction, start = state._replace(forces=forces), None, problem.start
    if (slides := state.slides) is not None:
        slips, let_back = problem.slips(state, slides), state.let_back(state.tangential)
        previous = np.zeros(len(forces))
        if start is not None:
            previous = carried_forces(start.linearisation, start.forces, state.lin)
        friction = friction_state(forces, state.tangential, slips, let_back, state.lin.coefficients, previous)
    return ContactState(
        status,
        state.placed.placements,
        state.displacements,
        state.positions,
        state.lin,
        forces,
        state.nodal,
        state.history,
        friction,
        state.placed.motions,
        stable,
        problem.response,
    )


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"
