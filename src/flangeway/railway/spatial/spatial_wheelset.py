"""A wheelset on two rails in three dimensions: its contact at a position, and its equilibrium."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flangeway.errors import InputError
from flangeway.railway.rigid.elastic_start import RigidStart, rigid_start
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.spatial.rolling.rolling_motion import RollingMotion
from flangeway.railway.spatial.rolling.wheelset_creep import WheelsetCreep, rate_of
from flangeway.railway.spatial.running_surfaces import SpatialModel
from flangeway.railway.spatial.side_contact import GriddedSide, SideGrid, SideState, SideSurfaces
from flangeway.railway.spatial.side_newton import SideNewton, solve_side, transferred, transferred_creep
from flangeway.railway.spatial.spatial_contact import SpatialContact, SpatialState, pose_of, signs_of
from flangeway.railway.spatial.wheel_gap import wheel_gap
from flangeway.railway.spatial.wheelset_newton import COARSE_FORCES, FINE_RESIDUAL, WheelsetNewton
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium, search_equilibrium
from flangeway.railway.wheelset.residual import MAX_STEP
from flangeway.solve import Status
from flangeway.types import Bools, Floats

COARSE_MM = 1.4
"""Cells while the position is sought on the whole running surfaces."""
COARSE_STRIP_MM = 3.0
ROLLING_CELLS = 1.0
"""These with creep forces, which jump with the cells, over the same without."""
CLOSED_MM = 1.0
"""Gap of the rigid wheel within which strips may come into contact."""
EVERY = 3
"""Strips from one to the next at which these gaps are looked at."""
NEAR_MM = 12.0
"""Gap of the rigid wheel beyond which its surface is too far from the rail's to come into contact."""
COARSE_RESIDUAL = 1e-3
PRESSED_MM = 0.3
"""Depth below the rigid position at which the search begins."""
MOST_STEPS = 25
MOST_ROLLING_STEPS = 60
ROLLING_RESIDUAL, FAST_RESIDUAL, EXACT_RESIDUAL = 0.02, 1e-6, 1e-5
"""Equilibrium residual with friction: where another theory or other cells follow, which change it by as much, by fast
theories, and by the exact one, which is less sharp."""
LIFTED, TORQUE = 0.2, 3
"""Vertical or moment residual of wheels that do not carry the load; number of the torque among the residuals."""
LOST = 5.0
"""Equilibrium residual with friction on fine cells above which it will not be found."""
MAX_BENT_MM = (0.4, 0.1, 0.05)
"""Displacements of a cell by creep forces in one step, at most: smaller ones where the search for equilibrium fails."""
NEARBY, MOST_COARSE = 5.0, 12
"""Way over the step limits within which the coarse cells still fit, and the number of times they are made anew."""
ACROSS = 26
"""Cells across a patch, and along it."""
LEAST_ACROSS = 20
FEWER_ACROSS, NESTED_RESIDUAL = 13, 2e-3
"""The same while creep forces are sought, and their equilibrium residual by the exact theory: as much as cells do."""
MARGIN = 0.2
"""Width of the window beyond a patch on each side over the patch."""
LENGTHENED = 6.0
"""Longer side over shorter side of a cell, at most."""
MOST_GRIDS, MOST_COVERED = 4, 3
"""Fine grids that are made, and times that patches outside of them are added."""
SEARCHED_MM = 90.0
"""Distance along the track from the wheel's middle up to which it may touch without yaw."""
FLANGE_SLOPE = 3.0
"""Slope of the flange, by which yaw moves its contact along the track."""
LONGEST = 48
"""Strips along the longest patch, at most."""
MOST_ON_A_SIDE = 5000
"""Cells in the windows of a side, at most."""
MAIN = 0.05
"""Share of a side's force above which a patch has its cells counted."""


@dataclass(frozen=True, eq=False)
class SpatialWheelset:
    """A wheelset whose running surfaces are ready: each further position needs only its contact.

    - `surfaces`: of each side.
    - `model`: supports, axle and yaw.
    """

    problem: WheelsetProblem
    surfaces: Mapping[Side, SideSurfaces]
    model: SpatialModel
    _geometries: dict[float, RigidGeometry] = field(default_factory=dict, repr=False)

    def at(
        self, load: WheelsetLoad, prescribed: Prescribed, yaw_rad: float, rolling: RollingMotion | None = None
    ) -> "SpatialWheelset":
        """The same bodies under another load, elsewhere, rolling in another way; rigid geometries are shared."""
        problem = replace(self.problem, load=load, prescribed=prescribed)
        return replace(self, problem=problem, model=replace(self.model, yaw_rad=yaw_rad, rolling=rolling))

    @property
    def geometry(self) -> RigidGeometry:
        """Rigid geometry of the wheelset on its track."""
        yaw = self.model.yaw_rad
        if yaw not in self._geometries:
            self._geometries[yaw] = RigidGeometry.of(self.problem.track, self.problem.wheelset, yaw)
        return self._geometries[yaw]

    @cached_property
    def start(self) -> RigidStart:
        """Rigid equilibrium."""
        return rigid_start(self.problem, self.geometry)

    def solve(self, progress: Callable[[str], None] = lambda _: None) -> Equilibrium[SpatialState]:
        """Find the equilibrium, first on coarse cells over the whole running surfaces, then on fine ones."""
        found = None
        half = self.problem.load.in_track[1] / 2.0
        tilts = self._tilts({side: half * np.array([0.0, 1.0, self._seat(side)]) for side in SIDES})
        for start in self.start.starts:
            grids = {side: self._coarse(side, start) for side in SIDES}
            contact = SpatialContact(self.problem, self.start, grids, self.model.yaw_rad, tilts, COARSE_FORCES)
            found = self._pressed(contact, start, progress)
            if found is None or found.stable is False:
                found = search_equilibrium(contact, progress, start, tolerance=COARSE_RESIDUAL, enough=COARSE_RESIDUAL)
                if found.status.converged:
                    found = self._refined(contact, found.position, found.state, progress, COARSE_RESIDUAL) or found
            if found.status.converged and found.stable is not False:
                break
        assert found is not None
        if self.model.rolling is not None:
            return self._with_friction(self.model.rolling, found, progress)
        found = self._fine(found, progress)
        beyond = self._beyond(grids, found) if found.status.converged else None
        return found if beyond is None else self._fine(replace(found, state=beyond), progress)

    def _with_friction(
        self, motion: RollingMotion, found: Equilibrium[SpatialState], progress: Callable[[str], None]
    ) -> Equilibrium[SpatialState]:
        """Equilibrium with creep forces from where the search without friction ended."""
        if not found.status.converged and self.problem.prescribed.lateral_mm is None:
            # creep forces may hold what nothing holds without them
            prescribed = replace(self.problem.prescribed, lateral_mm=found.position.lateral_mm)
            held = self.at(self.problem.load, prescribed, self.model.yaw_rad)
            with suppress(InputError):
                found = held.solve(progress)
        if not found.status.converged:
            advice = "give lateral_mm, a smaller yaw, or a load and speed that do not tip the wheelset over"
            cause = "no equilibrium without friction, from which that with creep forces is sought"
            return replace(found, status=Status(False, f"{cause}; {advice}", found.status.iterations))
        for max_bent_mm in MAX_BENT_MM:
            rolled = self._rolling(motion, found, progress, max_bent_mm)
            if rolled.status.converged:
                break
        return rolled

    def _rolling(
        self,
        motion: RollingMotion,
        found: Equilibrium[SpatialState],
        progress: Callable[[str], None],
        max_bent_mm: float,
    ) -> Equilibrium[SpatialState]:
        """Equilibrium with creep forces from one without friction: by a fast theory first, on coarse cells too."""
        theory = "fastsim" if motion.theory == "exact" else motion.theory
        creep = WheelsetCreep(motion, rate_of(motion, found.state.sides), theory, max_bent_mm)
        for _ in range(MOST_COARSE):
            yaw = self.model.yaw_rad if found.state.rolled is None else found.state.rolled.yaw_rad
            grids = {side: self._coarse(side, found.position, yaw) for side in SIDES}
            found = self._rolled(grids, found, progress, creep, ROLLING_RESIDUAL, NEARBY)
            if found.status.converged or found.status.iterations == MOST_ROLLING_STEPS:
                break
        if not found.status.converged:
            ended = found.status.iterations == MOST_ROLLING_STEPS
            return found if ended else replace(found, status=self._none(found, motion))
        stages = [(creep, FEWER_ACROSS, ROLLING_RESIDUAL)]
        if motion.theory == "exact":
            exact = replace(creep, theory="exact")
            stages += [(exact, FEWER_ACROSS, NESTED_RESIDUAL), (exact, ACROSS, EXACT_RESIDUAL)]
        else:
            stages.append((creep, ACROSS, FAST_RESIDUAL))
        for forces, across, tolerance in stages:
            forces.rate_rad_s = creep.rate_rad_s
            found = self._covered(grids, found, progress, forces, tolerance, across)
            creep = forces
            if not found.status.converged:
                break
        return found

    def _covered(
        self,
        grids: Mapping[Side, GriddedSide],
        found: Equilibrium[SpatialState],
        progress: Callable[[str], None],
        creep: WheelsetCreep,
        tolerance: float,
        across: int,
    ) -> Equilibrium[SpatialState]:
        """Equilibrium by `_fine` whose cells hold all patches; `grids`: coarse cells of the whole running surfaces."""
        for turn in range(MOST_COVERED):
            found = self._rolled(self._finer(found, across), found, progress, creep, tolerance, ends=False)
            found = self._fine(found, progress, creep, tolerance, across)
            beyond = self._beyond(grids, found) if found.status.converged and turn < MOST_COVERED - 1 else None
            if beyond is None:
                break
            found = replace(found, state=beyond)
        return found

    def _rolled(
        self,
        grids: Mapping[Side, GriddedSide],
        found: Equilibrium[SpatialState],
        progress: Callable[[str], None],
        creep: WheelsetCreep,
        tolerance: float,
        reach: float = np.inf,
        *,
        ends: bool = True,
    ) -> Equilibrium[SpatialState]:
        """Equilibrium with creep forces on given grids; see `_refined`."""
        tilts = self._tilts({side: state.resultant for side, state in found.state.sides.items()})
        contact = SpatialContact(self.problem, self.start, grids, self.model.yaw_rad, tilts)
        new = None
        with suppress(InputError, np.linalg.LinAlgError):  # forces without bounds, or wheels that have left the rails
            new = self._refined(
                contact, found.position, found.state, progress, tolerance, creep=creep, reach=reach, ends=ends
            )
        if new is not None and (new.status.converged or new.status.message):
            return new
        return replace(found, status=self._none(new or found, creep.motion))

    def _none(self, last: Equilibrium[SpatialState], motion: RollingMotion) -> Status:
        """No equilibrium with friction: what is not balanced where the search ended."""
        residuals, position = last.residuals, last.position
        free = np.array([*residuals.free, True, True])
        errors = np.abs([residuals.lateral_residual, residuals.vertical_residual, residuals.moment_residual,
                         residuals.torque_residual, residuals.yaw_residual]) * free  # fmt: skip
        force, torque_kNm = float(last.residual[0]), 1e-3 * abs(motion.torque_Nm)
        place = f"where the search ended, {abs(position.lateral_mm):.1f} mm to the {_way(position.lateral_mm)}"
        advice = "give a smaller yaw or less friction, or lateral_mm to see the forces at a position"
        if errors[:3].max() > LOST or errors[1:3].max() > LIFTED:
            cause = f"{place}, a wheel no longer carries its load: it lifts, or climbs its rail (derailment)"
        elif motion.torque_Nm and errors.argmax() == TORQUE:
            unit = 1e-6 * self.problem.load.in_track[1] * self.problem.wheelset.tape_radius_mm
            missing = unit * abs(residuals.torque_residual)
            cause = f"friction does not transmit the torque: {missing:.1f} of {torque_kNm:.1f} kN m are left"
            advice = "give a smaller torque, or more friction"
        elif errors.argmax() == 0:
            cause = f"{place}, a lateral force of {1e-3 * abs(force):.1f} kN to the {_way(force)} is not balanced"
            if force * position.lateral_mm > 0.0:
                cause += f", which pushes the {_way(force)} flange up its rail"
        else:
            cause = f"{place}, the forces still change from step to step"
            advice = "give a neighbouring lateral_mm, yaw, torque or friction"
        message = f"no equilibrium with friction in {MOST_ROLLING_STEPS} steps: {cause}; {advice}"
        return Status(False, message, MOST_ROLLING_STEPS)

    def _fine(
        self,
        found: Equilibrium[SpatialState],
        progress: Callable[[str], None],
        creep: WheelsetCreep | None = None,
        tolerance: float = FINE_RESIDUAL,
        across: int = ACROSS,
    ) -> Equilibrium[SpatialState]:
        """Equilibrium on cells that are fine enough for the patches, from a coarser one.

        - `creep`, `tolerance`: creep forces, and the equilibrium residual with them.
        - `across`: cells across a patch.
        """
        for turn in range(MOST_GRIDS):
            if not found.status.converged and (creep is None or found.status.iterations == MOST_ROLLING_STEPS):
                break
            grids = self._finer(found, across)
            if all(new is found.state.sides[side].grid for side, new in grids.items()):
                break
            if creep is not None:
                found = self._rolled(grids, found, progress, creep, tolerance, ends=turn == MOST_GRIDS - 1)
                continue
            tilts = self._tilts({side: state.resultant for side, state in found.state.sides.items()})
            contact = SpatialContact(self.problem, self.start, grids, self.model.yaw_rad, tilts)
            found = self._refined(contact, found.position, found.state, progress) or search_equilibrium(
                contact, progress, near=(found.position, found.state), tolerance=FINE_RESIDUAL, enough=FINE_RESIDUAL
            )
        return found

    def _finer(self, found: Equilibrium[SpatialState], across: int) -> dict[Side, GriddedSide]:
        """See `finer`."""
        state = found.state
        return {side: finer(each, across, state.insides(side)) for side, each in state.sides.items()}

    def _beyond(self, grids: Mapping[Side, GriddedSide], found: Equilibrium[SpatialState]) -> SpatialState | None:
        """Contact on coarse cells, if wheel and rail touch outside of the fine grids; else None."""
        sides, touches = dict(found.state.sides), False
        for side, fine in found.state.sides.items():
            if fine.grid is grids[side]:
                continue
            coarse, inner = grids[side].grid, fine.grid.grid
            start, creep = transferred(fine, grids[side]), transferred_creep(fine, grids[side])
            newton = SideNewton(grids[side], fine.pose, start)
            newton.creep = creep
            newton.linearise(fine.pose)
            across = (coarse.cells[:, :1] < inner.cells[:, 1]) & (coarse.cells[:, 1:] > inner.cells[:, 0])
            along = (coarse.z > inner.z[0] - coarse.strip) & (coarse.z < inner.z[-1] + coarse.strip)
            outside = ~np.outer(across.any(axis=1), along)
            if (newton.total[outside] < 0.0).any():
                sides[side] = solve_side(grids[side], fine.pose, start, creep=creep)
                touches |= bool((sides[side].forces[outside] > 0.0).any())
        return SpatialState(sides) if touches else None

    def _seat(self, side: Side) -> float:
        """Distance of a wheel's seat from the middle of the axle."""
        return abs(self.problem.wheelset.placement(side).translation[0])

    @cached_property
    def _tilts_by_forces(self) -> Floats:
        """Tilts of both wheels by force (x, y) and moment about the axle's middle on each, shape (2, 2, 3).

        By side, tilt and resultant, in the track's axes.
        """
        found = np.zeros((2, 2, 3))
        if self.model.axle is None:
            return found
        places = np.array([self.problem.wheelset.placement(side).translation[0] for side in SIDES])
        for number, place in enumerate(places.tolist()):
            for axis, unit in ((1, (1.0, -place)), (2, (0.0, 1.0))):
                forces = np.zeros((2, 2))
                forces[number] = unit
                found[number, :, axis] = self.model.axle.tilts(places, forces)
        return found

    def _tilts(self, resultants: Mapping[Side, Floats]) -> Floats:
        """Tilts of the left and the right wheel under forces in the right-hand form of each, (2,)."""
        total = np.zeros(2)
        for number, side in enumerate(SIDES):
            total += self._tilts_by_forces[number] @ (signs_of(side) * resultants[side])
        return total

    def _pressed(
        self, contact: SpatialContact, start: WheelsetPosition, progress: Callable[[str], None]
    ) -> Equilibrium[SpatialState] | None:
        """Equilibrium by `_refined` from a rigid start, the wheels pressed on the rails a little."""
        pressed = start.moved(WheelsetPosition(vertical_mm=-PRESSED_MM))
        kept = self.problem.prescribed.components
        position = WheelsetPosition(*(a if b is None else b for a, b in zip(pressed.components, kept, strict=True)))
        return self._refined(
            contact, position, None, progress, COARSE_RESIDUAL, lower=self.problem.prescribed == Prescribed()
        )

    def _refined(
        self,
        contact: SpatialContact,
        position: WheelsetPosition,
        near: SpatialState | None,
        progress: Callable[[str], None],
        tolerance: float = FINE_RESIDUAL,
        *,
        lower: bool = False,
        creep: WheelsetCreep | None = None,
        reach: float = np.inf,
        ends: bool = True,
    ) -> Equilibrium[SpatialState] | None:
        """Equilibrium from a position with its contact, if that is known, by `SideNewton` of both sides.

        None where it is not found, or not both wheels touch.

        - `tolerance`: equilibrium residual; forces and tilts are found to the same share of theirs.
        - `lower`: whether the weight is carried first, before the wheelset may move sideways.
        - `creep`: creep forces, if it rolls with friction.
        - `reach`: way over the step limits beyond which the search ends, to go on with other cells.
        - `ends`: whether patches may come to the ends of their cells; else the search ends there too.
        """
        newton = WheelsetNewton(contact, self._tilts_by_forces, position, near, creep, lower=lower)
        if near is None and not newton.touches:
            return None
        least = np.inf
        for iteration in range(MOST_STEPS if creep is None else MOST_ROLLING_STEPS):
            newton.linearise()
            error = newton.relative.equilibrium_residual
            least = min(least, error)
            if not ends and tolerance < error < ROLLING_RESIDUAL and newton.reaches_an_end:
                return newton.found(Status(False, "patches at the ends of their cells", iteration))
            lost = creep is not None and error > LOST * (1.0 if reach == np.inf else max(least, 1.0))
            settled = None if lost else newton.step(tolerance)
            progress(f"equilibrium residual {error:.1e} after {iteration} steps on fine cells")
            if settled is None:
                break
            if settled:
                message = f"contact forces and load are in equilibrium to {error:.1e}"
                return newton.found(Status(True, message, iteration))
            way = np.abs(np.subtract(newton.position.components, position.components)) / MAX_STEP
            if way.max() > reach:
                return newton.found(Status(False, "far from the first position", iteration))
        return None if creep is None else newton.found(Status(False, "", MOST_ROLLING_STEPS))

    def _coarse(self, side: Side, start: WheelsetPosition, yaw_rad: float | None = None) -> GriddedSide:
        """Cells of a whole running surface; `yaw_rad`: of a wheelset that rolls with friction."""
        rolls = yaw_rad is not None
        yaw = self.model.yaw_rad if yaw_rad is None else yaw_rad
        cell, strip = (each * (ROLLING_CELLS if rolls else 1.0) for each in (COARSE_MM, COARSE_STRIP_MM))
        surfaces, pose = self.surfaces[side], pose_of(self.problem, start, side, yaw)
        low, high = np.sort(surfaces.rail_stations[[0, -1], 1])
        ends = cell * np.arange(int(np.ceil(low / cell)), int(np.floor(high / cell)) + 1)
        cells = np.stack((ends[:-1], ends[1:]), axis=1)
        # yaw moves the wheel along the track, and contact on the flange further
        lead = float(pose.axis[2]) * pose.seat_mm
        reach = SEARCHED_MM + FLANGE_SLOPE * abs(pose.yaw_rad) * self.problem.wheelset.radius_mm
        searched = np.arange(int((lead - reach) / strip), int((lead + reach) / strip) + 1)
        searched = searched[::EVERY]
        z = strip * searched.astype(np.float64)
        points, normals = surfaces.rail_points(cells.mean(axis=1))
        gaps = wheel_gap(surfaces.wheel, pose.middle, pose.axis, points, normals, z).gaps
        near = np.flatnonzero(gaps.min(axis=1) < NEAR_MM)
        if len(near):
            cells = cells[near[0] : near[-1] + 1]
        planes = searched[gaps.min(axis=0) < CLOSED_MM]
        if len(planes) == 0:
            planes = int(lead / strip) + np.arange(-5, 6)
        grid = SideGrid(cells, strip, np.arange(planes[0] - EVERY + 1, planes[-1] + EVERY))
        return GriddedSide(surfaces, grid, pose)


def _way(lateral: float) -> str:
    return "right" if lateral >= 0.0 else "left"


@dataclass(frozen=True)
class _Window:
    """Ends of a patch along the rail's surface and along z, its cells across and along, and its share of the force."""

    ends: tuple[float, float]
    planes: tuple[float, float]
    across: int
    along: int
    share: float
    cell: float


def _windows(state: SideState, insides: Sequence[Bools] | None) -> list[_Window]:
    """One for each patch."""
    grid = state.grid.grid
    found: list[_Window] = []
    for patch in state.cells.patches(insides):
        rows, columns = (np.flatnonzero(patch.inside.any(axis=axis)) for axis in (1, 0))
        new = _Window(
            (float(grid.cells[rows[0], 0]), float(grid.cells[rows[-1], 1])),
            (float(grid.z[columns[0]]) - grid.strip / 2.0, float(grid.z[columns[-1]]) + grid.strip / 2.0),
            *patch.cells,
            float(state.forces[patch.inside].sum() / state.forces.sum()),
            float(grid.widths[rows].max()),
        )
        found.append(new)
    return found


def finer(state: SideState, n_across: int = ACROSS, insides: Sequence[Bools] | None = None) -> GriddedSide:
    """Grid with enough cells across each patch and room around it; the same grid if it is one already.

    - `n_across`: cells across a patch, and along it.
    - `insides`: cells of the patches, (n, n_z) each; left out: those that are apart.
    """
    old, grid = state.grid, state.grid.grid
    loaded = state.forces > 0.0
    if not loaded.any():
        return old
    windows = _windows(state, insides)
    main = [each for each in windows if each.share > MAIN]
    longest = max(each.along for each in main)
    part = n_across / ACROSS
    most_along, least_across = part * LONGEST, part * LEAST_ACROSS
    strip = grid.strip * min(1.0, max(min(each.along for each in main) / n_across, longest / most_along))
    enough = all(
        (each.along >= least_across or longest >= 0.9 * most_along)
        and (each.across >= least_across or each.cell <= 1.01 * grid.strip / LENGTHENED)
        for each in main
    )
    if enough and not (loaded & grid.at_edge).any():
        return old
    spans: list[list[float]] = []
    reached = -np.inf
    for each in sorted(windows, key=lambda each: each.ends):
        (first, last), before = each.ends, spans[-1] if spans else None
        more = max(MARGIN * (last - first), 0.6 * each.cell)
        cell = min(each.cell, max((last - first) / n_across, strip / LENGTHENED), LENGTHENED * strip)
        low, high = first - more, last + more
        if before is not None and first < reached:
            before[1:] = max(before[1], high), min(before[2], cell)
        else:
            if before is not None and low < before[1]:  # each patch has its own cells, up to the middle between them
                low = before[1] = (first + reached) / 2.0
            spans.append([low, high, cell])
        reached = max(last, reached)
    # as many cells as a factorisation takes
    strips = sum(each.planes[1] - each.planes[0] for each in windows) / max(len(windows), 1) / strip
    many = np.sqrt(max(sum((high - low) / cell for low, high, cell in spans) * strips / MOST_ON_A_SIDE, 1.0))
    strip *= many
    spans = [[low, high, cell * many] for low, high, cell in spans]
    limits = np.sort(old.surfaces.rail_stations[[0, -1], 1])
    cells = []
    for low, high, cell in spans:
        first, last = max(low, limits[0]), min(high, limits[1])
        ends = np.linspace(first, last, int(np.ceil((last - first) / cell)) + 1)
        cells.append(np.stack((ends[:-1], ends[1:]), axis=1))
    first, last = min(each.planes[0] for each in windows), max(each.planes[1] for each in windows)
    more = max(MARGIN * (last - first), 0.6 * grid.strip)
    planes = np.arange(int(np.floor((first - more) / strip)), int(np.ceil((last + more) / strip)) + 1)
    return GriddedSide(old.surfaces, SideGrid(np.concatenate(cells), strip, planes), state.pose)
