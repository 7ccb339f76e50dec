"""One wheel pressed on its rail in a given position, by the means of the wheelset in three dimensions."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.contact.patch.elastic_surface import ElasticSurface
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.railway.track.placements import SIDE_SIGN, Side, WheelsetPosition
from flangeway.railway.wheelset.fine_cells import finer
from flangeway.railway.wheelset.running_surfaces import SpatialModel
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, SideSurfaces, wheel_gap
from flangeway.railway.wheelset.side_newton import solve_side
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_newton import pose_of
from flangeway.types import Floats

FORCE_TOLERANCE = 1e-8
"""Error of the vertical force over the force."""
FIRST_MM = 0.02
"""Distance below the first touch at which the search begins."""
MOST_STEPS = 60
REACH_MM, CELL_MM = (16.0, 12.0), 1.0
"""Half width and half length about the first touch of the first grid, and its cells."""
FIXED = SpatialModel(support=None, axle=None)
"""Rails fixed along their bases, and a rigid axle."""
SPACING_MM = 0.1
"""Distance of the points at which rigid surfaces are compared."""


@dataclass(frozen=True, eq=False)
class PressedWheel:
    """A wheel on its rail.

    - `wheelset`, `side`: which.
    - `position`: of the wheelset.
    - `state`: its contact.
    """

    wheelset: SpatialWheelset
    side: Side
    position: WheelsetPosition
    state: SideState

    @cached_property
    def patches(self) -> list[ContactEllipse]:
        """Separate patches, by falling force."""
        return self.state.cells.patches()

    @property
    def normal_force(self) -> float:
        """Resultant of the pressures in N."""
        return np.hypot(*self.state.resultant[:2])

    @property
    def tape_mm(self) -> float:
        """Distance of the tape line from the middle of the axle."""
        wheelset = self.wheelset.problem.wheelset
        return wheelset.back_to_back_mm / 2.0 + wheelset.wheel_of(self.side).flange_back_mm

    @property
    def centre_of_pressure_mm(self) -> float:
        """Position on the wheel, from its tape line to the field side."""
        forces = self.state.forces
        return ((forces * self.state.gap.along).sum() / forces.sum()) - self.tape_mm

    @cached_property
    def overlap(self) -> tuple[float, float, float]:
        """Centre of the squared overlap of the undeformed surfaces.

        Position along the axle, length along the rail's surface, and z.
        """
        surfaces, grid, pose = self.state.grid.surfaces, self.state.grid.grid, self.state.pose
        stations: Floats = np.arange(grid.bounds[0] - REACH_MM[0], grid.bounds[-1] + REACH_MM[0], SPACING_MM)
        z: Floats = np.arange(grid.along[0] - REACH_MM[1], grid.along[-1] + REACH_MM[1], SPACING_MM)
        gap = wheel_gap(surfaces.wheel, pose.middle, pose.axis, *surfaces.rail_points(stations), z)
        weights = np.maximum(-gap.gaps, 0.0) ** 2
        weights /= weights.sum()
        rows, strips = weights.sum(axis=1), weights.sum(axis=0)
        return (weights * gap.along).sum(), (rows @ stations), (strips @ z)

    @property
    def interpenetration_mm(self) -> float:
        """Centre of `overlap`, from the wheel's tape line to the field side."""
        return self.overlap[0] - self.tape_mm


def as_half_spaces(surfaces: SideSurfaces) -> SideSurfaces:
    """Return the surfaces on bodies that move as half-spaces do."""

    def bare(elastic: ElasticSurface) -> ElasticSurface:
        return replace(elastic, remainder=np.zeros_like(elastic.remainder))

    return replace(surfaces, wheel_elastic=bare(surfaces.wheel_elastic), rail_elastic=bare(surfaces.rail_elastic))


def pressed_wheel(
    wheelset: SpatialWheelset, side: Side, force: float, lateral_mm: float = 0.0, roll_rad: float = 0.0
) -> PressedWheel:
    """Press a wheel down by a vertical force, lateral position and roll of the wheelset held.

    An `InputError` if there is no such position.
    """
    sign = SIDE_SIGN[side]
    touch = wheelset.geometry.side(side).touches(np.array([sign * lateral_mm]), np.array([sign * roll_rad]))
    surfaces, lift = wheelset.surfaces[side], touch.lift[0, 0] - wheelset.problem.wheelset.tape_radius_mm
    position = WheelsetPosition(lateral_mm, lift - FIRST_MM, roll_rad)
    # the yaw moves the wheel along the track
    along = touch.x[0, 0] * pose_of(wheelset.problem, position, side, wheelset.model.yaw_rad).axis[2]
    first, last = np.round((along + np.array([-1.0, 1.0]) * REACH_MM[1]) / CELL_MM).astype(int).tolist()
    low, high = np.sort(surfaces.rail_stations[[0, -1], 1])
    ends: Floats = np.arange(low, high, CELL_MM)
    ends = ends[np.abs(surfaces.rail_points(ends)[0][:, 0] - touch.x[0, 0]) < REACH_MM[0]]
    cells = PatchGrid.on_planes(ends, CELL_MM, first, last - 1)
    grid = GriddedSide(surfaces, cells, pose_of(wheelset.problem, position, side, wheelset.model.yaw_rad))
    while True:
        position, state = _pressed(wheelset, side, grid, position, force)
        new = finer(state)
        if new is grid:
            return PressedWheel(wheelset, side, position, state)
        grid = new


def on_square_cells(found: PressedWheel, cell_mm: float) -> PressedWheel:
    """Press the same wheel on even square cells."""
    old, grid = found.state.grid, found.state.grid.grid
    first, last = np.floor(grid.bounds[0] / cell_mm), np.ceil(grid.bounds[-1] / cell_mm)
    ends: Floats = cell_mm * np.arange(first, last + 1.0)
    planes = int(np.floor(grid.along[0] / cell_mm)), int(np.ceil(grid.along[-1] / cell_mm))
    cells = PatchGrid.on_planes(ends, cell_mm, *planes)
    force = float(found.state.resultant[1])
    position, state = _pressed(
        found.wheelset, found.side, GriddedSide(old.surfaces, cells, old.pose), found.position, force
    )
    return PressedWheel(found.wheelset, found.side, position, state)


def _pressed(
    wheelset: SpatialWheelset, side: Side, grid: GriddedSide, position: WheelsetPosition, force: float
) -> tuple[WheelsetPosition, SideState]:
    """Position and contact on a grid, by Newton's method."""
    forces = None
    for _ in range(MOST_STEPS):
        state = solve_side(grid, pose_of(wheelset.problem, position, side, wheelset.model.yaw_rad), forces)
        missing = force - state.resultant[1]
        if abs(missing) <= FORCE_TOLERANCE * force:
            return position, state
        touches = bool(state.forces.any())
        forces = state.forces if touches else None
        step = missing / state.stiffness[1, 1] if touches else -FIRST_MM
        position = position.moved(WheelsetPosition(0.0, step))
    raise InputError(
        f"a force of {force:g} N on the {side} wheel at {position.lateral_mm:g} mm and {position.roll_rad:g} rad",
        "a force that contact can carry there",
        "give another position",
    )
