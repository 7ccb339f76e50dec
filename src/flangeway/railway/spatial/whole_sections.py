"""Whole sections of rails and wheels through their most loaded patches: displacements and stresses."""

from dataclasses import dataclass

import numpy as np

from flangeway.contact.patch.patch_body import PatchBody
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import SectionStresses, SpatialStresses
from flangeway.problems import Harmonic
from flangeway.railway.spatial.rail_along_track import RailAlongTrack
from flangeway.railway.spatial.rail_supports import RailSupport
from flangeway.railway.spatial.rolling.patch_rolling import forces_on_cells
from flangeway.railway.spatial.running_surfaces import running_cells
from flangeway.railway.spatial.side_contact import tangents_of
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.spatial.supported_rail import SPREAD, WAVENUMBERS, SupportedRail, weights_at
from flangeway.railway.spatial.wheel_gap import wheel_gap
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.solve import SurfaceCells
from flangeway.solve.surface_compliance import FurtherLoads, wave_sums, waves
from flangeway.types import Floats

LEAST_HELD = 1e-3
"""Least wavenumber per mm of a body that is held: longer waves change no stress by 1e-3 of the maximum pressure."""
JOINED = 1e-6
"""Distance of two ends of cells over the width of the strips that are one."""


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


def whole_section(result: SpatialResult, side: Side, role: Role) -> WholeSection:
    """Section of a body in the plane of the centre of its side's most loaded patch.

    The forces are those of all patches of the side, with creep forces. A rail is on its support. A wheel is the prism
    of its rim, held at its cut, in the plane through its axis and the patch.

    Raises
    ------
    InputError
        If nothing touches on this side.

    """
    centre = next((patch.ellipse.centre for patch in result.patches if patch.side == side), None)
    if centre is None:
        raise InputError(f"a section of the {side} {role}", "a side with contact", "choose the other side")
    problem, model, state = result.problem, result.wheelset.model, result.equilibrium.state.sides[side]
    grid, surfaces, z = state.grid.grid, state.grid.surfaces, float(centre[2])
    profile = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    loaded = state.forces.any(axis=1)
    ends = grid.cells[loaded].ravel()
    own = np.diff(ends, prepend=-np.inf) > JOINED * grid.strip
    bounds, rows, forces = ends[own], np.cumsum(own)[::2] - 1, _on_wheel(result, side)[loaded]
    if role == "wheel":
        pose, frame = state.pose, surfaces.wheel_frame
        hits = wheel_gap(surfaces.wheel, pose.middle, pose.axis, *surfaces.rail_points(bounds), np.array([z]))
        bounds, rows = surfaces.wheel_at(hits.along[:, 0])[::-1], len(bounds) - 2 - rows
        origin = np.append(pose.middle, 0.0)
        inward = origin - centre
        inward -= (inward @ pose.axis) * pose.axis
        inward /= np.linalg.norm(inward)
        axes = np.stack((pose.axis, inward, np.cross(pose.axis, inward)), axis=1)
    else:
        frame, origin, axes, forces = surfaces.rail_frame, np.array([0.0, 0.0, z]), np.eye(3), -forces
    turn = axes.copy()
    turn[:, :2] = axes[:, :2] @ frame.matrix
    whole = running_cells(problem, model, profile, result.cache)
    cells = SurfaceCells(whole.problem, whole.edges, bounds)
    on_cells = np.zeros((cells.n_cells, 3, len(grid.planes)))
    on_cells[rows] = np.einsum("nai,nzi->naz", cells.frames[rows], forces @ turn)
    support = model.support if role == "rail" else None
    wavenumbers = waves(LEAST_HELD if support is None else WAVENUMBERS[0], grid.strip)
    further = None if support is None else _sleepers(whole.problem, support, result.rails[side], wavenumbers, z)
    even, odd = wave_sums(cells, on_cells, z - grid.z, grid.strip, wavenumbers, further)
    mesh = whole.problem.elasticity.space.mesh
    stresses = SectionStresses(PatchBody(whole.problem, cells.edges), z, even, odd).corners()
    displacement = np.column_stack((even[0, : mesh.n_points, :2], odd[0, : mesh.n_points, 2])) @ turn.T
    positions = frame.points(mesh.points) @ axes[:, :2].T + origin
    mirror = np.array([SIDE_SIGN[side], 1.0, 1.0])
    return WholeSection(mesh, positions * mirror, displacement * mirror, stresses.turned(mirror[:, None] * turn))


def _on_wheel(result: SpatialResult, side: Side) -> Floats:
    """Forces on the wheel's cells of a side in its right-hand form, creep forces included, (n, n_z, 3)."""
    state = result.equilibrium.state.sides[side]
    total = np.zeros((*state.forces.shape, 3))
    total[..., :2] = state.forces[..., None] * state.normals[:, None]
    for patch in result.rolling:
        if patch.patch.side == side:
            creep = patch.on_side(forces_on_cells(patch.forces, patch.contact))
            total[..., :2] += creep[..., :1] * tangents_of(state.normals)[:, None]
            total[..., 2] += creep[..., 1]
    return total


def _sleepers(
    problem: Harmonic, support: RailSupport, along: RailAlongTrack, wavenumbers: Floats, z: float
) -> FurtherLoads | None:
    """Loads of the base's modes that turn its continuous support into sleepers, see `supported_rail`."""
    if support.kind == "continuous":
        return None
    rail = SupportedRail(problem, support)
    nodes, modes = rail.base
    loads = np.zeros((problem.elasticity.space.n_dofs, 3, 3))
    loads[nodes] = modes
    flat = loads.reshape(-1, 3)
    low = wavenumbers[wavenumbers <= WAVENUMBERS[1]]
    of_seats = (1.0 - SPREAD) * along.reactions
    seats = np.stack(
        [each.T @ of_seats for each in weights_at(low, z - support.sleepers_mm, support.pad_length_mm, 1)], axis=-1
    )
    kept = np.diag(1.0 / ((1.0 - SPREAD) * support.per_length))

    def amounts(number: int, fields: Floats) -> Floats:
        if number >= len(low):
            return np.zeros((3, 2))
        moved = flat.T @ fields
        freedom = np.linalg.inv(kept - moved[:, 2:])
        added = seats[number]
        return np.asarray(added + freedom @ (moved[:, :2] + moved[:, 2:] @ added))

    return flat, amounts
