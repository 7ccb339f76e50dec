"""Contact patch of a wheel in equilibrium on its rail, and the stresses below it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact import Surface
from flangeway.contact.patch.normal_contact import Convolution, Pressing
from flangeway.contact.patch.patch_contact import PatchContact, SpatialPatch, press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchBody, grid_about, pairs_of
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.exact.shakedown import shakedown_state
from flangeway.geometry import Placement
from flangeway.post.patch_stresses import DepthProfile, StressField, half_space_profile, stress_field
from flangeway.problems import Body, Elasticity, Harmonic
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.rolling.patch_rolling import contact_in, forces_on_cells, rows_of, strips_of
from flangeway.railway.wheelset.side_contact import FAR_MM, SideState, tangents_of
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, region_of
from flangeway.types import Floats

DEPTHS = (0.05, 3.0)
"""Least depth relative to the shorter semi-axis, and greatest one relative to the longer one, of the lines below
patches."""
N_DEPTHS = 40


@dataclass(frozen=True, eq=False)
class WheelPatch(SpatialPatch):
    """One patch between a wheel and its rail, in the right-hand form of its side.

    - `side`: of the track.
    - `state`: contact of the side.
    - `creep`: creep forces on the wheel; None without friction.
    - `tractions`: by friction on the wheel's cells of the whole side, along t and z, shape (n, n_z, 2); None where the
      theory has none.
    - `yield_MPa`: yield strength; None where it is not known.
    """

    side: Side
    state: SideState
    creep: CreepState | None = None
    tractions: Floats | None = None
    yield_MPa: float | None = None  # noqa: N815

    @property
    def force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Normal and creep force on the wheel, N, in the track's axes: x to the right, y up, z ahead, shape (3,)."""
        return np.append(self.force * (SIDE_SIGN[self.side], 1.0), 0.0) + self.creep_force_on_wheel_N

    @cached_property
    def creep_force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Creep force on the wheel, N, in the track's axes, 0 without friction, shape (3,)."""
        if self.creep is None:
            return np.zeros(3)
        across, along = forces_on_cells(self.creep.forces, self.creep.contact).sum(axis=1).T
        normals = self.state.normals[rows_of(self.state, self.creep.contact)]
        return np.append(across @ tangents_of(normals), along.sum()) * (SIDE_SIGN[self.side], 1.0, 1.0)

    @property
    def centre_mm(self) -> Floats:
        """Centre of pressure in the track's axes: x to the right, y up, z ahead of the axle, shape (3,)."""
        return self.centre * (SIDE_SIGN[self.side], 1.0, 1.0)

    @property
    def contact_angle_rad(self) -> float:
        """Angle of the plane normal to the normal force from the track's plane, positive towards the flange."""
        return float(np.arctan2(-self.force[0], self.force[1]))

    @property
    def region(self) -> str:
        """Part of the rail in contact; see `flangeway.railway.wheelset.wheelset_model.region_of`."""
        lateral, vertical = self.force.tolist()
        return region_of("right", lateral, vertical)

    @property
    def rail_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed rail, in the frame of its profile, shape (2,)."""
        surfaces = self.state.grid.surfaces
        return surfaces.rail_frame.inverse().points(surfaces.rail_points(np.array([self.station]))[0])[0]

    @property
    def wheel_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed wheel, in the frame of its profile, shape (2,)."""
        surfaces = self.state.grid.surfaces
        along = np.array([(self.fractions * self.state.gap.along).sum()])
        point = np.stack((along, surfaces.wheel.over(along).y), axis=1)
        return surfaces.wheel_frame.inverse().points(point)[0]

    @property
    def rolling_radius_mm(self) -> float:
        """Distance of the centre of pressure from the axle."""
        heights = self.state.grid.surfaces.wheel.over(self.state.gap.along).y
        return -float((self.fractions * heights).sum())

    @property
    def conformity_deg(self) -> float:
        """Angle by which the rail's normal turns across the patch, in degrees."""
        normals = self.state.normals[self.inside.any(axis=1)]
        return float(np.rad2deg(np.ptp(np.arctan2(normals[:, 0], normals[:, 1]))))

    @property
    def load_factor(self) -> float | None:
        """Maximum pressure over the shear strength, p0 / k; None if the yield strength is not known."""
        return float(np.sqrt(3.0) * self.max_pressure / self.yield_MPa) if self.yield_MPa else None

    @property
    def shakedown_state(self) -> str | None:
        """State of the steel under repeated rolling, see `flangeway.exact.shakedown.shakedown_state`."""
        factor = self.load_factor
        return None if factor is None else shakedown_state(factor, self.creep.used_friction if self.creep else 0.0)

    def on_side(self, creep: CreepState, values: Floats) -> Floats:
        """Values (n_cells, n_strips, ...) of the cells of its creep forces on all cells of the side, 0 elsewhere."""
        whole = np.zeros((*self.inside.shape, *values.shape[2:]))
        whole[rows_of(self.state, creep.contact), strips_of(self.state, creep.contact)] = values
        return whole

    @cached_property
    def lines(self) -> dict[Role, DepthProfile]:
        """Stresses on the normals below the centre of pressure, of half-spaces under the tractions of the side.

        Axes: x along the surface, y along its outward normal, z along the track.
        """
        return {role: self._line(role) for role in ROLES}

    def _line(self, role: Role) -> DepthProfile:
        grid, loads = self.cells.grid, self._loads(role)
        window = np.ix_(loads.any(axis=(1, 2)), loads.any(axis=(0, 2)))
        loads = loads[window]
        return half_space_profile(
            (grid.cells[window[0][:, 0]], pairs_of(grid.strip_bounds)[window[1][0]]),
            loads[..., 0],
            (self.station, float(self.centre[2])),
            self._depths,
            self._poisson(role),
            None if self.tractions is None else loads[..., 1:],
        )

    @cached_property
    def stress_fields(self) -> dict[Role, StressField]:
        """Stresses in the volumes below the patch, as `lines`."""
        rail = self._field("rail")
        # without tractions both bodies of one material have the same stresses
        same = self.tractions is None and self._poisson("rail") == self._poisson("wheel")
        return {"rail": rail, "wheel": rail if same else self._field("wheel")}

    def _field(self, role: Role) -> StressField:
        grid, depths = self.cells.grid, np.append(0.0, self._depths)
        return stress_field(grid.cells, grid.along, self._loads(role), self.inside, depths, self._poisson(role))

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
        long, short = self.semi_axes
        return np.geomspace(DEPTHS[0] * short, DEPTHS[1] * long, N_DEPTHS)

    def _poisson(self, role: Role) -> float:
        """Poisson's ratio of a body."""
        rail, wheel = self.state.grid.surfaces.materials
        return (wheel if role == "wheel" else rail).poisson

    def _loads(self, role: Role) -> Floats:
        """Pressure and shears of all cells of the side on a body as a half-space, (n_cells, n_strips, 1 or 3)."""
        pressures = self.cells.pressures[..., None]
        if self.tractions is None:
            return pressures
        return np.concatenate((pressures, self.tractions * (1.0 if role == "wheel" else -1.0)), axis=2)


def rolling_contact_of(
    patch: WheelPatch, friction: Friction, origin: tuple[float, float] | None = None
) -> RollingContact:
    """Cells of a patch, to roll on the real bodies.

    Parameters
    ----------
    patch
        Patch of a wheelset in equilibrium.
    friction
        Coefficients of friction; several are those of the cells of the whole side, one for each row.
    origin
        Place that creepages and moments are of: length along the rail's elastic surface, and z; left out: the centre
        of pressure.

    Returns
    -------
    RollingContact
        The smallest box of rows and strips about the patch, with the pressures of this patch only. Bodies of different
        materials find their pressures anew with friction, at the same resultant.

    """
    state = patch.state
    normal, inside = state.forces, patch.inside
    rail, wheel = state.grid.surfaces.materials
    if rail == wheel:
        return contact_in(state, normal, inside, friction, origin)
    contact = contact_in(state, normal, inside, friction, origin, whole=True)
    rows = rows_of(state, contact)
    box = rows, strips_of(state, contact)
    influence = Convolution(np.ascontiguousarray(contact.coefficients[: contact.grid.n_strips, 1::3, 1::3]))
    undeformed = state.gaps[box] - influence(contact.normal_forces)
    undeformed[(normal > 0.0)[box] & ~inside[box]] = FAR_MM
    force = contact.normal_forces.sum(axis=1) @ state.normals[rows]
    total = float(np.linalg.norm(force))
    share = (state.normals[rows] @ force / total)[:, None]
    return replace(contact, pressed=Pressing(influence, undeformed, share, total))


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
