"""Equilibrium of a wheelset in three dimensions by Newton's method, without friction or with creep forces.

Unknown are the position, deflections and tilts of the axle's seats, and with friction the rate of rotation about the
axle, the difference of both rates where wheels are independent, and the yaw if it is not prescribed. The derivatives
are those of `SideNewton` and of `WheelsetCreep`. What a step passes on is a value: `WheelsetNewton.linearised` has its
equations, `LinearWheelset.step` what comes after it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.rolling import RollingMotion
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import (
    MAX_STEP,
    Equilibrium,
    RelativeResiduals,
    is_stable,
    moment_by_roll,
    with_loads,
)
from flangeway.railway.wheelset.rolling.wheelset_creep import TOLERANCE, SideCreep, WheelsetCreep, patches_of
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, WheelPose
from flangeway.railway.wheelset.side_newton import (
    MOTIONS,
    CreepSlopes,
    SideNewton,
    interpolated,
    transferred,
    transferred_creep,
)
from flangeway.solve import Status
from flangeway.types import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class RolledWheelset:
    """What rolling adds to an equilibrium.

    - `creep`: creep forces of both sides in their right-hand forms.
    - `rate_rad_s`: rate of rotation about the axle, the mean of both wheels.
    - `rate_difference_rad_s`: of independent wheels, right less left; None where they are joined.
    - `yaw_rad`: yaw of the axle.
    - `yaw_moment_Nmm`: of contact and creep forces on the wheelset, counter-clockwise from above.
    - `torque_Nmm`: of creep forces about the axle, > 0 where they drive it.
    """

    creep: Mapping[Side, SideCreep]
    rate_rad_s: float
    yaw_rad: float
    yaw_moment_Nmm: float  # noqa: N815 (units in names)
    torque_Nmm: float  # noqa: N815
    rate_difference_rad_s: float | None = None


@dataclass(frozen=True, eq=False)
class SpatialState:
    """Contact of both sides at one position, and what rolling adds."""

    sides: Mapping[Side, SideState]
    rolled: RolledWheelset | None = None

    @property
    def grids(self) -> dict[Side, GriddedSide]:
        """Cells of both sides."""
        return {side: side_state.grid for side, side_state in self.sides.items()}

    def interiors(self, side: Side) -> list[Bools] | None:
        """Cells of patches that roll by themselves, (n, n_z) each; None without friction, or by the exact theory."""
        interiors = None if self.rolled is None else self.rolled.creep[side].interiors
        return None if interiors is None else patches_of(self.sides[side].forces, interiors)


def signs_of(side: Side) -> Floats:
    """Signs of a force (x, y) and a moment, from the right-hand form of a side to the track's axes."""
    return np.array([SIDE_SIGN[side], 1.0, SIDE_SIGN[side]])


def motions_of(side: Side) -> Floats:
    """How a side moves by `MOTIONS` as the unknowns change, (7, 10)."""
    sign, motions = SIDE_SIGN[side], np.zeros((len(MOTIONS), N_UNKNOWNS))
    motions[MOTIONS.index("rate"), DIFFERENCE] = sign / 2.0
    numbers = [0, 1, 2, *np.add(BENDING.start, seat_of(side)).tolist(), RATE, YAW]
    motions[np.arange(len(MOTIONS)), numbers] = sign, 1.0, sign, 1.0, sign, 1.0, sign
    return motions


NOT_BENT = np.zeros(4)


def pose_of(
    problem: WheelsetProblem, position: WheelsetPosition, side: Side, yaw_rad: float, bending: Floats = NOT_BENT
) -> WheelPose:
    """Pose of a wheel in the right-hand form of its side.

    - `bending`: deflection and tilt of the left and the right seat in the track's axes, (4,).
    """
    sign = SIDE_SIGN[side]
    x, y = position.axle(problem.wheels)
    seat = abs(problem.wheels.placement(side).translation[0])
    deflection, tilt = bending[seat_of(side)].tolist()
    return WheelPose(sign * x, y, sign * position.roll_rad, sign * yaw_rad, sign * tilt, seat, deflection)


def seat_of(side: Side) -> list[int]:
    """Numbers of deflection and tilt of the seat of a side among those of both."""
    return [0, 1] if side == "left" else [2, 3]


def bending_of(sides: Mapping[Side, SideState]) -> Floats:
    """Deflection and tilt of both seats in the poses of the wheels, see `pose_of`."""
    poses = [(SIDE_SIGN[side], sides[side].pose) for side in SIDES]
    return np.array([value for sign, pose in poses for value in (pose.deflection_mm, sign * pose.tilt_rad)])


def on_seat(pose: WheelPose, resultant: Floats) -> tuple[Floats, Floats, Floats]:
    """Force across the axle and moment that a wheel exerts on its seat, (2,), and their derivatives.

    With the direction ``u`` across the axle and the seat ``s``: ``Q = (u . F, M - s x F)``; they do work on the
    deflection and the tilt of the seat.

    - `resultant`: force F on the wheel (x, y) and moment M about the axle's middle, (3,).

    Returned: Q, ``dQ / d(F, M)`` (2, 3) and ``dQ / d(x, y, roll, deflection, tilt)`` where F and M stay, (2, 5).
    """
    (u_x, u_y), (s_x, s_y), (f_x, f_y) = pose.up, pose.seat, resultant[:2]
    by_resultant = np.array([[u_x, u_y, 0.0], [s_y, -s_x, 1.0]])
    by_motion = np.zeros((2, 5))
    # du/droll = (-u_y, u_x), ds/droll = (-s_y, s_x), ds/ddeflection = u
    by_motion[:, 2] = u_x * f_y - u_y * f_x, s_x * f_x + s_y * f_y
    by_motion[1, 3] = u_y * f_x - u_x * f_y
    return by_resultant @ resultant, by_resultant, by_motion


def bending_by_load(problem: WheelsetProblem, compliance: Floats) -> Floats:
    """Deflection and tilt of both seats by half of the vertical load on each, see `pose_of`."""
    return np.asarray(compliance[:, ::2].sum(axis=1) * problem.forces.in_track[1] / 2.0)


COARSE_FORCES = 1e-2
"""Change of the forces from which on cells that come into contact or leave it do not count."""
FINE_RESIDUAL = 1e-8
FINE_BENDING = np.array([1e-6, 1e-9, 1e-6, 1e-9])
"""Change of deflections in mm and tilts in rad of the seats that is round-off."""
FINE_FORCES = 1e-7
"""Change of the forces of a step relative to their sum."""
ERROR_OF_LAW, MAX_ERROR_OF_LAW, ERROR_OF_CELLS = 0.03, 1e-2, 1e-3
"""Error of the law of friction relative to the residual of the position before, its largest one, and the residual
that other cells give an equilibrium."""
MAX_COARSER = 2.5
"""Strips relative to those of other cells up to which derivatives of creep forces serve there too."""
FIRST_TIME, FIRST_TIME_ROLLING, MIN_TIME, MAX_TIME = 50.0, 5.0, 0.25, 5e8
"""Time of the first step of a search without friction and with it, and its bounds, see `LinearWheelset`."""
MIN_FALL, SENSE = 1e-3, 2.0
"""Least ratio of residuals by which the time changes, and the factor on it by the sense of the steps."""
TOP = 1e-6
"""Step relative to its limits that is round-off."""
MAX_YAW_RAD, MAX_CREEPAGE = 2e-3, 4e-3
"""Step limits of the yaw, and of the rate of rotation over itself."""
N_UNKNOWNS, BENDING, RATE, DIFFERENCE, YAW = 10, slice(3, 7), 7, 8, 9
"""Numbers of the unknowns behind the position: deflection and tilt of the left and the right seat, and with friction
the rate of rotation, the difference of the wheels' rates (right less left), and the yaw."""


class RollingPlace(NamedTuple):
    """Where a wheelset stands: position of the axle's middle, bending at both wheels, rates of rotation, and yaw.

    Without friction the rate is 0, and of wheels that are joined the difference of their rates.
    """

    lateral_mm: float
    vertical_mm: float
    roll_rad: float
    left_deflection_mm: float
    left_tilt_rad: float
    right_deflection_mm: float
    right_tilt_rad: float
    rate_rad_s: float
    rate_difference_rad_s: float
    yaw_rad: float

    @classmethod
    def at(cls, position: WheelsetPosition, bending: Floats, rates: tuple[float, float], yaw: float) -> "RollingPlace":
        """Place at a position of the axle's middle with deflection and tilt of the left and the right seat, (4,)."""
        return cls(*map(float, (*position.components, *bending, *rates, yaw)))

    @classmethod
    def of(cls, equilibrium: Equilibrium[SpatialState]) -> "RollingPlace":
        """Place of an equilibrium; without friction it has no yaw of its own, and no rate."""
        rolled, bending = equilibrium.state.rolled, bending_of(equilibrium.state.sides)
        if rolled is None:
            return cls.at(equilibrium.position, bending, (0.0, 0.0), 0.0)
        rates = rolled.rate_rad_s, rolled.rate_difference_rad_s or 0.0
        return cls.at(equilibrium.position, bending, rates, rolled.yaw_rad)

    def rate_of(self, side: Side) -> float:
        """Rate of rotation of the wheel of a side."""
        return self.rate_rad_s + SIDE_SIGN[side] * self.rate_difference_rad_s / 2.0

    def moved(self, step: Floats) -> "RollingPlace":
        """Place after a step of all unknowns, (10,)."""
        return RollingPlace(*np.add(self, step).tolist())

    @property
    def position(self) -> WheelsetPosition:
        """Position of the axle's middle."""
        return WheelsetPosition(*self[:3])

    @property
    def bending(self) -> Floats:
        """Deflection and tilt of the left and the right seat, (4,)."""
        return np.array(self[BENDING])


class Pace(NamedTuple):
    """Time of the last step of a search, and this step relative to its limits, (10,)."""

    time: float
    step: Floats


@dataclass(frozen=True, eq=False)
class WheelsetNewton:
    """A wheelset while its equilibrium is sought, a value: what a step passes on to the next.

    - `compliance`: of the axle at its seats, (4, 4).
    - `rolls`: whether there are creep forces.
    - `sides`: contact of both sides; on cells from which no step was taken yet, of bodies that bend no further.
    - `creep`, `slopes`: creep forces of the step before, and how they change.
    - `errors`: equilibrium residuals of the positions on these cells, and the last one on those before.
    - `hanging`: steps in a row in which a wheel does not touch its rail.
    - `pace`: of the search.
    """

    problem: WheelsetProblem
    compliance: Floats
    place: RollingPlace
    rolls: bool
    pace: Pace
    sides: Mapping[Side, SideNewton] = field(default_factory=dict)
    creep: Mapping[Side, SideCreep] = field(default_factory=dict)
    slopes: Mapping[Side, CreepSlopes] = field(default_factory=dict)
    errors: tuple[float, ...] = (1.0,)
    hanging: int = 0

    @classmethod
    def of(
        cls,
        problem: WheelsetProblem,
        compliance: Floats,
        place: RollingPlace,
        grids: Mapping[Side, GriddedSide],
        near: SpatialState | None = None,
        *,
        rolls: bool = False,
    ) -> "WheelsetNewton":
        """A wheelset at a place, from a contact close by if there is one."""
        if problem.wheelset.wheels == "joined":
            place = place._replace(rate_difference_rad_s=0.0)
        pace = Pace(FIRST_TIME_ROLLING if rolls else FIRST_TIME, np.zeros(N_UNKNOWNS))
        return cls(problem, compliance, place, rolls, pace).on(grids, near)

    def on(self, grids: Mapping[Side, GriddedSide], near: SpatialState | None) -> "WheelsetNewton":
        """The same on other cells, from a contact if it is known."""
        sides = dict(self.sides)
        slopes = {
            side: slopes.on_cells(self.sides[side].grid.grid, grids[side].grid)
            for side, slopes in self.slopes.items()
            if self.sides[side].grid.grid.strip <= MAX_COARSER * grids[side].grid.strip
        }
        rolled = None if near is None else near.rolled
        for side, grid in grids.items():
            if near is not None and side in sides and grid is sides[side].grid:
                continue  # its contact is known
            forces: Floats | float = 0.0
            creep: Floats | float = 0.0
            opened: Floats | float = 0.0
            if near is not None:
                before = near.sides[side]
                forces, creep = transferred(before, grid), transferred_creep(before, grid)
                if rolled is not None:
                    increase = rolled.creep[side].gap_increase
                    opened = interpolated(increase, before.grid.grid.middles, grid.grid.middles)
            sides[side] = SideNewton.of(grid, self.pose_of(side), forces, creep, opened, rolls=self.rolls)
        return replace(
            self,
            sides=sides,
            slopes=slopes,
            creep=self.creep if rolled is None else rolled.creep,
            errors=(max(self.errors[-1], ERROR_OF_CELLS),),
        )

    def pose_of(self, side: Side) -> WheelPose:
        """Pose of a wheel, see `pose_of`."""
        return pose_of(self.problem, self.place.position, side, self.place.yaw_rad, self.place.bending)

    @property
    def motion(self) -> RollingMotion | None:
        """How the wheelset rolls; None where friction does not count."""
        return self.problem.rolling if self.rolls else None

    @property
    def turn_independently(self) -> bool:
        """Whether both wheels roll at rates of their own."""
        return self.rolls and self.problem.wheelset.wheels == "independent"

    @property
    def contact(self) -> SpatialState:
        """Contact of both sides."""
        return SpatialState({side: newton.state for side, newton in self.sides.items()})

    @property
    def way_left(self) -> float:
        """Way across the track to the lateral position that is prescribed, mm; 0 without one."""
        lateral = self.problem.position.lateral_mm
        return 0.0 if lateral is None else lateral - self.place.lateral_mm

    @property
    def reaches_an_end(self) -> bool:
        """Whether a patch has come to an end of its cells."""
        return any(side.grid.cuts(side.forces) for side in self.sides.values())

    def _derivatives_still_valid(self, tolerance: float) -> bool:
        """Whether three more steps with these derivatives of creep forces would be enough: new ones cost as much."""
        if len(self.errors) < 3:
            return True
        before, error = self.errors[-2:]
        return error**4 <= tolerance * before**3

    def linearised(self, tolerance: float) -> "LinearWheelset":
        """Residuals and their derivatives at the place.

        - `tolerance`: equilibrium residual that is asked for.
        """
        sides = {side: newton.linearised(self.pose_of(side)) for side, newton in self.sides.items()}
        creep, slopes = dict(self.creep), dict(self.slopes) if self._derivatives_still_valid(tolerance) else {}
        if self.rolls:
            # the law of friction need not hold better than the equilibrium
            error = float(np.clip(ERROR_OF_LAW * self.errors[-1], TOLERANCE, MAX_ERROR_OF_LAW))
            for side, newton in sides.items():
                theory = WheelsetCreep(self.problem, self.place.rate_of(side), error)
                normal, (forces, _) = np.zeros(newton.forces.shape), newton.solved
                normal[newton.touching] = np.maximum(forces, 0.0)
                now = creep[side] = theory.of_side(side, newton, normal, creep.get(side))
                slopes[side] = slopes.get(side) or theory.derivatives(side, newton, normal, now)
                sides[side] = newton.bent(now.resultant, now.rows, now.gap_increase, forces, slopes[side])
        hanging = 0 if all(side.touching.any() for side in sides.values()) else self.hanging + 1
        return LinearWheelset.of(replace(self, sides=sides, creep=creep, slopes=slopes, hanging=hanging))


@dataclass(frozen=True, eq=False)
class LinearWheelset:
    """A wheelset linearised at a place.

    - `newton`: the wheelset there; the last of its `errors` is the residual here.
    - `residual`: what is left of the equations: force and moment on the wheelset, bending of the axle, torque, yaw
      moment, (10,).
    - `jacobian`: its derivatives by `RollingPlace`, (10, 10).
    - `torque_Nmm`, `yaw_moment_Nmm`: of contact and creep forces.
    """

    newton: WheelsetNewton
    residual: Floats
    jacobian: Floats
    relative: RelativeResiduals
    torque_Nmm: float  # noqa: N815 (units in names)
    yaw_moment_Nmm: float  # noqa: N815

    @classmethod
    def of(cls, newton: WheelsetNewton) -> "LinearWheelset":
        """The equations ``R + dR/dq dq = 0`` of a wheelset whose sides are linearised."""
        problem, place, compliance = newton.problem, newton.place, newton.compliance
        total = np.zeros((N_UNKNOWNS, 1 + N_UNKNOWNS))  # R in the first column, dR/dq behind it
        for side, side_newton in newton.sides.items():
            sign, motion = signs_of(side), np.pad(motions_of(side), ((1, 0), (1, 0)))
            motion[0, 0] = 1.0
            normal, creep = (values @ motion for values in side_newton.resultants)
            wrench = normal + creep[[0, 1, 5]]
            total[:3] += sign[:, None] * wrench
            total[RATE] += creep[6]
            total[DIFFERENCE] += sign[0] * creep[6] / 2.0
            total[YAW] -= sign[0] * (creep[4] + side_newton.yaw_moment @ motion)
            # tau - C s = 0 with the forces on the seats in the track's axes
            _, by_resultant, by_motion = on_seat(side_newton.pose, wrench[:, 0])
            on_seats = by_resultant @ wrench + by_motion @ motion[1:6]
            total[BENDING] -= compliance[:, seat_of(side)] @ (sign[1::-1, None] * on_seats)
        on_wheels, (torque, yaw_moment) = total[:3, 0].copy(), total[[RATE, YAW], 0].tolist()
        load, relative = with_loads(problem, place.position, on_wheels)
        total[:3, 0] = load
        total[2, 3] += moment_by_roll(problem, place.roll_rad)
        total[BENDING, 0] += place.bending
        total[BENDING, 1:][:, BENDING] += np.eye(4)
        total[[RATE, DIFFERENCE, YAW]] *= newton.rolls
        if (rolling := newton.motion) is not None:
            total[RATE, 0] += rolling.torque
            total[YAW, 0] -= rolling.yaw_stiffness * (place.yaw_rad - problem.position.yaw_rad)
            total[YAW, 1 + YAW] -= rolling.yaw_stiffness
            weight, arm = problem.forces.vertical_N, problem.wheels.distance_mm / 2.0
            relative = replace(
                relative,
                torque_residual=math.hypot(total[RATE, 0], newton.turn_independently * total[DIFFERENCE, 0])
                / (weight * problem.wheels.tape_radius_mm),
                yaw_residual=float(total[YAW, 0]) / (weight * arm) * rolling.yaw_is_free,
            )
        newton = replace(newton, errors=(*newton.errors, relative.equilibrium_residual))
        return cls(newton, total[:, 0], total[:, 1:], relative, torque, yaw_moment)

    @property
    def free(self) -> Bools:
        """Which of the unknowns are sought, (10,)."""
        rolling, position = self.newton.motion, self.newton.problem.position.components
        yaws = rolling is not None and rolling.yaw_is_free
        rates = rolling is not None, self.newton.turn_independently
        return np.array([*(value is None for value in position), *[True] * 4, *rates, yaws])

    def step(self, tolerance: float) -> tuple[WheelsetNewton, bool]:
        """The wheelset after Newton's step within its limits, and whether it was in equilibrium."""
        newton, share = self.newton, tolerance / FINE_RESIDUAL
        step, pace = self._stable_step()
        taken = {side: one.taken(motions_of(side) @ step) for side, one in newton.sides.items()}
        most = share * FINE_FORCES
        moving = (
            any(side.creep_is_limited for side in newton.sides.values())
            or newton.way_left != 0.0
            or (most < COARSE_FORCES and any(side.changed for side in newton.sides.values()))
        )
        bends = bool((np.abs(self.residual[BENDING]) > share * FINE_BENDING).any())
        settled = self.relative.equilibrium_residual <= tolerance and not (bends or moving)
        settled = settled and all(change <= most for _, change in taken.values())
        sides = {side: one for side, (one, _) in taken.items()}
        return replace(newton, place=newton.place.moved(step), sides=sides, pace=pace), settled

    def _stable_step(self) -> tuple[Floats, Pace]:
        """Step within its limits towards an equilibrium that the wheelset does not leave, and the pace after it.

        With the residual R and its derivatives J the unknowns follow ``M dq/dt = R`` by an implicit Euler step of the
        time T, ``(M / T - J) dq = R`` (pseudo-transient continuation, Kelley and Keyes 1998). M is a force or a moment
        over the limit of a step; the axle's bending has none. As T grows it is Newton's step; it goes where the
        wheelset is pushed as long as 1 / T is above all real eigenvalues of ``M^-1 J``: it is at least twice the
        largest one. T grows as the residual falls and while steps keep their sense.
        """
        newton, problem, free, errors = self.newton, self.newton.problem, self.free, self.newton.errors
        arm, radius = problem.wheels.distance_mm / 2.0, problem.wheels.tape_radius_mm
        rate = MAX_CREEPAGE * newton.place.rate_rad_s if newton.rolls else 1.0
        limits = np.array([*MAX_STEP, *2 * (MAX_STEP[1], MAX_STEP[2]), rate, rate, MAX_YAW_RAD])
        mass = problem.forces.vertical_N * np.array([1.0, 1.0, arm, *NOT_BENT, radius, radius, arm]) / limits
        time = min(newton.pace.time * max(errors[-2] / max(errors[-1], 1e-300), MIN_FALL), MAX_TIME)
        driven = np.flatnonzero(free & (mass > 0.0))
        rates = np.linalg.eigvals(self.condensed(driven) / mass[driven, None])
        leaving = 2.0 * float(rates.real[rates.imag == 0.0].max(initial=0.0))
        step = np.zeros(N_UNKNOWNS)
        step[0] = np.clip(newton.way_left, -limits[0], limits[0])
        matrix = np.diag(max(1.0 / time, leaving) * mass) - self.jacobian
        right = self.residual + self.jacobian[:, 0] * step[0]
        step[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free])
        step /= max(float((np.abs(step) / limits).max()), 1.0)
        if leaving > 0.0 and not newton.rolls and free[0] and (np.abs(step) < TOP * limits).all():
            step[0] = -limits[0] / 2.0  # on top of the energy both ways lead down: to the left, whatever round-off says
        ways = step / limits
        time *= SENSE if ways @ newton.pace.step >= 0.0 else 1.0 / SENSE
        return step, Pace(max(time, MIN_TIME), ways)

    def condensed(self, unknowns: Ints) -> Floats:
        """Derivatives of the residual by some unknowns where the axle bends with them."""
        jacobian = self.jacobian
        bends = np.linalg.solve(jacobian[BENDING, BENDING], jacobian[BENDING, unknowns])
        condensed: Floats = jacobian[np.ix_(unknowns, unknowns)] - jacobian[unknowns, BENDING] @ bends
        return condensed

    def equilibrium(self, newton: WheelsetNewton, status: Status) -> Equilibrium[SpatialState]:
        """What there is after a step."""
        rolled = stable = None
        if newton.rolls:
            place, moments = newton.place, (self.yaw_moment_Nmm, self.torque_Nmm)
            difference = place.rate_difference_rad_s if newton.turn_independently else None
            rolled = RolledWheelset(newton.creep, place.rate_rad_s, place.yaw_rad, *moments, difference)
        elif self.free[:3].all():
            stable = is_stable(newton.problem, self.condensed(np.arange(3)))
        state = replace(newton.contact, rolled=rolled)
        return Equilibrium(status, newton.place.position, self.relative, state, self.residual[:3], stable)
