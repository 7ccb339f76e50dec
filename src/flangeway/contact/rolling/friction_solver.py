"""Tangential forces within Coulomb's limit, constant or falling, for a given rigid slip."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.patch.normal_contact import Convolution
from flangeway.contact.rolling.friction import Friction
from flangeway.solve import Status
from flangeway.types import Bools, Floats

# --- Limits of friction that fall with the slip velocity and with the flash temperature, and their derivatives.
#
# The limit of a cell under the normal force N, with tangential force f, slip S and the trial force ``t = f - r S`` of
# the law of friction, falls with the slip ``(|t| - m) / r``, see `Friction.fallen`; so it depends on the trial force
# alone. Its temperature is that of the heat of all cells ahead in the row,
#
#     T_i = T_0 + sum over j of H_ij c (n_j . f_j) (-n_j . S_j) / A_j
#
# where c is velocity over slip, n the direction of t, and A areas.


@dataclass(frozen=True, eq=False)
class LimitSlopes:
    """Derivatives of limits at a state.

    - `directions`: of the trial forces, (n_cells, 2, n_strips); `scale`: r, (n_cells, 1, n_strips).
    - `by_trial`, `by_rise`: of the limits by the trial force and by the temperature, (n_cells, n_strips).
    - `heat_by_force`, `heat_by_slip`: of the heat of the cells by force and slip, (n_cells, n_strips).
    - `warming`: temperatures by heat of cells ahead, (n_strips, n_strips), or None.
    """

    directions: Floats
    scale: Floats
    by_trial: Floats
    by_rise: Floats
    heat_by_force: Floats
    heat_by_slip: Floats
    warming: Floats | None

    def change(self, forces: Floats, slips: Floats) -> Floats:
        """Change of the limits (..., n_cells, n_strips) by changes of forces and slip, (..., n_cells, 2, n_strips)."""
        change = self.by_trial * np.sum(self.directions * (forces - self.scale * slips), axis=-2)
        if self.warming is not None:
            heat = self.heat_by_force * np.sum(self.directions * forces, axis=-2)
            heat = heat - self.heat_by_slip * np.sum(self.directions * slips, axis=-2)
            change = change + self.by_rise * (heat @ self.warming.T)
        return change

    def transposed(self, values: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the sum of limits times values (..., n_cells, n_strips) by forces and slip."""
        by_force = (self.by_trial * values)[..., None, :]
        by_slip = -self.scale * by_force
        if self.warming is not None:
            heat = (self.by_rise * values) @ self.warming
            by_force = by_force + (self.heat_by_force * heat)[..., None, :]
            by_slip = by_slip - (self.heat_by_slip * heat)[..., None, :]
        return self.directions * by_force, self.directions * by_slip


@dataclass(frozen=True, eq=False)
class FallingLimits:
    """Limits of the cells that a state needs.

    - `friction`: of the rows of cells, (n_cells,) or one number.
    - `normal`: normal forces of the cells, (n_cells, n_strips).
    - `areas`: of the cells, (n_cells, 1).
    - `velocity`: slip velocity over slip.
    - `warming`: temperatures by the heat of cells ahead, K over power density, (n_strips, n_strips), or None.
    """

    friction: Friction
    normal: Floats
    areas: Floats
    velocity: float
    warming: Floats | None

    @property
    def steepest(self) -> Floats:
        """Twice the fall of the limits with slip at rest, (n_cells, 1, n_strips): with r above it they are smooth."""
        static, kinetic = self._limits
        rate = self.velocity / self.friction.decay if self.friction.decay > 0.0 else 0.0
        return 2.0 * rate * (static - kinetic)[:, None]

    def under(self, forces: Floats, slips: Floats) -> Floats:
        """Limits (n_cells, n_strips) at the velocities and temperatures of forces and slip (n_cells, 2, n_strips)."""
        force, slip = np.linalg.norm(forces, axis=1), np.linalg.norm(slips, axis=1)
        rise = self._rise(self.velocity / self.areas * force * slip)
        static, kinetic = self._limits
        return kinetic + (static - kinetic) * self.friction.share(self.velocity * slip, rise)

    @cached_property
    def _limits(self) -> tuple[Floats, Floats]:
        """At rest and at high slip velocities, (n_cells, n_strips) each."""
        static, kinetic = (np.asarray(limit[:, None] * self.normal) for limit in self.friction.limits)
        return static, kinetic

    def _rise(self, heat: Floats) -> Floats | float:
        return 0.0 if self.warming is None else heat @ self.warming.T

    def at(self, scale: Floats, trial: Floats, forces: Floats, slips: Floats) -> tuple[Floats, LimitSlopes]:
        """Limits (n_cells, n_strips) of a state, and their derivatives.

        - `scale`: r, (n_cells, 1, n_strips).
        - `trial`, `forces`, `slips`: (n_cells, 2, n_strips).
        """
        length = np.linalg.norm(trial, axis=1)
        n = trial / np.maximum(length, np.finfo(float).tiny)[:, None]
        force, slip = np.sum(n * forces, axis=1).clip(min=0.0), -np.sum(n * slips, axis=1).clip(max=0.0)
        rate = self.velocity / self.areas
        rise = self._rise(rate * force * slip)
        limits, by_trial, by_rise = self.friction.fallen(*self._limits, length, self.velocity / scale[:, 0], rise)
        return limits, LimitSlopes(n, scale, by_trial, by_rise, rate * slip, rate * force, self.warming)


# --- Tangential forces within Coulomb's limit for a given rigid slip: a semismooth Newton method with Krylov and FFT.
#
# With tangential forces f of the cells, slip ``S = g + B f`` and limits ``m = mu p``, friction demands ``f = P(f - r
# S)`` for any r > 0, where P projects on the disc of radius m of each cell: where ``|f| < m`` there is no slip,
# elsewhere f is opposite to it (Kalker, 1990, "Three-dimensional elastic bodies in rolling contact", 4). B is monotone,
# so there is one solution. Newton's method for this equation solves ``S = 0`` on the cells that stick and the
# tangential part of the law on the others. Limits that fall with the slip velocity, or with the temperature that
# friction causes, are functions of f and S in the same equation (`FallingLimits`), with their derivatives.


Linear = Callable[[Floats], Floats]

MAX_STEPS = 60
FORCING = (1e-2, 0.1)
"""Residual of the linear equations relative to that before, least and most: Newton's method is far from its end at
first (Eisenstat and Walker, 1996, SIAM Journal on Scientific Computing 17, choice 2 with 0.9 and 2)."""
USUAL_BLOCKS, MAX_BLOCKS, DEPENDENT = 20, 120, 1e-10
"""Blocks of Krylov vectors that there is room for at first, and at most, and eigenvalue of their Gram matrix below
which they depend on each other."""
DECREASE, MIN_STEP = 0.1, 1.0 / 32.0
"""Part of a step by which the residual must fall, and the smallest part that is tried."""
ROUND_OFF = 1e-12
"""Residual relative to the limits that is none."""
MIN_PART = 0.02
"""Smallest part of the rigid slip by which it grows where Newton's method does not converge at once."""
HELD_LIMITS_ERROR = 1e-4
"""Error of the law of friction under limits that are held, from which Newton's method starts."""


class SlipOperator:
    """Slip of cells by tangential forces: ``sum_k w_k u(z + k dz)`` with their displacements u.

    Parameters
    ----------
    coefficients
        Displacements along t and z by forces, at the distances 0, dz, ..., shape (n_strips + n_weights - 1 or more,
        2 n_cells, 2 n_cells).
    weights
        ``(1,)`` for a shift, ``(1, -1)`` or ``(1.5, -2, 0.5)`` for steady rolling to +z.
    n_strips
        Number of strips.

    """

    def __init__(self, coefficients: Floats, weights: tuple[float, ...], n_strips: int) -> None:
        shape = n_strips, n_strips + len(weights) - 1
        self._moved = tangential_convolution(coefficients[: shape[1]])
        self._inside = np.eye(*shape)
        self._difference = np.sum([w * np.eye(*shape, k) for k, w in enumerate(weights)], axis=0)
        # S = D C f, with displacements on the strips and on those ahead of them; C is symmetric
        self._slip = self._moved.between(self._inside, self._difference.T)
        self._transposed = self._moved.between(self._difference, self._inside.T)
        diagonal = np.sum([w * np.diagonal(coefficients[k]) for k, w in enumerate(weights)], axis=0)
        self.scale: Floats = 1.0 / diagonal.reshape(-1, 2).mean(axis=1)[:, None, None]
        """Force over slip of each cell by itself."""

    def __call__(self, forces: Floats) -> Floats:
        """Slip (..., n_cells, 2, n_strips) by forces."""
        return self._on_cells(self._slip, forces)

    def transposed(self, values: Floats) -> Floats:
        """The transposed operator on values (..., n_cells, 2, n_strips)."""
        return self._on_cells(self._transposed, values)

    def preconditioned(self, slips: Floats, *, transposed: bool = False) -> Floats:
        """Forces that nearly give slips, or the same of the transpose: C^-1 without ends, then D^-1 on the strips."""
        return self._on_cells(self._inverses[transposed], slips)

    @cached_property
    def _inverses(self) -> tuple[Convolution, Convolution]:
        summation, inverse = np.linalg.inv(self._difference[:, : len(self._difference)]), self._moved.inverted()
        return (
            inverse.between(self._inside, self._inside.T @ summation.T),
            inverse.between(self._inside, self._inside.T @ summation),
        )

    def _on_cells(self, convolution: Convolution, values: Floats) -> Floats:
        return convolution(values.reshape(*values.shape[:-3], -1, values.shape[-1])).reshape(values.shape)


@dataclass(frozen=True, eq=False)
class FrictionState:
    """Forces with what follows from them.

    Parameters
    ----------
    forces, slips
        Tangential forces on the second body and its slip, shape (n_cells, 2, n_strips).
    limits
        Limits of the forces, (n_cells, n_strips), and how they change with forces and slip where they do.
    share
        Limit over length of ``f - r S`` where it is beyond the limit, otherwise 1, shape (n_cells, 1, n_strips).
    direction
        Direction of the same.
    sticks
        Where it is within the limit, and there is pressure.
    residual
        ``f - P(f - r S)``.

    """

    forces: Floats
    slips: Floats
    limits: Floats
    slopes: LimitSlopes | None
    share: Floats
    direction: Floats
    sticks: Bools
    residual: Floats

    @cached_property
    def norm(self) -> float:
        """Norm of the residual."""
        return float(np.linalg.norm(self.residual))


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """Rigid slip (n_cells, 2, n_strips) and limits (n_cells, n_strips) of the forces for an operator.

    - `falling`: how limits fall below these, if they do.
    """

    operator: SlipOperator
    rigid: Floats
    limits: Floats
    falling: FallingLimits | None = None

    @cached_property
    def loaded(self) -> Bools:
        """Cells with a limit above 0, shape (n_cells, 1, n_strips)."""
        return self.limits[:, None] > 0.0

    @cached_property
    def scale(self) -> Floats:
        """The factor r of the law of friction, (n_cells, 1, 1 or n_strips)."""
        scale = self.operator.scale
        if self.falling is None:
            return scale
        return np.maximum(scale, self.falling.steepest) + np.zeros((1, 1, self.rigid.shape[2]))

    def state(self, forces: Floats) -> FrictionState:
        """Slip and residual of forces."""
        slips = self.rigid + self.operator(forces)
        trial = forces - self.scale * slips
        falling, slopes = self.falling, None
        all_limits = self.limits
        if falling is not None:
            all_limits, slopes = falling.at(self.scale, trial, forces, slips)
        length = np.maximum(np.linalg.norm(trial, axis=1, keepdims=True), np.finfo(float).tiny)
        limits = all_limits[:, None]
        share = limits / np.maximum(length, limits)
        within = self.loaded & (length <= limits)
        return FrictionState(forces, slips, all_limits, slopes, share, trial / length, within, forces - share * trial)

    def solve(self, start: Floats | None, tolerance: float) -> tuple[FrictionState, Status]:
        """Find the forces.

        Parameters
        ----------
        start
            Forces to start from; without them none.
        tolerance
            Norm of the residual over that without forces at which the iteration ends: in slip that is of the limits,
            at small creepages of what single cells would carry.

        """
        if self.falling is not None:
            return self._fallen(self.falling, start, tolerance)
        none = np.zeros(self.rigid.shape)
        state, status = self._newton(none if start is None else start, tolerance)
        # otherwise the slip grows from none, in parts as small as needed
        done, part, forces = 0.0, 0.5, none
        while not status.converged and part >= MIN_PART:
            trial, trial_status = replace(self, rigid=min(done + part, 1.0) * self.rigid)._newton(forces, tolerance)
            if not trial_status.converged:
                part /= 4.0
                continue
            done, part, forces = done + part, 2.0 * part, trial.forces
            if done >= 1.0:
                return trial, trial_status
        return state, status

    def _fallen(self, falling: FallingLimits, start: Floats | None, tolerance: float) -> tuple[FrictionState, Status]:
        """Forces under limits that fall: Newton's method from neighbouring ones, or from those under held limits.

        Where it does not converge, as where a patch slips away at once, limits are lowered to those of the slip, and
        never raised: this ends.
        """
        limits, forces, jumps = self.limits, start, falling.friction.jumps
        enough = max(tolerance, HELD_LIMITS_ERROR)
        if start is not None and not jumps:
            state, status = self._newton(start, tolerance)
            if status.converged:
                return state, status
        while True:
            held = replace(self, falling=None, limits=limits).solve(forces, tolerance if jumps else enough)
            solution = held if jumps else self._newton(held[0].forces, tolerance)
            lower = np.minimum(limits, falling.under(held[0].forces, held[0].slips * ~held[0].sticks))
            if (solution[1].converged and not jumps) or (lower >= (1.0 - ROUND_OFF) * limits).all():
                return solution
            limits, forces = lower, held[0].forces

    def _newton(self, start: Floats, tolerance: float) -> tuple[FrictionState, Status]:
        """Newton's method with step halving.

        A loop of its own: each linear system is solved only as far as the residual before it has fallen, and where no
        step lowers the residual the state of the lowest one is the last.
        """
        none = self.state(np.zeros(self.rigid.shape))
        whole = max(none.norm, ROUND_OFF * float(np.linalg.norm(self.limits)), np.finfo(float).tiny)
        state = self.state(self._within(start))
        step, part, forcing = 0, 1.0, FORCING[1]
        while state.norm > tolerance * whole and step < MAX_STEPS and part > 0.0:
            step += 1
            change = self.solved(state, state.residual[None], forcing)[0]
            part, best, before = 1.0, state, state.norm
            while part >= MIN_STEP:
                trial = self.state(state.forces - part * change)
                best = min(best, trial, key=lambda iterate: iterate.norm)
                if trial.norm <= (1.0 - DECREASE * part) * state.norm:
                    break
                part /= 2.0
            part = 0.0 if best is state else part
            state = best
            enough = tolerance * whole / (2.0 * max(state.norm, np.finfo(float).tiny))
            forcing = float(np.clip(max(0.9 * (state.norm / before) ** 2, enough), *FORCING))
        error = state.norm / whole
        last = self.state(state.forces - state.residual)  # within the limits exactly
        advice = "" if error <= tolerance else "; start from a neighbouring result, or take larger cells"
        message = f"forces satisfy the law of friction to {error:.1e} after {step} steps{advice}"
        return last, Status(error <= tolerance, message, step)

    def solved(self, state: FrictionState, right: Floats, tolerance: float) -> Floats:
        """Solve the linearised law for changes of the residual, (k, n_cells, 2, n_strips)."""
        sticks, scale, ratio, n = state.sticks, self.scale, self._ratio(state), state.direction
        weight, along = self._sticking(state)

        def law(forces: Floats) -> Floats:
            slips = self.operator(np.where(self.loaded, forces, 0.0))
            moved = scale * slips
            # where it slips: df - ratio (1 - n n') (df - r dS) - n dm
            fallen = 0.0 if state.slopes is None else n * state.slopes.change(forces, slips)[..., None, :]
            return np.where(sticks, moved, forces - ratio * _across(n, forces - moved) - fallen)

        def near(values: Floats) -> Floats:
            across = weight * _across(along, values)
            return values + weight * _across(along, self.operator.preconditioned(across / scale) - across)

        return np.where(self.loaded, _solved(law, near, right, tolerance), 0.0)

    def adjoint(self, state: FrictionState, values: Floats, tolerance: float) -> tuple[Floats, Floats, Floats]:
        """Derivatives of sums of the forces times values, by the rigid slip, by the limits, and by the velocity.

        - `values`: of k sums, (k, n_cells, 2, n_strips).
        - `tolerance`: residual of the linear equations over their right-hand side.

        Returned: (k, n_cells, 2, n_strips), (k, n_cells, n_strips) and, by the logarithm of the velocity over the slip,
        (k,), where limits fall.
        """
        # of df = -J^-1 (D r dg - n dm) and J = 1 - D + D r B with D the matrix of the cells, the transpose;
        # limits that fall, dm = M_f df + M_S dS, add -n M_f - n M_S B to J and -n M_S dg to its right-hand side
        sticks, scale, ratio, n = state.sticks, self.scale, self._ratio(state), state.direction
        weight, along = self._sticking(state)

        def fallen(vector: Floats) -> tuple[Floats | float, Floats | float]:
            radial = np.where(sticks, 0.0, n * vector).sum(axis=-2)
            return (0.0, 0.0) if state.slopes is None else state.slopes.transposed(radial)

        def law(vector: Floats) -> Floats:
            inside = np.where(sticks, vector, ratio * _across(n, vector))
            by_force, by_slip = fallen(vector)
            moved = self.operator.transposed(scale * inside - by_slip)
            return vector - inside - by_force + np.where(self.loaded, moved, 0.0)

        def near(vector: Floats) -> Floats:
            across = weight * _across(along, vector)
            inside = self.operator.preconditioned(across, transposed=True) / scale
            return vector + weight * _across(along, inside - across)

        solution = _solved(law, near, np.where(self.loaded, values, 0.0), tolerance)
        falling = fallen(solution)[1] + np.zeros(values.shape)
        by_slip = falling - scale * np.where(sticks, solution, ratio * _across(n, solution))
        by_limits = np.sum(n * solution, axis=-2) * (self.loaded & ~sticks)[:, 0]
        return by_slip, by_limits, np.sum(falling * state.slips, axis=(1, 2, 3))

    def _ratio(self, state: FrictionState) -> Floats:
        return np.where(self.loaded & ~state.sticks, state.share, 0.0)

    def _sticking(self, state: FrictionState) -> tuple[Floats, Floats]:
        """How far cells are as those that stick, and in which direction they are not.

        Across the slip a cell that hardly slips is as one that sticks, and one that slips far is by itself.
        """
        weight = np.where(state.sticks, 1.0, np.clip(3.0 * self._ratio(state) - 1.0, 0.0, 1.0))
        return weight, np.where(state.sticks, 0.0, state.direction)

    def derivative(self, state: FrictionState, rigid: Floats, tolerance: float = 1e-4) -> Floats:
        """Changes of the forces by changes of the rigid slip, (k, n_cells, 2, n_strips)."""
        scaled, n = self.scale * rigid, state.direction
        slipping = self._ratio(state) * _across(n, scaled)
        if state.slopes is not None:
            slipping = slipping - n * state.slopes.change(np.zeros(rigid.shape), rigid)[..., None, :]
        return -self.solved(state, np.where(state.sticks, scaled, slipping), tolerance)

    def _within(self, forces: Floats) -> Floats:
        """Forces cut at the limits."""
        length, limits = np.linalg.norm(forces, axis=1, keepdims=True), self.limits[:, None]
        return forces * np.where(length > limits, limits / np.where(length > 0.0, length, 1.0), 1.0)


def tangential_convolution(coefficients: Floats) -> Convolution:
    """Displacements along t and z by forces along t and z, at distances (n_strips, 2 n_cells, 2 n_cells)."""
    return Convolution(coefficients, odd=((False, True), (False, True)))


def _across(directions: Floats, values: Floats) -> Floats:
    """Parts of values (..., n_cells, 2, n_strips) across directions."""
    t, z = (directions[..., axis, :] * values[..., axis, :] for axis in (0, 1))
    return values - directions * (t + z)[..., None, :]


def _solved(law: Linear, near: Linear, right: Floats, tolerance: float) -> Floats:
    """Solve linear equations for several right-hand sides (k, ...), with an operator that is near to the inverse.

    Block GMRES: all right-hand sides share one Krylov space, so that each product with the operator serves all of them
    (O'Leary, 1980, Linear Algebra and its Applications 29). Images of the directions Z are kept orthonormal (Walker and
    Zhou, 1994, Numerical Linear Algebra with Applications 1): ``L Z = U W`` with U lower triangular,
    ``x = b W' U^-1 Z`` of rows.
    """
    shape = right.shape[1:]
    residual = right.reshape(len(right), -1)
    enough = tolerance * np.linalg.norm(residual, axis=1)
    k, new, n = len(right), residual, 0
    directions, images = np.empty((2, USUAL_BLOCKS * k, residual.shape[1]))
    mixed, along = np.eye(MAX_BLOCKS * k), np.empty((k, MAX_BLOCKS * k))
    for _ in range(MAX_BLOCKS):
        direction = near(new.reshape(-1, *shape)).reshape(new.shape)
        new = law(direction.reshape(-1, *shape)).reshape(new.shape)
        parts = np.zeros((len(new), n))
        for _ in range(2):  # twice is enough
            more = new @ images[:n].T
            new, parts = new - more @ images[:n], parts + more
        size = np.maximum(np.linalg.norm(new, axis=1), np.finfo(float).tiny)[:, None]
        unit = new / size
        values, vectors = np.linalg.eigh(unit @ unit.T)
        apart = values > DEPENDENT
        combined = vectors[:, apart].T / np.sqrt(values[apart, None]) / size.T
        new, last = combined @ new, n + int(apart.sum())
        if last > len(images):
            directions, images = (np.concatenate((kept, np.empty_like(kept))) for kept in (directions, images))
        directions[n:last], images[n:last], mixed[n:last, :n] = combined @ direction, new, combined @ parts
        along[:, n:last] = residual @ new.T
        residual, n = residual - along[:, n:last] @ new, last
        if (np.linalg.norm(residual, axis=1) <= enough).all():
            break
    return (np.linalg.solve(mixed[:n, :n].T, along[:, :n].T).T @ directions[:n]).reshape(right.shape)
