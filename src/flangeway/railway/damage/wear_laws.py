"""Wear laws, and the wear of wheels and rails by the patches of one wheelset."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal, Protocol, runtime_checkable

import annotated_types as at
import numpy as np
from scipy.interpolate import make_interp_spline

from flangeway.checks import as_numbers, check_finite, check_kind, refused
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.rolling_contact import Rolling
from flangeway.errors import InputError
from flangeway.railway.damage.rolling_fatigue import shakedown_index, surface_fatigue_index, t_gamma_damage
from flangeway.railway.track.placements import Side
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.rolling.patch_rolling import rows_of
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import WheelPatch
from flangeway.records import Fraction, Positive, Record
from flangeway.types import Floats

# --- Wear laws: depth worn per distance rolled from pressure, tractions and slip of the cells of a patch.
#
# A point of the surface that passes through the patch loses ``integral of rate dx`` of its depth in one passage, with
# the distance x along rolling. A rate is a depth in mm over the distance rolled in mm, of one of the two bodies.
# Sources:
#
# - Archard (1953, J. Appl. Phys. 24): ``rate = k p |slip| / H``. The map of k over slip velocity and pressure is that
# of
#   Jendel (2002, Wear 253, 83-89): its ranges are in `JENDEL`.
# - USFD: T-gamma over area, Braghin, Lewis, Dwyer-Joyce and Bruni (2006, Wear 261, 1253-1264), wheels of R8T on rails
# of
#   UIC 60 900A. As first published the rate jumps from 55 to 4779 ug/m/mm2 at 77.2 N/mm2; later authors let the third
#   branch begin where the second one ends.
# - Energy: volume over dissipated energy, a constant (Fouvry et al., 2003, Wear 255).
#
# The ranges of k, both limits of USFD and its three constants are those that `docs/theory/damage.md` lists, with how
# each was checked. The original papers are not open. The law of British Rail Research (Pearce and Sherratt, 1991) is
# left out: no open source with its constants was at hand.
#
# Whether a law is evaluated in each cell (local) or once for a patch (`PerPatch`) changes its result where its constant
# depends on the load: say which.


DENSITY_ug_per_mm3 = 7800.0
"""Density of steel, 7800 kg/m3."""
JENDEL: tuple[tuple[float, float], ...] = ((1e-4, 10e-4), (30e-4, 40e-4), (1e-4, 10e-4), (300e-4, 400e-4))
"""Ranges of Archard's k: slip below 0.2 m/s, 0.2 to 0.7 m/s, above; and at pressures above 0.8 of the hardness."""
JENDEL_VELOCITIES_m_s = (0.2, 0.7)
JENDEL_PRESSURE = 0.8
EnergyUnit = Literal["mm3/J", "mm3/kJ", "mm3/MJ", "ug/J", "mg/kJ"]
ENERGY_UNITS: dict[EnergyUnit, float] = {
    "mm3/J": 1e-3,
    "mm3/kJ": 1e-6,
    "mm3/MJ": 1e-9,
    "ug/J": 1e-3 / DENSITY_ug_per_mm3,
    "mg/kJ": 1e-3 / DENSITY_ug_per_mm3,
}
"""Units of worn volume or mass over energy, in mm3 per N mm."""
RATE_UNITS = {
    "mm/mm": 1.0,
    "mm/m": 1e-3,
    "um/m": 1e-6,
    "mm3/m/mm2": 1e-3,
    "ug/m/mm2": 1e-3 / DENSITY_ug_per_mm3,
}
"""Units of a rate, in mm of depth per mm rolled."""


@dataclass(frozen=True, eq=False)
class CellLoads:
    """What a law needs of the cells of one patch; arrays of one shape (...), or (..., 2).

    Parameters
    ----------
    pressures
        MPa, 0 outside of the patch, shape (...).
    tractions
        Tangential tractions in MPa, shape (..., 2).
    slips
        Slip velocity over the rolling velocity, of one body on the other, shape (..., 2).
    areas
        Of the cells in mm2; (...), or a shape that broadcasts to it.
    speed_m_s
        Rolling velocity.
    dissipation
        Dissipated energy over area and distance in N/mm2, T-gamma / A of each cell; left out: tractions times slip.

    """

    pressures: Floats
    tractions: Floats
    slips: Floats
    areas: Floats
    speed_m_s: float
    dissipation: Floats | None = None

    def __post_init__(self) -> None:
        """Raise an `InputError` if shapes differ from these or a number is not finite, >= 0 for pressures and speed."""
        names = [
            name
            for name in ("pressures", "tractions", "slips", "areas", "dissipation")
            if getattr(self, name) is not None
        ]
        for name in names:
            object.__setattr__(self, name, as_numbers(f"CellLoads({name})", getattr(self, name)))
        shape = self.pressures.shape
        of_cells = shape if self.dissipation is None else self.dissipation.shape
        fits = self.tractions.shape == self.slips.shape == (*shape, 2) and of_cells == shape
        speed = check_finite("CellLoads", "speed_m_s", self.speed_m_s)
        if not (
            fits
            and all(np.isfinite(getattr(self, name)).all() for name in names)
            and min(self.pressures.min(initial=0.0), speed) >= 0.0
        ):
            raise InputError(
                f"CellLoads with pressures {shape}, tractions {self.tractions.shape}, slips "
                f"{self.slips.shape}, dissipation {of_cells}, at {speed:g} m/s",
                "finite numbers of shapes (...), (..., 2), (..., 2) and (...), pressures and speed >= 0",
                "give the loads of the same cells",
            )

    @property
    def energy(self) -> Floats:
        """T-gamma over area, N/mm2, not below 0, shape (...)."""
        if self.dissipation is not None:
            return np.maximum(self.dissipation, 0.0)
        return np.abs((self.tractions * self.slips).sum(axis=-1))

    @property
    def slip_sizes(self) -> Floats:
        """Slip over the distance rolled, shape (...)."""
        return np.asarray(np.linalg.norm(self.slips, axis=-1))

    @property
    def t_gamma_N(self) -> float:  # noqa: N802
        """Energy dissipated over the distance rolled, N."""
        return float((self.energy * self.areas).sum())

    @property
    def contact_area_mm2(self) -> float:
        """Area of the cells under pressure."""
        return float(((self.pressures > 0.0) * self.areas).sum())

    def mean(self) -> "CellLoads":
        """One cell with the means over the contact area; traction times slip is the mean T-gamma over area."""
        area = self.contact_area_mm2
        weights = np.broadcast_to(self.areas, self.pressures.shape) / (area or 1.0)
        energy = float((self.energy * weights).sum())
        slip = float((self.slip_sizes * weights)[self.pressures > 0.0].sum())
        traction = energy / slip if slip > 0.0 else 0.0
        return CellLoads(
            np.array([float((self.pressures * weights).sum())]),
            np.array([[traction, 0.0]]),
            np.array([[slip, 0.0]]),
            np.array([area]),
            self.speed_m_s,
            np.array([energy]),
        )


@runtime_checkable
class WearLaw(Protocol):
    """A law of wear: its name with the way it is evaluated, and its rate."""

    @property
    def name(self) -> str:
        """What reports call it."""
        ...

    def rates(self, cells: CellLoads) -> Floats:
        """Depth worn off one body over the distance rolled, mm/mm, shape (...)."""
        ...


class _Law(Record):
    """A law that files name."""

    per_patch: bool = False
    """whether it is evaluated once for a patch, at means over its area"""

    @property
    def evaluated(self) -> WearLaw:
        """The law in each cell, or for each patch as a whole."""
        return PerPatch(self) if self.per_patch else self  # type: ignore[arg-type, return-value]


class ArchardLaw(_Law):
    """Archard's law with a constant k, or with Jendel's map of k."""

    kind: Literal["archard"] = "archard"
    """Archard's law"""
    hardness_MPa: Positive  # noqa: N815
    """hardness of the softer body; HB 275 is 2700 MPa"""
    k: Fraction | None = None
    """wear coefficient without unit; steel has 1e-4 to 4e-2 (default: Jendel's map)"""
    level: Annotated[float, at.Ge(0.0), at.Le(1.0)] = 0.5
    """where in the ranges of the map k lies, 0 at their lower and 1 at their upper ends"""

    @property
    def name(self) -> str:
        """See `WearLaw`."""
        return f"Archard, {'map of Jendel' if self.k is None else f'k = {self.k:g}'}"

    def coefficients(self, velocity_m_s: Floats, pressures: Floats) -> Floats:
        """Wear coefficient k at slip velocities and pressures in MPa, one shape."""
        if self.k is not None:
            return np.full(np.shape(pressures), self.k)
        k = np.array([low + self.level * (high - low) for low, high in JENDEL])
        by_velocity = k[np.searchsorted(JENDEL_VELOCITIES_m_s, velocity_m_s, side="right")]
        return np.where(pressures > JENDEL_PRESSURE * self.hardness_MPa, k[3], by_velocity)

    def rates(self, cells: CellLoads) -> Floats:
        """See `WearLaw`."""
        slips = cells.slip_sizes
        k = self.coefficients(cells.speed_m_s * slips, cells.pressures)
        return np.asarray(k * cells.pressures * slips / self.hardness_MPa)


class UsfdLaw(_Law):
    """T-gamma over area by the University of Sheffield, in ug of steel per m rolled and mm2 of contact."""

    kind: Literal["usfd"] = "usfd"
    """T-gamma over area"""
    branch: Literal["continuous", "published"] = "continuous"
    """continuous: the third branch begins where the second one ends; published: as of 2006"""
    limits: ClassVar[tuple[float, float]] = (10.4, 77.2)
    """T-gamma over area in N/mm2 at which severe and catastrophic wear begin."""
    slopes: ClassVar[tuple[float, float]] = (5.3, 61.9)
    """Rates over T-gamma / A of mild and catastrophic wear, (ug/m/mm2) / (N/mm2)."""
    severe: ClassVar[float] = 55.0
    """Rate of severe wear, ug/m/mm2."""

    @property
    def name(self) -> str:
        """See `WearLaw`."""
        return f"T-gamma/A, USFD, third branch {'continuous' if self.branch == 'continuous' else 'as published'}"

    def micrograms(self, t_gamma_over_area: Floats) -> Floats:
        """Rate in ug/m/mm2 by T-gamma over area in N/mm2."""
        x, start = t_gamma_over_area, self.limits[1] if self.branch == "continuous" else 0.0
        third = self.slopes[1] * (x - start) + (self.severe if self.branch == "continuous" else 0.0)
        return np.where(x < self.limits[0], self.slopes[0] * x, np.where(x < self.limits[1], self.severe, third))

    def rates(self, cells: CellLoads) -> Floats:
        """See `WearLaw`."""
        return RATE_UNITS["ug/m/mm2"] * self.micrograms(cells.energy)


class EnergyLaw(_Law):
    """Worn volume or mass in proportion to the dissipated energy."""

    kind: Literal["energy"] = "energy"
    """volume or mass in proportion to the dissipated energy"""
    constant: Positive
    """worn volume or mass over energy"""
    unit: EnergyUnit
    """unit of the constant"""

    @property
    def name(self) -> str:
        """See `WearLaw`."""
        return f"energy, {self.constant:g} {self.unit}"

    def rates(self, cells: CellLoads) -> Floats:
        """See `WearLaw`."""
        return self.constant * ENERGY_UNITS[self.unit] * cells.energy


@dataclass(frozen=True)
class OwnLaw:
    """A law by a function.

    - `function`: of pressures (...), slips (..., 2) and tractions (..., 2) as in `CellLoads`; returns the rate (...).
    - `unit`: of the rate, one of `RATE_UNITS`.
    - `title`: what reports call it.
    """

    function: Callable[[Floats, Floats, Floats], Floats] = field(repr=False)  # has another address in each session
    unit: str
    title: str = "own law"

    def __post_init__(self) -> None:
        if not callable(self.function):
            advice = "give a function of pressures, slips and tractions"
            raise refused("OwnLaw", "function", self.function, "a function that returns the rate", advice)
        if self.unit not in [*RATE_UNITS]:  # a list of them is no unit, but has no place in a mapping either
            raise InputError(f"OwnLaw(unit={self.unit!r})", ", ".join(RATE_UNITS), "give the unit of the rate")

    @property
    def name(self) -> str:
        """See `WearLaw`."""
        return self.title

    def rates(self, cells: CellLoads) -> Floats:
        """See `WearLaw`; an `InputError` if the function returns another shape, or what is negative or not finite."""
        rates = as_numbers(self.title, self.function(cells.pressures, cells.slips, cells.tractions))
        if rates.shape != cells.pressures.shape or not (np.isfinite(rates) & (rates >= 0.0)).all():
            raise InputError(
                f"{self.title}: rates of shape {rates.shape} for {cells.pressures.shape}, or some not >= 0",
                "a finite rate >= 0 for each cell",
                "correct the function",
            )
        return RATE_UNITS[self.unit] * rates


@dataclass(frozen=True)
class PerPatch:
    """A law evaluated once for a patch, at means over its area; the depth is spread as the dissipated energy is."""

    law: WearLaw

    def __post_init__(self) -> None:
        check_kind("PerPatch", "law", self.law, WearLaw, "a wear law", "give one such as UsfdLaw()")

    @property
    def name(self) -> str:
        """See `WearLaw`."""
        return f"{self.law.name}, per patch"

    def rates(self, cells: CellLoads) -> Floats:
        """See `WearLaw`."""
        t_gamma = cells.t_gamma_N
        volume = float(self.law.rates(cells.mean())[0]) * cells.contact_area_mm2
        return np.asarray(cells.energy * (volume / t_gamma if t_gamma > 0.0 else 0.0))


# --- Wear of wheels and rails by the patches of one wheelset: areas worn off their profiles, by rows of cells.


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


def patch_loads(creep: CreepState) -> CellLoads:
    """Loads of the cells of a patch that rolls; its energy over the distance is the patch's T-gamma.

    An `InputError` if its theory has no tractions and slip on cells.
    """
    forces, speed = creep.cells, creep.speed
    if forces is None:
        raise InputError(
            f"wear by creep forces of the theory {creep.theory}",
            f"a theory with slip in the cells: {THEORIES_WITH_CELLS}",
            "choose one of them as rolling.theory",
        )
    scale = abs(forces.motion.speed) or 1.0
    loads = CellLoads(
        creep.contact.pressures,
        forces.tractions,
        forces.slip_velocities / scale,
        np.broadcast_to(creep.contact.areas, creep.contact.pressures.shape),
        speed,
        forces.power_density / scale if isinstance(forces, Rolling) else None,
    )
    # single cells may have a negative power, and FASTSIM's strips are interpolated on cells
    total = loads.t_gamma_N
    energy = loads.energy * (creep.t_gamma_N / total if total > 0.0 else 0.0)
    return CellLoads(loads.pressures, loads.tractions, loads.slips, loads.areas, speed, energy)


def row_wear(result: SpatialResult, laws: dict[Role, WearLaw]) -> list[RowWear]:
    """Wear of both sides' wheels and rails by a wheelset that rolls; bodies without a law do not wear."""
    rows: list[RowWear] = []
    for patch, creep in result.rolling:
        loads, damage = patch_loads(creep), float(t_gamma_damage(np.array(creep.t_gamma_N)).net)
        for role in ROLES:
            if role not in laws:
                continue
            # area of a row: sum over its cells of rate times the area of the cell, each passed along its strip
            areas = (laws[role].rates(loads) * loads.areas).sum(axis=1)
            worn = np.flatnonzero(areas)
            if not worn.size:
                continue
            ends, radii = _ends(patch, creep, role)
            rows.append(RowWear(patch.side, role, ends[worn], areas[worn], radii[worn], damage))
    return rows


def _ends(patch: WheelPatch, creep: CreepState, role: Role) -> tuple[Floats, Floats]:
    """Ends of the rows of cells (n, 2, 2) in the frame of a profile, and their distances from the axle (n,)."""
    state, rows = patch.state, rows_of(patch.state, creep.contact)
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
    damages = []
    for patch, creep in result.rolling:
        p0, friction = patch.max_pressure, creep.used_friction
        damages.append(
            PatchDamage(
                patch.side,
                patch.region,
                p0,
                creep.t_gamma_N,
                friction,
                None if shear is None else surface_fatigue_index(friction, patch.semi_axes, creep.contact.force, shear),
                None if shear is None else shakedown_index(p0, shear, friction),
                float(t_gamma_damage(np.array(creep.t_gamma_N)).net),
            )
        )
    return damages
