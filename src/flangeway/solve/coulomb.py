"""Coulomb's law for the constraints of a contact: their forces in a linearised step, and what they are in the end.

With normal forces p, gaps s, tangential forces q and slips w, all in the order of the constraints, the law is
``0 <= p, 0 <= s, p s = 0`` and ``|q| <= mu p``, ``w = 0`` where ``|q| < mu p``, and w against q elsewhere. For any
``r > 0`` this is ``p = max(0, p - r s)``, ``q = P(q - r w)`` with the projection P on ``[-mu p, mu p]`` (P. Alart and
A. Curnier, 1991, Comput. Methods Appl. Mech. Eng. 92). Its semismooth Newton method solves linear equations for a guess
of what is open, sticks and slips, and takes the next guess from this equation (S. Hueeber, G. Stadler and B. I.
Wohlmuth, 2008, SIAM J. Sci. Comput. 30). Each r is the stiffness of the bodies against the constraint's own force.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from flangeway.solve.complementarity import Motions, equations
from flangeway.types import Bools, Floats, Ints

MOST_ROUNDS = 30
"""Linear equations of Newton's method."""
MEMORY, HALVINGS = 4, 10
"""Steps whose maximum error the next one has to fall below, and how often a step is halved until it does."""
MOST_PIECES, MOST_WORK = 10_000, 2e11
"""Linear pieces of a path, and the multiplications that they may take: some ten seconds."""
SAME, NEARLY = 1e-12, 1e-9
"""Error of the law's equations, over the maximum force, that is round-off; and one that is taken where none is less."""
AT_LIMIT = 1e-9
"""Part of the limit by which a tangential force is below it where surfaces stick."""
SolvedRows = Callable[[Ints, sp.csr_array], tuple[Floats, Floats]]
"""See `BodyResponse.constrained`."""
Answer = tuple[Floats, Floats]
"""Forces p, then q, and the gaps, then slips, of a guess of what is open, sticks and slips; each (2 m,)."""


@dataclass(frozen=True, eq=False)
class CoulombState:
    """Friction of m constraints at the end of a step.

    Parameters
    ----------
    forces
        Tangential forces on the secondary, positive along the primary's direction, shape (m,).
    slips
        Slips in this step, shape (m,); 0 where surfaces stick or are open.
    elastic
        Slip that the compliance of a penalty, or the tolerance of an augmented Lagrangian, lets back, shape (m,).
    sticks
        Whether a closed constraint sticks, shape (m,).
    work
        Work that the slips dissipated in this step, >= 0.

    """

    forces: Floats
    slips: Floats
    elastic: Floats
    sticks: Bools
    work: float


def friction_state(
    normal: Floats, tangential: Floats, slips: Floats, let_back: Floats, coefficients: Floats
) -> CoulombState:
    """State of constraints by forces, and by slips since the last step with its elastic ones, each (m,).

    ``let_back`` (m,) is what the law of contact adds to the slips: compliance times tangential force.
    """
    closed = normal > 0.0
    sticks = closed & (np.abs(tangential) < (1.0 - AT_LIMIT) * coefficients * normal)
    slipped = np.where(closed & ~sticks & (coefficients > 0.0), slips + let_back, 0.0)
    # a slip that is round-off may have the sign of the force
    slipped = np.where(slipped * tangential > 0.0, 0.0, slipped)
    elastic = np.where(closed, slips - slipped, 0.0)
    return CoulombState(tangential, slipped, elastic, sticks, float(0.0 - (tangential * slipped).sum()))


def violation(normal: Floats, tangential: Floats, slips: Floats, coefficients: Floats) -> tuple[float, float]:
    """Maximum force beyond its limit, and maximum slip that sticks or goes along with the force."""
    limits = coefficients * np.maximum(normal, 0.0)
    beyond = float((np.abs(tangential) - limits).max(initial=0.0))
    loaded = limits > 0.0
    inside = loaded & (np.abs(tangential) < (1.0 - AT_LIMIT) * limits)
    wrong = np.where(inside, np.abs(slips), np.where(loaded, np.maximum(slips * np.sign(tangential), 0.0), 0.0))
    return beyond, float(wrong.max(initial=0.0))


def solve(matrix: Floats, offset: Floats, coefficients: Floats, guess: Floats) -> Floats | None:
    """Solve ``(s, w) = M (p, q) + b`` with Coulomb's law.

    Parameters
    ----------
    matrix, offset
        M, shape (2 m, 2 m), not symmetric, and b, shape (2 m,).
    coefficients
        Coefficients of friction, shape (m,).
    guess
        Forces p, then q, shape (2 m,).

    Returns
    -------
    Floats or None
        p, then q, shape (2 m,); None where none was found.

    """
    m = len(coefficients)
    coefficients, stiffness = _scaled(coefficients, matrix.diagonal())

    def solved(active: Bools, signs: Ints) -> Answer:
        forces = np.zeros(2 * m)
        system, right, rows, ratios = _equations(matrix, offset, coefficients, active, signs)
        if len(rows):
            forces[rows] = equations(system, -right)
            forces[m:] += ratios * forces[:m]
        return forces, matrix @ forces + offset

    # a push that all nodes follow makes none of them slip at once: what stuck sticks first
    for answer in (solved(*_sets_of_forces(coefficients, guess)), (guess, matrix @ guess + offset)):
        found = _by_newton(solved, coefficients, stiffness, answer)
        if found is not None:
            return found
    found = _by_path(matrix, offset, coefficients)
    if found is not None:
        missed = np.abs(_projected(coefficients, stiffness, (found, matrix @ found + offset)) - found).max()
        found = found if missed <= NEARLY * np.abs(found).max() else None
    return found


def solve_sparse(solved_rows: SolvedRows, own: Floats, coefficients: Floats, guess: Floats) -> Floats | None:
    """Solve without the matrix M, by a function from `BodyResponse.constrained` and the compliances ``own`` (2 m,)."""
    m = len(coefficients)
    coefficients, stiffness = _scaled(coefficients, own)

    def solved(active: Bools, signs: Ints) -> Answer:
        rows, ratios = _rows(coefficients, active, signs)
        columns, normal = np.arange(len(rows)), int(active.sum())
        slipping = m + rows[:normal]
        places = np.concatenate((rows, slipping)), np.concatenate((columns, columns[:normal]))
        values = np.concatenate((np.ones(len(rows)), ratios[active]))
        return solved_rows(rows, sp.csr_array((values, places), shape=(2 * m, len(rows))))

    return _by_newton(solved, coefficients, stiffness, solved(*_sets_of_forces(coefficients, guess)))


def solve_with_motions(
    matrix: Floats, offset: Floats, coefficients: Floats, guess: Floats, motions: Motions, *, soft: bool = True
) -> tuple[Floats, Floats, Floats] | None:
    """Solve with free motions: forces (2 m,), motions, what is kept zero; see `complementarity.solve_with_motions`."""
    m = len(coefficients)
    softened, lifted, yielding = motions.softened(matrix, offset)
    forces = solve(softened, lifted, coefficients, guess)
    if forces is None:
        return None
    sprung = forces, yielding @ np.append(forces, 1.0), np.zeros((2, len(motions.residual), 0))
    coefficients, stiffness = _scaled(coefficients, matrix.diagonal())
    last, loads = sprung, motions.loads(forces)

    def solved(active: Bools, signs: Ints) -> Answer | None:
        nonlocal last
        system, right, rows, ratios = _equations(matrix, offset, coefficients, active, signs)
        resultants = motions.resultants[:, rows]
        resultants[:, : active.sum()] += (motions.resultants[:, m:] * ratios)[:, active]
        mine = system, right, motions.by_motion[rows], resultants
        found = motions.held(*mine, loads) if soft else None
        found = found or motions.held(*mine, None)
        if found is None:
            return None
        forces = np.zeros(2 * m)
        forces[rows] = found[0]
        forces[m:] += ratios * forces[:m]
        last = forces, *found[1:]
        return forces, matrix @ forces + motions.by_motion @ found[1] + offset

    gaps = matrix @ forces + motions.by_motion @ sprung[1] + offset
    found = _by_newton(solved, coefficients, stiffness, (forces, gaps))
    return sprung if found is None else (found, *last[1:])


def _scaled(coefficients: Floats, own: Floats) -> tuple[Floats, Floats]:
    """Coefficients, and stiffness (2 m,) against each force: with none their tangential force stays zero."""
    own = np.abs(own)  # negative ones are of bodies that pressure makes unstable where surfaces are apart
    movable = own[len(coefficients) :] > 1e-12 * own.max(initial=0.0)
    stiffness = np.where(own > 0.0, 1.0 / np.where(own > 0.0, own, 1.0), 1.0 / own.max(initial=1e-300))
    return np.where(movable, coefficients, 0.0), stiffness


def _sets_of_forces(coefficients: Floats, forces: Floats) -> tuple[Bools, Ints]:
    """Which constraints are closed and which slip, by forces (2 m,) alone; see `_sets`."""
    m = len(coefficients)
    at_limit = np.abs(forces[m:]) >= (1.0 - AT_LIMIT) * coefficients * forces[:m]
    signs = np.where(at_limit, np.sign(forces[m:]), 0.0).astype(np.int64)
    signs[coefficients == 0.0] = 1
    return forces[:m] > 0.0, signs


def _by_newton(
    solved: Callable[[Bools, Ints], Answer | None], coefficients: Floats, stiffness: Floats, answer: Answer
) -> Floats | None:
    """Forces by the semismooth Newton method from a guess and its gaps; None if it does not converge.

    A step is halved until the error of the law's equations, by its energy, is below the maximum of the last steps (L.
    Grippo, F. Lampariello and S. Lucidi, 1986, SIAM J. Numer. Anal. 23), and goes the whole way if it never is. Forces
    and gaps are linear along it, so that no halving needs further equations.
    """

    def error(answer: Answer) -> float:
        return float(np.linalg.norm((answer[0] - _projected(coefficients, stiffness, answer)) / np.sqrt(stiffness)))

    errors, sets = [error(answer)], _sets(coefficients, stiffness, answer)
    for number in range(max(MOST_ROUNDS, len(coefficients))):
        # the ends of a zone that sticks come nearer by a node a round: on long surfaces that takes many, all better
        if number >= MOST_ROUNDS and errors[-1] >= errors[-2]:
            return None
        found = solved(*sets)
        if found is None:
            return None
        new_sets, projected = _sets(coefficients, stiffness, found), _projected(coefficients, stiffness, found)
        if all(np.array_equal(*each) for each in zip(sets, new_sets, strict=True)):
            return found[0]
        tolerance = SAME if number < MOST_ROUNDS - 1 else NEARLY
        if np.abs(projected - found[0]).max() <= tolerance * max(np.abs(found[0]).max(), 1e-300):
            return projected
        for share in (*0.5 ** np.arange(HALVINGS), 1.0):
            tried = (answer[0] + share * (found[0] - answer[0]), answer[1] + share * (found[1] - answer[1]))
            if error(tried) < max(errors[-MEMORY:]):
                break
        answer = tried
        errors.append(error(answer))
        sets = _sets(coefficients, stiffness, answer)
    return None


def _by_path(matrix: Floats, offset: Floats, coefficients: Floats) -> Floats | None:
    """Forces at the end of a path along which bodies that are apart are brought together.

    With t added to all gaps forces, gaps and slips change linearly with t until one constraint opens, closes, sticks or
    slips. Then t goes the way on which this constraint satisfies the law: mostly down, sometimes up again (C. E. Lemke,
    1965, Manage. Sci. 11, without its tableau). It ends at t = 0 if M is positive definite, whatever the coefficients
    are (R. W. Cottle, J.-S. Pang and R. E. Stone, 1992, The linear complementarity problem, 4.4: copositive matrices).
    """
    m = len(coefficients)
    moving = coefficients > 0.0
    active, signs = np.zeros(m, dtype=np.bool_), np.where(moving, 0, 1)
    lifted = np.column_stack((offset, np.repeat((1.0, 0.0), m)))
    kind, which, added = 0, int(offset[:m].argmin()), -float(offset[:m].min())
    if added <= 0.0:
        return np.zeros(2 * m)
    active[which], signs[which] = True, -np.sign(offset[m + which]) if moving[which] else 1
    for _ in range(int(min(MOST_PIECES, MOST_WORK / (2.0 * m) ** 3))):
        system, _, rows, ratios = _equations(matrix, offset, coefficients, active, signs)
        both = np.zeros((2 * m, 2))
        both[rows] = equations(system, -lifted[rows])
        both[m:] += ratios[:, None] * both[:m]
        gaps = matrix @ both + lifted
        slips, limits = active & (signs != 0), coefficients[:, None] * both[:m]
        # what must not become negative, with its rate by t in the second column
        kept = np.stack(
            (
                np.where(active[:, None], both[:m], gaps[:m]),
                np.where(slips[:, None], -signs[:, None] * gaps[m:], limits - both[m:]),
                limits + both[m:],
            )
        )
        watched = np.stack((np.ones(m, dtype=np.bool_), active & moving, active & moving & ~slips))
        watched[kind, which] = False  # what has changed last is zero and grows
        rates = np.sign(kept[kind, which, 1]) * kept[..., 1]
        falling = watched & (rates < -SAME * np.abs(rates).max())
        values = np.maximum(kept[..., 0] + added * kept[..., 1], 0.0)
        ways = np.where(falling, values / np.where(falling, -rates, 1.0), np.inf)
        way, down = float(ways.min()), kept[kind, which, 1] < 0.0
        if down and way >= added:
            return both[:, 0]
        if not np.isfinite(way):
            return None
        added -= way if down else -way
        kind, which = (int(each) for each in np.unravel_index(ways.argmin(), ways.shape))
        if kind == 0:
            active[which] = not active[which]
            signs[which] = -np.sign(gaps[m + which] @ (1.0, added)) if moving[which] else 1  # it slips as it did
        elif slips[which]:
            kind, signs[which] = (1 if signs[which] > 0 else 2), 0
        else:
            kind, signs[which] = 1, (1 if kind == 1 else -1)
    return None


def _equations(
    matrix: Floats, offset: Floats, coefficients: Floats, active: Bools, signs: Ints
) -> tuple[Floats, Floats, Ints, Floats]:
    """Equations ``A y + b = 0`` of a guess: A, b, which rows and forces of (p, q) they are, and q over p that slips.

    Active constraints close, with no slip where the sign is 0, else with the limit as force.
    """
    rows, ratios = _rows(coefficients, active, signs)
    normal = rows[: active.sum()]
    system = matrix[np.ix_(rows, rows)]
    system[:, : len(normal)] += matrix[np.ix_(rows, len(coefficients) + normal)] * ratios[normal]
    return system, offset[rows], rows, ratios


def _rows(coefficients: Floats, active: Bools, signs: Ints) -> tuple[Ints, Floats]:
    """Which of (p, q) are unknown: all that are closed, then those that stick; and q over p of what slips, (m,)."""
    sticking = len(coefficients) + np.flatnonzero(active & (signs == 0))
    return np.concatenate((np.flatnonzero(active), sticking)), np.where(active, coefficients * signs, 0.0)


def _projected(coefficients: Floats, stiffness: Floats, answer: Answer) -> Floats:
    """What the law's equations make of forces: the same if they satisfy it."""
    m, trial = len(coefficients), answer[0] - stiffness * answer[1]
    normal = np.maximum(trial[:m], 0.0)
    limits = coefficients * normal
    return np.concatenate((normal, np.clip(trial[m:], -limits, limits)))


def _sets(coefficients: Floats, stiffness: Floats, answer: Answer) -> tuple[Bools, Ints]:
    """What is closed, and the sign of the tangential force where it is at its limit, by the law's equations."""
    m, trial = len(coefficients), answer[0] - stiffness * answer[1]
    limits = coefficients * np.maximum(trial[:m], 0.0)
    signs = np.where(np.abs(trial[m:]) > limits, np.sign(trial[m:]), 0.0).astype(np.int64)
    signs[coefficients == 0.0] = 1
    return trial[:m] > 0.0, signs
