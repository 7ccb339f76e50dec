"""A wheelset on two rails in three dimensions: its contact at a position, and its equilibrium."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.railway.rigid.rigid_equilibrium import RigidStart, rigid_start
from flangeway.railway.rigid.rigid_geometry import CLIMBED_MM, RigidGeometry
from flangeway.railway.track.placements import SIDES, RigidTrack, RigidWheelPair, Side, WheelsetPosition
from flangeway.railway.track.rolling import RollingMotion, on_gauge_face
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import MAX_STEP, MAX_WAY, Equilibrium
from flangeway.railway.wheelset.fine_cells import divided, finer
from flangeway.railway.wheelset.rolling.wheelset_creep import rates_of
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, SideSurfaces, wheel_gap
from flangeway.railway.wheelset.side_newton import solve_side, transferred, transferred_creep
from flangeway.railway.wheelset.wheelset_newton import (
    FINE_RESIDUAL,
    MAX_TIME,
    RollingPlace,
    SpatialState,
    WheelsetNewton,
    bending_by_load,
    bending_of,
    pose_of,
)
from flangeway.solve import Status
from flangeway.types import Floats

COARSE_MM, COARSE_STRIP_MM = 1.4, 3.0
"""Cells of the whole running surfaces; the contact at a flange root jumps between wider ones."""
CLOSED_MM = 1.0
"""Gap of the rigid wheel within which strips may come into contact."""
STRIP_STEP = 3
"""Strips from one to the next at which these gaps are looked at."""
FAR_APART_MM = 12.0
"""Gap of the rigid wheel beyond which its surface is too far from the rail's to come into contact."""
COARSE_RESIDUAL = 1e-3
PRESSED_MM = 0.1
"""Depth below the rigid position, beyond what the rails sink, at which the search begins."""
MAX_ITERATIONS = 120
"""Newton steps until the equilibrium."""
FAST_RESIDUAL = 1e-7
"""Equilibrium residual with friction by fast theories, whose forces are not smooth."""
LIFTED_RESIDUAL, MIN_CARRIED, TORQUE, YAW_MOMENT = 0.1, 1e-3, 3, 4
"""Vertical or moment residual of wheels that do not carry the load, or torque of those that spin; share of the load
that a wheel carries at least; numbers of torque and yaw moment in residuals."""
MAX_STEPS_ON_CELLS = 2.5
"""Way relative to the step limits within which cells still fit."""
CELL_REACH = 0.3, MAX_STEPS_ON_CELLS * float(MAX_STEP[0])
"""Gap within which a wheel on the way to its equilibrium may come into contact on these cells, after their longest way
across the track."""
GRID_RESIDUAL = 1e-3
"""Residual at which the cells are chosen."""
COARSER_ACROSS, NESTED_RESIDUAL = 0.35, 2e-3
"""Cells across a patch relative to the final ones while creep forces are sought, and the residual on them."""
MAX_GRIDS = 6
"""Fine grids that are made near the equilibrium, also to add patches outside of them."""
MAX_HANGING = 30
"""Steps in a row in which a wheel on the way to a lateral position may touch nothing."""
MAX_SHIFTED_STEPS, SHORT_STEP_MM = 10, 0.01
"""Steps on cells that are shifted, at most, and a lateral one that is short."""
MAX_TURN_RAD = 0.05
"""Yaw beyond that of the guidance where the search for it ends; wheelsets in the sharpest curves run at half of it."""
MAX_RIGID = 64
"""Rigid geometries and equilibria of the last positions that stay in memory."""
SEARCHED_MM = 90.0
"""Distance along the track from the wheel's middle up to which it may touch without yaw."""
FLANGE_SLOPE = 3.0
"""Slope of the flange, by which yaw moves its contact along the track."""


OUTSIDE_CELLS = (
    "wheel and rail touch outside of the cells that are fine enough for their patches; give more patch_cells"
)
AT_SURFACE_END = "a contact reaches the end of the running surface; check the profiles and the load"


@dataclass(frozen=True, eq=False)
class SpatialWheelset:
    """A wheelset whose running surfaces are ready: each further position needs only its contact.

    - `surfaces`: of each side.
    """

    problem: WheelsetProblem
    surfaces: Mapping[Side, SideSurfaces]

    def at(self, problem: WheelsetProblem) -> "SpatialWheelset":
        """The same bodies under another load, elsewhere, rolling in another way."""
        return replace(self, problem=problem)

    @property
    def geometry(self) -> RigidGeometry:
        """Rigid geometry of the wheelset on its track."""
        track, wheels = self.problem.track, self.problem.wheels
        # files of one name may have changed: profiles count as they were read
        profiles = (*track.rails.values(), *wheels.profiles.values())
        return _rigid_geometry(track, wheels, self.problem.position.yaw_rad, profiles)

    @property
    def start(self) -> RigidStart:
        """Rigid equilibrium."""
        return _rigid_start(self.problem, self.geometry)

    def solve(
        self, progress: Callable[[str], None] = lambda _: None, near: RollingPlace | None = None
    ) -> Equilibrium[SpatialState]:
        """Find the equilibrium, first on coarse cells over the whole running surfaces, then on fine ones.

        With friction from the equilibrium without on coarse cells, first on fewer fine cells: on coarse ones creep
        forces jump with each cell that comes into contact.

        - `near`: place close to the equilibrium, from which the search begins instead.
        """
        if near is not None and near.rate_rad_s and self.problem.friction is not None:
            return self._rolling(near, self._touching(near), progress)
        risen = float(self._bending_by_load[::2].mean())
        start = self.start.motion.moved(WheelsetPosition(vertical_mm=-PRESSED_MM - self._sinking - risen))
        start = start if near is None else near.position
        kept = None, *self.problem.position.components[1:]  # the wheelset is moved to a lateral position
        position = WheelsetPosition(*(a if b is None else b for a, b in zip(start.components, kept, strict=True)))
        grids = self.whole(position, None, {})
        place = RollingPlace.at(position, self._bending_by_load, (0.0, 0.0), self.problem.position.yaw_rad)
        newton = WheelsetNewton.of(self.problem, self.compliance, place, grids)
        if self.problem.friction is None:
            return self._search(newton, _Cells(self, position, ((self.problem.patch_cells, FINE_RESIDUAL),)), progress)
        free = self._search(newton, _Cells(self, position, ()), progress)
        rates, bending = rates_of(self.problem, free.state.sides), bending_of(free.state.sides)
        place = RollingPlace.at(free.position, bending, rates, self.problem.position.yaw_rad)
        return self._rolling(place, free.state, progress)

    def _rolling(
        self, place: RollingPlace, state: SpatialState, progress: Callable[[str], None]
    ) -> Equilibrium[SpatialState]:
        """Equilibrium with friction from a contact on coarse cells."""
        rolling, across = self.problem.friction, self.problem.patch_cells
        assert rolling is not None
        last = FINE_RESIDUAL if rolling.theory == "exact" else FAST_RESIDUAL
        stages = (round(COARSER_ACROSS * across), NESTED_RESIDUAL), (across, last)
        cells = _Cells(self, place.position, stages, state.sides)
        newton = WheelsetNewton.of(self.problem, self.compliance, place, cells.fine(state), state, rolls=True)
        return self._search(newton, cells, progress)

    def _touching(self, start: RollingPlace) -> SpatialState:
        """Contact without friction on coarse cells at a place."""
        grids, sides = self.whole(start.position, None, {}), dict[Side, SideState]()
        for side in SIDES:
            pose = pose_of(self.problem, start.position, side, start.yaw_rad, start.bending)
            sides[side] = solve_side(grids[side], pose)
        return SpatialState(sides)

    def whole(
        self, position: WheelsetPosition, near: SpatialState | None, before: Mapping[Side, GriddedSide]
    ) -> dict[Side, GriddedSide]:
        """Coarse cells of the whole running surfaces at a position; those before where they reach as far."""
        grids = {side: self._coarse(side, position, near) for side in SIDES}
        return grids | {side: grid for side, grid in before.items() if grid.grid.covers(grids[side].grid)}

    def _search(
        self, newton: WheelsetNewton, cells: "_Cells", progress: Callable[[str], None]
    ) -> Equilibrium[SpatialState]:
        """Equilibrium by `WheelsetNewton` from its cells, coarse ones of whole running surfaces or fine ones.

        Fine cells suffice for the patches, and hold all of them. Where a patch comes to the end of these, or the
        wheelset leaves the position that they are for, they are chosen by the contact on coarse cells.
        """
        begun = newton.place.position
        for iteration in range(MAX_ITERATIONS):
            linear = newton.linearised(cells.tolerance)
            error = linear.relative.equilibrium_residual
            progress(f"equilibrium residual {error:.1e} after {iteration} steps")
            newton, settled = linear.step(cells.tolerance)
            message = f"contact forces and load are in equilibrium to {error:.1e}"
            equilibrium = linear.equilibrium(newton, Status(settled, message, iteration))
            cells, grids, state = cells.after(equilibrium, at_end=newton.reaches_an_end)
            if cells.status is not None:
                return replace(equilibrium, status=cells.status)
            if grids != equilibrium.state.grids:
                newton = newton.on(grids, state)
                at_peaks = cells.at_peaks(newton.contact)
                if at_peaks != grids:
                    newton = newton.on(at_peaks, state)
            if self._is_off(newton, begun):
                break
        return replace(equilibrium, status=self._no_equilibrium_status(equilibrium, newton.motion))

    def lateral_uncertainty(self, equilibrium: Equilibrium[SpatialState]) -> float:
        """How far an equilibrium with friction moves across the track on cells shifted by half of their size, mm.

        Slip zones are as thin as a cell, so that creep forces change with the position of the edges of the patches in
        the cells; where the lateral force hardly depends on the lateral position, they balance at several positions.
        By Newton's steps on the other cells, until they are short: mostly the first one is.
        """
        place = RollingPlace.of(equilibrium)
        grids = {side: replace(grid, grid=grid.grid.staggered) for side, grid in equilibrium.state.grids.items()}
        newton = WheelsetNewton.of(self.problem, self.compliance, place, grids, equilibrium.state, rolls=True)
        newton = replace(newton, pace=newton.pace._replace(time=MAX_TIME))
        for _ in range(MAX_SHIFTED_STEPS):
            previous = newton.place.lateral_mm
            newton, _ = newton.linearised(FINE_RESIDUAL).step(FINE_RESIDUAL)
            if abs(newton.place.lateral_mm - previous) < SHORT_STEP_MM:
                break
        return abs(newton.place.lateral_mm - place.lateral_mm)

    def rise(self, position: WheelsetPosition) -> float:
        """How much higher the wheels are at a position than rigid in the middle of the track, mm."""
        return position.vertical_mm + float(self._bending_by_load[::2].mean()) - self._middle_mm

    @cached_property
    def _middle_mm(self) -> float:
        """Height of the rigid axle in the middle of the track."""
        geometry = self.geometry
        return float(geometry.located(geometry.touching(np.zeros(1), at_axle=True)).vertical_mm[0])

    def _is_off(self, newton: WheelsetNewton, begun: WheelsetPosition) -> bool:
        """Whether the wheelset has left the track, turns without end, or cannot come to its lateral position."""
        position = newton.place.position
        ways = np.abs(np.subtract(position.components, begun.components))
        ways[0] = abs(position.lateral_mm) - abs(begun.lateral_mm)  # it may go from one flange to the other
        lateral, *others = self.problem.position.components
        climbs = self.rise(position) > CLIMBED_MM or (others == [None, None] and newton.hanging > MAX_HANGING)
        turns = abs(newton.place.yaw_rad - self.problem.position.yaw_rad) > MAX_TURN_RAD
        stops = lateral is not None and (climbs or not self.start.can_reach(lateral))
        return turns or bool((ways > MAX_WAY).any()) or stops

    def _no_equilibrium_status(self, last: Equilibrium[SpatialState], motion: RollingMotion | None) -> Status:
        """No equilibrium: what is not balanced where the search ended, and what would hold it."""
        residuals, position = last.residuals, last.position
        free = np.array([*residuals.free, True, True])
        errors = np.abs([residuals.lateral_residual, residuals.vertical_residual, residuals.moment_residual,
                         residuals.torque_residual, residuals.yaw_residual]) * free  # fmt: skip
        force, torque_kNm = float(last.residual[0]), 0.0 if motion is None else abs(motion.torque_kNm)
        location = f"where the search ended, {abs(position.lateral_mm):.1f} mm to the {_way(position.lateral_mm)}"
        remedy = "a smaller lateral force, or friction"
        if motion is not None:
            unguided = motion.yaw_is_free and not motion.yaw_stiffness
            remedy = f"{'a yaw stiffness' if unguided else 'a smaller yaw'}, or less friction"
        if residuals.free[0]:
            advice = f"give lateral_mm to see the forces at a position, {remedy}"
        else:
            advice = "give a lateral_mm nearer to the middle of the track"
            advice += "" if motion is None else f", {remedy}"
        turned = 0.0 if last.state.rolled is None else last.state.rolled.yaw_rad - self.problem.position.yaw_rad
        carried = min(float(side_state.forces.sum()) for side_state in last.state.sides.values())
        lifted = carried < MIN_CARRIED * self.problem.forces.in_track[1] or self.rise(position) > CLIMBED_MM
        lifted = lifted or any(_is_on_flange(side_state) for side_state in last.state.sides.values())
        if lifted or errors[1:3].max() > LIFTED_RESIDUAL:
            cause = location + ", a wheel no longer carries its load: it lifts, or climbs its rail (derailment)"
        elif torque_kNm and (errors.argmax() == TORQUE or errors[TORQUE] > LIFTED_RESIDUAL):
            unit = 1e-6 * self.problem.forces.in_track[1] * self.problem.wheels.tape_radius_mm
            missing = unit * abs(residuals.torque_residual)
            cause = f"friction does not transmit the torque: {missing:.3g} of {torque_kNm:.3g} kN m are left"
            advice = "give a smaller torque, or more friction"
        elif errors.argmax() == YAW_MOMENT or abs(turned) > MAX_TURN_RAD:
            arm = self.problem.wheels.distance_mm / 2.0
            missing = 1e-6 * abs(residuals.yaw_residual) * self.problem.forces.vertical_N * arm
            turn = f"turned by {1e3 * abs(turned):.0f} mrad"
            cause = f"{location} and {turn}, a yaw moment of {missing:.1f} kN m is not balanced"
            advice = "give the yaw, or a yaw stiffness that holds it"
        elif errors.argmax() == 0:
            cause = f"{location}, a lateral force of {0.001 * abs(force):.1f} kN to the {_way(force)} is not balanced"
            if force * position.lateral_mm > 0.0:
                cause += f", which pushes the {_way(force)} flange up its rail"
        else:
            cause = location + ", the forces still change from step to step"
            advice = "give a neighbouring lateral_mm, yaw, torque or friction"
        kind = "no equilibrium" if motion is None else "no equilibrium with friction"
        message = f"{kind} in {last.status.iterations} steps: {cause}; {advice}"
        return Status(False, message, last.status.iterations)

    def beyond(
        self, equilibrium: Equilibrium[SpatialState], touching: Mapping[Side, SideState]
    ) -> dict[Side, SideState]:
        """Contact on coarse cells of the sides where wheel and rail overlap outside of the fine cells.

        The forces of the fine cells stay: a contact anew on coarse cells would carry more.

        - `touching`: contact on coarse cells before, whose cells serve where they reach as far.
        """
        sides: dict[Side, SideState] = {}
        grids = self.whole(
            equilibrium.position, equilibrium.state, {side: side_state.grid for side, side_state in touching.items()}
        )
        for side, fine in equilibrium.state.sides.items():
            whole, inner = grids[side], fine.grid.grid
            forces, creep = transferred(fine, whole), transferred_creep(fine, whole)
            deformed = whole.deformed(fine.pose, forces, creep[:, 0])
            cells, z, strip = whole.grid.cells, whole.grid.along, whole.grid.strip
            across = (cells[:, :1] < inner.cells[:, 1]) & (cells[:, 1:] > inner.cells[:, 0])
            along = (z > inner.along[0] - strip) & (z < inner.along[-1] + strip)
            gaps = deformed[3] + whole.influence(forces)
            overlap = np.where(np.outer(across.any(axis=1), along), 0.0, np.maximum(-gaps, 0.0))
            if overlap.any():
                forces = forces + overlap / whole.coefficients[0].diagonal()[:, None]
                sides[side] = SideState(whole, fine.pose, forces, *deformed[:3], gaps, creep)
        return sides

    @cached_property
    def _sinking(self) -> float:
        """Displacement of the rails under the vertical load, at the middle of their heads, mm."""
        compliance = [
            float(side.rail_elastic.remainder[0, :, 1, :, 1].diagonal().min()) for side in self.surfaces.values()
        ]
        return min(compliance) * self.problem.forces.in_track[1] / 2.0

    @cached_property
    def compliance(self) -> Floats:
        """Compliance of the axle at its seats, see `ElasticAxle.compliance`, (4, 4)."""
        wheels = self.problem.wheels
        return self.problem.wheelset.axle.compliance(
            np.array([wheels.placement(side).translation[0] for side in SIDES])
        )

    @cached_property
    def _bending_by_load(self) -> Floats:
        """Deflection and tilt of both seats by the vertical load, (4,)."""
        return bending_by_load(self.problem, self.compliance)

    def _coarse(self, side: Side, position: WheelsetPosition, near: SpatialState | None) -> GriddedSide:
        """Cells of a whole running surface at a position; `near`: contact there, if it is known."""
        cell, strip, yaw = COARSE_MM, COARSE_STRIP_MM, self.problem.position.yaw_rad
        if near is not None and near.rolled is not None:
            yaw = near.rolled.yaw_rad
        bending = self._bending_by_load if near is None else bending_of(near.sides)
        surfaces, pose = self.surfaces[side], pose_of(self.problem, position, side, yaw, bending)
        # the rail's head has moved away
        motion = np.array([0.0, -self._sinking])
        if near is not None:
            state = near.sides[side]
            motion = state.grid.rail_motion(state.forces, state.creep[:, 0])[0]
        pose = replace(pose, x=pose.x - motion[0], y=pose.y - motion[1])
        low, high = np.sort(surfaces.rail_stations[[0, -1], 1])
        ends: Floats = cell * np.arange(int(np.ceil(low / cell)), int(np.floor(high / cell)) + 1.0)
        # yaw moves the wheel along the track, and contact on the flange further
        lead = float(pose.axis[2]) * pose.seat_mm
        reach = SEARCHED_MM + FLANGE_SLOPE * abs(pose.yaw_rad) * self.problem.wheels.tip_radius_mm
        searched = np.arange(int((lead - reach) / strip), int((lead + reach) / strip) + 1)
        searched = searched[::STRIP_STEP]
        z = strip * searched.astype(np.float64)
        points, normals = surfaces.rail_points((ends[1:] + ends[:-1]) / 2.0)
        gaps = wheel_gap(surfaces.wheel, pose.middle, pose.axis, points, normals, z).gaps
        rows = np.flatnonzero(gaps.min(axis=1) < FAR_APART_MM)
        if len(rows):
            ends = ends[rows[0] : rows[-1] + 2]
        planes = searched[gaps.min(axis=0) < CLOSED_MM]
        if len(planes) == 0:
            planes = int(lead / strip) + np.arange(-5, 6)
        grid = PatchGrid.on_planes(ends, strip, int(planes[0]) - STRIP_STEP + 1, int(planes[-1]) + STRIP_STEP - 1)
        return GriddedSide(surfaces, grid, pose)


@lru_cache(maxsize=MAX_RIGID)
def _rigid_geometry(track: RigidTrack, wheels: RigidWheelPair, yaw_rad: float, _profiles: object) -> RigidGeometry:
    return RigidGeometry.of(track, wheels, yaw_rad)


@lru_cache(maxsize=MAX_RIGID)
def _rigid_start(problem: WheelsetProblem, geometry: RigidGeometry) -> RigidStart:
    return rigid_start(problem, geometry)


@dataclass(frozen=True, eq=False)
class _Cells:
    """Cells of a search, a value.

    - `place`: position that they are for.
    - `stages`: cells across a patch, and the equilibrium residual; forces and tilts are found to the same share of
      theirs. Near the equilibrium of the last stage cells are chosen by their own contact.
    - `stage`: number of the current one.
    - `touching`: contact on coarse cells by which fine ones were chosen; empty on coarse cells.
    - `n_grids`: fine grids near the equilibrium; `last`: whether these do for it.
    - `status`: how the search ends.
    """

    wheelset: SpatialWheelset
    place: WheelsetPosition
    stages: Sequence[tuple[int, float]]
    touching: Mapping[Side, SideState] = field(default_factory=dict)
    stage: int = 0
    n_grids: int = 1
    last: bool = False
    status: Status | None = None

    @property
    def is_last(self) -> bool:
        """Whether these are cells of the last stage."""
        return bool(self.touching) and self.stage == len(self.stages) - 1

    @property
    def tolerance(self) -> float:
        """Equilibrium residual that is wanted on these cells."""
        if not self.touching:
            return COARSE_RESIDUAL
        wanted = self.stages[self.stage][1]
        return wanted if self.last else max(GRID_RESIDUAL, wanted)

    def after(self, equilibrium: Equilibrium[SpatialState], *, at_end: bool) -> "Placed":
        """Cells after a step, and a contact to start from on them; those of `equilibrium` where they stay.

        - `at_end`: whether a patch has come to an end of its cells.
        """
        settled, state, cells = equilibrium.status.converged, equilibrium.state, self
        far = _is_far(equilibrium.position, self.place)
        if far or (at_end if self.touching else settled):
            cells = replace(self, place=equilibrium.position)
            grids = self.wheelset.whole(cells.place, state, {} if self.touching else state.grids)
            if self.touching:
                return cells._anew(grids, state, far=far)
            if grids != state.grids:
                return cells, grids, state
        return cells._refined(equilibrium) if settled else (cells, state.grids, state)

    def _anew(self, whole: Mapping[Side, GriddedSide], state: SpatialState, *, far: bool) -> "Placed":
        """Fine cells by the contact on coarse ones at the same poses, with the same creep forces.

        Where the wheelset is not far from the place of its cells, a patch that came to their end has wider ones about
        itself: coarse cells may end at the same place again.
        """
        touching = {
            side: solve_side(
                whole[side], one.pose, transferred(one, whole[side]), creep=transferred_creep(one, whole[side])
            )
            for side, one in state.sides.items()
        }
        cells, near = replace(self, touching=touching, last=False), SpatialState(touching) if far else state
        return cells, cells.fine(near, CELL_REACH), near

    def _refined(self, equilibrium: Equilibrium[SpatialState]) -> "Placed":
        """Cells of the next stage, or better ones for the equilibrium of the last one."""
        state, grids, cells, status = equilibrium.state, equilibrium.state.grids, self, equilibrium.status
        if not self.stages:
            return replace(self, status=status), grids, state
        if not self.is_last:
            cells = replace(self, stage=self.stage + bool(self.touching), touching=self.touching or state.sides)
            return cells, cells.fine(state), state
        if more := self.n_grids < MAX_GRIDS:
            cells, grids = replace(self, n_grids=self.n_grids + 1), self.fine(state)
        if grids != state.grids or not self.last:
            return replace(cells, last=grids == state.grids or self.last), grids, state
        if beyond := self.wheelset.beyond(equilibrium, self.touching):
            if not more:
                return replace(cells, status=Status(False, OUTSIDE_CELLS, status.iterations)), grids, state
            cells, near = replace(cells, touching={**self.touching, **beyond}), SpatialState({**state.sides, **beyond})
            if (wider := cells.fine(near)) != grids:
                return cells, wider, near
        if any(one.grid.leaves(one.forces) for one in state.sides.values()):
            status = Status(False, AT_SURFACE_END, status.iterations)
        return replace(cells, status=status), grids, state

    def at_peaks(self, state: SpatialState) -> dict[Side, GriddedSide]:
        """Cells of the last stage divided at narrow peaks of the pressure, which coarser ones do not show."""
        if not self.is_last:
            return state.grids
        return {side: divided(side_state, self.stages[-1][0]) for side, side_state in state.sides.items()}

    def fine(self, state: SpatialState, near: tuple[float, float] = (0.0, 0.0)) -> dict[Side, GriddedSide]:
        """Fine cells of both sides for a contact, see `finer`."""
        across = self.stages[self.stage][0]
        sides = state.sides.items()
        return {side: finer(one, across, state.interiors(side), self.touching[side], near) for side, one in sides}


Placed: TypeAlias = tuple[_Cells, dict[Side, GriddedSide], SpatialState]
"""Cells of a search, those of both sides, and a contact to start from on them."""


def _is_far(position: WheelsetPosition, other: WheelsetPosition) -> bool:
    """Whether cells that are for a place do not fit at a position."""
    return bool((np.abs(np.subtract(position.components, other.components)) > MAX_STEPS_ON_CELLS * MAX_STEP).any())


def _is_on_flange(state: SideState) -> bool:
    """Whether a wheel touches its rail with the flange alone."""
    steep = on_gauge_face(state.normals[state.forces.any(axis=1)])
    return len(steep) > 0 and bool(steep.all())


def _way(lateral: float) -> str:
    return "right" if lateral >= 0.0 else "left"
