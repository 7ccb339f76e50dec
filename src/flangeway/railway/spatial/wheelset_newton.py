"""Equilibrium of a wheelset in three dimensions by Newton's method, without friction or with creep forces.

Unknown are the position, the tilts of both wheels, and with friction the rate of rotation about the axle and, if it is
not prescribed, the yaw. With the derivatives of `SideNewton` by the position, those of creep forces are differences of
a fast theory; what they miss of the exact theory is learned from step to step (Broyden, 1965).
"""

from dataclasses import replace

import numpy as np

from flangeway.railway.spatial.rolling.wheelset_creep import TOLERANCE, SideCreep, WheelsetCreep
from flangeway.railway.spatial.side_contact import SideState
from flangeway.railway.spatial.side_newton import SideNewton, nearest, transferred, transferred_creep
from flangeway.railway.spatial.spatial_contact import RolledWheelset, SpatialContact, SpatialState, pose_of, signs_of
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.wheelset.equilibrium import LOWERED, Equilibrium
from flangeway.railway.wheelset.residual import MAX_STEP, RelativeResiduals, is_stable, loads_of, with_loads
from flangeway.solve import Status
from flangeway.types import Bools, Floats

COARSE_FORCES = 1e-4
FINE_RESIDUAL = 1e-8
FINE_TILT_RAD = 1e-9
FINE_FORCES = 1e-7
"""Change of the forces of a step over their sum."""
MAX_STEPS = 10.0
"""Step over the step limits above which the position is not close by."""
LOWERING = np.array([False, True, False, True, True])
ACROSS = np.array([True, False, False, False, False, False, True])
SETTLED = 0.02
"""Residual, but for lateral force and yaw moment, above which pressures on new cells are not yet found: until then
creep forces move the wheelset neither across the track nor by yaw."""
MAX_GROWTH = 4.0
"""Factor on the step limits."""
FALLS, LEAST_PART = 0.4, 0.15
"""Share of a step by which the residual must fall, otherwise smaller parts of steps are taken, and the smallest one."""
LEARNS = 0.01
"""Residual of the forces below which what the derivatives miss is learned."""
ERROR_OF_LAW, LOOSE = 0.1, 1e-2
"""Error of the law of friction over the residual of the position before, and its largest one."""
MAX_CREEPAGE, MAX_YAW_RAD = 2e-3, 1e-3
"""Step limits of the rate of rotation over itself, and of the yaw."""
MAX_BENDING = 8.0
"""Factor on the displacement by creep forces in one step, which doubles where the rest is nearly in equilibrium: rails
that bend far would creep there, and elsewhere large steps of bending lead astray."""
LEAST_TRUST = 0.25
"""Least factor on the first. Where friction is exhausted torque hardly changes with the rate: whole steps go round."""
RATE, YAW = 5, 6
"""Numbers of the unknowns that friction adds behind position and tilts: the rate of rotation, and the yaw."""


class WheelsetNewton:
    """A wheelset while its equilibrium is sought."""

    def __init__(
        self,
        contact: SpatialContact,
        by_forces: Floats,
        position: WheelsetPosition,
        near: SpatialState | None,
        creep: WheelsetCreep | None,
        *,
        lower: bool,
    ) -> None:
        self.contact, self.problem, self.by_forces = contact, contact.problem, by_forces
        self.position, self.tilts, self.yaw = position, contact.tilts, contact.yaw_rad
        self.creep, self.lower = creep, lower
        if near is not None and creep is not None:
            poses = [(SIDE_SIGN[side], near.sides[side].pose) for side in SIDES]
            self.yaw = poses[0][0] * poses[0][1].yaw_rad
            self.tilts = np.array([sign * pose.tilt_rad for sign, pose in poses])
        self.sides: dict[Side, SideNewton] = {}
        for number, (side, grid) in enumerate(contact.grids.items()):
            pose = pose_of(self.problem, position, side, self.yaw, self.tilts[number])
            before = None if near is None else near.sides[side]
            self.sides[side] = SideNewton(grid, pose, None if before is None else transferred(before, grid))
            if before is not None:
                self.sides[side].creep = transferred_creep(before, grid)
            if before is not None and near is not None and near.rolled is not None:
                self.sides[side].raised = nearest(near.rolled.creep[side].raised, before.grid.grid, grid.grid)
        held = [*(value is None for value in self.problem.prescribed.components), True, True]
        if creep is not None:
            held += [True, creep.motion.yaw_is_free]
        self.free = np.array(held)
        if creep is not None and near is not None and near.rolled is not None:
            creep.before = near.rolled.creep
        self.history: list[RelativeResiduals] = []
        self.growth, self.trust, self.bending, self._across = 1.0, 1.0, 1.0, 0.0
        self.part, self._error = 1.0, np.inf
        self.settles = creep is not None and near is not None and near.rolled is not None
        self._missing = self._slopes = np.zeros((5, len(self.free)))
        self._before: tuple[Floats, Floats] | None = None

    @property
    def touches(self) -> bool:
        """Whether both wheels touch."""
        return all(each.touching.any() for each in self.sides.values())

    @property
    def bends(self) -> bool:
        """Whether creep forces that were found still bend the bodies in part only."""
        return any(each.bent for each in self.sides.values())

    @property
    def reaches_an_end(self) -> bool:
        """Whether a patch has come to an end of its cells."""
        return any(bool(((each.forces > 0.0) & each.grid.grid.at_edge).any()) for each in self.sides.values())

    def linearise(self) -> None:
        """Take residuals and their derivatives at the position."""
        n = len(self.free)
        if self.creep is not None:  # the law of friction need not hold better than the equilibrium
            before = self.history[-1].equilibrium_residual if self.history else LOOSE / ERROR_OF_LAW
            self.creep.tolerance = float(np.clip(ERROR_OF_LAW * before, TOLERANCE, LOOSE))
            self.bending = float(np.clip(self.bending * (2.0 if before < SETTLED else 0.5), 1.0, MAX_BENDING))
        total, self.jacobian = np.zeros(3), np.zeros((n, n))
        self.resultants: dict[Side, Floats] = {}
        self.own: dict[Side, Floats] = {}
        self.changes: dict[Side, tuple[Floats, Floats, Floats, list[int]]] = {}
        self.rolled: dict[Side, SideCreep] = {}
        self.turning = 0.0  # yaw moment of normal forces
        self.creep_now, self.creeping = np.zeros(5), np.zeros((5, n))
        jacobian = self.jacobian
        for number, (side, newton) in enumerate(self.sides.items()):
            newton.linearise(pose_of(self.problem, self.position, side, self.yaw, self.tilts[number]))
            rolls = self.creep is not None
            forces, by = newton.solve(rolls=rolls)
            if rolls:
                self._bent_by_creep(side, newton, forces)
                forces, by = newton.solve(rolls=True)
            resultant, own = newton.stiffness(forces, by)
            signs = signs_of(side)
            by_signs = np.array([*signs, signs[0], 1.0, signs[0]])[: by.shape[1]]
            columns = [0, 1, 2, 3 + number, RATE, YAW][: by.shape[1]]  # of the axle's x, y and roll, this side's tilt
            self.own[side], self.resultants[side] = own[:, :4], signs * resultant
            self.changes[side] = forces, by, by_signs, columns
            slopes = signs[:, None] * own * by_signs
            jacobian[:3, columns] += slopes
            jacobian[3:5, columns] -= self.by_forces[number] @ slopes
            if rolls:
                self._add_creep(number, side)
            total += self.resultants[side]
        jacobian[2, 2] += loads_of(self.problem).moment_by_roll(self.position.roll_rad)
        jacobian[3:5, 3:5] += np.eye(2)
        self.residual, self.relative = with_loads(self.problem, self.position, total)
        bent = sum(self.by_forces[number] @ self.resultants[side] for number, side in enumerate(SIDES))
        self.bent = np.asarray(bent)
        self.missed = np.append(self.residual, self.tilts - self.bent)
        if self.creep is not None:
            self._add_equations(self.creep)
        self.history.append(self.relative)

    def _bent_by_creep(self, side: Side, newton: SideNewton, forces: Floats) -> None:
        """Find creep forces under normal ones, and let them bend the bodies."""
        assert self.creep is not None
        normal = np.zeros(newton.forces.shape)
        normal[newton.touching] = np.maximum(forces, 0.0)
        found = self.rolled[side] = self.creep.of_side(side, newton, normal)
        slopes = self.creep.derivatives(side, newton, normal, found)
        newton.bend(found.rows, found.raised, forces, slopes, self.bending * self.creep.max_bent_mm)

    def _add_creep(self, number: int, side: Side) -> None:
        """Add creep forces of a side and what they change."""
        newton, to_track = self.sides[side], signs_of_creep(side)
        forces, by, by_signs, columns = self.changes[side]
        now, change = newton.creep_now(forces, by, self.rolled[side].resultant)
        now, change = to_track @ now, to_track @ change * by_signs
        self.creeping[:, columns] += change
        self.creep_now += now
        self.resultants[side] = self.resultants[side] + now[:3]
        self.jacobian[3:5, columns] -= self.by_forces[number] @ change[:3]
        moment, slopes = newton.yaw_moment(forces, by * by_signs)
        self.turning -= SIDE_SIGN[side] * moment
        self.jacobian[YAW, columns] -= SIDE_SIGN[side] * slopes

    def _add_equations(self, creep: WheelsetCreep) -> None:
        """Add the equations of torque and yaw, and what differences of a fast theory miss of the exact one."""
        motion, problem = creep.motion, self.problem
        unknown = np.array([*self.position.components, *self.tilts, creep.rate_rad_s, self.yaw])
        if self.relative.equilibrium_residual < LEARNS:
            if self._before is not None:
                step = unknown - self._before[0]
                weighted = step / self._limits**2
                wrong = self.creep_now - self._before[1] - self._slopes @ step
                self._missing = self._missing + np.outer(wrong, weighted) / max(float(weighted @ step), 1e-300)
            self.creeping += self._missing
            self._before, self._slopes = (unknown, self.creep_now), self.creeping
        self.jacobian[[0, 1, 2, RATE, YAW]] += self.creeping
        self.torque = float(self.creep_now[3])
        self.yaw_moment = float(self.creep_now[4]) + self.turning
        weight, arm = float(loads_of(problem).weight), problem.wheelset.back_to_back_mm / 2.0
        driven, guided = self.torque + 1e3 * motion.torque_Nm, 0.0
        if motion.yaw_stiffness_Nm_per_rad is not None:
            stiffness = 1e3 * motion.yaw_stiffness_Nm_per_rad
            guided = self.yaw_moment - stiffness * (self.yaw - self.contact.yaw_rad)
            self.jacobian[YAW, YAW] -= stiffness
        self.missed = np.append(self.missed, [driven, guided])
        self.relative = replace(
            self.relative,
            torque_residual=driven / (weight * problem.wheelset.tape_radius_mm),
            yaw_residual=guided / (weight * arm),
        )

    @property
    def _limits(self) -> Floats:
        """Step limits with friction."""
        assert self.creep is not None
        return np.array([*MAX_STEP, MAX_STEP[2], MAX_STEP[2], MAX_CREEPAGE * self.creep.rate_rad_s, MAX_YAW_RAD])

    def _newton_step(self, free: Bools, given: Floats | None = None) -> Floats:
        """Step of what is free, after a given one of the others."""
        step: Floats = np.zeros(len(self.free)) if given is None else given.copy()
        missed = self.missed if given is None else self.missed + self.jacobian @ given
        step[free] = np.linalg.solve(self.jacobian[np.ix_(free, free)], -missed[free])
        return step

    def _limited(self, step: Floats, free: Bools) -> Floats:
        """Newton's step within the limits: the wheelset goes where it is pushed, as far as to a flange."""
        limits = self._limits
        if free[0] and abs(step[0]) > self.growth * limits[0]:
            given = np.zeros(len(step))
            given[0] = np.sign(self.missed[0]) * self.growth * limits[0]
            step = self._newton_step(free & (np.arange(len(step)) > 0), given)
            self.growth = min(2.0 * self.growth, MAX_GROWTH) if given[0] * self._across > 0.0 else 1.0
        else:
            self.growth = 1.0
        self._across = float(step[0])
        limits[:2] *= self.growth
        if self._error < np.inf:
            falls = self.relative.equilibrium_residual < self._error
            self.trust = min(1.5 * self.trust, 1.0) if falls else max(self.trust / 2.0, LEAST_TRUST)
        limits[RATE] *= self.trust
        excess = float((np.abs(step) / limits).max())
        # close by, forces that jump from one patch to another end in circles without
        falls = self.relative.equilibrium_residual < (1.0 - FALLS * self.part) * self._error
        falls |= self.bends  # creep forces still grow
        self.part = min(1.0, 1.5 * self.part) if falls or excess > 1.0 else max(self.part / 1.5, LEAST_PART)
        self._error = self.relative.equilibrium_residual
        return step * min(self.part, 1.0 / excess if excess > 1.0 else 1.0)

    def step(self, tolerance: float) -> bool | None:
        """Move by Newton's step within its limits; whether it was in equilibrium, or None where that is far away."""
        share = tolerance / FINE_RESIDUAL
        error = self.relative.equilibrium_residual
        self.lower = self.lower and abs(self.relative.vertical_residual) > LOWERED
        now = self.free & LOWERING if self.lower else self.free
        if self.settles:
            relative = replace(self.relative, lateral_residual=0.0, yaw_residual=0.0)
            self.settles = self.bends or relative.equilibrium_residual > SETTLED
        if self.settles:
            now = now & ~ACROSS[: len(now)]
        step = self._newton_step(now)
        if self.creep is None:
            excess = float((np.abs(step[:3]) / MAX_STEP).max())
            if excess > MAX_STEPS:
                return None
            step /= max(1.0, excess)
        else:
            step = self._limited(step, now)
        change = 0.0
        for side, (forces, by, by_signs, columns) in self.changes.items():
            own = by_signs * step[columns]
            change = max(change, self.sides[side].take(forces + by @ own, own))
        most = share * FINE_FORCES
        if self.creep is None:
            most = min(most, COARSE_FORCES)
        moving = self.bends or (most < COARSE_FORCES and any(each.changed for each in self.sides.values()))
        loose = self.creep is not None and self.creep.theory == "exact" and self.creep.tolerance > TOLERANCE
        settled = change <= most and not moving and not loose
        if error <= tolerance and float(np.abs(self.tilts - self.bent).max()) <= share * FINE_TILT_RAD and settled:
            return True
        self.position = self.position.moved(WheelsetPosition(*step[:3].tolist()))
        self.tilts = self.tilts + step[3:5]
        if self.creep is not None:
            self.creep.rate_rad_s += float(step[RATE])
            self.yaw += float(step[YAW])
        return False

    def found(self, status: Status) -> Equilibrium[SpatialState]:
        """What there is now."""
        states: dict[Side, SideState] = {side: each.state(status, self.own[side]) for side, each in self.sides.items()}
        rolled = stable = None
        if self.creep is not None:
            rolled = RolledWheelset(self.rolled, self.creep.rate_rad_s, self.yaw, self.yaw_moment, self.torque)
        elif self.free.all():
            # the tilts follow the position
            jacobian = self.jacobian
            whole = jacobian[:3, :3] - jacobian[:3, 3:] @ np.linalg.solve(jacobian[3:, 3:], jacobian[3:, :3])
            stable = is_stable(self.problem, whole)
        state = SpatialState(states, rolled)
        return Equilibrium(status, self.position, self.relative, state, self.residual, stable, tuple(self.history))


def signs_of_creep(side: Side) -> Floats:
    """From `SideCreep.resultant` to force (x, y), moment, torque and yaw moment in the track's axes, (5, 7)."""
    sign = SIDE_SIGN[side]
    found = np.zeros((5, 7))
    found[0, 0], found[1, 1], found[2, 5], found[3, 6], found[4, 4] = sign, 1.0, sign, 1.0, -sign
    return found
