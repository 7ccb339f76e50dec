"""A wheelset of rigid wheels on two rigid rails: positions in which both wheels touch, and where they touch.

With the lateral motion given, vertical motion and roll follow from one touch on each side. They are found along the
lateral motion of the wheelset *at the height of the rails* (the point of the wheelset that is at the top of the rails
in the reference position): along it the roll has one solution for each place, while the lateral motion of the axle's
middle turns back when a steep flange climbs.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid_side import RigidSide, Touches
from flangeway.railway.track import SIDES, Side, Track, Wheelset, WheelsetMotion, refuse_misfit

Floats = NDArray[np.float64]

TOUCH_TOLERANCE_MM = 1e-10
"""Difference of the two wheels' heights at which both touch."""

JUMP_MM = 0.3
"""Shortest jump of a point of contact along the wheel that counts as one."""

_PATH_STEP_MM = 0.1
_FLANGE_MM = 30.0  # further lateral motion at the rails' height that is searched, while the flange climbs
_ROUNDING_MM = 0.1 * TOUCH_TOLERANCE_MM
_CONFORMING_MM = 1e-5
"""Difference of the heights that is left where curves conform: the touch jumps among places of the same height."""

_LARGEST_TURN_RAD = 0.02
_FAST = 3.0  # motion of the point of contact per lateral motion, above which it may have jumped
_MAX_ITERATIONS = 40
_SECTIONS = 64


@dataclass(frozen=True, eq=False)
class RigidWheelset:
    """A wheelset on two rails, all rigid.

    Parameters
    ----------
    left, right
        The sides, each in its right-hand form.
    reference_height_mm
        Height of the axle's middle over the top of the rails in the reference position.
    barycentre_height_mm
        Height above the axle's middle of the point where a load acts.

    """

    left: RigidSide
    right: RigidSide
    reference_height_mm: float
    barycentre_height_mm: float = Wheelset.barycentre_height_mm

    @classmethod
    def of(cls, track: Track, wheelset: Wheelset) -> "RigidWheelset":
        """Return the rigid curves of a wheelset on a track; see `refuse_misfit` for what is refused."""
        refuse_misfit(track, wheelset)
        left, right = (RigidSide.of(track, wheelset, side) for side in SIDES)
        return cls(left, right, wheelset.tape_radius_mm, wheelset.barycentre_height_mm)

    def side(self, side: Side) -> RigidSide:
        """Curves of a side."""
        return self.left if side == "left" else self.right


@dataclass(frozen=True, eq=False)
class SideLocus:
    """Points of contact of one side over the positions of a wheelset.

    Points in the frames of the profiles are in the right-hand form on both sides. Column 0 is the touch, further
    columns are the next smallest gaps, nan where there are none.

    Parameters
    ----------
    side
        Side of the track.
    wheel_points_mm, rail_points_mm
        In the frames of the profiles, shape (n, N_TOUCHES, 2).
    gaps_mm
        Vertical gap at these places, zero in column 0, inf where there is no place, shape (n, N_TOUCHES).
    contact_angles_rad
        Angle of the common tangent from the track's plane, positive towards the flange, shape (n, N_TOUCHES).
    rolling_radii_mm
        Distance from the axle, shape (n, N_TOUCHES).
    relative_curvatures_per_mm
        Sum of the curvatures of wheel and rail, shape (n, N_TOUCHES).
    points_mm
        In the track's axes, shape (n, N_TOUCHES, 2); here the left side has negative x.

    """

    side: Side
    wheel_points_mm: Floats
    rail_points_mm: Floats
    gaps_mm: Floats
    contact_angles_rad: Floats
    rolling_radii_mm: Floats
    relative_curvatures_per_mm: Floats
    points_mm: Floats


@dataclass(frozen=True, eq=False)
class ContactLocus:
    """Positions in which both wheels touch, and their points of contact.

    Parameters
    ----------
    lateral_mm, vertical_mm, roll_rad
        Motion of the axle's middle from its reference position, each (n,); see `WheelsetMotion`.
    rail_level_mm
        Lateral motion of the wheelset at the height of the rails, (n,).
    left, right
        Points of contact.

    """

    lateral_mm: Floats
    vertical_mm: Floats
    roll_rad: Floats
    rail_level_mm: Floats
    left: SideLocus
    right: SideLocus

    def side(self, side: Side) -> SideLocus:
        """Points of contact of a side."""
        return self.left if side == "left" else self.right

    @property
    def rolling_radius_difference_mm(self) -> Floats:
        """Rolling radius of the right wheel less that of the left one, (n,)."""
        return self.right.rolling_radii_mm[:, 0] - self.left.rolling_radii_mm[:, 0]

    def motion(self, number: int) -> WheelsetMotion:
        """Motion of the wheelset in a position."""
        return WheelsetMotion(
            float(self.lateral_mm[number]), float(self.vertical_mm[number]), float(self.roll_rad[number])
        )


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
    return locus_of(wheelset, settle(wheelset, wanted, *start, at_axle=True))


def path_of_contact(wheelset: RigidWheelset, reach_mm: float, middle_mm: float = 0.0) -> Settled:
    """Positions along the lateral motion at the height of the rails, to both sides as far as both wheels touch inside.

    Parameters
    ----------
    wheelset
        Wheels and rails.
    reach_mm
        Largest lateral motion at the rails' height; the positions are 0.1 mm apart.
    middle_mm
        Lateral motion of the middle one.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails even without lateral motion.

    """
    n_side = max(int(np.ceil(reach_mm / _PATH_STEP_MM)), 1)
    rail_level = middle_mm + _PATH_STEP_MM * np.arange(-n_side, n_side + 1, dtype=np.float64)
    over = wheelset.right.over_rail(rail_level) & wheelset.left.over_rail(-rail_level)
    if over[n_side]:
        # a margin for the part of the lateral motion that roll adds at the axle's height
        over &= np.roll(over, 30) & np.roll(over, -30)
        rail_level = rail_level[_run_about(over, n_side)] if over[n_side] else rail_level[:0]
    else:
        rail_level = rail_level[:0]
    if len(rail_level):
        settled, lost = _settle(wheelset, rail_level, rail_level.copy(), np.zeros(len(rail_level)), at_axle=False)
        inside = ~np.isin(np.arange(len(rail_level)), lost)
        inside &= ~wheelset.right.at_edge(settled.right) & ~wheelset.left.at_edge(settled.left)
        middle = int(np.argmin(np.abs(rail_level)))
        if inside[middle]:
            kept = _run_about(inside, middle)
            return Settled(
                settled.rail_level[kept],
                settled.roll[kept],
                Touches(*(column[kept] for column in settled.left)),
                Touches(*(column[kept] for column in settled.right)),
            )
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
        Largest lateral motion of the axle's middle.

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
        arcs = (path.left if side == "left" else path.right).wheel_arc[:, 0]
        places = np.flatnonzero(within & (np.abs(np.diff(arcs)) > max(JUMP_MM, _FAST * _PATH_STEP_MM)))
        low, high = path.rail_level[places], path.rail_level[places + 1]
        while len(low) and float((high - low).max()) > TOUCH_TOLERANCE_MM:
            low, high = _narrowed(wheelset, side, low, high)
        for first, last in zip(low, high, strict=True):
            jump = _jump(wheelset, side, float(first), float(last))
            if abs(jump.motion.lateral_mm) <= lateral_mm:
                found.append(jump)
    return tuple(sorted(found, key=lambda jump: jump.motion.lateral_mm))


def _narrowed(wheelset: RigidWheelset, side: Side, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Sections of intervals in which the point of contact still jumps."""
    grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _SECTIONS + 1)
    settled = settle(wheelset, grid.ravel())
    touches = settled.left if side == "left" else settled.right
    arcs = touches.wheel_arc[:, 0].reshape(grid.shape)
    rows, columns = np.nonzero(np.abs(np.diff(arcs, axis=1)) > JUMP_MM)
    return grid[rows, columns], grid[rows, columns + 1]


def _jump(wheelset: RigidWheelset, side: Side, low: float, high: float) -> ContactJump:
    ends = locus_of(wheelset, settle(wheelset, np.array([low, high])))
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

    """
    eta = target.copy() if rail_level is None else rail_level.copy()
    phi = np.zeros(len(target)) if roll is None else roll.copy()
    settled, lost = _settle(wheelset, target, eta, phi, at_axle=at_axle)
    if len(lost):
        raise InputError(
            f"a lateral motion of {target[lost[0]]:g} mm, at which no roll lets both wheels touch",
            "profiles on which the touch can be followed",
            "smooth the profiles, or move a little aside",
        )
    return settled


def _settle(
    wheelset: RigidWheelset, target: Floats, eta: Floats, phi: Floats, *, at_axle: bool
) -> tuple[Settled, NDArray[np.int64]]:
    """Settle positions as far as a roll is found for them; the numbers of the others, as where a profile ends."""
    radius = wheelset.reference_height_mm
    # with the motion at the rails' height given, the difference of the heights falls with the roll: a bracket is kept
    low, high = np.full(len(target), -np.inf), np.full(len(target), np.inf)
    active = np.arange(len(target))
    kept: list[Floats] | None = None
    for _ in range(_MAX_ITERATIONS):
        lateral = eta[active] - radius * np.sin(phi[active])
        right = wheelset.right.touches(lateral, phi[active])
        left = wheelset.left.touches(-lateral, -phi[active])
        columns = [*right, *left]
        if kept is None:
            kept = [column.copy() for column in columns]
        else:
            for whole, part in zip(kept, columns, strict=True):
                whole[active] = part
        height = right.lift[:, 0] - left.lift[:, 0]
        offset = lateral - target[active] if at_axle else np.zeros(len(active))
        done = (np.abs(height) < _ROUNDING_MM) & (np.abs(offset) < _ROUNDING_MM)
        arm, slope = _levers(radius, eta[active], phi[active], left, right)
        swing = radius * np.cos(phi[active])
        turn = (height - slope * offset) / (arm - slope * swing) if at_axle else height / arm
        new = phi[active] + np.clip(turn, -_LARGEST_TURN_RAD, _LARGEST_TURN_RAD)
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
    return Settled(eta, phi, Touches(*(kept or [])[6:]), Touches(*(kept or [])[:6])), lost


def _levers(radius: float, rail_level: Floats, roll: Floats, left: Touches, right: Touches) -> tuple[Floats, Floats]:
    """Sum of both touches' lever arms about the point at the rails' height, and sum of their slopes."""
    slopes = np.tan(right.angle[:, 0]), np.tan(left.angle[:, 0])
    arms = [
        touch.x[:, 0] - sign * rail_level + slope * (touch.y[:, 0] - touch.lift[:, 0] + radius * np.cos(roll))
        for touch, sign, slope in zip((right, left), (1.0, -1.0), slopes, strict=True)
    ]
    return arms[0] + arms[1], slopes[0] + slopes[1]


def _bracketed(wheelset: RigidWheelset, wanted: Floats) -> tuple[Floats, Floats]:
    """First guesses of the motion at the rails' height and of the roll, on the branch that leads from the middle."""
    path = path_of_contact(wheelset, float(np.abs(wanted).max()) + _FLANGE_MM)
    lateral = path.rail_level - wheelset.reference_height_mm * np.sin(path.roll)
    middle = int(np.argmin(np.abs(path.rail_level)))
    # away from the middle until the axle turns back
    steps = np.diff(lateral) > 0.0
    last = middle + (int(np.argmin(steps[middle:])) if not steps[middle:].all() else len(steps) - middle)
    before = steps[:middle][::-1]
    first = middle - (int(np.argmin(before)) if not before.all() else middle)
    low, high = lateral[first], lateral[last]
    if ((wanted < low) | (wanted > high)).any():
        worst = float(wanted[np.argmax(np.abs(wanted))])
        raise InputError(
            f"a lateral motion of {worst:g} mm",
            f"{low:.2f} to {high:.2f} mm, between the ends of the running surfaces or climbing flanges",
            "give a smaller lateral motion",
        )
    part = slice(first, last + 1)
    return np.interp(wanted, lateral[part], path.rail_level[part]), np.interp(wanted, lateral[part], path.roll[part])


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
        wheel = curves.wheel.at(np.nan_to_num(touches.wheel_arc))
        there = np.isfinite(touches.lift)
        on_wheel = np.where(there[..., None], np.stack((wheel.x, wheel.y), axis=-1), np.nan)
        on_rail = np.stack((touches.x, touches.y), axis=-1)
        sides[side] = SideLocus(
            "left" if side == "left" else "right",
            _in_frame(curves.wheel_frame, on_wheel),
            _in_frame(curves.rail_frame, on_rail),
            touches.lift[:, :1] - touches.lift,
            touches.angle,
            -on_wheel[..., 1],
            touches.relative_curvature,
            on_rail * (sign, 1.0),
        )
    return ContactLocus(lateral, settled.lift - radius, settled.roll, settled.rail_level, sides["left"], sides["right"])


def _in_frame(frame: Placement, points: Floats) -> Floats:
    back = frame.inverse()
    return points @ back.matrix.T + np.array(back.translation)
