"""Newton's method for placed linear bodies in unilateral contact.

Unknowns are the contact forces p >= 0. Every iteration linearises the gaps ``g(x)`` and the direction of the forces
about the current positions and solves the linear complementarity problem that follows: with the bodies' stiffness K and
the geometric stiffness ``G = -sum p d2g`` of the *current* forces,

    (K + G) u' = B^T p' + G u,   0 <= p',   0 <= g + B (u' - u) + C p',   p' . (...) = 0,

where ``B = dg/du`` and C is the compliance of the contact law (0: no penetration; 1/penalty: Moherdaui (2021) 2.66 with
the sign of the errata). Once the active set has settled this is Newton's method with the consistent tangent (Moherdaui
2021, 3.118).

Near the solution K + G and B hardly change from one iteration to the next, and the last iteration takes those of the
one before (the chord method; C. T. Kelley, 1995, Iterative Methods for Linear and Nonlinear Equations, 5.4.1): only
gaps and forces are new.

With a barrier of the product w and the reach r, forces act at a gap: ``0 <= g + ... - w / (p' + w / r)``.

A step is halved until the residual is below the maximum of the last steps (L. Grippo, F. Lampariello and S. Lucidi,
1986, SIAM J. Numer. Anal. 23). What this does not reach from the start is reached along a path of smaller motions and
loads (`flangeway.solve.status`).

Where a penetration is to be within a tolerance (augmented Lagrange), C acts on ``p' - p0`` instead. Until it is, the
forces p0 are corrected to those found (Uzawa's method), and the penalty grows with each correction (D. P. Bertsekas,
1982, Constrained Optimization and Lagrange Multiplier Methods, 2.2): with one penalty, patterns of forces that hardly
displace the bodies are corrected hardly at all.

With friction, tangential forces q are added. The slips w since the last converged step are linearised as the gaps are,
with ``S = dw/du``, and their forces act along T, so that the linear problem is

    (K + G) u' = B^T p' + T^T q' + G u,   |q'| <= mu p',   w + S (u' - u) + C q' + e = 0 or against q' at the limit,

with Coulomb's law in place of the complementarity (`flangeway.solve.active_set`). The geometric stiffness has the turn
of the tangential forces, ``-sum q dT``, and is not symmetric. C is the same as for the gaps; e is the slip ``-C q``
that it had let back before.
"""

import itertools
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from flangeway.contact.search import MAX_ROTATION_STEP, on_path
from flangeway.contact.system import (
    ContactLinearisation,
    ContactSystem,
    Entry,
    Sliding,
    carried_forces,
    changed_keys,
    nodal_forces_of,
)
from flangeway.geometry import Placement
from flangeway.solve import active_set
from flangeway.solve.active_set import CoulombState
from flangeway.solve.body_response import BodyResponse, Constrained
from flangeway.solve.handles import Handle, Handles
from flangeway.solve.status import Iteration, NewtonSettings, Status, is_at_round_off
from flangeway.space.symmetric import EPS
from flangeway.types import Bools, Floats, Ints

MEMORY, MAX_GROWTH, MIN_FRACTION = 12, 2.0, 1.0 / 32.0
"""A step is halved while its residual is above the maximum of so many iterations before it, times the growth, until the
fraction of the step. Active sets change in the first iterations, so that the residual need not fall in each; without
any limit nodes on edges far shorter than their share of the surface, which are not stable under pressure, run away.
After as many, pairs of a node and an edge are held by a wider margin, so that none changes for ever."""

SPRING, STIFF_SPRING = 1e-6, 1.0
"""Stiffness of the springs that hold motions within a step, relative to the maximum stiffness of one constraint; and
the same where the equations with the geometric stiffness had no solution."""

SOFTNESSES = 0.0, 1.0, 0.5, 0.25
"""Powers of the stiffness of these springs, that of the softest ones over theirs, in the order in which they are tried:
with friction the equations may have no solution with the softest."""

START_DISTANCE = 0.5
"""Part of the maximum displacement by which bodies may have moved since a start whose gaps are linearised anew only
after the first iteration."""

OPEN_GAP = 0.01
"""Gap relative to the maximum displacement, or way, from which constraints are left out of iterations that keep them
open."""

GAP_CLOSURE = 2.0 * np.sqrt(2.0)
"""Closing of a gap relative to the maximum component of the nodes' displacements, at most."""

OLD_DERIVATIVES_RESIDUAL = 1e-6
"""Residual up to which the equations of an iteration may serve the next one."""

MAX_UNBALANCED_FORCE = 1e-9
"""Force left on a floating part relative to the maximum load, or the total force, above which a message names it."""

MAX_FORCE_ALONG_MOTION = 1e-6
"""Force along a motion relative to the maximum load, above which a message names it."""

ROUND_OFF = 1e-13
"""Force relative to the maximum one below which it is round-off of the solved equations: its constraint is open."""

MAX_ROUND_OFF = 1e-3
"""Residual that round-off of the positions excuses, at most: where nothing moves it would excuse any force."""

MAX_SLIDE, MAX_TURN = 0.4, 1.0
"""Way relative to the size of a part, and angle in rad, after which it slides away if friction has not held its load
meanwhile: a wheel of eight sides turns by 0.8 from one to the next."""

RELAXATION = 4.0
"""Factor by which springs are softer with each iteration of such a way: a load just beyond the limit is a slow push."""

MAX_DENSE_EQUATIONS = 4000
"""Equations of a contact with friction up to which a dense matrix of them is made where there is another way."""

MAX_NAMED = 3
"""How many constraints a message names."""

MAX_TRAVEL = 2.0
"""Way relative to the size of the largest part after which no surface comes within reach of a part that nothing
touches."""

MAX_STOPS = 12
"""Steps of an iteration that stop where a node enters another surface."""

MAX_DEFORMATION = 1.0
"""Deformation relative to the size of the largest body that is not sought: bodies are linear."""

MAX_ROUNDS = 20
"""Rounds of further constraints for nodes that penetrate."""

PENALTY_GROWTH, MAX_CORRECTIONS = 10.0, 10
"""Growth of the penalty with a correction of the forces, and corrections after which round-off hides the tolerance."""


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


def solve_contact(
    response: BodyResponse,
    constraints: ContactSystem,
    placements: tuple[Placement, ...],
    *,
    handles: Sequence[Handle | None] | None = None,
    start: ContactState | None = None,
    settings: NewtonSettings | None = None,
    origin: Sequence[Placement] | None = None,
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
    handles
        Handle of each body, the same object for all that share it, whose motion after the placements is unknown; None
        for a body or all: there is none.
    start
        A solution of the same constraints for a neighbouring position, whose forces are the first guess. Where the
        bodies have moved by little since, the first iteration also takes its linearisation. With friction it is the
        converged step before: slip is counted from its positions.
    settings
        Limits of the iteration.
    origin
        Placements from which the undeformed bodies come, and slip is counted, without a start; left out: those given.

    Returns
    -------
    ContactState
        Its status says whether it converged.

    """
    settings = settings or NewtonSettings()
    parts = Handles(response, placements, handles)
    return _Run(response, constraints, parts, settings, start, origin).solve()


_Step = tuple[Floats, Floats, Floats, Floats]
"""New contact forces, tangential ones, nodal forces in equilibrium with them, and rigid motions."""


class _Equations(NamedTuple):
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
    rigid: active_set.Motions
    by_forces: Floats


class _Run:
    """One call of `solve_contact`: the current state and what was done."""

    def __init__(
        self,
        response: BodyResponse,
        constraints: ContactSystem,
        parts: Handles,
        settings: NewtonSettings,
        start: ContactState | None,
        origin: Sequence[Placement] | None,
    ) -> None:
        self.response, self.constraints, self.parts, self.settings = response, constraints, parts, settings
        self.neutral, self.unheld = np.zeros((2, parts.n, 0)), np.zeros(parts.n)
        self.tangent: tuple[Floats, active_set.Motions, Bools]
        self.move(np.zeros(parts.n) if start is None else start.motions)
        self.applied = np.zeros_like(self.reference) if start is None else start.nodal_forces
        self.begun = self.reference
        self.history: list[Iteration] = []
        self.is_unheld, self.failure = False, ""
        self.start, self.before = start, self.reference
        came_from = self.placements if start is None else start.placements
        if start is None and origin is not None:
            self.before, came_from = response.undeformed(origin), tuple(origin)
        self.displacements = np.zeros_like(self.reference)
        if start is None:
            self.current = after = constraints.linearise(self.reference, None)
            self.forces = self.tangential = np.zeros(len(after.keys))
        else:
            self.before, self.current, self.forces = start.positions, start.linearisation, start.forces
            self.tangential = np.zeros_like(start.forces) if start.friction is None else start.friction.forces
            after = self._unguarded(start.positions)
            if _is_near(start, self.reference):  # the first iteration uses the gaps of the start
                self.displacements = start.positions - self.reference
            else:
                everywhere = np.arange(response.n_nodes)
                self.displacements = response.displacements(self.rotations, everywhere, start.nodal_forces)
                after = constraints.linearise(self.reference + self.displacements, after)
        here = self._come(came_from, after)
        self.take_over(here)
        self.stalled, self.corrections, self.sliding, self.stops, self.is_held_back = False, 0, 0, 0, here is not after
        self.stable: bool | None = None
        self.correct()

    def _come(self, placements: Sequence[Placement], after: ContactLinearisation) -> ContactLinearisation:
        """Come from where slip is counted, with the placements there, up to where nodes enter another surface.

        Rigid motions turn along their arcs, and bodies deform straight. Returns the linearisation there, which is
        ``after`` where nothing is in the way.
        """
        points = np.stack((self.before, self.reference + self.displacements))
        both = zip(placements, self.placements, strict=True)
        angle = max(abs(last.rotation_rad - first.rotation_rad) for first, last in both)
        parts = 1 + int(angle / MAX_ROTATION_STEP)
        at = points[0]
        for part in range(1, parts + 1):
            following = points[1] if part == parts else self._on_path(placements, points, part / parts)
            lin = after if part == parts else self.constraints.linearise(following, after)
            if (entry := self.constraints.entered(at, following, lin)) is not None:
                at = at + entry.time * (following - at)
                self.displacements = at - self.reference
                remaining = np.abs(at - self.response.undeformed(self.placements)).max()
                if remaining > MAX_DEFORMATION * self.parts.size:
                    self.is_unheld, self.failure = True, self._passes(entry, "")
                return self.constraints.guarded_too(at, lin, entry.guards)
            at = following
        return after

    def _on_path(self, placements: Sequence[Placement], points: Floats, share: float) -> Floats:
        """Positions of the surface nodes at a share of the way between two positions, shape (2, n_nodes, 2)."""
        both, offsets = zip(placements, self.placements, strict=True), self.response.offsets
        bodies = [points[:, first:last] for first, last in itertools.pairwise(offsets.tolist())]
        return np.concatenate([on_path(*ends, body, share) for ends, body in zip(both, bodies, strict=True)])

    def move(self, motions: Floats) -> None:
        """Place the parts on handles."""
        self.motions = motions
        self.placements = self.parts.placements(motions)
        self.rotations = self.response.rotations(self.placements)
        self.reference = self.response.reference(self.placements)

    def solve(self) -> ContactState:
        """Solve, and guard nodes that penetrate, until none does and penetrations are within their tolerance."""
        rounds = 0
        while True:
            failure = self.failure or self.iterate()
            if failure is not None:
                return self.result(failure, converged=False)
            if self.excess() <= 1.0:
                if self.is_held_back:
                    self.release()
                elif not self.guard():
                    more = f" and {_counted(self.corrections, 'correction')} of the forces" if self.corrections else ""
                    if self.stalled:
                        more += f", to round-off: the residual is {self.history[-1].residual:.1e}"
                    return self.result(f"converged in {_counted(len(self.history), 'iteration')}{more}", converged=True)
                rounds += 1
                if rounds == MAX_ROUNDS:
                    return self.result(
                        f"not converged: nodes still penetrate after {rounds} rounds; take a finer mesh",
                        converged=False,
                    )
            elif self.corrections == MAX_CORRECTIONS:
                return self.result(
                    f"not converged in {MAX_CORRECTIONS} corrections of the forces: the penetration is "
                    f"{self.excess():.3g} times the tolerated one, which is below round-off; take a larger tolerance",
                    converged=False,
                )
            else:
                self.corrections += 1
                self.correct()

    def guard(self) -> bool:
        """Add constraints where bodies overlap although those that there are hold; whether there are any."""
        maximum = float(np.abs(self.displacements).max(initial=0.0))
        more = self.constraints.guarded(self.reference + self.displacements, self.current, self.forces, maximum)
        if more is None:
            return False
        self.take_over(more)
        self.correct()
        return True

    def release(self) -> None:
        """Leave the constraints of nodes that entered on the way, which the solution may not need."""
        self.take_over(self._unguarded(self.reference + self.displacements))
        self.is_held_back = False
        self.correct()

    def _unguarded(self, positions: Floats) -> ContactLinearisation:
        """Linearise about positions (n_nodes, 2) without guarded nodes.

        Bodies that slide along a path leave the places where nodes penetrated in earlier steps; but without the nodes
        that hold it a part on a handle would go where its load takes it.
        """
        return self.current if self.parts.n else self.constraints.unguarded(positions, self.current)

    def take_over(self, after: ContactLinearisation) -> None:
        """Go on with another linearisation about the same positions or new ones; forces stay where constraints do."""
        self.forces, self.tangential = (
            carried_forces(self.current, forces, after) for forces in (self.forces, self.tangential)
        )
        self.current, self.slides = after, self._slides(after, self.displacements)

    def correct(self) -> None:
        """Take the forces found as those about which a tolerated penetration gives."""
        self.anchor = (self.current, self.forces, self.tangential)
        self.equations: _Equations | None = None

    def excess(self) -> float:
        """Maximum penetration, or gap under force, over the tolerated one."""
        gaps = np.where(self.forces > 0.0, np.abs(self.current.gaps), -self.current.gaps)
        if self.slides is not None and np.isfinite(self.current.tolerances).any():
            # what the law lets back of the slips
            gaps = np.maximum(gaps, np.abs(self._let_back(self.current, self.tangential)))
        return float((gaps / self.current.tolerances).max(initial=0.0))

    def iterate(self) -> str | None:
        """Newton's method with the forces corrected last; None if it converged, else why not."""
        first = len(self.history)
        before = sum(iteration.correction == self.corrections for iteration in self.history)
        iteration, stops, slid_from, pressed = -1, self.stops, self.motions, self._pressed()
        self.sliding = 0
        while (iteration := iteration + 1) < self.settings.max_iterations - before + self.stops - stops:
            if loose := self._approach():
                return loose
            way = np.where(pressed, np.abs(self.motions - slid_from) / self.parts.lengths, 0.0)
            if self.sliding and ((way > MAX_TURN) | (self.parts.without_turns(way) > MAX_SLIDE)).any():
                return self._slides_away()
            # deep in first overlaps the geometric stiffness can make the tangent indefinite: K on stiff springs is not
            step = self._step() or self._step(bend=False)
            if step is None:
                return (
                    "not converged: the contact laws of a linearised step have no solution: "
                    f"{self._worst()}; check the direction and the size of loads and motions, or "
                    "take a finer mesh or a softer penalty"
                )
            here, fraction, settle = copy(self), 1.0, len(self.history) >= MEMORY
            limit = MAX_GROWTH * max((iteration.residual for iteration in self.history[-MEMORY:]), default=np.inf)
            taken = self._take(here, step, fraction, settle=settle)
            if (entry := self._entry(here)) is not None:
                if self.stops == MAX_STOPS:
                    return self._passes(entry, f", again after {MAX_STOPS} stops")
                self._stop(here, step, entry)
                continue
            while taken.residual > limit and fraction > MIN_FRACTION:
                fraction /= 2.0
                taken = self._take(here, step, fraction, settle=settle)
            self.history.append(taken)
            last_pressed, pressed = pressed, self._pressed()
            self.sliding += 1
            if not self.unheld[pressed].any() or not np.array_equal(pressed, last_pressed):
                self.sliding, slid_from = 0, self.motions
            round_off = 64.0 * EPS * float(np.abs(self.reference).max()) / self._scale()
            floor = min(round_off, MAX_ROUND_OFF)
            # the residual is that of the new state, its law of contact included, whatever changed on the way there
            met = taken.residual <= max(self.settings.tolerance, floor) and fraction == 1.0
            self.stalled = not met and is_at_round_off(self.history[first:])
            if met or self.stalled:
                return None
        # parts without contact still fall, and where it comes and goes it may hold less of the load
        return (not self.history[-1].changed and self._loose(pressed)) or self._explain()

    def _pressed(self) -> Bools:
        """Which motions move a part under contact forces, shape (n,): the others' parts still fall."""
        pressed = np.unique(self.response.body_of_node[np.flatnonzero(self._nodal().any(axis=1))])
        return self.parts.of_bodies(pressed)

    def _slides_away(self) -> str:
        """Names the motion against which friction does not hold a part."""
        self.is_unheld = True
        words = "; ".join(self.parts.describe(self.motions, self.unheld[:, None]))
        what = "a load" if self.parts.load.any() else "what the motion presses"
        return (
            f"no friction holds {what}: {words}; take a smaller load or motion, a larger coefficient of friction, or "
            "hold the part in Body(held=...)"
        )

    def _entry(self, here: "_Run") -> Entry | None:
        """Where a node enters another surface unseen on the way from a state, a copy of this run."""
        before, after = (run.reference + run.displacements for run in (here, self))
        return self.constraints.entered(before, after, self.current)

    def _stop(self, here: "_Run", step: "_Step", entry: Entry) -> None:
        """Go only as far along a step as no node enters another surface, and guard those that do."""
        self.history.append(self._take(here, step, entry.time, settle=False))
        self.take_over(self.constraints.guarded_too(self.reference + self.displacements, self.current, entry.guards))
        self.equations, self.stops = None, self.stops + 1

    def _passes(self, entry: Entry, again: str) -> str:
        """Names bodies of which one goes into the other although constraints hold it back."""
        words = self.constraints.describe_entry(entry, self.reference + self.displacements)
        return (
            f"not converged: {words}{again}; move or load the bodies less, give all edges that may "
            "touch, or take a finer mesh there"
        )

    def _take(self, here: "_Run", step: "_Step", share: float, *, settle: bool) -> Iteration:
        """Go a share of a step from a state, a copy of this run; what that did."""
        new_forces, new_tangential, applied, motion = step
        nodes, before = here.current.nodes, (here.forces, here.tangential)
        if self.parts.n:
            self.move(here.motions + share * motion)
        moved = self.response.displacements(self.rotations, nodes, applied[nodes])
        if share < 1.0:
            # bodies are linear: a share of the displacements is that by a share of the forces
            moved, applied, new_forces, new_tangential = (
                old + share * (new - old)
                for old, new in (
                    (here.displacements, moved),
                    (here.applied, applied),
                    (here.forces, new_forces),
                    (here.tangential, new_tangential),
                )
            )
        after = self.constraints.linearise(self.reference + moved, here.current, settle=settle)
        self.current, self.displacements, self.forces, self.tangential = here.current, moved, new_forces, new_tangential
        self.take_over(after)
        yielded = max(
            float(np.abs(vector).max(initial=0.0)) for vector in (moved, self._compliances(after) * self.forces)
        )
        if yielded <= EPS * float(np.abs(self.reference).max()) and not self.parts.forces(self.motions).any():
            # nothing presses, and neither bodies nor laws yield: what is left of forces is round-off
            self.forces, self.tangential = np.zeros((2, len(after.keys)))
            applied = np.zeros_like(applied)
        self.applied = applied
        residual = max(float(values.max(initial=0.0)) for values in self._residuals())
        change = float(np.abs(moved - here.displacements).max(initial=0.0)) / self._scale()
        changed = changed_keys(here.current, before, after, (self.forces, self.tangential))
        return Iteration(change, residual, int((self.forces > 0).sum()), changed, self.corrections)

    def _residuals(self) -> tuple[Floats, Floats, Floats]:
        """Violations of the laws, (m,), and what is not balanced on nodes, (n_nodes,), and along motions, (n,).

        Lengths are relative to the maximum displacement, forces to all of the contacts. Without force only a
        penetration violates the law of contact; with it any gap beyond the one of the law.
        """
        lin, forces, scale = self.current, self.forces, self._scale()
        slack = self._gaps(lin) + self._compliances(lin) * forces - active_set.standoffs(forces, lin.barriers)
        laws = np.where(forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0)) / scale
        # a constraint that was left on the way took its force with it: what it moved is not in equilibrium
        most = max(float(np.abs(vector).max(initial=0.0)) for vector in (self.applied, self.parts.load))
        total = max(float(forces.sum()), most) or np.inf
        if self.slides is not None:
            slips = self._slips(lin, self.slides) + self._let_back(lin, self.tangential)
            beyond, wrong = active_set.violations(forces, self.tangential, slips, lin.coefficients)
            laws = np.maximum.reduce((laws, beyond / total, wrong / scale))
        left = self._left()
        left -= self.neutral[0] @ (self.neutral[0].T @ left)
        return laws, np.abs(self._nodal() - self.applied).max(axis=1) / total, np.abs(left) / total

    def _scale(self) -> float:
        """Maximum displacement, or way of a placed body."""
        ways = self.displacements, self.reference - self.begun
        return max(*(float(np.abs(vector).max(initial=0.0)) for vector in ways), 1e-300)

    def _gaps(self, lin: ContactLinearisation) -> Floats:
        """Gaps less what the corrected forces press in, and with what the laws' tangents press in without force."""
        return lin.gaps + lin.offsets - self._compliances(lin) * self._anchored(self.anchor[1], lin)

    def _compliances(self, lin: ContactLinearisation) -> Floats:
        """Penetration for each force, by the penalty that has grown with the corrections of the forces, (m,)."""
        grown = np.isfinite(lin.tolerances)
        return np.where(grown, lin.compliances / PENALTY_GROWTH**self.corrections, lin.compliances)

    def _anchored(self, forces: Floats, lin: ContactLinearisation) -> Floats:
        """Forces of the anchor where they are corrected."""
        return np.where(np.isfinite(lin.tolerances), carried_forces(self.anchor[0], forces, lin), 0.0)

    def _slides(self, lin: ContactLinearisation, displacements: Floats) -> Sliding | None:
        """Slips since the last step, where there is friction."""
        if len(lin.keys) == 0 or not lin.coefficients.any():
            return None
        return lin.slides(self.reference + displacements, self.before)

    def _slips(self, lin: ContactLinearisation, slides: Sliding) -> Floats:
        """Slips since the last step, with the elastic ones of it."""
        if self.start is None or self.start.friction is None:
            return slides.slips
        elastic = carried_forces(self.start.linearisation, self.start.friction.elastic, lin)
        return slides.slips + elastic

    def _let_back(self, lin: ContactLinearisation, tangential: Floats) -> Floats:
        """What the compliance of the law takes from the slips."""
        return self._compliances(lin) * (tangential - self._anchored(self.anchor[2], lin))

    def _step(self, *, bend: bool = True) -> _Step | None:
        """One iteration; None if the laws of the linearised problem have no solution.

        - `bend`: with the geometric stiffness, by which the tangent may be indefinite deep in a first overlap.
        """
        current, applied = self.current, np.zeros_like(self.displacements)
        if len(current.nodes) == 0:
            return self.forces, self.tangential, applied, np.zeros(self.parts.n)
        products, reaches = current.barriers.T
        # barriers push before surfaces meet
        gaps = self._gaps(current) - np.where(products > 0.0, reaches, 0.0)
        near = (self.forces > 0.0) | (gaps <= OPEN_GAP * self._scale())
        before, self.equations = self.equations if bend and self._serves(near) else None, None
        geometric, constrained = self._laws(before, bend=bend)
        while True:
            near = near if near.any() else ~near
            solution = self._step_of(geometric, constrained, near, before, bend=bend)
            if solution is None:
                return None
            forces, moved, motion = solution
            # the laws of the others hold with them open if the step leaves a gap there, which it closes by no more than
            # nodes of both sides move: the mean over a sliver of an edge has derivatives that say more
            step = moved - constrained.displacements
            apart = gaps + (constrained.jacobian @ step)[: len(near)]
            missed = ~near & (apart < 0.0) & (gaps < GAP_CLOSURE * float(np.abs(step).max()))
            if not missed.any():
                break
            near, before = near | missed, None
        nodal = constrained.directions.T @ forces - geometric @ step
        applied[current.nodes] = nodal.reshape(-1, 2)
        tangential = forces[len(near) :] if self.slides is not None else self.tangential
        return forces[: len(near)], tangential, applied, motion

    def _serves(self, near: Bools) -> bool:
        """Whether the equations of the iteration before, of the same constraints, are enough for one more.

        The residual that it leaves is about the product of the last one and of the last step, by which the derivatives
        have changed.
        """
        if self.equations is None:
            return False
        last, same_keys = self.history[-1], np.array_equal(self.equations.keys, self.current.keys[near])
        reached = last.residual <= OLD_DERIVATIVES_RESIDUAL and last.residual * last.change <= self.settings.tolerance
        return reached and not last.changed and same_keys and np.array_equal(self.equations.nodes, self.current.nodes)

    def _step_of(
        self, geometric: sp.csr_array, all_constraints: Constrained, near: Bools, before: _Equations | None, *,
        bend: bool,
    ) -> tuple[Floats, Floats, Floats] | None:  # fmt: skip
        """Forces of all constraints, displacements of the touched nodes, and motions, where only some may close."""
        current, n = self.current, self.parts.n
        rows = np.flatnonzero(np.tile(near, 1 if self.slides is None else 2))
        constrained = all_constraints.of(rows)
        coefficients, barriers = current.coefficients[near], current.barriers[near]
        guess, forces = np.concatenate((self.forces, self.tangential))[rows], np.zeros(len(all_constraints.violations))
        solver = None
        if self.slides is not None and not n and not barriers[:, 0].any() and len(rows) > MAX_DENSE_EQUATIONS:
            solver = self.response.constrained(self.rotations, current.nodes, geometric, constrained)
        if solver is not None:
            solved, diagonal = solver
            laws = active_set.Laws(coefficients, barriers, diagonal)
            answer = active_set.solve(laws, active_set.sparse_equations(solved, laws), guess)
            if answer is None:
                return None
            forces[rows] = answer.forces
            loads = constrained.directions.T @ answer.forces + geometric @ constrained.displacements
            bent = self.response.tangent(self.rotations, current.nodes, geometric, symmetric=False)
            return forces, bent(sp.csr_array(loads[:, None]))[:, 0], np.zeros(0)
        if before is None:
            problem = self._problem(geometric, constrained, current.keys[near])
        else:
            problem = self._problem_again(before, constrained, guess)
        matrix, rigid = problem.matrix, problem.rigid
        answer = self._answer(problem, (coefficients, barriers), guess, SPRING if bend else STIFF_SPRING)
        if answer is None:
            return None
        self.tangent = matrix, rigid, answer.forces[: len(coefficients)] > 0.0
        # if one more iteration was not enough, the next one has its own
        self.equations = problem if bend and before is None else None
        motion = self.parts.shortened(answer.motions, self.parts.velocities(self.motions, self.reference))
        forces[rows] = answer.forces
        return forces, problem.by_loads @ np.concatenate((answer.forces, (1.0,), motion)), motion

    def _answer(
        self, problem: _Equations, laws_of: tuple[Floats, Floats], guess: Floats, spring: float
    ) -> active_set.Answer | None:
        """Forces and motions of an iteration's equations, by coefficients and barriers, and a stiffness of springs.

        With springs against the motions there always is a solution; without them Newton's method for the motions goes
        on from there. Where nothing but springs holds a part they are soft, so that it falls on what is to hold it.
        """
        matrix, offset, rigid = problem.matrix, problem.offset, problem.rigid
        if not self.parts.n:
            laws = active_set.Laws(*laws_of, matrix.diagonal())
            return active_set.solve(laws, active_set.DenseEquations(matrix, offset, laws, rigid), guess)
        stiff, last = rigid.sprung(matrix.diagonal(), spring), None
        sprung = stiff
        for softness in SOFTNESSES:
            if last is not None:
                sprung = rigid.softly_sprung(stiff, last.forces, softness, RELAXATION**self.sliding)
            laws = active_set.Laws(*laws_of, matrix.diagonal() + sprung.compliances())
            answer = active_set.solve(laws, active_set.DenseEquations(matrix, offset, laws, sprung), guess)
            if answer is None and last is None:
                return None
            if answer is None:
                continue
            equations = active_set.DenseEquations(matrix, offset, laws, rigid)
            left, right, loose = equations.free_motions(answer)
            self.neutral = np.stack([np.linalg.qr(side)[0] for side in (left, right)])
            basis = _complement(left), _complement(right)
            held = active_set.DenseEquations(matrix, offset, laws, rigid.without(*basis))
            exact = None if loose else active_set.solve(laws, held, answer.forces)
            if exact is not None:
                self.unheld = np.zeros(self.parts.n)
                return exact._replace(motions=basis[1] @ exact.motions)
            if self.slides is not None:
                self.unheld = rigid.unbalanced(answer, self.neutral[0])
            if last is not None:
                return answer
            last = answer
        return last

    def _laws(self, before: _Equations | None, *, bend: bool = True) -> tuple[sp.csr_array, Constrained]:
        """Geometric stiffness, and gaps, then slips where there is friction, about the displacements."""
        current = self.current
        geometric = current.curvature(-self.forces) if before is None else before.geometric
        at_nodes = self.displacements[current.nodes].ravel()
        jacobian, directions, compliances = current.jacobian, current.jacobian, self._compliances(current)
        violations = self._gaps(current)
        if (slides := self.slides) is not None:
            if before is None:
                geometric = geometric + slides.curvature(-self.tangential)
            directions, jacobian = (
                sp.csr_array(sp.vstack((jacobian, of_slips))) for of_slips in (slides.directions, slides.jacobian)
            )
            compliances = np.tile(compliances, 2)
            slips = self._slips(current, slides) + self._let_back(current, np.zeros(len(violations)))
            violations = np.concatenate((violations, slips))
        geometric = geometric if bend else sp.csr_array(geometric.shape)
        return geometric, Constrained(at_nodes, jacobian, directions, compliances, violations)

    def _problem(self, geometric: sp.csr_array, constrained: Constrained, keys: Ints) -> _Equations:
        """Linear complementarity problem of an iteration with the constraints of some keys."""
        parts, nodes, slides = self.parts, self.current.nodes, self.slides
        at_nodes, jacobian, directions = constrained.displacements, constrained.jacobian, constrained.directions
        n = 2 * len(nodes)
        m = len(constrained.violations)
        positions = self.reference + self.displacements
        rigid = parts.velocities(self.motions, positions)[nodes].reshape(n, parts.n)
        turned = parts.turned(self.applied)[nodes].reshape(n, parts.n)
        by_rigid, by_forces = turned - geometric @ rigid, turned - geometric.T @ rigid
        loads = sp.hstack((directions.T, np.column_stack((geometric @ at_nodes, by_rigid))), format="csr")
        solved = self.response.tangent(self.rotations, nodes, geometric, symmetric=slides is None)
        answer = solved(loads)
        stiffness = by_forces.T @ answer[:, m + 1 :] - rigid.T @ (geometric @ rigid)
        # of the rotation's own second derivative; that of a rotation and a slide vanishes in equilibrium
        stiffness[np.diag_indices(parts.n)] += np.einsum("dq,dq->q", turned, rigid)
        stiffness += parts.tangent(self.motions)
        residual = by_forces.T @ (answer[:, m] - at_nodes) + parts.forces(self.motions)
        resultants = by_forces.T @ answer[:, :m] + (directions @ rigid).T
        answer[:, m + 1 :] += rigid
        at_gaps = jacobian @ answer
        matrix = at_gaps[:, :m] + np.diag(constrained.compliances)
        matrix = (matrix + matrix.T) / 2.0 if slides is None else matrix
        offset = constrained.violations - jacobian @ at_nodes + at_gaps[:, m]
        by_motion = at_gaps[:, m + 1 :]
        if slides is None:  # symmetric but for rounding
            stiffness, resultants = (stiffness + stiffness.T) / 2.0, by_motion.T
        motions = active_set.Motions(by_motion, resultants, stiffness, residual, parts.numbers, parts.sizes)
        return _Equations(keys, nodes, geometric, solved, answer, matrix, offset, motions, by_forces)

    def _problem_again(self, before: _Equations, constrained: Constrained, forces: Floats) -> _Equations:
        """The same about the present state and forces y, with derivatives of the iteration before.

        With the forces e that are not balanced, displacements are ``u + Y e + Y D^T (y' - y)``.
        """
        unbalanced = (self._nodal() - self.applied)[self.current.nodes]
        moved = before.solved(sp.csr_array(unbalanced.reshape(-1, 1)))[:, 0]
        by_loads, m = before.by_loads.copy(), len(forces)
        by_loads[:, m] = constrained.displacements + moved - by_loads[:, :m] @ forces
        offset = constrained.violations + constrained.jacobian @ moved + constrained.compliances * forces
        residual = self._left() + before.by_forces.T @ moved - before.rigid.resultants @ forces
        rigid = replace(before.rigid, residual=residual)
        return before._replace(by_loads=by_loads, offset=offset - before.matrix @ forces, rigid=rigid)

    def _nodal(self) -> Floats:
        """Forces of the constraints on all surface nodes, shape (n_nodes, 2)."""
        return nodal_forces_of(self.current, self.forces, self.slides, self.tangential, len(self.reference))

    def _left(self) -> Floats:
        """What is left of forces, loads and springs along the motions of handles, shape (n,)."""
        return self.parts.residual(self.motions, self.reference + self.displacements, self._nodal())

    def _stays_free(self) -> str:
        """Words for the motions that nothing holds in the solution."""
        if not self.parts.n:
            return ""
        (kept, free), unstable = self.neutral, np.zeros((self.parts.n, 0))
        if not self.forces.any():
            kept = free = np.eye(self.parts.n)
        elif free.shape[1] < self.parts.n and self.slides is None:
            matrix, rigid, active = self.tangent  # of the last step, which changes nothing any more
            unstable = rigid.unstable(matrix, active, kept)
            self.stable = False if unstable.size else None if free.size else True
        left = self._left()
        size = float(np.abs(kept.T @ left).max(initial=0.0))
        why = "nothing prevents"
        if size > MAX_UNBALANCED_FORCE * self.forces.sum():
            why = f"hardly anything prevents: it is kept in place, against a force of {size:.2g}"
        named = [f"{words}, which {why}" for words in self.parts.describe(self.motions, free)]
        named += [f"{words} out of an unstable equilibrium" for words in self.parts.describe(self.motions, unstable)]
        return "".join(f"; {words}" for words in named)

    def _explain(self) -> str:
        last = self.history[-1]
        advice = "take a softer penalty or a finer mesh"
        if not last.changed:
            reason = f"the displacements still change by {last.change:.1e} of the maximum one"
        else:
            positions = self.reference + self.displacements
            named = [self.constraints.describe(key, positions) for key in last.changed[:MAX_NAMED]]
            more = f" and {len(last.changed) - MAX_NAMED} more" if len(last.changed) > MAX_NAMED else ""
            reason = f"contact still comes and goes at {'; '.join(named)}{more}"
            advice += (
                "; with node-to-segment contact, nodes opposite each other change between two edges: take elements of "
                "another size on one side, as half of it, or segment-to-segment"
            )
        count = _counted(len(self.history), "iteration")
        return f"not converged in {count}: {reason}; {self._worst()}; {advice}"

    def _worst(self) -> str:
        """Words for the motion or node that is in equilibrium least, or the node whose laws are violated most."""
        laws, nodes, motions = self._residuals()
        names, positions = self.constraints, self.reference + self.displacements
        if motions.max(initial=0.0) > max(laws.max(initial=0.0), nodes.max()):
            worst = np.where(np.arange(self.parts.n) == motions.argmax(), 1.0, 0.0)
            words = "; ".join(self.parts.describe(self.motions, worst[:, None]))
            return f"a force of {abs(float(self._left() @ worst)):.3g} is not balanced, under which {words}"
        if laws.max(initial=0.0) > nodes.max():
            return f"the laws are violated most at {names.describe(int(self.current.keys[laws.argmax()]), positions)}"
        node = int(nodes.argmax())
        force = float(np.linalg.norm((self._nodal() - self.applied)[node]))
        return f"a force of {force:.3g} is not balanced at {names.describe_node(node, positions)}"

    def _approach(self) -> str:
        """Move handles that nothing touches along their loads until a surface is within reach; words if none comes.

        Their equations have no contact that answers: springs alone, or nothing but the way to the next surface.
        """
        if not self.parts.n:
            return ""
        scale, reach, travel = (
            MAX_FORCE_ALONG_MOTION * np.abs(self.parts.load).max(initial=0.0),
            self.constraints.reach,
            0.0,
        )
        while travel <= MAX_TRAVEL * self.parts.size:
            alone = self.parts.untouched(self.current.nodes)
            left = np.where(alone, self.parts.forces(self.motions), 0.0)
            if not (np.abs(left) > scale).any():
                return ""
            stiffness, step = self.parts.springs[np.ix_(alone, alone)], np.zeros(self.parts.n)
            step[alone] = np.linalg.lstsq(stiffness, left[alone], rcond=None)[0]
            left[alone] -= stiffness @ step[alone]
            velocities = self.parts.velocities(self.motions, self.reference)
            if (np.abs(left) > scale).any():  # no spring holds it: as far as the next surface is found
                left = (
                    self.parts.without_turns(left) if (self.parts.without_turns(np.abs(left)) > scale).any() else left
                )
                step += left * reach / float(np.linalg.norm(velocities @ left, axis=1).max())
            length = float(np.linalg.norm(velocities @ step, axis=1).max())
            travel += min(length, reach)
            self.move(self.motions + step * min(1.0, reach / length))
            self.take_over(self.constraints.linearise(self.reference + self.displacements, self.current))
        return self._loose(np.ones(self.parts.n, dtype=np.bool_))

    def _loose(self, among: Bools) -> str:
        """Names the parts that move away because nothing answers to their loads, by ``among`` the motions, (n,)."""
        left = self._left()
        velocities = self.parts.velocities(self.motions, self.reference + self.displacements)
        held = np.einsum("niq,ni->q", np.abs(velocities), np.abs(self._nodal()))
        beyond = MAX_FORCE_ALONG_MOTION * np.abs(self.parts.load).max(initial=0.0)
        pushed = np.where(among & (np.abs(left) > beyond) & (held < beyond), left, 0.0)
        words = self.parts.describe(self.motions, pushed[:, None] / np.abs(pushed).max()) if pushed.any() else []
        if not words:
            return ""
        self.is_unheld = True
        return (
            f"no contact holds a load: {'; '.join(words)}; check its direction and its size, place the part "
            "before what is to hold it, hold it in Body(held=...), or leave its load out"
        )

    def result(self, message: str, *, converged: bool) -> ContactState:
        message += self._stays_free() if converged else ""
        # which constraints are said to be closed must not rest on the last digit of the others' forces
        self.forces = np.where(self.forces > ROUND_OFF * self.forces.max(initial=0.0), self.forces, 0.0)
        friction = None
        if (slides := self.slides) is not None:
            slips, let_back = self._slips(self.current, slides), self._let_back(self.current, self.tangential)
            given = self.forces, self.tangential, slips, let_back
            previous = np.zeros(len(self.forces))
            if self.start is not None:
                previous = carried_forces(self.start.linearisation, self.start.forces, self.current)
            friction = active_set.friction_state(*given, self.current.coefficients, previous)
        residual = self.history[-1].residual if self.history else np.inf
        return ContactState(
            Status(converged, message, len(self.history), residual=residual, is_unheld=self.is_unheld),
            self.placements,
            self.displacements,
            self.reference + self.displacements,
            self.current,
            self.forces,
            self._nodal(),
            tuple(self.history),
            friction,
            self.motions,
            self.stable,
            self.response,
        )


def _complement(directions: Floats) -> Floats:
    """Orthonormal directions (n, n - r) across those of the columns (n, r)."""
    n, r = directions.shape
    return np.linalg.qr(directions, mode="complete")[0][:, r:] if r else np.eye(n)


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"


def _is_near(start: ContactState, reference: Floats) -> bool:
    """Whether a start's bodies have moved by less than a part of their displacements."""
    moved = np.abs(reference - (start.positions - start.displacements)).max()
    return bool(moved <= START_DISTANCE * np.abs(start.displacements).max())
