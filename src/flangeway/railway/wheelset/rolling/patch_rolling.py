"""How a wheelset rolls, and the rolling of a wheel's patch with friction."""

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.fast_theories import SimplifiedRolling
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import (
    STRIPS_BEYOND,
    CreepForces,
    Rolling,
    RollingContact,
    box_of,
)
from flangeway.railway.wheelset.side_contact import SideState
from flangeway.types import Bools, Floats

# --- Rolling of a wheel's patch with friction: its cells with influence coefficients in three axes, and its creep
# forces.
#
# Axes of a patch are those of `flangeway.contact.rolling.rolling_contact.Creepages` with the rail as the first body,
# in the right-hand form of the side: t along the rail's surface towards the gauge side, n out of the rail, z ahead.


def contact_in(
    state: SideState,
    normal: Floats,
    inside: Bools,
    friction: Friction,
    origin: tuple[float, float] | None = None,
    *,
    whole: bool = False,
    bodies: bool = True,
) -> RollingContact:
    """Cells of a patch of a side to roll, with pressures that stay.

    - `state`: of the side.
    - `normal`: normal forces of all cells, (n, n_z).
    - `inside`: which cells, (n, n_z).
    - `whole`: cells about the patch too, which friction moves along the normals: as many rows on each side as it
      has itself at most, and all strips.
    - `bodies`: whether the bodies' influence coefficients are needed: fast theories do not.
    """
    side, grid = state.grid, state.grid.grid
    rows, strips = box_of(inside)
    if whole or not bodies:  # the ellipse of a patch that is none may be wider
        size, last = rows.stop - rows.start, len(grid.widths)
        rows = slice(max(0, rows.start - size), min(last, rows.stop + size)) if whole else slice(0, last)
    if whole:
        strips = slice(0, inside.shape[1])
    z = grid.along[strips]
    cells = PatchGrid(grid.bounds[rows.start : rows.stop + 1], grid.strip, len(z), float(z.mean()))
    forces = np.where(inside, normal, 0.0)[rows, strips]
    friction_of_rows = friction.of_rows(rows)
    coefficients = np.zeros((0, 0, 0))
    if bodies:
        coefficients = side.coefficients_of((0, 1, 2), rows, len(z) + 2 * STRIPS_BEYOND)
    return RollingContact(
        cells, forces / cells.areas, friction_of_rows, side.surfaces.materials, coefficients, None, origin
    )


def rows_of(state: SideState, contact: RollingContact) -> slice:
    """Rows of cells of a side that a patch's contact has."""
    first = int(np.argmin(np.abs(state.grid.grid.bounds[:-1] - contact.grid.bounds[0])))
    return slice(first, first + len(contact.grid.widths))


def strips_of(state: SideState, contact: RollingContact) -> slice:
    """Strips of a side that a patch's contact has."""
    first = int(np.argmin(np.abs(state.grid.grid.along - contact.grid.along[0])))
    return slice(first, first + contact.grid.n_strips)


def forces_on_cells(forces: CreepForces, contact: RollingContact) -> Floats:
    """Creep forces on the cells (n_cells, n_strips, 2), along t and z.

    Where a theory has none, or those of an ellipse, what is missing is spread as the normal forces are.
    """
    share = (contact.normal_forces / contact.force)[..., None]
    if isinstance(forces, Rolling):
        return np.asarray(forces.tractions * contact.areas[..., None])
    cells = np.zeros((*share.shape[:2], 2))
    if isinstance(forces, SimplifiedRolling):
        cells = forces.tractions * contact.areas[..., None]
    return np.asarray(cells + share * (np.array([forces.across, forces.along]) - cells.sum(axis=(0, 1))))
