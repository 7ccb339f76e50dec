"""Contact of a wheelset at a position in three dimensions, on given grids."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flangeway.railway.spatial.rolling.wheelset_creep import SideCreep, patches_of
from flangeway.railway.spatial.side_contact import SideState, WheelPose
from flangeway.railway.track.placements import SIDE_SIGN, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
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
    def status(self) -> Status:
        """Whether the contact forces were found."""
        each = [state.status for state in self.sides.values()]
        return Status(
            all(one.converged for one in each),
            "; ".join(one.message for one in each),
            sum(one.iterations for one in each),
        )

    def insides(self, side: Side) -> list[Bools] | None:
        """Cells of patches that roll by themselves, (n, n_z) each; None without friction, or by the exact theory."""
        insides = None if self.rolled is None else self.rolled.creep[side].insides
        return None if insides is None else patches_of(self.sides[side].forces, insides)

    @property
    def forces(self) -> Floats:
        """All contact forces in N."""
        return np.concatenate([state.forces.ravel() for state in self.sides.values()])


def signs_of(side: Side) -> Floats:
    """Signs of a force (x, y) and a moment, from the right-hand form of a side to the track's axes."""
    return np.array([SIDE_SIGN[side], 1.0, SIDE_SIGN[side]])


def pose_of(
    problem: WheelsetProblem, position: WheelsetPosition, side: Side, yaw_rad: float, tilt_rad: float = 0.0
) -> WheelPose:
    """Pose of a wheel in the right-hand form of its side."""
    sign = SIDE_SIGN[side]
    x, y = position.axle(problem.wheelset)
    seat = abs(problem.wheelset.placement(side).translation[0])
    return WheelPose(sign * x, y, sign * position.roll_rad, sign * yaw_rad, sign * tilt_rad, seat)
