"""Contact forces of a wheel on its rail as both bend: semismooth Newton steps.

Within the set C of cells in contact ``f = -(A + K E)_CC^-1 (h - K p + G dq)`` with the influence A, the right-hand side
h of the geometry as it is deformed now, its derivatives G by the position and K by the forces ``p = E f`` of rows: the
rail moves across the track and rolls, and the patch with it. The set changes with the signs of forces and gaps.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg

from flangeway.contact.patch.normal_contact import solve_normal
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.geometry.arrays import cross_product, sums_at
from flangeway.railway.wheelset.side_contact import ALL, FAR_MM, GriddedSide, SideState, WheelPose, tangents_of
from flangeway.types import Bools, Floats

MAX_CELLS = 6000
"""Cells in contact up to which their matrix is factorised."""
FORCE_TOLERANCE = 1e-6
"""Force relative to the mean force of the cells in contact that is round-off."""
START_TOLERANCE = 1e-4
"""Tolerance of the forces on bodies that bend no further, from which the steps start."""
MAX_STEPS, FORCE_CHANGE = 30, 1e-9
"""Steps at one pose, and change of the forces in one, relative to their sum, at which they are found."""
MAX_MOVED_MM, MAX_BENT_MM = 0.5, 0.4
"""Displacement of a cell across the normal by normal forces, and by creep forces, by which the geometry changes in one
step, at most."""
N_RESULTANTS = 7
MOTIONS = ("x", "y", "roll", "deflection", "tilt", "rate", "yaw")
"""By what derivatives are: the axle's position and roll, the seat's deflection and tilt, the wheel's rate of rotation
and the yaw."""


class CreepSlopes(NamedTuple):
    """How creep forces of a side change: `motion` and `shape` with the resultant (7) and lateral forces of rows (n).

    - `motion`: by `MOTIONS` where normal forces stay, (7 + n, 7).
    - `shape`: by products of the normal forces with functions on the patches, (7 + n, k).
    - `weights`: these functions, (k, n, n_z).
    """

    motion: Floats
    shape: Floats
    weights: Floats

    def on_cells(self, old: PatchGrid, new: PatchGrid) -> "CreepSlopes":
        """The same for the cells of another grid, as far as they are smooth."""
        rows = scipy.linalg.block_diag(np.eye(N_RESULTANTS), _fractions(old.bounds, new.bounds))
        return CreepSlopes(rows @ self.motion, rows @ self.shape, interpolated(self.weights, old.middles, new.middles))


class SideTangent(NamedTuple):
    """Derivatives of the geometry of a side.

    - `moves`, `turns`: see `GriddedSide.derivatives`.
    - `now`: resultant of normal forces, (3,).
    - `resultant`: its derivatives by normal forces and, with friction, lateral ones of rows (p, a), (3, 2 n).
    - `rail`: rigid motion of the rail under the patches about the middle of the axle by (p, a), (3, 2 n).
    """

    moves: Floats
    turns: Floats
    now: Floats
    resultant: Floats
    rail: Floats


@dataclass(frozen=True, eq=False)
class SideNewton(SideState):
    """One side while its forces are sought, a value: its contact in the geometry of the last linearisation.

    - `gap_increase`: what creep forces open the gaps besides moving the cells across, (n, n_z).
    - `values`: gaps without the influence of forces, (n, n_z).
    - `touching`: cells in contact, (n, n_z); `changed`: whether others than before.
    - `raw`: forces of the last step without a bound, (n, n_z).
    - `slopes`: how creep forces change; without friction they do not.
    - `tangent`: derivatives of the geometry.
    - `creep_resultant`: of the creep forces, see `SideCreep`, (7,).
    - `shape`: values of the normal forces for `CreepSlopes.shape` at which the creep forces were found, (k,).
    - `expected`: with friction, gaps after the step before as far as they are linear: they decide what touches.
    - `factor`: Cholesky factor of the influence coefficients of the cells in contact, and whether it is a lower one.
    - `creep_is_limited`: whether creep forces bend the bodies in part only.
    """

    gap_increase: Floats
    values: Floats
    touching: Bools
    raw: Floats
    slopes: CreepSlopes
    tangent: SideTangent
    creep_resultant: Floats
    shape: Floats
    expected: Floats | None = None
    factor: tuple[Floats, bool] | None = None
    changed: bool = True
    creep_is_limited: bool = False

    @classmethod
    def of(
        cls,
        grid: GriddedSide,
        pose: WheelPose,
        forces: Floats | float = 0.0,
        creep: Floats | float = 0.0,
        gap_increase: Floats | float = 0.0,
        *,
        rolls: bool = False,
    ) -> "SideNewton":
        """A side at a pose, with forces on bodies that bend no further.

        - `forces`, `creep`, `gap_increase`: to start from; creep forces on the wheel's rows of cells, (n, 2).
        """
        n, cells = len(grid.grid.widths), np.zeros((len(grid.grid.widths), grid.grid.n_strips))
        start, creep_of_rows, opened = cells + forces, np.zeros((n, 2)) + creep, cells + gap_increase
        points, normals, gap, values = grid.deformed(pose, start, creep_of_rows[:, 0])
        # cells that touch on these bodies: the steps would find them one after the other
        solution = solve_normal(
            grid.influence,
            values + opened,
            approach=0.0,
            start=start if start.any() else None,
            tolerance=START_TOLERANCE,
        )
        state = SideState(grid, pose, solution.forces, points, normals, gap, solution.gaps, creep_of_rows)
        rows = N_RESULTANTS + n * rolls
        slopes = CreepSlopes(np.zeros((rows, len(MOTIONS))), np.zeros((rows, 0)), np.zeros((0, *cells.shape)))
        return cls(
            **vars(state),
            gap_increase=opened,
            values=values + opened,
            touching=solution.forces > 0.0,
            raw=solution.forces,
            slopes=slopes,
            tangent=tangent_of(state, rows - N_RESULTANTS),
            creep_resultant=np.zeros(N_RESULTANTS),
            shape=np.zeros(0),
        )

    def linearised(self, pose: WheelPose) -> "SideNewton":
        """Gaps and their derivatives at a pose, in the geometry deformed by the forces so far."""
        grid, gap = self.grid, self.gap.moved(self.pose, pose)
        points, normals, gap_now, values = grid.deformed(pose, self.forces, self.creep[:, 0], gap)
        values = values + self.gap_increase
        gaps = values + grid.influence(self.forces)
        state = SideState(grid, pose, self.forces, points, normals, gap_now, gaps, self.creep)
        # a cell leaves the set, or comes in, by more than round-off: otherwise some change sides for ever
        least = FORCE_TOLERANCE * float(self.forces.sum()) / max(int(self.touching.sum()), 1)
        width = least * float(grid.coefficients[0].diagonal().max())
        # with friction by the linear step: its normal and creep forces and these gaps belong together; without it the
        # overlaps of the deformed geometry push the wheelset on
        opening = gaps if self.expected is None else self.expected
        touching = np.where(self.touching, self.raw > -least, opening < -width) & (gap_now.gaps < FAR_MM)
        changed = bool((touching != self.touching).any())
        factor = factorised(grid, touching) if changed or self.factor is None else self.factor
        return replace(
            self,
            **vars(state),
            values=values,
            touching=touching,
            changed=changed,
            factor=factor,
            tangent=tangent_of(state, len(self.slopes.motion) - N_RESULTANTS),
        )

    def bent(
        self, resultant: Floats, creep: Floats, gap_increase: Floats, forces: Floats, slopes: CreepSlopes
    ) -> "SideNewton":
        """The same with creep forces on rows of cells (n, 2), or a part of the way to them: they move the bodies too.

        - `resultant`, `gap_increase`: see `SideCreep`.
        - `forces`: normal forces on the cells in contact under which they were found, (m,).
        - `slopes`: how they change.
        """
        change = creep - self.creep
        moved = np.einsum("ixj,j->ix", self.grid.bending_across, change[:, 0])
        share = min(1.0, MAX_BENT_MM / max(float(np.abs(moved).max()), 1e-300))
        part = np.ones((len(slopes.motion), 1))
        part[N_RESULTANTS:] = share
        # rail points that move by v are as a wheel that moves by -v
        opened = share * (gap_increase - self.gap_increase)
        return replace(
            self,
            creep=self.creep + share * change,
            creep_is_limited=share < 1.0,
            creep_resultant=resultant,
            slopes=slopes._replace(motion=part * slopes.motion, shape=part * slopes.shape),
            shape=slopes.weights[:, self.touching] @ forces,
            gap_increase=self.gap_increase + opened,
            values=self.values + opened - share * np.einsum("izx,ix->iz", self.gap.by_motion[..., :2], moved),
        )

    def _opened(self, rows: slice, strips: slice, motion: Floats, forces: Floats) -> Floats:
        """How gaps of cells change, (m, m_z, k), by k motions along `MOTIONS`, (7, k), and forces of rows (p, a)."""
        n, (moves, turns, *_) = len(self.points), self.tangent
        by, gaps, arms = (values[rows, strips] for values in (self.gap.by_motion, self.gap.gaps, self.gap.arms))
        # dg = -b . dP - g (b . t) dphi where the rail moves by dP and its normals turn by dphi
        along = np.einsum("izx,ix->iz", by[..., :2], tangents_of(self.normals[rows]))
        opened = -by[..., :2] @ (moves[rows] @ forces) - (gaps * along)[..., None] * (turns[rows] @ forces)[:, None]
        # dg = b . (v + w x a) where the wheel moves by v and turns by w, a from the origin of its profile
        middle, axes = self.pose.motions
        moving = np.delete(motion, MOTIONS.index("rate"), axis=0)
        arms = arms - np.append(self.pose.shift, 0.0)
        opened += by @ (middle @ moving) + np.cross(arms, by) @ (axes @ moving)
        along_normals = self.grid.moved_along_normals[rows] @ forces[:n]
        means: Floats = self.grid.means(opened, gaps, rows) + along_normals[:, None]
        return means

    @cached_property
    def _creep_changes(self) -> tuple[Floats, Floats, Floats]:
        """How resultant and lateral forces of rows, ``(C, a)``, change: by `MOTIONS`, p and `CreepSlopes.shape`.

        The rail moves by ``rho = P dp + A da``, and creep forces turn with it by its roll: ``dC = C_q (dq - rho) +
        C_s ds + rho_roll z x C``, ``da = a_q (dq - rho) + a_s ds``.
        """
        n, rows = len(self.points), slice(N_RESULTANTS, None)
        by_rail = -self.slopes.motion[:, :3]
        # z x F and z x M; the torque about the wheel's axis stays
        f_x, f_y, _, m_x, m_y = self.creep_resultant[:5]
        by_rail[:5, 2] += -f_y, f_x, 0.0, -m_y, m_x
        rail, rail_across = self.tangent.rail[:, :n], self.tangent.rail[:, n:]
        changes = np.hstack((self.slopes.motion, by_rail @ rail, self.slopes.shape))
        # da = (1 - a_rho A)^-1 (...)
        by_across = by_rail[rows] @ rail_across
        changes[rows] = np.linalg.solve(np.eye(len(by_across)) - by_across, changes[rows])
        changes[:N_RESULTANTS] += by_rail[:N_RESULTANTS] @ rail_across @ changes[rows]
        by_motion, by_row, by_shape = np.split(changes, (len(MOTIONS), len(MOTIONS) + n), axis=1)
        return by_motion, by_row, by_shape

    @cached_property
    def solved(self) -> tuple[Floats, Floats]:
        """Forces on the cells in contact, (m,), and derivatives by `MOTIONS`, (m, 7)."""
        if self.factor is None:
            return np.zeros(0), np.zeros((0, len(MOTIONS)))
        rows, strips = np.nonzero(self.touching)
        loaded = np.flatnonzero(self.touching.any(axis=1) | self.forces.any(axis=1))
        row = np.equal.outer(np.arange(len(self.points)), loaded).astype(np.float64)
        of_motion, of_row, of_shape = (changes[N_RESULTANTS:] for changes in self._creep_changes)
        n, n_rows, n_shapes = len(MOTIONS), len(loaded), of_shape.shape[1]
        motion = np.eye(n, n + n_rows + n_shapes)
        normal = np.pad(row, ((0, 0), (n, n_shapes)))
        forces = np.vstack((normal, np.hstack((of_motion, of_row[:, loaded], of_shape))))
        # means over cells take those beside them
        box = slice(max(rows[0] - 1, 0), rows[-1] + 2), slice(strips.min(), strips.max() + 1)
        opened = self._opened(*box, motion, forces)[rows - box[0].start, strips - box[1].start]
        by_motion, left = opened[:, :n], opened[:, n:]
        right = np.vstack((row.T[:, rows], self.slopes.weights[:, rows, strips]))
        # h is that of the forces so far: their part in K is taken off
        values = self.values[rows, strips] - left @ np.append(self.forces.sum(axis=1)[loaded], self.shape)
        solutions = scipy.linalg.cho_solve(self.factor, np.column_stack((values, by_motion, left)), check_finite=False)
        solved, inner = solutions[:, : n + 1], solutions[:, n + 1 :]
        small = np.eye(len(right)) + right @ inner
        solved = solved - inner @ np.linalg.solve(small, right @ solved)
        return -solved[:, 0], -solved[:, 1:]

    @property
    def yaw_moment(self) -> Floats:
        """Moment of the normal forces of `solved` on the wheel about y, ``z f_x``, and its derivatives, (8,)."""
        rows, strips = np.nonzero(self.touching)
        arms = self.grid.grid.along[strips] * self.normals[rows, 0]
        return np.asarray(arms @ np.column_stack(self.solved))

    @cached_property
    def resultants(self) -> tuple[Floats, Floats]:
        """Resultants of normal and creep forces at the forces of `solved`, as far as they are linear.

        Their values and derivatives by `MOTIONS`, (3, 8) and (7, 8).
        """
        n, by_forces = len(self.points), self.tangent.resultant
        weights, rows = self.slopes.weights[:, self.touching], np.nonzero(self.touching)[0]
        motion, row, shape = self._creep_changes
        values = np.column_stack(self.solved)
        changes = sums_at(rows, values, n)
        changes[:, 0] -= self.forces.sum(axis=1)
        shapes = weights @ values
        shapes[:, 0] -= self.shape
        of_creep = row @ changes + shape @ shapes
        of_creep[:, 1:] += motion
        normal = by_forces[:, :n] @ changes + by_forces[:, n:] @ of_creep[N_RESULTANTS:]
        normal[:, 0] += self.tangent.now
        # the moment changes too as the axle's middle moves away from where the forces act
        normal[2, 1:3] += (-normal[1, 0], normal[0, 0])
        creep: Floats = of_creep[:N_RESULTANTS]
        creep[:, 0] += self.creep_resultant
        return normal, creep

    def taken(self, step: Floats) -> tuple["SideNewton", float]:
        """The side with the forces of `solved` after a step, or a part of the way to them.

        - `step`: by what the axle moves, as `MOTIONS`; creep forces change with it.

        Returned too: how much forces change, over their sum.
        """
        forces, by_motion = self.solved
        raw: Floats = np.zeros(self.forces.shape)
        raw[self.touching] = forces + by_motion @ step
        new = np.maximum(raw, 0.0)
        change = new - self.forces
        moved = np.abs(self.grid.bending @ change.sum(axis=1))
        share = min(1.0, MAX_MOVED_MM / max(float(moved[self.touching.any(axis=1)].max(initial=0.0)), 1e-300))
        taken = replace(self, raw=raw, forces=self.forces + share * change if share < 1.0 else new)
        if len(self.shape):
            # gaps under `raw`: none where the cells touch
            across, _ = self._across(raw, step)
            normal = (raw - self.forces).sum(axis=1)
            opened = self._opened(ALL, ALL, step[:, None], np.append(normal, across)[:, None])[..., 0]
            across, shape = self._across(taken.forces, step)
            creep = self.creep + np.outer(across, (1.0, 0.0))
            expected = self.values + self.grid.influence(raw) + opened
            taken = replace(taken, creep=creep, shape=shape, expected=expected)
        total = float(np.abs(new).sum())
        return taken, float(np.abs(change).sum()) / total if total > 0.0 else float(change.any())

    def _across(self, forces: Floats, step: Floats) -> tuple[Floats, Floats]:
        """How lateral forces of rows change to normal forces (n, n_z) and by a step, and `shape` there."""
        motion, row, by_shape = (changes[N_RESULTANTS:] for changes in self._creep_changes)
        shape = self.slopes.weights[:, self.touching] @ forces[self.touching]
        return motion @ step + row @ (forces - self.forces).sum(axis=1) + by_shape @ (shape - self.shape), shape

    @property
    def state(self) -> SideState:
        """Contact as it is now."""
        geometry = self.points, self.normals, self.gap, self.gaps
        return SideState(self.grid, self.pose, self.forces, *geometry, self.creep)


def factorised(grid: GriddedSide, touching: Bools) -> tuple[Floats, bool] | None:
    """Cholesky factor of the influence coefficients of cells (n, n_z), and whether it is a lower one; None of none."""
    rows, strips = np.nonzero(touching)
    if len(rows) == 0:
        return None
    if len(rows) > MAX_CELLS:
        raise InputError(
            f"contact patches of {len(rows)} cells on one side",
            f"up to {MAX_CELLS} cells",
            "check the load, and whether these profiles conform over their whole width",
        )
    # A_ab = coefficients[|strip_a - strip_b|, row_a, row_b], by one number each: half the time of three
    n = len(touching)
    numbers = np.abs(np.subtract.outer(strips, strips, dtype=np.int32)) * np.int32(n * n)
    numbers += np.add.outer(n * rows, rows, dtype=np.int32)
    matrix = grid.coefficients.ravel().take(numbers)
    try:
        factor, lower = scipy.linalg.cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    except scipy.linalg.LinAlgError as error:
        raise InputError(
            "bodies that move so easily that the contact's own compliance is lost in round-off",
            "supports of about the stiffness of a track",
            "raise the stiffnesses of the rail seats",
        ) from error
    return factor, bool(lower)


def tangent_of(state: SideState, n_across: int) -> SideTangent:
    """Derivatives of the geometry as it is deformed.

    - `n_across`: see `GriddedSide.derivatives`.
    """
    n, row, tangents = len(state.points), state.forces.sum(axis=1), tangents_of(state.normals)
    moves, turns = state.grid.derivatives(row, state.creep[:, 0], n_across)
    # R = (sum p n, sum p (P - c) x n): dR = p t dphi, and p dP x n + p (P - c) x t dphi
    arm, forces = state.points - (state.pose.x, state.pose.y), row[:, None] * state.normals
    resultant = (row[:, None] * np.column_stack((tangents, cross_product(arm, tangents)))).T @ turns
    resultant[2] += moves[:, 0].T @ forces[:, 1] - moves[:, 1].T @ forces[:, 0]
    by_row = np.column_stack((state.normals, cross_product(arm, state.normals))).T
    resultant[:, :n] += by_row
    # a rail that moves by rho, about the middle of the axle, is as a wheel that moves by -rho
    share = row / max(row.sum(), 1e-300)
    rail = np.vstack((np.tensordot(share, moves, axes=1), share @ turns))
    x, y = share @ arm
    rail[:2] += np.outer((y, -x), rail[2])
    return SideTangent(moves, turns, by_row @ row, resultant, rail)


def interpolated(values: Floats, old: tuple[Floats, Floats], new: tuple[Floats, Floats]) -> Floats:
    """Values (..., n, n_z) at other stations (m,) and z (m_z,): linear, and constant beyond the outermost ones."""

    def weights(at: Floats, known: Floats) -> Floats:
        return np.array([np.interp(at, known, unit) for unit in np.eye(len(known))])

    return np.asarray(weights(new[0], old[0]).T @ values @ weights(new[1], old[1]))


def transferred(state: SideState, grid: GriddedSide) -> Floats:
    """Forces of a contact on the cells of another grid, each spread evenly over its cell; the sum stays."""
    old, new = state.grid.grid, grid.grid
    # f_kl = sum_ij R_ki f_ij S_lj with the fractions R and S of the old cells and strips that lie in the new ones
    forces: Floats = (
        _fractions(old.bounds, new.bounds) @ state.forces @ _fractions(old.strip_bounds, new.strip_bounds).T
    )
    total = float(forces.sum())
    return forces * (float(state.forces.sum()) / total) if total > 0.0 else forces


def _fractions(old: Floats, new: Floats) -> Floats:
    """Fractions of the intervals between old bounds, (m + 1,), that lie in those between new ones, (n + 1,): (n, m)."""
    common = np.minimum(new[1:, None], old[1:]) - np.maximum(new[:-1, None], old[:-1])
    return np.maximum(common, 0.0) / np.diff(old)


def transferred_creep(state: SideState, grid: GriddedSide) -> Floats:
    """Creep forces of rows on the nearest rows of another grid."""
    stations = grid.grid.stations
    nearest = np.abs(state.grid.grid.stations[:, None] - stations).argmin(axis=1)
    return sums_at(nearest, state.creep, len(stations))


def solve_side(
    grid: GriddedSide,
    pose: WheelPose,
    start: Floats | float = 0.0,
    *,
    creep: Floats | float = 0.0,
) -> SideState:
    """Contact at a pose of the wheel.

    - `start`: forces to start from.
    - `creep`: creep forces on rows of cells, (n, 2), that stay.
    """
    newton = SideNewton.of(grid, pose, start, creep)
    for _ in range(MAX_STEPS):
        newton, change = newton.linearised(pose).taken(np.zeros(len(MOTIONS)))
        if change < FORCE_CHANGE and not newton.changed:
            break
    return newton.state


def stiffness_of(state: SideState) -> Floats:
    """Derivatives of `SideState.resultant` by `MOTIONS` at a contact in equilibrium without friction, (3, 7)."""
    newton = SideNewton.of(state.grid, state.pose, state.forces, state.creep)
    return newton.linearised(state.pose).resultants[0][:, 1:]
