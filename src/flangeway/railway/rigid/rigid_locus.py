"""Points of contact of a rigid wheelset over its positions, and where they jump."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from flangeway.railway.track.placements import Side, WheelsetPosition
from flangeway.types import Floats


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

    def part(self, chosen: slice | NDArray[np.int64]) -> "SideLocus":
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

    def part(self, chosen: slice | NDArray[np.int64]) -> "ContactLocus":
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
