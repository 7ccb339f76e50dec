"""The position of the wheelset in which contact forces and load are in equilibrium (Moherdaui 2021, 7.2.1)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flangeway.railway.track.placements import WheelsetMotion
from flangeway.railway.wheelset.residual import RelativeResiduals, is_stable, jacobian_of, residuals_of
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState, Status, StepSettings, follow, solve_contact
from flangeway.types import Floats

FIRST_PENETRATION_MM = 0.1
FIRST_CAP = np.array([0.3, 0.3, 3e-4])  # mm, mm, rad: the lateral stiffness jumps when a flange touches
MAX_GROWTH = 64.0
SMALLEST_GROWTH = 1.0 / 1024.0
MAX_ITERATIONS = 60
STALLED = 15
"""Steps in which the error does not fall by a tenth, after which the search is given up."""

TOLERANCE = 1e-12
ACCEPTED = 1e-10
LOWERED = 0.05
"""Vertical error below which the wheelset is free to move aside and to roll."""

DOWN = np.array([False, True, False])
WORSE = 4.0
"""Growth of the error above which a step is taken back and tried at a quarter of its length."""

NEXT_STEP = StepSettings(smallest=0.125)
"""Steps of contact on the way to the next position: where they fail, a shorter way is tried before shorter steps."""

FARTHEST = np.array([30.0, 30.0, 0.05])
"""Motion in mm, mm and rad from where the search started, beyond which the wheelset has left the track."""


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
    stable
        Whether the wheelset comes back after a small push; None where that has no meaning: not in balance, or held.
    history
        Errors at each position that the search tried, in order.

    """

    status: Status
    motion: WheelsetMotion
    balance: RelativeResiduals
    state: ContactState
    stable: bool | None = None
    history: tuple[RelativeResiduals, ...] = ()


def find_equilibrium(
    model: WheelsetModel,
    response: BodyResponse,
    progress: Callable[[str], None] = lambda _: None,
    start: WheelsetMotion | None = None,
) -> Equilibrium:
    """Find the components of the motion that are not prescribed by Newton's method with the exact Jacobian.

    The search starts a little below a place where rigid wheels rest, where the forces have derivatives. Steps are
    limited; the limit grows while they lead on and shrinks when one makes the balance much worse.

    Parameters
    ----------
    model, response
        The wheelset and its bodies.
    progress
        Called with a sentence after each step.
    start
        Where rigid wheels rest; the model's own by default.

    """
    return _Search(model, response, progress, model.start_motion if start is None else start).run()


class _Search:
    """The state of a search."""

    def __init__(
        self, model: WheelsetModel, response: BodyResponse, progress: Callable[[str], None], start: WheelsetMotion
    ) -> None:
        self.model, self.response, self.progress = model, response, progress
        self.free = np.array([value is None for value in model.problem.prescribed.components])
        # down first: a wheelset that hangs on its flanges slips aside before they have pushed the rails apart
        self.now = self.free & DOWN if (self.free & DOWN).any() else self.free
        self.start = start
        self.motion = _pressed(model, start)
        self.state = contact_at(model, response, self.motion, start=start)
        self.residual, self.balance = residuals_of(model, response, self.motion, self.state)
        self.growth, self.last_error = 1.0, np.inf
        self.safe = (self.motion, self.state)
        self.least = (np.inf, 0)
        self.best: Equilibrium | None = None
        self.history: list[RelativeResiduals] = []

    def run(self) -> Equilibrium:
        iteration = 0
        for iteration in range(MAX_ITERATIONS):
            error = self._error()
            self.history.append(self.balance)
            self.progress(f"balance {error:.1e} after {iteration} steps")
            lost = not self.state.status.converged or not self.state.forces.any()
            if not self.free.any() and not lost:
                return self._found(Status(True, "contact forces at the prescribed position", iteration))
            if iteration and (lost or error > WORSE * self.last_error) and self._can_go_back():
                self.growth /= 4.0
                self._be_at(*self.safe)
                limited = False
            elif lost or self._is_away():
                return self._found(Status(False, self._why(), iteration))
            elif self._has_stalled(error, iteration):
                break
            else:
                if self._is_done(error, iteration) and self.best is not None:
                    return self.best
                self.last_error, self.safe = error, (self.motion, self.state)
                limited = True
            self._advance(may_grow=limited)
        failure = (
            f"no balance in {iteration + 1} steps, error {self._error():.1e}; check that these profiles can bear the "
            "load, and that load and Young's modulus are in the stated units"
        )
        return self.best or self._found(Status(False, failure, iteration + 1))

    def _error(self) -> float:
        """Error of what is free now; once the weight is borne, of all that is not prescribed."""
        error = self.balance.error_of(self.now)
        if error < LOWERED and self.now is not self.free:
            self.now, self.growth, self.last_error = self.free, 1.0, np.inf
            self.least = (np.inf, self.least[1])
            error = self.balance.error_of(self.free)
        return error

    def _has_stalled(self, error: float, iteration: int) -> bool:
        if error < 0.9 * self.least[0]:
            self.least = (error, iteration)
        return iteration - self.least[1] > STALLED

    def _is_done(self, error: float, iteration: int) -> bool:
        if self.best is not None and error >= self.best.balance.equilibrium_residual:
            return True  # round-off: the last step was no better
        if error > ACCEPTED or self.now is not self.free:
            return False
        self.best = self._found(Status(True, f"contact forces balance the load to {error:.1e}", iteration))
        return error <= TOLERANCE

    def _can_go_back(self) -> bool:
        return self.growth > SMALLEST_GROWTH and self.best is None

    def _is_away(self) -> bool:
        return bool((np.abs(np.array(self.motion.components) - self.start.components) > FARTHEST).any())

    def _why(self) -> str:
        if not self.state.status.converged:
            return f"the contact forces were not found: {self.state.status.message}"
        given = "" if self.free.all() else "what is prescribed, "
        return f"the wheels left the rails; check {given}the load and the profiles"

    def _found(self, status: Status) -> Equilibrium:
        stable = None
        if status.converged and self.free.all():
            jacobian = jacobian_of(self.model, self.response, self.motion, self.state)
            stable = is_stable(self.model, self.motion, jacobian)
        return Equilibrium(status, self.motion, self.balance, self.state, stable, tuple(self.history))

    def _be_at(self, motion: WheelsetMotion, state: ContactState) -> None:
        self.motion, self.state = motion, state
        self.residual, self.balance = residuals_of(self.model, self.response, motion, state)

    def _advance(self, *, may_grow: bool) -> None:
        step, limited = self._step()
        if limited and may_grow:
            self.growth = min(2.0 * self.growth, MAX_GROWTH)
        target = self.motion.moved(WheelsetMotion(*step))
        self._be_at(target, contact_at(self.model, self.response, target, self.safe))

    def _step(self) -> tuple[Floats, bool]:
        """Newton's step of the free components within a cap, and whether the cap limited it."""
        jacobian = jacobian_of(self.model, self.response, self.motion, self.state)
        cap, free = self.growth * FIRST_CAP, self.now
        step = np.zeros(3)
        system = jacobian[np.ix_(free, free)]
        # one wheel alone may have no stiffness in some direction: the least of all steps then
        step[free] = np.linalg.lstsq(system * cap[free], -self.residual[free], rcond=1e-14)[0] * cap[free]
        if np.array_equal(free, DOWN) and step[1] * self.residual[1] < 0.0:
            # where a flange gives way the force falls as the wheelset sinks: go on
            step[1] = np.sign(self.residual[1]) * cap[1]
        excess = float((np.abs(step) / cap).max())
        return step / max(1.0, excess), excess > 1.0


def _pressed(model: WheelsetModel, start: WheelsetMotion) -> WheelsetMotion:
    """Return a position in which both wheels press on the rails, with what is prescribed."""
    rest = start.moved(WheelsetMotion(vertical_mm=-FIRST_PENETRATION_MM))
    given = model.problem.prescribed
    return WheelsetMotion(
        rest.lateral_mm if given.lateral_mm is None else given.lateral_mm,
        rest.vertical_mm if given.vertical_mm is None else given.vertical_mm,
        rest.roll_rad if given.roll_rad is None else given.roll_rad,
    )


def contact_at(
    model: WheelsetModel,
    response: BodyResponse,
    motion: WheelsetMotion,
    known: tuple[WheelsetMotion, ContactState] | None = None,
    *,
    start: WheelsetMotion | None = None,
) -> ContactState:
    """Contact forces at a position of the wheelset, by adaptive steps from a known one.

    Parameters
    ----------
    model, response
        The wheelset and its bodies.
    motion
        The position.
    known
        A position and its contact forces.
    start
        Without a known one: where the wheels only just touch; the model's rigid rest by default.

    """
    origin, state = known if known is not None else (model.start_motion if start is None else start, None)
    change = WheelsetMotion(
        motion.lateral_mm - origin.lateral_mm,
        motion.vertical_mm - origin.vertical_mm,
        motion.roll_rad - origin.roll_rad,
    )

    def solve_at(part: float, from_state: ContactState | None) -> ContactState:
        placements = model.placements(origin.moved(change, part))
        return solve_contact(response, model.system, placements, start=from_state)

    return follow(solve_at, state, None if known is None else NEXT_STEP)
