"""Exact derivatives of contact forces by rigid motions of some of the parts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.solve.body_response import BodyResponse
from flangeway.solve.linearisation import contact_loads
from flangeway.solve.newton import ContactState
from flangeway.types import Floats

QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class MotionDerivatives:
    """Derivatives by translations in x and y and a rotation of the moving parts, in this order.

    Of the positions of the nodes in ``state.linearisation.nodes`` and of the contact forces on them, (n_touched, 2, 3).
    """

    positions: Floats
    nodal_forces: Floats


def motion_derivatives(
    response: BodyResponse, state: ContactState, moving: NDArray[np.bool_], pivot: Floats
) -> MotionDerivatives:
    """Differentiate a converged contact problem, its active set held.

    A part's deformation turns with it, so a rotation also turns the flexibility against the forces, which stay in
    space: ``dx = F (B^T dp - G dx + J^T f dtheta) + V dq`` with the rigid velocities V and the quarter turn J, and
    ``B dx + C dp = 0`` on the active set.

    Parameters
    ----------
    response
        The bodies.
    state
        A converged solution.
    moving
        Which parts move, shape (n_parts,).
    pivot
        Point about which they turn, shape (2,).

    """
    lin = state.linearisation
    nodes, n = lin.nodes, len(lin.nodes)
    rotations = response.rotations(state.placements)
    moves = moving[response.body_of_node[nodes]]

    velocities = np.zeros((n, 2, 3))
    velocities[moves, 0, 0] = 1.0
    velocities[moves, 1, 1] = 1.0
    velocities[moves, :, 2] = (state.positions[nodes[moves]] - pivot) @ QUARTER_TURN.T
    turned = np.zeros((n, 2, 3))
    turned[moves, :, 2] = state.nodal_forces[nodes[moves]] @ QUARTER_TURN

    geometric = lin.curvature(-state.forces)
    active = state.forces > 0.0
    jacobian = lin.jacobian[active]
    rigid = velocities.reshape(2 * n, 3)
    loads = contact_loads(jacobian, turned.reshape(2 * n, 3) - geometric @ rigid)
    answer = response.respond(rotations, nodes, geometric, loads)
    by_force = answer[:, :-3]
    by_motion = rigid + answer[:, -3:]
    matrix = jacobian @ by_force + np.diag(lin.compliances[active])
    force_change = -np.linalg.solve(matrix, jacobian @ by_motion)
    positions = by_force @ force_change + by_motion
    nodal = jacobian.T @ force_change - geometric @ positions
    return MotionDerivatives(positions.reshape(n, 2, 3), nodal.reshape(n, 2, 3))
