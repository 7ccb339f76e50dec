"""Contact of a wheelset at a position in three dimensions, on given grids."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flangeway.railway.rigid.elastic_start import RigidStart
from flangeway.railway.spatial.rolling.wheelset_creep import SideCreep, patches_of
from flangeway.railway.spatial.side_contact import GriddedSide, SideState, WheelPose
from flangeway.railway.spatial.side_newton import solve_side
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.residual import RelativeResiduals, loads_of, with_loads
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
        """Cells of the patches that roll, (n, n_z) each; None without friction."""
        if self.rolled is None:
            return None
        return patches_of(self.sides[side].forces, [each.inside for each in self.rolled.creep[side].patches])

    @property
    def forces(self) -> Floats:
        """All contact forces in N."""
        return np.concatenate([state.forces.ravel() for state in self.sides.values()])


@dataclass(frozen=True, eq=False)
class SpatialContact:
    """Contact of a wheelset on given grids; see `flangeway.railway.wheelset.equilibrium.AxleContact`."""

    problem: WheelsetProblem
    start: RigidStart
    grids: Mapping[Side, GriddedSide]
    yaw_rad: float = 0.0
    tilts: Floats = field(default_factory=lambda: np.zeros(2))
    tolerance: float = 1e-9

    @property
    def rigid_position(self) -> WheelsetPosition:
        """Position in which the rigid wheelset touches."""
        return self.start.motion

    def contact_at(
        self,
        position: WheelsetPosition,
        before: tuple[WheelsetPosition, SpatialState] | None = None,
        start: WheelsetPosition | None = None,
    ) -> SpatialState:
        """Contact at a position; the forces of one before on the same grids are the start."""
        del start
        found = {}
        for side in SIDES:
            grid = self.grids[side]
            last = None if before is None else before[1].sides[side]
            forces = last.forces if last is not None and last.grid is grid and last.forces.any() else None
            pose = pose_of(self.problem, position, side, self.yaw_rad, self.tilts[SIDES.index(side)])
            found[side] = solve_side(grid, pose, forces, self.tolerance)
        return SpatialState(found)

    def residuals_of(self, position: WheelsetPosition, state: SpatialState) -> tuple[Floats, RelativeResiduals]:
        """See `flangeway.railway.wheelset.residual.with_loads`."""
        total = np.zeros(3)
        for side, found in state.sides.items():
            total += signs_of(side) * found.resultant
        return with_loads(self.problem, position, total)

    def jacobian_of(self, position: WheelsetPosition, state: SpatialState) -> Floats:
        """Derivatives of the residual by lateral and vertical displacement and roll, shape (3, 3)."""
        total = np.zeros((3, 3))
        for side, found in state.sides.items():
            signs = signs_of(side)
            total += signs[:, None] * found.stiffness[:, :3] * signs
        total[2, 2] += loads_of(self.problem).moment_by_roll(position.roll_rad)
        return total


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
