"""What a wheelset in three dimensions leaves for programs to read: forces and positions in the track's axes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.cases.summary import StatusSummary, Summary, SummaryPart
from flangeway.cases.wheelset.wheelset_summary import (
    LoadSummary,
    PositionSummary,
    ResidualSummary,
    SideSummary,
)
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.spatial.wheel_patch import SpatialPatch
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES, Side
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True)
class BelowSummary(SummaryPart):
    """Maximum stresses on the normal below a centre of pressure, with their depths."""

    max_von_mises_MPa: float
    max_von_mises_depth_mm: float
    max_shear_MPa: float
    max_shear_depth_mm: float


@dataclass(frozen=True, kw_only=True)
class WheelPatchSummary(SummaryPart):
    """A contact patch; Hertz's values are None where the curvatures vary too much within it."""

    side: Side
    region: str
    normal_force_kN: float
    lateral_force_kN: float
    vertical_force_kN: float
    contact_angle_deg: float
    max_pressure_MPa: float
    max_pressure_remark: str
    hertz_pressure_MPa: float | None
    semi_axes_mm: Sequence[float]
    hertz_semi_axes_mm: Sequence[float] | None
    angle_deg: float
    area_mm2: float
    conformity_deg: float
    rail_position_mm: Sequence[float]
    wheel_position_mm: Sequence[float]
    track_position_mm: Sequence[float]
    rolling_radius_mm: float
    cells: Sequence[int]
    in_rail: BelowSummary
    in_wheel: BelowSummary


@dataclass(frozen=True)
class RailMotionSummary(SummaryPart):
    """Motion of a rail's head at the wheel in the track's axes, and of its gauge face away from the middle."""

    side: Side
    lateral_mm: float
    vertical_mm: float
    roll_rad: float
    gauge_outward_mm: float


@dataclass(frozen=True, kw_only=True)
class SpatialWheelsetSummary(Summary):
    """What ``summary.json`` of a wheelset in three dimensions holds."""

    position: PositionSummary
    load: LoadSummary
    residual: ResidualSummary
    sides: Sequence[SideSummary]
    patches: Sequence[WheelPatchSummary]
    rails: Sequence[RailMotionSummary]
    assumptions: Sequence[str]
    warnings: Sequence[str]


def patch_summary(patch: SpatialPatch) -> WheelPatchSummary:
    """Return the numbers of a patch."""
    lateral, vertical = (patch.force_on_wheel_N / 1e3).tolist()
    hertz, ellipse = patch.hertz, patch.ellipse
    below = {role: _below(patch, role) for role in ROLES}
    return WheelPatchSummary(
        side=patch.side,
        region=patch.region,
        normal_force_kN=math.hypot(lateral, vertical),
        lateral_force_kN=lateral,
        vertical_force_kN=vertical,
        contact_angle_deg=math.degrees(patch.contact_angle_rad),
        max_pressure_MPa=ellipse.max_pressure,
        max_pressure_remark=patch.remark,
        hertz_pressure_MPa=hertz.max_pressure if hertz else None,
        semi_axes_mm=ellipse.semi_axes,
        hertz_semi_axes_mm=hertz.semi_axes if hertz else None,
        angle_deg=math.degrees(ellipse.angle_rad),
        area_mm2=ellipse.area,
        conformity_deg=patch.conformity_deg,
        rail_position_mm=patch.rail_point_mm.tolist(),
        wheel_position_mm=patch.wheel_point_mm.tolist(),
        track_position_mm=patch.centre_mm.tolist(),
        rolling_radius_mm=patch.rolling_radius_mm,
        cells=ellipse.cells,
        in_rail=below["rail"],
        in_wheel=below["wheel"],
    )


def _below(patch: SpatialPatch, role: Role) -> BelowSummary:
    line = patch.below(role)
    mises, shear = line.stresses.von_mises, line.stresses.tresca / 2.0

    def at(values: Floats) -> tuple[float, float]:
        number = int(np.argmax(values))
        return float(values[number]), float(line.depths[number])

    return BelowSummary(*at(mises), *at(shear))


def summarise_spatial_wheelset(
    case: dict[str, object], result: SpatialResult, assumptions: Sequence[str], total_s: float
) -> SpatialWheelsetSummary:
    """Return the summary of a solved wheelset.

    Parameters
    ----------
    case
        Name and inputs.
    result
        The solution.
    assumptions
        Sentences on what the model leaves out.
    total_s
        Wall-clock time of the computation in seconds.

    """
    equilibrium, load = result.equilibrium, result.problem.load
    motion, in_space, residual = equilibrium.position, result.position_in_space, equilibrium.residuals
    along, onto = load.in_track
    return SpatialWheelsetSummary(
        status=StatusSummary(result.status.converged, result.status.message),
        position=PositionSummary(
            *(motion.vertical_mm, motion.lateral_mm, motion.roll_rad, result.approach_mm),
            *(in_space.lateral_mm, in_space.vertical_mm, equilibrium.stable),
        ),
        load=LoadSummary(load.vertical_N / 1e3, load.lateral_N / 1e3, load.tilt_rad, along / 1e3, onto / 1e3),
        residual=ResidualSummary(
            *(residual.vertical_residual, residual.lateral_residual, residual.moment_residual),
            residual.equilibrium_residual,
        ),
        sides=[
            SideSummary(side, lateral / 1e3, vertical / 1e3, result.lateral_over_vertical(side))
            for side in SIDES
            for lateral, vertical in [result.force_on_wheel_N(side)]
        ],
        patches=[patch_summary(patch) for patch in result.patches],
        rails=[RailMotionSummary(side, *result.head_motion(side)) for side in SIDES],
        timings_s=result.timings_s | {"total": total_s},
        case=dict(case),
        assumptions=list(assumptions),
        warnings=list(result.warnings),
    )
