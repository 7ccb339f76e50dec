"""Where the iteration for contact stands, as a value, and what is not in equilibrium there.

See `flangeway.contact.newton` for the equations.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from flangeway.contact.system import ContactLinearisation, ContactSystem, Sliding, carried_forces, nodal_forces_of
from flangeway.geometry import Placement
from flangeway.geometry.arrays import max_magnitude, norms
from flangeway.solve.active_set import CoulombState, Motions, standoffs, violations
from flangeway.solve.body_response import BodyResponse
from flangeway.solve.handles import Handles
from flangeway.solve.status import Iteration, NewtonSettings, Status
from flangeway.types import Bools, Floats, Ints

PENALTY_GROWTH = 10.0
"""Growth of the penalty with a correction of the forces."""


@dataclass(frozen=True, eq=False)
class ContactState:
    """Solution of a contact problem for given placements.

    Parameters
    ----------
    status
        How the iteration ended.
    placements
        Placements of the bodies, those on handles as found.
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
    friction
        Tangential forces and slips of the constraints; None without friction.
    motions
        Rigid motions of handles since their given placements, see `Handles`, shape (n,).
    stable
        Whether handles come back after a small push; None where that has no meaning: not converged, with friction,
        without handles, or where a motion is free.
    response
        The bodies, with their loads.

    """

    status: Status
    placements: tuple[Placement, ...]
    displacements: Floats
    positions: Floats
    linearisation: ContactLinearisation
    forces: Floats
    nodal_forces: Floats
    history: tuple[Iteration, ...] = field(default=())
    friction: CoulombState | None = None
    motions: Floats = field(default_factory=lambda: np.zeros(0))
    stable: bool | None = None
    response: BodyResponse | None = None


def bending(response: BodyResponse, placements: Sequence[Placement], positions: Floats, displacements: Floats) -> float:
    """Maximum displacement of the surfaces by which elements bend between their nodes.

    That by contact forces, ``displacements`` (n_nodes, 2), or where it is less the one of the ``positions`` (n_nodes,
    2) from the placed bodies without loads: forces take back what loads alone would displace.
    """
    moves = displacements, positions - response.undeformed(placements)
    return min(max_magnitude(norms(move)) for move in moves)


class ContactEquations(NamedTuple):
    """Linear complementarity problem of an iteration.

    - `keys`, `nodes`: constraints that may close, and surface nodes on which any gap depends.
    - `geometric`, `solved`: geometric stiffness, and `BodyResponse.tangent` with it.
    - `by_loads`: displacements by the forces, now and by rigid motions, shape (2 n_touched, k + 1 + n).
    - `matrix`, `offset`: flexibility and offset of gaps and slips, shapes (k, k) and (k,).
    - `rigid`, `by_forces`: equations of the rigid motions, see `flangeway.solve.handles`, and W' of these.
    """

    keys: Ints
    nodes: Ints
    geometric: sp.csr_array
    solved: Callable[[sp.csr_array], Floats]
    by_loads: Floats
    matrix: Floats
    offset: Floats
    rigid: Motions
    by_forces: Floats


class HeldMotions(NamedTuple):
    """What holds the handles, by the equations of the last step.

    - `neutral`: motions that nothing holds, as directions of the equations and of the motions, (n, r) each.
    - `unheld`: direction of the load that springs hold within a step, zero if there is none, (n,).
    - `tangent`: flexibility of the gaps, equations of the motions, and which constraints are active; None: no step yet.
    """

    neutral: tuple[Floats, Floats]
    unheld: Floats
    tangent: tuple[Floats, Motions, Bools] | None


class PlacedBodies(NamedTuple):
    """Motions of the handles (n,), and where they place the bodies, undeformed by contact."""

    motions: Floats
    placements: tuple[Placement, ...]
    rotations: Floats
    reference: Floats


class ContactIterate(NamedTuple):
    """Where an iteration stands.

    - `placed`, `displacements`: of the bodies, and by contact of their surface nodes, (n_nodes, 2).
    - `applied`: forces on the surface nodes in equilibrium with these displacements, (n_nodes, 2).
    - `lin`, `slides`: gaps about the positions, and slips where there is friction.
    - `forces`, `tangential`: of the constraints, (m,) each.
    - `anchor`, `corrections`: constraints and both forces about which a tolerated penetration gives, and how often they
      were corrected.
    - `held`, `equations`: of the last step; equations that one more iteration may use.
    - `history`, `stops`: the iterations, and how many of them a surface stopped.
    - `sliding`: number of last iterations in which loads slide a part against friction.
    - `is_guarded`: whether constraints of nodes that entered on the way from the last position are still there.
    - `status`: the outcome; None while the iteration goes on.
    """

    placed: PlacedBodies
    displacements: Floats
    applied: Floats
    lin: ContactLinearisation
    forces: Floats
    tangential: Floats
    anchor: tuple[ContactLinearisation, Floats, Floats]
    held: HeldMotions
    slides: Sliding | None = None
    corrections: int = 0
    equations: ContactEquations | None = None
    history: tuple[Iteration, ...] = ()
    stops: int = 0
    sliding: int = 0
    is_guarded: bool = False
    status: Status | None = None

    @property
    def positions(self) -> Floats:
        """Of the surface nodes, (n_nodes, 2)."""
        return self.placed.reference + self.displacements

    @property
    def nodal(self) -> Floats:
        """Forces of the constraints on all surface nodes, (n_nodes, 2)."""
        return nodal_forces_of(self.lin, self.forces, self.slides, self.tangential, len(self.displacements))

    @property
    def compliances(self) -> Floats:
        """Penetration for each force, by the penalty that has grown with the corrections of the forces, (m,)."""
        lin = self.lin
        return np.where(
            np.isfinite(lin.tolerances), lin.compliances / PENALTY_GROWTH**self.corrections, lin.compliances
        )

    @property
    def gaps(self) -> Floats:
        """Gaps less what the corrected forces press in, and with what the laws' tangents press in without force."""
        return self.lin.gaps + self.lin.offsets - self.compliances * self._anchored(self.anchor[1])

    @property
    def excess(self) -> float:
        """Maximum penetration, or gap under force, relative to the tolerated one."""
        gaps = np.where(self.forces > 0.0, np.abs(self.lin.gaps), -self.lin.gaps)
        if self.slides is not None and np.isfinite(self.lin.tolerances).any():
            gaps = np.maximum(gaps, np.abs(self.let_back(self.tangential)))  # what the law lets back of the slips
        return float((gaps / self.lin.tolerances).max(initial=0.0))

    def let_back(self, tangential: Floats) -> Floats:
        """What the compliance of the law takes from the slips under tangential forces (m,)."""
        return self.compliances * (tangential - self._anchored(self.anchor[2]))

    def _anchored(self, forces: Floats) -> Floats:
        """Forces of the anchor where they are corrected."""
        return np.where(np.isfinite(self.lin.tolerances), carried_forces(self.anchor[0], forces, self.lin), 0.0)

    @property
    def n_iterations(self) -> int:
        """Iterations since the last correction of the forces, without those that a surface stopped."""
        return sum(iteration.correction == self.corrections for iteration in self.history) - self.stops

    def corrected(self, further: int = 0) -> "ContactIterate":
        """With the present forces as those about which a tolerated penetration gives, and equations of its own."""
        anchor = self.lin, self.forces, self.tangential
        return self._replace(anchor=anchor, corrections=self.corrections + further, equations=None)

    def outcome(self, message: str, *, converged: bool = False, is_unheld: bool = False) -> Status:
        """Outcome of the iteration here."""
        residual = self.history[-1].residual if self.history else np.inf
        return Status(converged, message, len(self.history), residual=residual, is_unheld=is_unheld)

    def ended(self, message: str, *, is_unheld: bool = False) -> "ContactIterate":
        """The same with an outcome that is no solution."""
        return self._replace(status=self.outcome(message, is_unheld=is_unheld))


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """What stays the same in a call of `solve_contact`.

    - `response`, `constraints`, `settings`, `start`, `origin`: see there.
    - `parts`: the handles.
    """

    response: BodyResponse
    constraints: ContactSystem
    parts: Handles
    settings: NewtonSettings
    start: ContactState | None
    origin: Sequence[Placement] | None

    @cached_property
    def begun(self) -> PlacedBodies:
        """Bodies before the handles move."""
        return self.placed(np.zeros(self.parts.n) if self.start is None else self.start.motions)

    @cached_property
    def slip_origin(self) -> tuple[Sequence[Placement], Floats]:
        """Where the bodies come from, and the positions of the surface nodes since which slip is counted."""
        if self.start is not None:
            return self.start.placements, self.start.positions
        if self.origin is None:
            return self.begun.placements, self.begun.reference
        return self.origin, self.response.undeformed(self.origin)

    def placed(self, motions: Floats) -> PlacedBodies:
        """Bodies after motions (n,) of the handles."""
        placements = self.parts.placements(motions)
        return PlacedBodies(
            motions, placements, self.response.rotations(placements), self.response.reference(placements)
        )

    def at(self, state: ContactIterate, lin: ContactLinearisation) -> ContactIterate:
        """The state with a linearisation about its positions; forces stay where constraints do."""
        forces, tangential = (carried_forces(state.lin, forces, lin) for forces in (state.forces, state.tangential))
        has_friction = len(lin.keys) > 0 and lin.coefficients.any()
        slides = lin.slides(state.positions, self.slip_origin[1]) if has_friction else None
        return state._replace(lin=lin, slides=slides, forces=forces, tangential=tangential)

    def slips(self, state: ContactIterate, slides: Sliding) -> Floats:
        """Slips since the last step, with the elastic ones of it."""
        if self.start is None or self.start.friction is None:
            return slides.slips
        return slides.slips + carried_forces(self.start.linearisation, self.start.friction.elastic, state.lin)

    def scale(self, state: ContactIterate) -> float:
        """Maximum displacement, or way of a placed body."""
        ways = state.displacements, state.placed.reference - self.begun.reference
        return max(*(max_magnitude(vector) for vector in ways), 1e-300)

    def along_motions(self, state: ContactIterate) -> Floats:
        """What is left of forces, loads and springs along the motions of handles, shape (n,)."""
        return self.parts.residual(state.placed.motions, state.positions, state.nodal)

    def residuals(self, state: ContactIterate) -> tuple[Floats, Floats, Floats]:
        """Violations of the laws, (m,), and what is not balanced on nodes, (n_nodes,), and along motions, (n,).

        Lengths are relative to the maximum displacement, forces to all of the contacts. Without force only a
        penetration violates the law of contact; with it any gap beyond the one of the law.
        """
        lin, forces, scale = state.lin, state.forces, self.scale(state)
        slack = state.gaps + state.compliances * forces - standoffs(forces, lin.barriers)
        laws = np.where(forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0)) / scale
        # a constraint that was left on the way took its force with it: what it moved is not in equilibrium
        most = max(max_magnitude(vector) for vector in (state.applied, self.parts.load))
        total = max(float(forces.sum()), most) or np.inf
        if state.slides is not None:
            slips = self.slips(state, state.slides) + state.let_back(state.tangential)
            beyond, wrong = violations(forces, state.tangential, slips, lin.coefficients)
            laws = np.maximum.reduce((laws, beyond / total, wrong / scale))
        nodal, (neutral, _) = state.nodal, state.held.neutral
        along = self.parts.residual(state.placed.motions, state.positions, nodal)
        along -= neutral @ (neutral.T @ along)
        return laws, np.abs(nodal - state.applied).max(axis=1) / total, np.abs(along) / total
