"""Contact of one wheel and its rail in three dimensions, on a grid that lies anywhere on the running surfaces.

All is in the right-hand form of a side: x to the field side, y up, z ahead, origin in the middle of the track.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from flangeway.contact.patch.normal_contact import Convolution, ElasticSurface
from flangeway.contact.patch.patch_contact import CellForces
from flangeway.contact.patch.patch_grid import PatchGrid, at_edge
from flangeway.exact import contact_modulus
from flangeway.geometry import Placement
from flangeway.geometry.arrays import turned_right
from flangeway.materials import Elastic
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM
from flangeway.railway.rigid.rigid_side import RigidCurve
from flangeway.solve.surface_compliance import half_spaces_on
from flangeway.types import Bools, Floats, Ints

MAX_STEPS = 12
MAX_STEP_MM = 3.0
MET_MM = 1e-11
"""Distance from the wheel's surface at which a ray has met it."""
FAR_MM = 1e3
"""Gap of what does not meet."""
ALL = slice(None)


class WheelGap(NamedTuple):
    """Gaps and where they end, arrays (n, n_z) or (n, n_z, 3).

    - `gaps`: distances along the normals, `FAR_MM` where a ray does not meet the wheel.
    - `along`: position of the hit along the axle from its middle.
    - `by_motion`: derivative of the gap by a translation of the wheel: its outward normal over the share of that along
      the ray.
    - `arms`: from the wheel's origin on its axis to the hit.
    """

    gaps: Floats
    along: Floats
    by_motion: Floats
    arms: Floats

    def moved(self, old: "WheelPose", new: "WheelPose") -> Floats:
        """Gaps as the wheel moves a little in its plane from one pose to another, (n, n_z)."""
        turn = new.whole_roll - old.whole_roll
        x, y = new.middle - old.middle
        arms = self.arms - np.append(old.shift, 0.0)
        way = self.by_motion[..., 0] * (x - turn * arms[..., 1]) + self.by_motion[..., 1] * (y + turn * arms[..., 0])
        return np.where(self.gaps < FAR_MM, self.gaps + way, FAR_MM)


def wheel_gap(
    wheel: RigidCurve,
    middle: Floats,
    axis: Floats,
    points: Floats,
    normals: Floats,
    z: Floats,
    guess: Floats | None = None,
) -> WheelGap:
    """Distances from points of a rail to a wheel along the rail's normals.

    Parameters
    ----------
    wheel
        Profile about the middle of the axle: x along it, -y the rolling radius.
    middle, axis
        Origin of the profile on the wheel's axis (2,), in the plane z = 0, and the axis' direction, a unit vector (3,).
    points, normals
        Of the rail, each (n, 2); normals towards the wheel.
    z
        Planes along the track, shape (n_z,).
    guess
        Gaps from close by to start from, shape (n, n_z).

    """
    # components first, (3, n n_z): sums over three of them are slow otherwise
    arms = np.vstack((np.repeat((points - middle).T, len(z), axis=1), np.tile(z, len(points))))
    rays = np.repeat(normals.T, len(z), axis=1)
    start, (u, v, w) = arms[:2].copy(), axis.tolist()
    gaps: Floats = np.zeros(rays.shape[1]) if guess is None else np.where(guess < FAR_MM, guess, 0.0).ravel()
    along, error, falling, radius, steepness = np.empty((5, len(gaps)))
    left: slice | Ints = slice(None)  # rays that have not met the wheel
    for _ in range(MAX_STEPS):
        ray = rays[:, left]
        arms[:2, left] = start[:, left] + gaps[left] * ray
        x, y, ahead = arms[:, left]
        station = u * x + v * y + w * ahead
        from_axis = x - station * u, y - station * v, ahead - station * w
        far = np.sqrt(from_axis[0] ** 2 + from_axis[1] ** 2 + from_axis[2] ** 2)
        height, steep, _ = wheel.graph(station)
        # f = r + y(x): positive outside of the wheel
        wrong = far + height
        slope = (from_axis[0] * ray[0] + from_axis[1] * ray[1]) / far + steep * (u * ray[0] + v * ray[1])
        along[left], error[left], falling[left], radius[left], steepness[left] = station, wrong, slope, far, steep
        further = np.abs(wrong) >= MET_MM
        if not further.any():
            break
        wrong = np.where(further, wrong, 0.0)
        if 2 * np.count_nonzero(further) < len(further):  # to pick them costs more than a few that stay
            wrong, slope, left = wrong[further], slope[further], np.arange(len(gaps))[left][further]
        step = np.where(slope < 0.0, -wrong / np.minimum(slope, -1e-3), MAX_STEP_MM * np.sign(wrong))
        gaps[left] += np.clip(step, -MAX_STEP_MM, MAX_STEP_MM)
    first, last = wheel.joints[[0, -1]]
    met = (np.abs(error) < 1e4 * MET_MM) & (falling < 0.0) & (along > first) & (along < last)
    gradient = (arms - along * axis[:, None]) / radius + steepness * axis[:, None]
    arrays = (np.where(met, gaps, FAR_MM), along, gradient / np.where(met, falling, -1.0), arms)
    return WheelGap(*(values.T.reshape(len(points), len(z), *values.shape[:-1]) for values in arrays))


RANK = 1e-4
"""Singular value relative to the first one below which modes of lateral bending are left out."""


@dataclass(frozen=True, eq=False)
class SideSurfaces:
    """Running surfaces of one side, elastic.

    - `wheel`: profile about the middle of the axle, x along it to the field side, -y the rolling radius.
    - `rail`: profile in the track's axes.
    - `wheel_elastic`, `rail_elastic`: what the bodies move more than half-spaces, in the axes of the curves.
    - `wheel_stations`, `rail_stations`: lengths along the curves, rising, and along the elastic surfaces, (n, 2); the
      rail's elastic surface runs from the field to the gauge side.
    - `wheel_frame`, `rail_frame`: from the frames of the profiles to those of the curves.
    """

    wheel: RigidCurve
    rail: RigidCurve
    wheel_elastic: ElasticSurface
    rail_elastic: ElasticSurface
    wheel_stations: Floats
    rail_stations: Floats
    wheel_frame: Placement
    rail_frame: Placement

    @property
    def modulus(self) -> float:
        """Contact modulus."""
        rail, wheel = self.materials
        return contact_modulus(rail.plane_modulus, wheel.plane_modulus)

    @property
    def materials(self) -> tuple[Elastic, Elastic]:
        """Materials of rail and wheel."""
        return self.rail_elastic.material, self.wheel_elastic.material

    def rail_points(self, stations: Floats) -> tuple[Floats, Floats]:
        """Points and outward normals of the rail at stations of its elastic surface, each (n, 2)."""
        arcs, along = self.rail_stations[::-1].T
        at = self.rail.at(np.interp(stations, along, arcs))
        return np.stack((at.x, at.y), axis=1), np.stack((-np.sin(at.angle), np.cos(at.angle)), axis=1)

    def wheel_at(self, along: Floats) -> Floats:
        """Stations of the wheel's elastic surface at positions along the axle."""
        x = self.wheel.at(self.wheel_stations[:, 0]).x
        return np.interp(along, x, self.wheel_stations[:, 1])


@dataclass(frozen=True)
class WheelPose:
    """Pose of a wheel in the right-hand form.

    - `x`, `y`: middle of the axle.
    - `roll_rad`, `yaw_rad`: of the axle.
    - `tilt_rad`: further roll of the wheel about its seat, as the axle bends.
    - `seat_mm`: distance of the wheel's seat from the axle's middle.
    - `deflection_mm`: displacement of the seat upwards across the axle, as it bends.
    """

    x: float
    y: float
    roll_rad: float
    yaw_rad: float = 0.0
    tilt_rad: float = 0.0
    seat_mm: float = 0.0
    deflection_mm: float = 0.0

    @property
    def whole_roll(self) -> float:
        """Roll of the wheel."""
        return self.roll_rad + self.tilt_rad

    @property
    def seat(self) -> Floats:
        """The wheel's seat from the axle's middle, shape (2,)."""
        return self.seat_mm * np.array([np.cos(self.roll_rad), np.sin(self.roll_rad)]) + self.deflection_mm * self.up

    @property
    def up(self) -> Floats:
        """Direction across the axle, along which its seats deflect, shape (2,)."""
        return np.array([-np.sin(self.roll_rad), np.cos(self.roll_rad)])

    @property
    def shift(self) -> Floats:
        """What bending of the axle moves the origin of the wheel's profile away from the axle's middle, shape (2,)."""
        return self.seat - self.seat_mm * np.array([np.cos(self.whole_roll), np.sin(self.whole_roll)])

    @property
    def middle(self) -> Floats:
        """Origin of the wheel's profile: the middle of the axle if that does not bend, shape (2,)."""
        return self.shift + np.array([self.x, self.y])

    @property
    def axis(self) -> Floats:
        """Direction of the wheel's axis to the field side, shape (3,)."""
        level = np.cos(self.whole_roll)
        return np.array([level * np.cos(self.yaw_rad), np.sin(self.whole_roll), level * np.sin(self.yaw_rad)])

    @property
    def motions(self) -> tuple[Floats, Floats]:
        """How `middle` moves and the axis turns by x, y, roll, deflection, tilt and yaw, (3, 6) each.

        The vectors of rotation of a body of revolution are ``axis x d(axis)``.
        """
        (s_x, s_y), yaw = self.seat, self.yaw_rad
        sine, cosine = np.sin(self.whole_roll), np.cos(self.whole_roll)
        middle, axes = np.zeros((3, 6)), np.zeros((3, 6))
        middle[0, 0] = middle[1, 1] = 1.0
        # middle = (x, y) + s - b (cos, sin)(roll + tilt) with the seat's distance b
        middle[:2, 4] = self.seat_mm * np.array([sine, -cosine])
        middle[:2, 2] = middle[:2, 4] + (-s_y, s_x)
        middle[:2, 3] = self.up
        axes[:, 2] = axes[:, 4] = -sine * np.cos(yaw), cosine, -sine * np.sin(yaw)
        axes[:, 5] = -cosine * np.sin(yaw), 0.0, cosine * np.cos(yaw)
        return middle, np.cross(self.axis, axes, axisb=0, axisc=0)


@dataclass(frozen=True, eq=False)
class SideState:
    """Contact of a side at one pose of its wheel.

    - `forces`: normal forces on the cells, N, shape (n, n_z).
    - `points`, `normals`: of the deformed rail's cells, each (n, 2).
    - `gap`: to the wheel as it stands, without the deformation of the surfaces at the contact.
    - `gaps`: of the deformed surfaces, shape (n, n_z).
    - `creep`: creep forces on the wheel's rows of cells, along t and z, shape (n, 2).
    """

    grid: "GriddedSide"
    pose: WheelPose
    forces: Floats
    points: Floats
    normals: Floats
    gap: WheelGap
    gaps: Floats
    creep: Floats

    @property
    def cells(self) -> CellForces:
        """Forces on the cells, in the right-hand form of the side."""
        grid, surfaces = self.grid.grid, self.grid.surfaces
        return CellForces(self.forces, grid, self.points, self.normals, self.gaps, surfaces.modulus, self.gap.gaps)

    @property
    def resultant(self) -> Floats:
        """Force on the wheel (x, y) and moment about the middle of the axle, counter-clockwise, shape (3,)."""
        on_wheel, arms = self.forces[..., None] * self.normals[:, None], self.gap.arms
        moment = (arms[..., 0] * on_wheel[..., 1] - arms[..., 1] * on_wheel[..., 0]).sum()
        return np.append(on_wheel.sum(axis=(0, 1)), moment)


@dataclass(frozen=True, eq=False)
class GriddedSide:
    """A side with its influence coefficients on a grid, for poses about one at which the wheel's cells were taken.

    The cells are on the rail's running surface, from the field side to the gauge side.
    """

    surfaces: SideSurfaces
    grid: PatchGrid
    pose: WheelPose

    @cached_property
    def _at(self) -> tuple[Floats, Floats]:
        """Points and outward normals of the rail's cells."""
        return self.surfaces.rail_points(self.grid.stations)

    @cached_property
    def frames(self) -> Floats:
        """Axes tangent (towards the gauge side), outward normal and z of the rail's cells, rows of (n, 3, 3)."""
        normals = self._at[1]
        frames = np.zeros((len(normals), 3, 3))
        frames[:, 0, :2] = tangents_of(normals)
        frames[:, 1, :2], frames[:, 2, 2] = normals, 1.0
        return frames

    @cached_property
    def _outermost(self) -> Bools:
        """Rows of cells between which and an end of the running surface no other one has room, (n, 1)."""
        low, high = np.sort(self.surfaces.rail_stations[[0, -1], 1])
        (first, last), widths = self.grid.cells.T, self.grid.widths
        return np.asarray((first - low < widths) | (high - last < widths))[:, None]

    def cuts(self, forces: Floats) -> bool:
        """Whether a patch of forces (n, n_z) comes to an end of the cells beyond which the surface goes on."""
        return bool(at_edge((forces > 0.0) & ~self._outermost).any())

    def leaves(self, forces: Floats) -> bool:
        """Whether a patch of forces (n, n_z) comes to the end of the running surface."""
        return bool(((forces > 0.0) & self._outermost).any())

    @property
    def _elastic(self) -> tuple[ElasticSurface, ElasticSurface]:
        return self.surfaces.rail_elastic, self.surfaces.wheel_elastic

    @cached_property
    def _weights(self) -> tuple[Floats, Floats]:
        """Weights of the splines of the rail and the wheel at the cells."""
        points, normals = self._at
        hit = wheel_gap(self.surfaces.wheel, self.pose.middle, self.pose.axis, points, normals, np.zeros(1))
        return (
            self.surfaces.rail_elastic.interpolation(self.grid.stations),
            self.surfaces.wheel_elastic.interpolation(self.surfaces.wheel_at(hit.along[:, 0])),
        )

    @property
    def _turns(self) -> tuple[Floats, Floats]:
        """Axes of the sections of rail and wheel in the track's axes, as columns of matrices (2, 2)."""
        return Placement(self.surfaces.rail_frame.rotation_rad).matrix, Placement(self.pose.whole_roll).matrix

    @cached_property
    def _loads(self) -> tuple[Floats, Floats]:
        """Unit normal forces on the cells in the axes of rail and wheel on their splines, (3, N, n)."""
        return self._unit_forces((1,), slice(None))

    def _unit_forces(self, axes: Sequence[int], rows: slice) -> tuple[Floats, Floats]:
        """Unit forces along axes of the frames of some cells, as `_loads`: (3, N, n m) for m axes."""
        directions, loads = self.frames[rows][:, axes], []
        for weights, turn in zip(self._weights, self._turns, strict=True):
            in_section = np.concatenate((directions[..., :2] @ turn, directions[..., 2:]), axis=2)
            full = np.einsum("ia,imx->xaim", weights[rows], in_section)
            loads.append(full.reshape(3, weights.shape[1], -1))
        return loads[0], loads[1]

    @cached_property
    def influence(self) -> Convolution:
        """Normal displacements of both surfaces together by normal forces."""
        return Convolution(self.coefficients)

    @cached_property
    def coefficients(self) -> Floats:
        """Normal displacements by unit normal forces at the distances of the strips, shape (n_z, n, n)."""
        return self.coefficients_of((1,), slice(None), self.grid.n_strips)

    def coefficients_of(self, axes: Sequence[int], rows: slice, n_distances: int) -> Floats:
        """Displacements of the wheel less those of the rail by unit forces on the wheel's cells, opposite on the rail.

        - `axes`: components along `frames`: 0 tangent, 1 normal, 2 z.
        - `rows`: cells across.
        - `n_distances`: number of distances along z, multiples of the strip from 0.

        Returned: shape (n_distances, n m, n m) for n cells and m axes.
        """
        grid = self.grid
        frames = self.frames[rows]
        bounds = grid.bounds[rows.start : None if rows.stop is None else rows.stop + 1]
        total = half_spaces_on(self.surfaces.materials, bounds, frames, grid.strip, n_distances, axes)
        total = total.reshape(n_distances, len(frames) * len(axes), -1)
        for elastic, loads in zip(self._elastic, self._unit_forces(axes, rows), strict=True):
            longest = grid.strip * max(n_distances, grid.n_strips)
            used = min(int(np.searchsorted(elastic.distances, longest)) + 3, len(elastic.distances))
            along = elastic.along(grid.strip * np.arange(n_distances, dtype=np.float64))[:, :used]
            near = _loaded(loads)
            table, near_loads = elastic.on_splines[(*near, slice(used), *near)], loads[near].reshape(-1, loads.shape[2])
            # T_zij = sum over splines k, l with their axes and tabulated distances w of A_zw L_ki R_kwl L_lj
            by_force = table.reshape(-1, len(near_loads)) @ near_loads
            on_cells = (near_loads.T @ by_force.reshape(len(near_loads), -1)).reshape(loads.shape[2], used, -1)
            total += (along @ on_cells).swapaxes(0, 1)
        return total

    @cached_property
    def _bending(self) -> tuple[Floats, Floats]:
        """What the bodies move more than half-spaces at the cells by unit normal forces.

        Displacement of the rail less that of the wheel at the cells (n, 2, n), and turn of the rail's normals (n, n).
        """
        return self._bent(self._loads)

    @cached_property
    def _bending_across(self) -> tuple[Floats, Floats]:
        """As `_bending` by unit forces along the tangents, opposite on rail and wheel."""
        return self._bent(self._unit_forces((0,), slice(None)))

    @property
    def bending(self) -> Floats:
        """Displacement of the rail less that of the wheel by unit normal forces on rows, (n, 2, n)."""
        return self._bending[0]

    @property
    def bending_across(self) -> Floats:
        """Displacement of the rail less that of the wheel by unit lateral forces on rows of the wheel, (n, 2, n)."""
        return self._bending_across[0]

    def _bent(self, forces: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        grid, (rail_weights, wheel_weights) = self.grid, self._weights
        moved = []
        for elastic, loads, turn in zip(self._elastic, forces, self._turns, strict=True):
            near = _loaded(loads)
            moved_splines = np.tensordot(elastic.on_splines[:2, :, 0][(..., *near)], loads[near])
            moved.append(np.einsum("xy,yaj->axj", turn, moved_splines))
        rail = -np.einsum("ia,axj->ixj", rail_weights, moved[0])
        wheel = np.einsum("ia,axj->ixj", wheel_weights, moved[1])
        slope = self.surfaces.rail_elastic.interpolation(grid.stations, 1)
        # along the surface d(u . n) / ds = -w by a rotation w
        turn = np.einsum("ia,axj,ix->ij", slope, moved[0], self._at[1], optimize=True)
        return rail - wheel, turn

    def rail_motion(self, forces: Floats, across: Floats) -> tuple[Floats, float]:
        """What normal forces (n, n_z), and lateral ones of rows (n,), move the rail's surface more than a half-space.

        Returned: rigid motion that fits it best, along x and y at the rail's top in mm and rotation in rad, (3,); and
        the displacement outwards of the gauge face 14 mm below the top, or of its lowest point, along x.
        """
        elastic, loads, turn = self._elastic[0], self._loads[0], self._turns[0]
        row = forces.sum(axis=1)
        shares = self.turned(row, across)[1]
        load = loads @ row + self._unit_forces((0,), slice(None))[0] @ (shares + across)
        moved = -elastic.interpolation(elastic.stations) @ np.tensordot(elastic.on_splines[:2, :, 0], load).T
        moved, points = moved @ turn.T, self.surfaces.rail_frame.points(elastic.points)
        top = points[np.argmax(points[:, 1])]
        x, y = (points - top).T
        ones, none = np.ones(len(x)), np.zeros(len(x))
        terms = np.concatenate((np.stack((ones, none, -y), axis=1), np.stack((none, ones, x), axis=1)))
        motion, *_ = np.linalg.lstsq(terms, moved.T.ravel())
        inner = np.flatnonzero(x < 0.0)
        at_gauge = inner[np.argmin(np.abs(y[inner] + GAUGE_DEPTH_MM))]
        return motion, float(moved[at_gauge, 0])

    @cached_property
    def loads_of_modes(self) -> Floats:
        """Lateral forces of rows by which `bending_across` has its modes, (r, n)."""
        _, sizes, loads = np.linalg.svd(self.bending_across.reshape(-1, len(self.grid.widths)), full_matrices=False)
        return np.asarray(loads[sizes > RANK * sizes[0]])

    def means(self, values: Floats, gaps: Floats, rows: slice = ALL) -> Floats:
        """Means over rows of cells of values by those at their middles, (n, n_z, k): ``v + w^2 / 24 v''``.

        A jump of a profile's curvature inside of a cell would be as a step of the surface otherwise.

        - `gaps`: at the middles, (n, n_z): beside those of what does not meet, values stay.
        """
        steps, widths = np.diff(self.grid.stations[rows])[:, None], self.grid.widths[rows, None]
        near = (gaps < FAR_MM)[1:] & (gaps < FAR_MM)[:-1] & (steps < 2.0 * widths[1:])
        # v'' = 2 ((v_+ - v) / h_+ - (v - v_-) / h_-) / (h_+ + h_-)
        part = widths[1:-1] ** 2 / 12.0 / (steps[1:] + steps[:-1]) * (near[1:] & near[:-1])
        means = values.copy()
        means[1:-1] += part[..., None] * np.diff(np.diff(values, axis=0) / steps[..., None], axis=0)
        return means

    def derivatives(self, row: Floats, across: Floats, n_across: int) -> tuple[Floats, Floats]:
        """How the rail's cells move against the wheel's and turn, by normal and lateral forces of rows.

        With normal forces p of rows, lateral ones a, and p's shares s along the tangents (see `turned`):
        ``ds = (1 - p T')^-1 ((th + p T) dp + p T' da)``, ``th = T p + T' (a + s)`` the turn,
        ``dP = B dp + B' (da + ds)``, and the angle of the normals ``(T dp + T' (da + ds)) / (1 + th^2)``.

        - `n_across`: n, or 0 without derivatives by a.

        Returned: displacement (n, 2, n + n_across) and angle (n, n + n_across) by (p, a).
        """
        (moved, turn), (moved_across, turn_across) = self._bending, self._bending_across
        n, angles, unit = len(row), self.turned(row, across)[0], np.eye(len(row))
        by = np.hstack((np.diag(angles) + row[:, None] * turn, row[:, None] * turn_across[:, :n_across]))
        along = np.linalg.solve(unit - row[:, None] * turn_across, by)
        along[:, n:] += unit[:, :n_across]
        turns, moves = turn_across @ along, moved_across @ along
        turns[:, :n] += turn
        moves[..., :n] += moved
        return moves, turns / (1.0 + angles**2)[:, None]

    def deformed(
        self,
        pose: WheelPose,
        forces: Floats,
        across: Floats,
        guess: Floats | None = None,
    ) -> tuple[Floats, Floats, WheelGap, Floats]:
        """Geometry as the bodies bend under forces: points and normals of the rail's cells, gaps, and right-hand side.

        The right-hand side has no deformation: what the forces move is added by `influence`, the bending included.

        - `across`: lateral creep forces on the wheel's rows of cells, (n,); what they move stays in the geometry.
        - `guess`: gaps from close by.
        """
        points, normals = self._at
        row = forces.sum(axis=1)
        turned, shares = self.turned(row, across)
        moved = self._bending[0] @ row
        points = points + self.bending_across @ (shares + across) + moved
        normals = normals + turned[:, None] * tangents_of(normals)
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        gap = wheel_gap(self.surfaces.wheel, pose.middle, pose.axis, points, normals, self.grid.along, guess)
        # arms from the middle of the axle, not from the profile's origin
        gap = gap._replace(arms=gap.arms + np.append(pose.shift, 0.0))
        values = self.means(gap.gaps[..., None], gap.gaps)[..., 0]
        # `influence` moves the cells along the undeformed normals
        values = np.where(gap.gaps < FAR_MM, values + (self.moved_along_normals @ row)[:, None], FAR_MM)
        return points, normals, gap, values

    def turned(self, row: Floats, across: Floats) -> tuple[Floats, Floats]:
        """Turn of the normals by normal forces of rows, and the share of these along the tangents, (n,) each.

        Forces act along the turned normals, on the bodies as on the wheelset: else the work that they do when the rail
        turns would be lost, and forces would not be the derivative of the energy. With normal forces p of rows, turns T
        by them and T' by forces along the tangents, ``s_i = p_i (T p + T' s)_i``. ``across``: see `deformed`.
        """
        turn, turn_across = self._bending[1], self._bending_across[1]
        by_row = turn @ row + turn_across @ across
        shares = np.asarray(np.linalg.solve(np.eye(len(row)) - row[:, None] * turn_across, row * by_row), np.float64)
        return by_row + turn_across @ shares, shares

    @cached_property
    def moved_along_normals(self) -> Floats:
        """What unit normal forces of rows move the cells along their undeformed normals in `influence`, N.B, (n, n)."""
        return np.einsum("ix,ixj->ij", self._at[1], self._bending[0])


def _loaded(loads: Floats) -> tuple[slice, slice]:
    """The axes and splines of unit forces on these, (3, N, n), from the first to the last one that is not zero."""
    axes, splines = (np.flatnonzero(loads.any(axis=rest)) for rest in ((1, 2), (0, 2)))
    return slice(0, int(axes[-1]) + 1), slice(int(splines[0]), int(splines[-1]) + 1)


def tangents_of(normals: Floats) -> Floats:
    """Directions along the rail towards the gauge side from outward normals, each (n, 2)."""
    return -turned_right(normals)
