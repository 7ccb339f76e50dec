"""One rigid wheel over one rigid rail: where it touches first when it comes down, for many positions at once.

Everything here is in the right-hand form of a side: x grows from the track's middle to the field side. The left side is
the mirror image, with the opposite lateral motion and roll.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid_curve import RigidCurve
from flangeway.railway.track import Side, Track, Wheelset, mirrored

Floats = NDArray[np.float64]

N_TOUCHES = 6
"""Places of a side that are followed: the touch, and the next smallest gaps."""

_SPACING_MM = 0.2
_TABLE_MM = 0.005
_CHUNK = 128
_SAME_MM = 1e-6
_ARC_TOLERANCE_MM = 1e-12


class Touches(NamedTuple):
    """Places where a wheel touches or comes close, arrays (n, N_TOUCHES), the first touch first.

    Parameters
    ----------
    lift
        Height of the axle's middle over the track at which this place touches, -inf where there is no such place.
    wheel_arc
        Length along the wheel's curve.
    x, y
        Place on the rail in the track's axes, right-hand form.
    angle
        Angle of the common tangent from the track's plane, positive towards the flange.
    relative_curvature
        Sum of the curvatures of wheel and rail, convex positive.

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

    Parameters
    ----------
    wheel
        About the middle of the axle: x to the field side, y up, so that -y is the rolling radius.
    rail
        In the track's axes.
    wheel_frame, rail_frame
        From the frames of the profiles to those of the curves.

    """

    wheel: RigidCurve
    rail: RigidCurve
    wheel_frame: Placement = field(default_factory=Placement)
    rail_frame: Placement = field(default_factory=Placement)

    @classmethod
    def of(cls, track: Track, wheelset: Wheelset, side: Side) -> "RigidSide":
        """Return a side of a wheelset on a track, on the track's side of the same name."""
        rail_frame, reference = track.placement(side), wheelset.placement(side)
        if side == "left":
            rail_frame, reference = mirrored(rail_frame), mirrored(reference)
        wheel_frame = Placement(0.0, (0.0, -wheelset.tape_radius_mm)).after(reference)
        wheel, rail = wheelset.wheel_of(side), track.rail_of(side)
        return cls(
            RigidCurve.from_contour(wheel.outline.part(wheel.running_names), wheel_frame),
            RigidCurve.from_contour(rail.outline.part(rail.head_names), rail_frame),
            wheel_frame,
            rail_frame,
        )

    @cached_property
    def _rail_heights(self) -> tuple[float, Floats]:
        """First x and heights of the rail on a grid, a little wider than its head."""
        first, last = self.rail.joints[[0, -1]]
        x = np.arange(first - 1.0, last + 1.0, _TABLE_MM)
        return float(x[0]), self.rail.over(x).y

    def over_rail(self, lateral: Floats) -> NDArray[np.bool_]:
        """Whether some of the wheel stands over the rail's head, (n,)."""
        return (lateral + self.wheel.joints[-1] > self.rail.joints[0]) & (
            lateral + self.wheel.joints[0] < self.rail.joints[-1]
        )

    def touches(self, lateral: Floats, roll: Floats) -> Touches:
        """First touch and next smallest gaps of a wheel that comes down.

        Parameters
        ----------
        lateral, roll
            Position of the axle's middle to the field side, and roll that lifts this wheel, each (n,).

        Raises
        ------
        InputError
            If no point of the wheel stands over the rail's head.

        """
        over = self.over_rail(lateral)
        if not over.all():
            worst = float(lateral[~over][np.argmax(np.abs(lateral[~over]))])
            raise InputError(
                f"a wheel moved by {worst:.1f} mm, beside its rail",
                "positions in which the wheel stands over the head of its rail",
                "check gauge, back-to-back distance and lateral motion",
            )
        parts = [
            self._touches(lateral[i : i + _CHUNK], roll[i : i + _CHUNK]) for i in range(0, max(len(lateral), 1), _CHUNK)
        ]
        return Touches(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _touches(self, lateral: Floats, roll: Floats) -> Touches:
        low, high = self._brackets(lateral, roll)
        there = np.isfinite(low)
        number = np.nonzero(there)[0]
        arc = self._refined(lateral[number], roll[number], low[there], high[there])
        placed = self._placed(lateral[number], roll[number], arc)
        columns = [np.full(there.shape, fill) for fill in (-np.inf, *[np.nan] * 5)]
        for column, values in zip(columns, placed, strict=True):
            column[there] = values
        order = np.argsort(-columns[0], axis=1, kind="stable")
        sorted_columns = [np.take_along_axis(column, order, axis=1) for column in columns]
        # two brackets that met at one place
        for earlier in range(N_TOUCHES - 1):
            gap = sorted_columns[1][:, earlier + 1 :] - sorted_columns[1][:, earlier, None]
            sorted_columns[0][:, earlier + 1 :][np.abs(gap) < _SAME_MM] = -np.inf
        order = np.argsort(-sorted_columns[0], axis=1, kind="stable")
        return Touches(*(np.take_along_axis(column, order, axis=1) for column in sorted_columns))

    def _brackets(self, lateral: Floats, roll: Floats) -> tuple[Floats, Floats]:
        """Lengths along the wheel about its highest places over the rail, (n, N_TOUCHES) each, nan for none."""
        first, last = self.rail.joints[[0, -1]]
        n_samples = int(np.ceil(self.wheel.length / _SPACING_MM)) + 1
        arcs = np.linspace(0.0, self.wheel.length, n_samples)
        wheel = self.wheel.at(arcs)
        near = (wheel.x + lateral.max() > first - 3.0) & (wheel.x + lateral.min() < last + 3.0)
        arcs, x, y = arcs[near], wheel.x[near], wheel.y[near]
        cosine, sine = np.cos(roll)[:, None], np.sin(roll)[:, None]
        over = lateral[:, None] + cosine * x - sine * y
        origin, heights = self._rail_heights
        position = np.clip((over - origin) / _TABLE_MM, 0.0, len(heights) - 1.001)
        cell = position.astype(np.int64)
        part = position - cell
        lift = (1.0 - part) * heights[cell] + part * heights[cell + 1] - (sine * x + cosine * y)
        lift[(over < first - 0.5) | (over > last + 0.5)] = -np.inf
        highest = np.full(lift.shape, -np.inf)
        inner = lift[:, 1:-1]
        highest[:, 1:-1] = np.where((inner >= lift[:, :-2]) & (inner > lift[:, 2:]), inner, -np.inf)
        # the ends count: a touch there is a touch at the edge of a profile
        highest[:, 0] = np.where(lift[:, 0] > lift[:, 1], lift[:, 0], -np.inf)
        highest[:, -1] = np.where(lift[:, -1] > lift[:, -2], lift[:, -1], -np.inf)
        n_kept = min(N_TOUCHES, highest.shape[1])
        best = np.argpartition(-highest, n_kept - 1, axis=1)[:, :n_kept]
        there = np.isfinite(np.take_along_axis(highest, best, axis=1))
        low = np.where(there, arcs[np.maximum(best - 1, 0)], np.nan)
        high = np.where(there, arcs[np.minimum(best + 1, len(arcs) - 1)], np.nan)
        missing = ((0, 0), (0, N_TOUCHES - n_kept))
        return np.pad(low, missing, constant_values=np.nan), np.pad(high, missing, constant_values=np.nan)

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
            step = -difference / np.where(slope < 0.0, slope, -np.inf)
            target = s + step
            inside = (slope < 0.0) & (target > low[active]) & (target < high[active])
            new = np.where(inside, target, 0.5 * (low[active] + high[active]))
            arc[active] = new
            done = np.abs(new - s) < _ARC_TOLERANCE_MM * (1.0 + np.abs(s))
            done |= difference == 0.0
            arc[active] = np.where(difference == 0.0, s, new)
            active = active[~done]
            if not len(active):
                break
        return arc

    def _placed(self, lateral: Floats, roll: Floats, arc: Floats) -> Touches:
        wheel = self.wheel.at(arc)
        cosine, sine = np.cos(roll), np.sin(roll)
        rail = self.rail.over(lateral + cosine * wheel.x - sine * wheel.y)
        lift = rail.y - (sine * wheel.x + cosine * wheel.y)
        return Touches(lift, arc, rail.x, rail.y, rail.angle, wheel.curvature - rail.curvature)

    def at_edge(self, touches: Touches) -> NDArray[np.bool_]:
        """Whether the first touch is at an end of the wheel's or the rail's running surface, (n,)."""
        arc, x = touches.wheel_arc[:, 0], touches.x[:, 0]
        ends = self.rail.joints[[0, -1]]
        on_wheel = (arc < 1e-9) | (arc > self.wheel.length - 1e-9)
        return on_wheel | (x <= ends[0]) | (x >= ends[1])
