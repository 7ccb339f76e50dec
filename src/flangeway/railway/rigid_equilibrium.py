"""Positions in which rigid wheels on rigid rails bear a load without friction: the rigid answer beside the elastic one.

Along the positions in which both wheels touch, the potential of the load has a derivative; where it passes through zero
the wheelset is in balance. A point of contact that jumps makes the derivative jump: if it passes through zero there,
the side touches in two points, and three normal forces follow from the three equations of balance.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.railway.load import Load
from flangeway.railway.rigid_contact import (
    ContactLocus,
    RigidWheelset,
    Settled,
    locus_of,
    path_of_contact,
    settle,
)
from flangeway.railway.track import SIDES, Side, WheelsetMotion
from flangeway.solve import Status

Floats = NDArray[np.float64]

BALANCED = 1e-8
"""Largest residual force over the load at which the normal forces count as in balance."""

_TOGETHER_MM = 1e-7  # gap below which a further place touches as well
_PRECISION_MM = 1e-13
_SECTIONS = 128
_ASIDE_MM = 0.05
_NEAR_MM = 1e-6
_ONE_POINT_MM = 1e-2
_REACH_MM = 40.0


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

    """

    side: Side
    wheel_point_mm: tuple[float, float]
    rail_point_mm: tuple[float, float]
    point_mm: tuple[float, float]
    contact_angle_rad: float
    rolling_radius_mm: float
    relative_curvature_per_mm: float
    normal_force_N: float  # noqa: N815

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

    """

    motion: WheelsetMotion
    motion_in_space: WheelsetMotion
    contacts: tuple[RigidContactPoint, ...]
    stable: bool
    residual: float

    @property
    def bears(self) -> bool:
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
    """Balance of a rigid wheelset under a load.

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
        return Status(True, f"in balance at a lateral motion of {lateral:.3f} mm on {n_points} points", 0)

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


def rigid_equilibrium(wheelset: RigidWheelset, load: Load) -> RigidEquilibrium:
    """Find all positions in which a load is in balance, and the one that is reached from the middle.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    load
        Forces at the barycentre.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails.

    """
    # half a step aside: in the middle of a symmetric track a symmetric derivative is zero
    path = path_of_contact(wheelset, _REACH_MM, _ASIDE_MM)
    derivative = _derivative(wheelset, path, load)
    rising = derivative >= 0.0
    places = np.flatnonzero(rising[1:] != rising[:-1])
    positions = []
    if len(places):
        low, high = path.rail_level[places], path.rail_level[places + 1]
        low, high = _zeros(wheelset, load, low, high)
        # a little to both sides as well: between conforming arcs the contact is decided by rounding at the jump itself
        found = settle(wheelset, np.concatenate((low, high, low - _NEAR_MM, high + _NEAR_MM)))
        positions = [
            _position(wheelset, load, found, range(i, 4 * len(places), len(places)), bool(rising[place + 1]))
            for i, place in enumerate(places)
        ]
    along, onto = load.in_track
    ratios = held_ratios(wheelset, path)
    middle = int(np.argmin(np.abs(path.rail_level)))
    reached = _reached(derivative[middle], middle, places, rising)
    position = None if reached is None else positions[reached]
    outcome: RigidPosition | InputError
    if position is None:
        outcome = _derailment(path, ratios, along / onto)
    elif not position.bears:
        outcome = _overturning(wheelset, position, along / onto)
    else:
        outcome = position
    return RigidEquilibrium(outcome, tuple(each for each in positions if each.bears), along / onto)


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
    """Lift and lateral motion of the barycentre per lateral motion at the rails' height."""
    vertical, roll = _slopes(wheelset, path)
    height = wheelset.reference_height_mm + wheelset.barycentre_height_mm
    return vertical - roll * height * np.sin(path.roll), 1.0 - roll * height * np.cos(path.roll)


def _derivative(wheelset: RigidWheelset, path: Settled, load: Load) -> Floats:
    """Derivative of the load's potential along the path."""
    along, onto = load.in_track
    lift, lateral = _work(wheelset, path)
    return onto * lift - along * lateral


def held_ratios(wheelset: RigidWheelset, path: Settled) -> Floats:
    """Ratio of lateral to vertical force at the barycentre that is in balance in each position, nan where none is.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    path
        Positions in which both wheels touch.

    """
    lift, lateral = _work(wheelset, path)
    return np.where(lateral > 1e-3, lift / np.where(lateral > 1e-3, lateral, 1.0), np.nan)


def _zeros(wheelset: RigidWheelset, load: Load, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Narrow intervals in which the derivative passes through zero, by continuous change or by a jump."""
    rows = np.arange(len(low))
    for _ in range(12):
        grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _SECTIONS + 1)
        derivative = _derivative(wheelset, settle(wheelset, grid.ravel()), load).reshape(grid.shape)
        rising = derivative >= 0.0
        changes = rising[:, 1:] != rising[:, :-1]
        column = np.argmax(changes, axis=1)
        low, high = grid[rows, column], grid[rows, column + 1]
        if float((high - low).max()) < _PRECISION_MM:
            break
    return low, high


def _reached(derivative: float, middle: int, places: NDArray[np.int64], rising: NDArray[np.bool_]) -> int | None:
    """Number of the first stable zero downhill from the middle."""
    for number in range(len(places)) if derivative < 0.0 else reversed(range(len(places))):
        beyond = places[number] >= middle if derivative < 0.0 else places[number] < middle
        if beyond and rising[places[number] + 1]:
            return number
    return None


def _position(wheelset: RigidWheelset, load: Load, found: Settled, ends: range, stable: bool) -> RigidPosition:
    """Forces and points of contact at a zero; positions about it, so that both points of a jump are there."""
    locus = locus_of(wheelset, found)
    motion = locus.motion(ends[0])
    points = _points(locus, ends)
    along, onto = load.in_track
    height = wheelset.reference_height_mm + motion.vertical_mm
    barycentre = (
        motion.lateral_mm - wheelset.barycentre_height_mm * math.sin(motion.roll_rad),
        height + wheelset.barycentre_height_mm * math.cos(motion.roll_rad),
    )
    columns = []
    for point in points:
        x, y = point.force_on_wheel_N
        moment = (point.point_mm[0] - barycentre[0]) * y - (point.point_mm[1] - barycentre[1]) * x
        columns.append((x, y, moment / height))
    forces, rest = nnls(np.array(columns).T, np.array([-along, onto, 0.0]) / onto)
    bearing = tuple(_with_force(point, float(force) * onto) for point, force in zip(points, forces, strict=True))
    cosine, sine = math.cos(load.tilt_rad), math.sin(load.tilt_rad)
    in_space = WheelsetMotion(
        cosine * motion.lateral_mm - sine * motion.vertical_mm,
        sine * motion.lateral_mm + cosine * motion.vertical_mm,
        motion.roll_rad,
    )
    kept = tuple(point for point in bearing if point.normal_force_N > 1e-9 * onto)
    return RigidPosition(motion, in_space, kept, stable, float(rest))


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
                    )
                )
    return points


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _with_force(point: RigidContactPoint, force: float) -> RigidContactPoint:
    return RigidContactPoint(
        point.side,
        point.wheel_point_mm,
        point.rail_point_mm,
        point.point_mm,
        point.contact_angle_rad,
        point.rolling_radius_mm,
        point.relative_curvature_per_mm,
        force,
    )


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
    height = wheelset.barycentre_height_mm + max(point.rolling_radius_mm for point in position.contacts)
    return InputError(
        f"a load of L/V {abs(load_ratio):.3f}, which is overturning about the {side} rail: the other wheel lifts",
        f"L/V up to {arm / height:.3f}, at which it lifts with this height of the barycentre",
        "lower the lateral force, the speed or the barycentre, or raise the superelevation",
    )
