"""Parts pressed together by loads, by prescribed motions, or by a force on one of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flangeway.cases.case import Progress
from flangeway.contact import Contact, ContactLinearisation, ContactSolution, ContactSystem, LoadStep, press
from flangeway.contact.press import Load
from flangeway.geometry import Placement
from flangeway.problems import Part
from flangeway.solve import CondensedBodies, ContactState, Status, StepSettings, follow, solve_contact
from flangeway.solve.body_response import LoadedBodies
from flangeway.types import Floats

Trial = tuple[float, float, ContactState]
"""A distance along the push, the excess of the contact's resistance there, and the solution."""

MAX_ERROR = 1e-7  # relative difference of the force on a pushed part from the prescribed one at which the search ends
NEAR = 1e-2
"""Excess at both ends of a bracket, over the force, below which the stiffness in it is compared with the one before."""
JUMP = 10.0
"""Stiffness in such a bracket over that in the larger one before above which the resistance jumps there: of augmented
Lagrange, where the number of corrections changes."""
SLOW = 0.3  # excess over the one before above which a step with one stiffness changes it
MOST_TRIALS = 60
SMALLEST_STEP = 1.0 / 1024.0


@dataclass(frozen=True)
class Push:
    """A force on the supports of a part, which move together along its direction until the contact carries it."""

    part: Part  # the part
    direction: tuple[float, float]  # unit vector x, y
    force: float
    """Force that the supports exert on the part, >= 0. With 0 the contact carries the part's loads alone: the supports
    let it slide along the direction, and the reaction of a support against that is zero in the end."""


@dataclass(frozen=True, eq=False)
class Pressed:
    """Parts in contact."""

    contact: ContactSolution  # the solution
    pushed: float = 0.0  # how far the pushed part has moved along the force; 0 without one

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.contact.status

    def placement(self, part: Part) -> Placement:
        """Rigid motion of a part's supports."""
        return self.contact.state.placements[self.contact.system.parts.index(part)]

    def force_on(self, part: Part) -> Floats:
        """Contact forces on a part in space, shape (2,)."""
        return _force_on(self.contact, part)


def press_loaded(
    contacts: Sequence[Contact],
    *,
    motion: Mapping[Part, Placement] | None = None,
    fields: Mapping[Part, Floats] | None = None,
    push: Push | None = None,
    loads: Mapping[Part, Floats] | None = None,
    n_steps: int = 1,
    progress: Progress = lambda _: None,
) -> Pressed:
    """Bring parts in contact under loads and motions, in proportional steps, and then push one of them.

    - `motion`: rigid motion of the supports of each part that moves.
    - `fields`: displacements of each part under its loads and its supports' prescribed displacements without contact,
      shape (n_dofs, 2), see `LoadedBodies`.
    - `push`: a force on one part, applied after the other loads.
    - `loads`: resultant of each part's loads, shape (2,); the contact also carries those of the pushed part.
    - `n_steps`: equal steps of loads and motions; halved where one does not converge.
    """
    driver = _Driver(ContactSystem(contacts), motion or {}, fields or {}, progress)
    step = 1.0 / n_steps
    state = follow(driver.at_share, None, StepSettings(step, step, min(step, SMALLEST_STEP)))
    if push is None or not state.status.converged:
        return Pressed(driver.solution(state))
    load = np.zeros(2) if loads is None else loads.get(push.part, np.zeros(2))
    return _Search(driver, push, load, state).run()


def press_path(
    contacts: Sequence[Contact],
    legs: Sequence[Mapping[Part, Placement]],
    push: Push | None,
    n_steps: int = 1,
    progress: Progress = lambda _: None,
) -> Pressed:
    """Follow a path of motions, with friction and bodies that contact alone holds; a push along x or y grows in leg 1.

    Each leg has `n_steps` equal steps, halved where one does not converge.
    """
    step = 1.0 / n_steps
    loads: dict[Part, Load] = {}
    if push is not None:
        x, y = (push.force * each or None for each in push.direction)
        loads[push.part] = (x, y, None)
    sizes = StepSettings(step, step, min(step, SMALLEST_STEP))
    found = Pressed(press(contacts, list(legs), loads=loads, steps=[sizes] * len(legs), progress=progress))
    if push is None:
        return found
    start, last = push.part.placement.translation, found.placement(push.part).translation
    return replace(found, pushed=float(np.subtract(last, start) @ push.direction))


def moved_part(part: Part, motion: Mapping[Part, Placement], share: float) -> Placement:
    """Placement of the frame of a part after a share of its motion."""
    if part not in motion:
        return part.placement
    x, y = motion[part].translation
    return Placement(share * motion[part].rotation_rad, (share * x, share * y)).after(part.placement)


class _Driver:
    """Solves for shares of loads and motions, and for a further motion of one part."""

    def __init__(
        self, system: ContactSystem, motion: Mapping[Part, Placement], fields: Mapping[Part, Floats], progress: Progress
    ) -> None:
        self.system, self.motion, self.progress = system, motion, progress
        self.bodies = CondensedBodies(system.surface_nodes)
        self.fields = [fields.get(part) for part in system.parts]
        self.steps: list[LoadStep] = []

    def at_share(self, share: float, start: ContactState | None) -> ContactState:
        state = solve_contact(self.loaded(share), self.system, self.placements(share), start=start)
        self.progress(f"{100.0 * share:.4g} % of loads and motions: {state.status.message}")
        if state.status.converged:
            self.steps.append(LoadStep(share, state))
        return state

    def loaded(self, share: float) -> LoadedBodies:
        return LoadedBodies(self.bodies, self.fields, share)

    def placements(
        self, share: float, pushed: Part | None = None, further: tuple[float, float] = (0.0, 0.0)
    ) -> tuple[Placement, ...]:
        moved = ((part, moved_part(part, self.motion, share)) for part in self.system.parts)
        return tuple(Placement(0.0, further).after(each) if part is pushed else each for part, each in moved)

    def solution(self, state: ContactState, *, whole: bool = True) -> ContactSolution:
        reference = self.bodies.reference(tuple(part.placement for part in self.system.parts))
        depths = [float((-pairs.gaps).max(initial=0.0)) for pairs in self.system.linearise(reference, None).pairs]
        found = ContactSolution(self.system, self.loaded(1.0), state, tuple(self.steps), np.array(depths))
        return found.without_overlap() if whole else found


class _Search:
    """Finds how far a part is to be pushed: the contact's resistance rises with the distance."""

    def __init__(self, driver: _Driver, push: Push, load: Floats, state: ContactState) -> None:
        self.driver, self.part = driver, push.part
        self.direction = np.array(push.direction)
        self.wanted = push.force + float(load @ self.direction)
        self.scale = max(push.force, abs(self.wanted))
        body = push.part.body
        stiffness = max(float(m.matrix.diagonal().max()) for m in body.elasticity.materials) * body.thickness
        self.first_step = self.scale / stiffness
        self.reach = 2.0 * max(part.body.elasticity.size for part in driver.system.parts)
        self.least = float(np.finfo(np.float64).eps) * self.reach * stiffness
        """Force of an approach as small as rounding of the positions."""
        self.trials = 0
        self.low = (0.0, self._excess(state), state)

    def run(self) -> Pressed:
        if self.wanted <= 0.0:
            return self._failed("the loads on the pushed part are larger than the force and pull it away")
        if self.wanted < self.least:
            return self._failed(
                f"the contact has to carry {self.wanted:.1e} N, less than the rounding error of the positions: "
                f"{self.least:.1e} N"
            )
        bracket = self._bracket()
        if isinstance(bracket, str):
            return self._failed(bracket)
        return self._refined(*bracket)

    def _excess(self, state: ContactState) -> float:
        """Contact's resistance less what it must be."""
        return -float(_force_on(self.driver.solution(state, whole=False), self.part) @ self.direction) - self.wanted

    def _solve(self, distance: float, start: ContactState) -> Trial:
        self.trials += 1
        x, y = (distance * self.direction).tolist()
        placements = self.driver.placements(1.0, self.part, (x, y))
        state = solve_contact(self.driver.loaded(1.0), self.driver.system, placements, start=start)
        excess = self._excess(state) if state.status.converged else np.nan
        return distance, excess, state

    def _bracket(self) -> tuple[Trial, Trial] | str:
        """Two distances of which one is too little and one too much; or why there are none."""
        low, step, why = self.low, self.first_step, "check its direction and the bodies' positions"
        sign = 1.0 if low[1] < 0.0 else -1.0
        while self.trials < MOST_TRIALS:
            free = self._free_way(low[2]) if sign > 0.0 else 0.0
            next_ = self._solve(low[0] + sign * max(step, free), low[2])
            if not next_[2].status.converged:
                step = max(step, free) / 4.0
                why = f"at {next_[0]:.4g} along the push: {next_[2].status.message}"
                if step < SMALLEST_STEP * self.first_step:
                    return why
                continue
            if next_[1] * sign >= 0.0:
                return (low, next_) if sign > 0.0 else (next_, low)
            if abs(next_[0]) > self.reach:
                return (
                    f"no contact carries the force within {self.reach:.4g} mm of motion along the push; check its "
                    "direction and its size"
                )
            if free < step:
                step *= 2.0
            low = next_
        return f"the force is not reached in {MOST_TRIALS} trials; {why}"

    def _free_way(self, state: ContactState) -> float:
        """Distance that no contact is nearer than, so that nothing is passed over; zero where there is one."""
        lin = state.linearisation
        assert isinstance(lin, ContactLinearisation)
        gaps = np.concatenate([pairs.gaps for pairs in lin.pairs])
        return 0.0 if len(gaps) == 0 or state.forces.any() else max(float(gaps.min()), 0.0)

    def _refined(self, low: Trial, high: Trial) -> Pressed:
        """Regula falsi; an end that stays twice loses half of its weight (Illinois)."""
        weights, last = [low[1], high[1]], -1
        best = min(low, high, key=lambda trial: abs(trial[1]))
        if high[0] == low[0]:  # two solutions at one distance: the contact jumps
            return self._checked(best)
        stiffness = (high[1] - low[1]) / (high[0] - low[0])
        while abs(best[1]) > MAX_ERROR * self.scale and self.trials < MOST_TRIALS and high[0] != low[0]:
            slope = (high[1] - low[1]) / (high[0] - low[0])
            if max(-low[1], high[1]) > NEAR * self.scale:
                stiffness = slope
            elif slope > JUMP * stiffness:
                best = self._settled(best, stiffness)
                break
            distance = (low[0] * weights[1] - high[0] * weights[0]) / (weights[1] - weights[0])
            best = self._solve(distance, low[2] if abs(low[1]) < abs(high[1]) else high[2])
            self.driver.progress(f"pushed by {distance:.6g}: {best[2].status.message}")
            if not best[2].status.converged:
                break
            side = 0 if best[1] < 0.0 else 1
            low, high = (best, high) if side == 0 else (low, best)
            weights[side] = best[1]
            weights[1 - side] /= 2.0 if side == last else 1.0
            last = side
        return self._checked(best)

    def _settled(self, best: Trial, stiffness: float) -> Trial:
        """Newton's method with a stiffness that hardly changes, each trial from the last, whose forces it corrects."""
        while abs(best[1]) > MAX_ERROR * self.scale and self.trials < MOST_TRIALS:
            trial = self._solve(best[0] - best[1] / stiffness, best[2])
            self.driver.progress(f"pushed by {trial[0]:.6g}: {trial[2].status.message}")
            if not trial[2].status.converged:
                return trial
            ratio = trial[1] / best[1]
            stiffness *= float(np.clip(1.0 - ratio, 0.5, 4.0)) if abs(ratio) > SLOW else 1.0
            best = trial
        return best

    def _checked(self, trial: Trial) -> Pressed:
        distance, excess, state = trial
        if not state.status.converged:
            return self._failed(f"at {distance:.4g} along the push: {state.status.message}")
        if abs(excess) > 1e-6 * self.scale:
            message = f"the force is found to {abs(excess) / self.scale:.1e} of it only; take a finer mesh"
            state = replace(state, status=Status(False, message, state.status.iterations))
            return Pressed(self.driver.solution(state), distance)
        self.driver.steps.append(LoadStep(1.0, state))
        return Pressed(self.driver.solution(state), distance)

    def _failed(self, message: str) -> Pressed:
        state = replace(self.low[2], status=Status(False, message, self.low[2].status.iterations))
        return Pressed(self.driver.solution(state), self.low[0])


def _force_on(solution: ContactSolution, part: Part) -> Floats:
    total = np.zeros(2)
    for contact, resultants in zip(solution.system.contacts, solution.resultants, strict=True):
        for side, surface in enumerate((contact.secondary, contact.primary)):
            if surface.part is part:
                total += resultants[side, :2]
    return total
