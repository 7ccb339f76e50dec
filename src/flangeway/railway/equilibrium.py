"""The position of the wheelset in which the contact forces balance its load (seed 7.2.1, without trial by hand)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.railway.model import WheelsetModel
from flangeway.railway.track import WheelsetMotion
from flangeway.solve import BodyResponse, ContactState, Status, follow, solve_contact
from flangeway.solve.sensitivity import QUARTER_TURN, motion_derivatives

Floats = NDArray[np.float64]

LATERAL_REFERENCE_N = 28.4e3
"""Reference of the lateral error in both situations: the centrifugal force of the curve (seed 7.2.2)."""

FIRST_PENETRATION_MM = 0.1
LARGEST_STEP = np.array([0.3, 0.3, 3e-4])  # mm, mm, rad: the lateral stiffness jumps when a flange touches
MAX_ITERATIONS = 40
TOLERANCE = 1e-12
ACCEPTED = 1e-10


@dataclass(frozen=True)
class Balance:
    """Relative errors of the equilibrium (seed 7.2.2).

    Parameters
    ----------
    vertical_error
        Residual of the vertical force over the load.
    lateral_error
        Residual of the lateral force over 28.4 kN.
    moment_error
        Residual of the moment about the barycentre over the moment of one side's contact forces.

    """

    vertical_error: float
    lateral_error: float
    moment_error: float

    @property
    def resulting_error(self) -> float:
        """Root of the sum of squares of the three errors."""
        return float(np.linalg.norm([self.vertical_error, self.lateral_error, self.moment_error]))


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A position of the wheelset and its contact forces.

    Parameters
    ----------
    status
        How the search ended.
    motion
        Motion of the wheelset from its reference position.
    balance
        Errors of the equilibrium in the current configuration.
    state
        Contact forces and displacements of the surfaces.

    """

    status: Status
    motion: WheelsetMotion
    balance: Balance
    state: ContactState


def find_equilibrium(
    model: WheelsetModel,
    response: BodyResponse,
    progress: Callable[[str], None] = lambda _: None,
) -> Equilibrium:
    """Find lateral and vertical motion and roll by Newton's method with the exact Jacobian.

    The search starts a little below first touch, where the forces have derivatives, and limits its steps.
    """
    motion = model.touch_motion.moved(WheelsetMotion(vertical_mm=-FIRST_PENETRATION_MM))
    state = contact_at(model, response, motion)
    best: Equilibrium | None = None
    for iteration in range(MAX_ITERATIONS):
        residual, balance = balance_of(model, response, motion, state)
        error = balance.resulting_error
        progress(f"balance {error:.1e} after {iteration} steps")
        failure = None
        if not state.status.converged:
            failure = f"the contact forces were not found: {state.status.message}"
        elif not state.forces.any():
            failure = "the wheels left the rails; check the load and the profiles"
        if failure is not None:
            return Equilibrium(Status(False, failure, iteration), motion, balance, state)
        if best is not None and error >= best.balance.resulting_error:
            return best  # round-off: the last step was no better
        if error <= ACCEPTED:
            message = f"contact forces balance the load to {error:.1e}"
            best = Equilibrium(Status(True, message, iteration), motion, balance, state)
            if error <= TOLERANCE:
                return best
        step = np.linalg.solve(_jacobian(model, response, motion, state), -residual)
        step /= max(1.0, float((np.abs(step) / LARGEST_STEP).max()))
        target = motion.moved(WheelsetMotion(*step))
        state = contact_at(model, response, target, (motion, state))
        motion = target
    failure = (
        f"no balance in {MAX_ITERATIONS} steps of at most {LARGEST_STEP[1]} mm, error {error:.1e}; check that these "
        "profiles can bear the load, and that load and Young's modulus are in the stated units"
    )
    return best or Equilibrium(Status(False, failure, MAX_ITERATIONS), motion, balance, state)


def contact_at(
    model: WheelsetModel,
    response: BodyResponse,
    motion: WheelsetMotion,
    known: tuple[WheelsetMotion, ContactState] | None = None,
) -> ContactState:
    """Contact forces at a position of the wheelset, by adaptive steps from a known one or from first touch."""
    start, state = known if known is not None else (model.touch_motion, None)
    change = WheelsetMotion(
        motion.lateral_mm - start.lateral_mm,
        motion.vertical_mm - start.vertical_mm,
        motion.roll_rad - start.roll_rad,
    )

    def solve_at(part: float, from_state: ContactState | None) -> ContactState:
        placements = model.placements(start.moved(change, part))
        return solve_contact(response, model.system, placements, start=from_state)

    return follow(solve_at, state)


def wheel_forces(model: WheelsetModel, response: BodyResponse, state: ContactState) -> Floats:
    """Contact forces on the wheels' surface nodes, zero on the rails', shape (n_nodes, 2)."""
    moves = model.moving[response.body_of_node]
    return np.where(moves[:, None], state.nodal_forces, 0.0)


def balance_of(
    model: WheelsetModel, response: BodyResponse, motion: WheelsetMotion, state: ContactState
) -> tuple[Floats, Balance]:
    """Residual of the wheelset's equilibrium and its relative errors, in the current configuration.

    Returns
    -------
    tuple
        Lateral force, vertical force and moment about the barycentre (N, N, N mm), and the errors.

    """
    load = model.problem.load.vertical_N
    forces = wheel_forces(model, response, state)
    arms = state.positions - np.array(motion.barycentre(model.problem.wheelset))
    moments = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
    right = np.array([side == "right" for side in model.sides])[response.body_of_node]
    lateral, vertical = forces.sum(axis=0) - (0.0, load)
    reference = float(np.abs(moments[right].sum())) or 1.0
    moment = moments.sum()
    balance = Balance(float(vertical / load), float(lateral / LATERAL_REFERENCE_N), float(moment / reference))
    return np.array([lateral, vertical, moment]), balance


def _jacobian(model: WheelsetModel, response: BodyResponse, motion: WheelsetMotion, state: ContactState) -> Floats:
    """Derivatives of the residual by lateral and vertical motion and roll, shape (3, 3)."""
    wheelset = model.problem.wheelset
    axle, barycentre = np.array(motion.axle(wheelset)), np.array(motion.barycentre(wheelset))
    derivatives = motion_derivatives(response, state, model.moving, axle)
    nodes = state.linearisation.nodes
    on_wheel = model.moving[response.body_of_node[nodes]]
    force = state.nodal_forces[nodes[on_wheel]]
    arm = state.positions[nodes[on_wheel]] - barycentre
    carried = np.column_stack((np.eye(2), QUARTER_TURN @ (barycentre - axle)))
    arm_change = derivatives.positions[on_wheel] - carried
    force_change = derivatives.nodal_forces[on_wheel]
    moment = np.einsum("nq,n->q", arm_change[:, 0], force[:, 1])
    moment -= np.einsum("nq,n->q", arm_change[:, 1], force[:, 0])
    moment += np.einsum("n,nq->q", arm[:, 0], force_change[:, 1])
    moment -= np.einsum("n,nq->q", arm[:, 1], force_change[:, 0])
    return np.vstack((force_change.sum(axis=0), moment))
