"""Coulomb's law for the constraints of a contact: their forces in a linearised step, and what they are in the end.

With normal forces p, gaps s, tangential forces q and slips w, all in the order of the constraints, the law is
``0 <= p, 0 <= s, p s = 0`` and ``|q| <= mu p``, ``w = 0`` where ``|q| < mu p``, and w against q elsewhere. For any
``r > 0`` this is ``p = max(0, p - r s)``, ``q = P(q - r w)`` with the projection P on ``[-mu p, mu p]`` (P. Alart and
A. Curnier, 1991, Comput. Methods Appl. Mech. Eng. 92). Its semismooth Newton method solves linear equations for a guess
of what is open, sticks and slips, and takes the next guess from this equation (S. Hueeber, G. Stadler and B. I.
Wohlmuth, 2008, SIAM J. Sci. Comput. 30). Each r is the stiffness of the bodies against the constraint's own force.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.solve import complementarity
from flangeway.solve.complementarity import MAX_CHANGES, equations
from flangeway.types import Bools, Floats, Ints

LEAST_PART = 1.0 / 1024.0
"""Smallest part of the coefficients by which friction grows from none where guesses go round."""
SAME, NEARLY = 1e-12, 1e-9
"""Error of the law's equations, over the maximum force, that is round-off; and one where guesses go round with it."""
AT_LIMIT = 1e-9
"""Part of the limit by which a tangential force is below it where surfaces stick."""


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
    return CoulombState(tangential, slipped, elastic, sticks, float(-(tangential * slipped).sum()))


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
    own = np.maximum(matrix.diagonal(), 0.0)
    # constraints on what is held have no stiffness: their tangential force stays zero
    movable = own[m:] > 1e-12 * own.max(initial=0.0)
    coefficients = np.where(movable, coefficients, 0.0)
    stiffness = np.where(own > 0.0, 1.0 / np.where(own > 0.0, own, 1.0), 1.0 / own.max(initial=1e-300))
    active = guess[:m] > 0.0 if guess[:m].any() else offset[:m] < 0.0
    at_limit = np.abs(guess[m:]) >= (1.0 - AT_LIMIT) * coefficients * guess[:m]
    signs = np.where((at_limit & (guess[m:] != 0.0)) | (coefficients == 0.0), np.sign(guess[m:]), 0.0).astype(np.int64)
    signs[coefficients == 0.0] = 1
    found = _by_guesses(matrix, offset, coefficients, stiffness, (active, signs))
    if found is not None:
        return found
    symmetric = (matrix[:m, :m] + matrix[:m, :m].T) / 2.0
    normal = complementarity.solve(symmetric, offset[:m], active)
    if normal is None:
        return None
    forces, done, part = np.concatenate((normal, np.zeros(m))), 0.0, 0.5
    while part >= LEAST_PART:
        share = min(done + part, 1.0)
        sets = _sets(matrix, offset, share * coefficients, stiffness, forces)
        found = _by_guesses(matrix, offset, share * coefficients, stiffness, sets)
        if found is None:
            part /= 4.0
            continue
        if share == 1.0:
            return found
        forces, done, part = found, share, 2.0 * part
    return None


def _by_guesses(
    matrix: Floats, offset: Floats, coefficients: Floats, stiffness: Floats, sets: tuple[Bools, Ints]
) -> Floats | None:
    """Forces by the semismooth Newton method from a guess of what is closed and of the signs; None if it cycles."""
    seen: set[bytes] = set()
    for _ in range(MAX_CHANGES):
        active, signs = sets
        forces = _solved(matrix, offset, coefficients, active, signs)
        sets = _sets(matrix, offset, coefficients, stiffness, forces)
        if np.array_equal(sets[0], active) and np.array_equal(sets[1], signs):
            return forces
        projected = _projected(matrix, offset, coefficients, stiffness, forces)
        error = np.abs(projected - forces).max() / max(np.abs(forces).max(), 1e-300)
        state = active.tobytes() + signs.tobytes()
        if error <= (NEARLY if state in seen else SAME):
            return projected
        if state in seen:
            return None
        seen.add(state)
    return None


def _solved(matrix: Floats, offset: Floats, coefficients: Floats, active: Bools, signs: Ints) -> Floats:
    """Forces that close the active constraints, with no slip where the sign is 0, else with the limit as force."""
    m = len(coefficients)
    forces = np.zeros(2 * m)
    normal, sticking = np.flatnonzero(active), np.flatnonzero(active & (signs == 0))
    rows = np.concatenate((normal, m + sticking))
    if len(rows):
        system = matrix[np.ix_(rows, rows)]
        ratios = coefficients[normal] * signs[normal]
        system[:, : len(normal)] += matrix[np.ix_(rows, m + normal)] * ratios
        found = equations(system, -offset[rows])
        forces[normal] = found[: len(normal)]
        forces[m + normal] = ratios * found[: len(normal)]
        forces[m + sticking] = found[len(normal) :]
    return forces


def _trial(matrix: Floats, offset: Floats, stiffness: Floats, forces: Floats) -> Floats:
    return np.asarray(forces - stiffness * (matrix @ forces + offset))


def _projected(matrix: Floats, offset: Floats, coefficients: Floats, stiffness: Floats, forces: Floats) -> Floats:
    """What the law's equations make of forces: the same if they satisfy it."""
    m = len(coefficients)
    trial = _trial(matrix, offset, stiffness, forces)
    normal = np.maximum(trial[:m], 0.0)
    limits = coefficients * normal
    return np.concatenate((normal, np.clip(trial[m:], -limits, limits)))


def _sets(
    matrix: Floats, offset: Floats, coefficients: Floats, stiffness: Floats, forces: Floats
) -> tuple[Bools, Ints]:
    """What is closed, and the sign of the tangential force where it is at its limit, by the law's equations."""
    m = len(coefficients)
    trial = _trial(matrix, offset, stiffness, forces)
    limits = coefficients * np.maximum(forces[:m], 0.0)
    signs = np.where(np.abs(trial[m:]) > limits, np.sign(trial[m:]), 0.0).astype(np.int64)
    signs[forces[:m] <= 0.0] = 0  # what closes sticks first
    signs[coefficients == 0.0] = 1
    return trial[:m] > 0.0, signs
