"""A wheelset of rigid wheels on two rigid rails: positions in which both wheels touch, and where they touch.

With the lateral motion given, vertical motion and roll follow from one touch on each side. They are found along the
lateral motion of the wheelset *at the height of the rails* (the point of the wheelset that is at the top of the rails
in the reference position): along it the roll has one solution for each place, while the lateral motion of the axle's
middle turns back when a steep flange climbs.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid.rigid_locus import ContactLocus, SideLocus
from flangeway.railway.rigid.rigid_side import RigidSide, Touches
from flangeway.railway.track.placements import SIDES, Side, Track, Wheelset, WheelsetMotion, refuse_misfit
from flangeway.types import Floats

TOUCH_TOLERANCE_MM = 1e-10
"""Difference of the two wheels' heights at which both touch."""

JUMP_MM = 0.3
"""Shortest jump of a point of contact along the wheel that counts as one."""

PATH_MM = 40.0
"""Lateral motion at the rails' height to which positions are followed, if no larger one is asked for."""

PATH_STEP_MM = 0.1
"""Distance of these positions."""

_FLANGE_MM = 30.0  # further lateral motion at the rails' height that is searched, while the flange climbs
_ROUNDING_MM = 0.1 * TOUCH_TOLERANCE_MM
_CONFORMING_MM = 1e-5
"""Difference of the heights that is left where curves conform: the touch jumps among places of the same height."""

_MAX_TURN_RAD = 0.02
_FAST = 3.0  # motion of the point of contact per lateral motion, above which it may have jumped
_MAX_ITERATIONS = 40
_SECTIONS = 32


@dataclass(frozen=True, eq=False)
class RigidWheelset:
    """A wheelset on two rails, all rigid.

    Parameters
    ----------
    left, right
        The sides, each in its right-hand form.
    reference_height_mm
        Height of the axle's middle over the top of the rails in the reference position.
    centre_of_gravity_height_mm
        Height above the axle's middle of the point where a load acts.

    """

    left: RigidSide
    right: RigidSide
    reference_height_mm: float
    centre_of_gravity_height_mm: float = Wheelset.centre_of_gravity_height_mm

    @classmethod
    def of(cls, track: Track, wheelset: Wheelset, yaw_rad: float = 0.0) -> "RigidWheelset":
        """Return the rigid curves of a wheelset on a track; see `refuse_misfit` for what is refused.

        Parameters
        ----------
        track, wheelset
            What stands where.
        yaw_rad
            Yaw of the axle about its middle, counter-clockwise seen from above: the right wheel is ahead.

        """
        refuse_misfit(track, wheelset)
        left, right = (RigidSide.of(track, wheelset, side, yaw_rad) for side in SIDES)
        return cls(left, right, wheelset.tape_radius_mm, wheelset.centre_of_gravity_height_mm)

    def side(self, side: Side) -> RigidSide:
        """Curves of a side."""
        return self.left if side == "left" else self.right

    @cached_property
    def _path(self) -> "Settled":
        return _followed(self, PATH_MM)

    def path(self, reach_mm: float) -> "Settled":
        """See `path_of_contact`."""
        path = self._path if reach_mm <= PATH_MM else _followed(self, reach_mm)
        return path.part(np.abs(path.rail_level) < reach_mm + PATH_STEP_MM)


@dataclass(frozen=True)
class ContactJump:
    """A position in which the point of contact of a side jumps: there it touches in two points.

    Parameters
    ----------
    side
        Side of the track.
    motion
        Motion of the axle's middle.
    wheel_points_mm, rail_points_mm
        Both points in the frames of the profiles, that of the smaller lateral motion first.

    """

    side: Side
    motion: WheelsetMotion
    wheel_points_mm: tuple[tuple[float, float], tuple[float, float]]
    rail_points_mm: tuple[tuple[float, float], tuple[float, float]]


class Intervals(NamedTuple):
    """Intervals of the lateral motion at the rails' height, or grids in them, and guesses of the roll, (n, m) each."""

    level: Floats
    roll: Floats

    def divided(self, n_sections: int) -> "Intervals":
        """Grids (n, n_sections + 1) between the ends."""
        part = np.linspace(0.0, 1.0, n_sections + 1)
        return Intervals(*(each[:, :1] + np.diff(each, axis=1) * part for each in self))


class Settled(NamedTuple):
    """Positions in which both wheels touch: raw arrays (n,), and touches of both sides."""

    rail_level: Floats
    roll: Floats
    left: Touches
    right: Touches

    @property
    def lift(self) -> Floats:
        """Height of the axle's middle."""
        return 0.5 * (self.right.lift[:, 0] + self.left.lift[:, 0])

    def side(self, side: Side) -> Touches:
        """Touches of a side."""
        return self.left if side == "left" else self.right

    def pairs(self, places: NDArray[np.int64]) -> Intervals:
        """Intervals from positions to those that follow them."""
        both = places[:, None] + np.arange(2)
        return Intervals(self.rail_level[both], self.roll[both])

    def part(self, chosen: slice | NDArray[np.bool_]) -> "Settled":
        """Some of the positions."""
        sides = (Touches(*(column[chosen] for column in side)) for side in (self.left, self.right))
        return Settled(self.rail_level[chosen], self.roll[chosen], *sides)


def contact_locus(wheelset: RigidWheelset, lateral_mm: ArrayLike, *, roll: bool = True) -> ContactLocus:
    """Lower a wheelset on its rails until both wheels touch, at given lateral motions of the axle's middle.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    lateral_mm
        Lateral motions, (n,).
    roll
        Whether the wheelset rolls, so that both wheels touch. Without, each wheel comes down by itself on its rail, as
        the reference results of EN 15302 have it; the vertical motion is then the mean of both.

    Raises
    ------
    InputError
        If a motion is not finite, or cannot be reached: beyond the largest one the flange climbs and turns the axle
        back, or a wheel leaves its rail.

    """
    wanted = np.atleast_1d(np.asarray(lateral_mm, dtype=np.float64))
    if wanted.ndim != 1 or not len(wanted) or not np.isfinite(wanted).all():
        raise InputError("lateral motions that are not finite numbers", "finite numbers in mm", "give one or more")
    if not roll:
        level = np.zeros(len(wanted))
        left, right = wheelset.left.touches(-wanted, level), wheelset.right.touches(wanted, level)
        edge = wheelset.left.at_edge(left) | wheelset.right.at_edge(right)
        if edge.any():
            raise InputError(
                f"a lateral motion of {wanted[np.argmax(edge)]:g} mm, with a touch at the end of a running surface",
                "touches inside the rails' heads and the wheels' running surfaces",
                "check gauge and back-to-back distance, or give smaller motions",
            )
        return locus_of(wheelset, Settled(wanted.copy(), level, left, right))
    start = _bracketed(wheelset, wanted)
    return locus_of(wheelset, settle(wheelset, wanted, *start, at_axle=True, gaps=True))


def path_of_contact(wheelset: RigidWheelset, reach_mm: float) -> Settled:
    """Positions along the lateral motion at the height of the rails, to both sides as far as both wheels touch inside.

    They are 0.1 mm apart, half of that from the middle: on symmetric tracks symmetric functions are zero there. Only
    the first touches are in them. They are computed once for a wheelset.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    reach_mm
        Maximum lateral motion at the rails' height.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails even without lateral motion.

    """
    return wheelset.path(reach_mm)


def _followed(wheelset: RigidWheelset, reach_mm: float) -> Settled:
    """Follow the path of contact."""
    n_side = max(int(np.ceil(reach_mm / PATH_STEP_MM)), 1) + 1
    rail_level = np.arange(-n_side + 0.5, n_side) * PATH_STEP_MM
    over = wheelset.right.over_rail(rail_level) & wheelset.left.over_rail(-rail_level)
    # a margin for the part of the lateral motion that roll adds at the axle's height
    over &= np.roll(over, 30) & np.roll(over, -30)
    if over[n_side]:
        rail_level = rail_level[_run_about(over, n_side)]
        every = slice(None, None, 10)
        coarse = _settle(wheelset, rail_level[every], rail_level[every], 0.0 * rail_level[every])[0]
        roll = np.interp(rail_level, coarse.rail_level, coarse.roll)
        settled, lost = _settle(wheelset, rail_level, rail_level, roll)
        inside = ~np.isin(np.arange(len(rail_level)), lost)
        inside &= ~wheelset.right.at_edge(settled.right) & ~wheelset.left.at_edge(settled.left)
        middle = int(np.argmin(np.abs(rail_level)))
        if inside[middle]:
            return settled.part(_run_about(inside, middle))
    raise InputError(
        "a wheelset whose wheels do not touch the rails inside their running surfaces",
        "wheels that stand on the heads of the rails",
        "check gauge_mm and back_to_back_mm",
    )


def contact_jumps(wheelset: RigidWheelset, lateral_mm: float) -> tuple[ContactJump, ...]:
    """Find the positions in which a point of contact jumps, to both sides up to a lateral motion.

    Between positions 0.1 mm apart a jump is narrowed until it is known to 1e-10 mm; a point of contact that only moves
    fast becomes continuous on the way.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    lateral_mm
        Maximum lateral motion of the axle's middle.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails.

    """
    path = path_of_contact(wheelset, lateral_mm + _FLANGE_MM)
    lateral = path.rail_level - wheelset.reference_height_mm * np.sin(path.roll)
    within = np.minimum(np.abs(lateral[1:]), np.abs(lateral[:-1])) <= lateral_mm
    found = []
    for side in SIDES:
        arcs = path.side(side).wheel_arc[:, 0]
        places = np.flatnonzero(within & (np.abs(np.diff(arcs)) > max(JUMP_MM, _FAST * PATH_STEP_MM)))
        pairs = path.pairs(places)
        while len(pairs.level) and float(np.diff(pairs.level, axis=1).max()) > TOUCH_TOLERANCE_MM:
            grid = pairs.divided(_SECTIONS)
            settled = settle(wheelset, grid.level.ravel(), roll=grid.roll.ravel())
            arcs = settled.side(side).wheel_arc[:, 0].reshape(grid.level.shape)
            rows, columns = np.nonzero(np.abs(np.diff(arcs, axis=1)) > JUMP_MM)
            pairs = settled.pairs(rows * grid.level.shape[1] + columns)
        for first, last in pairs.level:
            jump = _jump(wheelset, side, float(first), float(last))
            if abs(jump.motion.lateral_mm) <= lateral_mm:
                found.append(jump)
    return tuple(sorted(found, key=lambda jump: jump.motion.lateral_mm))


def _jump(wheelset: RigidWheelset, side: Side, low: float, high: float) -> ContactJump:
    ends = locus_of(wheelset, settle(wheelset, np.array([low, high]), gaps=True))
    at = ends.side(side)
    order = (0, 1) if abs(ends.lateral_mm[0]) <= abs(ends.lateral_mm[1]) else (1, 0)
    on_wheel, on_rail = (
        tuple((float(points[i, 0, 0]), float(points[i, 0, 1])) for i in order)
        for points in (at.wheel_points_mm, at.rail_points_mm)
    )
    return ContactJump(side, ends.motion(0), (on_wheel[0], on_wheel[1]), (on_rail[0], on_rail[1]))


def settle(
    wheelset: RigidWheelset,
    target: Floats,
    rail_level: Floats | None = None,
    roll: Floats | None = None,
    *,
    at_axle: bool = False,
    gaps: bool = False,
) -> Settled:
    """Find the rolls at which both wheels touch, by Newton with the exact derivatives of the touches' heights.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    target
        Lateral motions at the rails' height, or of the axle's middle, (n,).
    rail_level, roll
        First guess; `target` and zero by default.
    at_axle
        Whether `target` is the motion of the axle's middle.
    gaps
        Whether the next smallest gaps are wanted besides the touches.

    """
    eta = target if rail_level is None else rail_level
    phi = np.zeros(len(target)) if roll is None else roll
    settled, lost = _settle(wheelset, target, eta, phi, at_axle=at_axle)
    if len(lost):
        raise InputError(
            f"a lateral motion of {target[lost[0]]:g} mm, at which no roll lets both wheels touch",
            "profiles on which the touch can be followed",
            "smooth the profiles, or move a little aside",
        )
    if gaps:
        return Settled(settled.rail_level, settled.roll, *_both(wheelset, settled.rail_level, settled.roll, gaps=True))
    return settled


def _both(wheelset: RigidWheelset, rail_level: Floats, roll: Floats, *, gaps: bool) -> tuple[Touches, Touches]:
    """Touches of the left and of the right wheel."""
    lateral = rail_level - wheelset.reference_height_mm * np.sin(roll)
    return (
        wheelset.left.touches(-lateral, -roll, first_only=not gaps),
        wheelset.right.touches(lateral, roll, first_only=not gaps),
    )


def _settle(
    wheelset: RigidWheelset, target: Floats, rail_level: Floats, roll: Floats, *, at_axle: bool = False
) -> tuple[Settled, NDArray[np.int64]]:
    """Settle positions as far as a roll is found for them; the numbers of the others, as where a profile ends."""
    radius, eta, phi = wheelset.reference_height_mm, rail_level.copy(), roll.copy()
    # with the motion at the rails' height given, the difference of the heights falls with the roll: a bracket is kept
    low, high = np.full(len(target), -np.inf), np.full(len(target), np.inf)
    active = np.arange(len(target))
    kept: list[Floats] | None = None
    for _ in range(_MAX_ITERATIONS):
        left, right = _both(wheelset, eta[active], phi[active], gaps=False)
        columns = [*left, *right]
        if kept is None:
            kept = [column.copy() for column in columns]
        else:
            for whole, part in zip(kept, columns, strict=True):
                whole[active] = part
        height = right.lift[:, 0] - left.lift[:, 0]
        offset = eta[active] - radius * np.sin(phi[active]) - target[active] if at_axle else np.zeros(len(active))
        done = (np.abs(height) < _ROUNDING_MM) & (np.abs(offset) < _ROUNDING_MM)
        arm, slope = _levers(radius, eta[active], phi[active], left, right)
        swing = radius * np.cos(phi[active])
        turn = (height - slope * offset) / (arm - slope * swing) if at_axle else height / arm
        new = phi[active] + np.clip(turn, -_MAX_TURN_RAD, _MAX_TURN_RAD)
        if not at_axle:
            low[active] = np.where(height > 0.0, phi[active], low[active])
            high[active] = np.where(height > 0.0, high[active], phi[active])
            beyond = ((new <= low[active]) | (new >= high[active])) & np.isfinite(high[active] - low[active])
            new = np.where(beyond, 0.5 * (low[active] + high[active]), new)
        # the last step of those that are done would only add rounding
        new = np.where(done, phi[active], new)
        if at_axle:
            eta[active] += np.where(done, 0.0, swing * (new - phi[active]) - offset)
        phi[active] = new
        active, rest = active[~done], np.maximum(np.abs(height), np.abs(offset))[~done]
        if not len(active):
            break
    lost = active[~(rest < _CONFORMING_MM)]
    return Settled(eta, phi, Touches(*(kept or [])[:6]), Touches(*(kept or [])[6:])), lost


def _levers(radius: float, rail_level: Floats, roll: Floats, left: Touches, right: Touches) -> tuple[Floats, Floats]:
    """Sum of both touches' lever arms about the point at the rails' height, and sum of their slopes."""
    slopes = np.tan(right.angle[:, 0]), np.tan(left.angle[:, 0])
    arms = [
        touch.x[:, 0] - sign * rail_level + slope * (touch.y[:, 0] - touch.lift[:, 0] + radius * np.cos(roll))
        for touch, sign, slope in zip((right, left), (1.0, -1.0), slopes, strict=True)
    ]
    return arms[0] + arms[1], slopes[0] + slopes[1]


def lateral_limits(wheelset: RigidWheelset, maximum_mm: float) -> tuple[float, float]:
    """Least and maximum lateral motion of the axle's middle, before a flange climbs and turns the axle back.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    maximum_mm
        Lateral motion up to which they are looked for.

    """
    path, part = _outward(wheelset, maximum_mm)
    lateral = path.rail_level - wheelset.reference_height_mm * np.sin(path.roll)
    return float(lateral[part.start]), float(lateral[part.stop - 1])


def unrolled_limits(wheelset: RigidWheelset, maximum_mm: float) -> tuple[float, float]:
    """Least and maximum lateral motion without roll, before a touch reaches the end of a running surface; see above."""
    n_side = math.ceil(maximum_mm / PATH_STEP_MM)
    lateral = np.linspace(-n_side, n_side, 2 * n_side + 1) * PATH_STEP_MM
    over = wheelset.right.over_rail(lateral) & wheelset.left.over_rail(-lateral)
    lateral = lateral[_run_about(over, n_side)]
    level = np.zeros(len(lateral))
    left = wheelset.left.touches(-lateral, level, first_only=True)
    right = wheelset.right.touches(lateral, level, first_only=True)
    inside = ~wheelset.left.at_edge(left) & ~wheelset.right.at_edge(right)
    run = lateral[_run_about(inside, int(np.argmin(np.abs(lateral))))]
    return float(run[0]), float(run[-1])


def _outward(wheelset: RigidWheelset, maximum_mm: float) -> tuple[Settled, slice]:
    """The path of contact, and the part of it on which the axle moves outward with the wheelset at the rails."""
    path = path_of_contact(wheelset, maximum_mm + _FLANGE_MM)
    lateral = path.rail_level - wheelset.reference_height_mm * np.sin(path.roll)
    rises = np.append(np.diff(lateral) > 0.0, False)
    middle = int(np.argmin(np.abs(path.rail_level)))
    run = _run_about(rises, middle) if rises[middle] else slice(middle, middle)
    return path, slice(run.start, run.stop + 1)


def _bracketed(wheelset: RigidWheelset, wanted: Floats) -> tuple[Floats, Floats]:
    """First guesses of the motion at the rails' height and of the roll, on the branch that leads from the middle."""
    path, part = _outward(wheelset, float(np.abs(wanted).max()))
    path = path.part(part)
    lateral = path.rail_level - wheelset.reference_height_mm * np.sin(path.roll)
    low, high = lateral[[0, -1]]
    if ((wanted < low) | (wanted > high)).any():
        worst = float(wanted[np.argmax(np.abs(wanted))])
        raise InputError(
            f"a lateral motion of {worst:g} mm",
            f"{low:.2f} to {high:.2f} mm, between the ends of the running surfaces or climbing flanges",
            "give a smaller lateral motion",
        )
    return np.interp(wanted, lateral, path.rail_level), np.interp(wanted, lateral, path.roll)


def _run_about(flags: NDArray[np.bool_], middle: int) -> slice:
    """The run of true flags about a place."""
    after, before = flags[middle:], flags[: middle + 1][::-1]
    last = middle + (int(np.argmin(after)) if not after.all() else len(after))
    first = middle - (int(np.argmin(before)) if not before.all() else len(before)) + 1
    return slice(first, last)


def locus_of(wheelset: RigidWheelset, settled: Settled) -> ContactLocus:
    """Points of contact of settled positions in the frames that engineers use."""
    radius = wheelset.reference_height_mm
    lateral = settled.rail_level - radius * np.sin(settled.roll)
    sides = {}
    for side, touches, sign in (("left", settled.left, -1.0), ("right", settled.right, 1.0)):
        curves = wheelset.left if side == "left" else wheelset.right
        along, radii, ahead = (
            np.where(np.isfinite(touches.lift), each, np.nan)
            for each in curves.on_wheel(np.nan_to_num(touches.wheel_arc))
        )
        on_wheel = np.stack((along, -radii), axis=-1)
        on_rail = np.stack((touches.x, touches.y), axis=-1)
        sides[side] = SideLocus(
            "left" if side == "left" else "right",
            _in_frame(curves.wheel_frame, on_wheel),
            _in_frame(curves.rail_frame, on_rail),
            touches.lift[:, :1] - touches.lift,
            touches.angle,
            radii,
            touches.relative_curvature,
            on_rail * (sign, 1.0),
            ahead,
        )
    return ContactLocus(lateral, settled.lift - radius, settled.roll, settled.rail_level, sides["left"], sides["right"])


def _in_frame(frame: Placement, points: Floats) -> Floats:
    back = frame.inverse()
    return points @ back.matrix.T + np.array(back.translation)
