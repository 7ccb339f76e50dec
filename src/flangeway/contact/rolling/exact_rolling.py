"""Rolling and shifting with friction by Kalker's exact (variational) theory, on half-spaces or on the bodies."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from flangeway.checks import check_finite, check_positive
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.friction_solver import ROUND_OFF, FallingLimits, FrictionProblem, FrictionState
from flangeway.contact.rolling.rolling_contact import (
    NO_CONTACT,
    SLIPS,
    STICKS,
    STRIPS_BEYOND,
    Creepages,
    Rolling,
    RollingContact,
)
from flangeway.errors import InputError
from flangeway.geometry.arrays import quotients
from flangeway.solve import Status
from flangeway.types import Floats

STEADY_WEIGHTS = (1.5, -2.0, 0.5)
"""Weights of displacements here, one strip and two strips ahead: a difference of second order that looks upstream."""
FIRST_STEP_WEIGHTS = (1.0, -1.0)
"""The same for the first step of transient rolling, of first order."""
MAX_TURNS, MAX_SLOW = 60, 5
SLOPE_STEP = 1e-7
"""Difference of creepages for the derivative of `Rolling.slope`."""
FORCE_ERROR, FINER = 1e-6, 1e-3
"""Error of a prescribed force relative to the limit of friction, and the finer tolerance of the law of friction for
it."""
MIN_SLOPE = 1e-9
"""Change of a force by its creepage, relative to that of cells by themselves, that is none: everything slips."""
PRESSURE_CHANGE = 1e-5
"""Change of the normal forces by tangential ones, relative to their sum, at which the iteration of both ends."""


class Start(NamedTuple):
    """Tractions (t, z) to start from, (n_cells, n_strips, 2), on the cells of a contact."""

    tractions: Floats
    contact: RollingContact


def roll(
    contact: RollingContact,
    motion: Creepages,
    *,
    force_along: float | None = None,
    force_across: float | None = None,
    before: Rolling | None = None,
    start: Rolling | Start | None = None,
    tolerance: float = 1e-4,
    differences: tuple[float, ...] = STEADY_WEIGHTS,
) -> Rolling:
    """Find tangential tractions, stick and slip by the exact theory (Kalker, 1990).

    A motion with a speed and nothing before it is steady rolling. With a state before it, it is one step of transient
    rolling, by one strip. A motion of speed 0 is a shift from the state before, or from bodies that were pressed
    together without friction. Displacements are differenced with second order looking upstream. Edges of the patch
    leave an error of first order in the cells: at 40 cells along the patch forces are within 0.5 % of those of fine
    grids, with spin within 2 % (first order: 2 % and 5 %). Two grids, extrapolated, give 0.1 %.

    Parameters
    ----------
    contact
        The patch.
    motion
        Creepages and speed, or a shift.
    force_along, force_across
        Forces on the second body instead of creepages: those of `motion` are then only the first guess.
    before
        The state before: makes rolling transient.
    start
        A neighbouring result to start from.
    tolerance
        Error of the law of friction over its limits, at small creepages over what single cells would carry.
    differences
        Weights of the displacements on a strip and those ahead of it in steady rolling; `FIRST_STEP_WEIGHTS` has the
        errors of first order of Kalker's and CONTACT's scheme.

    Raises
    ------
    InputError
        If prescribed forces reach the limit of friction or are no numbers, states of different grids are mixed, or the
        tolerance is not positive, or the sum of the differences is not 0.

    """
    if before is not None and not isinstance(before, Rolling):
        raise InputError(f"a state before of {before.theory}", "a result of roll", "compute it by the exact theory")
    for other in (before, start):
        shape = np.shape(getattr(other, "tractions", ()))[:2]
        if other is not None and shape != contact.pressures.shape:
            raise InputError(
                f"a state of {shape} cells for a patch of {contact.pressures.shape}",
                "states of the same grid",
                "leave it out, or compute it on this grid",
            )
    check_positive("roll", "tolerance", tolerance)
    if len(differences) not in (2, 3) or abs(sum(differences)) > ROUND_OFF:
        raise InputError(
            f"differences={differences}",
            "STEADY_WEIGHTS or FIRST_STEP_WEIGHTS: two or three weights of sum 0",
            "take one of them",
        )
    if contact.friction.by_temperature and not (motion.rolls and before is None):
        raise InputError(
            "friction that falls with temperature in a shift, or from a state before",
            "steady rolling: temperatures are those of surfaces that have gone on in the same way",
            "leave the state before out, or let friction fall with the slip velocity",
        )
    for name, force in (("force_along", force_along), ("force_across", force_across)):
        if force is not None:
            check_finite("roll", name, force)
    wanted = (force_along, force_across)
    step = _Step(contact, motion, before, contact, differences)
    result = step.rolling(None if start is None else _forces(start), motion, wanted, tolerance)
    if contact.pressed is None or not contact.coupled:
        return result
    # friction changes the gaps, pressures the limits and the slip
    change, turn = np.inf, 0
    while change > PRESSURE_CHANGE and turn < MAX_TURNS:
        turn += 1
        old, forces = step.contact.normal_forces, _forces(result)
        new = contact.pressed(result.gap_increase, old).forces
        change = float(np.abs(new - old).sum()) / contact.force
        step = replace(step, contact=step.contact.under(new / contact.areas))
        result = step.rolling(forces, result.motion, wanted, tolerance)
    message = f"{result.status.message}; pressures change by {change:.1e} after {turn} turns"
    met = result.status.converged and change <= PRESSURE_CHANGE
    return replace(result, status=Status(met, message, result.status.iterations))


def creep_curve(contact: RollingContact, motions: Sequence[Creepages], tolerance: float = 1e-4) -> list[Rolling]:
    """Steady rolling at many creepages, each started from the one before."""
    curve: list[Rolling] = []
    for motion in motions:
        curve.append(roll(contact, motion, start=curve[-1] if curve else None, tolerance=tolerance))
    return curve


def derivatives(rolling: Rolling) -> Floats:
    """Derivatives of (along, across, moment) by (along, across, spin) of the motion, shape (3, 3).

    Raises
    ------
    InputError
        If the result is not one of `roll`.

    """
    if not isinstance(rolling, Rolling) or rolling.problem is None or rolling.state is None:
        raise InputError(f"a result of {rolling.theory}", "a result of roll", "compute it by the exact theory")
    places = rolling.contact.places
    slips = np.array([Creepages(*unit).rigid(*places) for unit in np.eye(3).tolist()])
    # (along, across, moment) by forces (t, z): (0, 1), (1, 0), (-z, s), which are the rigid slips of unit creepages
    by_slip, _, by_slope = adjoint(rolling, slips)
    motion, lever = rolling.motion, 1.0 / rolling.contact.grid.strip
    slopes = [
        [np.log(EllipticContact.slope_of(rolling.contact, replace(motion.moved(*plane), spin=motion.spin + turning)))
         for *plane, turning in (unit * part * SLOPE_STEP * [1.0, 1.0, lever] for part in (-1.0, 1.0))]
        for unit in np.eye(3)
    ]  # fmt: skip
    reduced = np.diff(slopes, axis=1)[:, 0] / (2.0 * SLOPE_STEP * np.array([1.0, 1.0, lever]))
    return np.tensordot(by_slip, slips, axes=([1, 2, 3], [1, 2, 3])) + np.outer(by_slope, reduced)


def adjoint(rolling: Rolling, values: Floats, tolerance: float = 1e-4) -> tuple[Floats, Floats, Floats]:
    """Derivatives of sums of tangential forces times values, by rigid slip and normal forces of the cells.

    The law of friction is linearised at the result: cells that stick go on to stick, others to slip.

    Parameters
    ----------
    rolling
        Steady rolling by `roll`.
    values
        Of k sums on the cells, (k, n_cells, 2, n_strips).
    tolerance
        Residual of the linear equations over their right-hand side.

    Returns
    -------
    tuple[Floats, Floats, Floats]
        By the rigid slip over the distance rolled (`Creepages.rigid`), (k, n_cells, 2, n_strips), by the normal forces,
        (k, n_cells, n_strips), both at the same `Rolling.slope`, and by its logarithm, (k,).

    """
    assert rolling.problem is not None
    assert rolling.state is not None
    step = _Step(rolling.contact, rolling.motion, None, rolling.contact)
    rows, strips = step.inside
    wanted = step.turned(values)[:, rows, :, strips]
    by_slip, by_limits, by_velocity = rolling.problem.adjoint(rolling.state, wanted, tolerance)
    by_slope = np.sum(by_slip * rolling.problem.rigid, axis=(1, 2, 3)) - by_velocity
    by_slip *= rolling.slope
    pressing = step.cells(rolling.contact.normal_forces)
    by_normal = quotients(by_limits * rolling.state.limits, pressing)
    by_normal = step.outside(np.stack((by_normal, by_normal), axis=2))[:, :, 0]
    if rolling.contact.coupled:  # normal forces move the surfaces along t and z: by reciprocity these the normals
        forces = np.zeros((*values.shape[:3], values.shape[3] + 2 * STRIPS_BEYOND))
        for k, weight in enumerate(step.weights):
            forces[:, rows, :, strips.start + STRIPS_BEYOND + k : strips.stop + STRIPS_BEYOND + k] += weight * by_slip
        by_normal = by_normal + rolling.contact.gap_increase(step.turned(forces))[..., STRIPS_BEYOND:-STRIPS_BEYOND]
    return step.distance * step.outside(by_slip), by_normal, by_slope


@dataclass(frozen=True, eq=False)
class _Step:
    """One state to be found: of steady rolling, or from one before, at pressures that are known.

    Inside, all bodies roll to +z: for rolling to -z strips and components along z are turned over. `pressed` has the
    pressures before the first shift.
    """

    contact: RollingContact
    motion: Creepages
    before: Rolling | None
    pressed: RollingContact
    differences: tuple[float, ...] = STEADY_WEIGHTS

    @property
    def steady(self) -> bool:
        return self.motion.rolls and self.before is None

    @property
    def distance(self) -> float:
        """Distance that is rolled, 1 for a shift."""
        return self.contact.grid.strip if self.motion.rolls else 1.0

    @property
    def weights(self) -> tuple[float, ...]:
        """Weights of the displacements of this state and of those before it."""
        if not self.motion.rolls:
            return FIRST_STEP_WEIGHTS
        onwards = self.before is None or (
            self.before.motion.speed * self.motion.speed > 0.0 and len(self.before.displacements) > 1
        )
        return self.differences if onwards else FIRST_STEP_WEIGHTS

    def turned(self, values: Floats) -> Floats:
        """Components (t, ..., z) in the direction of rolling, (..., n_cells, m, n_strips); its own inverse."""
        if self.motion.speed >= 0.0:
            return values
        mirrored = values[..., ::-1].copy()
        mirrored[..., -1, :] *= -1.0
        return mirrored

    @cached_property
    def inside(self) -> tuple[slice, slice]:
        """Rows and strips of the cells under pressure in the direction of rolling."""
        rows, strips = self.contact.box
        n = self.contact.grid.n_strips
        return rows, strips if self.motion.speed >= 0.0 else slice(n - strips.stop, n - strips.start)

    def cells(self, values: Floats) -> Floats:
        """Numbers of the cells (n_cells, n_strips) in the box, in the direction of rolling."""
        return (values if self.motion.speed >= 0.0 else values[:, ::-1])[self.inside]

    def rigid(self, along: Floats | float, across: Floats | float, spin: Floats | float) -> Floats:
        """Rigid slip in the box over the distance."""
        whole = Creepages(along, across, spin).rigid(*self.contact.places)
        rows, strips = self.inside
        return self.distance * self.turned(whole)[rows, :, strips]

    def outside(self, values: Floats) -> Floats:
        """Values of the box (..., n_rows, 2, n_strips) on all cells, components along t and z."""
        whole = np.zeros((*values.shape[:-3], len(self.contact.pressures), 2, self.contact.grid.n_strips))
        rows, strips = self.inside
        whole[..., rows, :, strips] = values
        return self.turned(whole)

    @cached_property
    def known_slip(self) -> Floats:
        """Slip in the box by pressures and by the displacements before."""
        rows, strips = self.inside
        n, weights = strips.stop - strips.start, self.weights

        def ahead(displacements: Floats, k: int) -> Floats:
            start = strips.start + STRIPS_BEYOND + k
            return self.turned(displacements)[rows, :, start : start + n]

        pressing = self.contact.pressing if self.contact.coupled else None
        total = np.zeros((rows.stop - rows.start, 2, n))
        if self.steady:
            return total if pressing is None else sum((w * ahead(pressing, k) for k, w in enumerate(weights)), total)
        if pressing is not None:
            total += weights[0] * ahead(pressing, 0)
        if self.before is None and pressing is not None:
            return total - ahead(self.pressed.pressing, 0)
        moved = 1 if self.motion.rolls else 0
        for k, past in enumerate(() if self.before is None else self.before.displacements[: len(weights) - 1], 1):
            total += weights[k] * ahead(past, k * moved)
        return total

    def rolling(
        self,
        start: Floats | None,
        motion: Creepages,
        wanted: tuple[float | None, float | None],
        tolerance: float,
    ) -> Rolling:
        """The result for creepages, those of prescribed forces found by `_under_forces`."""
        unknown = [number for number, force in enumerate(wanted) if force is not None]
        if not unknown:
            return self.result(motion, *self.solved(motion, start, tolerance))
        limit = float((self.contact.friction.limits[0][:, None] * self.contact.normal_forces).sum())
        target = np.array([wanted[number] for number in unknown], dtype=np.float64)
        if not np.linalg.norm(target) < limit:
            raise InputError(
                f"forces of {target.tolist()} by friction up to {limit:.6g}",
                "forces below the limit of friction: beyond it everything slips, at any creepage",
                "lower the forces, or give creepages",
            )
        return self._under_forces(start, motion, unknown, target, limit, FINER * tolerance)

    def _under_forces(
        self,
        start: Floats | None,
        motion: Creepages,
        unknown: list[int],
        target: Floats,
        limit: float,
        tolerance: float,
    ) -> Rolling:
        """Creepages with prescribed forces, by Newton's method from those of the motion.

        Forces fall with their creepages: one creepage is kept between those that are known to be too small and too
        large. With two the error must fall: steps are halved. Where it hardly does, as where everything slips at the
        first guess, they start again from no creepage. A loop of its own: one creepage has a bracket, and each force is
        itself the end of an iteration.

        - `unknown`: which of the creepages along and across, (n,); `target`: their forces, (n,).
        - `limit`: of friction, the unit of errors.
        """
        one = len(unknown) == 1
        best, slow, failed, guessed = np.inf, 0, 0, not one
        change, bracket = np.zeros(len(unknown)), np.array([-np.inf, np.inf])
        for turn in range(MAX_TURNS):
            if failed > MAX_SLOW:
                break
            trial = motion.moved(*(change @ np.eye(2)[unknown]))
            problem, state, status = self.solved(trial, start, tolerance)
            forces = self.outside(state.forces)
            missing = target - self.contact.resultants(forces)[unknown]
            error = float(np.linalg.norm(missing)) / limit
            if one:
                bracket[int(missing[0] > 0.0)] = change[0]
            slow += error > best / 2.0
            failed += not status.converged
            if error < best:
                best, base, start = error, change, forces
                rolling = self.result(trial, problem, state, status)
                if error <= FORCE_ERROR:
                    return rolling
                step = self._newton(problem, state, unknown, missing) / self.slope(trial)
            else:
                step = np.array([np.inf]) if one else step / 2.0
            change = base + step
            if guessed and slow > MAX_SLOW:
                change = -np.array([np.mean(motion.along), np.mean(motion.across)])
                best, start, guessed = np.inf, None, False
            if one and not bracket[0] < change[0] < bracket[1]:
                far = 4.0**turn * float((problem.limits / problem.operator.scale[:, 0]).max()) / self.distance
                change = np.array([_middle(bracket, far)])
        message = f"{rolling.status.message}; the prescribed forces are missed by {best:.1e} of the limit"
        return replace(rolling, status=Status(False, message, rolling.status.iterations))

    def _newton(self, problem: FrictionProblem, state: FrictionState, unknown: list[int], missing: Floats) -> Floats:
        """Change of the creepages that gives the missing forces as far as they are linear."""
        columns = problem.derivative(state, np.array([self.rigid(*np.eye(3)[number]) for number in unknown]))
        matrix = np.stack([self.contact.resultants(forces)[unknown] for forces in self.outside(columns)], axis=1)
        if len(unknown) == 1 and abs(matrix[0, 0]) <= MIN_SLOPE * float(problem.operator.scale.sum()) * self.distance:
            return np.array([np.inf])
        return np.asarray(np.linalg.lstsq(matrix, missing)[0], dtype=np.float64)

    def solved(
        self, motion: Creepages, start: Floats | None, tolerance: float
    ) -> tuple[FrictionProblem, FrictionState, Status]:
        """Forces at creepages, and at limits that may fall with the slip velocity."""
        rows, strips = self.inside
        friction, pressing = self.contact.friction, self.cells(self.contact.normal_forces)
        rigid = self.slope(motion) * (self.rigid(motion.along, motion.across, motion.spin) + self.known_slip)
        operator = self.contact.operator(self.weights if self.steady else self.weights[:1])
        forces = None if start is None else self.turned(start)[rows, :, strips]
        static = np.broadcast_to(friction.limits[0][:, None], self.contact.pressures.shape)[rows, strips]
        problem = FrictionProblem(operator, rigid, static * pressing)
        if not friction.constant:
            warming = None
            if friction.by_temperature and friction.heating is not None:
                warming = friction.heating.on_strips(pressing.shape[1], self.contact.grid.strip, motion.speed)
            areas = self.contact.areas[rows]
            falling = FallingLimits(friction.of_rows(rows), pressing, areas, self.velocity(motion), warming)
            problem = replace(problem, falling=falling)
        return problem, *problem.solve(forces, tolerance)

    def velocity(self, motion: Creepages) -> float:
        """Velocity over the slip of `FrictionProblem`, which is slip times the factor of the slope."""
        return (abs(motion.speed) / self.distance if motion.rolls else 1.0) / self.slope(motion)

    def slope(self, motion: Creepages) -> float:
        """Factor of `Friction.slope`: displacements by friction are those of the bodies over it."""
        return EllipticContact.slope_of(self.contact, motion)

    def result(self, motion: Creepages, problem: FrictionProblem, state: FrictionState, status: Status) -> Rolling:
        """The record of a state."""
        contact, heating = self.contact, self.contact.friction.heating
        forces, slips = self.outside(state.forces), self.velocity(motion) * self.outside(state.slips)
        loaded = contact.pressures > 0.0
        slips *= loaded[:, None]
        gap_increase = contact.gap_increase(np.pad(forces, ((0, 0), (0, 0), (STRIPS_BEYOND, STRIPS_BEYOND))))
        sticks = self.outside(np.repeat(state.sticks * 1.0, 2, axis=1))[:, 0] != 0.0
        warmth, rolling = None, 0.0
        if self.steady:
            if heating is not None:
                heat = -np.sum(forces * slips, axis=1) / contact.areas
                warmth = heating.rises(heat, contact.grid.strip, motion.speed)
            raising = (
                gap_increase[:, STRIPS_BEYOND + 1 : 1 - STRIPS_BEYOND]
                - gap_increase[:, STRIPS_BEYOND - 1 : -1 - STRIPS_BEYOND]
            ) / 2.0
            rolling = -motion.speed * float(np.sum(contact.normal_forces * raising)) / contact.grid.strip
        along, across, moment = self.contact.resultants(forces).tolist()
        return Rolling(
            motion=motion,
            along=along,
            across=across,
            moment=moment,
            theory="exact",
            status=status,
            notices=(*motion.notices, *contact.notices),
            contact=contact,
            tractions=forces.swapaxes(1, 2) / contact.areas[:, :, None],
            slip_velocities=slips.swapaxes(1, 2),
            states=np.where(loaded, np.where(sticks, STICKS, SLIPS), NO_CONTACT),
            flash_temperatures=warmth,
            rolling_power=rolling,
            gap_increase=gap_increase[:, STRIPS_BEYOND:-STRIPS_BEYOND],
            slope=self.slope(motion),
            past=() if self.before is None or not motion.rolls else self.before.displacements[:1],
            steady=self.steady,
            problem=problem,
            state=state,
        )


def _middle(bracket: Floats, far: float) -> float:
    """Middle of a bracket, one of whose ends may be infinite: a distance ``far`` from the other one instead."""
    known = np.isfinite(bracket)
    return float(np.where(known, bracket, bracket[known].mean() + far * np.array([-1.0, 1.0])).mean())


def _forces(rolling: Rolling | Start) -> Floats:
    """Tangential forces (n_cells, 2, n_strips) on the cells."""
    return rolling.contact.forces_of(rolling.tractions)
