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

from flangeway.solve.complementarity import MAX_CHANGES, Motions, equations
from flangeway.types import Bools, Floats, Ints

MOST_PIECES = 2000
"""Linear pieces of a path."""
SAME, NEARLY = 1e-12, 1e-9
"""Error of the law's equations, over the maximum force, that is round-off; and one where guesses go round with it."""
AT_LIMIT = 1e-9
"""Part of the limit by which a tangential force is below it where surfaces stick."""
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


def solve(
    matrix: Floats, offset: Floats, coefficients: Floats, guess: Floats, own: Floats | None = None
) -> Floats | None:
    """Solve ``(s, w) = M (p, q) + b`` with Coulomb's law.

    Parameters
    ----------
    matrix, offset
        M, shape (2 m, 2 m), not symmetric, and b, shape (2 m,).
    coefficients
        Coefficients of friction, shape (m,).
    guess
        Forces p, then q, shape (2 m,).
    own
        Compliance of the bodies against each force alone, shape (2 m,); left out: the diagonal of M.

    Returns
    -------
    Floats or None
        p, then q, shape (2 m,); None where none was found.

    """
    m = len(coefficients)
    coefficients, stiffness = _scaled(coefficients, matrix.diagonal() if own is None else own)

    def solved(active: Bools, signs: Ints) -> Answer:
        forces = np.zeros(2 * m)
        system, right, rows, ratios = _equations(matrix, offset, coefficients, active, signs)
        if len(rows):
            forces[rows] = equations(system, -right)
            forces[m:] += ratios * forces[:m]
        return forces, matrix @ forces + offset

    active = guess[:m] > 0.0 if guess[:m].any() else offset[:m] < 0.0
    at_limit = np.abs(guess[m:]) >= (1.0 - AT_LIMIT) * coefficients * guess[:m]
    signs = np.where((at_limit & (guess[m:] != 0.0)) | (coefficients == 0.0), np.sign(guess[m:]), 0.0).astype(np.int64)
    signs[coefficients == 0.0] = 1
    found = _by_guesses(solved, coefficients, stiffness, (active, signs))
    if found is not None:
        return found
    return _by_path(matrix, offset, coefficients, stiffness, guess)


def solve_with_motions(
    matrix: Floats, offset: Floats, coefficients: Floats, guess: Floats, motions: Motions, *, soft: bool = True
) -> tuple[Floats, Floats, Floats] | None:
    """Solve with free motions: forces (2 m,), motions, what is kept zero; see `complementarity.solve_with_motions`."""
    m, own = len(coefficients), matrix.diagonal()
    softened, lifted, yielding = motions.softened(matrix, offset)
    forces = solve(softened, lifted, coefficients, guess, own)
    if forces is None:
        return None
    sprung = forces, yielding @ np.append(forces, 1.0), np.zeros((2, len(motions.residual), 0))
    coefficients, stiffness = _scaled(coefficients, own)
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
    found = _by_guesses(solved, coefficients, stiffness, _sets(coefficients, stiffness, (forces, gaps)))
    return sprung if found is None else (found, *last[1:])


def _scaled(coefficients: Floats, own: Floats) -> tuple[Floats, Floats]:
    """Coefficients, and stiffness (2 m,) against each force: with none their tangential force stays zero."""
    own = np.maximum(own, 0.0)
    movable = own[len(coefficients) :] > 1e-12 * own.max(initial=0.0)
    stiffness = np.where(own > 0.0, 1.0 / np.where(own > 0.0, own, 1.0), 1.0 / own.max(initial=1e-300))
    return np.where(movable, coefficients, 0.0), stiffness


def _by_guesses(
    solved: Callable[[Bools, Ints], Answer | None], coefficients: Floats, stiffness: Floats, sets: tuple[Bools, Ints]
) -> Floats | None:
    """Forces by the semismooth Newton method from a guess of what is closed and of the signs; None if it cycles."""
    seen: set[bytes] = set()
    for _ in range(MAX_CHANGES):
        active, signs = sets
        answer = solved(active, signs)
        if answer is None:
            return None
        forces = answer[0]
        sets = _sets(coefficients, stiffness, answer)
        if np.array_equal(sets[0], active) and np.array_equal(sets[1], signs):
            return forces
        projected = _projected(coefficients, stiffness, answer)
        error = np.abs(projected - forces).max() / max(np.abs(forces).max(), 1e-300)
        state = active.tobytes() + signs.tobytes()
        if error <= (NEARLY if state in seen else SAME):
            return projected
        if state in seen:
            return None
        seen.add(state)
    return None


def _by_path(matrix: Floats, offset: Floats, coefficients: Floats, stiffness: Floats, guess: Floats) -> Floats | None:
    """Forces at the end of a path from a guess, which solves the problem with another offset.

    As the offset goes over to its own, forces, gaps and slips change linearly until one constraint opens, closes,
    sticks or slips: the path has pieces (D. Ralph, 1994, Math. Oper. Res. 19). None if it turns back.
    """
    m = len(coefficients)
    trial = guess - stiffness * (matrix @ guess + offset)
    start = _projected(coefficients, stiffness, (trial, np.zeros(2 * m)))
    other = (start - trial) / stiffness - matrix @ start - offset
    active, signs = trial[:m] > 0.0, np.sign(trial[m:] - start[m:]).astype(np.int64)
    signs[coefficients == 0.0] = 1
    done = 0.0
    for _ in range(MOST_PIECES):
        system, _, rows, ratios = _equations(matrix, offset, coefficients, active, signs)
        both = np.zeros((2 * m, 2))
        both[rows] = equations(system, -np.column_stack((offset, other))[rows])
        both[m:] += ratios[:, None] * both[:m]
        gaps = matrix @ both + np.column_stack((offset, other))
        left = 1.0 - done
        slips, limits = active & (signs != 0), coefficients[:, None] * both[:m]
        # what must not become negative, with -1 times its rate in the second column
        kept = np.stack(
            (
                np.where(active[:, None], both[:m], gaps[:m]),
                np.where(slips[:, None], -signs[:, None] * gaps[m:], limits - both[m:]),
                limits + both[m:],
            )
        )
        watched = np.stack((np.ones(m, dtype=np.bool_), active & (coefficients > 0.0), active & (signs == 0)))
        falling = watched & (kept[..., 1] > SAME * np.abs(kept[..., 1]).max(initial=1e-300))
        values = kept[..., 0] + left * kept[..., 1]
        ways = np.where(falling, np.maximum(values, 0.0) / np.where(falling, kept[..., 1], 1.0), np.inf)
        kind, which = np.unravel_index(int(ways.argmin()), ways.shape)
        if not ways[kind, which] < left:
            return both[:, 0]
        done += float(ways[kind, which])
        if kind == 0:
            active[which] = not active[which]
            signs[which] = -np.sign(gaps[m + which] @ (1.0, 1.0 - done))  # what closes slips as it did
        else:
            signs[which] = 0 if slips[which] else (1 if kind == 1 else -1)
        signs[coefficients == 0.0] = 1
    return None


def _equations(
    matrix: Floats, offset: Floats, coefficients: Floats, active: Bools, signs: Ints
) -> tuple[Floats, Floats, Ints, Floats]:
    """Equations ``A y + b = 0`` of a guess: A, b, which rows and forces of (p, q) they are, and q over p that slips.

    Active constraints close, with no slip where the sign is 0, else with the limit as force.
    """
    m = len(coefficients)
    normal, sticking = np.flatnonzero(active), np.flatnonzero(active & (signs == 0))
    rows = np.concatenate((normal, m + sticking))
    ratios = np.where(active, coefficients * signs, 0.0)
    system = matrix[np.ix_(rows, rows)]
    system[:, : len(normal)] += matrix[np.ix_(rows, m + normal)] * ratios[normal]
    return system, offset[rows], rows, ratios


def _projected(coefficients: Floats, stiffness: Floats, answer: Answer) -> Floats:
    """What the law's equations make of forces: the same if they satisfy it."""
    m, trial = len(coefficients), answer[0] - stiffness * answer[1]
    normal = np.maximum(trial[:m], 0.0)
    limits = coefficients * normal
    return np.concatenate((normal, np.clip(trial[m:], -limits, limits)))


def _sets(coefficients: Floats, stiffness: Floats, answer: Answer) -> tuple[Bools, Ints]:
    """What is closed, and the sign of the tangential force where it is at its limit, by the law's equations."""
    m, trial = len(coefficients), answer[0] - stiffness * answer[1]
    limits = coefficients * np.maximum(answer[0][:m], 0.0)
    signs = np.where(np.abs(trial[m:]) > limits, np.sign(trial[m:]), 0.0).astype(np.int64)
    signs[answer[0][:m] <= 0.0] = 0  # what closes sticks first
    signs[coefficients == 0.0] = 1
    return trial[:m] > 0.0, signs
