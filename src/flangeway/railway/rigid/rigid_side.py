"""One rigid wheel over one rigid rail: where it touches first when it comes down, for many positions at once.

Everything here is in the right-hand form of a side: x grows from the track's middle to the field side. The left side is
the mirror image, with the opposite lateral displacement and roll.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid.rigid_curve import CurvePoints, RigidCurve, on_profile, outline_across
from flangeway.railway.track.placements import Side, Track, Wheelset, mirrored
from flangeway.types import Floats
from flangeway.units import sentence

N_TOUCHES = 6  # points of a side that are followed: the touch, and the next smallest gaps

_SPACING_MM = 0.2
_TABLE_MM = 0.005
_CHUNK = 128
_FIRST_MARGIN_MM = 0.2  # by which a sample may be lower than the highest one and yet touch first
_SAME_MM = 1e-6
_ARC_TOLERANCE_MM = 1e-12
_CORNER_RAD = 1e-6  # difference of the angles of wheel and rail where they touch, above which one has a corner


class Touches(NamedTuple):
    """Points where a wheel touches or comes close, arrays (n, N_TOUCHES) or (n, 1), the first touch first.

    - `lift`: height of the axle's middle over the track at which this point touches, -inf where there is none.
    - `wheel_arc`: length along the wheel's curve.
    - `x`, `y`: point of the rail in the track's axes, right-hand form.
    - `angle`: angle of the common tangent from the track's plane, positive towards the flange.
    - `relative_curvature`: sum of the curvatures of wheel and rail, convex positive.
    """

    lift: Floats
    wheel_arc: Floats
    x: Floats
    y: Floats
    angle: Floats
    relative_curvature: Floats


@dataclass(frozen=True, eq=False)
class RigidSide:
    """A wheel and its rail as rigid curves.

    - `wheel`: its outline in the longitudinal view, about the middle of the axle: x to the field side, y up. Without
      yaw that is the profile, and -y is the rolling radius.
    - `rail`: in the track's axes.
    - `wheel_frame`, `rail_frame`: from the frames of the profiles to those of the curves.
    - `yaw_rad`: yaw of the wheel, positive where it is ahead of the other one; see `outline_across`.
    """

    wheel: RigidCurve
    rail: RigidCurve
    wheel_frame: Placement = field(default_factory=Placement)
    rail_frame: Placement = field(default_factory=Placement)
    yaw_rad: float = 0.0

    @classmethod
    def of(cls, track: Track, wheelset: Wheelset, side: Side, yaw_rad: float = 0.0) -> "RigidSide":
        """Return a side of a wheelset on a track, on the track's side of the same name."""
        rail_frame, reference = track.placement(side), wheelset.placement(side)
        if side == "left":
            rail_frame, reference = mirrored(rail_frame), mirrored(reference)
        wheel_frame = Placement(0.0, (0.0, -wheelset.tape_radius_mm)).after(reference)
        wheel, rail = wheelset.wheel_of(side), track.rail_of(side)
        profile = RigidCurve.from_contour(wheel.running_surface, wheel_frame)
        return cls(
            outline_across(profile, yaw_rad),
            RigidCurve.from_contour(rail.running_surface, rail_frame),
            wheel_frame,
            rail_frame,
            yaw_rad if side == "right" else -yaw_rad,
        )

    def on_wheel(self, wheel_arc: Floats) -> tuple[Floats, Floats, Floats]:
        """Position along the axle, rolling radius, distance ahead of the axle; at lengths along the wheel's outline."""
        at = self.wheel.at(wheel_arc)
        return on_profile(at.x, at.y, at.angle, self.yaw_rad)

    @cached_property
    def _rail_heights(self) -> tuple[float, Floats]:
        """First x and heights of the rail on a grid, a little wider than its head."""
        first, last = self.rail.joints[[0, -1]]
        x = np.arange(first - 1.0, last + 1.0, _TABLE_MM)
        return float(x[0]), self.rail.over(x).y

    def over_rail(self, lateral: Floats) -> NDArray[np.bool_]:
        """Whether some of the wheel is above the rail's head, (n,)."""
        return (lateral + self.wheel.joints[-1] > self.rail.joints[0]) & (
            lateral + self.wheel.joints[0] < self.rail.joints[-1]
        )

    def touches(self, lateral: Floats, roll: Floats, *, first_only: bool = False) -> Touches:
        """First touch and next smallest gaps of a wheel that comes down.

        An `InputError` if no point of the wheel is above the rail's head.

        - `lateral`, `roll`: position of the axle's middle to the field side, and roll that lifts this wheel, each (n,).
        - `first_only`: whether the next smallest gaps are left out: arrays (n, 1).
        """
        over = self.over_rail(lateral)
        if not over.all():
            worst = float(lateral[~over][np.argmax(np.abs(lateral[~over]))])
            inside = self.rail.joints[0] - self.wheel.joints[-1] - worst
            outside = worst + self.wheel.joints[0] - self.rail.joints[-1]
            raise InputError(
                sentence(
                    "a lateral displacement of {:.1f mm}, with which the wheel misses the rail by {:.1f mm}",
                    worst,
                    max(inside, outside),
                ),
                "displacements with the wheel above the head of its rail",
                f"{'lower' if inside > 0.0 else 'raise'} gauge_mm or {'raise' if inside > 0.0 else 'lower'} "
                "back_to_back_mm, or give a smaller displacement",
            )
        margin = _FIRST_MARGIN_MM if first_only else np.inf
        number, low, high = (
            np.concatenate(column)
            for column in zip(
                *(self._brackets(lateral, roll, slice(i, i + _CHUNK), margin) for i in range(0, len(lateral), _CHUNK)),
                strict=True,
            )
        )
        placed = self._placed(lateral[number], roll[number], self._refined(lateral[number], roll[number], low, high))
        # two brackets that met at one point are one touch
        order = np.lexsort((placed.wheel_arc, number))
        again = (np.diff(placed.wheel_arc[order]) < _SAME_MM) & (np.diff(number[order]) == 0)
        order = order[np.concatenate(([True], ~again))]
        order = order[np.lexsort((-placed.lift[order], number[order]))]
        row = number[order]
        rank = np.arange(len(row)) - np.searchsorted(row, row)
        n_kept = 1 if first_only else N_TOUCHES
        order, row, rank = order[rank < n_kept], row[rank < n_kept], rank[rank < n_kept]
        columns = [np.full((len(lateral), n_kept), fill) for fill in (-np.inf, *[np.nan] * 5)]
        for column, values in zip(columns, placed, strict=True):
            column[row, rank] = values[order]
        return Touches(*columns)

    @cached_property
    def _samples(self) -> tuple[Floats, CurvePoints]:
        """Lengths along the wheel at which its height over the rail is sampled, and the points there."""
        arcs = np.linspace(0.0, self.wheel.length, int(np.ceil(self.wheel.length / _SPACING_MM)) + 1)
        return arcs, self.wheel.at(arcs)

    def _brackets(
        self, lateral: Floats, roll: Floats, part: slice, margin: float
    ) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Numbers of positions, and brackets of lengths along the wheel about its local maxima over the rail.

        Maxima lower than the highest one by more than a margin are left out.
        """
        lateral, roll = lateral[part], roll[part]
        first, last = self.rail.joints[[0, -1]]
        arcs, wheel = self._samples
        # roll moves the wheel's lower part across by its radius times the angle
        across = lateral[:, None] - np.sin(roll)[:, None] * [wheel.y.min(), wheel.y.max()]
        near = np.flatnonzero((wheel.x + across.max() > first - 3.0) & (wheel.x + across.min() < last + 3.0))
        within = slice(near[0], near[-1] + 1)
        arcs, x, y = arcs[within], wheel.x[within], wheel.y[within]
        cosine, sine = np.cos(roll)[:, None], np.sin(roll)[:, None]
        over = lateral[:, None] + cosine * x - sine * y
        origin, heights = self._rail_heights
        position = np.clip((over - origin) / _TABLE_MM, 0.0, len(heights) - 1.001)
        cell = position.astype(np.int64)
        position -= cell
        lift = heights[cell]
        lift += position * (heights[cell + 1] - lift) - (sine * x + cosine * y)
        lift[(over < first - 0.5) | (over > last + 0.5)] = -np.inf
        # with the ends: a touch there is one at the edge of a profile
        highest = np.isfinite(lift) & (lift >= lift.max(axis=1, keepdims=True) - margin)
        highest[:, 1:] &= lift[:, 1:] >= lift[:, :-1]
        highest[:, :-1] &= lift[:, :-1] > lift[:, 1:]
        row, column = np.nonzero(highest)
        return row + part.start, arcs[np.maximum(column - 1, 0)], arcs[np.minimum(column + 1, len(arcs) - 1)]

    def _refined(self, lateral: Floats, roll: Floats, low: Floats, high: Floats) -> Floats:
        """Lengths along the wheel where the tangents of wheel and rail agree, by Newton kept in a bracket."""
        low, high = low.copy(), high.copy()
        arc = 0.5 * (low + high)
        active = np.arange(len(arc))
        for _ in range(100):
            s = arc[active]
            y, turn = lateral[active], roll[active]
            wheel = self.wheel.at(s)
            rail = self.rail.over(y + np.cos(turn) * wheel.x - np.sin(turn) * wheel.y)
            wheel_angle = wheel.angle + turn
            difference = rail.angle - wheel_angle
            rises = difference > 0.0
            low[active] = np.where(rises, s, low[active])
            high[active] = np.where(rises, high[active], s)
            slope = rail.curvature * np.cos(wheel_angle) / np.cos(rail.angle) - wheel.curvature
            falls = slope < 0.0
            step = np.where(falls, -difference / np.where(falls, slope, -1.0), np.inf)
            tolerance = _ARC_TOLERANCE_MM * (1.0 + np.abs(s))
            # in the end the root is an end of the bracket: a short step is the last one
            converged = (difference == 0.0) | (np.abs(step) < tolerance)
            target = np.where(difference == 0.0, s, s + step)
            inside = (target > low[active]) & (target < high[active])
            bisected = 0.5 * (low[active] + high[active])
            new = np.where(converged, np.clip(target, low[active], high[active]), np.where(inside, target, bisected))
            arc[active] = new
            active = active[~converged & (np.abs(new - s) >= tolerance)]
            if not len(active):
                break
        return arc

    def _placed(self, lateral: Floats, roll: Floats, arc: Floats) -> Touches:
        wheel = self.wheel.at(arc)
        cosine, sine = np.cos(roll), np.sin(roll)
        rail = self.rail.over(lateral + cosine * wheel.x - sine * wheel.y)
        lift = rail.y - (sine * wheel.x + cosine * wheel.y)
        # a corner of the rail has all angles between those of its sides, and is touched with that of the wheel
        angle, of_wheel = rail.angle.copy(), wheel.angle + roll
        corner = np.flatnonzero(np.abs(angle - of_wheel) > _CORNER_RAD)
        beside = [self.rail.over(rail.x[corner] + step).angle for step in (_SAME_MM, -_SAME_MM)]
        angle[corner] = np.clip(of_wheel[corner], *np.sort(beside, axis=0))
        return Touches(lift, arc, rail.x, rail.y, angle, wheel.curvature - rail.curvature)

    def close_arcs(self, lateral: float, roll: float, lift: float, gap_mm: float) -> Floats:
        """Lengths along the wheel, from first to last, at which it is over the rail by less than a gap, (n,).

        - `lateral`, `roll`: position of the wheel; see `touches`.
        - `lift`: height of the axle's middle.
        - `gap_mm`: largest vertical gap.
        """
        arcs = self._samples[0]
        placed = self._placed(np.full(len(arcs), lateral), np.full(len(arcs), roll), arcs)
        over = (placed.x >= self.rail.joints[0]) & (placed.x <= self.rail.joints[-1])
        return arcs[over & (lift - placed.lift < gap_mm)]

    def at_edge(self, touches: Touches) -> NDArray[np.bool_]:
        """Whether the first touch is at an end of the wheel's or the rail's running surface, (n,)."""
        arc, x = touches.wheel_arc[:, 0], touches.x[:, 0]
        ends = self.rail.joints[[0, -1]]
        on_wheel = (arc < 1e-9) | (arc > self.wheel.length - 1e-9)
        return on_wheel | (x <= ends[0]) | (x >= ends[1])
