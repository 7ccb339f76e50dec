"""Newton's method for placed linear bodies in unilateral contact.

Unknowns are the contact forces p >= 0. Every iteration linearises the gaps ``g(x)`` and the direction of the forces
about the current positions and solves the linear complementarity problem that follows: with the bodies' stiffness K and
the geometric stiffness ``G = -sum p d2g`` of the *current* forces,

    (K + G) u' = B^T p' + G u,   0 <= p',   0 <= g + B (u' - u) + C p',   p' . (...) = 0,

where ``B = dg/du`` and C is the compliance of the contact law (0: no penetration; 1/penalty: Moherdaui (2021) 2.66 with
the sign of the errata). Once the active set has settled this is Newton's method with the consistent tangent (Moherdaui
2021, 3.118).

Where a penetration is to be within a tolerance (augmented Lagrange), C acts on ``p' - p0`` instead, and the forces p0
are corrected to those found until it is (Uzawa's method).
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from flangeway.checks import check_integer, check_tolerance
from flangeway.geometry import Placement
from flangeway.solve import complementarity
from flangeway.solve.body_response import BodyResponse
from flangeway.solve.linearisation import Constraints, Linearisation, contact_loads
from flangeway.solve.status import Status
from flangeway.types import Floats

SETTLE_AFTER = 8
"""Iterations after which pairs of a node and an edge are held by a wider margin, so that none changes for ever."""

HALVE_AFTER = 16
"""Iterations after which every other step is half of Newton's, if whole steps alone go round between two states."""

NEAR = 0.5
"""Part of the maximum displacement by which bodies may have moved since a start whose gaps are linearised anew only
after the first iteration."""

NAMED = 3
"""How many constraints a message names."""

MOST_ROUNDS = 20
"""Rounds of further constraints for nodes that penetrate."""


@dataclass(frozen=True)
class NewtonSettings:
    """Limits of the iteration.

    Parameters
    ----------
    max_iterations
        Iterations before giving up; each correction of the forces has as many.
    max_corrections
        Corrections of the forces before giving up.
    tolerance
        Maximum residual of forces over the total force, and maximum violation of the contact law over the maximum
        displacement.

    """

    max_iterations: int = 40
    max_corrections: int = 50
    tolerance: float = 1e-11

    def __post_init__(self) -> None:
        for name in ("max_iterations", "max_corrections"):
            check_integer("NewtonSettings", name, getattr(self, name), 1, advice="leave it out")
        check_tolerance("NewtonSettings", self.tolerance)


@dataclass(frozen=True)
class Iteration:
    """What one iteration did.

    Parameters
    ----------
    change
        Maximum change of a displacement over the maximum displacement.
    residual
        Maximum residual over the total force, or violation of the contact law over the maximum displacement.
    n_active
        Number of constraints under force.
    changed
        Keys of the constraints that came under force, left it, or changed their partner.
    correction
        Number of corrections of the forces before it.

    """

    change: float
    residual: float
    n_active: int
    changed: tuple[int, ...]
    correction: int = 0


@dataclass(frozen=True, eq=False)
class ContactState:
    """Solution of a contact problem for given placements.

    Parameters
    ----------
    status
        How the iteration ended.
    placements
        Placements of the bodies.
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
        Placement of each body.
    start
        A solution of the same constraints for a neighbouring position, whose forces are the first guess. Where the
        bodies have moved by little since, the first iteration also takes its linearisation.
    settings
        Limits of the iteration.

    Returns
    -------
    ContactState
        Its status says whether it converged.

    """
    settings = settings or NewtonSettings()
    state = _solved(_Run(response, constraints, placements, settings, start))
    if not state.status.converged and state.history and state.history[-1].changed:
        damped = _solved(_Run(response, constraints, placements, settings, start, damped=True))
        return damped if damped.status.converged else state
    return state


def _solved(run: "_Run") -> ContactState:
    """Solve, and guard nodes that penetrate, until none does."""
    for _ in range(MOST_ROUNDS):
        state = run.solve()
        if not (state.status.converged and run.guard()):
            return state
    return run.result(
        f"not converged: nodes still penetrate after {MOST_ROUNDS} rounds; take a finer mesh", converged=False
    )


class _Run:
    """One call of `solve_contact`: the current state and what was done."""

    def __init__(
        self,
        response: BodyResponse,
        constraints: Constraints,
        placements: tuple[Placement, ...],
        settings: NewtonSettings,
        start: ContactState | None,
        *,
        damped: bool = False,
    ) -> None:
        self.response, self.constraints, self.placements, self.settings = response, constraints, placements, settings
        self.damped = damped
        self.rotations = response.rotations(placements)
        self.reference = response.reference(placements)
        self.history: list[Iteration] = []
        if start is not None and _is_near(start, self.reference):
            # the first iteration uses the gaps of the start
            self.displacements = start.positions - self.reference
            self.current, self.forces = start.linearisation, start.forces
        else:
            self.displacements = np.zeros_like(self.reference)
            previous: Linearisation | None = None
            forces = np.zeros(0)
            if start is not None:
                previous, forces = start.linearisation, start.forces
                everywhere = np.arange(response.n_nodes)
                self.displacements = response.displacements(self.rotations, everywhere, start.nodal_forces)
            self.current = constraints.linearise(self.reference + self.displacements, previous)
            self.forces = _carried(previous, forces, self.current)
        self.correct()

    def solve(self) -> ContactState:
        """Find the forces of the constraints that there are."""
        for correction in range(self.settings.max_corrections + 1):
            failure = self.iterate(correction)
            if failure is not None:
                return self.result(failure, converged=False)
            if self.penetration_is_tolerated():
                more = f" and {_counted(correction, 'correction')} of the forces" if correction else ""
                return self.result(f"converged in {_counted(len(self.history), 'iteration')}{more}", converged=True)
            self.correct()
        return self.result(
            f"not converged in {_counted(self.settings.max_corrections, 'correction')} of the forces: the penetration "
            f"is {self.excess():.3g} times the tolerated one; take a larger penalty or a larger tolerance",
            converged=False,
        )

    def guard(self) -> bool:
        """Add constraints where bodies overlap although those that there are hold; whether there are any."""
        maximum = float(np.abs(self.displacements).max(initial=0.0))
        more = self.constraints.guarded(self.reference + self.displacements, self.current, self.forces, maximum)
        if more is None:
            return False
        self.forces = _carried(self.current, self.forces, more)
        self.current = more
        self.correct()
        return True

    def correct(self) -> None:
        """Take the forces found as those about which a tolerated penetration gives."""
        self.anchor = (self.current, self.forces)

    def excess(self) -> float:
        """Maximum penetration, or gap under force, over the tolerated one."""
        gaps = np.where(self.forces > 0.0, np.abs(self.current.gaps), -self.current.gaps)
        return float((gaps / self.current.tolerances).max(initial=0.0))

    def penetration_is_tolerated(self) -> bool:
        return self.excess() <= 1.0

    def iterate(self, correction: int) -> str | None:
        """Newton's method with the forces corrected last; None if it converged, else why not."""
        for iteration in range(self.settings.max_iterations):
            step = self._step(bend=True) or self._step(bend=False)
            if step is None:
                return (
                    "the linear complementarity problem has no solution: the tangent is not positive definite; take "
                    "smaller steps, a finer mesh or a softer penalty"
                )
            moved, new_forces, applied = step
            halved = self.damped and iteration >= HALVE_AFTER and iteration % 2 == 0
            if halved:
                moved = (self.displacements + moved) / 2.0
            after = self.constraints.linearise(self.reference + moved, self.current, settle=iteration >= SETTLE_AFTER)
            carried = _carried(self.current, new_forces, after)
            scale = max(float(np.abs(moved).max(initial=0.0)), 1e-300)
            change = float(np.abs(moved - self.displacements).max(initial=0.0)) / scale
            residual = _residual(after, self._gaps(after), carried, applied, scale)
            changed = _changed(self.current, self.forces, after, carried)
            self.history.append(Iteration(change, residual, int((carried > 0).sum()), changed, correction))
            self.displacements, self.current, self.forces = moved, after, carried
            floor = 64.0 * np.finfo(float).eps * float(np.abs(self.reference).max()) / scale
            # the residual is that of the new state, its law of contact included, whatever changed on the way there
            if residual <= max(self.settings.tolerance, floor) and not halved:
                return None
        return self._explain()

    def _gaps(self, lin: Linearisation) -> Floats:
        """Gaps less what the corrected forces press in."""
        anchored = np.where(np.isfinite(lin.tolerances), _carried(*self.anchor, lin), 0.0)
        return lin.gaps - lin.compliances * anchored

    def _step(self, *, bend: bool) -> tuple[Floats, Floats, Floats] | None:
        """One iteration: new displacements, new contact forces and the nodal forces in equilibrium with them.

        Without ``bend`` the geometric stiffness is left out, which at deep penetration can make the tangent indefinite.
        """
        current, displacements = self.current, self.displacements
        nodes, jacobian = current.nodes, current.jacobian
        if len(nodes) == 0:
            return np.zeros_like(displacements), self.forces, np.zeros_like(displacements)
        at_nodes = displacements[nodes].ravel()
        n = 2 * len(nodes)
        geometric = current.curvature(-self.forces) if bend else sp.csr_array((n, n))
        loads = contact_loads(jacobian, (geometric @ at_nodes)[:, None])
        answer = self.response.respond(self.rotations, nodes, geometric, loads)
        at_gaps = jacobian @ answer
        matrix = at_gaps[:, :-1] + np.diag(current.compliances)
        offset = self._gaps(current) - jacobian @ at_nodes + at_gaps[:, -1]
        guess = self.forces > 0.0 if self.forces.any() else offset < 0.0
        new_forces = complementarity.solve((matrix + matrix.T) / 2.0, offset, guess)
        if new_forces is None:
            return None
        moved = answer[:, :-1] @ new_forces + answer[:, -1]
        carried_load = (jacobian.T @ new_forces - geometric @ (moved - at_nodes)).reshape(-1, 2)
        applied = np.zeros_like(displacements)
        applied[nodes] = carried_load
        return self.response.displacements(self.rotations, nodes, carried_load), new_forces, applied

    def _explain(self) -> str:
        last = self.history[-1]
        advice = "take smaller steps, a softer penalty or a finer mesh"
        if not last.changed:
            reason = f"the displacements still change by {last.change:.1e} of the maximum one"
        else:
            positions = self.reference + self.displacements
            named = [self.constraints.describe(key, positions) for key in last.changed[:NAMED]]
            more = f" and {len(last.changed) - NAMED} more" if len(last.changed) > NAMED else ""
            reason = f"contact still comes and goes at {'; '.join(named)}{more}"
            advice += "; with node-to-segment contact, make the finer surface secondary or take segment-to-segment"
        return f"not converged in {_counted(self.settings.max_iterations, 'iteration')}: {reason}; {advice}"

    def result(self, message: str, *, converged: bool) -> ContactState:
        return ContactState(
            Status(converged, message, len(self.history)),
            self.placements,
            self.displacements,
            self.reference + self.displacements,
            self.current,
            self.forces,
            _nodal(self.current, self.forces, len(self.reference)),
            tuple(self.history),
        )


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"


def _is_near(start: ContactState, reference: Floats) -> bool:
    """Whether a start's bodies have moved by less than a part of their displacements."""
    moved = np.abs(reference - (start.positions - start.displacements)).max()
    return bool(moved <= NEAR * np.abs(start.displacements).max())


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


def _residual(lin: Linearisation, gaps: Floats, forces: Floats, applied: Floats, scale: float) -> float:
    """Worst of: residual of nodal forces over the total force; violation of the law over the displacements."""
    # a constraint that was left on the way took its force with it: what it moved is not in equilibrium
    total = max(float(forces.sum()), float(np.abs(applied).max(initial=0.0)))
    if total == 0.0:
        return float(np.maximum(-gaps, 0.0).max(initial=0.0)) / scale
    residual = float(np.abs(_nodal(lin, forces, len(applied)) - applied).max()) / total
    slack = gaps + lin.compliances * forces
    violation = np.where(forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0))
    return max(residual, float(violation.max(initial=0.0)) / scale)


def _changed(before: Linearisation, forces: Floats, after: Linearisation, new_forces: Floats) -> tuple[int, ...]:
    """Keys of active constraints that came, went, or changed their partner."""
    pairs = []
    for lin, values in ((before, forces), (after, new_forces)):
        active = values > 0.0
        pairs.append(set(zip(lin.keys[active].tolist(), lin.partners[active].tolist(), strict=True)))
    return tuple(sorted({key for key, _ in pairs[0] ^ pairs[1]}))
