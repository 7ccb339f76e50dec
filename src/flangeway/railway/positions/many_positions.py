"""Thousands of positions of one wheelset: lateral position by load, each in equilibrium.

Some positions are solved side by side (`PositionBatch`), each from a neighbour that was found (`PositionQueue`). What
does not converge there is solved by the full search.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.railway.positions.position_queue import Continuation, PositionQueue
from flangeway.railway.positions.positions_newton import PositionBatch
from flangeway.railway.positions.positions_patches import (
    LoadedPatch,
    PositionPatch,
    maximum_shears,
    patches_of,
    position_patches,
)
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset
from flangeway.railway.positions.surface_positions import Targets
from flangeway.railway.rigid.elastic_start import rigid_start
from flangeway.railway.track.placements import SIDES, WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed
from flangeway.railway.wheelset.residual import AxleLoads
from flangeway.types import Bools, Floats, Ints

AT_ONCE = 32  # positions that are solved side by side

PRESSED_MM = 0.01
"""Depth to which rigid wheels are pressed on the rails at first: small, so that only what carries the load touches."""

MOST_WAITING = 128  # regions of contact that may wait for the stresses below them, which are found together

FEWEST_SUPERPOSED = 200
"""Positions from which on it pays to solve for unit forces: they take as long as some hundred fields."""


@dataclass(frozen=True, eq=False)
class Positions:
    """What each position is asked for.

    An `InputError` if lengths differ, there is no position, or a load is not positive.

    - `lateral_mm`: lateral position of the axle's middle, not-a-number where it is found from equilibrium, shape (n,).
    - `vertical_N`, `lateral_N`: weight and lateral force as in `WheelsetLoad`, shape (n,).
    """

    lateral_mm: Floats
    vertical_N: Floats  # noqa: N815 (the unit newton)
    lateral_N: Floats  # noqa: N815

    def __post_init__(self) -> None:
        names = ("lateral_mm", "vertical_N", "lateral_N")
        given = np.broadcast_arrays(*(np.atleast_1d(as_numbers(name, getattr(self, name))) for name in names))
        if given[0].ndim != 1 or len(given[0]) == 0:
            raise InputError(f"positions of shape {given[0].shape}", "one or more, shape (n,)", "give flat arrays")
        lateral, vertical, force = given
        wrong = ~(np.isfinite(vertical) & (vertical > 0.0) & np.isfinite(force)) | np.isinf(lateral)
        if wrong.any():
            place = int(wrong.argmax())
            raise InputError(
                f"position {place} with lateral_mm={lateral[place]}, vertical_N={vertical[place]}, "
                f"lateral_N={force[place]}",
                "finite numbers, a positive weight; lateral_mm may be nan",
                "correct it",
            )
        for name, value in zip(names, given, strict=True):
            stored = value.copy()
            stored.setflags(write=False)
            object.__setattr__(self, name, stored)

    @classmethod
    def grid(cls, lateral_mm: ArrayLike, vertical_N: ArrayLike, lateral_N: float = 0.0) -> Self:
        """All lateral positions (n,) with all weights (m,), lateral position by lateral position: n m positions."""
        lateral, vertical = (
            each.ravel() for each in np.meshgrid(np.asarray(lateral_mm), np.asarray(vertical_N), indexing="ij")
        )
        return cls(lateral, vertical, np.full(len(lateral), lateral_N))

    def __len__(self) -> int:
        """Return the number of positions."""
        return len(self.lateral_mm)

    def take(self, chosen: ArrayLike) -> "Positions":
        """Some of them."""
        places = np.asarray(chosen)
        return Positions(self.lateral_mm[places], self.vertical_N[places], self.lateral_N[places])


@dataclass(frozen=True, eq=False)
class PositionTable:
    """What was found for each position.

    - `converged`: whether it was found, shape (n,).
    - `by_full_search`: whether the full search was needed, shape (n,).
    - `rounds`: Newton iterations of the fast path, shape (n,).
    - `position`: lateral and vertical position in mm and roll in rad; nan where it was not found, shape (n, 3).
    - `patches`: regions of contact of each position, left side first.
    - `messages`: why positions were not found, by number.
    """

    positions: Positions
    converged: Bools
    by_full_search: Bools
    rounds: Ints
    position: Floats
    patches: tuple[tuple[PositionPatch, ...], ...]
    messages: dict[int, str]

    @property
    def forces_on_wheels_N(self) -> Floats:  # noqa: N802 (the unit newton)
        """Forces on the left and the right wheel, axes of the track, shape (n, 2, 2)."""
        result = np.zeros((len(self.patches), 2, 2))
        for number, patches in enumerate(self.patches):
            for patch in patches:
                result[number, SIDES.index(patch.side)] += patch.force_on_wheel_N
        return result

    @property
    def lateral_over_vertical(self) -> Floats:
        """L/V of left and right wheel, positive where it pushes the rail outwards; nan without contact: (n, 2)."""
        forces = self.forces_on_wheels_N
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(forces[..., 1] > 0.0, forces[..., 0] / forces[..., 1], np.nan)
        return ratio * [1.0, -1.0]


def solve_positions(
    prepared: PreparedWheelset,
    positions: Positions,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
    *,
    shear: bool = False,
    n_alike: int | None = None,
) -> PositionTable:
    """Bring the wheelset into equilibrium in each of many positions.

    Vertical position and roll are found, or as the prepared problem prescribes them; the track's tilt is that of its
    load. Where a lateral position is to be found and there are several equilibria, it is the one that is reached from a
    neighbouring load. An `InputError` if the contact is not segment-to-segment with a penalty or multipliers.

    - `progress`: called with the number of positions that are done and that of all.
    - `shear`: whether the maximum shear stress below each contact is wanted: it needs the fields of all bodies.
    - `n_alike`: number of positions of the same bodies in this call and others together; this call alone if left out.
      From `FEWEST_SUPERPOSED` on the fields for shear stresses are superposed, which changes nothing beyond round-off.
    """
    superposed = (len(positions) if n_alike is None else n_alike) >= FEWEST_SUPERPOSED
    run = _Run(prepared, positions, progress, shear, superposed)
    run.go()
    return run.table()


@dataclass(eq=False)
class _Run:
    """One call of `solve_positions`."""

    prepared: PreparedWheelset
    positions: Positions
    progress: Callable[[int, int], None]
    shear: bool
    superposed: bool
    waiting: list[tuple[int, LoadedPatch]] = field(default_factory=list)
    patches: dict[int, tuple[PositionPatch, ...]] = field(default_factory=dict)
    messages: dict[int, str] = field(default_factory=dict)
    rigid_positions: dict[int, WheelsetPosition] = field(default_factory=dict)
    overlapping: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        n = len(self.positions)
        self.poses = self.prepared.poses
        self.converged, self.by_full_search = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
        self.rounds, self.position = np.zeros(n, dtype=np.int64), np.full((n, 3), np.nan)
        problem = self.prepared.model.problem
        loads = [self._load(number).in_track for number in range(n)]
        along, onto = np.array(loads).T
        given = np.full((n, 3), np.nan)
        for component, value in enumerate(problem.prescribed.components):
            if value is not None and component > 0:
                given[:, component] = value
        given[:, 0] = self.positions.lateral_mm
        self.targets = Targets(AxleLoads.of(problem, along, onto, self.positions.vertical_N), given)
        self.guesses = self._guesses()

    def _load(self, number: int) -> WheelsetLoad:
        tilt = self.prepared.model.problem.load.tilt_rad
        return WheelsetLoad(float(self.positions.vertical_N[number]), float(self.positions.lateral_N[number]), tilt)

    def _prescribed(self, number: int) -> Prescribed:
        lateral = float(self.positions.lateral_mm[number])
        given = self.prepared.model.problem.prescribed
        return Prescribed(None if np.isnan(lateral) else lateral, given.vertical_mm, given.roll_rad)

    def _guesses(self) -> dict[float, WheelsetPosition]:
        """Rigid equilibrium at each lateral position that is asked for and can be reached."""
        wanted = np.unique(self.positions.lateral_mm[~np.isnan(self.positions.lateral_mm)])
        geometry = self.prepared.model.rigid_start.geometry
        try:
            locus = geometry.locus(wanted) if len(wanted) else None
            return {} if locus is None else {float(each): locus.motion(i) for i, each in enumerate(wanted)}
        except InputError:
            return _reachable(self.prepared, wanted)

    def _start(self, number: int) -> WheelsetPosition | None:
        """Rigid position; None and a message if there is none."""
        lateral = float(self.positions.lateral_mm[number])
        if not np.isnan(lateral):
            found = self.guesses.get(lateral)
            if found is None:
                self.messages[number] = f"the wheels are not on both rails at a lateral position of {lateral:g} mm"
            return found
        if number in self.rigid_positions or number in self.messages:
            return self.rigid_positions.get(number)
        try:
            problem = self.prepared.problem_with(self._load(number), self._prescribed(number))
            self.rigid_positions[number] = rigid_start(problem, self.prepared.model.rigid_start.geometry).motion
            return self.rigid_positions[number]
        except InputError as error:
            self.messages[number] = str(error)
            return None

    def go(self) -> None:
        """Solve all."""
        queue = PositionQueue(self.targets, self._possible(), AT_ONCE)
        at = [each for each in (self._next(queue, None) for _ in range(AT_ONCE)) if each is not None]
        if at:
            slots = PositionBatch(
                self.poses, self.targets.take(np.array([each.number for each in at])), self._pressed(at)
            )
            for slot, continuation in enumerate(at):
                slots.ask(slot, self.targets, continuation.number, continuation.shares[0], continuation.origin)
            self._advance(slots, at, queue)
        for number in (*self.overlapping, *np.flatnonzero(queue.open)):
            self._solve_slowly(int(number))
        self._find_shear()

    def _possible(self) -> Bools:
        """Which positions can be begun; a message for the others."""
        possible = np.ones(len(self.positions), dtype=np.bool_)
        for number in np.flatnonzero(~np.isnan(self.positions.lateral_mm)):
            possible[number] = self._start(int(number)) is not None
        return possible

    def _next(self, queue: PositionQueue, at: int | None) -> Continuation | None:
        """What a slot does next; positions that rigid wheels cannot begin are left to their neighbours."""
        while (continuation := queue.next(at)) is not None:
            if continuation.origin is not None or self._start(continuation.number) is not None:
                return continuation
            queue.lost(continuation)
        return None

    def _advance(self, slots: PositionBatch, at: list[Continuation], queue: PositionQueue) -> None:
        """Solve in the batch what can be solved there."""
        while True:
            done, lost = slots.evaluate()
            lost &= ~done
            overlapping = np.zeros(len(at), dtype=np.bool_)
            arrived = np.array([each.arrives for each in at])
            for slot in np.flatnonzero(done & arrived):
                if any(side.overlaps(int(slot)) for side in slots.sides):
                    done[slot], overlapping[slot] = False, True
                    self.overlapping.append(at[slot].number)
            self._collect(slots, np.flatnonzero(done & arrived), at)
            for slot in np.flatnonzero(done & arrived):
                queue.arrived(at[slot].number, slots.state(int(slot)))
            moves: list[int] = []
            ends = np.zeros(len(at), dtype=np.bool_)
            for slot in np.flatnonzero(done | lost | overlapping):
                before = at[slot]
                if lost[slot]:
                    queue.lost(before)
                if done[slot] and not before.arrives:
                    continuation: Continuation | None = before.on()
                else:
                    continuation = self._next(queue, before.number if done[slot] else None)
                if continuation is None:
                    ends[slot] = True
                    continue
                at[slot] = continuation
                slots.ask(int(slot), self.targets, continuation.number, continuation.shares[0], continuation.origin)
                if not continuation.follows:
                    moves.append(int(slot))
            if ends.all():
                break
            slots.step()
            self._move(slots, np.array(moves, dtype=np.int64), at, queue)
            if ends.any():
                at[:] = [each for each, end in zip(at, ends, strict=True) if not end]
                slots.keep(~ends)

    def _move(self, slots: PositionBatch, moves: Ints, at: list[Continuation], queue: PositionQueue) -> None:
        """Put slots at the start of their continuations."""
        cold = np.array([slot for slot in moves if at[slot].origin is None], dtype=np.int64)
        if len(cold):
            slots.restart(cold, self._pressed([at[slot] for slot in cold]))
        for slot in moves:
            origin = at[slot].origin
            if origin is not None:
                slots.take_up(int(slot), queue.states[origin])

    def _pressed(self, continuations: list[Continuation]) -> Floats:
        """Where the searches for positions begin: rigid wheels a little pressed on the rails, shape (n, 3)."""
        positions = [self._start(each.number) for each in continuations]
        rest = np.array([position.components for position in positions if position is not None])
        given = self.targets.prescribed[[each.number for each in continuations]]
        return np.where(np.isnan(given), rest - [0.0, PRESSED_MM, 0.0], given)

    def _collect(self, slots: PositionBatch, found: Ints, at: list[Continuation]) -> None:
        if len(found) == 0:
            return
        sides = [position_patches(side, found) for side in slots.sides]
        for place, slot in enumerate(found):
            number = at[slot].number
            self.patches[number] = tuple(patch for side in sides for patch in side[place])
            if self.shear:
                for side, patches in zip(slots.sides, sides, strict=True):
                    wheel = side.pair.wheel.in_own_order(side.loads.wheel[slot])
                    rail = side.pair.rail.in_own_order(side.loads.rail[slot])
                    self.waiting += [(number, LoadedPatch(patch, wheel, rail)) for patch in patches[place]]
            self.position[number], self.converged[number] = slots.position[slot], True
            self.rounds[number] = slots.age[slot]
        self.progress(int(self.converged.sum()), len(self.positions))
        if len(self.waiting) > MOST_WAITING:
            self._find_shear()

    def _find_shear(self) -> None:
        """Give the patches that wait for it their maximum shear stress."""
        waiting, self.waiting = self.waiting, []
        found = maximum_shears(self.prepared, [each for _, each in waiting], superposed=self.superposed)
        patches: dict[int, list[PositionPatch]] = {}
        for (number, each), shear in zip(waiting, found, strict=True):
            patches.setdefault(number, []).append(replace(each.patch, shear=shear))
        self.patches.update({number: tuple(mine) for number, mine in patches.items()})

    def _solve_slowly(self, number: int) -> None:
        start = self._start(number)
        if start is None:
            return
        found = self.prepared.solve(self._load(number), self._prescribed(number), start)
        self.by_full_search[number] = True
        self.converged[number] = found.status.converged
        if not found.status.converged:
            self.messages[number] = found.status.message
            return
        self.position[number] = found.position.components
        self.patches[number] = patches_of(self.prepared, found)
        if self.shear:
            response, state = self.prepared.response, found.state
            local = np.einsum("nji,nj->ni", response.rotations(state.placements), state.nodal_forces)
            names = [part.name for part in self.prepared.model.system.parts]
            of_part = dict(zip(names, np.split(local, response.offsets[1:-1]), strict=True))
            self.waiting += [
                (number, LoadedPatch(patch, of_part[f"wheel-{patch.side}"], of_part[f"rail-{patch.side}"]))
                for patch in self.patches[number]
            ]

    def table(self) -> PositionTable:
        """Return what was found."""
        for values in (self.converged, self.by_full_search, self.rounds, self.position):
            values.setflags(write=False)
        return PositionTable(
            self.positions,
            self.converged,
            self.by_full_search,
            self.rounds,
            self.position,
            tuple(self.patches.get(number, ()) for number in range(len(self.positions))),
            {number: text for number, text in self.messages.items() if not self.converged[number]},
        )


def _reachable(prepared: PreparedWheelset, wanted: Floats) -> dict[float, WheelsetPosition]:
    """Rigid positions at those lateral positions that can be reached."""
    found = {}
    for lateral in wanted:
        try:
            found[float(lateral)] = prepared.model.rigid_start.geometry.locus([lateral]).motion(0)
        except InputError:
            continue
    return found
