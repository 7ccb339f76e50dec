"""One iteration for contact: the linearised problem about a state, its step, and the state after it.

See `flangeway.contact.newton` for the equations.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from flangeway.contact.contact_state import ContactEquations, ContactIterate, ContactProblem, HeldMotions
from flangeway.contact.system import changed_keys
from flangeway.geometry.arrays import max_magnitude
from flangeway.solve.active_set import Answer, DenseEquations, Laws, Motions, solve, sparse_equations
from flangeway.solve.body_response import Constrained
from flangeway.solve.status import Iteration
from flangeway.space.symmetric import EPS
from flangeway.types import Bools, Floats, Ints

SPRING, STIFF_SPRING = 1e-6, 1.0
"""Stiffness of the springs that hold motions within a step, relative to the maximum stiffness of one constraint; and
the same where the equations with the geometric stiffness had no solution."""

SOFTNESSES = 0.0, 1.0, 0.5, 0.25
"""Powers of the stiffness of these springs, that of the softest ones over theirs, in the order in which they are tried:
with friction the equations may have no solution with the softest."""

RELAXATION = 4.0
"""Factor by which springs are softer with each iteration of such a way: a load just beyond the limit is a slow push."""

OPEN_GAP = 0.01
"""Gap relative to the maximum displacement, or way, from which constraints are left out of iterations that keep them
open."""

GAP_CLOSURE = 2.0 * np.sqrt(2.0)
"""Closing of a gap relative to the maximum component of the nodes' displacements, at most."""

OLD_DERIVATIVES_RESIDUAL = 1e-6
"""Residual up to which the equations of an iteration may serve the next one."""

MAX_DENSE_EQUATIONS = 4000
"""Equations of a contact with friction up to which a dense matrix of them is made where there is another way."""


class LinearisedContact(NamedTuple):
    """Gaps and slips linearised about a state.

    - `gaps`, `candidates`: gaps at which constraints begin to push, and which constraints may close, (m,) each.
    - `geometric`, `constrained`: geometric stiffness, and gaps, then slips where there is friction.
    - `previous`: equations of the iteration before if they serve once more.
    - `bend`: with the geometric stiffness.
    """

    gaps: Floats
    candidates: Bools
    geometric: sp.csr_array
    constrained: Constrained
    previous: ContactEquations | None
    bend: bool


class ContactStep(NamedTuple):
    """New forces, nodal forces in equilibrium with them, change of the motions, and what the step leaves in the state.

    Forces (m,), tangential ones (m,), nodal ones (n_nodes, 2), motions (n,).
    """

    forces: Floats
    tangential: Floats
    applied: Floats
    motion: Floats
    held: HeldMotions
    equations: ContactEquations | None


def linearise(problem: ContactProblem, state: ContactIterate, *, bend: bool) -> LinearisedContact:
    """Linearise gaps and slips about a state.

    - `bend`: with the geometric stiffness, by which the tangent may be indefinite deep in a first overlap.
    """
    lin, slides, forces = state.lin, state.slides, state.forces
    products, reaches = lin.barriers.T
    # barriers push before surfaces meet
    gaps = state.gaps - np.where(products > 0.0, reaches, 0.0)
    candidates = (forces > 0.0) | (gaps <= OPEN_GAP * problem.scale(state))
    previous = state.equations if bend and _derivatives_still_valid(problem, state, candidates) else None
    candidates = candidates if candidates.any() else ~candidates
    geometric = lin.curvature(-forces) if previous is None else previous.geometric
    jacobian, directions, compliances, violations = lin.jacobian, lin.jacobian, state.compliances, state.gaps
    if slides is not None:
        if previous is None:
            geometric = geometric + slides.curvature(-state.tangential)
        directions, jacobian = (
            sp.csr_array(sp.vstack((jacobian, of_slips))) for of_slips in (slides.directions, slides.jacobian)
        )
        compliances = np.tile(compliances, 2)
        slips = problem.slips(state, slides) + state.let_back(np.zeros(len(violations)))
        violations = np.concatenate((violations, slips))
    geometric = geometric if bend else sp.csr_array(geometric.shape)
    at_nodes = state.displacements[lin.nodes].ravel()
    constrained = Constrained(at_nodes, jacobian, directions, compliances, violations)
    return LinearisedContact(gaps, candidates, geometric, constrained, previous, bend)


def _derivatives_still_valid(problem: ContactProblem, state: ContactIterate, candidates: Bools) -> bool:
    """Whether the equations of the iteration before, of the same constraints, are enough for one more.

    The residual that it leaves is about the product of the last one and of the last step, by which the derivatives
    have changed.
    """
    if state.equations is None:
        return False
    last, lin, equations = state.history[-1], state.lin, state.equations
    small = last.residual <= OLD_DERIVATIVES_RESIDUAL and last.residual * last.change <= problem.settings.tolerance
    same_keys = np.array_equal(equations.keys, lin.keys[candidates])
    return small and not last.changed and same_keys and np.array_equal(equations.nodes, lin.nodes)


def step(problem: ContactProblem, state: ContactIterate, *, bend: bool = True) -> ContactStep | None:
    """Step of one iteration; None if the laws of the linearised problem have no solution."""
    applied = np.zeros_like(state.displacements)
    if len(state.lin.nodes) == 0:
        motion = np.zeros(problem.parts.n)
        return ContactStep(state.forces, state.tangential, applied, motion, state.held, state.equations)
    linearised = linearise(problem, state, bend=bend)
    gaps, constrained = linearised.gaps, linearised.constrained
    while True:
        solution = _step_among(problem, state, linearised)
        if solution is None:
            return None
        forces, displacements, motion, held, equations = solution
        # the laws of the others hold with them open if the step leaves a gap there, which it closes by no more than
        # nodes of both sides move: the mean over a sliver of an edge has derivatives that say more
        change = displacements - constrained.displacements
        predicted = gaps + (constrained.jacobian @ change)[: len(gaps)]
        closing = (predicted < 0.0) & (gaps < GAP_CLOSURE * max_magnitude(change)) & ~linearised.candidates
        if not closing.any():
            break
        linearised = linearised._replace(candidates=linearised.candidates | closing, previous=None)
    nodal = constrained.directions.T @ forces - linearised.geometric @ change
    applied[state.lin.nodes] = nodal.reshape(-1, 2)
    tangential = state.tangential if state.slides is None else forces[len(gaps) :]
    return ContactStep(forces[: len(gaps)], tangential, applied, motion, held, equations)


def _step_among(
    problem: ContactProblem, state: ContactIterate, linearised: LinearisedContact
) -> tuple[Floats, Floats, Floats, HeldMotions, ContactEquations | None] | None:
    """Forces of all constraints, displacements of the touched nodes, and what follows in `ContactStep`."""
    lin, rotations, motions = state.lin, state.placed.rotations, state.placed.motions
    geometric, candidates = linearised.geometric, linearised.candidates
    rows = np.flatnonzero(np.tile(candidates, 1 if state.slides is None else 2))
    constrained = linearised.constrained.of(rows)
    coefficients, barriers = lin.coefficients[candidates], lin.barriers[candidates]
    guess = np.concatenate((state.forces, state.tangential))[rows]
    forces = np.zeros(len(linearised.constrained.violations))
    if (
        state.slides is not None
        and len(rows) > MAX_DENSE_EQUATIONS
        and not (problem.parts.n or barriers[:, 0].any())
        and (solver := problem.response.constrained(rotations, lin.nodes, geometric, constrained)) is not None
    ):
        solved, diagonal = solver
        laws = Laws(coefficients, barriers, diagonal)
        answer = solve(laws, sparse_equations(solved, laws), guess)
        if answer is None:
            return None
        forces[rows] = answer.forces
        loads = constrained.directions.T @ answer.forces + geometric @ constrained.displacements
        tangent = problem.response.tangent(rotations, lin.nodes, geometric, symmetric=False)
        return forces, tangent(sp.csr_array(loads[:, None]))[:, 0], np.zeros(0), state.held, None
    previous = linearised.previous
    if previous is None:
        equations = _new_equations(problem, state, geometric, constrained, lin.keys[candidates])
    else:
        equations = _updated_equations(problem, state, previous, constrained, guess)
    answer, held = _answer(problem, state, equations, (coefficients, barriers), guess, bend=linearised.bend)
    if answer is None:
        return None
    held = held._replace(tangent=(equations.matrix, equations.rigid, answer.forces[: len(coefficients)] > 0.0))
    # if one more iteration was not enough, the next one has its own
    serves = linearised.bend and previous is None
    motion = problem.parts.shortened(answer.motions, problem.parts.velocities(motions, state.placed.reference))
    forces[rows] = answer.forces
    displacements = equations.by_loads @ np.concatenate((answer.forces, (1.0,), motion))
    return forces, displacements, motion, held, equations if serves else None


def _answer(
    problem: ContactProblem,
    state: ContactIterate,
    equations: ContactEquations,
    laws_of: tuple[Floats, Floats],
    guess: Floats,
    *,
    bend: bool,
) -> tuple[Answer | None, HeldMotions]:
    """Forces and motions of an iteration's equations, by coefficients and barriers, and what holds the motions.

    With springs against the motions there always is a solution; without them Newton's method for the motions goes
    on from there. Where nothing but springs holds a part they are soft, so that it falls on what is to hold it.
    """
    matrix, offset, rigid, held = equations.matrix, equations.offset, equations.rigid, state.held
    if not problem.parts.n:
        laws = Laws(*laws_of, matrix.diagonal())
        return DenseEquations(matrix, offset, laws, rigid).answer(guess), held
    last: Answer | None = None
    stiff = sprung = rigid.sprung(matrix.diagonal(), SPRING if bend else STIFF_SPRING)
    for softness in SOFTNESSES:
        if last is not None:
            sprung = rigid.softly_sprung(stiff, last.forces, softness, RELAXATION**state.sliding)
        laws = Laws(*laws_of, matrix.diagonal() + sprung.compliances())
        answer = solve(laws, DenseEquations(matrix, offset, laws, sprung), guess)
        if answer is None and last is None:
            return None, held
        if answer is None:
            continue
        dense = DenseEquations(matrix, offset, laws, rigid)
        left, right, loose = dense.free_motions(answer)
        held = held._replace(neutral=(np.linalg.qr(left)[0], np.linalg.qr(right)[0]))
        basis = _complement(left), _complement(right)
        kept = DenseEquations(matrix, offset, laws, rigid.without(*basis))
        exact = None if loose else solve(laws, kept, answer.forces)
        if exact is not None:
            held = held._replace(unheld=np.zeros(problem.parts.n))
            return exact._replace(motions=basis[1] @ exact.motions), held
        if state.slides is not None:
            held = held._replace(unheld=rigid.unbalanced(answer, held.neutral[0]))
        if last is not None:
            return answer, held
        last = answer
    return last, held


def _new_equations(
    problem: ContactProblem, state: ContactIterate, geometric: sp.csr_array, constrained: Constrained, keys: Ints
) -> ContactEquations:
    """Linear complementarity problem of an iteration with the constraints of some keys."""
    parts, nodes, motions, is_symmetric = problem.parts, state.lin.nodes, state.placed.motions, state.slides is None
    at_nodes, jacobian, directions = constrained.displacements, constrained.jacobian, constrained.directions
    n = 2 * len(nodes)
    m = len(constrained.violations)
    rigid = parts.velocities(motions, state.positions)[nodes].reshape(n, parts.n)
    turned = parts.turned(state.applied)[nodes].reshape(n, parts.n)
    by_rigid, by_forces = turned - geometric @ rigid, turned - geometric.T @ rigid
    loads = sp.hstack((directions.T, np.column_stack((geometric @ at_nodes, by_rigid))), format="csr")
    solved = problem.response.tangent(state.placed.rotations, nodes, geometric, symmetric=is_symmetric)
    answer = solved(loads)
    stiffness = by_forces.T @ answer[:, m + 1 :] - rigid.T @ (geometric @ rigid)
    # of the rotation's own second derivative; that of a rotation and a slide vanishes in equilibrium
    stiffness[np.diag_indices(parts.n)] += np.einsum("dq,dq->q", turned, rigid)
    stiffness += parts.tangent(motions)
    residual = by_forces.T @ (answer[:, m] - at_nodes) + parts.forces(motions)
    resultants = by_forces.T @ answer[:, :m] + (directions @ rigid).T
    answer[:, m + 1 :] += rigid
    at_gaps = jacobian @ answer
    matrix = at_gaps[:, :m] + np.diag(constrained.compliances)
    offset = constrained.violations - jacobian @ at_nodes + at_gaps[:, m]
    by_motion = at_gaps[:, m + 1 :]
    if is_symmetric:  # but for rounding
        matrix, stiffness = (matrix + matrix.T) / 2.0, (stiffness + stiffness.T) / 2.0
        resultants = by_motion.T
    of_motions = Motions(by_motion, resultants, stiffness, residual, parts.numbers, parts.sizes)
    return ContactEquations(keys, nodes, geometric, solved, answer, matrix, offset, of_motions, by_forces)


def _updated_equations(
    problem: ContactProblem, state: ContactIterate, previous: ContactEquations, constrained: Constrained, forces: Floats
) -> ContactEquations:
    """The same about the present state and forces y, with derivatives of the iteration before.

    With the forces e that are not balanced, displacements are ``u + Y e + Y D^T (y' - y)``.
    """
    unbalanced = (state.nodal - state.applied)[state.lin.nodes]
    moved = previous.solved(sp.csr_array(unbalanced.reshape(-1, 1)))[:, 0]
    by_loads, m = previous.by_loads.copy(), len(forces)
    by_loads[:, m] = constrained.displacements + moved - by_loads[:, :m] @ forces
    offset = constrained.violations + constrained.jacobian @ moved + constrained.compliances * forces
    residual = problem.along_motions(state) + previous.by_forces.T @ moved - previous.rigid.resultants @ forces
    rigid = replace(previous.rigid, residual=residual)
    return previous._replace(by_loads=by_loads, offset=offset - previous.matrix @ forces, rigid=rigid)


def after(
    problem: ContactProblem, state: ContactIterate, step: ContactStep, fraction: float, *, settle: bool
) -> ContactIterate:
    """State after a fraction of a step."""
    placed = problem.placed(state.placed.motions + fraction * step.motion) if problem.parts.n else state.placed
    nodes = state.lin.nodes
    displacements = problem.response.displacements(placed.rotations, nodes, step.applied[nodes])
    values = [displacements, step.applied, step.forces, step.tangential]
    if fraction < 1.0:
        # bodies are linear: a fraction of the displacements is that by a fraction of the forces
        old_values = state.displacements, state.applied, state.forces, state.tangential
        values = [old + fraction * (new - old) for old, new in zip(old_values, values, strict=True)]
    displacements, applied, forces, tangential = values
    new = state._replace(
        placed=placed,
        displacements=displacements,
        applied=applied,
        forces=forces,
        tangential=tangential,
        held=step.held,
        equations=step.equations,
    )
    new = problem.at(new, problem.constraints.linearise(new.positions, state.lin, settle=settle))
    yielding = max(max_magnitude(vector) for vector in (displacements, new.compliances * new.forces))
    if yielding <= EPS * max_magnitude(placed.reference) and not problem.parts.forces(placed.motions).any():
        # nothing presses, and neither bodies nor laws yield: what is left of forces is round-off
        zeros = np.zeros_like(new.forces)
        new = new._replace(forces=zeros, tangential=zeros, applied=np.zeros_like(applied))
    residual = max(float(values.max(initial=0.0)) for values in problem.residuals(new))
    change = max_magnitude(displacements - state.displacements) / problem.scale(new)
    changed = changed_keys(state.lin, (state.forces, state.tangential), new.lin, (new.forces, new.tangential))
    iteration = Iteration(change, residual, int((new.forces > 0).sum()), changed, state.corrections)
    return new._replace(history=(*state.history, iteration))


def _complement(directions: Floats) -> Floats:
    """Orthonormal directions (n, n - r) across those of the columns (n, r)."""
    n, r = directions.shape
    return np.linalg.qr(directions, mode="complete")[0][:, r:] if r else np.eye(n)
