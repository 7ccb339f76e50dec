"""Positions in which rigid wheels on rigid rails bear a load without friction: the rigid answer beside the elastic one.

Along the positions in which both wheels touch, the potential of the load has a derivative; where it passes through zero
the wheelset is in balance. A point of contact that jumps makes the derivative jump: if it passes through zero there,
the side touches in two points, and three normal forces follow from the three equations of balance.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.railway.rigid.rigid_contact import (
    PATH_MM,
    PATH_STEP_MM,
    Intervals,
    RigidWheelset,
    Settled,
    locus_of,
    path_of_contact,
    settle,
)
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.railway.track.placements import SIDES, Side, WheelsetMotion
from flangeway.railway.track.wheelset_load import Load
from flangeway.solve import Status
from flangeway.types import Floats

BALANCED = 1e-5
"""Maximum residual force over the load at which the normal forces count as in equilibrium."""

NEUTRAL_MM = 1.0
"""Length from which positions that all are in equilibrium count as one, which is neutral."""

_TOGETHER_MM = 1e-7  # gap below which a further place touches as well
_PRECISION_MM = 1e-13
_SECTIONS = 32
_NEAR_MM = 1e-6
_ONE_POINT_MM = 1e-2


@dataclass(frozen=True)
class RigidContactPoint:
    """A point of contact of a wheelset in balance.

    Parameters
    ----------
    side
        Side of the track.
    wheel_point_mm, rail_point_mm
        In the frames of the profiles, in the right-hand form on both sides.
    point_mm
        In the track's axes.
    contact_angle_rad
        Angle of the common tangent from the track's plane, positive towards the flange.
    rolling_radius_mm
        Distance from the axle.
    relative_curvature_per_mm
        Sum of the curvatures of wheel and rail, convex positive.
    normal_force_N
        Force, >= 0.
    ahead_mm
        Distance along the track by which the point is ahead of the axle, zero without yaw.

    """

    side: Side
    wheel_point_mm: tuple[float, float]
    rail_point_mm: tuple[float, float]
    point_mm: tuple[float, float]
    contact_angle_rad: float
    rolling_radius_mm: float
    relative_curvature_per_mm: float
    normal_force_N: float  # noqa: N815
    ahead_mm: float = 0.0

    @property
    def force_on_wheel_N(self) -> tuple[float, float]:  # noqa: N802
        """Force on the wheel in the track's axes."""
        sign = -1.0 if self.side == "right" else 1.0
        return (
            sign * self.normal_force_N * math.sin(self.contact_angle_rad),
            self.normal_force_N * math.cos(self.contact_angle_rad),
        )

    def hertz(self, thickness_mm: float, contact_modulus_MPa: float) -> LineContact | None:
        """Elastic estimate by Hertz's line contact per thickness; None without force or between conforming curves."""
        if not (self.normal_force_N > 0.0 and self.relative_curvature_per_mm > 0.0):
            return None
        return LineContact(self.normal_force_N / thickness_mm, self.relative_curvature_per_mm, contact_modulus_MPa)


@dataclass(frozen=True, eq=False)
class RigidPosition:
    """A position in which the forces balance.

    Parameters
    ----------
    motion
        Motion of the axle's middle in the track's axes.
    motion_in_space
        The same along horizontal and vertical.
    contacts
        Points of contact that bear force, left side first.
    stable
        Whether the wheelset comes back after a small push.
    residual
        Residual of the balance over the load; above `BALANCED` no compressive forces balance the load.
    neutral_mm
        Least and maximum lateral motion of the axle's middle between which every position is in equilibrium, as for
        cylinders; None where the equilibrium is a single position.

    """

    motion: WheelsetMotion
    motion_in_space: WheelsetMotion
    contacts: tuple[RigidContactPoint, ...]
    stable: bool
    residual: float
    neutral_mm: tuple[float, float] | None = None

    @property
    def carries(self) -> bool:
        """Whether compressive forces balance the load."""
        return self.residual <= BALANCED

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's forces in the track's axes, positive if the rail is pushed outward; nan if none."""
        forces = np.array([point.force_on_wheel_N for point in self.contacts if point.side == side]).reshape(-1, 2)
        total = forces.sum(axis=0)
        if not total[1] > 0.0:
            return math.nan
        return float(total[0] / total[1]) * (-1.0 if side == "right" else 1.0)


@dataclass(frozen=True, eq=False)
class RigidEquilibrium:
    """RelativeResiduals of a rigid wheelset under a load.

    Parameters
    ----------
    outcome
        The balance that the wheelset reaches from the middle of the track; without one the error that says why.
    positions
        All balances between climbing flanges, from left to right.
    load_ratio
        Force along the track over force onto it, L/V of the axle.

    """

    outcome: RigidPosition | InputError
    positions: tuple[RigidPosition, ...]
    load_ratio: float

    @property
    def position(self) -> RigidPosition | None:
        """The balance that is reached; None if there is none."""
        return None if isinstance(self.outcome, InputError) else self.outcome

    @property
    def status(self) -> Status:
        """Whether there is a balance that the wheelset reaches from the middle of the track; if not, why."""
        if isinstance(self.outcome, InputError):
            error = self.outcome
            return Status(False, f"{error.given}; allowed is {error.allowed}; {error.advice}", 0)
        # no sign before a zero
        lateral, n_points = round(self.outcome.motion.lateral_mm, 3) + 0.0, len(self.outcome.contacts)
        where = f"at a lateral motion of {lateral:.3f} mm on {n_points} points"
        if self.outcome.neutral_mm is not None:
            low, high = self.outcome.neutral_mm
            return Status(
                True,
                f"in neutral equilibrium, which nothing but friction holds, between {low:.2f} and {high:.2f} mm; shown "
                f"{where}",
                0,
            )
        return Status(True, f"in balance {where}", 0)

    def reached(self) -> RigidPosition:
        """Return the balance that is reached.

        Raises
        ------
        InputError
            If there is none: the load overturns the wheelset, or carries a flange over its rail.

        """
        if isinstance(self.outcome, InputError):
            raise self.outcome
        return self.outcome


def rigid_equilibrium(wheelset: RigidWheelset, load: Load, *, reached_only: bool = False) -> RigidEquilibrium:
    """Find all positions in which a load is in balance, and the one that is reached from the middle.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    load
        Forces at the centre of gravity.
    reached_only
        Whether only the one that is reached is looked for.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails.

    """
    path = path_of_contact(wheelset, PATH_MM)
    along, onto = load.in_track
    derivative = _derivative(wheelset, path, load) / onto
    candidates = _candidates(derivative)
    reached = _reached(derivative, int(np.argmin(np.abs(path.rail_level))), candidates)
    chosen = candidates if not reached_only else [candidates[reached]] if reached is not None else []
    positions = _positions(wheelset, load, path, chosen)
    position = None if reached is None else positions[0 if reached_only else reached]
    outcome: RigidPosition | InputError
    if position is None:
        outcome = _derailment(path, held_ratios(wheelset, path), along / onto)
    elif not position.carries:
        outcome = _overturning(wheelset, position, along / onto)
    else:
        outcome = position
    return RigidEquilibrium(outcome, tuple(each for each in positions if each.carries), along / onto)


class _Candidate(NamedTuple):
    """Positions of the path between which the derivative passes through zero, or is zero all along."""

    first: int
    last: int
    stops: bool  # whether a wheelset that arrives stays
    neutral: bool


def _candidates(derivative: Floats) -> list[_Candidate]:
    """Where the derivative over the load is zero along the path of contact, in order."""
    still = np.concatenate(([False], np.abs(derivative) <= BALANCED, [False]))
    starts, ends = np.flatnonzero(still[1:] & ~still[:-1]), np.flatnonzero(still[:-1] & ~still[1:]) - 1
    found = [
        _Candidate(int(start), int(end), True, True)
        for start, end in zip(starts, ends, strict=True)
        if (end - start) * PATH_STEP_MM >= NEUTRAL_MM
    ]
    rising = derivative >= 0.0
    for place in np.flatnonzero(rising[1:] != rising[:-1]).tolist():
        if all(place + 1 < each.first or place > each.last for each in found if each.neutral):
            found.append(_Candidate(place, place + 1, bool(rising[place + 1]), False))
    return sorted(found)


def _positions(wheelset: RigidWheelset, load: Load, path: Settled, candidates: list[_Candidate]) -> list[RigidPosition]:
    """Forces and points of contact at candidates."""
    if not candidates:
        return []
    first, last = (np.array([each[i] for each in candidates]) for i in (0, 1))
    neutral = np.array([each.neutral for each in candidates])
    ends = Intervals(
        np.stack((path.rail_level[first], path.rail_level[last]), axis=1),
        np.stack((path.roll[first], path.roll[last]), axis=1),
    )
    # a neutral equilibrium is shown as near to the middle as it goes
    level = np.clip(0.0, ends.level[:, 0], ends.level[:, 1])
    found = Intervals(np.stack((level, level), axis=1), ends.roll.copy())
    if not neutral.all():
        zeros = _zeros(wheelset, load, Intervals(*(each[~neutral] for each in ends)))
        found.level[~neutral], found.roll[~neutral] = zeros
    # a little to both sides as well: between conforming arcs the contact is decided by rounding at the jump itself
    levels, rolls = (np.concatenate((each, each), axis=1) for each in found)
    levels += np.array([0.0, 0.0, -_NEAR_MM, _NEAR_MM])
    settled = settle(wheelset, levels.T.ravel(), roll=rolls.T.ravel(), gaps=True)
    lateral = ends.level - wheelset.reference_height_mm * np.sin(ends.roll)
    count = len(candidates)
    return [
        _position(wheelset, load, settled, range(i, i + 1 if each.neutral else 4 * count, count), each, lateral[i])
        for i, each in enumerate(candidates)
    ]


def _slopes(wheelset: RigidWheelset, path: Settled) -> tuple[Floats, Floats]:
    """Vertical motion and roll per lateral motion of the point at the rails' height, along the touching positions."""
    height = path.lift - wheelset.reference_height_mm * np.cos(path.roll)
    slopes, arms = [], []
    for touches, sign in ((path.right, 1.0), (path.left, -1.0)):
        slope = sign * np.tan(touches.angle[:, 0])
        slopes.append(slope)
        arms.append(sign * touches.x[:, 0] - path.rail_level + slope * (touches.y[:, 0] - height))
    roll = (slopes[0] - slopes[1]) / (arms[0] - arms[1])
    return slopes[0] - roll * arms[0], roll


def _work(wheelset: RigidWheelset, path: Settled) -> tuple[Floats, Floats]:
    """Lift and lateral motion of the centre of gravity per lateral motion at the rails' height."""
    vertical, roll = _slopes(wheelset, path)
    height = wheelset.reference_height_mm + wheelset.centre_of_gravity_height_mm
    return vertical - roll * height * np.sin(path.roll), 1.0 - roll * height * np.cos(path.roll)


def _derivative(wheelset: RigidWheelset, path: Settled, load: Load) -> Floats:
    """Derivative of the load's potential along the path."""
    along, onto = load.in_track
    lift, lateral = _work(wheelset, path)
    return onto * lift - along * lateral


def held_ratios(wheelset: RigidWheelset, path: Settled) -> Floats:
    """Ratio of lateral to vertical force at the centre of gravity in equilibrium at each position, nan where none is.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    path
        Positions in which both wheels touch.

    """
    lift, lateral = _work(wheelset, path)
    return np.where(lateral > 1e-3, lift / np.where(lateral > 1e-3, lateral, 1.0), np.nan)


def _zeros(wheelset: RigidWheelset, load: Load, pairs: Intervals) -> Intervals:
    """Narrow intervals in which the derivative passes through zero, by continuous change or by a jump."""
    rows = np.arange(len(pairs.level))
    while float(np.diff(pairs.level, axis=1).max()) > _PRECISION_MM:
        grid = pairs.divided(_SECTIONS)
        settled = settle(wheelset, grid.level.ravel(), roll=grid.roll.ravel())
        rising = _derivative(wheelset, settled, load).reshape(grid.level.shape) >= 0.0
        column = np.argmax(rising[:, 1:] != rising[:, :-1], axis=1)
        found = settled.pairs(rows * grid.level.shape[1] + column)
        if np.array_equal(found.level, pairs.level):
            break  # neighbours among the numbers of the machine
        pairs = found
    return pairs


def _reached(derivative: Floats, middle: int, candidates: list[_Candidate]) -> int | None:
    """Number of the first candidate downhill from the middle at which a wheelset stays."""
    falls = derivative[middle] < 0.0
    numbered = list(enumerate(candidates))
    for number, each in numbered if falls else reversed(numbered):
        beyond = each.first >= middle if falls else each.first < middle
        if (each.stops and beyond) or (each.neutral and each.first <= middle <= each.last):
            return number
    return None


def _position(
    wheelset: RigidWheelset, load: Load, found: Settled, ends: range, candidate: _Candidate, lateral: Floats
) -> RigidPosition:
    """Forces and points of contact at a candidate; of a zero positions about it, so that both points of a jump are."""
    locus = locus_of(wheelset, found)
    motion = locus.motion(ends[0])
    points = _points(locus, ends)
    along, onto = load.in_track
    height = wheelset.reference_height_mm + motion.vertical_mm
    centre_of_gravity = (
        motion.lateral_mm - wheelset.centre_of_gravity_height_mm * math.sin(motion.roll_rad),
        height + wheelset.centre_of_gravity_height_mm * math.cos(motion.roll_rad),
    )
    columns = []
    for point in points:
        x, y = point.force_on_wheel_N
        moment = (point.point_mm[0] - centre_of_gravity[0]) * y - (point.point_mm[1] - centre_of_gravity[1]) * x
        columns.append((x, y, moment / height))
    forces, rest = nnls(np.array(columns).T, np.array([-along, onto, 0.0]) / onto)
    bearing = tuple(
        replace(point, normal_force_N=float(force) * onto) for point, force in zip(points, forces, strict=True)
    )
    cosine, sine = math.cos(load.tilt_rad), math.sin(load.tilt_rad)
    in_space = WheelsetMotion(
        cosine * motion.lateral_mm - sine * motion.vertical_mm,
        sine * motion.lateral_mm + cosine * motion.vertical_mm,
        motion.roll_rad,
    )
    kept = tuple(point for point in bearing if point.normal_force_N > 1e-9 * onto)
    neutral = (float(lateral[0]), float(lateral[1])) if candidate.neutral else None
    return RigidPosition(motion, in_space, kept, candidate.stops and not candidate.neutral, float(rest), neutral)


def _points(locus: ContactLocus, ends: range) -> list[RigidContactPoint]:
    """Points that touch in some of the positions, each with unit force."""
    points: list[RigidContactPoint] = []
    for side in SIDES:
        at = locus.side(side)
        seen: list[Floats] = []
        for number in ends:
            for place in np.flatnonzero(at.gaps_mm[number] < _TOGETHER_MM):
                on_wheel = at.wheel_points_mm[number, place]
                if any(float(np.hypot(*(on_wheel - other))) < _ONE_POINT_MM for other in seen):
                    continue
                seen.append(on_wheel)
                points.append(
                    RigidContactPoint(
                        side,
                        (float(on_wheel[0]), float(on_wheel[1])),
                        _pair(at.rail_points_mm[number, place]),
                        _pair(at.points_mm[number, place]),
                        float(at.contact_angles_rad[number, place]),
                        float(at.rolling_radii_mm[number, place]),
                        float(at.relative_curvatures_per_mm[number, place]),
                        1.0,
                        float(at.ahead_mm[number, place]),
                    )
                )
    return points


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _derailment(path: Settled, ratios: Floats, load_ratio: float) -> InputError:
    side = "right" if load_ratio >= 0.0 else "left"
    outer = path.right if side == "right" else path.left
    steepest = float(np.tan(np.nanmax(outer.angle[:, 0])))
    held = float(np.nanmax((1.0 if side == "right" else -1.0) * ratios))
    return InputError(
        f"a load of L/V {abs(load_ratio):.3f}, which is a derailment: the {side} flange climbs its rail",
        f"L/V up to {held:.3f}, which the contacts hold (flange angle {math.degrees(math.atan(steepest)):.1f} deg, no "
        "friction)",
        "lower the lateral force or the speed, or raise the superelevation",
    )


def _overturning(wheelset: RigidWheelset, position: RigidPosition, load_ratio: float) -> InputError:
    side = "right" if load_ratio >= 0.0 else "left"
    arm = max(abs(point.point_mm[0] - position.motion.lateral_mm) for point in position.contacts if point.side == side)
    height = wheelset.centre_of_gravity_height_mm + max(point.rolling_radius_mm for point in position.contacts)
    return InputError(
        f"a load of L/V {abs(load_ratio):.3f}, which is overturning about the {side} rail: the other wheel lifts",
        f"L/V up to {arm / height:.3f}, at which it lifts with this height of the centre of gravity",
        "lower the lateral force, the speed or the centre of gravity, or raise the superelevation",
    )
