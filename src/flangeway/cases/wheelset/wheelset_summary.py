"""What a run of a wheelset found: the contents of ``summary.json``, forces and positions in the track's axes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from flangeway.cases.summary import StatusSummary, Summary, SummaryPart
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

# ruff: noqa: N815 (units in names)

REFERENCE = (
    "Position relative to the reference position, in which the axle is level, in the middle of the track, and the "
    "wheels' tape lines are at the height of the rails' tops (y = 0), in the track's axes. The approach is the descent "
    "from the position in which rigid wheels touch (in a curve: from the rigid equilibrium)."
)
AXES = {
    "space": (
        "The track's axes: x across the track to the right, y up from its plane; origin in the middle of the track at "
        "the top of the rails; roll counter-clockwise about the axle's middle. Superelevation turns them in space."
    ),
    "rail": (
        "The right rail's profile: x from the middle of its base away from the middle of the track, y up "
        "from its base, before its inclination. The left rail is its mirror image."
    ),
    "wheel": (
        "The right wheel's profile: x from the tape line away from the middle of the track, y up to the "
        "axle. The left wheel is its mirror image."
    ),
    "forces": "Of the rail on the wheel, the track's axes: a positive lateral force pushes the wheel to the right.",
}


@dataclass(frozen=True)
class PositionSummary(SummaryPart):
    """Position of the wheelset, relative to the reference position that is described."""

    vertical_mm: float
    lateral_mm: float
    roll_rad: float
    approach_mm: float
    horizontal_in_space_mm: float
    vertical_in_space_mm: float
    stable: bool | None
    reference: str = REFERENCE


@dataclass(frozen=True)
class LoadSummary(SummaryPart):
    """Load on the wheelset in space, and its components in the track plane and onto it."""

    vertical_kN: float
    lateral_kN: float
    tilt_rad: float
    lateral_in_track_kN: float
    onto_track_kN: float


@dataclass(frozen=True)
class ResidualSummary(SummaryPart):
    """Relative residuals of the equilibrium, and the norm of those of what is free."""

    vertical: float
    lateral: float
    moment: float
    equilibrium: float


@dataclass(frozen=True)
class SideSummary(SummaryPart):
    """Total force on a wheel, and L/V; None without contact."""

    side: Side
    lateral_force_kN: float
    vertical_force_kN: float
    lateral_over_vertical: float | None


def equilibrium_parts(result: WheelsetResult | SpatialResult, load: WheelsetLoad) -> dict[str, Any]:
    """Status, position, load, residuals and forces on both wheels: the parts that all summaries of wheelsets have."""
    equilibrium, in_space = result.equilibrium, result.position_in_space
    motion, residuals, (along, onto) = equilibrium.position, equilibrium.residuals, load.in_track
    return {
        "status": StatusSummary(result.status.converged, result.status.message),
        "position": PositionSummary(
            *(motion.vertical_mm, motion.lateral_mm, motion.roll_rad, result.approach_mm),
            *(in_space.lateral_mm, in_space.vertical_mm, equilibrium.stable),
        ),
        "load": LoadSummary(load.vertical_N / 1e3, load.lateral_N / 1e3, load.tilt_rad, along / 1e3, onto / 1e3),
        "residual": ResidualSummary(
            *(residuals.vertical_residual, residuals.lateral_residual, residuals.moment_residual),
            residuals.equilibrium_residual,
        ),
        "sides": [
            SideSummary(side, lateral / 1e3, vertical / 1e3, result.lateral_over_vertical(side))
            for side in SIDES
            for lateral, vertical in [result.force_on_wheel_N(side)]
        ],
    }


@dataclass(frozen=True)
class SubsurfaceSummary(SummaryPart):
    """Maximum stresses on the normal below a centre of pressure, with their depths."""

    max_in_plane_shear_MPa: float | None
    max_in_plane_shear_depth_mm: float | None
    max_von_mises_MPa: float | None
    max_von_mises_depth_mm: float | None


@dataclass(frozen=True, kw_only=True)
class RigidContactSummary(SummaryPart):
    """A point of contact of rigid wheels on rigid rails; forces are None where the lateral position is prescribed."""

    side: Side
    force_kN: float | None
    lateral_force_kN: float | None
    vertical_force_kN: float | None
    contact_angle_deg: float
    rail_position_mm: Sequence[float]
    wheel_position_mm: Sequence[float]
    space_position_mm: Sequence[float]
    hertz_half_width_mm: float | None
    hertz_pressure_MPa: float | None
    rolling_radius_mm: float


@dataclass(frozen=True, kw_only=True)
class ContactSummary(SummaryPart):
    """Force, position, pressure and subsurface stresses of one region of contact."""

    side: Side
    region: str
    force_kN: float
    lateral_force_kN: float
    vertical_force_kN: float
    contact_angle_deg: float
    rail_position_mm: Sequence[float]
    wheel_position_mm: Sequence[float]
    space_position_mm: Sequence[float]
    half_width_mm: float
    max_pressure_MPa: float
    max_pressure_remark: str | None
    pressure_oscillation: float
    hertz_half_width_mm: float | None
    hertz_pressure_MPa: float | None
    hertz_in_plane_shear_MPa: float | None
    hertz_in_plane_shear_depth_mm: float | None
    n_nodes: int
    in_rail: SubsurfaceSummary
    in_wheel: SubsurfaceSummary


@dataclass(frozen=True)
class RigidSummary(SummaryPart):
    """Position and contact points of rigid wheels on rigid rails."""

    vertical_mm: float
    lateral_mm: float
    roll_rad: float
    horizontal_in_space_mm: float
    vertical_in_space_mm: float
    contacts: Sequence[RigidContactSummary]


@dataclass(frozen=True)
class StressSummary(SummaryPart):
    """Extreme element averages of the stresses of a part: below the contacts, and anywhere in the slice."""

    part: str
    max_von_mises_below_contacts_MPa: float | None
    max_von_mises_MPa: float
    min_principal_MPa: float
    max_in_plane_shear_MPa: float


@dataclass(frozen=True)
class MeshSummary(SummaryPart):
    """Mesh of a body, and the parts that it is used for."""

    name: str
    unknowns: int
    elements: int
    nodes: int
    parts: Sequence[str]


@dataclass(frozen=True)
class PublishedPosition(SummaryPart):
    """A published position, and why it differs."""

    vertical_mm: float
    horizontal_mm: float
    roll_rad: float
    reason: str


@dataclass(frozen=True, kw_only=True)
class WheelsetSummary(Summary):
    """What ``summary.json`` of a wheelset holds."""

    position: PositionSummary
    load: LoadSummary
    residual: ResidualSummary
    sides: Sequence[SideSummary]
    contacts: Sequence[ContactSummary]
    rigid: RigidSummary
    stresses: Sequence[StressSummary]
    bodies: Sequence[MeshSummary]
    axes: dict[str, str] = field(default_factory=lambda: AXES)
    assumptions: Sequence[str]
    published: PublishedPosition | None
    warnings: Sequence[str]
