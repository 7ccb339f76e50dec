"""Forces and moment that are left on the wheelset, and how they change with its motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.railway.track.placements import WheelsetMotion
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState
from flangeway.solve.sensitivity import QUARTER_TURN, motion_derivatives
from flangeway.types import Floats

LATERAL_REFERENCE_N = 28.4e3
"""Reference of the lateral error in both situations: the centrifugal force of the curve (Moherdaui 2021, 7.2.2)."""


@dataclass(frozen=True)
class RelativeResiduals:
    """Relative errors of the equilibrium (Moherdaui 2021, 7.2.2).

    Parameters
    ----------
    vertical_residual
        Residual of the vertical force over the load.
    lateral_residual
        Residual of the lateral force over 28.4 kN.
    moment_residual
        Residual of the moment about the centre of gravity over the moment of one side's contact forces.
    free
        Which of lateral and vertical motion and roll are found by balance; the others are prescribed, and their
        residuals are what holds the wheelset.

    """

    vertical_residual: float
    lateral_residual: float
    moment_residual: float
    free: tuple[bool, bool, bool] = (True, True, True)

    @property
    def equilibrium_residual(self) -> float:
        """Root of the sum of squares of the errors of what is free."""
        return self.error_of(np.array(self.free))

    def error_of(self, free: NDArray[np.bool_]) -> float:
        """Root of the sum of squares of some errors, in the order of lateral and vertical motion and roll."""
        return float(
            np.linalg.norm(np.array([self.lateral_residual, self.vertical_residual, self.moment_residual])[free])
        )


def wheel_forces(model: WheelsetModel, response: BodyResponse, state: ContactState) -> Floats:
    """Contact forces on the wheels' surface nodes, zero on the rails', shape (n_nodes, 2)."""
    moves = model.moving[response.body_of_node]
    return np.where(moves[:, None], state.nodal_forces, 0.0)


def residuals_of(
    model: WheelsetModel, response: BodyResponse, motion: WheelsetMotion, state: ContactState
) -> tuple[Floats, RelativeResiduals]:
    """Residual of the wheelset's equilibrium and its relative errors, in the current configuration.

    Returns
    -------
    tuple
        Lateral force, vertical force and moment about the centre of gravity in the track's axes (N, N, N mm), and the
        errors. With a prescribed motion, the moment is that about the axle's middle, where the wheelset is held.

    """
    problem = model.problem
    along, onto = problem.load.in_track
    forces = wheel_forces(model, response, state)
    axle, centre_of_gravity = (
        np.array(motion.axle(problem.wheelset)),
        np.array(motion.centre_of_gravity(problem.wheelset)),
    )
    arms = state.positions - centre_of_gravity
    moments = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
    right = np.array([side == "right" for side in model.sides])[response.body_of_node]
    lateral, vertical = forces.sum(axis=0) + np.array([along, -onto])
    reference = float(np.abs(moments[right].sum())) or 1.0
    moment = moments.sum()
    if _is_held(model):
        x, y = centre_of_gravity - axle
        moment += x * vertical - y * lateral
    free = [value is None for value in problem.prescribed.components]
    balance = RelativeResiduals(
        float(vertical / problem.load.vertical_N),
        float(lateral / LATERAL_REFERENCE_N),
        float(moment / reference),
        (free[0], free[1], free[2]),
    )
    return np.array([lateral, vertical, moment]), balance


def _is_held(model: WheelsetModel) -> bool:
    return any(value is not None for value in model.problem.prescribed.components)


def jacobian_of(model: WheelsetModel, response: BodyResponse, motion: WheelsetMotion, state: ContactState) -> Floats:
    """Exact derivatives of the residual by lateral and vertical motion and roll, shape (3, 3)."""
    wheelset = model.problem.wheelset
    axle, centre_of_gravity = np.array(motion.axle(wheelset)), np.array(motion.centre_of_gravity(wheelset))
    derivatives = motion_derivatives(response, state, model.moving, axle)
    nodes = state.linearisation.nodes
    on_wheel = model.moving[response.body_of_node[nodes]]
    force = state.nodal_forces[nodes[on_wheel]]
    arm = state.positions[nodes[on_wheel]] - centre_of_gravity
    carried = np.column_stack((np.eye(2), QUARTER_TURN @ (centre_of_gravity - axle)))
    arm_change = derivatives.positions[on_wheel] - carried
    force_change = derivatives.nodal_forces[on_wheel]
    moment = np.einsum("nq,n->q", arm_change[:, 0], force[:, 1])
    moment -= np.einsum("nq,n->q", arm_change[:, 1], force[:, 0])
    moment += np.einsum("n,nq->q", arm[:, 0], force_change[:, 1])
    moment -= np.einsum("n,nq->q", arm[:, 1], force_change[:, 0])
    total = force_change.sum(axis=0)
    if _is_held(model):
        residual = residuals_of(model, response, motion, state)[0]
        x, y = centre_of_gravity - axle
        moment += x * total[1] - y * total[0]
        moment[2] += -y * residual[1] - x * residual[0]
    return np.vstack((total, moment))


def is_stable(model: WheelsetModel, motion: WheelsetMotion, jacobian: Floats) -> bool:
    """Whether a wheelset in balance comes back after a small push: contact and load have a potential.

    Parameters
    ----------
    model
        The wheelset.
    motion
        Where it is in balance, nothing prescribed.
    jacobian
        Derivatives of the residual there.

    """
    wheelset = model.problem.wheelset
    x, y = np.array(motion.centre_of_gravity(wheelset)) - np.array(motion.axle(wheelset))
    about_axle = jacobian.copy()
    about_axle[2] += x * jacobian[1] - y * jacobian[0]
    # in units of one length, so that the roll weighs as much as the motions
    scale = np.diag([1.0, 1.0, 1.0 / wheelset.back_to_back_mm])
    stiffness = -scale @ about_axle @ scale
    return bool(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0.0)
