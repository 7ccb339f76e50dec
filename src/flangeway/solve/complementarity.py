"""Linear complementarity: ``s = M p + q``, ``p >= 0``, ``s >= 0``, ``p . s = 0``."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.types import Bools, Floats, Ints

MAX_CHANGES = 60

MAX_ROUNDS = 100
"""Rounds in which the law of a barrier is linearised: forces about double in each, until they are near."""

SETTLED = 1e-10
"""Change of forces over the maximum one at which that law holds: the next change is its square."""

SPRING = 1e-6
"""Stiffness of springs that hold free motions until constraints do, over the maximum stiffness of one constraint."""

NO_STIFFNESS = 1e-10
"""Stiffness against a motion over the maximum one, below which nothing holds it."""

SOFT = 1.0
"""Stiffness against a motion over the forces on a part by its size, below which its contacts hardly hold it: it is one
of curved contact surfaces, or an error of the meshes, not of the materials."""

LEFT = 1e-3
"""Force along a motion that is hardly held over the forces on the part, below which it is kept in place."""

NO_FORCE = 1e-9
"""Force over the one that would close the maximum gap, below which a constraint only touches."""


def solve(matrix: Floats, offset: Floats, active: NDArray[np.bool_]) -> Floats | None:
    """Solve a complementarity problem by a primal-dual active set, from a guess of where p > 0, shape (n,).

    Each round solves the equations of the active set and moves every unknown of wrong sign (Hintermueller, Ito and
    Kunisch, 2002, SIAM J. Optim. 13). If the rounds cycle and the matrix (n, n) is positive definite, the equivalent
    non-negative least squares problem is solved by Lawson and Hanson's finite method. Returns p, shape (n,), or None.
    """
    active = active.copy()
    for _ in range(MAX_CHANGES):
        pressure = np.zeros(len(offset))
        if active.any():
            pressure[active] = equations(matrix[np.ix_(active, active)], -offset[active])
        slack = matrix @ pressure + offset
        changed = np.where(active, pressure > 0.0, slack < 0.0)
        if (changed == active).all():
            return pressure
        active = changed
    return _least_squares(matrix, offset)


@dataclass(frozen=True, eq=False)
class Motions:
    """Unknowns q besides p, of any sign, with as many equations ``L p + H q + e = 0``; slacks have ``N q`` added.

    Parameters
    ----------
    by_motion
        N, shape (n, m).
    resultants
        L, shape (m, n): ``N^T`` without friction.
    stiffness
        H, symmetric without friction, shape (m, m).
    residual
        e, shape (m,).
    parts, sizes
        Number and size of the part that each unknown moves, shape (m,).

    """

    by_motion: Floats
    resultants: Floats
    stiffness: Floats
    residual: Floats
    parts: Ints
    sizes: Floats

    def loads(self, pressure: Floats) -> Floats:
        """Maximum over the motions of its part of the sum of forces along each, shape (m,)."""
        return self._most(np.abs(self.resultants) @ np.abs(pressure))

    def _most(self, along: Floats) -> Floats:
        most = np.zeros(int(self.parts.max(initial=0)) + 1)
        np.maximum.at(most, self.parts, along + np.abs(self.residual))
        return most[self.parts]

    def softened(self, matrix: Floats, offset: Floats) -> tuple[Floats, Floats, Floats]:
        """Matrix and offset of the problem whose motions soft springs hold, and the motions by p and 1 (m, n + 1)."""
        n = len(self.residual)
        stiffest = float((np.sum(self.by_motion**2, axis=1) / np.maximum(matrix.diagonal(), 1e-300)).max(initial=0.0))
        symmetric = (self.stiffness + self.stiffness.T) / 2.0
        spring = SPRING * (stiffest or 1.0) + 2.0 * max(float(np.linalg.eigvalsh(symmetric).max(initial=0.0)), 0.0)
        by_forces = np.column_stack((self.resultants, self.residual))
        yielding = np.asarray(np.linalg.solve(spring * np.eye(n) - self.stiffness, by_forces), dtype=np.float64)
        return matrix + self.by_motion @ yielding[:, :-1], offset + self.by_motion @ yielding[:, -1], yielding

    def held(
        self, matrix: Floats, offset: Floats, by_motion: Floats, resultants: Floats, loads: Floats | None
    ) -> tuple[Floats, Floats, Floats] | None:
        """Solve ``M y + N q + b = 0``, ``L y + H q + e = 0`` of k forces y that act: these, and the least q (m,).

        Motions that nothing holds are zero, and with `loads` those that are hardly held. None if forces act on them.
        The last result is what they leave undetermined, (2, m, r): directions of no equation, and of no motion.
        """
        n = len(self.residual)
        answer = equations(matrix, np.column_stack((by_motion, offset)))
        stiffness = resultants @ answer[:, :n] - self.stiffness
        weights = np.ones(n) if loads is None else np.maximum(loads, 1e-12 * loads.max(initial=1e-300)) / self.sizes
        root = np.sqrt(weights)
        left, values, right = np.linalg.svd(stiffness / root / root[:, None])
        held = values > (NO_STIFFNESS * values.max(initial=0.0) if loads is None else SOFT)
        wanted = self.residual - resultants @ answer[:, n]
        motion = (right[held].T @ ((left[:, held].T @ (wanted / root)) / values[held])) / root
        forces = -answer @ np.append(motion, 1.0)
        unbalanced = np.abs(resultants @ forces + self.stiffness @ motion + self.residual)
        most = self._most(np.abs(resultants) @ np.abs(forces))
        if (unbalanced > (1e-8 if loads is None else LEFT) * most).any():
            return None
        free = np.linalg.qr(left[:, ~held] * root[:, None])[0], np.linalg.qr(right[~held].T / root[:, None])[0]
        return forces, motion, np.stack(free)

    def unstable(self, matrix: Floats, active: Bools, kept: Floats) -> Floats:
        """Motions out of an unstable equilibrium, apart from those that are kept zero (m, k): shape (m, n_motions)."""
        mine = self.by_motion[active]
        stiffness = mine.T @ equations(matrix[np.ix_(active, active)], mine) - self.stiffness
        limit = NO_STIFFNESS * np.abs(stiffness).max(initial=0.0)
        away = np.eye(len(stiffness)) - kept @ kept.T
        values, vectors = np.linalg.eigh(away @ stiffness @ away)
        return vectors[:, values < -limit]


def solve_with_motions(
    matrix: Floats, offset: Floats, active: Bools, motions: Motions, *, soft: bool = True
) -> tuple[Floats, Floats, Floats] | None:
    """Solve a complementarity problem with free motions: p (n,), q (m,), and what is kept zero, see `Motions.held`.

    Springs that are far softer than the constraints hold the motions first, so that there always is a solution. The
    equations without springs follow from its active set; motions that it does not hold are zero. If there is none
    without springs, because forces act on a motion that nothing holds, that with springs is returned: it leads far
    along the motion, towards the next constraint. ``soft``: motions that the constraints hardly hold are kept zero too,
    if hardly any force acts on them: else the error of the meshes would decide how far they go.
    None where `solve` finds none.
    """
    softened, lifted, yielding = motions.softened(matrix, offset)
    pressure = solve((softened + softened.T) / 2.0, lifted, active)
    if pressure is None:
        return None
    sprung = pressure, yielding @ np.append(pressure, 1.0), np.zeros((2, len(motions.residual), 0))
    active = pressure > 0.0
    for _ in range(MAX_CHANGES):
        mine = matrix[np.ix_(active, active)], offset[active], motions.by_motion[active], motions.resultants[:, active]
        found = motions.held(*mine, motions.loads(sprung[0])) if soft else None
        found = found or motions.held(*mine, None)
        if found is None:
            return sprung
        forces, motion, zero = found
        pressure = np.zeros(len(offset))
        pressure[active] = forces
        slack = matrix @ pressure + motions.by_motion @ motion + offset
        gaps = np.abs(offset) + np.abs(motions.by_motion) @ np.abs(motion)
        touching = np.abs(pressure) <= NO_FORCE * float(gaps.max(initial=0.0)) / float(
            matrix.diagonal().max(initial=0.0)
        )
        closed = slack >= -NO_FORCE * gaps
        if (pressure[active & ~touching] > 0.0).all() and closed.all():
            pressure[touching] = 0.0
            return pressure, motion, zero
        active = np.where(active, (pressure > 0.0) | touching, ~closed)
    return sprung


def equations(matrix: Floats, right: Floats) -> Floats:
    """Solution of equations, the least one where constraints repeat each other.

    NumPy's solver and not SciPy's: each has its own threads, and where both wake in turn they wait for each other.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)


def _least_squares(matrix: Floats, offset: Floats) -> Floats | None:
    """With ``M = L L^T``, p minimises ``|L^T p + L^-1 q|`` over p >= 0."""
    from scipy.optimize import nnls  # noqa: PLC0415 (slow to import, seldom needed)

    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return None
    target = -np.linalg.solve(lower, offset)
    pressure: Floats = nnls(lower.T, target)[0]
    return pressure


def standoffs(forces: Floats, products: Floats, reaches: Floats) -> Floats:
    """Gaps at which forces (m,) act by a barrier ``p = w (1 / g - 1 / r)``; see `with_barrier`."""
    shifts = products / reaches
    loaded = products > 0.0
    return np.divide(products, forces + shifts, out=np.zeros(len(forces)), where=loaded)


def with_barrier(
    solved: Callable[[Floats, Floats, Floats], tuple[Floats, Floats, Floats] | None],
    matrix: Floats,
    offset: Floats,
    barriers: Floats,
    forces: Floats,
) -> tuple[Floats, Floats, Floats] | None:
    """Solve with a barrier, ``p = max(0, w / g - w / r)``, what another function solves without.

    About forces p0 the gap of the barrier, ``w / (p + w / r)``, is a gap ``g0`` with a compliance c,
    ``g0 - c (p - p0)``. It is convex in p: forces of one constraint that are too small grow to those of the law.

    Parameters
    ----------
    solved
        From a matrix, an offset and normal forces (m,) as the guess to forces, of which the first m are normal ones,
        motions, and what is kept zero; None where it finds none.
    matrix, offset
        Of normal and tangential forces, shape (k, k) and (k,), k >= m.
    barriers
        Products w and reaches r, shape (m, 2); 0 and infinite where there is none.
    forces
        Normal forces to begin with, shape (m,).

    """
    products, reaches = barriers.T
    m, found = len(products), None
    for _ in range(MAX_ROUNDS):
        gaps = standoffs(forces, products, reaches)
        compliances = np.divide(gaps**2, products, out=np.zeros(m), where=products > 0.0)
        softened, lifted = matrix.copy(), offset.copy()
        softened[np.arange(m), np.arange(m)] += compliances
        lifted[:m] -= gaps + compliances * forces
        found = solved(softened, lifted, forces)
        if found is None:
            return None
        before, forces = forces, np.maximum(found[0][:m], 0.0)
        if np.abs(forces - before).max() <= SETTLED * forces.max():
            break
    return found
