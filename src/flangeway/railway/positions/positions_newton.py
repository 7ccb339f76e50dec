"""Newton's method for many positions of a wheelset at once.

Unknowns of a slot are the contact forces of both sides and the free components of its position. With the displacements
``u = F B^T p`` of the surfaces (F: flexibility, B: derivatives of the gaps g) the equations are those of
`flangeway.solve.newton` and `flangeway.railway.wheelset.equilibrium`:

    0 <= p,   0 <= g(x(q) + u) + C p,   p . (...) = 0,   W^T p + load = 0,   W = B V,

with the rigid velocities V of the wheels. The tangent is that without the turning of B, ``[A + C, W; W^T, load']`` with
``A = B F B^T`` of an earlier round: what is left out is about a hundredth (pressure over Young's modulus) of it, the
part of the error that a round leaves. The equations themselves are solved in full.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.railway.positions.positions_tangent import Tangent, restricted, tangents
from flangeway.railway.positions.running_pair import ALLOWED_MM, Candidates, Gaps, overlap_depth
from flangeway.railway.positions.surface_positions import (
    Loads,
    SidePose,
    SurfacePositions,
    Targets,
    carried,
    resultants,
)
from flangeway.railway.wheelset.residual import MAX_STEP, TOLERANCE, residual_norm
from flangeway.types import Bools, Floats, Ints

MARGIN_MM = 0.12  # gap below which contact is evaluated; with a displacement still to come, this much more
SURE_MM = 0.02  # gap, as measured at nodes, above which a place that was not looked at is sure not to touch
NEAR_MM = 0.02  # gap below which a constraint has to have its part in the tangent
IN_TANGENT_MM = 0.06  # gap below which a constraint is taken into a tangent
MOVED_MM = 0.06  # displacement after which candidates are searched anew
STALE_MM = 0.2  # lateral displacement after which the tangent is made anew

MOST_ROUNDS = 25
FIRST_ROUNDS = 12  # rounds after which a slot is lost whose error has not come below `LOWERED`
SLOW = 0.2  # part of the error left by a round above which the tangent is made anew
FEWEST_ROUNDS = 3  # rounds that a tangent is kept at least
SWAPS = 8  # rounds for the active set within one of the positions
LOWERED = 1e-2  # error above which the wheelset may still have a long way to go

LOST_MM = 1e-3
"""What a force on a node that faces nothing violates, and the least displacement that violations are measured by."""

RIDGE = np.array([1e-3, 1e-3, 1e3])  # stiffness where no wheel touches: N/mm, N/mm, N mm


@dataclass(frozen=True, eq=False)
class PositionState:
    """A position that a slot has found.

    - `position`: motion of the wheelset, shape (3,).
    - `loads`: of both sides; see `Loads.packed`.
    """

    position: Floats
    loads: tuple[tuple[Ints, Floats], ...]


class PositionSide:
    """One side of all slots: loads, tangents and gaps."""

    def __init__(self, pose: SidePose, n_positions: int) -> None:
        self.pose, self.pair = pose, pose.pair
        empty = np.zeros(0, dtype=np.int64)
        window = np.zeros((n_positions, len(self.pair.hats.nodes)), dtype=np.bool_)
        self.candidates = Candidates(window, empty, empty)
        self.tangents: list[Tangent | None] = [None] * n_positions
        self.in_tangent = window.copy()
        self.loads = Loads.none(self.pair, n_positions)
        self.gaps: Gaps
        self.around: SurfacePositions
        self.carried_load: Loads

    def keep(self, stays: Bools) -> None:
        """Drop slots; what `evaluate` finds has to be found anew."""
        self.tangents = [each for each, stay in zip(self.tangents, stays, strict=True) if stay]
        self.in_tangent, self.loads = self.in_tangent[stays], self.loads.take(stays)
        self.candidates = restricted(self.candidates, self.pair, stays)

    def forget(self, slots: Ints) -> None:
        """Make tangents anew when they are needed."""
        for slot in slots:
            self.tangents[slot] = None
        self.in_tangent[slots] = False

    def evaluate(self, position: Floats, anew: Ints, margins: Floats) -> None:
        """Find gaps and what the contact forces load the bodies with; look anew for candidates of some slots."""
        self.around = SurfacePositions.at(self.pose, position, self.loads)
        if len(anew):
            self._look(anew, margins)
        self.gaps = self.pair.gaps(self.around.wheel, self.around.rail, self.candidates)
        self.carried_load = carried(self.pose, self.gaps, self.around, self.loads.forces)

    def _look(self, slots: Ints, margins: Floats) -> None:
        found = self.around.take(slots).search(self.pair, margins)
        n_second, n_first = len(self.pair.secondary.edges), len(self.pair.primary.edges)
        old = ~np.isin(self.candidates.edges // n_second, slots)
        within = found.edges // n_second
        window = self.candidates.window.copy()
        window[slots] = found.window | (self.loads.forces[slots] > 0.0)
        moved = slots[within] - within
        self.candidates = Candidates(
            window,
            np.concatenate((self.candidates.edges[old], found.edges + moved * n_second)),
            np.concatenate((self.candidates.partners[old], found.partners + moved * n_first)),
        )

    def law(self) -> tuple[Floats, Bools]:
        """Left side of the law, and which constraints there are, shapes (L, n_hats)."""
        allowed = self.gaps.areas > 0.0
        forces = self.loads.forces
        slack = self.gaps.gaps + self.pair.compliance * forces / np.where(allowed, self.gaps.areas, 1.0)
        return slack, allowed

    def violation(self) -> Floats:
        """Maximum imbalance over the total force, or violation of the law over the displacement, shape (L,)."""
        loads, carried_load = self.loads, self.carried_load
        total = np.maximum(loads.forces.sum(axis=1), 1e-300)
        imbalance = np.maximum(
            np.abs(carried_load.wheel - loads.wheel).max(axis=(1, 2)),
            np.abs(carried_load.rail - loads.rail).max(axis=(1, 2)),
        )
        slack, allowed = self.law()
        violation = np.where(loads.forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0))
        violation[~allowed] = np.where(loads.forces > 0.0, LOST_MM, 0.0)[~allowed]
        return np.maximum(imbalance / total, violation.max(axis=1) / np.maximum(self.around.scale, LOST_MM))

    def overlaps(self, slot: int) -> bool:
        """Whether the bodies of a slot overlap by more than its penetration and `ALLOWED_MM`, anywhere."""
        wheel, rail = (
            boundary.positions(running[slot], turn)
            for boundary, running, turn in zip(
                self.pair.boundaries,
                (self.around.wheel, self.around.rail),
                (self.around.turns[slot], np.eye(2)),
                strict=True,
            )
        )
        penetration = 2.0 * float(-self.gaps.gaps[slot].min(initial=0.0))
        return overlap_depth(self.pair.boundaries[0], wheel, self.pair.boundaries[1], rail) > penetration + ALLOWED_MM

    def renewed(self) -> list[Tangent]:
        """Tangents of all slots; those that are missing, or lack a constraint that may become active, are made."""
        slack, allowed = self.law()
        lacks = ((slack < NEAR_MM) & allowed & ~self.in_tangent).any(axis=1)
        missing = lacks | np.array([each is None for each in self.tangents])
        if missing.any():
            chosen = allowed & ((slack < IN_TANGENT_MM) | (self.loads.forces > 0.0))
            made = tangents(self.pose, self.around, self.candidates, self.loads.forces, chosen, missing)
            for slot, tangent in zip(np.flatnonzero(missing), made, strict=True):
                self.tangents[slot] = tangent
                self.in_tangent[slot] = False
                self.in_tangent[slot, tangent.rows] = True
        return [each for each in self.tangents if each is not None]


class PositionBatch:
    """Positions that are solved side by side; a slot that has found its position is given another one.

    - `targets`: what the slots are asked for.
    - `position`: first guess, shape (L, 3).
    """

    def __init__(self, poses: tuple[SidePose, ...], targets: Targets, position: Floats) -> None:
        self.targets, self.position = targets, position.copy()
        self.sides = [PositionSide(pose, len(position)) for pose in poses]
        n_positions = len(position)
        self.looked_at = np.full((n_positions, 3), np.inf)
        self.renewed_at = np.full(n_positions, np.inf)
        self.age, self.tangent_age = np.zeros(n_positions, dtype=np.int64), np.zeros(n_positions, dtype=np.int64)
        self.error = np.full(n_positions, np.inf)

    def state(self, slot: int) -> PositionState:
        """What a slot has found."""
        loads = [side.loads.packed(slot) for side in self.sides]
        return PositionState(self.position[slot].copy(), tuple(loads))

    def take_up(self, slot: int, state: PositionState) -> None:
        """Put a slot at a position that was found."""
        self._move(np.array([slot]), state.position)
        for side, loads in zip(self.sides, state.loads, strict=True):
            side.loads.unpack(slot, loads)

    def keep(self, stays: Bools) -> None:
        """Drop slots."""
        self.targets, self.position, self.error = self.targets.take(stays), self.position[stays], self.error[stays]
        self.looked_at, self.renewed_at = self.looked_at[stays], self.renewed_at[stays]
        self.age, self.tangent_age = self.age[stays], self.tangent_age[stays]
        for side in self.sides:
            side.keep(stays)

    def restart(self, slots: Ints, position: Floats) -> None:
        """Begin anew without any contact."""
        self._move(slots, position)
        self.error[slots] = np.inf
        for side in self.sides:
            for each in (side.loads.forces, side.loads.wheel, side.loads.rail):
                each[slots] = 0.0

    def _move(self, slots: Ints, position: Floats) -> None:
        self.position[slots], self.looked_at[slots], self.renewed_at[slots] = position, np.inf, np.inf
        for side in self.sides:
            side.forget(slots)

    def ask(self, slot: int, targets: Targets, number: int, share: float, origin: int | None) -> None:
        """Ask a slot for a position, or a place on the way; see `Targets.changed`. It goes on from where it is."""
        self.targets = self.targets.changed(slot, targets, number, share, origin)
        self.age[slot], self.error[slot] = 0, np.nan

    def evaluate(self) -> tuple[Bools, Bools]:
        """Evaluate the equations; return which slots are solved and which are lost."""
        self.age += 1
        to_come = np.abs(self.targets.remaining(self.position)) / MAX_STEP * MAX_STEP[0]
        with np.errstate(invalid="ignore"):
            moved = np.abs(self.position - self.looked_at) / MAX_STEP * MAX_STEP[0]
        anew = np.flatnonzero(~(moved.max(axis=1) <= MOVED_MM))
        self.looked_at[anew] = self.position[anew]
        margins = MARGIN_MM + np.where(self.error > LOWERED, MARGIN_MM, 0.0)
        residual = self.targets.loads.on_axle(self.position[:, 2])
        error = to_come.max(axis=1)
        for side in self.sides:
            side.evaluate(self.position, anew, margins[anew])
            residual += np.einsum("lh,lhk->lk", side.loads.forces, resultants(side.pose, side.gaps, side.around))
            error = np.maximum(error, side.violation())
        error = np.maximum(error, residual_norm(self.targets.loads.relative(residual), self.targets.free))
        done = error <= TOLERANCE
        if done.any():
            done &= ~self._is_missed(done)
        self._forget(error)
        self.error = error
        hopeless = (self.age >= MOST_ROUNDS) | ((self.age >= FIRST_ROUNDS) & (error > LOWERED))
        return done, ~np.isfinite(error) | hopeless

    def _forget(self, error: Floats) -> None:
        """Make tangents anew that do not serve any more."""
        slow = (error > SLOW * self.error) & (error > TOLERANCE) & (self.tangent_age >= FEWEST_ROUNDS)
        slow |= error > LOWERED
        with np.errstate(invalid="ignore"):
            slow |= ~(np.abs(self.position[:, 0] - self.renewed_at) <= STALE_MM)
        slots = np.flatnonzero(slow)
        self.renewed_at[slots], self.tangent_age[slots] = self.position[slots, 0], 0
        for side in self.sides:
            side.forget(slots)

    def _is_missed(self, done: Bools) -> Bools:
        """Whether slots may touch where contact was not evaluated; these are searched anew."""
        missed = np.zeros(len(done), dtype=np.bool_)
        slots = np.flatnonzero(done)
        for side in self.sides:
            near = side.around.take(slots).search(side.pair, SURE_MM).window
            missed[slots] |= (near & ~side.candidates.window[slots]).any(axis=1)
        self.looked_at[missed] = np.inf
        return missed

    def step(self) -> None:
        """Solve the linearised equations and move on."""
        self.tangent_age += 1
        windows = [Window.of(side) for side in self.sides]
        change, forces = linear_step(windows, self.targets, self.position)
        self.position = self.targets.snapped(self.position + change)
        for side, window, now in zip(self.sides, windows, forces, strict=True):
            side.loads = window.loads_after(now, change)


@dataclass(frozen=True, eq=False)
class Window:
    """Linearised equations of one side in the slots' windows, filled up to one size m.

    - `pose`, `gaps`, `around`, `tangents`: where the side is.
    - `rows`: hat functions, shape (L, m).
    - `is_real`: which of them are constraints, shape (L, m).
    - `matrix`: tangents' matrices, shape (L, m, m).
    - `forces`, `slack`, `compliance`: current forces, left side of the law with forces not in equilibrium, and
      penetration per force, shape (L, m).
    - `by_position`: derivatives of the gaps by the position, shape (L, m, 3).
    - `to_resultant`: forces and moment on the wheelset by the forces, shape (L, m, 3).
    - `resultant`: those now, shape (L, 3).
    - `stiffness`: their derivatives by the position with forces that stay, shape (L, 3, 3).
    - `imbalance`, `moved`: T P F h and T Q of the tangents, shapes (L, 4) and (L, 4, 3).
    """

    pose: SidePose
    gaps: Gaps
    around: SurfacePositions
    tangents: list[Tangent]
    rows: Ints
    is_real: Bools
    matrix: Floats
    forces: Floats
    slack: Floats
    compliance: Floats
    by_position: Floats
    to_resultant: Floats
    resultant: Floats
    stiffness: Floats
    imbalance: Floats
    moved: Floats

    @classmethod
    def of(cls, side: PositionSide) -> "Window":
        """Gather them."""
        all_tangents, loads = side.renewed(), side.loads
        size = max((len(each.rows) for each in all_tangents), default=0) or 1
        n_positions = len(all_tangents)
        rows = np.zeros((n_positions, size), dtype=np.int64)
        is_real = np.zeros((n_positions, size), dtype=np.bool_)
        matrix = np.zeros((n_positions, size, size))
        by_turning, turned_by = np.zeros((n_positions, size, 4)), np.zeros((n_positions, 4, size))
        moved, out = np.zeros((n_positions, 4, 3)), np.zeros((n_positions, 4))
        gap_shift, on_wheel, on_rail = _imbalance(side)
        for slot, tangent in enumerate(all_tangents):
            n = len(tangent.rows)
            rows[slot, :n], is_real[slot, :n], matrix[slot, :n, :n] = tangent.rows, True, tangent.matrix
            by_turning[slot, :n], turned_by[slot, :, :n] = tangent.by_turning, tangent.turned_by
            moved[slot] = tangent.moved(side.pose, side.around.axles[slot])
            out[slot] = tangent.fitted(on_wheel[slot], on_rail[slot])
        inverse = np.stack([each.inverse for each in all_tangents])
        total = np.stack([each.resultants for each in all_tangents])
        slack, allowed = side.law()
        is_real &= np.take_along_axis(allowed, rows, axis=1)
        areas = np.take_along_axis(side.gaps.areas, rows, axis=1)
        unit = resultants(side.pose, side.gaps, side.around)
        in_window = np.where(is_real[..., None], np.take_along_axis(unit, rows[..., None], axis=1), 0.0)
        shift = np.take_along_axis(slack + gap_shift, rows, axis=1) + np.einsum("lma,la->lm", by_turning, out)
        out = np.einsum("lab,lb->la", inverse, out)
        return cls(
            side.pose, side.gaps, side.around, all_tangents,
            rows,
            is_real,
            matrix,
            np.where(is_real, np.take_along_axis(loads.forces, rows, axis=1), 0.0),
            np.where(is_real, shift, 0.0),
            side.pair.compliance / np.where(is_real, areas, 1.0),
            in_window + by_turning @ moved * is_real[..., None],
            in_window + (turned_by.swapaxes(1, 2) @ total.swapaxes(1, 2)) * is_real[..., None],
            np.einsum("lh,lhk->lk", loads.forces, unit) + np.einsum("lka,la->lk", total, out),
            total @ inverse @ moved,
            out,
            inverse @ moved,
        )  # fmt: skip

    def loads_after(self, forces: Floats, change: Floats) -> Loads:
        """Loads of the bodies with new forces (L, m) and after a change of the position (L, 3)."""
        result = np.zeros_like(self.gaps.gaps)
        slot, place = np.nonzero(self.is_real)
        result[slot, self.rows[slot, place]] = forces[slot, place]
        loads = carried(self.pose, self.gaps, self.around, result)
        turn = self.imbalance + np.einsum("lak,lk->la", self.moved, change)
        step = forces - self.forces
        for number, tangent in enumerate(self.tangents):
            n = len(tangent.rows)
            by = turn[number] + tangent.turned_by @ step[number, :n]
            loads.wheel[number] += np.einsum("a,anx->nx", by, tangent.wheel_turning) @ self.around.turns[number]
            loads.rail[number] += np.einsum("a,anx->nx", by, tangent.rail_turning)
        return loads

    def respond(self, slots: Ints, active: Bools) -> Floats:
        """Solve for the active forces: those of an unmoved wheelset, and their changes by its position, (L, m, 4)."""
        forces = self.forces[slots]
        right = self.slack[slots] - self._times(slots, np.where(active, 0.0, forces))
        size = int(active.sum(axis=1).max(initial=0))
        places = np.argsort(~active, axis=1, kind="stable")[:, :size]  # the active ones first
        mine = np.take_along_axis(active, places, axis=1)
        matrix = self.matrix[slots[:, None, None], places[:, :, None], places[:, None, :]]
        matrix[~(mine[:, :, None] & mine[:, None, :])] = 0.0
        diagonal = np.arange(size)
        compliance = np.take_along_axis(self.compliance[slots], places, axis=1)
        matrix[:, diagonal, diagonal] += np.where(mine, compliance, 1.0)
        columns = np.concatenate((right[..., None], self.by_position[slots]), axis=2)
        columns = np.take_along_axis(columns, places[..., None], axis=1) * mine[..., None]
        answer = np.zeros((*active.shape, 4))
        np.put_along_axis(answer, places[..., None], -np.linalg.solve(matrix, columns), axis=1)
        answer[..., 0] += np.where(active, forces, 0.0)
        return answer

    def slack_after(self, slots: Ints, forces: Floats, position: Floats) -> Floats:
        """Left side of the law after a change of forces (L, m) and position (L, 3)."""
        change = forces - self.forces[slots]
        moved = np.einsum("lmk,lk->lm", self.by_position[slots], position)
        return self.slack[slots] + self._times(slots, change) + self.compliance[slots] * change + moved

    def _times(self, slots: Ints, forces: Floats) -> Floats:
        matrix = self.matrix if len(slots) == len(self.matrix) else self.matrix[slots]
        product: Floats = np.matmul(matrix, forces[..., None])[..., 0]
        return product


def _imbalance(side: PositionSide) -> tuple[Floats, Floats, Floats]:
    """Changes of the gaps (L, n_hats) and displacements (L, n, 2) in the rail's frame by forces not in equilibrium."""
    turns = side.around.turns.swapaxes(1, 2)
    on_wheel = side.pair.wheel.displacements(side.carried_load.wheel - side.loads.wheel) @ turns
    on_rail = side.pair.rail.displacements(side.carried_load.rail - side.loads.rail)
    values = 0.0
    for gradients, nodes, moved in zip(
        (side.gaps.on_wheel, side.gaps.on_rail), side.gaps.nodes, (on_wheel, on_rail), strict=True
    ):
        values = values + np.einsum("prwx,pwx->pr", gradients, moved.reshape(-1, 2)[nodes])
    size = side.gaps.gaps.size
    shift = np.bincount(side.gaps.rows.ravel(), np.ravel(values), minlength=size).astype(np.float64, copy=False)
    return shift.reshape(side.gaps.gaps.shape), on_wheel, on_rail


def linear_step(windows: list[Window], targets: Targets, position: Floats) -> tuple[Floats, list[Floats]]:
    """Change of the position (L, 3) and new forces (L, m) of both sides by the complementarity problem of a round."""
    active = [each.is_real & np.where(each.forces > 0.0, True, each.slack < 0.0) for each in windows]
    forces = [np.zeros_like(each.forces) for each in windows]
    change = np.zeros_like(position)
    slots = np.arange(len(position))
    for _ in range(SWAPS):
        answers = [each.respond(slots, mine[slots]) for each, mine in zip(windows, active, strict=True)]
        change[slots] = _position_change(windows, slots, answers, targets.take(slots), position[slots])
        swapped = np.zeros(len(slots), dtype=np.bool_)
        for number, (each, answer) in enumerate(zip(windows, answers, strict=True)):
            now = answer[..., 0] + np.einsum("lmk,lk->lm", answer[..., 1:], change[slots])
            forces[number][slots] = now
            before = active[number][slots]
            after = each.is_real[slots] & np.where(before, now > 0.0, each.slack_after(slots, now, change[slots]) < 0.0)
            active[number][slots] = after
            swapped |= (after != before).any(axis=1)
        slots = slots[swapped]
        if len(slots) == 0:
            break
    return change, [np.maximum(each, 0.0) for each in forces]


def _position_change(
    windows: list[Window], slots: Ints, answers: list[Floats], targets: Targets, position: Floats
) -> Floats:
    """Change of the position that brings the loads into equilibrium, within the longest step, shape (L, 3)."""
    residual, stiffness = targets.loads.on_axle(position[:, 2]), np.zeros((len(slots), 3, 3))
    stiffness[:, 2, 2] = -targets.loads.moment_by_roll(position[:, 2])
    for each, answer in zip(windows, answers, strict=True):
        change = answer.copy()
        change[..., 0] -= each.forces[slots]
        products = np.einsum("lmk,lmj->lkj", each.to_resultant[slots], change)
        residual += each.resultant[slots] + products[..., 0]
        stiffness -= products[..., 1:] + each.stiffness[slots]
    stiffness += np.diag(RIDGE)
    held = ~targets.free
    coupling = np.where(held[:, None, :], stiffness, 0.0)
    stiffness[held[:, :, None] | held[:, None, :]] = 0.0
    slot, component = np.nonzero(held)
    stiffness[slot, component, component] = 1.0
    # prescribed components move by what remains, and the others with them
    to_come = targets.remaining(position)
    residual -= np.einsum("lij,lj->li", coupling, np.clip(to_come, -MAX_STEP, MAX_STEP))
    step = np.linalg.solve(stiffness * MAX_STEP, np.where(held, to_come, residual)[..., None])[..., 0]
    excess = np.abs(step).max(axis=1, keepdims=True)
    return step / np.maximum(excess, 1.0) * MAX_STEP
