"""What rolling with friction leaves for programs to read."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.cases.summary import SummaryPart
from flangeway.contact.rolling.rolling_result import SLIPS, STICKS, Rolling
from flangeway.railway.spatial.rolling.patch_rolling import RollingPatch
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.track.placements import SIDES, Side

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True, kw_only=True)
class CreepSummary(SummaryPart):
    """Creepages and creep forces of a patch on the wheel: ahead, to the right, upwards, counter-clockwise from above.

    `sticking` is the share of the patch that sticks, None for theories without it.
    """

    side: Side
    region: str
    longitudinal_creepage: float
    lateral_creepage: float
    spin_per_m: float
    longitudinal_force_kN: float
    lateral_force_kN: float
    vertical_force_kN: float
    spin_moment_Nm: float
    used_friction: float
    sticking: float | None
    t_gamma_N: float
    power_W: float


@dataclass(frozen=True, kw_only=True)
class RollingSummary(SummaryPart):
    """How the wheelset rolls: torque on the axle, moment that guides it, L/V beside Nadal's limit, and power.

    `yaw_moment_kNm` is that of the contact on the wheelset, counter-clockwise from above, `traction_kN` the sum of
    creep forces ahead. Nadal's limits are those of the left and the right wheel. The kinematic (Klingel's) wave is that
    of the equivalent conicity of rigid wheels at 3 mm, None where there is none.
    """

    speed_km_h: float
    rate_rad_per_s: float
    yaw_mrad: float
    yaw_moment_kNm: float
    torque_kNm: float
    traction_kN: float
    t_gamma_N: float
    power_W: float
    nadal_limits: Sequence[float]
    kinematic_wavelength_m: float | None
    kinematic_frequency_Hz: float | None
    patches: Sequence[CreepSummary]


def creep_summary(found: RollingPatch) -> CreepSummary:
    """Return the numbers of a patch."""
    lateral, vertical, along = (found.creep_force_on_wheel_N / 1e3).tolist()
    sticking = None
    if isinstance(found.forces, Rolling):
        states = found.forces.states
        sticking = float((states == STICKS).sum() / np.isin(states, (STICKS, SLIPS)).sum())
    return CreepSummary(
        side=found.patch.side,
        region=found.patch.region,
        longitudinal_creepage=found.longitudinal_creepage,
        lateral_creepage=found.lateral_creepage,
        spin_per_m=found.spin_creepage_per_m,
        longitudinal_force_kN=along,
        lateral_force_kN=lateral,
        vertical_force_kN=vertical,
        spin_moment_Nm=found.spin_moment_Nm,
        used_friction=found.used_friction,
        sticking=sticking,
        t_gamma_N=found.t_gamma_N,
        power_W=found.power_W,
    )


def rolling_summary(result: SpatialResult) -> RollingSummary | None:
    """Return how a solved wheelset rolls, None without friction."""
    motion, rolled = result.wheelset.model.rolling, result.equilibrium.state.rolled
    if motion is None or rolled is None:
        return None
    length = result.kinematic_wavelength_mm
    return RollingSummary(
        speed_km_h=3.6 * motion.speed_m_s,
        rate_rad_per_s=rolled.rate_rad_s,
        yaw_mrad=1e3 * rolled.yaw_rad,
        yaw_moment_kNm=rolled.yaw_moment_Nmm / 1e6,
        torque_kNm=-rolled.torque_Nmm / 1e6,
        traction_kN=sum(float(each.creep_force_on_wheel_N[2]) for each in result.rolling) / 1e3,
        t_gamma_N=sum(each.t_gamma_N for each in result.rolling),
        power_W=sum(each.power_W for each in result.rolling),
        nadal_limits=[result.nadal_limit(side) for side in SIDES],
        kinematic_wavelength_m=None if length is None else length / 1e3,
        kinematic_frequency_Hz=None if length is None else 1e3 * motion.speed_m_s / length,
        patches=[creep_summary(each) for each in result.rolling],
    )
