"""What engineers ask for of a wheelset in three dimensions: its patches, and the stresses below them."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.errors import InputError
from flangeway.exact import PointContact, contact_modulus
from flangeway.post.patch_stresses import DepthProfile, half_space_profile
from flangeway.railway.rigid.elastic_start import CLIMBED_MM
from flangeway.railway.spatial.rail_along_track import RailAlongTrack, rail_along_track
from flangeway.railway.spatial.running_surfaces import SpatialModel, running_surfaces
from flangeway.railway.spatial.side_contact import SideState
from flangeway.railway.spatial.spatial_wheelset import SpatialState, SpatialWheelset
from flangeway.railway.spatial.supported_rail import supported_rail
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.wheelset_model import region_of
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

DEPTHS = (0.05, 3.0)
"""Least depth over the shorter semi-axis, and greatest one over the longer one, of the lines below patches."""
N_DEPTHS = 60
NO_ELLIPSE = 0.8
"""Area of a patch over that of its equivalent ellipse below which it is none; single patches have 0.95 to 1.02."""
NARROW = 10
"""Cells across or along a patch below which its maximum pressure is uncertain by more than 2 %."""


@dataclass(frozen=True, eq=False)
class SpatialPatch:
    """One patch between a wheel and its rail.

    - `side`: of the track.
    - `state`: contact of the side, in its right-hand form.
    - `ellipse`: resultant, axes and cells in this form.
    """

    side: Side
    state: SideState
    ellipse: ContactEllipse
    materials: Mapping[Role, tuple[float, float]]

    @property
    def force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Force on the wheel in the track's axes, shape (2,)."""
        return self.ellipse.force * (SIDE_SIGN[self.side], 1.0)

    @property
    def centre_mm(self) -> Floats:
        """Centre of pressure in the track's axes: x to the right, y up, z ahead of the axle, shape (3,)."""
        return self.ellipse.centre * (SIDE_SIGN[self.side], 1.0, 1.0)

    @property
    def contact_angle_rad(self) -> float:
        """Angle of the plane normal to the resultant from the track's plane, positive towards the flange."""
        return float(np.arctan2(-self.ellipse.force[0], self.ellipse.force[1]))

    @property
    def region(self) -> str:
        """Part of the rail in contact; see `flangeway.railway.wheelset.wheelset_model.region_of`."""
        lateral, vertical = self.force_on_wheel_N.tolist()
        return region_of(self.side, lateral, vertical)

    @cached_property
    def _row(self) -> Floats:
        """Shares of the cells across in the force."""
        forces = np.where(self.ellipse.inside, self.state.forces, 0.0).sum(axis=1)
        return forces / forces.sum()

    @property
    def rail_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed rail, in the frame of its profile, shape (2,)."""
        surfaces, station = self.state.grid.surfaces, np.array([self._row @ self.state.grid.grid.stations])
        return surfaces.rail_frame.inverse().points(surfaces.rail_points(station)[0])[0]

    @property
    def wheel_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed wheel, in the frame of its profile, shape (2,)."""
        surfaces = self.state.grid.surfaces
        inside = np.where(self.ellipse.inside, self.state.forces, 0.0)
        along = np.array([(inside * self.state.gap.along).sum() / inside.sum()])
        point = np.stack((along, surfaces.wheel.over(along).y), axis=1)
        return surfaces.wheel_frame.inverse().points(point)[0]

    @property
    def rolling_radius_mm(self) -> float:
        """Distance of the centre of pressure from the axle."""
        inside = np.where(self.ellipse.inside, self.state.forces, 0.0)
        radii = -self.state.grid.surfaces.wheel.over(self.state.gap.along).y
        return float((inside * radii).sum() / inside.sum())

    @property
    def conformity_deg(self) -> float:
        """Angle by which the rail's normal turns across the patch, in degrees."""
        normals = self.state.normals[self.ellipse.inside.any(axis=1)]
        return float(np.rad2deg(np.ptp(np.arctan2(normals[:, 0], normals[:, 1]))))

    @cached_property
    def hertz(self) -> PointContact | None:
        """Hertz's contact for its force and the curvatures of its gap, None where these vary too much."""
        gaps = self.state.gap.gaps
        inside = self.ellipse.inside
        approach = float(np.ptp(gaps[inside]))
        if min(self.ellipse.cells) < 3 or not approach > 0.0:
            return None
        modulus = contact_modulus(*(young / (1.0 - poisson**2) for young, poisson in self.materials.values()))
        return self.state.cells.hertz(self.ellipse, gaps, approach, modulus)

    @property
    def remark(self) -> str:
        """What limits the maximum pressure, empty if nothing does."""
        across, along = self.ellipse.cells
        return f"{across} by {along} cells" if min(across, along) < NARROW else ""

    def below(self, role: Role, tractions: Floats | None = None) -> DepthProfile:
        """Stresses on the normal below the centre of pressure, of a half-space under the tractions of the patch.

        Axes: x along the surface, y along its outward normal, z along the track. The tractions by friction on the
        wheel's cells, along x and z, have the shape (n_cells, n_strips, 2).
        """
        grid, ellipse = self.state.grid.grid, self.ellipse
        window = np.ix_(ellipse.inside.any(axis=1), ellipse.inside.any(axis=0))
        depths: Floats = np.geomspace(DEPTHS[0] * ellipse.semi_axes[1], DEPTHS[1] * ellipse.semi_axes[0], N_DEPTHS)
        z = np.stack((grid.z - grid.strip / 2.0, grid.z + grid.strip / 2.0), axis=1)
        return half_space_profile(
            (grid.cells[window[0][:, 0]], z[window[1][0]]),
            np.where(ellipse.inside, self.state.cells.pressures, 0.0)[window],
            (float(self._row @ grid.stations), float(ellipse.centre[2])),
            depths,
            self.materials[role][1],
            None if tractions is None else tractions[window] * (1.0 if role == "wheel" else -1.0),
        )


@dataclass(frozen=True, eq=False)
class SpatialResult:
    """A wheelset in equilibrium on its track, in three dimensions.

    - `equilibrium`: position, residuals and contact of both sides.
    - `patches`: left side first, each side by falling force.
    - `timings_s`: seconds of the stages.
    - `warnings`: what limits the result.
    - `cache`: where solutions of the sections are kept from one process to the next.
    """

    status: Status
    wheelset: SpatialWheelset
    equilibrium: Equilibrium[SpatialState]
    patches: tuple[SpatialPatch, ...]
    timings_s: dict[str, float]
    warnings: tuple[str, ...]
    cache: Cache | None = None

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.wheelset.problem

    @property
    def approach_mm(self) -> float:
        """Vertical displacement of the axle's middle, down, from the rigid position to the equilibrium."""
        return self.wheelset.start.motion.vertical_mm - self.equilibrium.position.vertical_mm

    @cached_property
    def rails(self) -> dict[Side, RailAlongTrack]:
        """Both rails along the track under these contact forces, empty if their bases are fixed."""
        support, found = self.wheelset.model.support, {}
        for side in SIDES if support is not None else ():
            assert support is not None
            profile, state = self.problem.track.rail_of(side), self.equilibrium.state.sides[side]
            grid, frame = state.grid.grid, state.grid.surfaces.rail_frame
            loaded = state.forces.any(axis=1)
            points = frame.inverse().points(state.grid.surfaces.rail_points(grid.stations[loaded])[0])
            forces = -state.forces.sum(axis=1)[loaded, None] * frame.inverse().vectors(state.normals[loaded])
            rail = supported_rail(profile, self.problem.material_of("rail"), support, cache=self.cache)
            found[side] = rail_along_track(rail, profile, points, np.pad(forces, ((0, 0), (0, 1))), placement=frame)
        return found

    @property
    def position_in_space(self) -> WheelsetPosition:
        """The position along horizontal and vertical."""
        position = self.equilibrium.position
        lateral, vertical = self.problem.load.to_space(position.lateral_mm, position.vertical_mm)
        return WheelsetPosition(lateral, vertical, position.roll_rad)

    def force_on_wheel_N(self, side: Side) -> Floats:  # noqa: N802
        """Contact force on the wheel of a side, axes of the track, shape (2,)."""
        return self.equilibrium.state.sides[side].resultant[:2] * (SIDE_SIGN[side], 1.0)

    def head_motion(self, side: Side) -> tuple[float, float, float, float]:
        """Motion of a rail's head in the track's axes, lateral, vertical and roll, and that of its gauge face outwards.

        See `flangeway.railway.spatial.side_contact.GriddedSide.rail_motion`.
        """
        state, sign = self.equilibrium.state.sides[side], SIDE_SIGN[side]
        (lateral, vertical, roll), outward = state.grid.rail_motion(state.forces)
        return sign * float(lateral), float(vertical), sign * float(roll), float(outward)

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's contact force, positive where it pushes the rail outwards; nan without contact."""
        lateral, vertical = self.force_on_wheel_N(side)
        if not vertical > 0.0:
            return float("nan")
        return float(lateral / vertical) * -SIDE_SIGN[side]


def solve_spatial(
    problem: WheelsetProblem,
    model: SpatialModel | None = None,
    *,
    cold: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> SpatialResult:
    """Find a wheelset's equilibrium in three dimensions, and its patches.

    - `model`: supports, axle and yaw; those by default if left out.
    - `cold`: compute everything anew, without the user's cache.
    """
    timings: dict[str, float] = {}
    start = time.perf_counter()
    model = SpatialModel() if model is None else model
    cache = None if cold else Cache.of_user()
    rigid = SpatialWheelset(problem, {}, model)
    _ = rigid.start  # what rigid wheels cannot do is refused before the bodies are meshed
    surfaces = running_surfaces(problem, model, cache=cache, progress=progress)
    timings["compliance"] = time.perf_counter() - start
    return replace(solve_position(replace(rigid, surfaces=surfaces), timings, progress), cache=cache)


def solve_position(
    wheelset: SpatialWheelset,
    timings: dict[str, float],
    progress: Callable[[str], None] = lambda _: None,
) -> SpatialResult:
    """Find the equilibrium of a wheelset whose running surfaces are ready."""
    begun = time.perf_counter()
    equilibrium = wheelset.solve(progress)
    problem = wheelset.problem
    materials = {role: (problem.material_of(role).young, problem.material_of(role).poisson) for role in ROLES}
    patches: list[SpatialPatch] = []
    for side in SIDES if equilibrium.status.converged else ():
        state = equilibrium.state.sides[side]
        patches += [SpatialPatch(side, state, each, materials) for each in state.cells.patches()]
    timings["contact"] = time.perf_counter() - begun
    status, warnings = equilibrium.status, []
    lost = [side for side in SIDES if not any(patch.side == side for patch in patches)]
    if equilibrium.stable is False:
        warnings.append("the equilibrium is unstable: a small push moves the wheelset away from it")
    if lost and status.converged:
        warnings.append(f"the {' and '.join(lost)} wheel does not touch its rail")
    warnings += [
        f"{patch.side} side, {patch.region}: {patch.remark} on a narrow patch, its maximum pressure is rough"
        for patch in patches
        if patch.remark
    ]
    start, lateral = wheelset.start, problem.prescribed.lateral_mm
    if not status.converged and len(start.starts) > 1 and lateral is not None:
        more = f"; a rigid flange climbs beyond {start.motion.lateral_mm:.1f} mm: check lateral_mm"
        status = Status(False, status.message + more, status.iterations)
    rise = equilibrium.position.vertical_mm - float(start.geometry.locus([0.0]).vertical_mm[0])
    if status.converged and rise > CLIMBED_MM:
        reason = f"derailed, the axle {rise:.1f} mm higher than in the middle of the track, a flange on its rail"
        if lateral is not None:
            raise InputError(
                f"lateral_mm = {lateral:g}: {reason}",
                f"a position at which no flange climbs, rigid ones up to {start.motion.lateral_mm:.1f} mm",
                "give a smaller lateral_mm",
            )
        status = Status(False, f"{reason}; check what is prescribed and the load", status.iterations)
    warnings += [
        f"{patch.side} side, {patch.region}: the patch is no ellipse; its semi-axes are those of its second moments"
        for patch in patches
        if patch.ellipse.area < NO_ELLIPSE * np.pi * np.prod(patch.ellipse.semi_axes)
    ]
    sides = equilibrium.state.sides.items()
    cut = [side for side, state in sides if (state.forces > 0.0)[state.grid.grid.at_edge].any()]
    if cut and status.converged:
        status = Status(
            False,
            f"the {' and '.join(cut)} contact reaches the end of the running surface; check the profiles and the load",
            status.iterations,
        )
    return SpatialResult(status, wheelset, equilibrium, tuple(patches), timings, tuple(warnings))
