"""What a wheelset in three dimensions leaves for programs to read: forces and positions in the track's axes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.cases.summary import Summary, SummaryPart
from flangeway.cases.wheelset.rolling_summary import RollingSummary, rolling_summary
from flangeway.cases.wheelset.wheelset_profiles import side_warnings
from flangeway.cases.wheelset.wheelset_summary import (
    LoadSummary,
    PositionSummary,
    ResidualSummary,
    SideSummary,
    equilibrium_parts,
)
from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import NO_CONTACT, SLIPS, Rolling
from flangeway.post.patch_stresses import StressMaximum
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.rolling.patch_rolling import RollingPatch
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True)
class BelowSummary(SummaryPart):
    """Maximum stresses in the whole volume below a patch, with their depths and positions in the track's axes.

    Tresca's stress is twice the shear stress, tension the first principal stress. The von Mises stress on the normal
    below the centre of pressure stands beside the maximum: it is much less below a divided patch.
    """

    max_von_mises_MPa: float
    max_von_mises_depth_mm: float
    max_von_mises_position_mm: Sequence[float]
    max_tresca_MPa: float
    max_tresca_depth_mm: float
    max_tresca_position_mm: Sequence[float]
    max_tension_MPa: float
    max_tension_depth_mm: float
    max_tension_position_mm: Sequence[float]
    von_mises_below_centre_MPa: float
    von_mises_below_centre_depth_mm: float


@dataclass(frozen=True, kw_only=True)
class PatchRollingSummary(SummaryPart):
    """Friction of a patch that rolls, on the wheel; what only theories with tractions have is None for the others.

    Creepages, and forces along the surface: ahead and to the right; spin: counter-clockwise from above. `t_gamma_N` is
    the power that friction dissipates over the speed; without and with spin: forces times creepages at the centre.
    """

    theory: str
    longitudinal_creepage: float
    lateral_creepage: float
    spin_creepage_per_m: float
    longitudinal_creep_force_kN: float
    lateral_creep_force_kN: float
    spin_moment_Nm: float
    traction_coefficient: float
    t_gamma_N: float
    t_gamma_without_spin_N: float
    t_gamma_with_spin_N: float
    frictional_power_W: float
    slipping_share: float | None
    max_traction_MPa: float | None
    max_slip_velocity_m_s: float | None
    max_power_density_W_mm2: float | None


@dataclass(frozen=True, kw_only=True)
class WheelPatchSummary(SummaryPart):
    """A contact patch; Hertz's values are None where the curvatures vary too much within it.

    `pressure_over_shear_strength` is the maximum pressure over k = yield strength / sqrt(3), None if the bodies are not
    of steel and it is not given; `shakedown_state` is elastic, shakedown (elastic after the first passages), hardening
    (the same with kinematic hardening) or yields (in each passage), for a circular patch; `rolling` is
    None without friction.
    """

    side: Side
    region: str
    normal_force_kN: float
    lateral_force_kN: float
    vertical_force_kN: float
    contact_angle_deg: float
    max_pressure_MPa: float
    max_pressure_remark: str
    pressure_over_shear_strength: float | None
    shakedown_state: str | None
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
    rolling: PatchRollingSummary | None


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
    rolling: RollingSummary | None
    assumptions: Sequence[str]
    warnings: Sequence[str]


def patch_summary(result: SpatialResult, patch: SpatialPatch) -> WheelPatchSummary:
    """Return the numbers of a patch."""
    rolling = result.rolling_of(patch)
    lateral, vertical = (patch.force_on_wheel_N / 1e3).tolist()
    hertz, ellipse = patch.hertz, patch.ellipse
    below = {role: _below(patch, role, result.tractions_of(patch.side)) for role in ROLES}
    return WheelPatchSummary(
        side=patch.side,
        region=patch.region,
        normal_force_kN=math.hypot(lateral, vertical),
        lateral_force_kN=lateral,
        vertical_force_kN=vertical,
        contact_angle_deg=math.degrees(patch.contact_angle_rad),
        max_pressure_MPa=ellipse.max_pressure,
        max_pressure_remark=patch.remark,
        pressure_over_shear_strength=result.load_factor(patch),
        shakedown_state=result.shakedown_state(patch),
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
        rolling=None if rolling is None else _rolling(rolling),
    )


def _rolling(patch: RollingPatch) -> PatchRollingSummary:
    found, fields = patch.forces, None
    scale = patch.speed_m_s / abs(found.motion.speed)
    if isinstance(found, Rolling | SimplifiedRolling):
        loaded = (found.states != NO_CONTACT).sum()
        fields = (
            float((found.states == SLIPS).sum() / loaded),
            float(np.linalg.norm(found.tractions, axis=2).max()),
            scale * float(np.linalg.norm(found.slip_velocities, axis=2).max()),
            scale * float(found.power_density.max()),
        )
    share, traction, slip, power = fields or (None, None, None, None)
    return PatchRollingSummary(
        theory=found.theory,
        longitudinal_creepage=patch.longitudinal_creepage,
        lateral_creepage=patch.lateral_creepage,
        spin_creepage_per_m=patch.spin_creepage_per_m,
        longitudinal_creep_force_kN=found.along / 1e3,
        lateral_creep_force_kN=patch.lateral_creep_force_N / 1e3,
        spin_moment_Nm=patch.spin_moment_Nm,
        traction_coefficient=patch.used_friction,
        t_gamma_N=patch.t_gamma_N,
        t_gamma_without_spin_N=patch.products_N[0],
        t_gamma_with_spin_N=patch.products_N[1],
        frictional_power_W=patch.power_W,
        slipping_share=share,
        max_traction_MPa=traction,
        max_slip_velocity_m_s=slip,
        max_power_density_W_mm2=power,
    )


def _below(patch: SpatialPatch, role: Role, tractions: Floats | None) -> BelowSummary:
    field, line = patch.field(role, tractions), patch.below(role, tractions)
    mises = line.stresses.von_mises
    values: dict[str, Any] = {}
    for name in ("max_von_mises", "max_tresca", "max_tension"):
        found: StressMaximum = getattr(field, name)
        point = patch.points_below(role, *(np.array([each]) for each in found.position))[0]
        values |= {
            f"{name}_MPa": found.value,
            f"{name}_depth_mm": found.position[1],
            f"{name}_position_mm": point.tolist(),
        }
    at = int(mises.argmax())
    return BelowSummary(**values, von_mises_below_centre_MPa=mises[at], von_mises_below_centre_depth_mm=line.depths[at])


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
    return SpatialWheelsetSummary(
        **equilibrium_parts(result, result.problem.load),
        patches=[patch_summary(result, patch) for patch in result.patches],
        rails=[RailMotionSummary(side, *result.head_motion(side)) for side in SIDES],
        rolling=rolling_summary(result),
        timings_s=result.timings_s | {"total": total_s},
        case=dict(case),
        assumptions=list(assumptions),
        warnings=[*result.warnings, *side_warnings(result.problem.track)],
    )
