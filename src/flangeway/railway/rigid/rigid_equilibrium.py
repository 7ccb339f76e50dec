"""Equilibria of rigid wheels on rigid rails, by themselves and as the start of the elastic search."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Placement
from flangeway.geometry.arrays import norms
from flangeway.railway.rigid.rigid_geometry import (
    CLIMBED_MM,
    PATH_STEP_MM,
    ContactLocus,
    Intervals,
    RigidGeometry,
    TouchingPositions,
    levers,
)
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition, lateral_over_vertical
from flangeway.railway.track.wheelset_loads import WheelsetLoad
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.solve import Status
from flangeway.types import Bools, Floats

# --- Equilibria of rigid wheels on rigid rails under a load without friction.
#
# Along the positions in which both wheels touch, the potential of the load has a derivative; where it passes through
# zero the wheelset is in equilibrium. A point of contact that jumps makes the derivative jump: if it passes through
# zero there, the side touches in two points, and three normal forces follow from the three equations of equilibrium.


MAX_RESIDUAL = 1e-5  # maximum residual force relative to the load in equilibrium
NEUTRAL_MM = 1.0  # least length of the positions of a neutral equilibrium
_TOGETHER_MM = 1e-7  # gap below which a further point touches as well
_PRECISION_MM = 1e-13
_POSITION_TOLERANCE_MM = 1e-6
_ONE_POINT_MM = 1e-2


@dataclass(frozen=True)
class RigidContactPoint:
    """A point of contact of a wheelset in equilibrium.

    - `wheel_point_mm`, `rail_point_mm`: in the frames of the profiles, in the right-hand form on both sides.
    - `point_mm`: in the track's axes.
    - `contact_angle_rad`: angle of the common tangent from the track's plane, positive towards the flange.
    - `rolling_radius_mm`: distance from the axle.
    - `relative_curvature_per_mm`: sum of the curvatures of wheel and rail, convex positive.
    - `normal_force_N`: force, >= 0.
    - `ahead_mm`: longitudinal distance by which the point is ahead of the axle, zero without yaw.
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
        return (
            -SIDE_SIGN[self.side] * self.normal_force_N * math.sin(self.contact_angle_rad),
            self.normal_force_N * math.cos(self.contact_angle_rad),
        )

    def hertz(self, thickness_mm: float, contact_modulus_MPa: float) -> LineContact | None:
        """Elastic estimate by Hertz's line contact per thickness; None without force or between conforming curves."""
        if not (self.normal_force_N > 0.0 and self.relative_curvature_per_mm > 0.0):
            return None
        return LineContact(self.normal_force_N / thickness_mm, self.relative_curvature_per_mm, contact_modulus_MPa)


@dataclass(frozen=True, eq=False)
class RigidPosition:
    """A position in which the forces are in equilibrium.

    - `motion`: displacement of the axle's middle in the track's axes.
    - `motion_in_space`: its horizontal and vertical components, and the roll.
    - `contacts`: points of contact with a force, left side first.
    - `stable`: whether the wheelset comes back after a small push.
    - `residual`: equilibrium residual over the load; above `MAX_RESIDUAL` no compressive forces carry the load.
    - `neutral_mm`: least and maximum lateral displacement of the axle's middle between which every position is in
      equilibrium, as for cylinders; None where the equilibrium is a single position.
    """

    motion: WheelsetPosition
    motion_in_space: WheelsetPosition
    contacts: tuple[RigidContactPoint, ...]
    stable: bool
    residual: float
    neutral_mm: tuple[float, float] | None = None

    @property
    def carries(self) -> bool:
        """Whether compressive forces carry the load."""
        return self.residual <= MAX_RESIDUAL

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's forces in the track's axes, positive if the rail is pushed outward; nan if none."""
        forces = np.array([point.force_on_wheel_N for point in self.contacts if point.side == side]).reshape(-1, 2)
        return lateral_over_vertical(forces.sum(axis=0), side)


@dataclass(frozen=True, eq=False)
class RigidEquilibrium:
    """Equilibria of a rigid wheelset under a load.

    - `outcome`: the equilibrium that the wheelset reaches from the middle of the track; without one the error with the
      reason.
    - `positions`: all equilibria between climbing flanges, from left to right.
    - `load_ratio`: lateral over vertical force in the track's axes, L/V of the axle.
    """

    outcome: RigidPosition | InputError
    positions: tuple[RigidPosition, ...]
    load_ratio: float

    @property
    def position(self) -> RigidPosition | None:
        """The equilibrium that is reached; None if there is none."""
        return None if isinstance(self.outcome, InputError) else self.outcome

    @property
    def status(self) -> Status:
        """Whether there is an equilibrium that the wheelset reaches from the middle of the track; if not, why."""
        if isinstance(self.outcome, InputError):
            error = self.outcome
            return Status(False, f"{error.given}; allowed is {error.allowed}; {error.advice}", 0)
        # no sign before a zero
        lateral, n_points = round(self.outcome.motion.lateral_mm, 3) + 0.0, len(self.outcome.contacts)
        where = f"at a lateral displacement of {lateral:.3f} mm on {n_points} points"
        if self.outcome.neutral_mm is not None:
            low, high = self.outcome.neutral_mm
            return Status(
                True,
                f"in neutral equilibrium between {low:.2f} and {high:.2f} mm, without friction; shown {where}",
                0,
            )
        return Status(True, "in equilibrium " + where, 0)

    def reached(self) -> RigidPosition:
        """Return the equilibrium that is reached.

        An `InputError` if there is none: the load overturns the wheelset, or carries a flange over its rail.
        """
        if isinstance(self.outcome, InputError):
            raise self.outcome
        return self.outcome


def rigid_equilibrium(geometry: RigidGeometry, load: WheelsetLoad) -> RigidEquilibrium:
    """Find all equilibria under a load, and the one that is reached from the middle of the track.

    Parameters
    ----------
    geometry
        Wheels and rails.
    load
        Forces at the centre of gravity.

    Raises
    ------
    InputError
        As `RigidGeometry.path`.
    """
    path = geometry.path()
    along, onto = load.in_track
    derivative = _derivative(geometry, path, load) / onto
    candidates = _candidates(derivative)
    reached = _reached(derivative, int(np.argmin(np.abs(path.rail_level))), candidates)
    positions = _positions(geometry, load, path, candidates)
    position = None if reached is None else positions[reached]
    outcome: RigidPosition | InputError
    if position is None:
        outcome = _beyond_reach(geometry, path, load, along / onto)
    elif not position.carries:
        outcome = _overturning(load, position, along / onto)
    else:
        outcome = position
    return RigidEquilibrium(outcome, tuple(position for position in positions if position.carries), along / onto)


class _Candidate(NamedTuple):
    """Positions of the path between which the derivative passes through zero, or is zero all along."""

    first: int
    last: int
    stops: bool  # whether a wheelset that arrives stays
    neutral: bool


def _candidates(derivative: Floats) -> list[_Candidate]:
    """Where the derivative over the load is zero along the path of contact, in order."""
    still = np.concatenate(([False], np.abs(derivative) <= MAX_RESIDUAL, [False]))
    starts, ends = np.flatnonzero(still[1:] & ~still[:-1]), np.flatnonzero(still[:-1] & ~still[1:]) - 1
    candidates = [
        _Candidate(int(start), int(end), True, True)
        for start, end in zip(starts, ends, strict=True)
        if (end - start) * PATH_STEP_MM >= NEUTRAL_MM
    ]
    rising = derivative >= 0.0
    for row in np.flatnonzero(rising[1:] != rising[:-1]).tolist():
        if all(row + 1 < candidate.first or row > candidate.last for candidate in candidates if candidate.neutral):
            candidates.append(_Candidate(row, row + 1, bool(rising[row + 1]), False))
    return sorted(candidates)


def _positions(
    geometry: RigidGeometry, load: WheelsetLoad, path: TouchingPositions, candidates: list[_Candidate]
) -> list[RigidPosition]:
    """Forces and points of contact at candidates."""
    if not candidates:
        return []
    first, last = (np.array([candidate[i] for candidate in candidates]) for i in (0, 1))
    neutral = np.array([candidate.neutral for candidate in candidates])
    ends = Intervals(
        np.stack((path.rail_level[first], path.rail_level[last]), axis=1),
        np.stack((path.roll[first], path.roll[last]), axis=1),
    )
    # a neutral equilibrium is shown as near to the middle as it goes
    level = np.clip(0.0, ends.level[:, 0], ends.level[:, 1])
    interval_levels, interval_rolls = np.stack((level, level), axis=1), ends.roll.copy()
    if not neutral.all():
        zeros = _zeros(geometry, load, Intervals(*(end[~neutral] for end in ends)))
        interval_levels[~neutral], interval_rolls[~neutral] = zeros
    # a little to both sides as well: between conforming arcs the contact is decided by rounding at the jump itself
    levels, rolls = (np.concatenate((bounds, bounds), axis=1) for bounds in (interval_levels, interval_rolls))
    levels += np.array([0.0, 0.0, -_POSITION_TOLERANCE_MM, _POSITION_TOLERANCE_MM])
    settled = geometry.touching(levels.T.ravel(), roll=rolls.T.ravel(), gaps=True)
    lateral = ends.level - geometry.reference_height_mm * np.sin(ends.roll)
    count = len(candidates)
    return [
        _position(
            geometry, load, settled, range(i, i + 1 if candidate.neutral else 4 * count, count), candidate, lateral[i]
        )
        for i, candidate in enumerate(candidates)
    ]


def _work(geometry: RigidGeometry, path: TouchingPositions, load: WheelsetLoad) -> tuple[Floats, Floats]:
    """Lift and lateral displacement of the centre of gravity per lateral displacement at the rails' height."""
    slopes, arms = levers(geometry.reference_height_mm, path)
    roll = (slopes[0] - slopes[1]) / (arms[0] - arms[1])
    vertical = slopes[0] - roll * arms[0]
    height, offset = geometry.reference_height_mm + load.height_mm, load.offset_mm
    sine, cosine = np.sin(path.roll), np.cos(path.roll)
    return (
        vertical - roll * height * sine + roll * offset * cosine,
        1.0 - roll * height * cosine - roll * offset * sine,
    )


def _derivative(geometry: RigidGeometry, path: TouchingPositions, load: WheelsetLoad) -> Floats:
    """Derivative of the load's potential along the path."""
    along, onto = load.in_track
    lift, lateral = _work(geometry, path, load)
    return onto * lift - along * lateral


def held_ratios(geometry: RigidGeometry, path: TouchingPositions, load: WheelsetLoad) -> Floats:
    """Lateral over vertical force at the centre of gravity in equilibrium at each position, nan where none is.

    - `path`: positions in which both wheels touch.
    - `load`: where it acts.
    """
    lift, lateral = _work(geometry, path, load)
    return np.where(lateral > 1e-3, lift / np.where(lateral > 1e-3, lateral, 1.0), np.nan)


def _zeros(geometry: RigidGeometry, load: WheelsetLoad, pairs: Intervals) -> Intervals:
    """Narrow intervals in which the derivative passes through zero, by continuous change or by a jump."""

    def first_change(positions: TouchingPositions, shape: tuple[int, ...]) -> Bools:
        rising = _derivative(geometry, positions, load).reshape(shape) >= 0.0
        changes = rising[:, 1:] != rising[:, :-1]
        columns = np.arange(shape[1] - 1)
        return columns == np.argmax(changes, axis=1)[:, None]

    return geometry.narrowed(pairs, first_change, _PRECISION_MM)


def _reached(derivative: Floats, middle: int, candidates: list[_Candidate]) -> int | None:
    """Number of the first candidate downhill from the middle at which a wheelset stays."""
    falls = derivative[middle] < 0.0
    numbered = list(enumerate(candidates))
    for number, candidate in numbered if falls else reversed(numbered):
        beyond = candidate.first >= middle if falls else candidate.first < middle
        if (candidate.stops and beyond) or (candidate.neutral and candidate.first <= middle <= candidate.last):
            return number
    return None


def _position(
    geometry: RigidGeometry,
    load: WheelsetLoad,
    touching: TouchingPositions,
    ends: range,
    candidate: _Candidate,
    lateral: Floats,
) -> RigidPosition:
    """Forces and points of contact at a candidate; of a zero positions about it, so that both points of a jump are."""
    locus = geometry.located(touching)
    motion = locus.motion(ends[0])
    points = contact_points(locus, ends)
    along, onto = load.in_track
    height = geometry.reference_height_mm + motion.vertical_mm
    x, y = load.centre_of_gravity(motion.roll_rad)
    centre_of_gravity = motion.lateral_mm + x, height + y
    columns = []
    for point in points:
        x, y = point.force_on_wheel_N
        moment = (point.point_mm[0] - centre_of_gravity[0]) * y - (point.point_mm[1] - centre_of_gravity[1]) * x
        columns.append((x, y, moment / height))
    forces, remainder = nnls(np.array(columns).T, np.array([-along, onto, 0.0]) / onto)
    loaded = (replace(point, normal_force_N=float(force) * onto) for point, force in zip(points, forces, strict=True))
    kept = tuple(point for point in loaded if point.normal_force_N > 1e-9 * onto)
    neutral = (float(lateral[0]), float(lateral[1])) if candidate.neutral else None
    return RigidPosition(
        motion, motion.turned(load.tilt_rad), kept, candidate.stops and not candidate.neutral, float(remainder), neutral
    )


def contact_points(locus: ContactLocus, numbers: range) -> list[RigidContactPoint]:
    """Points that touch in some positions of a locus, left side first, each with unit force."""
    points: list[RigidContactPoint] = []
    for side in SIDES:
        at = locus.side(side)
        seen: list[Floats] = []
        for row, column in np.argwhere(at.gaps_mm[numbers] < _TOGETHER_MM):
            touch = numbers[row], column
            on_wheel = at.wheel_points_mm[touch]
            if all(float(norms(on_wheel - other)) >= _ONE_POINT_MM for other in seen):
                seen.append(on_wheel)
                columns = (at.contact_angles_rad, at.rolling_radii_mm, at.relative_curvatures_per_mm, at.ahead_mm)
                angle, radius, curvature, ahead = (float(array[touch]) for array in columns)
                wheel, on_rail, in_track = (
                    (float(x), float(y)) for x, y in (on_wheel, at.rail_points_mm[touch], at.points_mm[touch])
                )
                points.append(RigidContactPoint(side, wheel, on_rail, in_track, angle, radius, curvature, 1.0, ahead))
    return points


def _beyond_reach(
    geometry: RigidGeometry, path: TouchingPositions, load: WheelsetLoad, load_ratio: float
) -> InputError:
    """Why no position holds a load: the flange climbs, or the positions end before it does."""
    side: Side = "right" if load_ratio >= 0.0 else "left"
    held = float(np.nanmax(SIDE_SIGN[side] * held_ratios(geometry, path, load)))
    contact, flange = np.degrees([np.nanmax(path.side(side).angle[:, 0]), geometry.side(side).flange_angle_rad()])
    return InputError(
        f"a load of L/V {abs(load_ratio):.3f}, which no position holds: {geometry.path_end(side)}",
        f"L/V up to {held:.3f} without friction (contact angle up to {contact:.1f} deg, flange angle {flange:.1f} deg)",
        "lower the lateral force or the speed, raise the superelevation, or check profiles, gauge and back-to-back",
    )


def _overturning(load: WheelsetLoad, position: RigidPosition, load_ratio: float) -> InputError:
    side = "right" if load_ratio >= 0.0 else "left"
    arm = max(abs(point.point_mm[0] - position.motion.lateral_mm) for point in position.contacts if point.side == side)
    height = load.height_mm + max(point.rolling_radius_mm for point in position.contacts)
    return InputError(
        f"a load of L/V {abs(load_ratio):.3f}, which is overturning about the {side} rail: the other wheel lifts",
        f"L/V up to {arm / height:.3f}, at which it lifts with this height of the centre of gravity",
        "lower the lateral force, the speed or the centre of gravity, or raise the superelevation",
    )


# --- Rigid equilibrium as the start of the elastic search, and the points where the elastic bodies need a fine mesh.


FLANGE_MM = 1.0  # how much farther than a rigid one an elastic wheelset may go sideways
CLOSE_MM = 0.2  # gap in the rigid equilibrium that elastic bodies close

MARGIN_MM = 8.0
"""Gap in the rigid equilibrium within which a second point may come into contact: flanges may push the rails apart."""

END_MM = 2.0  # points nearer to the end of a running surface are where it ends, not where smooth curves come close

CLIMBING_RAD = math.radians(45.0)
"""Contact angle above which a rigid flange climbs; elastic rails deflect there, and no flange rises."""

MAX_DEFLECTION_MM = 20.0
"""Lateral displacement beyond that of rigid wheels that touch both rails, at which elastic ones surely do not."""

SCAN_MM = 0.1
"""Distance of the positions in which the contact angle is checked, up to a prescribed lateral displacement."""

Points = dict[str, Floats]
"""Points (n, 2) in the frame of the profile, by the part's name such as ``wheel-left``."""


@dataclass(frozen=True, eq=False)
class RigidStart:
    """A rigid wheelset in equilibrium under its load, or at the lateral displacement that is prescribed.

    Beyond the lateral displacement at which a rigid flange begins to climb it is where the flange does not climb yet:
    rigid rails would lift it by some millimetres, elastic ones deflect.

    - `geometry`: rigid geometry of the wheelset on its track.
    - `motion`: displacement of the axle's middle in the equilibrium that is reached, or at a prescribed lateral
      displacement, or before it where the flange does not climb yet.
    - `equilibrium`: all equilibria under the load; None at a prescribed lateral displacement.
    """

    geometry: RigidGeometry
    motion: WheelsetPosition
    equilibrium: RigidEquilibrium | None

    def can_reach(self, lateral_mm: float) -> bool:
        """Whether surfaces may meet at a lateral displacement, see `MAX_DEFLECTION_MM`."""
        low, high = self.geometry.limits(abs(lateral_mm))
        return low - MAX_DEFLECTION_MM <= lateral_mm <= high + MAX_DEFLECTION_MM

    @property
    def relative_curvature_per_mm(self) -> float:
        """Sum of the curvatures of wheel and rail where they touch, on the side where it is smaller."""
        curvature = self._beside(0.0)
        return float(min(side.relative_curvature[0, 0] for side in (curvature.left, curvature.right)))

    def near_points(self, margin_mm: float = MARGIN_MM, further_mm: float = FLANGE_MM) -> Points:
        """Points with a gap up to a margin, at the start and up to a distance further sideways."""
        lateral = self.motion.lateral_mm
        further = math.copysign(further_mm, lateral) if abs(lateral) > FLANGE_MM else 0.0
        near_by_kind: dict[str, list[Floats]] = {}
        for offset in (0.0, 0.5 * further, further) if further else (0.0,):
            try:
                positions = self._beside(offset)
            except InputError:
                if offset == 0.0:
                    raise
                continue  # what lies beyond a rail adds nothing
            locus = self.geometry.located(positions)
            for side in SIDES:
                touches, at = positions.side(side), locus.side(side)
                near = (at.gaps_mm[0] <= margin_mm) & self._inside(side, touches.wheel_arc[0], touches.x[0])
                near[0] = True
                near_by_kind.setdefault(f"wheel-{side}", []).append(at.wheel_points_mm[0, near])
                near_by_kind.setdefault(f"rail-{side}", []).append(at.rail_points_mm[0, near])
        return {name: np.concatenate(points) for name, points in near_by_kind.items()}

    def close_points(self) -> Points:
        """All points at the start with a gap below `CLOSE_MM`.

        Where worn profiles conform they reach farther than the curvatures at the touch show.
        """
        start = self._beside(0.0)
        lateral, lift = float(self.geometry.axle_lateral(start)[0]), float(start.lift[0])
        points: Points = {}
        for side, sign in SIDE_SIGN.items():
            curves, roll = self.geometry.side(side), sign * float(start.roll[0])
            arcs = curves.close_arcs(sign * lateral, roll, lift, CLOSE_MM)
            on_wheel = np.column_stack(curves.wheel.at(arcs)[:2])
            moved = Placement(roll, (sign * lateral, lift)).points(on_wheel)
            on_rail = np.column_stack(curves.rail.over(moved[:, 0])[:2])
            points[f"wheel-{side}"] = curves.wheel_frame.inverse().points(on_wheel)
            points[f"rail-{side}"] = curves.rail_frame.inverse().points(on_rail)
        return points

    def _beside(self, offset_mm: float) -> TouchingPositions:
        """The position beside the start by a lateral offset at the height of the rails."""
        level = self.motion.lateral_mm + self.geometry.reference_height_mm * math.sin(self.motion.roll_rad) + offset_mm
        return self.geometry.touching(np.array([level]), gaps=True)

    def _inside(self, side: Side, wheel_arc: Floats, rail_x: Floats) -> Bools:
        curves = self.geometry.side(side)
        first, last = curves.rail.joints[[0, -1]]
        on_wheel = (wheel_arc > END_MM) & (wheel_arc < curves.wheel.length - END_MM)
        inside: Bools = on_wheel & (rail_x > first + END_MM) & (rail_x < last - END_MM)
        return inside


def rigid_start(problem: WheelsetProblem, geometry: RigidGeometry | None = None) -> RigidStart:
    """Find the equilibrium that a rigid wheelset reaches from the middle of the track, or its prescribed position.

    An `InputError` if the wheels do not fit the rails, or the load overturns the wheelset or carries a flange over its
    rail.

    - `problem`: wheelset, track, load and prescribed displacements.
    - `geometry`: rigid geometry of this wheelset on this track, if it is there already.
    """
    geometry = geometry or RigidGeometry.of(problem.track, problem.wheels)
    lateral = problem.position.lateral_mm
    if lateral is not None:
        return RigidStart(geometry, _prescribed_start(geometry, lateral), None)
    equilibrium = rigid_equilibrium(geometry, problem.forces)
    if problem.has_alike_sides and problem.forces.is_symmetric:
        # the middle is in equilibrium, though it need not be stable
        middle = geometry.located(geometry.touching(np.array([0.0]), at_axle=True)).motion(0)
        return RigidStart(geometry, middle, equilibrium)
    return RigidStart(geometry, equilibrium.reached().motion, equilibrium)


def _prescribed_start(geometry: RigidGeometry, lateral: float) -> WheelsetPosition:
    """The position at a prescribed lateral displacement; before it, the last one in which the flange does not climb."""
    low, high = geometry.limits(abs(lateral))
    inside = low <= lateral <= high
    reached = lateral if inside else SCAN_MM * math.trunc(min(max(lateral, low), high) / SCAN_MM)
    ends = geometry.locus([reached, 0.0])
    at_it = ends.motion(0)
    if _steepest(ends)[0] <= CLIMBING_RAD and at_it.vertical_mm - ends.vertical_mm[1] <= CLIMBED_MM:
        return at_it
    n_steps = max(math.ceil(abs(reached) / SCAN_MM), 1)
    scan = geometry.locus(reached * np.arange(n_steps) / n_steps)
    climbing = np.flatnonzero(_steepest(scan) > CLIMBING_RAD)
    last = int(climbing[0]) - 1 if len(climbing) else n_steps - 1
    return at_it if last < 0 else scan.motion(last)


def _steepest(locus: ContactLocus) -> Floats:
    """Contact angle of the steeper side, shape (n,)."""
    angles: Floats = np.maximum(*(locus.side(side).contact_angles_rad[:, 0] for side in SIDES))
    return angles
