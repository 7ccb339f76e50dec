"""Whole sections of rails and wheels through their most loaded patches: displacements and stresses."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flangeway.contact.patch.patch_grid import PatchBody
from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import SectionStresses, SpatialStresses
from flangeway.problems import Harmonic
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.track.supports import Continuous, Sleepers
from flangeway.railway.track.wheelset_problem import Role, WheelsetProblem
from flangeway.railway.wheelset.rolling.patch_rolling import forces_on_cells
from flangeway.railway.wheelset.running_surfaces import running_cells
from flangeway.railway.wheelset.side_contact import tangents_of, wheel_gap
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.supported_rail import (
    SPREAD,
    WAVENUMBERS,
    SupportedRail,
    weights_at,
)
from flangeway.solve import SurfaceCells
from flangeway.solve.surface_compliance import FurtherLoads, StripForces, wave_sums, waves
from flangeway.types import Floats

MIN_HELD = 1e-3
"""Least wavenumber per mm of a body that is held: longer waves change no stress by 1e-3 of the maximum pressure."""
END_TOLERANCE = 1e-6
"""Distance of two ends of cells relative to the width of the strips that are one."""


@dataclass(frozen=True, eq=False)
class WholeSection:
    """A rail, or the rim of a wheel, in a section through a patch, in the track's axes.

    - `mesh`: of the section, in the frame of its profile.
    - `positions`: undeformed points, a rail's on its unloaded support, a wheel's in its place, shape (n_points, 3).
    - `displacement`: elastic displacement of the points in mm, shape (n_points, 3).
    - `stresses`: at the corners of cells, each from its own cell, in the order of ``mesh.cell_points``.
    """

    mesh: PolyMesh
    positions: Floats
    displacement: Floats
    stresses: SpatialStresses


def whole_sections(result: SpatialResult, role: Role) -> dict[Side, WholeSection]:
    """Sections of the rails or the wheels in the plane of the centre of each side's most loaded patch.

    The forces are those of all patches of the side, with creep forces. A rail is on its support. A wheel is the prism
    of its rim, held at its cut, in the plane through its axis and the patch. A side without contact has none. Sides of
    one profile share the factorisations of its section.
    """
    problem, sections = result.problem, dict[Side, WholeSection]()
    touching = [side for side in SIDES if any(patch.side == side for patch in result.patches)]
    profiles = {side: _profile(problem, side, role) for side in touching}
    for first in touching:
        if first in sections:
            continue
        held = problem.track.support_of(first) if role == "rail" else problem.wheelset.section
        whole = running_cells(problem, profiles[first], held, result.cache)
        supports = {side: problem.track.support_of(side) for side in touching}
        alike = [side for side in touching if (profiles[side], supports[side]) == (profiles[first], supports[first])]
        cuts = [_cut(result, side, role, whole) for side in alike]
        is_supported = isinstance(held, Sleepers | Continuous)
        wavenumbers = waves(WAVENUMBERS[0] if is_supported else MIN_HELD, min(cut.forces.strip for cut in cuts))
        further = _sleepers(whole.problem, held, result, wavenumbers, cuts) if isinstance(held, Sleepers) else None
        sums = wave_sums([cut.forces for cut in cuts], wavenumbers, further)
        sections |= {cut.side: _section(cut, *waves_of_cut) for cut, waves_of_cut in zip(cuts, sums, strict=True)}
    return sections


@dataclass(frozen=True, eq=False)
class _Cut:
    """The plane of a section, and the forces on the body.

    - `z`: of the plane.
    - `frame`: from that of the profile to that of the side's curves.
    - `origin`, `axes`: of the body in the track's axes, (3,) and (3, 3), axes as columns.
    - `turn`: from the axes of the mesh to the track's, (3, 3).
    """

    side: Side
    z: float
    frame: Placement
    origin: Floats
    axes: Floats
    turn: Floats
    forces: StripForces


def _profile(problem: WheelsetProblem, side: Side, role: Role) -> WheelProfile | RailProfile:
    return problem.wheels.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)


def _cut(result: SpatialResult, side: Side, role: Role, whole: SurfaceCells) -> _Cut:
    """The plane through the side's first patch."""
    centre = next(patch.centre for patch in result.patches if patch.side == side)
    state = result.equilibrium.state.sides[side]
    grid, surfaces, z = state.grid.grid, state.grid.surfaces, float(centre[2])
    loaded = state.forces.any(axis=1)
    ends, forces = grid.cells[loaded].ravel(), _on_wheel(result, side)[loaded]
    if role == "wheel":
        pose, frame, forces = state.pose, surfaces.wheel_frame, forces[::-1]
        hits = wheel_gap(surfaces.wheel, pose.middle, pose.axis, *surfaces.rail_points(ends), np.array([z]))
        # normals of a corner sharper than the overlap is deep cross before they meet the wheel, where points of both
        # bodies follow each other in the same order all the same
        ends = np.sort(surfaces.wheel_at(hits.along[:, 0]))
        origin = np.append(pose.middle, 0.0)
        inward = origin - centre
        inward -= (inward @ pose.axis) * pose.axis
        inward /= np.linalg.norm(inward)
        axes = np.stack((pose.axis, inward, np.cross(pose.axis, inward)), axis=1)
    else:
        frame, origin, axes, forces = surfaces.rail_frame, np.array([0.0, 0.0, z]), np.eye(3), -forces
    distinct = np.diff(ends, prepend=-np.inf) > END_TOLERANCE * grid.strip
    cells = SurfaceCells(whole.problem, whole.edges, ends[distinct])
    rows = np.minimum(np.cumsum(distinct)[::2], cells.n_cells) - 1
    turn = axes.copy()
    turn[:, :2] = axes[:, :2] @ frame.matrix
    on_cells = np.zeros((cells.n_cells, 3, grid.n_strips))
    np.add.at(on_cells, rows, np.einsum("nai,nzi->naz", cells.frames[rows], forces @ turn))
    return _Cut(side, z, frame, origin, axes, turn, StripForces(cells, on_cells, z - grid.along, grid.strip))


def _section(cut: _Cut, even: Floats, odd: Floats) -> WholeSection:
    """Displacements and stresses by the sums of `wave_sums`."""
    cells = cut.forces.cells
    mesh = cells.problem.elasticity.space.mesh
    stresses = SectionStresses(PatchBody(cells.problem, cells.edges), cut.z, even, odd).corners()
    displacement = np.column_stack((even[0, : mesh.n_points, :2], odd[0, : mesh.n_points, 2])) @ cut.turn.T
    positions = cut.frame.points(mesh.points) @ cut.axes[:, :2].T + cut.origin
    mirror = np.array([SIDE_SIGN[cut.side], 1.0, 1.0])
    return WholeSection(mesh, positions * mirror, displacement * mirror, stresses.turned(mirror[:, None] * cut.turn))


def _on_wheel(result: SpatialResult, side: Side) -> Floats:
    """Forces on the wheel's cells of a side in its right-hand form, creep forces included, (n, n_z, 3)."""
    state = result.equilibrium.state.sides[side]
    total = np.zeros((*state.forces.shape, 3))
    total[..., :2] = state.forces[..., None] * state.normals[:, None]
    for patch, creep in result.rolling:
        if patch.side == side:
            across, along = np.moveaxis(patch.on_side(creep, forces_on_cells(creep.forces, creep.contact)), 2, 0)
            total[..., :2] += across[..., None] * tangents_of(state.normals)[:, None]
            total[..., 2] += along
    return total


def _sleepers(
    problem: Harmonic, support: Sleepers, result: SpatialResult, wavenumbers: Floats, cuts: list[_Cut]
) -> FurtherLoads:
    """Loads of the base's modes that turn its continuous support into sleepers, see `supported_rail`."""
    rail = SupportedRail(problem, support)
    nodes, modes = rail.base
    loads = np.zeros((problem.elasticity.space.n_dofs, 3, 3))
    loads[nodes] = modes
    flat = loads.reshape(-1, 3)
    low = wavenumbers[wavenumbers <= WAVENUMBERS[1]]
    kept = np.diag(1.0 / ((1.0 - SPREAD) * support.per_length))

    def of(cut: _Cut) -> Callable[[int, Floats], Floats]:
        of_seats = (1.0 - SPREAD) * result.rails[cut.side].reactions
        apart = cut.z - result.rails[cut.side].sleepers_mm
        seats = np.stack(
            [weights.T @ of_seats for weights in weights_at(low, apart, support.pad_length_mm, 1)], axis=-1
        )

        def amounts(number: int, fields: Floats) -> Floats:
            if number >= len(low):
                return np.zeros((3, 2))
            moved = flat.T @ fields
            freedom = np.linalg.inv(kept - moved[:, 2:])
            added = seats[number]
            return np.asarray(added + freedom @ (moved[:, :2] + moved[:, 2:] @ added))

        return amounts

    return flat, [of(cut) for cut in cuts]
