"""Parts pressed together by loads, by prescribed motions, or by a force on one of them."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flangeway.cases.case import Progress
from flangeway.contact import Contact, ContactSolution, ContactSystem, LoadStep, press
from flangeway.contact.press import Load
from flangeway.geometry import Placement
from flangeway.problems import Part
from flangeway.solve import CondensedBodies, ContactState, Handle, Status, StepSettings, follow, solve_contact
from flangeway.solve.body_response import LoadedBodies
from flangeway.types import Floats

SMALLEST_STEP = 1.0 / 1024.0
"""Share of all loads or of a push below which a step is not halved any more."""
MOST_PLACES = 2000
"""Positions at most at which a pushed part is looked for contacts within reach."""


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
        total, found = np.zeros(2), self.contact
        for contact, resultants in zip(found.system.contacts, found.resultants, strict=True):
            for side, surface in enumerate((contact.secondary, contact.primary)):
                if surface.part is part:
                    total += resultants[side, :2]
        return total


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
    return _pushed(driver, push, load, state)


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

    def free_way(self, push: Push, reach: float) -> float:
        """Distance at which contacts of a pushed part come within the pairings' reach; above ``reach`` if none does."""
        own = [push.part in (each.secondary.part, each.primary.part) for each in self.system.contacts]
        primaries = [each.primary for each in itertools.compress(self.system.contacts, own)]
        chords = [np.diff(each.part.body.nodes[each.edges], axis=1) for each in primaries]
        step = max(min(float(np.linalg.norm(each, axis=-1).mean()) for each in chords), reach / MOST_PLACES)
        response, distance = self.loaded(1.0), 0.0
        while distance <= reach:
            x, y = (distance * each for each in push.direction)
            positions = response.reference(self.placements(1.0, push.part, (x, y)))
            pairs = self.system.linearise(positions, None).pairs
            if any(len(each.gaps) for each in itertools.compress(pairs, own)):
                break
            distance += step
        return distance

    def solution(self, state: ContactState) -> ContactSolution:
        reference = self.bodies.reference(tuple(part.placement for part in self.system.parts))
        depths = [float((-pairs.gaps).max(initial=0.0)) for pairs in self.system.linearise(reference, None).pairs]
        found = ContactSolution(self.system, self.loaded(1.0), state, tuple(self.steps), np.array(depths))
        return found.checked()

    def failed(self, state: ContactState, message: str) -> Pressed:
        status = Status(False, message, state.status.iterations)
        return Pressed(self.solution(replace(state, status=status)))


def _pushed(driver: _Driver, push: Push, load: Floats, state: ContactState) -> Pressed:
    """Let a part slide along its push, from the state under all other loads, until contact carries it."""
    direction, parts = np.array(push.direction), driver.system.parts
    wanted = push.force + float(load @ direction)
    body = push.part.body
    stiffness = max(float(m.matrix.diagonal().max()) for m in body.elasticity.materials) * body.thickness
    reach = 2.0 * max(part.body.elasticity.size for part in parts)
    least = float(np.finfo(np.float64).eps) * reach * stiffness
    if wanted <= 0.0:
        return driver.failed(state, "the loads on the pushed part are larger than the force and pull it away")
    if wanted < least:  # that of an approach as small as rounding of the positions
        return driver.failed(
            state,
            f"the contact has to carry {wanted:.1e} N, less than the rounding error of the positions: {least:.1e} N",
        )
    free = driver.free_way(push, reach)
    nothing = (
        f"no contact carries the force within {reach:.4g} mm of motion along the push; check its direction and its size"
    )
    if free > reach:
        return driver.failed(state, nothing)
    response = driver.loaded(1.0)
    placements = driver.placements(1.0, push.part, tuple((free * direction).tolist()))

    def at_share(share: float, start: ContactState | None) -> ContactState:
        load = np.append(share * wanted * direction, 0.0)
        handle = Handle((push.part,), np.zeros(2), direction[None], turns=False, load=load)
        handles = [handle if part is push.part else None for part in parts]
        found = solve_contact(response, driver.system, placements, handles=handles, start=start)
        driver.progress(f"{100.0 * share:.4g} % of the push: {found.status.message}")
        return found

    found = follow(at_share, None, StepSettings(1.0, 1.0, SMALLEST_STEP))
    if not found.status.converged:
        return driver.failed(found, f"under the push: {found.status.message}" if found.forces.any() else nothing)
    driver.steps.append(LoadStep(1.0, found))
    return Pressed(driver.solution(found), free + float(found.motions[0]))
