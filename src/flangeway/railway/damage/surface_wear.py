"""Wear of wheels and rails by the patches of one wheelset: areas worn off their profiles, by rows of cells."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.errors import InputError
from flangeway.railway.damage.rolling_fatigue import shakedown_index, surface_fatigue_index, t_gamma_damage
from flangeway.railway.damage.wear_laws import CellLoads, WearLaw
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.rolling.patch_rolling import RollingPatch
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.types import Floats

THEORIES_WITH_CELLS = "exact, fastsim, fastrip"


@dataclass(frozen=True, eq=False)
class RowWear:
    """What a patch wears off one profile, by its rows of cells.

    Parameters
    ----------
    side, role
        Whose profile.
    ends
        Ends of the rows on the running surface in the frame of the profile, shape (n, 2, 2).
    areas
        Area worn off the profile in mm2 where the patch has passed once, shape (n,): depth of a passage times width.
    radii
        Distance of the rows from the axle, mm, shape (n,).
    damage
        Net T-gamma damage of the patch in one passage.

    """

    side: Side
    role: Role
    ends: Floats
    areas: Floats
    radii: Floats
    damage: float

    @property
    def rates(self) -> Floats:
        """Areas of a rail by one axle in mm2; those of a wheel over the distance rolled, mm2/mm, shape (n,).

        A point of a rail is passed once by each axle, one of a wheel once in each turn.
        """
        return self.areas if self.role == "rail" else self.areas / (2.0 * np.pi * self.radii)


@dataclass(frozen=True)
class PatchDamage:
    """Numbers of a patch for reports.

    - `fatigue_index`, `shakedown_index`: None where the yield strength is not known.
    - `net_damage`: of T-gamma, one passage.
    """

    side: Side
    region: str
    max_pressure_MPa: float  # noqa: N815
    t_gamma_N: float  # noqa: N815
    utilised_friction: float
    fatigue_index: float | None
    shakedown_index: float | None
    net_damage: float


def patch_loads(rolling: RollingPatch) -> CellLoads:
    """Loads of the cells of a patch that rolls; its energy over the distance is the patch's T-gamma.

    An `InputError` if its theory has no tractions and slip on cells.
    """
    forces, speed = rolling.forces, rolling.speed_m_s
    if not isinstance(forces, Rolling | SimplifiedRolling):
        raise InputError(
            f"wear by creep forces of the theory {forces.theory}",
            f"a theory with slip in the cells: {THEORIES_WITH_CELLS}",
            "choose one of them as rolling_theory",
        )
    scale = abs(forces.motion.speed) or 1.0
    loads = CellLoads(
        rolling.contact.pressures,
        forces.tractions,
        forces.slip_velocities / scale,
        np.broadcast_to(rolling.contact.areas, rolling.contact.pressures.shape),
        speed,
        forces.power_density / scale if isinstance(forces, Rolling) else None,
    )
    # single cells may have a negative power, and FASTSIM's strips are interpolated on cells
    total = loads.t_gamma_N
    energy = loads.energy * (rolling.t_gamma_N / total if total > 0.0 else 0.0)
    return CellLoads(loads.pressures, loads.tractions, loads.slips, loads.areas, speed, energy)


def row_wear(result: SpatialResult, laws: dict[Role, WearLaw]) -> list[RowWear]:
    """Wear of both sides' wheels and rails by a wheelset that rolls; bodies without a law do not wear."""
    found: list[RowWear] = []
    for rolling in result.rolling:
        loads, damage = patch_loads(rolling), float(t_gamma_damage(np.array(rolling.t_gamma_N)).net)
        for role in ROLES:
            if role not in laws:
                continue
            # area of a row: sum over its cells of rate times the area of the cell, each passed along its strip
            areas = (laws[role].rates(loads) * loads.areas).sum(axis=1)
            worn = np.flatnonzero(areas)
            if not worn.size:
                continue
            ends, radii = _ends(rolling, role)
            found.append(RowWear(rolling.patch.side, role, ends[worn], areas[worn], radii[worn], damage))
    return found


def _ends(rolling: RollingPatch, role: Role) -> tuple[Floats, Floats]:
    """Ends of the rows of cells (n, 2, 2) in the frame of a profile, and their distances from the axle (n,)."""
    state, rows = rolling.patch.state, rolling.rows
    surfaces, cells = state.grid.surfaces, state.grid.grid.cells[rows]
    pressed = state.forces[rows] * (state.forces[rows] > 0.0)
    pressed = np.where(pressed.any(axis=1, keepdims=True), pressed, 1.0)
    along = (pressed * state.gap.along[rows]).sum(axis=1) / pressed.sum(axis=1)
    radii = -surfaces.wheel.over(along).y
    if role == "rail":
        points = surfaces.rail_points(cells.ravel())[0]
        return surfaces.rail_frame.inverse().points(points).reshape(-1, 2, 2), radii
    # the ends of the cells lie on lines through the middles of neighbours
    x = make_interp_spline(cells.mean(axis=1), along, k=1)(cells.ravel())
    points = np.stack((x, surfaces.wheel.over(x).y), axis=1)
    return surfaces.wheel_frame.inverse().points(points).reshape(-1, 2, 2), radii


def patch_damage(result: SpatialResult) -> Sequence[PatchDamage]:
    """Numbers of the patches of a wheelset that rolls."""
    shear = None if result.yield_MPa is None else result.yield_MPa / np.sqrt(3.0)
    found = []
    for rolling in result.rolling:
        patch, friction = rolling.patch, rolling.used_friction
        p0, (a, b) = patch.ellipse.max_pressure, patch.ellipse.semi_axes
        found.append(
            PatchDamage(
                patch.side,
                patch.region,
                p0,
                rolling.t_gamma_N,
                friction,
                None if shear is None else surface_fatigue_index(friction, (a, b), rolling.contact.force, shear),
                None if shear is None else shakedown_index(p0, shear, friction),
                float(t_gamma_damage(np.array(rolling.t_gamma_N)).net),
            )
        )
    return found
