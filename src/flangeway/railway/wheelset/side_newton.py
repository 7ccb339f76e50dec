"""Contact forces of a wheel on its rail as both bend: semismooth Newton steps.

Within the set C of cells in contact ``f = -(A + D)_CC^-1 (h + B dq)`` with the influence A, the right-hand side h of
the geometry as it is deformed now, and its derivatives B by the position and D by the forces: the rail moves across
the track and rolls, and the patch with it. D has a low rank. The set changes with the signs of forces and gaps.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg

from flangeway.contact.patch.normal_contact import solve_normal
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.railway.wheelset.side_contact import FAR_MM, GriddedSide, SideState, WheelPose
from flangeway.types import Bools, Floats, Ints

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


class SideNewton:
    """One side while its forces are sought."""

    def __init__(
        self,
        grid: GriddedSide,
        pose: WheelPose,
        forces: Floats | float = 0.0,
        creep: Floats | float = 0.0,
        gap_increase: Floats | float = 0.0,
    ) -> None:
        self.grid, self.pose = grid, pose
        n, n_z = len(grid.grid.widths), grid.grid.n_strips
        self.creep: Floats = np.zeros((n, 2)) + creep
        """Creep forces on the wheel's rows of cells, (n, 2), which bend the bodies too."""
        self.gap_increase: Floats = np.zeros((n, n_z)) + gap_increase
        """What they open the gaps besides, (n, n_z)."""
        start: Floats = np.zeros((n, n_z)) + forces
        self.points, self.normals, self.gap, self.values = grid.deformed(pose, start, self.creep[:, 0])
        self.values = self.values + self.gap_increase
        # cells that touch on these bodies: the steps would find them one after the other
        solution = solve_normal(
            grid.influence, self.values, approach=0.0, start=start if start.any() else None, tolerance=START_TOLERANCE
        )
        self.forces = self.raw = solution.forces
        self.total = solution.gaps
        self.touching: Bools = self.forces > 0.0
        self.expected: Floats | None = None
        """With friction, gaps after the step before as far as they are linear, (n, n_z): they decide what touches."""
        self._factor: tuple[Floats, bool] | None = None
        self.changed = True
        rows = N_RESULTANTS + n
        self.slopes = CreepSlopes(np.zeros((rows, len(MOTIONS))), np.zeros((rows, 0)), np.zeros((0, n, n_z)))
        """How creep forces change; without friction they do not."""
        self.shape: Floats = np.zeros(0)
        """Values of the normal forces for `CreepSlopes.shape` at which the creep forces were found, (k,)."""
        self.stiffness: Floats = np.zeros((3, len(MOTIONS)))
        """Derivatives of the resultant of normal forces by `MOTIONS`, at the last `linearised_resultant`."""
        self.creep_is_limited = False

    def linearise(self, pose: WheelPose) -> None:
        """Take gaps and their derivatives at a pose, in the geometry deformed by the forces so far."""
        grid = self.grid
        guess = self.gap.moved(self.pose, pose)
        self.pose = pose
        self.points, self.normals, self.gap, self.values = grid.deformed(pose, self.forces, self.creep[:, 0], guess)
        self.values = self.values + self.gap_increase
        self.total = self.values + grid.influence(self.forces)
        # a cell leaves the set, or comes in, by more than round-off: otherwise some change sides for ever
        least = FORCE_TOLERANCE * float(self.forces.sum()) / max(int(self.touching.sum()), 1)
        width = least * float(grid.coefficients[0].diagonal().max())
        # with friction by the linear step: its normal and creep forces and these gaps belong together; without it the
        # overlaps of the deformed geometry push the wheelset on
        opening = self.total if self.expected is None else self.expected
        touching = np.where(self.touching, self.raw > -least, opening < -width) & (self.gap.gaps < FAR_MM)
        self.changed = bool((touching != self.touching).any())
        if self.changed or self._factor is None:
            self.touching = touching
            self._factor = self._factorised()

    def _factorised(self) -> tuple[Floats, bool] | None:
        rows, strips = np.nonzero(self.touching)
        if len(rows) == 0:
            return None
        if len(rows) > MAX_CELLS:
            raise InputError(
                f"contact patches of {len(rows)} cells on one side",
                f"up to {MAX_CELLS} cells",
                "check the load, and whether these profiles conform over their whole width",
            )
        # A_ab = coefficients[|strip_a - strip_b|, row_a, row_b], by one number each: half the time of three
        n = len(self.touching)
        numbers = np.abs(np.subtract.outer(strips, strips, dtype=np.int32)) * np.int32(n * n)
        numbers += np.add.outer(n * rows, rows, dtype=np.int32)
        matrix = self.grid.coefficients.ravel().take(numbers)
        try:
            factor, lower = scipy.linalg.cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
        except scipy.linalg.LinAlgError as error:
            raise InputError(
                "bodies that move so easily that the contact's own compliance is lost in round-off",
                "supports of about the stiffness of a track",
                "raise the stiffnesses of the rail seats",
            ) from error
        return factor, bool(lower)

    def bend(self, creep: Floats, gap_increase: Floats, forces: Floats, slopes: CreepSlopes) -> None:
        """Take creep forces on rows of cells (n, 2), or a part of the way to them: they move rail and wheel too.

        - `gap_increase`: see `SideCreep`.
        - `forces`: normal forces on the cells in contact under which they were found, (m,).
        - `slopes`: how they change.
        """
        change = creep - self.creep
        moved = np.einsum("ixj,j->ix", self.grid.bending_across, change[:, 0])
        share = min(1.0, MAX_BENT_MM / max(float(np.abs(moved).max()), 1e-300))
        self.creep = self.creep + share * change
        self.creep_is_limited = share < 1.0
        part = np.ones((len(slopes.motion), 1))
        part[N_RESULTANTS:] = share
        self.slopes = slopes._replace(motion=part * slopes.motion, shape=part * slopes.shape)
        self.shape = slopes.weights[:, self.touching] @ forces
        # rail points that move by v are as a wheel that moves by -v
        opened = share * (gap_increase - self.gap_increase)
        self.gap_increase = self.gap_increase + opened
        self.values = self.values + opened - share * np.einsum("izx,ix->iz", self.gap.by_motion[..., :2], moved)

    def solve(self) -> tuple[Floats, Floats]:
        """Forces on the cells in contact, (m,), and derivatives by `MOTIONS`, (m, 7)."""
        if self._factor is None:
            return np.zeros(0), np.zeros((0, len(MOTIONS)))
        rows, strips = np.nonzero(self.touching)
        (slopes, left, of_shape), right = self._changes(rows, strips), self._right
        # h is that of the forces so far: their part in D is taken off
        values = self.values[rows, strips] - left @ (right @ self.forces.sum(axis=1)) - of_shape @ self.shape
        left, right = np.hstack((left, of_shape)), np.vstack((right[:, rows], self.slopes.weights[:, rows, strips]))
        solutions = scipy.linalg.cho_solve(self._factor, np.column_stack((values, slopes, left)), check_finite=False)
        n = 1 + slopes.shape[1]
        solved, inner = solutions[:, :n], solutions[:, n:]
        small = np.eye(len(right)) + right @ inner
        solved = solved - inner @ np.linalg.solve(small, right @ solved)
        return -solved[:, 0], -solved[:, 1:]

    def _changes(self, rows: Ints, strips: Ints) -> tuple[Floats, Floats, Floats]:
        """How gaps of cells (m,) change: by `MOTIONS`, by `_right`, and by `CreepSlopes.shape`."""
        all_by, arms = self.gap.by_motion[rows, strips], self.gap.arms[rows, strips]
        by = all_by[:, :2]
        # a wheel that moves by v changes the gaps by by . v; a rotation moves the hits by (-arm_y, arm_x)
        from_seat = arms[:, :2] - self.pose.seat
        slopes = np.stack(
            (
                by[:, 0],
                by[:, 1],
                by[:, 1] * arms[:, 0] - by[:, 0] * arms[:, 1],
                by @ self.pose.up,
                by[:, 1] * from_seat[:, 0] - by[:, 0] * from_seat[:, 1],
                np.zeros(len(rows)),
                all_by[:, 2] * arms[:, 0] - by[:, 0] * arms[:, 2],
            ),
            axis=1,
        )
        # D = left right: by_motion . n = 1, so that n - by_motion lies across
        grid = self.grid
        (modes, _), (across, loads_across) = grid.bending_modes, grid.bending_modes_across
        by_across = -np.einsum("mx,mxk->mk", by, across[rows])
        left = np.hstack((np.einsum("mx,mxk->mk", grid.undeformed_normals[rows] - by, modes[rows]), by_across))
        by_motion, by_shape = (loads_across @ slopes[N_RESULTANTS:] for slopes in self.slopes[:2])
        return slopes + by_across @ by_motion, left, by_across @ by_shape

    @property
    def _right(self) -> Floats:
        """Loads of the modes by which normal forces of rows bend the bodies, (r, n)."""
        grid, row = self.grid, self.forces.sum(axis=1)
        loads, loads_across = grid.bending_modes[1], grid.bending_modes_across[1]
        # shares s = p T p of the forces along the tangents: ds_i = (T p)_i dp_i + p_i (T dp)_i
        turned, _ = grid.turned(row, self.creep[:, 0])
        return np.vstack((loads, loads_across * turned + (loads_across * row) @ grid.turn_by_rows))

    def resultants(self, forces: Floats) -> Floats:
        """Force on the wheel (x, y) and moment about the axle's middle of forces on cells in contact (m, k): (3, k)."""
        rows, strips = np.nonzero(self.touching)
        normals, arms = self.normals[rows], self.gap.arms[rows, strips]
        moment = arms[:, 0] * normals[:, 1] - arms[:, 1] * normals[:, 0]
        result: Floats = np.column_stack((normals, moment)).T @ forces
        return result

    def yaw_moment(self, forces: Floats, by_motion: Floats) -> tuple[float, Floats]:
        """Moment of normal forces (m,) on the wheel about y, ``z f_x``, and its derivatives by those of the forces."""
        rows, strips = np.nonzero(self.touching)
        arms = self.grid.grid.along[strips] * self.normals[rows, 0]
        return float(arms @ forces), arms @ by_motion

    def linearised_resultant(self, forces: Floats, by_motion: Floats) -> Floats:
        """Resultant of forces of `solve`, (3,); its derivatives are then `stiffness`."""
        resultants = self.resultants(np.column_stack((forces, by_motion)))
        # the moment changes too as the axle's middle moves away from where the forces act
        resultants[2, 1:3] += (-resultants[1, 0], resultants[0, 0])
        self.stiffness = resultants[:, 1:]
        return resultants[:, 0]

    def creep_now(self, forces: Floats, by_motion: Floats, at_bend: Floats) -> tuple[Floats, Floats]:
        """Resultant of creep forces (7,), and its derivatives (7, 7), at forces of `solve` from that at `bend`."""
        weights, by_shape = self.slopes.weights[:, self.touching], self.slopes.shape[:N_RESULTANTS]
        now = at_bend + by_shape @ (weights @ forces - self.shape)
        return now, self.slopes.motion[:N_RESULTANTS] + by_shape @ (weights @ by_motion)

    def take(self, forces: Floats, step: Floats) -> float:
        """Take forces on the cells in contact, or a part of the way to them; how much they change, over their sum.

        - `step`: by what the axle moves, as `MOTIONS`; creep forces change with it.
        """
        new = np.zeros(self.forces.shape)
        self.raw = new.copy()
        self.raw[self.touching] = forces
        new[self.touching] = np.maximum(forces, 0.0)
        change = new - self.forces
        rolls = len(self.shape) > 0
        if rolls:
            self._expect(step)
        moved = np.abs(
            np.einsum("ixk,k->ix", self.grid.bending_modes[0], self.grid.bending_modes[1] @ change.sum(axis=1))
        )
        share = min(1.0, MAX_MOVED_MM / max(float(moved[self.touching.any(axis=1)].max(initial=0.0)), 1e-300))
        self.forces = self.forces + share * change if share < 1.0 else new
        if rolls:
            shape = self.slopes.weights[:, self.touching] @ self.forces[self.touching]
            change_of_rows = self.slopes.shape @ (shape - self.shape) + self.slopes.motion @ step
            self.creep = self.creep + np.outer(change_of_rows[N_RESULTANTS:], (1.0, 0.0))
            self.shape = shape
        total = float(np.abs(new).sum())
        return float(np.abs(change).sum()) / total if total > 0.0 else float(change.any())

    def _expect(self, step: Floats) -> None:
        """Take gaps under the forces of `solve` after a step: none where the cells touch."""
        rows, strips = np.indices(self.forces.shape).reshape(2, -1)
        slopes, left, of_shape = self._changes(rows, strips)
        change = slopes @ step + left @ (self._right @ (self.raw - self.forces).sum(axis=1))
        change = change + of_shape @ (np.tensordot(self.slopes.weights, self.raw, axes=2) - self.shape)
        self.expected = self.values + self.grid.influence(self.raw) + change.reshape(self.forces.shape)

    @property
    def state(self) -> SideState:
        """Contact as it is now."""
        geometry = self.points, self.normals, self.gap, self.total
        return SideState(self.grid, self.pose, self.forces, *geometry, self.stiffness, self.creep)


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
    creep, stations = np.zeros((len(grid.grid.widths), 2)), grid.grid.stations
    nearest = np.abs(state.grid.grid.stations[:, None] - stations).argmin(axis=1)
    np.add.at(creep, nearest, state.creep)
    return creep


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
    newton = SideNewton(grid, pose, start, creep)
    for _ in range(MAX_STEPS):
        newton.linearise(pose)
        forces, by_motion = newton.solve()
        newton.linearised_resultant(forces, by_motion)
        change = newton.take(forces, np.zeros(len(MOTIONS)))
        if change < FORCE_CHANGE and not newton.changed:
            break
    return newton.state
