"""A rigid wheelset on two rigid rails, and its points of contact over its positions."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid.rigid_side import RigidSide, Touches
from flangeway.railway.track.placements import (
    SIDE_SIGN,
    SIDES,
    RigidTrack,
    RigidWheelPair,
    Side,
    WheelsetPosition,
    refuse_misfit,
)
from flangeway.types import Bools, Floats, Ints, floats

# --- Points of contact of a rigid wheelset over its positions, and where they jump.


@dataclass(frozen=True, eq=False)
class SideLocus:
    """Points of contact of one side over the positions of a wheelset.

    Points in the frames of the profiles are in the right-hand form on both sides. Column 0 is the touch, further
    columns are the next smallest gaps, nan where there are none.

    - `wheel_points_mm`, `rail_points_mm`: in the frames of the profiles, shape (n, N_TOUCHES, 2).
    - `gaps_mm`: vertical gap at these points, zero in column 0, inf where there is none, shape (n, N_TOUCHES).
    - `contact_angles_rad`: angle of the common tangent from the track's plane, positive towards the flange, shape (n,
      N_TOUCHES).
    - `rolling_radii_mm`: distance from the axle, shape (n, N_TOUCHES).
    - `relative_curvatures_per_mm`: sum of the curvatures of wheel and rail, shape (n, N_TOUCHES).
    - `points_mm`: in the track's axes, shape (n, N_TOUCHES, 2); here the left side has negative x.
    - `ahead_mm`: longitudinal distance by which the point is ahead of the axle, zero without yaw, shape (n, N_TOUCHES).
    """

    side: Side
    wheel_points_mm: Floats
    rail_points_mm: Floats
    gaps_mm: Floats
    contact_angles_rad: Floats
    rolling_radii_mm: Floats
    relative_curvatures_per_mm: Floats
    points_mm: Floats
    ahead_mm: Floats

    def part(self, chosen: slice | Ints) -> "SideLocus":
        """The points of some positions."""
        arrays = (getattr(self, entry.name)[chosen] for entry in fields(self) if entry.name != "side")
        return SideLocus(self.side, *arrays)


@dataclass(frozen=True, eq=False)
class ContactLocus:
    """Positions in which both wheels touch, and their points of contact.

    - `lateral_mm`, `vertical_mm`, `roll_rad`: displacement of the axle's middle from its reference position, each (n,);
      see `WheelsetPosition`.
    - `rail_level_mm`: lateral displacement of the wheelset at the height of the rails, (n,).
    - `left`, `right`: points of contact.
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

    def part(self, chosen: slice | Ints) -> "ContactLocus":
        """Some of the positions."""
        lateral, vertical, roll = self.lateral_mm[chosen], self.vertical_mm[chosen], self.roll_rad[chosen]
        sides = self.left.part(chosen), self.right.part(chosen)
        return ContactLocus(lateral, vertical, roll, self.rail_level_mm[chosen], *sides)

    def motion(self, number: int) -> WheelsetPosition:
        """Displacement of the wheelset in a position."""
        return WheelsetPosition(
            float(self.lateral_mm[number]), float(self.vertical_mm[number]), float(self.roll_rad[number])
        )


@dataclass(frozen=True)
class ContactJump:
    """A position in which the point of contact of a side jumps: there it touches in two points.

    - `motion`: displacement of the axle's middle.
    - `wheel_points_mm`, `rail_points_mm`: both points in the frames of the profiles, that of the smaller lateral
      displacement first.
    """

    side: Side
    motion: WheelsetPosition
    wheel_points_mm: tuple[tuple[float, float], tuple[float, float]]
    rail_points_mm: tuple[tuple[float, float], tuple[float, float]]

    @classmethod
    def between(cls, locus: ContactLocus, side: Side, number: int) -> "ContactJump":
        """The jump between a position and the next."""
        at, order = locus.side(side), np.array((number, number + 1))
        if abs(locus.lateral_mm[number]) > abs(locus.lateral_mm[number + 1]):
            order = order[::-1]
        on_wheel, on_rail = (
            tuple((float(x), float(y)) for x, y in points[order, 0])
            for points in (at.wheel_points_mm, at.rail_points_mm)
        )
        return cls(side, locus.motion(number), (on_wheel[0], on_wheel[1]), (on_rail[0], on_rail[1]))


# --- A rigid wheelset on two rigid rails: one object for a pair of profiles on a track, computed once.
#
# For a prescribed lateral displacement, the vertical displacement and the roll follow from one touch on each side. They
# are found along the lateral displacement of the wheelset *at the height of the rails* (the point of the wheelset that
# is at the top of the rails in the reference position): there the roll is a function of it, while the lateral
# displacement of the axle's middle turns back when a steep flange climbs.


TOUCH_TOLERANCE_MM = 1e-10  # difference of the two wheels' heights at which both touch
JUMP_MM = 0.3  # shortest jump of a point of contact along the wheel that is reported

CLIMBED_MM = 3.0  # rise of the axle from the middle of the track above which a flange has climbed
PATH_MM = 40.0
"""Lateral displacement at the rails' height to which positions are followed, if no larger one is asked for."""

MAX_REACH_MM = 300.0  # lateral displacement beyond which no wheel is over its rail
PATH_STEP_MM = 0.1  # distance of these positions
_FLANGE_MM = 30.0  # further lateral displacement at the rails' height that is searched, while the flange climbs
_ROUNDING_MM = 0.1 * TOUCH_TOLERANCE_MM
_CONFORMING_MM = 1e-5
"""Difference of the heights that is left where curves conform: the touch jumps among points of the same height."""

_MAX_JUMP_MM = 0.01
"""The same where the touch jumps between points nearer than the samples of the wheel, at sharp corners of a flat head.

There the roll is between two that differ by `_ROLL_TOLERANCE_RAD` at most, so that no other balances the heights."""
_ROLL_TOLERANCE_RAD = 1e-11

_MAX_TURN_RAD = 0.02
_MAX_SHIFT_RATIO = 3.0
"""Displacement of the point of contact per lateral displacement, above which it may have jumped."""
_MAX_ITERATIONS = 40
_SECTIONS = 32


class Intervals(NamedTuple):
    """Intervals of the lateral displacement at the rails' height, or grids in them, and guesses of the roll, (n, m)."""

    level: Floats
    roll: Floats

    def divided(self, n_sections: int) -> "Intervals":
        """Grids (n, n_sections + 1) between the ends."""
        part = np.linspace(0.0, 1.0, n_sections + 1)
        return Intervals(*(column[:, :1] + np.diff(column, axis=1) * part for column in self))


class TouchingPositions(NamedTuple):
    """Positions in which both wheels touch: lateral displacement at the rails' height and roll (n,), and touches."""

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

    def pairs(self, numbers: Ints) -> Intervals:
        """Intervals from positions to those that follow them."""
        both = numbers[:, None] + np.arange(2)
        return Intervals(self.rail_level[both], self.roll[both])

    def part(self, chosen: slice | Bools) -> "TouchingPositions":
        """Some of the positions."""
        sides = (Touches(*(column[chosen] for column in side)) for side in (self.left, self.right))
        return TouchingPositions(self.rail_level[chosen], self.roll[chosen], *sides)


@dataclass(frozen=True, eq=False)
class RigidGeometry:
    """A wheelset on two rails, all rigid: contact points over the lateral displacement, and what follows from them.

    Parameters
    ----------
    left, right
        The sides, each in its right-hand form.
    reference_height_mm
        Height of the axle's middle over the top of the rails in the reference position.
    """

    left: RigidSide
    right: RigidSide
    reference_height_mm: float
    _paths: dict[float, TouchingPositions] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, track: RigidTrack, wheelset: RigidWheelPair, yaw_rad: float = 0.0) -> "RigidGeometry":
        """Return the rigid geometry of a wheelset on a track; see `refuse_misfit` for what is refused.

        Parameters
        ----------
        track, wheelset
            Profiles and measures.
        yaw_rad
            Yaw of the axle about its middle, counter-clockwise seen from above: the right wheel is ahead.
        """
        wheelset = wheelset.on(track)
        refuse_misfit(track, wheelset)
        right = RigidSide.of(track, wheelset, "right", yaw_rad)
        # sides are seen from their own gauge: those of a symmetric pair are one, but for the sense of the yaw
        alike = track.is_symmetric and wheelset.is_symmetric
        left = replace(right, yaw_rad=-yaw_rad) if alike else RigidSide.of(track, wheelset, "left", yaw_rad)
        return cls(left, right, wheelset.tape_radius_mm)

    def side(self, side: Side) -> RigidSide:
        """Curves of a side."""
        return self.left if side == "left" else self.right

    def locus(self, lateral_mm: ArrayLike, *, roll: bool = True) -> ContactLocus:
        """Points of contact at lateral displacements of the axle's middle, after the wheelset is lowered on its rails.

        Parameters
        ----------
        lateral_mm
            Lateral displacements, (n,).
        roll
            Whether the wheelset rolls, so that both wheels touch. Without roll each wheel comes down by itself on its
            rail, as in the reference results of EN 15302; the vertical displacement is then the mean of both.

        Raises
        ------
        InputError
            If a displacement is not finite, or cannot be reached: beyond the maximum one the flange climbs and turns
            the axle back, or a wheel leaves its rail.
        """
        wanted = np.atleast_1d(floats(lateral_mm))
        if wanted.ndim != 1 or not len(wanted) or not np.isfinite(wanted).all():
            raise InputError(
                "lateral displacements that are not finite numbers", "finite numbers in mm", "give one or more"
            )
        if not roll:
            level = np.zeros(len(wanted))
            positions = TouchingPositions(wanted.copy(), level, *self._both(wanted, level, gaps=True))
            edge = self._at_edge(positions)
            if edge.any():
                raise InputError(
                    f"a lateral displacement of {wanted[np.argmax(edge)]:g} mm, with a touch at the end of a "
                    "running surface",
                    "touches inside the rails' heads and the wheels' running surfaces",
                    "check track.gauge_mm and wheelset.back_to_back_mm, or give smaller displacements",
                )
            return self.located(positions)
        path, lateral = self._outward(float(np.abs(wanted).max()))
        low, high = lateral[[0, -1]]
        if ((wanted < low) | (wanted > high)).any():
            worst = float(wanted[np.argmax(np.abs(wanted))])
            raise InputError(
                f"a lateral displacement of {worst:g} mm",
                f"{low:.2f} to {high:.2f} mm; beyond, {self.path_end('right' if worst > 0.0 else 'left')}",
                "give a smaller lateral displacement",
            )
        start = np.interp(wanted, lateral, path.rail_level), np.interp(wanted, lateral, path.roll)
        return self.located(self.touching(wanted, *start, at_axle=True, gaps=True))

    def scanned(self, reach_mm: float, step_mm: float, *, roll: bool = True) -> ContactLocus:
        """Points of contact to both sides as far as the wheels touch inside their surfaces and no flange climbs.

        - `reach_mm`, `step_mm`: maximum lateral displacement, and distance of the positions, which include the middle.
        - `roll`: as in `locus`.
        """
        low, high = self.limits(reach_mm, roll=roll)
        numbers = np.arange(math.ceil(max(low, -reach_mm) / step_mm), math.floor(min(high, reach_mm) / step_mm) + 1)
        return self.locus(numbers * step_mm, roll=roll)

    def limits(self, maximum_mm: float, *, roll: bool = True) -> tuple[float, float]:
        """Least and maximum lateral displacement of the axle's middle that `locus` reaches.

        With roll that is where a flange begins to turn the axle back, without roll where a touch reaches the end of a
        running surface.

        Parameters
        ----------
        maximum_mm
            Lateral displacement up to which they are looked for.
        roll
            As in `locus`.
        """
        if roll:
            lateral = self._outward(maximum_mm)[1]
            return float(lateral[0]), float(lateral[-1])
        n_side = math.ceil(maximum_mm / PATH_STEP_MM)
        wanted = np.linspace(-n_side, n_side, 2 * n_side + 1) * PATH_STEP_MM
        wanted = wanted[_run_about(self._over_rails(wanted), n_side)]
        level = np.zeros(len(wanted))
        inside = ~self._at_edge(TouchingPositions(wanted, level, *self._both(wanted, level)))
        run = wanted[_run_about(inside, int(np.argmin(np.abs(wanted))))]
        return float(run[0]), float(run[-1])

    def path(self, reach_mm: float = PATH_MM) -> TouchingPositions:
        """Positions along the lateral displacement at the height of the rails, as far as both wheels touch inside.

        They are 0.1 mm apart, half of that from the middle: on symmetric tracks symmetric functions are zero there.
        Only the first touches are in them. They are computed once.

        Parameters
        ----------
        reach_mm
            Maximum lateral displacement at the rails' height, to both sides.

        Raises
        ------
        InputError
            If the wheels do not touch the rails inside their running surfaces in the middle of the track.
        """
        whole = max(reach_mm, PATH_MM)
        path = self._paths.get(whole)
        if path is None:
            path = self._paths[whole] = self._followed(whole)
        return path.part(np.abs(path.rail_level) < reach_mm + PATH_STEP_MM)

    def path_end(self, side: Side) -> str:
        """Say in words what ends the path of contact: the flange of a side that climbs, or the end of a surface."""
        path, sign = self.path(), SIDE_SIGN[side]
        last = path.part(slice(-1, None) if sign > 0.0 else slice(1))
        if last.lift[0] - path.lift[np.argmin(np.abs(path.rail_level))] > CLIMBED_MM:
            return f"the {side} flange climbs its rail, a derailment"
        level = last.rail_level + sign * PATH_STEP_MM
        try:
            beyond = self._rolled(level, level, last.roll)[0]
        except InputError as reason:
            return reason.given
        words = filter(None, (self.side(name).edge_words(name, beyond.side(name)) for name in SIDES))
        return "both wheels touch only up to " + (" and ".join(words) or "this position")

    def axle_lateral(self, positions: TouchingPositions) -> Floats:
        """Lateral displacement of the axle's middle, (n,)."""
        return positions.rail_level - self.reference_height_mm * np.sin(positions.roll)

    def jumps(self, lateral_mm: float) -> tuple[ContactJump, ...]:
        """Positions in which a point of contact jumps, to both sides up to a lateral displacement.

        Between positions 0.1 mm apart a jump is narrowed to 1e-10 mm; a point of contact that only moves fast becomes
        continuous on the way.

        Parameters
        ----------
        lateral_mm
            Maximum lateral displacement of the axle's middle.

        Raises
        ------
        InputError
            As `path`.
        """
        path = self.path(lateral_mm + _FLANGE_MM)
        lateral = np.abs(self.axle_lateral(path))
        within = np.minimum(lateral[1:], lateral[:-1]) <= lateral_mm
        jumps = []
        for side in SIDES:

            def jumped(positions: TouchingPositions, shape: tuple[int, ...], side: Side = side) -> Bools:
                arcs = positions.side(side).wheel_arc[:, 0].reshape(shape)
                return np.abs(np.diff(arcs, axis=-1)) > JUMP_MM

            arcs = path.side(side).wheel_arc[:, 0]
            fast = np.abs(np.diff(arcs)) > max(JUMP_MM, _MAX_SHIFT_RATIO * PATH_STEP_MM)
            pairs = self.narrowed(path.pairs(np.flatnonzero(within & fast)), jumped, TOUCH_TOLERANCE_MM)
            if len(pairs.level):
                ends = self.located(self.touching(pairs.level.ravel(), roll=pairs.roll.ravel(), gaps=True))
                jumps += [ContactJump.between(ends, side, i) for i in range(0, len(ends.lateral_mm), 2)]
        chosen = (jump for jump in jumps if abs(jump.motion.lateral_mm) <= lateral_mm)
        return tuple(sorted(chosen, key=lambda jump: jump.motion.lateral_mm))

    def narrowed(
        self,
        pairs: Intervals,
        changes: Callable[[TouchingPositions, tuple[int, ...]], Bools],
        tolerance_mm: float,
    ) -> Intervals:
        """Narrow intervals to those parts in which something changes, until they are short.

        - `changes`: of positions, in rows of a shape (n, m), between which of them it changes, (n, m - 1).
        - `tolerance_mm`: length at which an interval is short enough; or its ends are neighbours among the numbers of
          the machine.

        A loop of its own: intervals in which nothing changes are dropped, all others are searched at once.
        """
        while len(pairs.level) and float(np.diff(pairs.level, axis=1).max()) > tolerance_mm:
            grid = pairs.divided(_SECTIONS)
            positions = self.touching(grid.level.ravel(), roll=grid.roll.ravel())
            rows, columns = np.nonzero(changes(positions, grid.level.shape))
            shorter = positions.pairs(rows * grid.level.shape[1] + columns)
            if np.array_equal(shorter.level, pairs.level):
                break
            pairs = shorter
        return pairs

    def touching(
        self,
        target: Floats,
        rail_level: Floats | None = None,
        roll: Floats | None = None,
        *,
        at_axle: bool = False,
        gaps: bool = False,
    ) -> TouchingPositions:
        """Find the rolls at which both wheels touch, by Newton with the exact derivatives of the touches' heights.

        Parameters
        ----------
        target
            Lateral displacements at the rails' height, or of the axle's middle, (n,).
        rail_level, roll
            First guess; `target` and zero by default.
        at_axle
            Whether `target` is the displacement of the axle's middle.
        gaps
            Whether the next smallest gaps are wanted besides the touches.

        Raises
        ------
        InputError
            If at one of them no roll lets both wheels touch.
        """
        eta = target if rail_level is None else rail_level
        phi = np.zeros(len(target)) if roll is None else roll
        rolls, lost = self._rolled(target, eta, phi, at_axle=at_axle)
        if len(lost):
            raise InputError(
                f"a lateral displacement of {target[lost[0]]:g} mm: no two-wheel contact position found",
                "profiles on which the touch can be followed",
                "smooth the profiles, or change the displacement a little",
            )
        if not gaps:
            return rolls
        return TouchingPositions(
            rolls.rail_level, rolls.roll, *self._both(self.axle_lateral(rolls), rolls.roll, gaps=True)
        )

    def located(self, positions: TouchingPositions) -> ContactLocus:
        """Points of contact of positions in the frames of the profiles and of the track."""
        sides = {}
        for side, sign in SIDE_SIGN.items():
            curves, touches = self.side(side), positions.side(side)
            along, radii, ahead = (
                np.where(np.isfinite(touches.lift), column, np.nan)
                for column in curves.on_wheel(np.nan_to_num(touches.wheel_arc))
            )
            on_rail = np.stack((touches.x, touches.y), axis=-1)
            sides[side] = SideLocus(
                side,
                _in_frame(curves.wheel_frame, np.stack((along, -radii), axis=-1)),
                _in_frame(curves.rail_frame, on_rail),
                touches.lift[:, :1] - touches.lift,
                touches.angle,
                radii,
                touches.relative_curvature,
                on_rail * (sign, 1.0),
                ahead,
            )
        vertical = positions.lift - self.reference_height_mm
        return ContactLocus(
            self.axle_lateral(positions), vertical, positions.roll, positions.rail_level, sides["left"], sides["right"]
        )

    def _both(self, lateral: Floats, roll: Floats, *, gaps: bool = False) -> tuple[Touches, Touches]:
        """Touches of the left and of the right wheel at displacements of the axle's middle."""
        return (
            self.left.touches(-lateral, -roll, first_only=not gaps),
            self.right.touches(lateral, roll, first_only=not gaps),
        )

    def _at_edge(self, positions: TouchingPositions) -> Bools:
        return self.left.at_edge(positions.left) | self.right.at_edge(positions.right)

    def _over_rails(self, lateral: Floats) -> Bools:
        return self.right.over_rail(lateral) & self.left.over_rail(-lateral)

    def _followed(self, reach_mm: float) -> TouchingPositions:
        """Follow the path of contact: coarsely first, for the rolls to begin with."""
        n_side = max(int(np.ceil(min(reach_mm, MAX_REACH_MM) / PATH_STEP_MM)), 1) + 1
        level = np.arange(-n_side + 0.5, n_side) * PATH_STEP_MM
        over = self._over_rails(level)
        # a margin for the part of the lateral displacement that roll adds at the axle's height
        over &= np.roll(over, 30) & np.roll(over, -30)
        if over[n_side]:
            level = level[_run_about(over, n_side)]
            coarse = self._rolled(level[::10], level[::10], np.zeros(len(level[::10])))[0]
            rolls, lost = self._rolled(level, level, np.interp(level, coarse.rail_level, coarse.roll))
            inside = ~np.isin(np.arange(len(level)), lost) & ~self._at_edge(rolls)
            middle = int(np.argmin(np.abs(level)))
            if inside[middle]:
                return rolls.part(_run_about(inside, middle))
        raise InputError(
            "track.gauge_mm and wheelset.back_to_back_mm do not fit: wheels touch rails beside their running surfaces",
            "wheels that stand on the heads of the rails",
            "change one of both",
        )

    def _rolled(
        self, target: Floats, rail_level: Floats, roll: Floats, *, at_axle: bool = False
    ) -> tuple[TouchingPositions, Ints]:
        """As `touching`, and the numbers of the positions for which no roll is found, as where a profile ends.

        A loop of its own: heights jump with the points of contact, so that rolls are kept in brackets, and positions
        leave it one by one.
        """
        radius, eta, phi = self.reference_height_mm, rail_level.copy(), roll.copy()
        # at a given level the difference of the heights falls with the roll: a bracket is kept
        low, high = np.full(len(target), -np.inf), np.full(len(target), np.inf)
        active = np.arange(len(target))
        kept: list[Floats] = []
        for _ in range(_MAX_ITERATIONS):
            level, turned = eta[active], phi[active]
            lateral = level - radius * np.sin(turned)
            left, right = self._both(lateral, turned)
            if not kept:
                kept = [column.copy() for column in (*left, *right)]
            else:
                for whole, part in zip(kept, (*left, *right), strict=True):
                    whole[active] = part
            height = right.lift[:, 0] - left.lift[:, 0]
            offset = lateral - target[active] if at_axle else np.zeros(len(active))
            remainder = np.maximum(np.abs(height), np.abs(offset))
            done = remainder < _ROUNDING_MM
            slopes, arms = levers(radius, TouchingPositions(level, turned, left, right))
            slope, arm = slopes[0] - slopes[1], arms[0] - arms[1]
            swing = radius * np.cos(turned)
            turn = (height - slope * offset) / (arm - slope * swing) if at_axle else height / arm
            new = turned + np.clip(turn, -_MAX_TURN_RAD, _MAX_TURN_RAD)
            if not at_axle:
                low[active] = np.where(height > 0.0, turned, low[active])
                high[active] = np.where(height > 0.0, high[active], turned)
                beyond = ((new <= low[active]) | (new >= high[active])) & np.isfinite(high[active] - low[active])
                new = np.where(beyond, 0.5 * (low[active] + high[active]), new)
            # the last step of those that are done would only add rounding
            new = np.where(done, turned, new)
            if at_axle:
                eta[active] += np.where(done, 0.0, swing * (new - turned) - offset)
            phi[active] = new
            active, remainder = active[~done], remainder[~done]
            if not len(active):
                break
        closed = high[active] - low[active] < _ROLL_TOLERANCE_RAD
        lost = active[~(remainder < np.where(closed, _MAX_JUMP_MM, _CONFORMING_MM))]
        return TouchingPositions(eta, phi, Touches(*kept[:6]), Touches(*kept[6:])), lost

    def _outward(self, maximum_mm: float) -> tuple[TouchingPositions, Floats]:
        """Part of the path on which the axle moves outward with the wheelset at the rails; its lateral displacement."""
        path = self.path(maximum_mm + _FLANGE_MM)
        lateral = self.axle_lateral(path)
        rises = np.append(np.diff(lateral) > 0.0, False)
        middle = int(np.argmin(np.abs(path.rail_level)))
        run = _run_about(rises, middle) if rises[middle] else slice(middle, middle)
        part = slice(run.start, run.stop + 1)
        return path.part(part), lateral[part]


def levers(radius: float, positions: TouchingPositions) -> tuple[Floats, Floats]:
    """Return slopes of both touches, up to the right, and their arms about the point at the rails' height, (2, n) each.

    The right side is first; arms are lateral distances along which a roll lifts a wheel over its slope.

    - `radius`: height of the axle's middle over that point.
    """
    slopes, arms = [], []
    for touch, sign in ((positions.right, 1.0), (positions.left, -1.0)):
        slope = sign * np.tan(touch.angle[:, 0])
        below = touch.y[:, 0] - touch.lift[:, 0] + radius * np.cos(positions.roll)
        slopes.append(slope)
        arms.append(sign * touch.x[:, 0] - positions.rail_level + slope * below)
    return np.array(slopes), np.array(arms)


def _run_about(flags: Bools, middle: int) -> slice:
    """The run of true flags about a number."""
    after, before = flags[middle:], flags[: middle + 1][::-1]
    last = middle + (int(np.argmin(after)) if not after.all() else len(after))
    first = middle - (int(np.argmin(before)) if not before.all() else len(before)) + 1
    return slice(first, last)


def _in_frame(frame: Placement, points: Floats) -> Floats:
    back = frame.inverse()
    return points @ back.matrix.T + np.array(back.translation)
