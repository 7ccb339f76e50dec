"""Forces that satisfy the laws of contact and friction where gaps and slips depend on them linearly.

With normal forces p, gaps s, tangential forces q and slips w of m constraints, and rigid motions r of n handles,

    (s, w) = M (p, q) + N r + b,   L (p, q) + H r + e = 0.

The laws are ``0 <= p, 0 <= s - h(p), p (s - h(p)) = 0``, where h is the gap that a barrier leaves, and Coulomb's
``|q| <= mu p`` with ``w = 0`` inside of the cone and w against q on it. For any ``c > 0`` they are the equations
``p = max(0, p - c (s - h(p)))`` and ``q = P(q - c w)`` with the projection P on ``[-mu p, mu p]`` (P. Alart and A.
Curnier, 1991, Comput. Methods Appl. Mech. Eng. 92). The semismooth Newton method solves linear equations for a guess of
what is open, sticks and slips, and takes the next guess from these equations (S. Hueeber, G. Stadler and B. I.
Wohlmuth, 2008, SIAM J. Sci. Comput. 30); without friction this is the primal-dual active set (M. Hintermueller, K. Ito
and K. Kunisch, 2002, SIAM J. Optim. 13). Each c is the stiffness of the bodies against the constraint's own force.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from flangeway.geometry.arrays import max_magnitude, quotients
from flangeway.space.symmetric import EPS
from flangeway.types import Bools, Floats, Ints

MIN_ROUNDS = 60
"""Linear equations of Newton's method after which it goes on only while each is better: the ends of a zone that sticks
come nearer by a node a round."""
ROUND_OFF = 1e-12
"""Error of the laws' equations, relative to the maximum force, that is round-off."""
BARRIER_CHANGE = 1e-8
"""Relative change of a force by a barrier from one linearisation to the next, whose square is round-off."""
LIMIT_MARGIN = 1e-9
"""Fraction of the limit by which a tangential force is below it where surfaces stick."""
MIN_STIFFNESS = 1e-10
"""Stiffness against a motion relative to the maximum one, below which nothing holds it."""
NEUTRAL_STIFFNESS = 1.0
"""Stiffness against a motion relative to the forces on a part by its size, below which the motion is neutral: what
holds it is the curvature of surfaces under load, or the error of the meshes, not the materials."""
NEUTRAL_FORCE = 1e-3
"""Force along a neutral motion relative to the forces on the part, below which the motion is kept zero."""
MIN_SPRING = 1e-4
"""Stiffness of the softest springs relative to those that are chosen first: more digits are lost below."""
MIN_COMPONENT = 0.03
"""Component of a neutral motion below which it is none of it: other motions are in equilibrium exactly."""

MAX_MOTION = 1e3
"""Motion relative to the size of the parts above which only round-off of a stiffness holds it."""

UNHELD_FORCE = 1e-5
"""Force that springs against the motions of a step hold, or that equations leave, relative to the forces along the
motions, above which nothing else holds it."""

MAX_PIECES = 400
"""Pieces of a path of solutions that is followed: two or three for each constraint that closes."""
GOLDEN_SECTION = 0.6180339887
"""Fraction of one whose multiples, less whole numbers, are all different."""
SIGNS = np.array([[1], [-1]])
"""Of forces at the limit of friction, in the order of the margins."""


class Answer(NamedTuple):
    """Forces p, then q, and gaps, then slips, each (m,) or (2 m,), and motions (n,)."""

    forces: Floats
    slacks: Floats
    motions: Floats


class Guess(NamedTuple):
    """Which constraints are closed, the sign of those at the limit of friction (0: they stick), and normal forces.

    A barrier is linearised about the normal forces; infinite ones leave it out. Each (m,).
    """

    active: Bools
    signs: Ints
    normal: Floats

    def same_as(self, other: "Guess", laws: "Laws") -> bool:
        """Whether another guess has the same equations, but for changes of a barrier whose square is round-off."""
        same = np.array_equal(self.active, other.active) and np.array_equal(self.signs, other.signs)
        if not (same and laws.barred):
            return same
        return bool((np.abs(self.normal - other.normal) <= BARRIER_CHANGE * self.normal)[self.active].all())

    def rows(self, coefficients: Floats) -> tuple[Ints, Floats]:
        """Unknown ones of (p, q): all that are closed, then those that stick; and q over p of what slips, (m,)."""
        sticking = len(self.active) + np.flatnonzero(self.active & (self.signs == 0))
        rows = np.concatenate((np.flatnonzero(self.active), sticking))
        return rows, np.where(self.active, coefficients * self.signs, 0.0)


@dataclass(frozen=True, eq=False)
class Motions:
    """Rigid motions r and their equations ``L y + H r + e = 0`` with forces y; gaps and slips have ``N r`` added.

    Parameters
    ----------
    by_motion
        N, shape (k, n).
    resultants
        L, shape (n, k): ``N^T`` without friction.
    stiffness
        H, symmetric without friction, shape (n, n).
    residual
        e, shape (n,).
    parts, sizes
        Number and size of the part that each unknown moves, shape (n,).

    """

    by_motion: Floats
    resultants: Floats
    stiffness: Floats
    residual: Floats
    parts: Ints
    sizes: Floats

    def loads(self, forces: Floats) -> Floats:
        """Maximum over the motions of its part of the sum of forces (k,) along each, shape (n,)."""
        along = np.abs(self.resultants) @ np.abs(forces) + np.abs(self.residual)
        maximum = np.zeros(int(self.parts.max(initial=0)) + 1)
        np.maximum.at(maximum, self.parts, along)
        return maximum[self.parts]

    def sprung(self, diagonal: Floats, stiffness: float) -> "Motions":
        """With springs against the motions of a step, so that equations that no constraint holds have a solution.

        In the solution the motions of a step are zero, and the springs have no force (K. Levenberg, 1944, Q. Appl.
        Math. 2). ``diagonal`` are compliances (k,) of the constraints, and ``stiffness`` is a fraction of the maximum
        stiffness of one.
        """
        yields = diagonal > ROUND_OFF * max_magnitude(diagonal)
        compliance = np.sum(self.by_motion[yields] ** 2, axis=1) / diagonal[yields]
        symmetric = (self.stiffness + self.stiffness.T) / 2.0
        unstable = max(float(np.linalg.eigvalsh(symmetric).max(initial=0.0)), 0.0)
        spring = stiffness * (float(compliance.max(initial=0.0)) or 1.0) + 2.0 * unstable
        return replace(self, stiffness=self.stiffness - spring * np.eye(len(self.residual)))

    def softly_sprung(self, sprung: "Motions", forces: Floats, softness: float, ways: float) -> "Motions":
        """With the springs of another one, but as soft as lets the forces on a part move it by ``ways`` of its size.

        At least `MIN_SPRING` of those springs stay. That is at softness 1; at 0 they stay as they are, and between both
        their stiffness has the power ``softness``.
        """
        stiff = np.diagonal(self.stiffness - sprung.stiffness)
        soft = np.clip(self.loads(forces) / (ways * self.sizes * stiff), MIN_SPRING, 1.0) ** softness
        return replace(self, stiffness=self.stiffness - np.diag(soft * stiff))

    def compliances(self) -> Floats:
        """Displacement that the motions add to that by each constraint's own force, shape (k,)."""
        return np.einsum("kn,nk->k", self.by_motion, np.linalg.solve(-self.stiffness, self.resultants))

    def unbalanced(self, answer: Answer, neutral: Floats) -> Floats:
        """Direction of what springs hold of an answer beside neutral motions (n, r); zero if that is little: (n,)."""
        left = self.resultants @ answer.forces + self.stiffness @ answer.motions + self.residual
        left -= neutral @ (neutral.T @ left)
        beyond = np.abs(left) > UNHELD_FORCE * self.loads(answer.forces)
        return left / np.linalg.norm(left) if beyond.any() else np.zeros_like(left)

    def without(self, left: Floats, right: Floats) -> "Motions":
        """Only motions and equations in the spans of orthonormal columns (n, n_kept) each."""
        return replace(
            self,
            by_motion=self.by_motion @ right,
            resultants=left.T @ self.resultants,
            stiffness=left.T @ self.stiffness @ right,
            residual=left.T @ self.residual,
        )

    def unstable(self, matrix: Floats, active: Bools, neutral: Floats) -> Floats:
        """Motions out of an unstable equilibrium, apart from neutral ones (n, r): shape (n, n_unstable)."""
        rows = self.by_motion[active]
        stiffness = rows.T @ equations(matrix[np.ix_(active, active)], rows) - self.stiffness
        limit = MIN_STIFFNESS * max_magnitude(stiffness)
        away = np.eye(len(stiffness)) - neutral @ neutral.T
        values, vectors = np.linalg.eigh(away @ stiffness @ away)
        return vectors[:, values < -limit]


class Laws:
    """The laws of m constraints.

    Parameters
    ----------
    coefficients
        Coefficients of friction, shape (m,).
    barriers
        Products w of force and gap, and reaches r, shape (m, 2): a force p leaves the gap ``h = w / (p + w / r)``. Zero
        and infinite where there is no barrier.
    compliances
        Of the bodies and the laws against each constraint's own force, p then q, shape (k,); k = m without friction.

    """

    def __init__(self, coefficients: Floats, barriers: Floats, compliances: Floats) -> None:
        sizes, most = np.abs(compliances), max_magnitude(compliances)
        # negative ones are of bodies that pressure makes unstable where surfaces are apart
        self.stiffness = np.where(sizes > 0.0, quotients(1.0, sizes), 1.0 / (most or 1.0))
        self.m, self.barriers = len(coefficients), barriers
        self.friction = len(sizes) > self.m
        movable = sizes[self.m :] > ROUND_OFF * most if self.friction else np.zeros(self.m, dtype=np.bool_)
        self.coefficients = np.where(movable, coefficients, 0.0)
        self.barred = bool((barriers[:, 0] > 0.0).any())

    def projected(self, answer: Answer) -> Floats:
        """What the laws' equations make of forces: the same if they are satisfied."""
        trial = self._trial(answer)
        normal = np.maximum(trial[: self.m], 0.0)
        if not self.friction:
            return normal
        limits = self.coefficients * normal
        return np.concatenate((normal, np.clip(trial[self.m :], -limits, limits)))

    def guess(self, answer: Answer) -> Guess:
        """What is closed, and the sign of the tangential force where it is at its limit, by the laws' equations."""
        trial = self._trial(answer)
        normal = np.maximum(answer.forces[: self.m], 0.0)
        signs = np.ones(self.m, dtype=np.int64)
        if self.friction:
            limits = self.coefficients * np.maximum(trial[: self.m], 0.0)
            at_limit = np.abs(trial[self.m :]) > (1.0 - LIMIT_MARGIN) * limits
            signs = np.where(at_limit, np.sign(trial[self.m :]), 0.0).astype(np.int64)
            signs[self.coefficients == 0.0] = 1
        return Guess(trial[: self.m] > 0.0, signs, normal)

    def margins(self, guess: Guess, answer: Answer) -> Floats:
        """What is left until the laws of a guess end, negative beyond: shape (3, m).

        Normal forces or gaps; then what a force of either sign has to its limit, or a slip to rest.
        """
        both = (np.resize(values, (2, self.m)) for values in (answer.forces, answer.slacks))
        (normal, tangential), (gaps, slips) = both  # what stands for tangential ones without friction does not count
        to_limits, to_rest = self.coefficients * normal - SIGNS * tangential, -SIGNS * slips
        of_friction = np.where(guess.signs == 0, to_limits, np.where(guess.signs == SIGNS, to_rest, 1.0))
        rubs = guess.active & (self.coefficients > 0.0)
        return np.vstack((np.where(guess.active, normal, gaps), np.where(rubs, of_friction, 1.0)))

    def linearised_barriers(self, normal: Floats) -> tuple[Floats, Floats]:
        """Compliance c and gap ``h - c p`` of the barriers about normal forces, each (m,)."""
        gaps = standoffs(normal, self.barriers)
        finite = np.where(np.isfinite(normal), normal, 0.0)
        products = self.barriers[:, 0]
        compliances = quotients(gaps**2, products)
        return compliances, gaps + compliances * finite

    def _trial(self, answer: Answer) -> Floats:
        slacks = answer.slacks
        if self.barred:
            slacks = slacks.copy()
            slacks[: self.m] -= standoffs(np.maximum(answer.forces[: self.m], 0.0), self.barriers)
        return answer.forces - self.stiffness * slacks


def standoffs(normal: Floats, barriers: Floats) -> Floats:
    """Gaps that forces (m,) leave by barriers (m, 2), ``p = w (1 / g - 1 / r)``."""
    products, reaches = barriers.T
    return quotients(products, normal + products / reaches)


def solve(laws: Laws, solved: Callable[[Guess], Answer | None], forces: Floats) -> Answer | None:
    """Solve by the semismooth Newton method; None if it does not converge.

    A loop of its own: the state is a set of constraints, and the iteration ends where the set repeats, not where a
    residual is small.

    Parameters
    ----------
    laws
        The laws.
    solved
        The linear equations of a guess; None where they have no solution.
    forces
        First guess of the forces, shape (k,): a push that all nodes follow makes none of them slip at once, so what
        stuck sticks first.

    """
    guess = laws.guess(Answer(forces, np.zeros(len(forces)), np.zeros(0)))
    errors: list[float] = []
    while len(errors) <= MIN_ROUNDS or errors[-1] < errors[-2]:
        answer = solved(guess)
        if answer is None:
            return None
        following, projected = laws.guess(answer), laws.projected(answer)
        errors.append(max_magnitude(projected - answer.forces))
        if following.same_as(guess, laws):
            return answer
        if errors[-1] <= ROUND_OFF * max_magnitude(answer.forces) and not laws.barred:
            return answer._replace(forces=projected)
        guess = following
    return None


class DenseEquations:
    """Equations of a guess with a matrix of all constraints.

    Parameters
    ----------
    matrix, offset
        M, shape (k, k), and b, shape (k,).
    laws
        The laws.
    motions
        The motions.

    """

    def __init__(self, matrix: Floats, offset: Floats, laws: Laws, motions: Motions) -> None:
        self.matrix, self.offset, self.laws, self.motions = matrix, offset, laws, motions

    def __call__(self, guess: Guess) -> Answer | None:
        """Forces, gaps, slips and motions of a guess; None if what it closes cannot carry the loads."""
        n, m, forces = len(self.motions.residual), self.laws.m, np.zeros(len(self.offset))
        rows, ratios, by_unit, resultants = self._responses(guess)
        motions = np.zeros(n)
        if n:
            # S r = e - L A^-1 b with the stiffness against motions S = L A^-1 N - H
            stiffness = resultants @ by_unit[:, :n] - self.motions.stiffness
            loads = self.motions.residual - resultants @ by_unit[:, n]
            motions = equations(stiffness, loads)
            unheld = np.abs(stiffness @ motions - loads).max() > UNHELD_FORCE * np.abs(loads).max()
            if unheld or np.abs(motions).max() > MAX_MOTION * self.motions.sizes.max():
                return None
        forces[rows] = -by_unit @ np.append(motions, 1.0)
        if self.laws.friction:
            forces[m:] += ratios * forces[:m]
        return Answer(forces, self.matrix @ forces + self.motions.by_motion @ motions + self.offset, motions)

    def answer(self, forces: Floats) -> Answer | None:
        """Solve by the semismooth Newton method from forces (k,), or along a path, without motions."""
        answer = solve(self.laws, self, forces)
        return answer if answer or self.laws.barred else self._along_path()

    def _along_path(self) -> Answer | None:
        """Solve by following solutions from where all constraints are open; None if the path does not arrive.

        Gaps are larger by ``(1 - t) d``, which opens all of them at t = 0. With one guess forces and gaps are linear in
        t, up to where the law of one constraint ends. It goes over to its next law, and t to where this one holds,
        which may be backwards (C. E. Lemke, 1965, Manag. Sci. 11; A. Klarbring, 1986, Ing.-Arch. 56). Newton's method
        may go round between guesses where friction holds a part that its supports hardly hold, or where nodes have left
        their partners.
        """
        laws, m = self.laws, self.laws.m
        # all different, so that one closes at a time
        lifts = max_magnitude(self.offset[:m]) * (2.0 + GOLDEN_SECTION * np.arange(m) % 1.0)
        start = DenseEquations(self.matrix, self.offset + np.pad(lifts, (0, len(self.offset) - m)), laws, self.motions)
        guess = Guess(*np.zeros((3, m), dtype=np.int64))
        time, direction, changed = 0.0, 1.0, None
        for _ in range(MAX_PIECES):
            first, last = start(guess), self(guess)
            assert first is not None
            assert last is not None
            margins = laws.margins(guess, first)
            falls = margins - laws.margins(guess, last)
            if changed:
                direction = -float(np.sign(falls[changed]))
            ahead = quotients(margins, direction * falls) - direction * time
            ahead = np.where(direction * falls > 0.0, np.maximum(ahead, 0.0), np.inf)
            changed = law, one = divmod(int(ahead.argmin()), m)
            time += direction * ahead[changed]
            if not 0.0 <= time < 1.0:
                return last if time > 0.0 else None
            if law:
                guess.signs[one] = 0 if guess.signs[one] else SIGNS[law - 1, 0]
            else:
                slips = (1.0 - time) * first.slacks + time * last.slacks
                guess.active[one] = not guess.active[one]
                guess.signs[one] = np.copysign(1.0, -np.resize(slips, 2 * m)[m + one])
        return None

    def free_motions(self, answer: Answer) -> tuple[Floats, Floats, bool]:
        """Motions that the constraints under the forces of an answer hold by hardly any stiffness.

        The stiffness against motions in the units of forces over sizes has singular values that tell what holds a
        motion: the materials, hardly anything, or nothing. Motions of the last two kinds with hardly any force along
        them are neutral.

        Returns
        -------
        tuple
            Neutral motions as directions of the equations and of the motions, (n, r) each; and whether nothing holds
            others, against the forces along them.

        """
        motions, n = self.motions, len(self.motions.residual)
        guess = self.laws.guess(answer)
        # what friction resists is not free where it slips: it stays in place, or no friction holds it
        sticking = guess._replace(signs=np.where(self.laws.coefficients > 0.0, 0, guess.signs))
        _, _, by_unit, resultants = self._responses(sticking)
        loads = motions.loads(answer.forces)
        stiffness = resultants @ by_unit[:, :n] - motions.stiffness
        # forces that would move what holds them by less than the last digit of the sizes are none
        least = EPS * max_magnitude(stiffness) * motions.sizes.max()
        root = np.sqrt(np.maximum(loads, 1e-12 * (max(float(loads.max()), least) or 1.0)) / motions.sizes)
        left, values, right = np.linalg.svd(stiffness / root / root[:, None])
        along = left.T @ ((motions.residual - resultants @ by_unit[:, n]) / root)
        limits = NEUTRAL_FORCE * np.linalg.norm(left * (loads / root)[:, None], axis=0)
        neutral = (values < NEUTRAL_STIFFNESS) & (np.abs(along) <= limits)
        loose = (values <= MIN_STIFFNESS * values[0]) & ~neutral
        for directions in (left, right.T):
            directions[np.abs(directions) < MIN_COMPONENT] = 0.0
        return left[:, neutral] * root[:, None], right[neutral].T / root[:, None], bool(loose.any())

    def _responses(self, guess: Guess) -> tuple[Ints, Floats, Floats, Floats]:
        """Unknown forces, q over p of what slips, ``A^-1 (N, b)`` and L of the unknown forces."""
        laws, m = self.laws, self.laws.m
        rows, ratios = guess.rows(laws.coefficients)
        normal = rows[: int(guess.active.sum())]
        # A = M[rows, rows] + M[rows, m + normal] ratio: what slips has the tangential force ratio * p
        system, right = self.matrix[np.ix_(rows, rows)], self.offset[rows]
        resultants = self.motions.resultants[:, rows]
        if laws.friction:
            system[:, : len(normal)] += self.matrix[np.ix_(rows, m + normal)] * ratios[normal]
            resultants[:, : len(normal)] += self.motions.resultants[:, m + normal] * ratios[normal]
        if laws.barred:
            compliances, gaps = laws.linearised_barriers(guess.normal)
            at = np.arange(len(normal))
            system[at, at] += compliances[normal]
            right[at] -= gaps[normal]
        return rows, ratios, equations(system, np.column_stack((self.motions.by_motion[rows], right))), resultants


SolvedRows = Callable[[Ints, sp.csr_array], tuple[Floats, Floats]]
"""See `BodyResponse.constrained`."""


def sparse_equations(solved_rows: SolvedRows, laws: Laws) -> Callable[[Guess], Answer]:
    """Equations of a guess without the matrix M, by a function from `BodyResponse.constrained`; no handle moves."""

    def solved(guess: Guess) -> Answer:
        rows, ratios = guess.rows(laws.coefficients)
        columns, n_normal = np.arange(len(rows)), int(guess.active.sum())
        at = np.concatenate((rows, laws.m + rows[:n_normal])), np.concatenate((columns, columns[:n_normal]))
        values = np.concatenate((np.ones(len(rows)), ratios[guess.active]))
        return Answer(*solved_rows(rows, sp.csr_array((values, at), shape=(2 * laws.m, len(rows)))), np.zeros(0))

    return solved


def equations(matrix: Floats, right: Floats) -> Floats:
    """Solution of equations, the least one where constraints repeat each other.

    NumPy's solver and not SciPy's: each has its own threads, and where both wake in turn they wait for each other.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)


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
    works
        Work that the slip of each dissipated in this step, >= 0, shape (m,).

    """

    forces: Floats
    slips: Floats
    elastic: Floats
    sticks: Bools
    works: Floats

    @property
    def work(self) -> float:
        """Work that the slips dissipated in this step, >= 0."""
        return float(self.works.sum())


def friction_state(
    normal: Floats, tangential: Floats, slips: Floats, let_back: Floats, coefficients: Floats, previous: Floats
) -> CoulombState:
    """State of constraints by forces, and by slips since the last step with its elastic ones, each (m,).

    ``let_back`` (m,) is what the law of contact adds to the slips: compliance times tangential force. The limit of
    friction goes from that of the ``previous`` normal forces (m,) to that of the present ones while a constraint slips,
    so that the work is of second order in the step.
    """
    closed = normal > 0.0
    sticks = closed & (np.abs(tangential) < (1.0 - LIMIT_MARGIN) * coefficients * normal)
    slipped = np.where(closed & ~sticks & (coefficients > 0.0), slips + let_back, 0.0)
    # a slip that is round-off may have the sign of the force
    slipped = np.where(slipped * tangential > 0.0, 0.0, slipped)
    elastic = np.where(closed, slips - slipped, 0.0)
    works = coefficients * (normal + previous) / 2.0 * np.abs(slipped)
    return CoulombState(tangential, slipped, elastic, sticks, works)


def violations(normal: Floats, tangential: Floats, slips: Floats, coefficients: Floats) -> tuple[Floats, Floats]:
    """Forces beyond the limit of friction, and slips where surfaces stick or go along with the force, each (m,)."""
    limits = coefficients * np.maximum(normal, 0.0)
    beyond = np.maximum(np.abs(tangential) - limits, 0.0)
    loaded = limits > 0.0
    inside = loaded & (np.abs(tangential) < (1.0 - LIMIT_MARGIN) * limits)
    return beyond, np.where(inside, np.abs(slips), np.where(loaded, np.maximum(slips * np.sign(tangential), 0.0), 0.0))
