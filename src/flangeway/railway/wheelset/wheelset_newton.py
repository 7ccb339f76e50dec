"""Equilibrium of a wheelset in three dimensions by Newton's method, without friction or with creep forces.

Unknown are the position, deflections and tilts of the axle's seats, and with friction the rate of rotation about the
axle and, if it is not prescribed, the yaw. The derivatives are those of `SideNewton` and of `WheelsetCreep`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import (
    MAX_STEP,
    Equilibrium,
    Reach,
    is_stable,
    moment_by_roll,
    with_loads,
)
from flangeway.railway.wheelset.rolling.wheelset_creep import TOLERANCE, SideCreep, WheelsetCreep, patches_of
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, WheelPose
from flangeway.railway.wheelset.side_newton import CreepSlopes, SideNewton, interpolated, transferred, transferred_creep
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
BENDING, RATE, YAW = slice(3, 7), 7, 8
"""Numbers of the unknowns behind the position: deflection and tilt of the left and the right seat, and with friction
the rate of rotation and the yaw."""


class WheelsetNewton:
    """A wheelset while its equilibrium is sought."""

    def __init__(
        self,
        problem: WheelsetProblem,
        grids: Mapping[Side, GriddedSide],
        position: WheelsetPosition,
        compliance: Floats,
        near: SpatialState | None,
        creep: WheelsetCreep | None,
    ) -> None:
        self.problem, self.compliance = problem, compliance
        self.position, self.yaw = position, problem.position.yaw_rad
        self.creep = creep
        if near is None:
            self.bending = bending_by_load(problem, compliance)
        else:
            self.yaw = SIDE_SIGN["left"] * near.sides["left"].pose.yaw_rad
            self.bending = bending_of(near.sides)
        self.sides: dict[Side, SideNewton] = {}
        self._slopes: dict[Side, CreepSlopes] = {}
        self.errors = [1.0]
        """Equilibrium residuals of the positions on these cells, and the last one on those before."""
        self.across = Reach(float(MAX_STEP[0]), MAX_GROWTH * float(MAX_STEP[0]))
        self.hanging = 0
        """Steps in a row in which a wheel does not touch its rail."""
        self.place(grids, near)
        rolls, prescribed = creep is not None, problem.position.components
        yaws = creep is not None and creep.motion.yaw_is_free
        self.free = np.array([*(value is None for value in prescribed), *[True] * 4, rolls, yaws])
        arm, radius = problem.wheels.distance_mm / 2.0, problem.wheels.tape_radius_mm
        turning = [0.0 if creep is None else radius / creep.rate_rad_s, arm]
        least = np.array([1.0, 1.0, arm**2, *NOT_BENT, *turning])
        self._least = np.diag(MIN_STIFFNESS * problem.forces.vertical_N * least)

    def place(self, grids: Mapping[Side, GriddedSide], near: SpatialState | None) -> None:
        """Go on with other cells, from a contact if it is known."""
        if len(self.errors) > 1:  # steps were taken on the cells before
            self.across = self.across.again(float(MAX_STEP[0]))
        self.errors = [max(self.errors[-1], ERROR_OF_CELLS)]
        self._slopes = {
            side: slopes.on_cells(self.sides[side].grid.grid, grids[side].grid)
            for side, slopes in self._slopes.items()
            if self.sides[side].grid.grid.strip <= MAX_COARSER * grids[side].grid.strip
        }
        for side, grid in grids.items():
            if near is not None and side in self.sides and grid is self.sides[side].grid:
                continue  # its contact is known
            pose = pose_of(self.problem, self.position, side, self.yaw, self.bending)
            if near is None:
                self.sides[side] = SideNewton(grid, pose, rolls=self.creep is not None)
                continue
            before, gap_increase = (
                near.sides[side],
                None if near.rolled is None else near.rolled.creep[side].gap_increase,
            )
            self.sides[side] = SideNewton(
                grid,
                pose,
                transferred(before, grid),
                transferred_creep(before, grid),
                0.0
                if gap_increase is None
                else interpolated(gap_increase, before.grid.grid.middles, grid.grid.middles),
                rolls=self.creep is not None,
            )
        self.reaches: dict[int, Reach] = {}
        """Step limits of rate and yaw: surfaces that slip everywhere have no slope that leads back."""
        if self.creep is not None:
            if near is not None and near.rolled is not None:
                self.creep.before = near.rolled.creep
            rate = MAX_CREEPAGE * self.creep.rate_rad_s
            self.reaches = {RATE: Reach(rate, rate), YAW: Reach(MAX_YAW_RAD, MAX_YAW_RAD)}

    @property
    def contact(self) -> SpatialState:
        """Contact of both sides; on cells from which no step was taken yet, of bodies that bend no further."""
        return SpatialState({side: newton.state for side, newton in self.sides.items()})

    @property
    def yaw_stiffness(self) -> float:
        """Stiffness of the guidance of a yaw that is found, N mm per rad."""
        return 0.0 if self.creep is None else self.creep.motion.yaw_stiffness

    @property
    def way_left(self) -> float:
        """Way across the track to the lateral position that is prescribed, mm; 0 without one."""
        lateral = self.problem.position.lateral_mm
        return 0.0 if lateral is None else lateral - self.position.lateral_mm

    @property
    def creep_is_limited(self) -> bool:
        """Whether creep forces that were found still bend the bodies in part only."""
        return any(side.creep_is_limited for side in self.sides.values())

    @property
    def reaches_an_end(self) -> bool:
        """Whether a patch has come to an end of its cells."""
        return any(side.grid.cuts(side.forces) for side in self.sides.values())

    @property
    def _is_halved(self) -> bool:
        """Whether the last step has lowered the residual much: its derivatives still serve, and its direction does."""
        return len(self.errors) > 2 and self.errors[-1] < HALVED * self.errors[-2]

    def _serve(self, tolerance: float) -> bool:
        """Whether three more steps with these derivatives of creep forces would be enough: new ones cost as much."""
        if len(self.errors) < 3:
            return True
        before, error = self.errors[-2:]
        return self._is_halved and error * (error / before) ** 3 <= tolerance

    def linearise(self, tolerance: float) -> None:
        """Take residuals and their derivatives at the position.

        - `tolerance`: equilibrium residual that is wanted.
        """
        n = len(self.free)
        if self.creep is not None:  # the law of friction need not hold better than the equilibrium
            if not self._serve(tolerance):
                self._slopes.clear()
            self.creep.tolerance = float(np.clip(ERROR_OF_LAW * self.errors[-1], TOLERANCE, MAX_ERROR_OF_LAW))
        total, self.jacobian, seats = np.zeros(3), np.zeros((n, n)), np.zeros(4)
        self.resultants: dict[Side, Floats] = {}
        self.changes: dict[Side, tuple[Floats, Floats, Floats, list[int]]] = {}
        self.rolled: dict[Side, SideCreep] = {}
        self.turning = 0.0  # yaw moment of normal forces
        self.creep_now, self.creeping = np.zeros(5), np.zeros((5, n))
        jacobian = self.jacobian
        for side, newton in self.sides.items():
            newton.linearise(pose_of(self.problem, self.position, side, self.yaw, self.bending))
            forces, by = newton.solve()
            if self.creep is not None:
                self._bent_by_creep(side, newton, forces)
                forces, by = newton.solve()
            signs = signs_of(side)
            by_signs = np.array([*signs, 1.0, signs[0], 1.0, signs[0]])
            columns = [0, 1, 2, *np.add(BENDING.start, seat_of(side)).tolist(), RATE, YAW]  # of `MOTIONS`
            normal, creep = newton.resultants(forces, by)
            self.resultants[side] = signs * normal
            self.changes[side] = forces, by, by_signs, columns
            slopes = signs[:, None] * newton.stiffness * by_signs
            jacobian[:3, columns] += slopes
            if self.creep is not None:
                slopes = slopes + self._add_creep(side, creep)
            total += self.resultants[side]
            to_track = np.array([1.0, signs[0]])
            forces_on_seat, by_resultant, by_motion = on_seat(newton.pose, signs * self.resultants[side])
            seats[seat_of(side)] = to_track * forces_on_seat
            slopes = by_resultant @ (signs[:, None] * slopes)
            slopes[:, :5] += by_motion * by_signs[:5]
            jacobian[BENDING, columns] -= self.compliance[:, seat_of(side)] @ (to_track[:, None] * slopes)
        jacobian[2, 2] += moment_by_roll(self.problem, self.position.roll_rad)
        jacobian[BENDING, BENDING] += np.eye(4)
        self.residual, self.relative = with_loads(self.problem, self.position, total)
        self.unbent = self.bending - self.compliance @ seats
        self.missed = np.concatenate((self.residual, self.unbent, np.zeros(2)))
        if self.creep is not None:
            self._add_equations(self.creep)
        self.errors.append(self.relative.equilibrium_residual)
        self.hanging = 0 if all(side.touching.any() for side in self.sides.values()) else self.hanging + 1

    def _bent_by_creep(self, side: Side, newton: SideNewton, forces: Floats) -> None:
        """Find creep forces under normal ones, and let them bend the bodies."""
        assert self.creep is not None
        normal = np.zeros(newton.forces.shape)
        normal[newton.touching] = np.maximum(forces, 0.0)
        creep = self.rolled[side] = self.creep.of_side(side, newton, normal)
        if side not in self._slopes:
            self._slopes[side] = self.creep.derivatives(side, newton, normal, creep)
        slopes = self._slopes[side]
        newton.bend(creep.resultant, creep.rows, creep.gap_increase, forces, slopes)

    def _add_creep(self, side: Side, creep: Floats) -> Floats:
        """Add creep forces of a side and what they change; derivatives of their resultant by `MOTIONS`, (3, 7)."""
        newton, to_track = self.sides[side], signs_of_creep(side)
        forces, by, by_signs, columns = self.changes[side]
        now, change = to_track @ creep, to_track @ newton.creep_stiffness * by_signs
        self.creeping[:, columns] += change
        self.creep_now += now
        self.resultants[side] = self.resultants[side] + now[:3]
        moment, slopes = newton.yaw_moment(forces, by * by_signs)
        self.turning -= SIDE_SIGN[side] * moment
        self.jacobian[YAW, columns] -= SIDE_SIGN[side] * slopes
        return np.asarray(change[:3])

    def _add_equations(self, creep: WheelsetCreep) -> None:
        """Add the equations of torque and yaw."""
        rolling, problem = creep.motion, self.problem
        self.jacobian[[0, 1, 2, RATE, YAW]] += self.creeping
        self.torque = float(self.creep_now[3])
        self.yaw_moment = float(self.creep_now[4]) + self.turning
        weight, arm = problem.forces.vertical_N, problem.wheels.distance_mm / 2.0
        driven, guided = self.torque + rolling.torque, 0.0
        if rolling.yaw_is_free:
            guided = self.yaw_moment - self.yaw_stiffness * (self.yaw - problem.position.yaw_rad)
            self.jacobian[YAW, YAW] -= self.yaw_stiffness
        self.missed[[RATE, YAW]] = driven, guided
        self.relative = replace(
            self.relative,
            torque_residual=driven / (weight * problem.wheels.tape_radius_mm),
            yaw_residual=guided / (weight * arm),
        )

    @property
    def _limits(self) -> Floats:
        """Step limits."""
        return np.array([*MAX_STEP, *2 * (MAX_STEP[1], MAX_STEP[2]), np.inf, MAX_YAW_RAD])

    def _step(self) -> Floats:
        """Newton's step, limited so that the wheelset goes where it is pushed.

        The rest of the unknowns is eliminated: what is left of the equation across the track at a fixed lateral
        position is the slope of the energy along it, and its sign is the direction in which the wheelset moves.
        With friction and a free yaw there are three such pairs of an unknown that leads and an equation, see `_leads`.
        """
        n, across = len(self.free), bool(self.free[0])
        limits = self._limits
        columns, rows = self.free.copy(), self.free.copy()
        jacobian = self.jacobian - self._least
        lead, row = 0, 0
        if across and self.free[YAW]:
            lead, row = _leads(jacobian, self.free, self.yaw_stiffness)
        sense = 1.0 if lead == row else -1.0
        columns[lead] = False
        if across:
            rows[row] = False
        right = -np.stack((self.missed, self.jacobian[:, lead]), axis=1)
        step, by_lead = _solved(jacobian, right, rows, columns)
        # an unknown whose step is limited goes where it is pushed, and the rest comes into equilibrium all the same:
        # without friction the energy falls that way, and moments of wheels that slip everywhere hardly depend on rate
        # and yaw; with creep forces it holds for these alone, also where friction that falls turns their slope over
        numbers = np.arange(n)
        pushed = columns & rows & ((numbers < BENDING.start) if self.creep is None else numbers >= RATE)
        wanted = step.copy()
        if self.creep is not None:
            for number in numbers[pushed]:
                if self._turns_over(jacobian, step, rows, columns, number):
                    wanted[number] = np.copysign(np.inf, self.missed[number])
            for number, reach in self.reaches.items():
                if pushed[number]:  # not a yaw that leads, or that balances the lateral force
                    limits[number] = reach.limit_of(float(wanted[number]), halved=self._is_halved)
        limited = pushed & (np.abs(wanted) > limits)
        if limited.any():
            part = np.where(limited, np.copysign(limits, self.missed), 0.0)
            right[:, 0] -= jacobian @ part
            step, by_lead = _solved(jacobian, right, rows & ~limited, columns & ~limited)
            step += part
        excess = float((np.abs(step) / limits).max())
        if excess > 1.0:
            return step / excess
        way = self.way_left
        if across:
            push = sense * float(self.missed[row] + self.jacobian[row] @ step)
            slope = sense * float(self.jacobian[row, lead] + self.jacobian[row] @ by_lead)
            way = -push / slope if slope < 0.0 else float(np.copysign(np.inf, push))
            if slope >= 0.0 and abs(push) < SADDLE * abs(self.jacobian[row, lead]):
                # on top of the energy both ways lead down: to the left, whatever round-off says; friction has no energy
                way = -np.inf if self.creep is None else 0.0
        reach = self.reaches[YAW] if lead else self.across
        limit = reach.limit_of(way, halved=self._is_halved)
        reach.last = way = float(np.clip(way, -limit, limit))
        by_lead[lead], limits[lead] = 1.0, np.inf
        step += way * by_lead
        return step / max(float((np.abs(step) / limits).max()), 1.0)

    def _turns_over(self, jacobian: Floats, step: Floats, rows: Bools, columns: Bools, number: int) -> bool:
        """Whether Newton's step of an unknown goes against the push on it where the rest is in equilibrium.

        Its equation rises with it there: an equilibrium ahead would be one that the wheelset leaves.
        """
        rest = np.arange(len(step)) != number
        (held,) = _solved(jacobian, -self.missed[:, None], rows & rest, columns & rest)
        return bool((self.missed[number] + jacobian[number] @ held) * step[number] < 0.0)

    @property
    def unlimited_step(self) -> Floats:
        """Newton's step of all unknowns, without limits."""
        (step,) = _solved(self.jacobian, -self.missed[:, None], self.free, self.free)
        return step

    def step(self, tolerance: float) -> bool:
        """Move by Newton's step within its limits; whether it was in equilibrium."""
        share = tolerance / FINE_RESIDUAL
        error = self.relative.equilibrium_residual
        step = self._step()
        change = 0.0
        for side, (forces, by, by_signs, columns) in self.changes.items():
            side_step = by_signs * step[columns]
            change = max(change, self.sides[side].take(forces + by @ side_step, side_step))
        most = share * FINE_FORCES
        moving = (
            self.creep_is_limited
            or self.way_left != 0.0
            or (most < COARSE_FORCES and any(side.changed for side in self.sides.values()))
        )
        bends = bool((np.abs(self.unbent) > share * FINE_BENDING).any())
        self.position = self.position.moved(WheelsetPosition(*step[:3].tolist()))
        self.bending = self.bending + step[BENDING]
        if self.creep is not None:
            for number, reach in self.reaches.items():
                reach.last = float(step[number])
            self.creep.rate_rad_s += float(step[RATE])
            self.yaw += float(step[YAW])
        return error <= tolerance and change <= most and not (bends or moving)

    @property
    def condensed(self) -> Floats:
        """Derivatives of the residual by the position where the axle bends with it, (3, 3)."""
        jacobian = self.jacobian
        bends = np.linalg.solve(jacobian[BENDING, BENDING], jacobian[BENDING, :3])
        condensed: Floats = jacobian[:3, :3] - jacobian[:3, BENDING] @ bends
        return condensed

    def equilibrium(self, status: Status) -> Equilibrium[SpatialState]:
        """What there is now."""
        rolled = stable = None
        if self.creep is not None:
            rolled = RolledWheelset(self.rolled, self.creep.rate_rad_s, self.yaw, self.yaw_moment, self.torque)
        elif self.free[:3].all():
            stable = is_stable(self.problem, self.condensed)
        state = replace(self.contact, rolled=rolled)
        return Equilibrium(status, self.position, self.relative, state, self.residual, stable)


def _solved(jacobian: Floats, right: Floats, rows: Bools, columns: Bools) -> Floats:
    """Solutions of some equations for some unknowns, the others 0, one for each right-hand side (n, k); (k, n)."""
    solutions = np.zeros(right.shape[::-1])
    solutions[:, columns] = np.linalg.solve(jacobian[np.ix_(rows, columns)], right[rows]).T
    return solutions


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


def signs_of_creep(side: Side) -> Floats:
    """From `SideCreep.resultant` to force (x, y), moment, torque and yaw moment in the track's axes, (5, 7)."""
    sign = SIDE_SIGN[side]
    signs = np.zeros((5, 7))
    signs[0, 0], signs[1, 1], signs[2, 5], signs[3, 6], signs[4, 4] = sign, 1.0, sign, 1.0, -sign
    return signs
