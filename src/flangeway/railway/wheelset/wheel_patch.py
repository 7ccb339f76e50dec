"""Contact patch of a wheel in equilibrium on its rail, and the stresses below it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact import Surface
from flangeway.contact.patch.patch_contact import ContactEllipse, PatchContact, press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchBody, grid_about, pairs_of
from flangeway.exact import PointContact
from flangeway.geometry import Placement
from flangeway.post.patch_stresses import DepthProfile, StressField, half_space_profile, stress_field
from flangeway.problems import Body, Elasticity, Harmonic
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.railway.track.wheelset_problem import Role
from flangeway.railway.wheelset.side_contact import SideState
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, region_of
from flangeway.types import Floats

DEPTHS = (0.05, 3.0)
"""Least depth relative to the shorter semi-axis, and greatest one relative to the longer one, of the lines below
patches."""
N_DEPTHS = 40
MIN_CELLS_OF_PATCH = 10
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
    def _shares(self) -> Floats:
        """Shares of all cells of the side in the force, (n, n_z)."""
        forces = np.where(self.ellipse.inside, self.state.forces, 0.0)
        return forces / forces.sum()

    @property
    def _station(self) -> float:
        """Length along the rail's elastic surface of the centre of pressure."""
        return float(self._shares.sum(axis=1) @ self.state.grid.grid.stations)

    @property
    def rail_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed rail, in the frame of its profile, shape (2,)."""
        surfaces = self.state.grid.surfaces
        return surfaces.rail_frame.inverse().points(surfaces.rail_points(np.array([self._station]))[0])[0]

    @property
    def wheel_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed wheel, in the frame of its profile, shape (2,)."""
        surfaces = self.state.grid.surfaces
        along = np.array([(self._shares * self.state.gap.along).sum()])
        point = np.stack((along, surfaces.wheel.over(along).y), axis=1)
        return surfaces.wheel_frame.inverse().points(point)[0]

    @property
    def rolling_radius_mm(self) -> float:
        """Distance of the centre of pressure from the axle."""
        heights = self.state.grid.surfaces.wheel.over(self.state.gap.along).y
        return -float((self._shares * heights).sum())

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
        return self.state.cells.hertz(self.ellipse, gaps, approach)

    @property
    def remark(self) -> str | None:
        """What limits the maximum pressure, None if nothing does."""
        across, along = self.ellipse.cells
        return f"{across} by {along} cells" if min(across, along) < MIN_CELLS_OF_PATCH else None

    def below(self, role: Role, tractions: Floats | None = None) -> DepthProfile:
        """Stresses on the normal below the centre of pressure, of a half-space under the tractions of the side.

        Axes: x along the surface, y along its outward normal, z along the track. The tractions by friction on the
        wheel's cells, along x and z, have the shape (n_cells, n_strips, 2).
        """
        grid, loads = self.state.grid.grid, self._loads(role, tractions)
        window = np.ix_(loads.any(axis=(1, 2)), loads.any(axis=(0, 2)))
        loads = loads[window]
        return half_space_profile(
            (grid.cells[window[0][:, 0]], pairs_of(grid.strip_bounds)[window[1][0]]),
            loads[..., 0],
            (self._station, float(self.ellipse.centre[2])),
            self._depths,
            self._poisson(role),
            None if tractions is None else loads[..., 1:],
        )

    def field(self, role: Role, tractions: Floats | None = None) -> StressField:
        """Stresses in the volume below the patch, as `below`."""
        grid, depths = self.state.grid.grid, np.append(0.0, self._depths)
        loads = self._loads(role, tractions)
        return stress_field(grid.cells, grid.along, loads, self.ellipse.inside, depths, self._poisson(role))

    def points_below(self, role: Role, along: Floats, depths: Floats, z: Floats) -> Floats:
        """Points of a body at depths below lengths along the rail's surface, in the track's axes; (n,) each, (n, 3)."""
        state, stations = self.state, self.state.grid.grid.stations
        points, normals = (
            np.stack([np.interp(along, stations, values) for values in array.T], axis=1)
            for array in (state.points, state.normals)
        )
        inward = normals * (1.0 if role == "wheel" else -1.0) / np.linalg.norm(normals, axis=1)[:, None]
        points = points + depths[:, None] * inward
        return np.column_stack((SIDE_SIGN[self.side] * points[:, 0], points[:, 1], z))

    @property
    def _depths(self) -> Floats:
        long, short = self.ellipse.semi_axes
        return np.geomspace(DEPTHS[0] * short, DEPTHS[1] * long, N_DEPTHS)

    def _poisson(self, role: Role) -> float:
        """Poisson's ratio of a body."""
        rail, wheel = self.state.grid.surfaces.materials
        return (wheel if role == "wheel" else rail).poisson

    def _loads(self, role: Role, tractions: Floats | None) -> Floats:
        """Pressure and shears of all cells of the side on a body as a half-space, (n_cells, n_strips, 1 or 3)."""
        pressures = self.state.cells.pressures[..., None]
        if tractions is None:
            return pressures
        return np.concatenate((pressures, tractions * (1.0 if role == "wheel" else -1.0)), axis=2)


def spatial_patch(
    model: WheelsetModel,
    side: Side,
    force: float,
    *,
    cell_mm: float | None = None,
    window_mm: tuple[float, float] = (16.0, 24.0),
    tolerance: float = 1e-3,
    progress: Callable[[str], None] = lambda _: None,
) -> PatchContact:
    """Press a wheel on its rail vertically, from the position in which the rigid wheelset touches.

    Parameters
    ----------
    model
        Meshed wheelset and track.
    side
        Side of the track.
    force
        Vertical force in N.
    cell_mm
        Size of square cells; chosen with the window if left out.
    window_mm
        Width across and length along the track of the grid, with `cell_mm`.
    tolerance
        See `flangeway.solve.compliance_table`.
    progress
        Called with a sentence at each stage.

    Returns
    -------
    PatchContact
        Pressures on the rail's cells, in the axes of the track, mm and MPa.

    Raises
    ------
    InputError
        As `flangeway.contact.patch.patch_contact.press_patch`.

    """
    contact = model.contact(side)
    wheel, rail = contact.secondary, contact.primary
    if wheel.part.name.startswith("rail"):
        wheel, rail = rail, wheel
    placement = model.rigid_position.placement(model.problem.wheels, side)
    back, roll = placement.inverse(), model.rigid_position.roll_rad
    axle = back.points([model.rigid_position.axle(model.problem.wheels)])[0]
    direction = back.vectors([(np.cos(roll), np.sin(roll))])[0]
    lower = _body(rail, rail.part.placement)
    upper = _body(wheel, placement, Axis((axle[0], axle[1]), (direction[0], direction[1])))
    grid = None if cell_mm is None else grid_about(lower, upper, cell_mm, window_mm)
    return press_patch(lower, upper, force=force, grid=grid, tolerance=tolerance, progress=progress)


def _body(surface: Surface, placement: Placement, axis: Axis | None = None) -> PatchBody:
    body = surface.part.body
    assert isinstance(body, Body)  # wheels and rails are meshed
    problem = Harmonic(Elasticity(body.space, body.material, name=body.name), held=dict.fromkeys(body.supports, "xyz"))
    return PatchBody(problem, surface.edges.astype(np.int64), surface.curve, placement, axis)
