"""How a wheelset rolls, and the rolling of a wheel's patch with friction."""

from dataclasses import dataclass, replace

import numpy as np

from flangeway.checks import check_finite, check_positive
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.fast_theories import SimplifiedRolling, Theory
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import (
    STRIPS_BEYOND,
    CreepForces,
    Rolling,
    RollingContact,
    box_of,
)
from flangeway.errors import InputError
from flangeway.railway.wheelset.side_contact import SideState
from flangeway.railway.wheelset.side_newton import SideNewton
from flangeway.types import Bools, Floats

# --- How a wheelset rolls: speed, curve, yaw, torque and friction.


GAUGE_FACE_RAD = np.deg2rad(45.0)
"""Slope of the rail's surface from which it is the gauge face."""


def on_gauge_face(normals: Floats) -> Bools:
    """Whether cells with outward normals of the rail, (n, 2), are on its gauge face, (n,)."""
    return np.abs(normals[:, 0]) > np.sin(GAUGE_FACE_RAD)


@dataclass(frozen=True, eq=False)
class RollingMotion:
    """Motion of a wheelset that rolls ahead along the track, and friction.

    Parameters
    ----------
    speed_m_s
        Speed V of the axle's middle along the track, > 0. All creepages are slip over it.
    friction
        Coefficients of friction; `Friction.decay` in m/s.
    flange_friction
        Static coefficient on the gauge face, where the rail is steeper than 45 degrees; the kinetic one is less by the
        same factor. None: that of `friction`.
    curve_radius_m
        Radius of the curve, positive to the left; None: straight track.
    yaw_rate_rad_s
        Yaw rate relative to the track, counter-clockwise from above. The curve adds V / R.
    lateral_velocity_m_s
        Velocity of the axle's middle across the track, to the right.
    torque_Nm
        Torque on the wheelset about its axle: > 0 drives it ahead, < 0 brakes it, 0: it rolls freely.
    yaw_stiffness_Nm_per_rad
        Stiffness against yaw by which the yaw is found. The wheelset is guided to the yaw that is given otherwise, that
        of the axle in the bogie, relative to the radial direction of the track. 0: no guidance. None: the yaw is
        prescribed.
    theory
        Creep forces by the exact theory, FASTSIM, FaStrip, Polach's formula or linear theory.

    Raises
    ------
    InputError
        If a number is not finite, the speed not positive, or the radius 0.

    """

    speed_m_s: float
    friction: Friction
    flange_friction: float | None = None
    curve_radius_m: float | None = None
    yaw_rate_rad_s: float = 0.0
    lateral_velocity_m_s: float = 0.0
    torque_Nm: float = 0.0  # noqa: N815 (units in names)
    yaw_stiffness_Nm_per_rad: float | None = None  # noqa: N815
    theory: Theory = "exact"

    def __post_init__(self) -> None:
        check_positive(
            "RollingMotion", "speed_m_s", self.speed_m_s, "a speed > 0", "leave rolling out for a wheelset that stands"
        )
        for name in ("yaw_rate_rad_s", "lateral_velocity_m_s", "torque_Nm"):
            check_finite("RollingMotion", name, getattr(self, name))
        if self.curve_radius_m is not None and not (np.isfinite(self.curve_radius_m) and self.curve_radius_m != 0.0):
            raise InputError(
                f"RollingMotion(curve_radius_m={self.curve_radius_m})",
                "a radius above 0 to the left or below 0 to the right",
                "leave it out on straight track",
            )
        stiffness = self.yaw_stiffness_Nm_per_rad
        if stiffness is not None and not (np.isfinite(stiffness) and stiffness >= 0.0):
            raise InputError(
                f"RollingMotion(yaw_stiffness_Nm_per_rad={stiffness})",
                "a stiffness >= 0",
                "leave it out to hold the yaw",
            )
        _ = self.friction_on(np.array([[0.0, 1.0]]))

    @property
    def turning_rad_s(self) -> float:
        """Yaw rate in space, counter-clockwise from above."""
        return self.yaw_rate_rad_s + (0.0 if self.curve_radius_m is None else self.speed_m_s / self.curve_radius_m)

    @property
    def yaw_is_free(self) -> bool:
        """Whether the yaw is found."""
        return self.yaw_stiffness_Nm_per_rad is not None

    def friction_on(self, normals: Floats) -> Friction:
        """Friction of rows of cells with outward normals of the rail, (n, 2)."""
        if self.flange_friction is None:
            return self.friction
        on_flange = Friction(self.flange_friction)
        static, kinetic = (limit[0] for limit in self.friction.limits)
        steep = on_gauge_face(normals)
        share = kinetic / static if static > 0.0 else 1.0
        on_face = float(on_flange.limits[0][0])
        return replace(
            self.friction, static=np.where(steep, on_face, static), kinetic=np.where(steep, share * on_face, kinetic)
        )


# --- Rolling of a wheel's patch with friction: its cells with influence coefficients in three axes, and its creep
# forces.
#
# Axes of a patch are those of `flangeway.contact.rolling.rolling_contact.Creepages` with the rail as the first body,
# in the right-hand form of the side: t along the rail's surface towards the gauge side, n out of the rail, z ahead.


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
