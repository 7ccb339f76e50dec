"""The wheelset in three dimensions: what ``flangeway reproduce wheelset3d`` computes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.contact.patch.normal_contact import ElasticSurface
from flangeway.contact.patch.patch_contact import SpatialPatch
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, Track, WheelPair, WheelsetPosition
from flangeway.railway.track.supports import Fixed, RigidAxle
from flangeway.railway.track.wheelset_loads import Curve, Load
from flangeway.railway.track.wheelset_problem import Mesh, Method, Plane, YieldingSteel
from flangeway.railway.wheelset.fine_cells import finer
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, SideSurfaces, wheel_gap
from flangeway.railway.wheelset.side_newton import solve_side, stiffness_of
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import spatial_patch
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.railway.wheelset.wheelset_newton import pose_of
from flangeway.types import Floats
from flangeway_studies.patches import pressed_profiles, profile_numbers
from flangeway_studies.study import Limit, Row, Run, percent, published_rows

# --- One wheel pressed on its rail in a given position, by the means of the wheelset in three dimensions.


FORCE_TOLERANCE = 1e-8
"""Error of the vertical force over the force."""
FIRST_MM = 0.02
"""Distance below the first touch at which the search begins."""
MAX_STEPS = 60
REACH_MM, CELL_MM = (16.0, 12.0), 1.0
"""Half width and half length about the first touch of the first grid, and its cells."""
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
    def patches(self) -> list[SpatialPatch]:
        """Separate patches, by falling force."""
        return self.state.cells.patches()

    @property
    def normal_force(self) -> float:
        """Resultant of the pressures in N."""
        return np.hypot(*self.state.resultant[:2])

    @property
    def tape_mm(self) -> float:
        """Distance of the tape line from the middle of the axle."""
        wheels = self.wheelset.problem.wheels
        return wheels.distance_mm / 2.0 + wheels.wheel_of(self.side).flange_back_mm

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
    surfaces, lift = wheelset.surfaces[side], touch.lift[0, 0] - wheelset.problem.wheels.tape_radius_mm
    position = WheelsetPosition(lateral_mm, lift - FIRST_MM, roll_rad)
    # the yaw moves the wheel along the track
    along = touch.x[0, 0] * pose_of(wheelset.problem, position, side, wheelset.problem.position.yaw_rad).axis[2]
    first, last = np.round((along + np.array([-1.0, 1.0]) * REACH_MM[1]) / CELL_MM).astype(int).tolist()
    low, high = np.sort(surfaces.rail_stations[[0, -1], 1])
    ends: Floats = np.arange(low, high, CELL_MM)
    ends = ends[np.abs(surfaces.rail_points(ends)[0][:, 0] - touch.x[0, 0]) < REACH_MM[0]]
    cells = PatchGrid.on_planes(ends, CELL_MM, first, last - 1)
    grid = GriddedSide(surfaces, cells, pose_of(wheelset.problem, position, side, wheelset.problem.position.yaw_rad))
    while True:
        position, state = _pressed(wheelset, side, grid, position, force)
        new = finer(state)
        if new is grid:
            return PressedWheel(wheelset, side, position, state)
        grid = new


def on_square_cells(pressed: PressedWheel, cell_mm: float) -> PressedWheel:
    """Press the same wheel on even square cells."""
    old, grid = pressed.state.grid, pressed.state.grid.grid
    first, last = np.floor(grid.bounds[0] / cell_mm), np.ceil(grid.bounds[-1] / cell_mm)
    ends: Floats = cell_mm * np.arange(first, last + 1.0)
    planes = int(np.floor(grid.along[0] / cell_mm)), int(np.ceil(grid.along[-1] / cell_mm))
    cells = PatchGrid.on_planes(ends, cell_mm, *planes)
    force = float(pressed.state.resultant[1])
    position, state = _pressed(
        pressed.wheelset, pressed.side, GriddedSide(old.surfaces, cells, old.pose), pressed.position, force
    )
    return PressedWheel(pressed.wheelset, pressed.side, position, state)


def _pressed(
    wheelset: SpatialWheelset, side: Side, grid: GriddedSide, position: WheelsetPosition, force: float
) -> tuple[WheelsetPosition, SideState]:
    """Position and contact on a grid, by Newton's method."""
    forces: Floats | float = 0.0
    for _ in range(MAX_STEPS):
        pose = pose_of(wheelset.problem, position, side, wheelset.problem.position.yaw_rad)
        state = solve_side(grid, pose, forces)
        missing = force - state.resultant[1]
        if abs(missing) <= FORCE_TOLERANCE * force:
            return position, state
        touches = bool(state.forces.any())
        forces = state.forces
        step = missing / stiffness_of(state)[1, 1] if touches else -FIRST_MM
        position = position.moved(WheelsetPosition(0.0, step))
    raise InputError(
        f"a force of {force:g} N on the {side} wheel at {position.lateral_mm:g} mm and {position.roll_rad:g} rad",
        "a force that contact can carry there",
        "give another position",
    )


# --- Tangent and curve by finite and virtual elements of both orders, and patches beside those of a fine direct mesh.


SITUATIONS = {
    "tangent": Load(),
    "curve": Load(curve=Curve(radius_m=500.0, speed_km_h=80.0, superelevation_mm=60.0)),
}
METHODS: tuple[tuple[Method, int], ...] = (("fem", 2), ("vem", 2), ("fem", 1), ("vem", 1))
"""The first is the reference of the others."""
FORCE_LIMIT, PRESSURE_LIMIT = 1e-3, 0.01


def method_rows(run: Run) -> Iterator[Row]:
    """Forces and pressures of both situations by each kind of elements beside those of the first; order 2 if quick."""
    base: dict[str, SpatialResult] = {}
    for method, order in METHODS[: 2 if run.quick else None]:
        code = f"{method} {order}"
        mesh = Mesh(method=method, order=order)
        run.progress(code)
        surfaces = running_surfaces(Wheelset(mesh=mesh), progress=run.progress)
        for name, load in SITUATIONS.items():
            result = solve_position(SpatialWheelset(Wheelset(load=load, mesh=mesh), surfaces), {})
            run.check(f"{name}, {code}", result.status)
            if (method, order) == METHODS[0]:
                base[name] = result
            else:
                yield from _beside(name, code, base[name], result)


def _beside(table: str, code: str, base: SpatialResult, result: SpatialResult) -> Iterator[Row]:
    for side in SIDES:
        known, forces = (result.force_on_wheel_N(side) for result in (base, result))
        allowed = FORCE_LIMIT * np.hypot(*known)
        for name, wanted, value in zip(("lateral", "vertical"), known.tolist(), forces.tolist(), strict=True):
            limit = Limit(f"{percent(FORCE_LIMIT)} of the contact force", abs(value - wanted) <= allowed)
            yield Row(table, code, f"{name} force, {side} wheel", "N", value, wanted, limit)
        known_patches, patches = ([patch for patch in one.patches if patch.side == side] for one in (base, result))
        for known_patch, patch in zip(known_patches, patches, strict=True):
            name = f"maximum pressure, {side} wheel, {known_patch.region}"
            value, wanted = patch.max_pressure, known_patch.max_pressure
            yield Row(table, code, name, "MPa", value, wanted, PRESSURE_LIMIT)


@dataclass(frozen=True)
class DirectMesh:
    """A wheel on a rail: track, wheels, the vertical force in N, and cells and window of the direct mesh in mm."""

    track: Track
    wheels: WheelPair
    force: float
    cell: float
    window: tuple[float, float]


DIRECT = {
    "AAR-1B on 136RE": DirectMesh(
        Track(rail="136RE", gauge_mm=1600.0, gauge_at="narrowest", support=Fixed()),
        WheelPair(wheel="AAR-1B", radius_mm=500.0, radius_at="flange-tip", axle=RigidAxle()),
        force=150e3,
        cell=0.4,
        window=(15.0, 22.0),
    ),
    "S1002 on 60E1": DirectMesh(
        Track(rail="60E1", gauge_at="narrowest", support=Fixed()),
        WheelPair(wheel="S1002", axle=RigidAxle()),
        force=100e3,
        cell=0.4,
        window=(30.0, 17.0),
    ),
}
DIRECT_LIMIT = 5e-3


def direct_numbers(name: str) -> Iterator[Row]:
    """Maximum pressure and semi-axes of a tabulated compliance beside those of a mesh that is fine in the patch."""
    given = DIRECT[name]
    wheelset = Wheelset(track=given.track, wheelset=given.wheels, load=Load(axle_load_kN=2e-3 * given.force))
    fine = Wheelset(
        track=given.track.replaced(support="sleepers"),
        wheelset=given.wheels.replaced(axle="elastic"),
        load=wheelset.load,
        contact=Plane(contact_size_mm=given.cell / 2.0, body_size_mm=12.0),
        mesh=Mesh(order=1),
    )
    model = build_model(fine)
    (direct,) = spatial_patch(model, "right", given.force, cell_mm=given.cell, window_mm=given.window).patches
    (patch,) = pressed_wheel(SpatialWheelset(wheelset, running_surfaces(wheelset)), "right", given.force).patches
    for (quantity, unit, known), (_, _, value) in zip(_measures(direct), _measures(patch), strict=True):
        yield Row(name, f"{given.force / 1e3:g} kN", quantity, unit, value, known, DIRECT_LIMIT)


def _measures(patch: SpatialPatch) -> tuple[tuple[str, str, float], ...]:
    longer, shorter = patch.semi_axes
    return (
        ("maximum pressure", "MPa", patch.max_pressure),
        ("longer semi-axis", "mm", longer),
        ("shorter semi-axis", "mm", shorter),
    )


# --- The Manchester contact benchmark, case, left wheel: S1002 on UIC60 in 21 positions, beside CONTACT.


FORCE = 10e3
CASE = Wheelset(
    track=Track(rail="60E1", gauge_mm=1435.0, gauge_depth_mm=14.0, support=Fixed()),
    wheelset=WheelPair(wheel="S1002", back_to_back_mm=1360.0, radius_mm=460.0, axle=RigidAxle()),
    load=Load(axle_load_kN=2e-3 * FORCE),
    material=YieldingSteel(young_MPa=2.0 * 82e3 * 1.28, poisson=0.28),
)
"""Rails fixed along their bases, and a rigid axle."""
TABLE = "Manchester A-2.2"
MANCHESTER_PRESSURE_LIMIT, MANCHESTER_FORCE_LIMIT, POSITION_LIMIT_MM = 0.03, 0.01, 0.3
STEEPEST_RAD = 0.3
"""Contact angle up to which numbers of half-spaces are a measure for real bodies."""
CENTRE = "CONTACT gives the centre of the squared overlap of the undeformed surfaces instead of that of the pressure"
STEEP = "steep or divided contact: half-spaces are no measure for it"


@dataclass(frozen=True, eq=False)
class BenchmarkPosition:
    """One position: as published, on the real bodies, and on half-spaces."""

    published: dict[str, float]
    real: PressedWheel
    half_spaces: PressedWheel

    @property
    def code(self) -> str:
        """Lateral position."""
        return f"y = {self.published['y']:g} mm"

    @property
    def comparable(self) -> bool:
        """Whether the contact is flat and in one piece."""
        return self.published["angle"] < STEEPEST_RAD and len(self.real.patches) == 1


def benchmark_positions(run: Run, *, every: int) -> Iterator[BenchmarkPosition]:
    """Press the left wheel in the positions, or every so many of them."""
    real = running_surfaces(CASE, progress=run.progress)
    half = {side: as_half_spaces(surfaces) for side, surfaces in real.items()}
    rows = published_rows("manchester_a22_left.csv")
    for row in rows[::every]:
        values = {name: float(value) for name, value in row.items()}
        run.progress(f"Manchester A-2.2, y = {values['y']:g} mm")
        # CONTACT's axes x ahead and z down: both angles have the opposite sign
        yawed = CASE.replaced(position={"yaw_mrad": -1e3 * values["yaw"]})
        pressed = [
            pressed_wheel(SpatialWheelset(yawed, surfaces), "left", FORCE, values["y"], -values["roll"])
            for surfaces in (real, half)
        ]
        yield BenchmarkPosition(values, *pressed)


def benchmark_numbers(position: BenchmarkPosition) -> Iterator[Row]:
    """Pressure, force, contact point and height of one position."""
    published, real, half = position.published, position.real, position.half_spaces
    limited = position.comparable
    note = "" if limited else STEEP
    p0 = published["p0"]
    for quantity, contact in (("maximum pressure", real), ("maximum pressure of half-spaces", half)):
        value = contact.patches[0].max_pressure
        yield Row(
            TABLE, position.code, quantity, "MPa", value, p0, MANCHESTER_PRESSURE_LIMIT if limited else None, note
        )
    value, limit = published["normal_force"], MANCHESTER_FORCE_LIMIT if limited else None
    yield Row(TABLE, position.code, "normal force", "N", real.normal_force, value, limit, note)
    # y to the right is to the gauge side of a left wheel
    for quantity, point in (
        ("contact point on the wheel", real.interpenetration_mm),
        ("centre of pressure on the wheel", real.centre_of_pressure_mm),
    ):
        shown = not limited or quantity.startswith("centre")
        near, why = (None, CENTRE) if shown else (f"{POSITION_LIMIT_MM:g} mm", "")
        yield Row(TABLE, position.code, quantity, "mm", -point, published["wheel_y"], near, why)


# --- The wheelset in three dimensions: what ``flangeway reproduce wheelset3d`` computes.


QUICK = 5  # every so many positions of the benchmark are computed if quick


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts; if quick, some positions of the benchmark, and elements of order 2 only."""
    points = []
    for position in benchmark_positions(run, every=QUICK if run.quick else 1):
        yield from benchmark_numbers(position)
        known = position.published
        points.append((known["y"], known["p0"], position.real.patches[0].max_pressure))
    y, published, computed = zip(*points, strict=True)
    run.curve("manchester", "S1002 on UIC60, left wheel, 10 kN", "CONTACT", y, published, "o")
    run.curve("manchester", "S1002 on UIC60, left wheel, 10 kN", "flangeway", y, computed)
    yield from method_rows(run)
    for name in DIRECT:
        run.progress(name)
        yield from direct_numbers(name)
    run.progress("one position beside CalculiX")
    yield from profile_numbers(pressed_profiles())
