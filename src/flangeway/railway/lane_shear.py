"""Largest shear stress below the contacts of many positions, from the fields of the bodies themselves."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import monomials
from flangeway.elements.monomials import Frame
from flangeway.post import Stresses
from flangeway.post.location import OUTSIDE, locate
from flangeway.problems import Body
from flangeway.railway.discretisation import ROLES, Role
from flangeway.railway.lane_patches import LanePatch
from flangeway.railway.prepared import PreparedWheelset
from flangeway.railway.subsurface import DEPTH, SubsurfaceExtreme, closest_on_boundary, largest_on
from flangeway.railway.track import SIDES
from flangeway.space import CellBatch

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

N_POINTS = 201
"""Points of a line into a body, as `stresses_below` has them."""


@dataclass(frozen=True, eq=False)
class LoadedPatch:
    """A region of contact and the forces on the whole surfaces of its bodies.

    Parameters
    ----------
    patch
        The region.
    wheel, rail
        Forces on the nodes of the surfaces in the bodies' own frames and order, each (n, 2).

    """

    patch: LanePatch
    wheel: Floats
    rail: Floats


def largest_shears(prepared: PreparedWheelset, loaded: Sequence[LoadedPatch]) -> list[dict[Role, SubsurfaceExtreme]]:
    """Largest in-plane shear stress in the wheel and in the rail below each region of contact.

    It is that of `flangeway.railway.subsurface.largest_shear`: on the line along the inward normal through the centre
    of pressure, smoothed over the cells. The fields of all regions are recovered together.

    Parameters
    ----------
    prepared
        The wheelset.
    loaded
        The regions.

    """
    found: list[dict[Role, SubsurfaceExtreme]] = [{} for _ in loaded]
    for role in ROLES:
        for side in SIDES:
            numbers = [number for number, each in enumerate(loaded) if each.patch.side == side]
            if not numbers:
                continue
            patches = [loaded[number] for number in numbers]
            forces = np.stack([each.wheel if role == "wheel" else each.rail for each in patches])
            lines = [line_below(prepared, role, each.patch) for each in patches]
            place = [part.name for part in prepared.model.system.parts].index(f"{role}-{side}")
            fields = prepared.response.body_fields(place, forces)
            body = prepared.model.system.parts[place].body
            shear = _stresses(body, fields, np.stack([points for points, _ in lines]))
            for number, values, (_, depths) in zip(numbers, shear, lines, strict=True):
                found[number][role] = largest_on(depths, values)
    return found


def line_below(prepared: PreparedWheelset, role: Role, patch: LanePatch) -> tuple[Floats, Floats]:
    """Points (n, 2) of the line into a body below a region of contact, in its frame, and their depths (n,)."""
    problem, side = prepared.model.problem, patch.side
    profile = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    point = np.array(patch.wheel_point_mm if role == "wheel" else patch.rail_point_mm)
    number, parameter, _ = profile.running_surface.closest([point])
    inward = -profile.running_surface.segments[int(number[0])].normal(parameter)[0]
    start = closest_on_boundary(prepared.model.parts[f"{role}-{side}"].body.mesh, point)
    depths = np.linspace(0.0, DEPTH * patch.half_width_mm, N_POINTS)
    return start + depths[:, None] * inward, depths


def _stresses(body: Body, fields: Floats, points: Floats) -> Floats:
    """Largest in-plane shear (m, n) of fields (m, n_dofs, 2) at points (m, n, 2), nan outside of the body."""
    n_fields, n_dofs = fields.shape[:2]
    cells = locate(body.mesh, points.reshape(-1, 2))
    field = np.repeat(np.arange(n_fields), points.shape[1])
    result = np.full(len(cells), np.nan)
    place = np.full(body.mesh.n_cells, -1, dtype=np.int64)
    for batch in body.space.batches():
        place[batch.cells] = np.arange(len(batch.cells))
        here = np.flatnonzero((cells != OUTSIDE) & (place[cells] >= 0))
        if len(here):
            columns = place[cells[here]]
            dofs = batch.dofs[:, columns] + n_dofs * field[here]
            chosen = CellBatch(batch.element, batch.cells[columns], batch.vertices[..., columns], dofs)
            reconstruction, stress = body.elasticity.cell_stresses(chosen, fields.reshape(-1, 2))
            frame = Frame(reconstruction.frame.origin, reconstruction.frame.map)
            values = monomials.evaluate(reconstruction.order, frame.local(points.reshape(-1, 2)[here].T))
            result[here] = Stresses(np.einsum("sae,ae->es", stress, values[: stress.shape[1]])).in_plane_shear
        place[batch.cells] = -1
    return result.reshape(points.shape[:2])
