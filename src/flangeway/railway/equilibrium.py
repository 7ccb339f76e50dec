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
FIRST_CAP = np.array([0.3, 0.3, 3e-4])  # mm, mm, rad: the lateral stiffness jumps when a flange touches
LARGEST_GROWTH = 64.0
SMALLEST_GROWTH = 1.0 / 1024.0
MAX_ITERATIONS = 60
TOLERANCE = 1e-12
ACCEPTED = 1e-10
LOWERED = 0.05
"""Vertical error below which the wheelset is free to move aside and to roll."""

DOWN = np.array([False, True, False])
WORSE = 4.0
"""Growth of the error above which a step is taken back and tried at a quarter of its length."""


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
    """Find the components of the motion that are not prescribed by Newton's method with the exact Jacobian.

    The search starts a little below the place where rigid wheels would rest, where the forces have derivatives. Steps
    are limited; the limit grows while they lead on and shrinks when one makes the balance much worse.
    """
    free = np.array([value is None for value in model.problem.prescribed.components])
    # down first: a wheelset that hangs on its flanges slips aside before they have pushed the rails apart
    now = free & DOWN if (free & DOWN).any() else free
    motion = _start(model)
    state = contact_at(model, response, motion)
    best: Equilibrium | None = None
    growth, last_error = 1.0, np.inf
    safe = (motion, state)
    for iteration in range(MAX_ITERATIONS):
        residual, balance = balance_of(model, response, motion, state)
        error = _error(balance, now)
        if error < LOWERED and now is not free:
            now, growth, last_error = free, 1.0, np.inf
            error = _error(balance, free)
        progress(f"balance {error:.1e} after {iteration} steps")
        failed = not state.status.converged or not state.forces.any()
        if iteration and (failed or error > WORSE * last_error) and growth > SMALLEST_GROWTH and best is None:
            growth /= 4.0
            motion, state = safe
            residual, balance = balance_of(model, response, motion, state)
        elif failed:
            failure = f"the contact forces were not found: {state.status.message}"
            if state.status.converged:
                failure = "the wheels left the rails; check the load and the profiles"
            return Equilibrium(Status(False, failure, iteration), motion, balance, state)
        else:
            if best is not None and error >= _error(best.balance, free):
                return best  # round-off: the last step was no better
            if error <= ACCEPTED and now is free:
                message = f"contact forces balance the load to {error:.1e}"
                best = Equilibrium(Status(True, message, iteration), motion, balance, state)
                if error <= TOLERANCE or not free.any():
                    return best
            last_error, safe = error, (motion, state)
        if not free.any():
            message = "contact forces at the prescribed position"
            return Equilibrium(Status(True, message, iteration), motion, balance, state)
        step, limited = _step(model, response, motion, state, residual, growth * FIRST_CAP, now)
        growth = min(2.0 * growth, LARGEST_GROWTH) if limited and safe[1] is state else growth
        target = motion.moved(WheelsetMotion(*step))
        state = contact_at(model, response, target, safe)
        motion = target
    failure = (
        f"no balance in {MAX_ITERATIONS} steps, error {error:.1e}; check that these profiles can bear the load, and "
        "that load and Young's modulus are in the stated units"
    )
    return best or Equilibrium(Status(False, failure, MAX_ITERATIONS), motion, balance, state)


def _start(model: WheelsetModel) -> WheelsetMotion:
    """Return a position in which both wheels press on the rails, with what is prescribed."""
    rest = model.start_motion.moved(WheelsetMotion(vertical_mm=-FIRST_PENETRATION_MM))
    given = model.problem.prescribed
    return WheelsetMotion(
        rest.lateral_mm if given.lateral_mm is None else given.lateral_mm,
        rest.vertical_mm if given.vertical_mm is None else given.vertical_mm,
        rest.roll_rad if given.roll_rad is None else given.roll_rad,
    )


def _error(balance: Balance, free: NDArray[np.bool_]) -> float:
    """Resulting error of the balance of what is not prescribed."""
    return float(np.linalg.norm(np.array([balance.lateral_error, balance.vertical_error, balance.moment_error])[free]))


def _step(
    model: WheelsetModel,
    response: BodyResponse,
    motion: WheelsetMotion,
    state: ContactState,
    residual: Floats,
    cap: Floats,
    free: NDArray[np.bool_],
) -> tuple[Floats, bool]:
    """Newton's step of the free components within a cap, and whether the cap limited it."""
    jacobian = _jacobian(model, response, motion, state)
    step = np.zeros(3)
    system = jacobian[np.ix_(free, free)]
    # one wheel alone may have no stiffness in some direction: the least of all steps then
    step[free] = np.linalg.lstsq(system * cap[free], -residual[free], rcond=1e-14)[0] * cap[free]
    if np.array_equal(free, DOWN) and step[1] * residual[1] < 0.0:
        # where a flange gives way the force falls as the wheelset sinks: go on
        step[1] = np.sign(residual[1]) * cap[1]
    excess = float((np.abs(step) / cap).max())
    return step / max(1.0, excess), excess > 1.0


def contact_at(
    model: WheelsetModel,
    response: BodyResponse,
    motion: WheelsetMotion,
    known: tuple[WheelsetMotion, ContactState] | None = None,
) -> ContactState:
    """Contact forces at a position of the wheelset, by adaptive steps from a known one or from first touch."""
    start, state = known if known is not None else (model.start_motion, None)
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
        Lateral force, vertical force and moment about the barycentre in the track's axes (N, N, N mm), and the errors.
        With a prescribed motion, the moment is that about the axle's middle, where the wheelset is held.

    """
    problem = model.problem
    along, onto = problem.load.in_track
    forces = wheel_forces(model, response, state)
    axle, barycentre = np.array(motion.axle(problem.wheelset)), np.array(motion.barycentre(problem.wheelset))
    arms = state.positions - barycentre
    moments = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
    right = np.array([side == "right" for side in model.sides])[response.body_of_node]
    lateral, vertical = forces.sum(axis=0) + np.array([along, -onto])
    reference = float(np.abs(moments[right].sum())) or 1.0
    moment = moments.sum()
    if _is_held(model):
        x, y = barycentre - axle
        moment += x * vertical - y * lateral
    balance = Balance(
        float(vertical / problem.load.vertical_N), float(lateral / LATERAL_REFERENCE_N), float(moment / reference)
    )
    return np.array([lateral, vertical, moment]), balance


def _is_held(model: WheelsetModel) -> bool:
    return any(value is not None for value in model.problem.prescribed.components)


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
    total = force_change.sum(axis=0)
    if _is_held(model):
        residual = balance_of(model, response, motion, state)[0]
        x, y = barycentre - axle
        moment += x * total[1] - y * total[0]
        moment[2] += -y * residual[1] - x * residual[0]
    return np.vstack((total, moment))
