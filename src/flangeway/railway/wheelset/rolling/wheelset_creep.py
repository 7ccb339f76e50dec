"""Creep forces of a wheelset at a position: creepages of all rows of cells, forces, and how they change.

The slip of the wheel's surface on a rail at rest is ``v + omega x r`` projected on the axes t and z of each row of
cells: v of the axle's middle, the rotation about the wheel's tilted and yawed axis, and the yaw rate with V / R.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid, separate_patches
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import Start, adjoint, roll
from flangeway.contact.rolling.fast_theories import FAST, SimplifiedRolling, Theory, fastsim_rows
from flangeway.contact.rolling.rolling_contact import Creepages, CreepForces, Rolling, RollingContact, box_of
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.track.rolling import RollingMotion
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.rolling.patch_rolling import (
    contact_in,
    forces_on_cells,
    rows_of,
    strips_of,
)
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, WheelPose, tangents_of
from flangeway.railway.wheelset.side_newton import N_RESULTANTS, CreepSlopes, interpolated
from flangeway.types import Bools, Floats

CLOSED_FORMS: tuple[Theory, ...] = ("polach", "linear")
"""Theories with a closed form."""
DIFFERENCE_STEPS = (1e-3, 1e-3, 1e-6, 1e-3, 1e-6, 1e-5, 1e-6)
"""Differences by the axle's x, y and roll, the seat's deflection and tilt, the wheel's rate of rotation over itself,
and the yaw."""
MERGED_FORCE, FIRST_MERGED_FORCE = 0.25, 0.1
"""Maximum force of a cell between two patches that were apart, relative to that of the lesser, at which they are one;
and the same for patches of which nothing is known before."""
MIN_SEPARATION = 1e-6
"""Least singular value, relative to the first one, of places in a patch that has several rows and strips."""
N_SHAPES = 5
TOLERANCE = 1e-9
"""Error of the law of friction in an equilibrium."""
SHAPE_STEP = 1e-3
"""Difference by `CreepSlopes.shape`."""
SLOPE_ERROR = 1e-2
"""Relative residual of the linear equations for derivatives of the exact theory."""
DISTINCT_RESULTANTS = 1e-3
"""Least singular value, relative to the first one, of numbers of a patch's forces whose derivatives are sought."""


class PatchCreep(NamedTuple):
    """Creep forces of one patch.

    - `inside`: its cells on the side, (n, n_z).
    - `contact`, `forces`: cells and creep forces.
    - `points`: of the undeformed wheel on all rows of cells of the side, where it rolls, (n, 2).
    """

    inside: Bools
    contact: RollingContact
    forces: CreepForces
    points: Floats


@dataclass(frozen=True, eq=False)
class SideCreep:
    """Creep forces of one side in its right-hand form.

    - `grid`: cells of the side.
    - `patches`: by falling normal force.
    - `resultant`: force on the wheel (3,), moment about the axle's middle (3,), and that about the wheel's axis; (7,).
    - `rows`: forces on rows of cells along t and z, (n, 2).
    - `gap_increase`: gap change from creep forces beyond that of `GriddedSide.bending_across`, on the cells of the
      patches and about them, (n, n_z).
    """

    grid: GriddedSide
    patches: tuple[PatchCreep, ...]
    resultant: Floats
    rows: Floats
    gap_increase: Floats

    @property
    def interiors(self) -> list[Bools] | None:
        """Cells of the patches that roll by themselves; None by the exact theory."""
        if any(isinstance(patch.forces, Rolling) for patch in self.patches):
            return None
        return [patch.inside for patch in self.patches]

    def patches_on(self, grid: GriddedSide) -> list[Bools]:
        """Cells of the patches on a grid; on another one all those of their rows."""
        return [patch.inside if grid is self.grid else _moved(patch, grid.grid) for patch in self.patches]

    def start(self, contact: RollingContact) -> Rolling | Start | None:
        """Tractions to start from on the cells of a patch; None without any."""
        tractions = np.zeros((*contact.pressures.shape, 2))
        for patch in self.patches:
            if not isinstance(patch.forces, Rolling | SimplifiedRolling):
                return None
            if isinstance(patch.forces, Rolling) and patch.contact.grid is contact.grid:
                return patch.forces
            by_axis = np.moveaxis(patch.forces.tractions, 2, 0)
            tractions += np.moveaxis(interpolated(by_axis, patch.contact.grid.middles, contact.grid.middles), 0, 2)
        return Start(tractions, contact) if self.patches else None


@dataclass(frozen=True, eq=False)
class WheelsetCreep:
    """Creep forces at a rate of rotation about the axle.

    - `problem`: the wheelset, with its motion and friction.
    - `tolerance`: error of the law of friction by the exact theory.
    """

    problem: WheelsetProblem
    rate_rad_s: float
    tolerance: float = TOLERANCE

    @property
    def motion(self) -> RollingMotion:
        """How the wheelset rolls."""
        assert self.problem.rolling is not None
        return self.problem.rolling

    def creepages(
        self, side: Side, pose: WheelPose, rate: float, rows: tuple[Floats, Floats], contact: RollingContact
    ) -> Creepages:
        """Creepages of rows of cells with points and normals, each (n, 2), at a pose of the wheel."""
        points, normals = rows
        sign, speed = SIDE_SIGN[side], self.problem.speed_m_s
        turning = rate * pose.axis
        yawing = np.array([0.0, -sign * self.problem.turning_rad_s, 0.0])
        flat = np.zeros((len(points), 1))
        arms, from_axle = (np.hstack((points - centre, flat)) for centre in (pose.middle, (pose.x, pose.y)))
        slip = np.array([1e-3 * sign * self.motion.lateral_velocity_mm_per_s, 0.0, speed])
        slip = slip + 1e-3 * (np.cross(turning, arms) + np.cross(yawing, from_axle))
        spin = 1e-3 * (normals @ (turning + yawing)[:2]) / speed
        s, z = contact.places
        across = (slip[:, 1] * normals[:, 0] - slip[:, 0] * normals[:, 1]) / speed
        # at the origin of the patch, from which spin counts
        return Creepages(slip[:, 2] / speed - spin * s, across - spin * (contact.grid.along[0] - z[0]), spin, speed)

    def of_side(self, side: Side, state: SideState, normal: Floats, before: SideCreep | None = None) -> SideCreep:
        """Creep forces under normal forces (n, n_z) at the pose of the wheel.

        - `before`: those of a neighbouring position, perhaps on other cells, from which the search starts.
        """
        patches: list[PatchCreep] = []
        for inside in self._divided(state, normal, before):
            contact = self._contact(side, state, normal, inside, before)
            rows = rows_of(state, contact)
            # bodies of one material stretch alike under pressure: the wheel rolls on its undeformed radius
            nearest = int(np.abs(state.grid.grid.along - contact.grid.along[0] + contact.places[1][0]).argmin())
            points = state.gap.arms[:, nearest, :2] + np.array([state.pose.x, state.pose.y])
            motion = self.creepages(side, state.pose, self.rate_rad_s, (points[rows], state.normals[rows]), contact)
            patches.append(PatchCreep(inside, contact, self._forces(contact, motion, before), points))
        return self._side(state, state.pose, tuple(patches))

    def _divided(self, state: SideState, normal: Floats, before: SideCreep | None) -> list[Bools]:
        """Cells that roll as one: a patch, or by the exact theory all of a side.

        Each patch moves the surfaces of the others along the track, and nothing jumps as they meet.
        """
        if self.motion.theory == "exact":
            return [normal > 0.0] if normal.any() else []
        return patches_of(normal, [] if before is None else before.patches_on(state.grid))

    def _forces(self, contact: RollingContact, motion: Creepages, before: SideCreep | None) -> CreepForces:
        if self.motion.theory != "exact":
            return FAST[self.motion.theory](contact, motion.mean(contact.places[0], contact.row_shares))
        start = None if before is None else before.start(contact)
        return roll(contact, motion, start=start, tolerance=self.tolerance)

    def _contact(
        self, side: Side, state: SideState, normal: Floats, inside: Bools, before: SideCreep | None
    ) -> RollingContact:
        friction = self.motion.friction_on(state.normals, self.problem.friction_of(side))
        if self.motion.theory != "exact":
            return contact_in(state, normal, inside, friction, bodies=False)
        box = box_of(inside)[0]
        if before is not None and before.grid is state.grid and before.patches:
            last = before.patches[0].contact
            rows, strips = rows_of(state, last), strips_of(state, last)
            if rows.start <= box.start and box.stop <= rows.stop:
                pressures = np.where(inside, normal, 0.0)[rows, strips] / last.areas
                return last.under(pressures, last, friction.of_rows(rows))
        return contact_in(state, normal, inside, friction, whole=True)

    def _side(self, state: SideState, pose: WheelPose, patches: tuple[PatchCreep, ...]) -> SideCreep:
        """Resultants of the patches' forces at a pose."""
        total, rows = np.zeros(N_RESULTANTS), np.zeros((len(state.grid.grid.widths), 2))
        gap_increase = np.zeros(state.forces.shape)
        for _, contact, forces, points in patches:
            cells, patch_rows = forces_on_cells(forces, contact), rows_of(state, contact)
            s, z = contact.places
            missing = forces.moment - float(s @ cells[..., 1].sum(axis=1) - cells[..., 0].sum(axis=0) @ z)
            spinning = missing * np.append(contact.row_shares @ state.normals[patch_rows], 0.0)
            ahead = cells[..., 0] @ contact.grid.along
            total += _resultant(
                (points[patch_rows], state.normals[patch_rows]), pose, cells.sum(axis=1), ahead, spinning
            )
            rows[patch_rows] += cells.sum(axis=1)
            if isinstance(forces, Rolling):
                total[6] -= 1e3 * forces.rolling_power / self.rate_rad_s
                moved = state.grid.bending_across[patch_rows, :, patch_rows] @ cells[..., 0].sum(axis=1)
                moved = (moved * state.normals[patch_rows]).sum(axis=1)[:, None]
                gap_increase[patch_rows, strips_of(state, contact)] += forces.gap_increase + moved
        return SideCreep(state.grid, patches, total, rows, gap_increase)

    def derivatives(self, side: Side, newton: SideState, normal: Floats, side_creep: SideCreep) -> CreepSlopes:
        """How creep forces under normal forces (n, n_z) change.

        By differences of the theory itself, or of the exact one by its linearised law of friction.
        """
        n = N_RESULTANTS + len(normal)
        columns = np.zeros((n, len(DIFFERENCE_STEPS)))
        changes, weights = [np.zeros((n, 0))], [np.zeros((0, *normal.shape))]
        for patch in side_creep.patches:
            if isinstance(patch.forces, Rolling):
                by_motion, by_normal, weight = self._linearised(side, newton, patch, patch.forces)
                columns += by_motion
                changes.append(by_normal)
                weights.append(weight)
                continue
            grid = newton.grid.grid
            shapes = shapes_of(grid.middles, normal, patch.inside)
            changed = self._changed(side, newton, normal, patch, shapes)
            columns += changed[:, : len(DIFFERENCE_STEPS)]
            changes.append(changed[:, len(DIFFERENCE_STEPS) :])
            weights.append(shapes / normal[patch.inside].sum())
        return CreepSlopes(columns, np.hstack(changes), np.concatenate(weights))

    def _linearised(
        self, side: Side, newton: SideState, patch: PatchCreep, rolling: Rolling
    ) -> tuple[Floats, Floats, Floats]:
        """Derivatives of the exact theory's creep forces of a patch: `CreepSlopes` of it.

        The adjoint problem of each number that is wanted of the forces of the rows has its derivatives by the rigid
        slip and the normal forces of all cells.
        """
        contact, n = rolling.contact, len(newton.grid.grid.widths)
        rows, strips = rows_of(newton, contact), strips_of(newton, contact)
        sizes, places, motions = self._moved(side, newton, patch)
        cells = forces_on_cells(rolling, contact)
        forces, ahead, none = cells.sum(axis=1), cells[..., 0] @ contact.grid.along, np.zeros(3)
        # numbers of the forces along t and z and of the sums of z times the former, for each row
        wanted = resultants_of(*places[0]).reshape(N_RESULTANTS, -1).T
        loads = newton.grid.loads_of_modes
        wanted = np.hstack((wanted, np.pad(loads[:, rows].T, ((0, 2 * len(forces)), (0, 0)))))
        scales = np.linalg.norm(wanted, axis=0)
        left, values, right = np.linalg.svd(wanted / np.where(scales > 0.0, scales, 1.0), full_matrices=False)
        kept = values > DISTINCT_RESULTANTS * values[0]
        right = values[kept, None] * right[kept] * scales
        t, z, turning = left.T[kept].reshape(-1, 3, len(forces), 1).swapaxes(0, 1)
        along = contact.grid.along
        values = np.stack((t + turning * along, z + 0.0 * along), axis=2)
        by_slip, by_normal, by_slope = adjoint(rolling, values, SLOPE_ERROR)
        slips = np.array([moved_motion.rigid(*contact.places) for moved_motion in motions])
        slopes = np.log([EllipticContact.slope_of(contact, moved_motion) for moved_motion in motions])
        by_motion = np.tensordot(by_slip, slips[1:] - slips[0], axes=([1, 2, 3], [1, 2, 3]))
        changes = right.T @ (by_motion + np.outer(by_slope, slopes[1:] - slopes[0]))
        moved = np.array([_resultant(*arguments, forces, ahead, none) for arguments in places])
        changes[:N_RESULTANTS] += (moved[1:] - moved[0]).T
        to_rows = np.linalg.pinv(loads)
        spread = np.vstack((np.eye(N_RESULTANTS, len(right.T)), np.hstack((np.zeros((n, N_RESULTANTS)), to_rows))))
        weights = np.zeros((len(by_normal), *newton.forces.shape))
        weights[:, rows, strips] = by_normal + by_slope[:, None, None] * _slope_by_normal(contact, motions[0])
        return spread @ (changes / sizes), spread @ right.T, weights

    def _moved(
        self, side: Side, newton: SideState, patch: PatchCreep
    ) -> tuple[Floats, list[tuple[tuple[Floats, Floats], WheelPose]], list[Creepages]]:
        """Sizes of `DIFFERENCE_STEPS`; points and normals of a patch's rows with the pose, and creepages.

        Those now come first, then those after each step.
        """
        contact, pose, rate = patch.contact, newton.pose, self.rate_rad_s
        rows = rows_of(newton, contact)
        sizes = np.array(DIFFERENCE_STEPS) * [1.0, 1.0, 1.0, 1.0, 1.0, rate, 1.0]
        places, motions = [], []
        for x, y, roll_rad, up, tilt, turning, yaw in np.vstack((np.zeros(len(sizes)), np.diag(sizes))).tolist():
            moved = replace(
                pose,
                x=pose.x + x,
                y=pose.y + y,
                roll_rad=pose.roll_rad + roll_rad,
                deflection_mm=pose.deflection_mm + up,
                tilt_rad=pose.tilt_rad + tilt,
                yaw_rad=pose.yaw_rad + yaw,
            )
            # where the rays along the rail's normals meet the wheel that has moved
            arms = (patch.points - pose.middle)[rows] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
            way = moved.middle - pose.middle + (moved.whole_roll - pose.whole_roll) * arms
            normals = newton.normals[rows]
            at = patch.points[rows] + (way * normals).sum(axis=1)[:, None] * normals, normals
            places.append((at, moved))
            motions.append(self.creepages(side, moved, rate + turning, at, contact))
        return sizes, places, motions

    def _changed(self, side: Side, newton: SideState, normal: Floats, patch: PatchCreep, shapes: Floats) -> Floats:
        """Derivatives of a patch's resultant and rows' lateral forces by `DIFFERENCE_STEPS` and by shapes, (7 + n, m).

        - `shapes`: (k, n, n_z); normal forces grow by their product with these.
        """
        contact = patch.contact
        rows, strips = rows_of(newton, contact), strips_of(newton, contact)
        sizes, places, motions = self._moved(side, newton, patch)
        places, motions = places + len(shapes) * places[:1], motions + len(shapes) * motions[:1]
        forces = np.where(patch.inside, normal, 0.0)[rows, strips]
        parts = [forces] * (1 + len(DIFFERENCE_STEPS)) + [
            forces * (1.0 + SHAPE_STEP * shape[rows, strips]) for shape in shapes
        ]
        lateral, resultants = np.zeros((len(parts), len(normal))), []
        of_parts = _forces_of_rows(self.motion.theory, contact, motions, parts)
        for number, (of_rows, ahead, missing) in enumerate(of_parts):
            spinning = missing * np.append(contact.row_shares @ newton.normals[rows], 0.0)
            resultants.append(_resultant(*places[number], of_rows, ahead, spinning))
            lateral[number, rows] = of_rows[:, 0]
        values = np.column_stack((resultants, lateral))
        steps = np.append(sizes, np.full(len(shapes), SHAPE_STEP))
        return ((values[1:] - values[0]) / steps[:, None]).T


def _slope_by_normal(contact: RollingContact, motion: Creepages) -> Floats:
    """Derivatives of the logarithm of `Rolling.slope` by the normal forces, (n_cells, n_strips).

    It knows only the products of normal forces with the polynomials of `shapes_of`.
    """
    normal = contact.normal_forces
    if contact.friction.slope.remaining == 1.0:
        return np.zeros(normal.shape)
    shapes = shapes_of(contact.places, normal, normal > 0.0)
    parts = (normal, *(normal * (1.0 + SHAPE_STEP * shape) for shape in shapes))
    ellipses = [
        EllipticContact.under(contact, motion, cell_forces.sum(axis=1), cell_forces.sum(axis=0))
        for cell_forces in parts
    ]
    now, *then = np.log([ellipse.slope_factor for ellipse in ellipses])
    return np.tensordot((np.array(then) - now) / SHAPE_STEP, shapes, axes=1) / normal.sum()


def _forces_of_rows(
    theory: Theory, contact: RollingContact, motions: Sequence[Creepages], parts: Sequence[Floats]
) -> Iterator[tuple[Floats, Floats, float]]:
    """Forces of rows along t and z (n_cells, 2), their sums of z times those along t, and what is missing of moments.

    At creepages and normal forces (n_cells, n_strips), about the origin of the patch; along z from its place.
    """
    s, z = contact.places
    middle = contact.grid.along[0] - z[0]
    origin = contact.grid.bounds[:2].mean() - s[0], middle
    if theory not in CLOSED_FORMS:
        ellipses = [
            EllipticContact.under(contact, motion, part.sum(axis=1), part.sum(axis=0))
            for motion, part in zip(motions, parts, strict=True)
        ]
        for rows, ahead in zip(*fastsim_rows(contact, ellipses, motions[0].speed), strict=True):
            yield rows, ahead + middle * rows[:, 0], 0.0
        return
    for motion, part in zip(motions, parts, strict=True):
        changed = replace(contact, pressures=part / contact.areas, origin=origin)
        forces_of_rows = FAST[theory](changed, motion.mean(changed.places[0], changed.row_shares))
        share = part / part.sum()
        rows, ahead = (
            np.outer(share.sum(axis=1), (forces_of_rows.across, forces_of_rows.along)),
            share @ z * forces_of_rows.across,
        )
        yield rows, ahead + middle * rows[:, 0], forces_of_rows.moment - float(s @ rows[:, 1] - ahead.sum())


def _moved(patch: PatchCreep, grid: PatchGrid) -> Bools:
    """Cells of another grid whose rows are in a patch."""
    rows, bounds = box_of(patch.contact.pressures > 0.0)[0], patch.contact.grid.bounds
    inside = (grid.stations > bounds[rows.start]) & (grid.stations < bounds[rows.stop])
    return np.repeat(inside[:, None], grid.n_strips, axis=1)


def patches_of(normal: Floats, before: Sequence[Bools] = ()) -> list[Bools]:
    """Patches of normal forces (n, n_z), by falling force.

    Creep forces jump where two patches become one. So patches that touch are divided at the row with the least forces,
    as long as these are below `FIRST_MERGED_FORCE` of the lesser maximum of both, or `MERGED_FORCE` if they were apart
    before, (n, n_z) each.
    """
    patches = []
    for region in separate_patches(normal > 0.0):
        most = np.where(region, normal, 0.0).max(axis=1)
        number = np.zeros(len(most), dtype=int)  # of the patch before
        for patch_number, inside in enumerate(before, 1):
            number[(inside & region).any(axis=1)] = patch_number
        rising = np.diff(np.concatenate(([0.0], most, [0.0])))
        peaks = np.flatnonzero((rising[:-1] > 0.0) & (rising[1:] <= 0.0)).tolist()
        cuts: list[int] = []
        while len(peaks) > 1:
            cuts = [first + int(most[first : last + 1].argmin()) for first, last in pairwise(peaks)]
            lesser = [min(most[first], most[last]) for first, last in pairwise(peaks)]
            apart = [
                MERGED_FORCE if number[first] != number[last] else FIRST_MERGED_FORCE for first, last in pairwise(peaks)
            ]
            ratios = most[cuts] / np.multiply(lesser, apart)
            worst = int(ratios.argmax())
            if ratios[worst] < 1.0:
                break
            del peaks[worst + int(most[peaks[worst]] >= most[peaks[worst + 1]])]
        cuts = [0, *(cuts if len(peaks) > 1 else [])]
        rows = np.searchsorted(cuts, np.arange(len(normal)), side="right")[:, None]
        patches += [region & (rows == number) for number in range(1, len(cuts) + 1)]
    return sorted(patches, key=lambda inside: -float(normal[inside].sum()))


def shapes_of(places: tuple[Floats, Floats], normal: Floats, inside: Bools) -> Floats:
    """Polynomials of second order of the places (n,) and (n_z,) in a patch, orthonormal under its forces, (5, n, n_z).

    A theory on an ellipse knows only the products of normal forces with these: force, centre, semi-axes and, where they
    vary across in this way, creepages.
    """
    rows, columns = np.nonzero(inside)
    share = normal[inside] / normal[inside].sum()
    s, z = (
        np.divide(coordinates - share @ coordinates, np.ptp(coordinates) or 1.0)
        for coordinates in (places[0][rows], places[1][columns])
    )
    terms = np.stack((np.ones(len(s)), s, z, s**2, z**2), axis=1)
    _, sizes, turned = np.linalg.svd(np.sqrt(share)[:, None] * terms, full_matrices=False)
    shapes = np.zeros((N_SHAPES, *inside.shape))
    kept = sizes > MIN_SEPARATION * sizes[0]
    shapes[: kept.sum(), rows, columns] = (terms @ turned[kept].T / sizes[kept]).T
    return shapes


def resultants_of(at: tuple[Floats, Floats], pose: WheelPose) -> Floats:
    """`SideCreep.resultant` by forces of rows along t, along z, and their sums of z times the former, (7, 3, n).

    - `at`: points and normals of rows, each (n, 2).
    """
    points, normals = at
    (t_x, t_y), none, one = tangents_of(normals).T, np.zeros(len(points)), np.ones(len(points))
    moments = []
    for middle in ((pose.x, pose.y), pose.middle):
        x, y = (points - middle).T
        # y f_z - z f_y, z f_x - x f_z, x f_y - y f_x
        moments.append(np.array([[none, y, -t_y], [none, -x, t_x], [x * t_y - y * t_x, none, none]]))
    along_axis = np.tensordot(pose.axis, moments[1], axes=1)
    return np.array([[t_x, none, none], [t_y, none, none], [none, one, none], *moments[0], along_axis])


def _resultant(at: tuple[Floats, Floats], pose: WheelPose, rows: Floats, ahead: Floats, spinning: Floats) -> Floats:
    """See `SideCreep.resultant`.

    - `rows`: forces of rows along t and z, (n, 2).
    - `ahead`: their sums of z times the forces along t, (n,).
    - `spinning`: further moment, (3,).
    """
    of_rows = np.tensordot(resultants_of(at, pose), np.array([*rows.T, ahead]), axes=2)
    return np.asarray(of_rows + np.concatenate((np.zeros(3), spinning, [spinning @ pose.axis])))


def rates_of(problem: WheelsetProblem, states: Mapping[Side, SideState]) -> tuple[float, float]:
    """Rate of rotation about the axle without creepage at the mean radius of the contacts.

    With it the difference of both wheels' rates, right less left, at the radii of their own; 0 where they are joined.
    """
    radii = []
    for side in SIDES:
        state = states[side]
        rows = state.forces.sum(axis=1)
        if rows.any():
            radii.append(float(np.average(state.pose.middle[1] - state.points[:, 1], weights=rows)))
    rate = 1e3 * problem.speed_m_s / float(np.mean(radii))
    differ = problem.wheelset.wheels == "independent" and len(radii) == len(SIDES)
    return rate, rate * (radii[0] / radii[1] - 1.0) * differ
