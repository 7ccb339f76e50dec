"""How a wheelset rolls, and the rolling of a wheel's patch with friction."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.patch.normal_contact import Convolution, Pressing
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.fast_theories import SimplifiedRolling
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import (
    STRIPS_BEYOND,
    Creepages,
    CreepForces,
    Rolling,
    RollingContact,
    box_of,
)
from flangeway.railway.track.placements import SIDE_SIGN
from flangeway.railway.wheelset.side_contact import FAR_MM, SideState, tangents_of
from flangeway.railway.wheelset.side_newton import SideNewton
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.types import Bools, Floats

# --- Rolling of a wheel's patch with friction: its cells with influence coefficients in three axes, and its creep
# forces.
#
# Axes of a patch are those of `flangeway.contact.rolling.rolling_contact.Creepages` with the rail as the first body,
# in the right-hand form of the side: t along the rail's surface towards the gauge side, n out of the rail, z ahead.


def rolling_contact_of(
    patch: SpatialPatch, friction: Friction, origin: tuple[float, float] | None = None
) -> RollingContact:
    """Cells of a patch, to roll on the real bodies.

    Parameters
    ----------
    patch
        Patch of a wheelset in equilibrium.
    friction
        Coefficients of friction; several are those of the cells of the whole side, one for each row.
    origin
        Place that creepages and moments are of: length along the rail's elastic surface, and z; left out: the centre
        of pressure.

    Returns
    -------
    RollingContact
        The smallest box of rows and strips about the patch, with the pressures of this patch only. Bodies of different
        materials find their pressures anew with friction, at the same resultant.

    """
    state = patch.state
    normal, inside = state.forces, patch.ellipse.inside
    rail, wheel = state.grid.surfaces.materials
    if rail == wheel:
        return contact_in(state, normal, inside, friction, origin)
    contact = contact_in(state, normal, inside, friction, origin, whole=True)
    rows = rows_of(state, contact)
    box = rows, strips_of(state, contact)
    influence = Convolution(np.ascontiguousarray(contact.coefficients[: contact.grid.n_strips, 1::3, 1::3]))
    undeformed = state.gaps[box] - influence(contact.normal_forces)
    undeformed[(normal > 0.0)[box] & ~inside[box]] = FAR_MM
    force = contact.normal_forces.sum(axis=1) @ state.normals[rows]
    total = float(np.linalg.norm(force))
    share = (state.normals[rows] @ force / total)[:, None]
    return replace(contact, pressed=Pressing(influence, undeformed, share, total))


def contact_in(
    state: SideState | SideNewton,
    normal: Floats,
    inside: Bools,
    friction: Friction,
    origin: tuple[float, float] | None = None,
    *,
    whole: bool = False,
    bodies: bool = True,
) -> RollingContact:
    """As `rolling_contact_of` for the cells of a patch on its side, with pressures that stay.

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


def rows_of(state: SideNewton | SideState, contact: RollingContact) -> slice:
    """Rows of cells of a side that a patch's contact has."""
    first = int(np.argmin(np.abs(state.grid.grid.bounds[:-1] - contact.grid.bounds[0])))
    return slice(first, first + len(contact.grid.widths))


def strips_of(state: SideNewton | SideState, contact: RollingContact) -> slice:
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


@dataclass(frozen=True, eq=False)
class RollingPatch:
    """A patch that rolls with friction: creep forces beside its normal forces.

    - `patch`: the patch.
    - `forces`: creep forces in the patch's axes, of any theory; `Rolling` and `SimplifiedRolling` have tractions, slip
      and states on the cells of the patch.
    - `contact`: cells and coefficients.
    - `speed_m_s`: speed of rolling.
    """

    patch: SpatialPatch
    forces: Rolling | SimplifiedRolling | CreepForces
    contact: RollingContact
    speed_m_s: float = 1.0

    @property
    def rows(self) -> slice:
        """Rows of cells of the side that `contact` has."""
        return rows_of(self.patch.state, self.contact)

    def on_side(self, values: Floats) -> Floats:
        """Values (n_cells, n_strips, ...) of the patch's cells on all cells of the side, 0 elsewhere."""
        state = self.patch.state
        whole = np.zeros((*state.forces.shape, *values.shape[2:]))
        whole[self.rows, strips_of(state, self.contact)] = values
        return whole

    @cached_property
    def tractions(self) -> Floats | None:
        """Tractions (t, z) of friction on the wheel's cells of the side, (n, n_z, 2); None: the theory has none."""
        forces = self.forces
        return self.on_side(forces.tractions) if isinstance(forces, Rolling | SimplifiedRolling) else None

    @cached_property
    def _side_force(self) -> Floats:
        """Creep force on the wheel in the right-hand form of the side."""
        normals = self.patch.state.normals[self.rows]
        across, along = forces_on_cells(self.forces, self.contact).sum(axis=1).T
        return np.append(across @ tangents_of(normals), along.sum())

    @property
    def creep_force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Creep force on the wheel, N, in the track's axes: x to the right, y up, z ahead, shape (3,)."""
        return self._side_force * (SIDE_SIGN[self.patch.side], 1.0, 1.0)

    @property
    def force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Normal and creep force on the wheel together, N, in the track's axes, shape (3,)."""
        return np.append(self.patch.force_on_wheel_N, 0.0) + self.creep_force_on_wheel_N

    @cached_property
    def creepages(self) -> Creepages:
        """Creepages at the origin of `contact` in the patch's axes, a number each: the rows' slip there, weighted."""
        return self.forces.motion.mean(self.contact.places[0], self.contact.row_shares)

    @property
    def longitudinal_creepage(self) -> float:
        """Slip of the wheel ahead over the speed, at the origin of `contact`; the mean of the rows by normal force."""
        return float(self.creepages.along)

    @property
    def lateral_creepage(self) -> float:
        """Slip of the wheel along the rail's surface to the right over the speed."""
        return -SIDE_SIGN[self.patch.side] * float(self.creepages.across)

    @property
    def spin_creepage_per_m(self) -> float:
        """Rotation of the wheel on the rail about its normal over the speed, 1/m, counter-clockwise from above."""
        return -1e3 * SIDE_SIGN[self.patch.side] * float(self.creepages.spin)

    @property
    def lateral_creep_force_N(self) -> float:  # noqa: N802
        """Creep force on the wheel along the rail's surface to the right, N."""
        return float(-SIDE_SIGN[self.patch.side] * self.forces.across)

    @property
    def spin_moment_Nm(self) -> float:  # noqa: N802
        """Moment on the wheel about the normal at the origin of `contact`, N m, counter-clockwise from above."""
        return -1e-3 * SIDE_SIGN[self.patch.side] * self.forces.moment

    @property
    def used_friction(self) -> float:
        """Creep force over normal force."""
        return float(np.hypot(self.forces.along, self.forces.across)) / self.contact.force

    @property
    def t_gamma_N(self) -> float:  # noqa: N802
        """Energy that friction dissipates over the distance rolled, its power over the speed, N = J/m."""
        return self.forces.t_gamma

    @property
    def power_W(self) -> float:  # noqa: N802
        """Power that friction dissipates, W."""
        return self.speed_m_s * self.forces.t_gamma
