"""An equilibrium of a wheelset (Moherdaui 2021, 7.2.1), and the search for that of one in three dimensions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.residual import (
    MAX_STEP,
    TOLERANCE,
    RelativeResiduals,
    is_stable,
)
from flangeway.solve import Status
from flangeway.types import Floats

FIRST_PENETRATION_MM = 0.1
MAX_GROWTH = 64.0
MIN_GROWTH = 1.0 / 1024.0  # factors on the step limits

MAX_ITERATIONS = 60
STALLED = 15  # steps in which the residual does not fall by a tenth, after which the search is given up
ROUND_OFF = 1e-12  # equilibrium residual at which the search ends at once
LOWERED = 0.05  # vertical residual below which the wheelset is free to move laterally and to roll

DOWN = np.array([False, True, False])
WORSE = 4.0  # growth of the residual above which a step is taken back and tried at a quarter of its length

MAX_WAY = np.array([30.0, 30.0, 0.05])
"""Displacement in mm, mm and rad from where the search started, beyond which the wheelset has left the track."""


class AxleState(Protocol):
    """Contact of the wheelset at one position, plane or in three dimensions."""

    @property
    def status(self) -> Status:
        """Whether the contact forces were found."""

    @property
    def forces(self) -> Floats:
        """Contact forces, zero where there is no contact."""


State = TypeVar("State", bound=AxleState)


class AxleContact(Protocol[State]):
    """What the search of an equilibrium needs of the bodies."""

    @property
    def problem(self) -> WheelsetProblem:
        """Loads, and what is prescribed."""

    @property
    def rigid_position(self) -> WheelsetPosition:
        """Position in which the rigid wheelset touches."""

    def contact_at(
        self,
        position: WheelsetPosition,
        before: tuple[WheelsetPosition, State] | None = None,
        start: WheelsetPosition | None = None,
    ) -> State:
        """Contact forces at a position, from one before or from where the wheels only just touch."""

    def residuals_of(self, position: WheelsetPosition, state: State) -> tuple[Floats, RelativeResiduals]:
        """Residual of the equilibrium, and its relative values; see `with_loads`."""

    def jacobian_of(self, position: WheelsetPosition, state: State) -> Floats:
        """Derivatives of the residual by lateral and vertical displacement and roll, shape (3, 3)."""


@dataclass(frozen=True, eq=False)
class Equilibrium(Generic[State]):
    """A position of the wheelset and its contact forces.

    - `status`: how the search ended.
    - `residuals`: relative residuals of the equilibrium in the current configuration.
    - `state`: contact forces and displacements of the surfaces.
    - `residual`: forces in the track's axes and moment about the axle's middle that are left, shape (3,).
    - `stable`: whether the wheelset comes back after a small push; None where that has no meaning: no equilibrium, or
      held.
    - `history`: residuals at each position that the search tried, in order.
    """

    status: Status
    position: WheelsetPosition
    residuals: RelativeResiduals
    state: State
    residual: Floats
    stable: bool | None = None
    history: tuple[RelativeResiduals, ...] = ()


def search_equilibrium(
    contact: AxleContact[State],
    progress: Callable[[str], None] = lambda _: None,
    start: WheelsetPosition | None = None,
    *,
    near: tuple[WheelsetPosition, State] | None = None,
    tolerance: float = TOLERANCE,
    enough: float = ROUND_OFF,
) -> Equilibrium[State]:
    """Find what is not prescribed of the position by Newton's method with the exact Jacobian.

    The search starts a little below a rigid equilibrium, where the forces have derivatives. Steps are limited; the
    limit grows while they lead on and shrinks when one makes the residual much worse.

    - `progress`: called with a sentence after each step.
    - `start`: a rigid equilibrium; that of the bodies by default.
    - `near`: a position close to the equilibrium, with its contact, to start from instead.
    - `tolerance`: equilibrium residual up to which a position is in equilibrium.
    - `enough`: equilibrium residual at which the search ends at once; else it goes on until no step is better.
    """
    search = _Search(contact, contact.rigid_position if start is None else start, near)
    iteration = 0
    for iteration in range(MAX_ITERATIONS):
        error = search.norm()
        search.history.append(search.residuals)
        progress(f"equilibrium residual {error:.1e} after {iteration} steps")
        lost = not search.state.status.converged or not search.state.forces.any()
        if not search.free.any() and not lost:
            return search.found(Status(True, "contact forces at the prescribed position", iteration))
        if iteration and (lost or error > WORSE * search.last_error) and search.can_go_back():
            search.growth /= 4.0
            search.evaluate(*search.safe)
            search.step(may_grow=False)
            continue
        if lost or search.is_away():
            return search.found(Status(False, search.why(), iteration))
        if search.has_stalled(error, iteration):
            break
        if search.best is not None and error >= search.best.residuals.equilibrium_residual:
            return search.best  # round-off: the last step was no better
        if error <= tolerance and search.now is search.free:
            message = f"contact forces and load are in equilibrium to {error:.1e}"
            search.best = search.found(Status(True, message, iteration))
            if error <= enough:
                return search.best
        search.last_error, search.safe = error, (search.position, search.state)
        search.step(may_grow=True)
    failure = (
        f"no equilibrium in {iteration + 1} steps, residual {search.norm():.1e}; check that these profiles can carry "
        "the load, and that load and Young's modulus are in the stated units"
    )
    return search.best or search.found(Status(False, failure, iteration + 1))


class _Search(Generic[State]):
    """The state of a search."""

    def __init__(
        self, contact: AxleContact[State], start: WheelsetPosition, near: tuple[WheelsetPosition, State] | None
    ) -> None:
        self.contact, self.start = contact, start
        prescribed = contact.problem.prescribed.components
        self.free = np.array([value is None for value in prescribed])
        # down first: a wheelset that hangs on its flanges slips sideways before they have pushed the rails apart
        self.now = self.free & DOWN if (self.free & DOWN).any() else self.free
        pressed = near[0] if near is not None else start.moved(WheelsetPosition(vertical_mm=-FIRST_PENETRATION_MM))
        position = WheelsetPosition(
            *(a if b is None else b for a, b in zip(pressed.components, prescribed, strict=True))
        )
        self.evaluate(position, contact.contact_at(position, near, start))
        self.growth, self.last_error = 1.0, np.inf
        self.safe = (self.position, self.state)
        self.least = (np.inf, 0)
        self.best: Equilibrium[State] | None = None
        self.history: list[RelativeResiduals] = []

    def evaluate(self, position: WheelsetPosition, state: State) -> None:
        """Be at a position."""
        self.position, self.state = position, state
        self.residual, self.residuals = self.contact.residuals_of(position, state)

    def norm(self) -> float:
        """Residual of what is free now; once the weight is carried, of all that is not prescribed."""
        error = self.residuals.norm_of(self.now)
        if error < LOWERED and self.now is not self.free:
            self.now, self.growth, self.last_error = self.free, 1.0, np.inf
            self.least = (np.inf, self.least[1])
            error = self.residuals.norm_of(self.free)
        return error

    def has_stalled(self, error: float, iteration: int) -> bool:
        if error < 0.9 * self.least[0]:
            self.least = (error, iteration)
        return iteration - self.least[1] > STALLED

    def can_go_back(self) -> bool:
        return self.growth > MIN_GROWTH and self.best is None

    def is_away(self) -> bool:
        return bool((np.abs(np.array(self.position.components) - self.start.components) > MAX_WAY).any())

    def why(self) -> str:
        if not self.state.status.converged:
            return f"the contact forces were not found: {self.state.status.message}"
        prescribed = "" if self.free.all() else "what is prescribed, "
        return f"the wheels left the rails; check {prescribed}the load and the profiles"

    def found(self, status: Status) -> Equilibrium[State]:
        stable = None
        if status.converged and self.free.all():
            stable = is_stable(self.contact.problem, self.contact.jacobian_of(self.position, self.state))
        history = tuple(self.history)
        return Equilibrium(status, self.position, self.residuals, self.state, self.residual, stable, history)

    def step(self, *, may_grow: bool) -> None:
        """Newton's step of the free components within the step limits."""
        jacobian = self.contact.jacobian_of(self.position, self.state)
        limit, free = self.growth * MAX_STEP, self.now
        step = np.zeros(3)
        system = jacobian[np.ix_(free, free)]
        # one wheel alone may have no stiffness in some direction: the least of all steps then
        step[free] = np.linalg.lstsq(system * limit[free], -self.residual[free], rcond=1e-14)[0] * limit[free]
        if np.array_equal(free, DOWN) and step[1] * self.residual[1] < 0.0:
            # where a flange slips the force falls as the wheelset sinks: go on
            step[1] = np.sign(self.residual[1]) * limit[1]
        excess = float((np.abs(step) / limit).max())
        if excess > 1.0 and may_grow:
            self.growth = min(2.0 * self.growth, MAX_GROWTH)
        target = self.position.moved(WheelsetPosition(*(step / max(1.0, excess))))
        self.evaluate(target, self.contact.contact_at(target, self.safe))
