"""Equilibrium of a wheelset in three dimensions by Newton's method, without friction or with creep forces.

Unknown are the position, deflections and tilts of the axle's seats, and with friction the rate of rotation about the
axle and, if it is not prescribed, the yaw. The derivatives are those of `SideNewton` and of `WheelsetCreep`. What a
step passes on is a value: `WheelsetNewton.linearised` has its equations, `LinearWheelset.step` what comes after it.
"""

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
    Reach,
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
from flangeway.types import Bools, Floats


@dataclass(frozen=True, eq=False)
class RolledWheelset:
    """What rolling adds to an equilibrium.

    - `creep`: creep forces of both sides in their right-hand forms.
    - `rate_rad_s`: rate of rotation about the axle.
    - `yaw_rad`: yaw of the axle.
    - `yaw_moment_Nmm`: of contact and creep forces on the wheelset, counter-clockwise from above.
    - `torque_Nmm`: of creep forces about the axle, > 0 where they drive it.
    """

    creep: Mapping[Side, SideCreep]
    rate_rad_s: float
    yaw_rad: float
    yaw_moment_Nmm: float  # noqa: N815 (units in names)
    torque_Nmm: float  # noqa: N815


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
    """How a side moves by `MOTIONS` as the unknowns change, (7, 9)."""
    sign, motions = SIDE_SIGN[side], np.zeros((len(MOTIONS), N_UNKNOWNS))
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
MAX_GROWTH, HALVED = 4.0, 0.25
"""Largest step across the track relative to its limit; the part to which a step lowers the residual that goes well."""
SADDLE = 1e-6
"""Push on the unknown that leads relative to its stiffness, in mm or rad, that is round-off."""
MIN_STIFFNESS = 1e-6
"""Of a wheel that does not touch, weight per mm, so that it goes where it is pushed; also for rate and yaw."""
ERROR_OF_LAW, MAX_ERROR_OF_LAW, ERROR_OF_CELLS = 0.03, 1e-2, 1e-3
"""Error of the law of friction relative to the residual of the position before, its largest one, and the residual
that other cells give an equilibrium."""
MAX_COARSER = 2.5
"""Strips relative to those of other cells up to which derivatives of creep forces serve there too."""
DIRECT = 4.0
"""See `_leads`."""
MAX_YAW_RAD, MAX_CREEPAGE = 1e-3, 2e-3
"""Step limits of the yaw, and of the rate of rotation over itself."""
N_UNKNOWNS, BENDING, RATE, YAW = 9, slice(3, 7), 7, 8
"""Numbers of the unknowns behind the position: deflection and tilt of the left and the right seat, and with friction
the rate of rotation and the yaw."""


class RollingPlace(NamedTuple):
    """Where a wheelset stands: position of the axle's middle, bending at both wheels, rate of rotation, and yaw.

    Without friction the rate is 0.
    """

    lateral_mm: float
    vertical_mm: float
    roll_rad: float
    left_deflection_mm: float
    left_tilt_rad: float
    right_deflection_mm: float
    right_tilt_rad: float
    rate_rad_s: float
    yaw_rad: float

    @classmethod
    def at(cls, position: WheelsetPosition, bending: Floats, rate: float, yaw: float) -> "RollingPlace":
        """Place at a position of the axle's middle with deflection and tilt of the left and the right seat, (4,)."""
        return cls(*map(float, (*position.components, *bending, rate, yaw)))

    @classmethod
    def of(cls, equilibrium: Equilibrium[SpatialState]) -> "RollingPlace":
        """Place of an equilibrium; without friction it has no yaw of its own, and no rate."""
        rolled, bending = equilibrium.state.rolled, bending_of(equilibrium.state.sides)
        motion = (0.0, 0.0) if rolled is None else (rolled.rate_rad_s, rolled.yaw_rad)
        return cls.at(equilibrium.position, bending, *motion)

    def moved(self, step: Floats) -> "RollingPlace":
        """Place after a step of all unknowns, (9,)."""
        return RollingPlace(*np.add(self, step).tolist())

    @property
    def position(self) -> WheelsetPosition:
        """Position of the axle's middle."""
        return WheelsetPosition(*self[:3])

    @property
    def bending(self) -> Floats:
        """Deflection and tilt of the left and the right seat, (4,)."""
        return np.array(self[BENDING])


@dataclass(frozen=True, eq=False)
class WheelsetNewton:
    """A wheelset while its equilibrium is sought, a value: what a step passes on to the next.

    - `compliance`: of the axle at its seats, (4, 4).
    - `rolls`: whether there are creep forces.
    - `sides`: contact of both sides; on cells from which no step was taken yet, of bodies that bend no further.
    - `creep`, `slopes`: creep forces of the step before, and how they change.
    - `errors`: equilibrium residuals of the positions on these cells, and the last one on those before.
    - `hanging`: steps in a row in which a wheel does not touch its rail.
    - `reaches`: step limits across the track, and with friction of rate and yaw: surfaces that slip everywhere have no
      slope that leads back.
    """

    problem: WheelsetProblem
    compliance: Floats
    place: RollingPlace
    rolls: bool
    reaches: Mapping[int, Reach]
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
        across = {0: Reach(float(MAX_STEP[0]), MAX_GROWTH * float(MAX_STEP[0]))}
        return cls(problem, compliance, place, rolls, across).on(grids, near)

    def on(self, grids: Mapping[Side, GriddedSide], near: SpatialState | None) -> "WheelsetNewton":
        """The same on other cells, from a contact if it is known."""
        across, sides, reaches = self.reaches[0], dict(self.sides), dict[int, Reach]()
        if len(self.errors) > 1:  # steps were taken on the cells before
            across = across.again(float(MAX_STEP[0]))
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
        if self.rolls:
            rate = MAX_CREEPAGE * self.place.rate_rad_s
            reaches = {RATE: Reach(rate, rate), YAW: Reach(MAX_YAW_RAD, MAX_YAW_RAD)}
        return replace(
            self,
            sides=sides,
            slopes=slopes,
            creep=self.creep if rolled is None else rolled.creep,
            errors=(max(self.errors[-1], ERROR_OF_CELLS),),
            reaches={0: across} | reaches,
        )

    def pose_of(self, side: Side) -> WheelPose:
        """Pose of a wheel, see `pose_of`."""
        return pose_of(self.problem, self.place.position, side, self.place.yaw_rad, self.place.bending)

    @property
    def motion(self) -> RollingMotion | None:
        """How the wheelset rolls; None where friction does not count."""
        return self.problem.rolling if self.rolls else None

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

    @property
    def is_halved(self) -> bool:
        """Whether the last step has lowered the residual much: its derivatives still serve, and its direction does."""
        return len(self.errors) > 2 and self.errors[-1] < HALVED * self.errors[-2]

    def _derivatives_still_valid(self, tolerance: float) -> bool:
        """Whether three more steps with these derivatives of creep forces would be enough: new ones cost as much."""
        if len(self.errors) < 3:
            return True
        before, error = self.errors[-2:]
        return self.is_halved and error * (error / before) ** 3 <= tolerance

    def linearised(self, tolerance: float) -> "LinearWheelset":
        """Residuals and their derivatives at the place.

        - `tolerance`: equilibrium residual that is asked for.
        """
        sides = {side: newton.linearised(self.pose_of(side)) for side, newton in self.sides.items()}
        creep, slopes = dict(self.creep), dict(self.slopes) if self._derivatives_still_valid(tolerance) else {}
        if self.rolls:
            # the law of friction need not hold better than the equilibrium
            error = float(np.clip(ERROR_OF_LAW * self.errors[-1], TOLERANCE, MAX_ERROR_OF_LAW))
            theory = WheelsetCreep(self.problem, self.place.rate_rad_s, error)
            for side, newton in sides.items():
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
      moment, (9,).
    - `jacobian`: its derivatives by `RollingPlace`, (9, 9).
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
        total[[RATE, YAW]] *= newton.rolls
        if (rolling := newton.motion) is not None:
            total[RATE, 0] += rolling.torque
            total[YAW, 0] -= rolling.yaw_stiffness * (place.yaw_rad - problem.position.yaw_rad)
            total[YAW, 1 + YAW] -= rolling.yaw_stiffness
            weight, arm = problem.forces.vertical_N, problem.wheels.distance_mm / 2.0
            relative = replace(
                relative,
                torque_residual=float(total[RATE, 0]) / (weight * problem.wheels.tape_radius_mm),
                yaw_residual=float(total[YAW, 0]) / (weight * arm) * rolling.yaw_is_free,
            )
        newton = replace(newton, errors=(*newton.errors, relative.equilibrium_residual))
        return cls(newton, total[:, 0], total[:, 1:], relative, torque, yaw_moment)

    @property
    def free(self) -> Bools:
        """Which of the unknowns are sought, (9,)."""
        rolling, position = self.newton.motion, self.newton.problem.position.components
        yaws = rolling is not None and rolling.yaw_is_free
        return np.array([*(value is None for value in position), *[True] * 4, rolling is not None, yaws])

    @property
    def unlimited_step(self) -> Floats:
        """Newton's step of all unknowns, without limits."""
        (step,) = _solved(self.jacobian, -self.residual[:, None], self.free, self.free)
        return step

    def step(self, tolerance: float) -> tuple[WheelsetNewton, bool]:
        """The wheelset after Newton's step within its limits, and whether it was in equilibrium."""
        newton, share = self.newton, tolerance / FINE_RESIDUAL
        step, reaches = self._limited_step()
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
        return replace(newton, place=newton.place.moved(step), sides=sides, reaches=reaches), settled

    def _limited_step(self) -> tuple[Floats, Mapping[int, Reach]]:
        """Newton's step, limited so that the wheelset goes where it is pushed.

        The rest of the unknowns is eliminated: what is left of the equation across the track at a fixed lateral
        position is the slope of the energy along it, and its sign is the direction in which the wheelset moves.
        With friction and a free yaw there are three such pairs of an unknown that leads and an equation, see `_leads`.
        """
        n, free, rolls, reaches = N_UNKNOWNS, self.free, self.newton.rolls, dict(self.newton.reaches)
        problem, across, halved = self.newton.problem, bool(free[0]), self.newton.is_halved
        limits = np.array([*MAX_STEP, *2 * (MAX_STEP[1], MAX_STEP[2]), np.inf, MAX_YAW_RAD])
        columns, rows = free.copy(), free.copy()
        arm, radius = problem.wheels.distance_mm / 2.0, problem.wheels.tape_radius_mm
        turning = radius / self.newton.place.rate_rad_s if rolls else 0.0
        least = np.array([1.0, 1.0, arm**2, *NOT_BENT, turning, arm])
        jacobian = self.jacobian - np.diag(MIN_STIFFNESS * problem.forces.vertical_N * least)
        lead, row = 0, 0
        if across and free[YAW]:
            assert self.newton.motion is not None
            lead, row = _leads(jacobian, free, self.newton.motion.yaw_stiffness)
        sense = 1.0 if lead == row else -1.0
        columns[lead] = False
        if across:
            rows[row] = False
        right = -np.stack((self.residual, self.jacobian[:, lead]), axis=1)
        step, by_lead = _solved(jacobian, right, rows, columns)
        # an unknown whose step is limited goes where it is pushed, and the rest comes into equilibrium all the same:
        # without friction the energy falls that way, and moments of wheels that slip everywhere hardly depend on rate
        # and yaw; with creep forces it holds for these alone, also where friction that falls turns their slope over
        numbers = np.arange(n)
        pushed = columns & rows & ((numbers < BENDING.start) if not rolls else numbers >= RATE)
        wanted = step.copy()
        if rolls:
            for number in numbers[pushed]:
                if self._turns_over(jacobian, step, rows, columns, number):
                    wanted[number] = np.copysign(np.inf, self.residual[number])
            for number in (RATE, YAW):
                if pushed[number]:  # not a yaw that leads, or that balances the lateral force
                    reaches[number] = reaches[number].towards(float(wanted[number]), halved=halved)
                    limits[number] = reaches[number].limit
        limited = pushed & (np.abs(wanted) > limits)
        if limited.any():
            part = np.where(limited, np.copysign(limits, self.residual), 0.0)
            right[:, 0] -= jacobian @ part
            step, by_lead = _solved(jacobian, right, rows & ~limited, columns & ~limited)
            step += part
        excess = float((np.abs(step) / limits).max())
        if excess > 1.0:
            return step / excess, _after(reaches, step / excess)
        way = self.newton.way_left
        if across:
            push = sense * float(self.residual[row] + self.jacobian[row] @ step)
            slope = sense * float(self.jacobian[row, lead] + self.jacobian[row] @ by_lead)
            way = -push / slope if slope < 0.0 else float(np.copysign(np.inf, push))
            if slope >= 0.0 and abs(push) < SADDLE * abs(self.jacobian[row, lead]):
                # on top of the energy both ways lead down: to the left, whatever round-off says; friction has no energy
                way = -np.inf if not rolls else 0.0
        reach = reaches[lead].towards(way, halved=halved)
        way = float(np.clip(way, -reach.limit, reach.limit))
        reaches[lead] = replace(reach, last=way)
        by_lead[lead], limits[lead] = 1.0, np.inf
        step += way * by_lead
        step /= max(float((np.abs(step) / limits).max()), 1.0)
        return step, _after(reaches, step)

    def _turns_over(self, jacobian: Floats, step: Floats, rows: Bools, columns: Bools, number: int) -> bool:
        """Whether Newton's step of an unknown goes against the push on it where the rest is in equilibrium.

        Its equation rises with it there: an equilibrium ahead would be one that the wheelset leaves.
        """
        rest = np.arange(len(step)) != number
        (held,) = _solved(jacobian, -self.residual[:, None], rows & rest, columns & rest)
        return bool((self.residual[number] + jacobian[number] @ held) * step[number] < 0.0)

    @property
    def condensed(self) -> Floats:
        """Derivatives of the residual by the position where the axle bends with it, (3, 3)."""
        jacobian = self.jacobian
        bends = np.linalg.solve(jacobian[BENDING, BENDING], jacobian[BENDING, :3])
        condensed: Floats = jacobian[:3, :3] - jacobian[:3, BENDING] @ bends
        return condensed

    def equilibrium(self, newton: WheelsetNewton, status: Status) -> Equilibrium[SpatialState]:
        """What there is after a step."""
        rolled = stable = None
        if newton.rolls:
            place = newton.place
            rolled = RolledWheelset(newton.creep, place.rate_rad_s, place.yaw_rad, self.yaw_moment_Nmm, self.torque_Nmm)
        elif self.free[:3].all():
            stable = is_stable(newton.problem, self.condensed)
        state = replace(newton.contact, rolled=rolled)
        return Equilibrium(status, newton.place.position, self.relative, state, self.residual[:3], stable)


def _solved(jacobian: Floats, right: Floats, rows: Bools, columns: Bools) -> Floats:
    """Solutions of some equations for some unknowns, the others 0, one for each right-hand side (n, k); (k, n)."""
    solutions = np.zeros(right.shape[::-1])
    solutions[:, columns] = np.linalg.solve(jacobian[np.ix_(rows, columns)], right[rows]).T
    return solutions


def _after(reaches: Mapping[int, Reach], step: Floats) -> dict[int, Reach]:
    """Step limits after a step; that across remembers the way that it would go without the limits of the others."""
    return {number: replace(reach, last=float(step[number])) if number else reach for number, reach in reaches.items()}


def _leads(jacobian: Floats, free: Bools, yaw_stiffness: float) -> tuple[int, int]:
    """Which unknown goes where the wheelset is pushed, as all others follow, and the equation that pushes it.

    By the derivatives of lateral force and yaw moment by displacement across and yaw where the other unknowns follow:

    - Where the flange holds the wheelset across, so that a step of the yaw changes the lateral force by less than a
      step across, the yaw goes where its moment pushes it.
    - Where guidance and flange hold both, and the product of their stiffnesses is larger than that of the other
      derivatives, the wheelset goes across where the lateral force pushes it.
    - Else yaw balances the lateral force by creepage, and the wheelset goes across where the yaw moment leads it.
      Where both products are alike (`DIRECT`) the tangent is nearly singular, and it turns to the rolling line by the
      sign of the moment. Creep forces alone hold no yaw: they are limited.
    """
    both, rest = [0, YAW], np.flatnonzero(free)
    rest = rest[(rest != 0) & (rest != YAW)]
    follow = np.linalg.solve(jacobian[np.ix_(rest, rest)], jacobian[np.ix_(rest, both)])
    (by_x, by_yaw), (moment_by_x, _) = jacobian[np.ix_(both, both)] - jacobian[np.ix_(both, rest)] @ follow
    stiffness = max(-by_x, 0.0)
    if abs(by_yaw) * MAX_YAW_RAD < stiffness * MAX_STEP[0]:
        return YAW, YAW
    direct = stiffness * yaw_stiffness
    return 0, 0 if -direct < by_yaw * moment_by_x < direct / DIRECT else YAW
