"""What a run of a wheelset found: the contents of ``summary.json``, forces and positions in the track's axes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from flangeway.cases.summary import StatusSummary, Summary, SummaryPart
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

# ruff: noqa: N815 (units in names)

REFERENCE = (
    "Position relative to the reference position, in which the axle is level, in the middle of the track, and the "
    "wheels' tape lines are at the height of the rails' tops (y = 0), in the track's axes; beside it along horizontal "
    "and vertical. The approach is the descent from the position in which rigid wheels touch (in a curve: from the "
    "rigid equilibrium)."
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
    "bending": (
        "Displacements of a rail's head are those of its top against the fixed base, the track's axes; stresses along "
        "the free surface between head and base, tension positive, positions in the rail's profile."
    ),
    "support": (
        "Forces of the base on the rail, or of the axle on the wheel, the track's axes; moments counter-clockwise "
        "about the middle of the base or of the axle, in kN mm; the eccentricity of a base's force is positive away "
        "from the track."
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
class OtherEquilibrium(SummaryPart):
    """A further equilibrium."""

    vertical_mm: float
    lateral_mm: float
    roll_rad: float
    stable: bool | None
    equilibrium_residual: float


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
class FilletSummary(SummaryPart):
    """Extreme stresses along the surface between the narrowest section of the web and the head or the foot."""

    face: str
    towards: str
    max_tension_MPa: float | None
    tension_position_mm: Sequence[float]
    max_compression_MPa: float | None
    compression_position_mm: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class BendingSummary(SummaryPart):
    """Displacement of a rail's head, forces in its web, stresses in web and fillets."""

    side: Side
    head_lateral_mm: float
    head_vertical_mm: float
    head_roll_rad: float
    head_roll_outward_rad: float
    gauge_outward_mm: float
    web_height_mm: float
    web_thickness_mm: float
    web_normal_force_kN: float
    web_shear_force_kN: float
    web_moment_kN_mm: float
    web_gauge_face_MPa: float
    web_field_face_MPa: float
    fillets: Sequence[FilletSummary]


@dataclass(frozen=True)
class ReactionSummary(SummaryPart):
    """Force and moment of a base or of the axle on a part; the eccentricity is None for a wheel."""

    part: str
    lateral_force_kN: float
    vertical_force_kN: float
    moment_kN_mm: float
    reference_mm: Sequence[float]
    eccentricity_mm: float | None
    force_residual: float
    moment_residual: float


@dataclass(frozen=True)
class HoldingSummary(SummaryPart):
    """Force and moment at the axle that hold a prescribed position."""

    lateral_N: float
    vertical_N: float
    moment_N_mm: float


@dataclass(frozen=True)
class SupportSummary(SummaryPart):
    """Reactions of bases and axle; `holding` is None where no position is prescribed."""

    reactions: Sequence[ReactionSummary]
    holding: HoldingSummary | None


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
    other_equilibria: Sequence[OtherEquilibrium]
    load: LoadSummary
    residual: ResidualSummary
    sides: Sequence[SideSummary]
    contacts: Sequence[ContactSummary]
    rigid: RigidSummary
    stresses: Sequence[StressSummary]
    bending: Sequence[BendingSummary]
    support: SupportSummary
    bodies: Sequence[MeshSummary]
    axes: dict[str, str] = field(default_factory=lambda: AXES)
    assumptions: Sequence[str]
    published: PublishedPosition | None
    warnings: Sequence[str]
