"""Maximum shear stress below the contacts of many positions, from the fields of the bodies themselves."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from flangeway.problems import Body
from flangeway.railway.positions.line_stresses import Lines, LineStresses
from flangeway.railway.positions.positions_patches import PositionPatch
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.subsurface import DEPTH, SEARCHED, SubsurfaceExtreme, inward_from, maximum_of_lines
from flangeway.solve import CondensedBodies
from flangeway.types import Floats

N_POINTS = 201  # points of a line into a body, as `stresses_below` has them


@dataclass(frozen=True, eq=False)
class LoadedPatch:
    """A region of contact and the forces on the whole surfaces of its bodies.

    - `wheel`, `rail`: forces on the nodes of the surfaces in the bodies' own frames and order, each (n, 2).
    """

    patch: PositionPatch
    wheel: Floats
    rail: Floats


Key = tuple[Body, bytes]
"""A body and its surface nodes: twins that are placed elsewhere share what is known of it."""

_kept: WeakKeyDictionary[CondensedBodies, dict[Key, LineStresses]] = WeakKeyDictionary()
"""What serves all lines into condensed bodies; it goes with them."""


def maximum_shears(
    prepared: PreparedWheelset, loaded: Sequence[LoadedPatch], *, superposed: bool
) -> list[dict[Role, SubsurfaceExtreme]]:
    """Maximum in-plane shear stress in the wheel and in the rail below each region of contact.

    It is that of `flangeway.railway.wheelset.subsurface.maximum_shear`: on the line along the inward normal through
    the centre of pressure, smoothed over the cells. All regions are treated together, and displacements are found
    only where their lines run.

    - `superposed`: whether fields are superposed from those of unit forces, which are kept with the condensed bodies;
      it pays for hundreds of regions over all calls.
    """
    found: list[dict[Role, SubsurfaceExtreme]] = [{} for _ in loaded]
    parts = [part.name for part in prepared.model.system.parts]
    for role in ROLES:
        twins: dict[Key, list[Side]] = {}
        for side in SIDES:
            surface = prepared.response.surfaces[parts.index(f"{role}-{side}")]
            twins.setdefault((surface.body, surface.nodes.tobytes()), []).append(side)
        for key, sides in twins.items():
            numbers = [number for number, each in enumerate(loaded) if each.patch.side in sides]
            if not numbers:
                continue
            patches = [loaded[number] for number in numbers]
            forces = np.stack([each.wheel if role == "wheel" else each.rail for each in patches])
            lines = lines_below(prepared, role, sides[0], [each.patch for each in patches])
            solve = partial(prepared.response.body_fields, parts.index(f"{role}-{sides[0]}"))
            stresses = _stresses(prepared.response, key, forces.shape[1])
            shear = stresses.in_plane_shear(lines, forces, solve, superposed=superposed)
            for number, extreme in zip(numbers, maximum_of_lines(lines.depths, shear, SEARCHED), strict=True):
                found[number][role] = extreme
    return found


def lines_below(prepared: PreparedWheelset, role: Role, side: Side, patches: Sequence[PositionPatch]) -> Lines:
    """Lines into a body below regions of contact, in the body's frame.

    - `role`, `side`: which of its bodies.
    - `patches`: the regions, of this side or of a side with the same bodies.
    """
    problem = prepared.model.problem
    profile = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    points = np.array([each.wheel_point_mm if role == "wheel" else each.rail_point_mm for each in patches])
    starts, inward = inward_from(profile.running_surface, prepared.model.parts[f"{role}-{side}"].body.mesh, points)
    lengths = DEPTH * np.array([each.half_width_mm for each in patches])
    return Lines(starts, inward, np.linspace(0.0, lengths, N_POINTS, axis=1))


def _stresses(response: CondensedBodies, key: Key, n_nodes: int) -> LineStresses:
    """Return what is kept of a body, made if needed."""
    kept = _kept.setdefault(response, {})
    if key not in kept:
        kept[key] = LineStresses(key[0], n_nodes)
    return kept[key]
