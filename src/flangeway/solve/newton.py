"""Newton's method for placed linear bodies in unilateral contact.

Unknowns are the contact forces p >= 0. Every iteration linearises the gaps ``g(x)`` and the direction of the forces
about the current positions and solves the linear complementarity problem that follows: with the bodies' stiffness K and
the geometric stiffness ``G = -sum p d2g`` of the *current* forces,

    (K + G) u' = B^T p' + G u,   0 <= p',   0 <= g + B (u' - u) + C p',   p' . (...) = 0,

where ``B = dg/du`` and C is the compliance of the contact law (0: no penetration; 1/penalty: seed 2.66 with the sign of
the errata). Once the active set has settled this is Newton's method with the consistent tangent (seed 3.118).
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.solve import complementarity
from flangeway.solve.bodies import BodyResponse
from flangeway.solve.status import Status

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Linearisation(Protocol):
    """Gaps about some positions, to second order."""

    @property
    def nodes(self) -> Ints:
        """Surface nodes on which any gap depends, shape (n_touched,)."""

    @property
    def keys(self) -> Ints:
        """Identity of each constraint from one linearisation to the next, shape (m,)."""

    @property
    def partners(self) -> Ints:
        """What each constraint is against, shape (m,); a change starts a new linear piece."""

    @property
    def gaps(self) -> Floats:
        """Gaps, open where positive, shape (m,)."""

    @property
    def jacobian(self) -> sp.csr_array:
        """Derivatives of the gaps, shape (m, 2 n_touched)."""

    @property
    def compliances(self) -> Floats:
        """Penetration for each force, shape (m,)."""

    def curvature(self, forces: Floats) -> Floats:
        """Sum of ``force * second derivative of the gap``, shape (2 n_touched, 2 n_touched)."""


class Constraints(Protocol):
    """Inequalities ``gap >= 0`` on the positions of surface nodes."""

    def linearise(self, positions: Floats, previous: "Linearisation | None") -> Linearisation:
        """Linearise about positions (n_nodes, 2); pairs of ``previous`` are kept where they can be."""


@dataclass(frozen=True)
class NewtonSettings:
    """Limits of the iteration.

    Parameters
    ----------
    max_iterations
        Iterations before giving up.
    tolerance
        Largest change of a displacement and largest violation of the contact law, both relative to the largest
        displacement.

    """

    max_iterations: int = 40
    tolerance: float = 1e-11

    def __post_init__(self) -> None:
        if self.max_iterations < 1 or not 0.0 < self.tolerance < 1.0:
            raise InputError(
                f"NewtonSettings(max_iterations={self.max_iterations}, tolerance={self.tolerance})",
                "at least one iteration and a tolerance between 0 and 1",
                "leave them out",
            )


@dataclass(frozen=True)
class Iteration:
    """What one iteration did: the largest change of a displacement, the error, and the active set."""

    change: float
    residual: float
    n_active: int
    n_changed: int


@dataclass(frozen=True, eq=False)
class ContactState:
    """Solution of a contact problem for given placements.

    Parameters
    ----------
    status
        How the iteration ended.
    placements
        Where the bodies stand.
    displacements
        Of the surface nodes, relative to their placed bodies, shape (n_nodes, 2).
    positions
        Of the surface nodes, shape (n_nodes, 2).
    linearisation
        Gaps about the final positions.
    forces
        Contact forces of its constraints, >= 0, shape (m,).
    nodal_forces
        Forces on the surface nodes, shape (n_nodes, 2).
    history
        One entry an iteration.

    """

    status: Status
    placements: tuple[Placement, ...]
    displacements: Floats
    positions: Floats
    linearisation: Linearisation
    forces: Floats
    nodal_forces: Floats
    history: tuple[Iteration, ...] = field(default=())


def solve_contact(
    response: BodyResponse,
    constraints: Constraints,
    placements: tuple[Placement, ...],
    *,
    start: ContactState | None = None,
    settings: NewtonSettings | None = None,
) -> ContactState:
    """Find the contact forces of placed bodies.

    Parameters
    ----------
    response
        The bodies.
    constraints
        The contacts among them.
    placements
        Where each body stands.
    start
        A solution for a neighbouring position, whose forces are the first guess.
    settings
        Limits of the iteration.

    Returns
    -------
    ContactState
        Its status says whether it converged.

    """
    settings = settings or NewtonSettings()
    rotations = response.rotations(placements)
    reference = response.reference(placements)
    displacements = np.zeros_like(reference)
    previous: Linearisation | None = None
    forces = np.zeros(0)
    if start is not None:
        previous, forces = start.linearisation, start.forces
        everywhere = np.arange(response.n_nodes)
        displacements = response.displacements(rotations, everywhere, start.nodal_forces)
    current = constraints.linearise(reference + displacements, previous)
    forces = _carried(previous, forces, current)
    history: list[Iteration] = []
    for _ in range(settings.max_iterations):
        step = _step(response, rotations, displacements, current, forces)
        if step is None:
            return _result(
                "the linear complementarity problem has no solution: the tangent is not positive "
                "definite; take smaller steps, a finer mesh or a softer penalty",
                False, placements, reference, displacements, current, forces, history,
            )  # fmt: skip
        moved, new_forces, applied = step
        after = constraints.linearise(reference + moved, current)
        carried = _carried(current, new_forces, after)
        scale = max(float(np.abs(moved).max(initial=0.0)), 1e-300)
        change = float(np.abs(moved - displacements).max(initial=0.0))
        residual = _residual(after, carried, applied, scale)
        n_changed = _n_changed(current, forces, after, carried)
        history.append(Iteration(change / scale, residual, int((carried > 0).sum()), n_changed))
        displacements, current, forces = moved, after, carried
        floor = 64.0 * np.finfo(float).eps * float(np.abs(reference).max()) / scale
        tolerance = max(settings.tolerance, floor)
        if n_changed == 0 and max(change / scale, residual) <= tolerance:
            message = f"converged in {len(history)} iterations"
            return _result(message, True, placements, reference, displacements, current, forces, history)
    return _result(
        _explain(history, settings), False,
        placements, reference, displacements, current, forces, history,
    )  # fmt: skip


def _step(
    response: BodyResponse,
    rotations: Floats,
    displacements: Floats,
    current: Linearisation,
    forces: Floats,
) -> tuple[Floats, Floats, Floats] | None:
    """One iteration: new displacements, new contact forces and the nodal forces that bear them."""
    nodes, jacobian = current.nodes, current.jacobian
    if len(nodes) == 0:
        return np.zeros_like(displacements), forces, np.zeros_like(displacements)
    at_nodes = displacements[nodes].ravel()
    geometric = -current.curvature(forces)
    loads = sp.hstack((jacobian.T, sp.csr_array((geometric @ at_nodes)[:, None])), format="csr")
    answer = response.respond(rotations, nodes, geometric, loads)
    at_gaps = jacobian @ answer
    matrix = at_gaps[:, :-1] + np.diag(current.compliances)
    offset = current.gaps - jacobian @ at_nodes + at_gaps[:, -1]
    guess = forces > 0.0 if forces.any() else offset < 0.0
    new_forces = complementarity.solve((matrix + matrix.T) / 2.0, offset, guess)
    if new_forces is None:
        return None
    moved = answer[:, :-1] @ new_forces + answer[:, -1]
    borne = (jacobian.T @ new_forces - geometric @ (moved - at_nodes)).reshape(-1, 2)
    applied = np.zeros_like(displacements)
    applied[nodes] = borne
    return response.displacements(rotations, nodes, borne), new_forces, applied


def _carried(before: Linearisation | None, forces: Floats, after: Linearisation) -> Floats:
    """Forces of the constraints in ``after`` that were in ``before``; zero for new ones."""
    result = np.zeros(len(after.keys))
    if before is None or len(before.keys) == 0:
        return result
    order = np.argsort(before.keys)
    place = np.searchsorted(before.keys, after.keys, sorter=order)
    place = order[np.minimum(place, len(order) - 1)]
    known = before.keys[place] == after.keys
    result[known] = forces[place[known]]
    return result


def _nodal(lin: Linearisation, forces: Floats, n_nodes: int) -> Floats:
    result = np.zeros((n_nodes, 2))
    result[lin.nodes] = (lin.jacobian.T @ forces).reshape(-1, 2)
    return result


def _residual(lin: Linearisation, forces: Floats, applied: Floats, scale: float) -> float:
    """Worst of: imbalance of nodal forces over the total force; violation of the law over the displacements."""
    total = float(forces.sum())
    if total == 0.0:
        return float(np.maximum(-lin.gaps, 0.0).max(initial=0.0)) / scale
    imbalance = float(np.abs(_nodal(lin, forces, len(applied)) - applied).max()) / total
    slack = lin.gaps + lin.compliances * forces
    violation = np.where(forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0))
    return max(imbalance, float(violation.max()) / scale)


def _n_changed(before: Linearisation, forces: Floats, after: Linearisation, new_forces: Floats) -> int:
    """How many active constraints came, went, or changed their partner."""
    old = set(zip(before.keys[forces > 0].tolist(), before.partners[forces > 0].tolist(), strict=True))
    new = set(
        zip(
            after.keys[new_forces > 0].tolist(),
            after.partners[new_forces > 0].tolist(),
            strict=True,
        )
    )
    return len(old ^ new)


def _explain(history: list[Iteration], settings: NewtonSettings) -> str:
    last = history[-1]
    if last.n_changed:
        reason = f"{last.n_changed} contact pairs still change"
    else:
        reason = f"the displacements still change by {last.change:.1e} of the largest one"
    return (
        f"not converged in {settings.max_iterations} iterations: {reason}; "
        "take smaller steps, a softer penalty or a finer mesh"
    )


def _result(
    message: str,
    converged: bool,
    placements: tuple[Placement, ...],
    reference: Floats,
    displacements: Floats,
    linearisation: Linearisation,
    forces: Floats,
    history: list[Iteration],
) -> ContactState:
    return ContactState(
        Status(converged, message, len(history)),
        placements,
        displacements,
        reference + displacements,
        linearisation,
        forces,
        _nodal(linearisation, forces, len(reference)),
        tuple(history),
    )
