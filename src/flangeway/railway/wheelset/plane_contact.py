"""Contact of a plane wheelset at a position: forces, residual of the equilibrium, and its derivatives."""

from dataclasses import dataclass

import numpy as np

from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.residual import RelativeResiduals, loads_of, with_loads
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState, StepSettings, follow, solve_contact
from flangeway.solve.sensitivity import motion_derivatives
from flangeway.types import Floats

NEXT_STEP = StepSettings(smallest=0.125)
"""Steps of contact on the way to the next position: where they fail, a shorter way is tried before shorter steps."""


@dataclass(frozen=True, eq=False)
class PlaneContact:
    """A plane wheelset as the search of its equilibrium sees it; see `AxleContact`.

    - `model`: meshed wheelset and track.
    - `response`: flexibilities of the bodies' surfaces.
    """

    model: WheelsetModel
    response: BodyResponse

    @property
    def problem(self) -> WheelsetProblem:
        """Loads, and what is prescribed."""
        return self.model.problem

    @property
    def rigid_position(self) -> WheelsetPosition:
        """Position in which the rigid wheelset touches."""
        return self.model.rigid_position

    def contact_at(
        self,
        position: WheelsetPosition,
        before: tuple[WheelsetPosition, ContactState] | None = None,
        start: WheelsetPosition | None = None,
    ) -> ContactState:
        """Contact forces at a position of the wheelset, by adaptive steps from one before.

        - `before`: a position and its contact forces.
        - `start`: without one before: where the wheels only just touch; the model's rigid equilibrium by default.
        """
        origin, state = before if before is not None else (self.rigid_position if start is None else start, None)
        change = position.moved(origin, -1.0)

        def solve_at(part: float, from_state: ContactState | None) -> ContactState:
            placements = self.model.placements(origin.moved(change, part))
            return solve_contact(self.response, self.model.system, placements, start=from_state)

        return follow(solve_at, state, None if before is None else NEXT_STEP)

    def residuals_of(self, position: WheelsetPosition, state: ContactState) -> tuple[Floats, RelativeResiduals]:
        """Residual of the wheelset's equilibrium and its relative values, in the current configuration.

        Returned: lateral force, vertical force and moment about the axle's middle in the track's axes (N, N, N mm), and
        the relative residuals.
        """
        forces = np.where(self.model.moving[self.response.body_of_node][:, None], state.nodal_forces, 0.0)
        arms = state.positions - position.axle(self.problem.wheelset)
        moment = float(arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0])
        return with_loads(self.problem, position, np.array([*forces.sum(axis=0), moment]))

    def jacobian_of(self, position: WheelsetPosition, state: ContactState) -> Floats:
        """Exact derivatives of the residual by lateral and vertical displacement and roll, shape (3, 3)."""
        axle = np.array(position.axle(self.problem.wheelset))
        derivatives = motion_derivatives(self.response, state, self.model.moving, axle)
        nodes = state.linearisation.nodes
        on_wheel = self.model.moving[self.response.body_of_node[nodes]]
        force, arm = state.nodal_forces[nodes[on_wheel]], state.positions[nodes[on_wheel]] - axle
        arm_change = derivatives.positions[on_wheel] - np.eye(2, 3)
        force_change = derivatives.nodal_forces[on_wheel]
        moment = force[:, 1] @ arm_change[:, 0] - force[:, 0] @ arm_change[:, 1]
        moment += arm[:, 0] @ force_change[:, 1] - arm[:, 1] @ force_change[:, 0]
        moment[2] += loads_of(self.problem).moment_by_roll(position.roll_rad)
        return np.vstack((force_change.sum(axis=0), moment))
