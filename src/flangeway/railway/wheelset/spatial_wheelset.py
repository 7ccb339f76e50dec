"""A wheelset on two rails in three dimensions: its contact at a position, and its equilibrium."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from flangeway.railway.rigid.elastic_start import RigidStart, rigid_start
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import MAX_STEP, MAX_WAY, Equilibrium
from flangeway.railway.wheelset.rolling.rolling_motion import RollingMotion
from flangeway.railway.wheelset.rolling.wheelset_creep import WheelsetCreep, rate_of
from flangeway.railway.wheelset.running_surfaces import PATCH_CELLS, SpatialModel
from flangeway.railway.wheelset.side_contact import GriddedSide, SideGrid, SideState, SideSurfaces, wheel_gap
from flangeway.railway.wheelset.side_newton import solve_side, transferred, transferred_creep
from flangeway.railway.wheelset.wheelset_newton import FINE_RESIDUAL, SpatialState, WheelsetNewton, pose_of
from flangeway.solve import Status
from flangeway.types import Bools, Floats, Ints

COARSE_MM, COARSE_STRIP_MM = 1.4, 3.0
"""Cells of the whole running surfaces; the contact at a flange root jumps between wider ones."""
CLOSED_MM = 1.0
"""Gap of the rigid wheel within which strips may come into contact."""
EVERY = 3
"""Strips from one to the next at which these gaps are looked at."""
NEAR_MM = 12.0
"""Gap of the rigid wheel beyond which its surface is too far from the rail's to come into contact."""
COARSE_RESIDUAL = 1e-3
PRESSED_MM = 0.1
"""Depth below the rigid position, beyond what the rails sink, at which the search begins."""
MAX_ITERATIONS = 80
"""Newton steps until the equilibrium on coarse cells, or on one set of fine ones."""
ROLLING_RESIDUAL, FAST_RESIDUAL = 0.02, 1e-7
"""Equilibrium residual with friction: where other cells follow, which change it by as much, and by fast theories, whose
forces are not smooth."""
LIFTED, TORQUE, YAW_MOMENT = 0.2, 3, 4
"""Vertical or moment residual of wheels that do not carry the load; numbers of torque and yaw moment in residuals."""
MAX_BENT_MM = 0.4
"""Displacement of a cell by creep forces in one step, at most."""
NEARBY = 5.0
"""Way over the step limits within which the coarse cells still fit."""
GRID_RESIDUAL = 1e-3
"""Residual at which the cells are chosen."""
COARSER = 1.3
"""Size of cells over the one that is wanted, at most."""
SIZES = 8
"""Sizes of cells from one to its double."""
FLAT = 1e-3
"""Fall of the pressure beside a local maximum, over it, below which that is no narrow peak."""
PEAK, MAX_DIVISION = 0.3, 4.0
"""Cells across half a narrow peak of the pressure over those across a patch, and parts of a cell there, at most."""
FEWER_ACROSS, NESTED_RESIDUAL = 0.5, 2e-3
"""Cells across a patch over the final ones while creep forces are sought, and the residual on them."""
MARGIN = 0.2
"""Width of the window beyond a patch on each side over the patch."""
BROAD_MARGIN = 0.6
"""The same for a patch that has come to the end of its window."""
LENGTHENED = 6.0
"""Longer side over shorter side of a cell, at most."""
MAX_GRIDS = 6
"""Fine grids that are made, also to add patches outside of them."""
SEARCHED_MM = 90.0
"""Distance along the track from the wheel's middle up to which it may touch without yaw."""
FLANGE_SLOPE = 3.0
"""Slope of the flange, by which yaw moves its contact along the track."""
LONGEST = 1.8
"""Strips along the longest patch over those wanted along the shortest, at most."""
MOST_ON_A_SIDE, MORE_ON_A_SIDE = 5000, 2.0
"""Cells in the windows of a side, at most, and the factor on them where more cells across a patch are wanted."""
MAIN = 0.05
"""Share of a side's force above which a patch has its cells counted."""

Placed: TypeAlias = tuple[Mapping[Side, GriddedSide], SpatialState]
"""Cells, and a contact to start from on them."""


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
        """Find the equilibrium, first on coarse cells over the whole running surfaces, then on fine ones.

        With friction from the equilibrium without, and on few cells between both.
        """
        start = self.start.motion.moved(WheelsetPosition(vertical_mm=-PRESSED_MM - self._sinking))
        kept = self.problem.prescribed.components
        position = WheelsetPosition(*(a if b is None else b for a, b in zip(start.components, kept, strict=True)))
        newton, coarse = self._on_coarse_cells(position, None, None, progress)
        motion, cells = self.model.rolling, self.model.patch_cells
        stages = [(cells, FINE_RESIDUAL)]
        if motion is not None:
            creep = WheelsetCreep(motion, rate_of(motion, coarse.state.sides), motion.theory, MAX_BENT_MM)
            newton, coarse = self._on_coarse_cells(coarse.position, coarse.state, creep, progress)
            last = FINE_RESIDUAL if motion.theory == "exact" else FAST_RESIDUAL
            stages = [(round(FEWER_ACROSS * cells), NESTED_RESIDUAL), (cells, last)]
        found = coarse
        for across, tolerance in stages:
            found = self._on_fine_cells(newton, found, coarse.state, progress, tolerance, across)
        return found

    def _on_coarse_cells(
        self,
        position: WheelsetPosition,
        near: SpatialState | None,
        creep: WheelsetCreep | None,
        progress: Callable[[str], None],
    ) -> tuple[WheelsetNewton, Equilibrium[SpatialState]]:
        """Equilibrium on coarse cells, which are made anew where the wheelset leaves the position that they are for."""
        place = position

        def grids_at(near: SpatialState | None) -> dict[Side, GriddedSide]:
            """Cells at the place; those of a contact where they reach as far."""
            grids = {side: self._coarse(side, place, near) for side in SIDES}
            for side, state in {} if near is None else near.sides.items():
                if state.grid.grid.covers(grids[side].grid):
                    grids[side] = state.grid
            return grids

        def others(found: Equilibrium[SpatialState], newton: WheelsetNewton) -> Placed | None:
            nonlocal place
            way = np.abs(np.subtract(newton.position.components, place.components))
            if not found.status.converged and (way / MAX_STEP).max() <= NEARBY:
                return None
            place = newton.position
            grids, state = grids_at(found.state), found.state
            return None if all(grids[side] is state.sides[side].grid for side in SIDES) else (grids, state)

        grids = grids_at(near)
        newton = WheelsetNewton(self.problem, grids, place, self.model.yaw_rad, self._tilts_by_forces, near, creep)
        tolerance = COARSE_RESIDUAL if self.model.rolling is None else ROLLING_RESIDUAL
        return newton, self._search(newton, tolerance, progress, others)

    def _on_fine_cells(
        self,
        newton: WheelsetNewton,
        found: Equilibrium[SpatialState],
        coarse: SpatialState,
        progress: Callable[[str], None],
        tolerance: float,
        across: int,
    ) -> Equilibrium[SpatialState]:
        """Equilibrium on cells that are fine enough for the patches, and that hold all of them.

        The cells of the last equilibrium are chosen at a larger residual than its own.

        - `newton`, `found`: the search on other cells, and how it ended.
        - `coarse`: contact on coarse cells of the whole running surfaces.
        - `tolerance`: equilibrium residual.
        - `across`: cells across a patch.
        """
        if not found.status.converged:
            return found
        whole = {side: state.grid for side, state in coarse.sides.items()}
        n_grids, last, nested = 1, False, tolerance > GRID_RESIDUAL

        def finer_ones(state: SpatialState) -> dict[Side, GriddedSide]:
            return {
                side: finer(each, across, state.insides(side), coarse.sides[side]) for side, each in state.sides.items()
            }

        def others(found: Equilibrium[SpatialState], newton: WheelsetNewton) -> Placed | None:
            nonlocal n_grids
            if n_grids == MAX_GRIDS or not ((found.status.converged and not nested) or newton.reaches_an_end):
                return None
            state: SpatialState | None = found.state
            grids = finer_ones(found.state)
            if all(grids[side] is each.grid for side, each in found.state.sides.items()):
                state = self._beyond(whole, found) if last else None
                grids = finer_ones(state) if state else grids
            n_grids += state is not None
            return None if state is None else (grids, state)

        newton.place(finer_ones(found.state), found.state)
        found = self._search(newton, max(GRID_RESIDUAL, tolerance), progress, others)
        last = True
        return found if nested or not found.status.converged else self._search(newton, tolerance, progress, others)

    def _search(
        self,
        newton: WheelsetNewton,
        tolerance: float,
        progress: Callable[[str], None],
        others: Callable[[Equilibrium[SpatialState], WheelsetNewton], Placed | None],
    ) -> Equilibrium[SpatialState]:
        """Equilibrium by `WheelsetNewton`.

        - `tolerance`: equilibrium residual; forces and tilts are found to the same share of theirs.
        - `others`: other cells on which it goes on, and a contact to start from there; None: those that it has.
        """
        for iteration in range(MAX_ITERATIONS):
            newton.linearise()
            error = newton.relative.equilibrium_residual
            progress(f"equilibrium residual {error:.1e} after {iteration} steps")
            settled = newton.step(tolerance)
            message = f"contact forces and load are in equilibrium to {error:.1e}"
            found = newton.found(Status(settled, message, iteration))
            placed = others(found, newton)
            if placed is not None:
                newton.place(*placed)
            elif settled:
                return found
            if (np.abs(np.subtract(newton.position.components, self.start.motion.components)) > MAX_WAY).any():
                break
        return replace(found, status=self._none(found, None if newton.creep is None else newton.creep.motion))

    def _none(self, last: Equilibrium[SpatialState], motion: RollingMotion | None) -> Status:
        """No equilibrium: what is not balanced where the search ended, and what would hold it."""
        residuals, position = last.residuals, last.position
        free = np.array([*residuals.free, True, True])
        errors = np.abs([residuals.lateral_residual, residuals.vertical_residual, residuals.moment_residual,
                         residuals.torque_residual, residuals.yaw_residual]) * free  # fmt: skip
        force, torque_kNm = float(last.residual[0]), 0.0 if motion is None else 1e-3 * abs(motion.torque_Nm)
        place = f"where the search ended, {abs(position.lateral_mm):.1f} mm to the {_way(position.lateral_mm)}"
        advice = "give lateral_mm to see the forces at a position, "
        advice += "a smaller lateral force, or friction" if motion is None else "a smaller yaw, or less friction"
        if errors[1:3].max() > LIFTED:
            cause = f"{place}, a wheel no longer carries its load: it lifts, or climbs its rail (derailment)"
        elif torque_kNm and errors.argmax() == TORQUE:
            unit = 1e-6 * self.problem.load.in_track[1] * self.problem.wheelset.tape_radius_mm
            missing = unit * abs(residuals.torque_residual)
            cause = f"friction does not transmit the torque: {missing:.1f} of {torque_kNm:.1f} kN m are left"
            advice = "give a smaller torque, or more friction"
        elif errors.argmax() == 0:
            cause = f"{place}, a lateral force of {1e-3 * abs(force):.1f} kN to the {_way(force)} is not balanced"
            if force * position.lateral_mm > 0.0:
                cause += f", which pushes the {_way(force)} flange up its rail"
        elif errors.argmax() == YAW_MOMENT:
            arm = self.problem.wheelset.back_to_back_mm / 2.0
            missing = 1e-6 * abs(residuals.yaw_residual) * self.problem.load.vertical_N * arm
            cause = f"{place}, a yaw moment of {missing:.1f} kN m is not balanced"
            advice = "give the yaw, or a yaw stiffness that holds it"
        else:
            cause = f"{place}, the forces still change from step to step"
            advice = "give a neighbouring lateral_mm, yaw, torque or friction"
        kind = "no equilibrium" if motion is None else "no equilibrium with friction"
        message = f"{kind} in {last.status.iterations} steps: {cause}; {advice}"
        return Status(False, message, last.status.iterations)

    def _beyond(self, grids: Mapping[Side, GriddedSide], found: Equilibrium[SpatialState]) -> SpatialState | None:
        """Contact on coarse cells, if wheel and rail touch outside of the fine grids; else None."""
        sides, touches = dict(found.state.sides), False
        for side, fine in found.state.sides.items():
            if fine.grid is grids[side]:
                continue
            coarse, inner = grids[side].grid, fine.grid.grid
            start, creep = transferred(fine, grids[side]), transferred_creep(fine, grids[side])
            values = grids[side].deformed(fine.pose, start, None, None if creep is None else creep[:, 0])[3]
            across = (coarse.cells[:, :1] < inner.cells[:, 1]) & (coarse.cells[:, 1:] > inner.cells[:, 0])
            along = (coarse.z > inner.z[0] - coarse.strip) & (coarse.z < inner.z[-1] + coarse.strip)
            outside = ~np.outer(across.any(axis=1), along)
            if ((values + grids[side].influence(start))[outside] < 0.0).any():
                sides[side] = solve_side(grids[side], fine.pose, start, creep=creep)
                touches |= bool((sides[side].forces[outside] > 0.0).any())
        return SpatialState(sides) if touches else None

    @cached_property
    def _sinking(self) -> float:
        """Displacement of the rails under the vertical load, at the middle of their heads, mm."""
        compliance = [float(np.diagonal(side.rail_elastic.by_axes[1, 1, 0]).min()) for side in self.surfaces.values()]
        return min(compliance) * self.problem.load.in_track[1] / 2.0

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

    def _coarse(self, side: Side, position: WheelsetPosition, near: SpatialState | None) -> GriddedSide:
        """Cells of a whole running surface at a position; `near`: contact there, if it is known."""
        cell, strip, yaw = COARSE_MM, COARSE_STRIP_MM, self.model.yaw_rad
        if near is not None and near.rolled is not None:
            yaw = near.rolled.yaw_rad
        surfaces, pose = self.surfaces[side], pose_of(self.problem, position, side, yaw)
        # the rail's head has moved away
        motion = np.array([0.0, -self._sinking])
        if near is not None:
            state = near.sides[side]
            motion = state.grid.rail_motion(state.forces, None if state.creep is None else state.creep[:, 0])[0]
        pose = replace(pose, x=pose.x - motion[0], y=pose.y - motion[1])
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
        rows = np.flatnonzero(gaps.min(axis=1) < NEAR_MM)
        if len(rows):
            cells = cells[rows[0] : rows[-1] + 1]
        planes = searched[gaps.min(axis=0) < CLOSED_MM]
        if len(planes) == 0:
            planes = int(lead / strip) + np.arange(-5, 6)
        grid = SideGrid(cells, strip, np.arange(planes[0] - EVERY + 1, planes[-1] + EVERY))
        return GriddedSide(surfaces, grid, pose)


def _way(lateral: float) -> str:
    return "right" if lateral >= 0.0 else "left"


@dataclass(frozen=True)
class _Window:
    """A patch on a grid.

    - `ends`, `planes`: along the rail's surface and along z.
    - `across`, `along`: widths of the ellipse by the second moments of the pressure, which do not jump between cells.
    - `share`: of the side's force.
    - `rows`: its rows of cells.
    - `peaks`: where the maximum pressure of rows has its local maxima, and half the widths of the parabolas through
      these, each (m, 2).
    """

    ends: tuple[float, float]
    planes: tuple[float, float]
    across: float
    along: float
    share: float
    rows: Ints
    peaks: Floats

    def sizes(self, cells: Floats, size: float, n_across: int) -> Floats:
        """Widths that cells (n, 2) should have where those of the patch have a size: smaller at narrow peaks."""
        wanted = np.full(len(cells), size)
        for middle, half in self.peaks:
            near = (cells[:, 1] > middle - half) & (cells[:, 0] < middle + half)
            wanted[near] = np.minimum(wanted[near], max(half / (PEAK * n_across), size / MAX_DIVISION))
        return wanted


def _windows(state: SideState, insides: Sequence[Bools] | None) -> list[_Window]:
    """One for each patch."""
    grid, pressures = state.grid.grid, state.cells.pressures
    windows: list[_Window] = []
    for patch in state.cells.patches(insides):
        rows, columns = (np.flatnonzero(patch.inside.any(axis=axis)) for axis in (1, 0))
        highest = np.where(patch.inside, pressures, 0.0).max(axis=1)
        windows.append(
            _Window(
                (float(grid.cells[rows[0], 0]), float(grid.cells[rows[-1], 1])),
                (float(grid.z[columns[0]]) - grid.strip / 2.0, float(grid.z[columns[-1]]) + grid.strip / 2.0),
                *patch.widths,
                float(state.forces[patch.inside].sum() / state.forces.sum()),
                rows,
                _peaks(grid.stations, highest, float(grid.widths[rows].max())),
            )
        )
    return windows


def _peaks(stations: Floats, values: Floats, size: float) -> Floats:
    """Local maxima above half of the maximum, and half the widths of the parabolas through them, (m, 2).

    - `size`: distance of the values that such a parabola goes through, the same on cells that were divided.
    """
    inner = values[1:-1]
    at = 1 + np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]) & (inner > 0.5 * values.max()))
    middle = stations[at]
    # v (1 - x^2 / a^2) falls by v (h / a)^2 at the distance h
    falls = values[at] - (np.interp(middle - size, stations, values) + np.interp(middle + size, stations, values)) / 2.0
    return np.column_stack((middle, size * np.sqrt(values[at] / np.maximum(falls, FLAT * values[at]))))


def finer(
    state: SideState,
    n_across: int = PATCH_CELLS,
    insides: Sequence[Bools] | None = None,
    coarse: SideState | None = None,
) -> GriddedSide:
    """Grid with enough cells across each patch and room around it; the same grid if it is one already.

    Cells end at multiples of their size along the rail's surface and along z, and sizes are powers of one number: so
    the cells at a position do not depend on how it was reached. At narrow peaks of the pressure, as at jumps of a
    profile's curvature, cells are divided.

    - `n_across`: cells across a patch, and along it.
    - `insides`: cells of the patches, (n, n_z) each; left out: those that are apart.
    - `coarse`: contact on coarse cells; what touches there has cells too, whether it is loaded here or not.
    """
    old, grid = state.grid, state.grid.grid
    loaded = state.forces > 0.0
    if not loaded.any():
        return old
    windows = _windows(state, insides)
    for window in () if coarse is None else _windows(coarse, None):
        if all(window.ends[1] < other.ends[0] or window.ends[0] > other.ends[1] for other in windows):
            windows.append(replace(window, share=0.0, rows=np.zeros(0, dtype=np.int64), peaks=np.zeros((0, 2))))
    windows.sort(key=lambda window: window.ends)
    middles = np.array([np.mean(window.ends) for window in windows])
    all_within = ((grid.cells[:, :1] <= middles) & (grid.cells[:, 1:] >= middles)).any(axis=0).all()
    main = [window for window in windows if window.share > MAIN]
    longest = max(window.along for window in main)
    strip = max(min(window.along for window in main) / n_across, longest / (n_across * LONGEST))
    sizes = [min(max(window.across / n_across, strip / LENGTHENED), LENGTHENED * strip) for window in windows]
    at_edge = bool((loaded & grid.at_edge).any())
    enough = grid.strip <= COARSER * strip and all(
        (grid.widths[window.rows] <= COARSER * window.sizes(grid.cells[window.rows], size, n_across)).all()
        for window, size in zip(windows, sizes, strict=True)
        if window.share > MAIN
    )
    if enough and all_within and not at_edge:
        return old
    margin = BROAD_MARGIN if at_edge else MARGIN
    spans: list[list[float]] = []
    reached = -np.inf
    for window, size in zip(windows, sizes, strict=True):
        (first, last), before = window.ends, spans[-1] if spans else None
        more = max(margin * (last - first), 0.6 * float(grid.widths[window.rows].max(initial=0.0)))
        low, high = first - more, last + more
        if before is not None and first < reached:
            before[1:] = max(before[1], high), min(before[2], size)
        else:
            if before is not None and low < before[1]:  # each patch has its own cells, up to the middle between them
                low = before[1] = (first + reached) / 2.0
            spans.append([low, high, size])
        reached = max(last, reached)
    first, last = min(window.planes[0] for window in windows), max(window.planes[1] for window in windows)
    more = max(margin * (last - first), 0.6 * grid.strip)
    # as many cells as a factorisation takes
    strips = sum(window.planes[1] - window.planes[0] for window in windows) / len(windows) / strip
    most = min(max(n_across / PATCH_CELLS, 1.0) ** 2, MORE_ON_A_SIDE) * MOST_ON_A_SIDE
    many = np.sqrt(max(sum((high - low) / size for low, high, size in spans) * strips / most, 1.0))
    strip = _rounded(many * strip)
    limits = np.sort(old.surfaces.rail_stations[[0, -1], 1])
    parts, end = [], limits[0]
    for low, high, size in spans:
        ends = _multiples(_rounded(many * size), low, high)
        ends = ends[(ends >= limits[0]) & (ends <= limits[1])]
        if ends[0] < end:  # beside another patch's cells: one of another width fills what is between
            ends = np.append(end, ends[ends > end + 0.5 * size])
        if len(ends) < 2:  # the other patch's cells hold all of it
            continue
        end = ends[-1]
        cells = np.stack((ends[:-1], ends[1:]), axis=1)
        wanted = np.min([window.sizes(cells, many * size, n_across) for window in windows], axis=0)
        parts.append(_divided(cells, wanted))
    planes = np.arange(int(np.floor((first - more) / strip)), int(np.ceil((last + more) / strip)) + 1)
    return GriddedSide(old.surfaces, SideGrid(np.concatenate(parts), strip, planes), state.pose)


def _rounded(size: float) -> float:
    """The closest one of the sizes that cells may have."""
    return float(2.0 ** (np.round(np.log2(size) * SIZES) / SIZES))


def _multiples(size: float, low: float, high: float) -> Floats:
    """Multiples of a size about an interval."""
    return size * np.arange(np.floor(low / size), np.ceil(high / size) + 1.0)


def _divided(cells: Floats, sizes: Floats) -> Floats:
    """Cells (n, 2), halved until they are not wider than sizes (n,)."""
    halvings = np.ceil(np.log2(np.diff(cells, axis=1)[:, 0] / (COARSER * sizes)))
    counts = 2 ** np.maximum(halvings, 0).astype(int)
    ends = [
        np.linspace(low, high, count, endpoint=False)
        for (low, high), count in zip(cells.tolist(), counts.tolist(), strict=True)
    ]
    limits = np.append(np.concatenate(ends), cells[-1, 1])
    return np.stack((limits[:-1], limits[1:]), axis=1)
