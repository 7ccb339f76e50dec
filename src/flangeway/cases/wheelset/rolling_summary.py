"""What rolling with friction leaves for programs to read."""

from collections.abc import Sequence
from dataclasses import dataclass

from flangeway.cases.summary import SummaryPart
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.spatial_result import SpatialResult

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True, kw_only=True)
class RollingSummary(SummaryPart):
    """How the wheelset rolls: torque on the axle, moment that guides it, Nadal's limits, and power.

    `yaw_moment_kNm` is that of the contact on the wheelset, counter-clockwise from above, `traction_kN` the sum of
    creep forces ahead, `power_W` what friction dissipates. Nadal's limits are those of the left and the right wheel;
    L/V over them is None for a wheel whose flange does not touch; above 1 the criterion is exceeded, and flange
    climb is possible. The kinematic (Klingel's) wave is that of the equivalent conicity of rigid wheels at 3 mm,
    None where there is none.
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
    shares_of_nadal_limits: Sequence[float | None]
    nadal_criterion_exceeded: bool
    kinematic_wavelength_m: float | None
    kinematic_frequency_Hz: float | None


def rolling_summary(result: SpatialResult) -> RollingSummary | None:
    """Return how a solved wheelset rolls, None without friction."""
    motion, rolled = result.wheelset.model.rolling, result.equilibrium.state.rolled
    if motion is None or rolled is None:
        return None
    length, limits = result.kinematic_wavelength_mm, [result.nadal_limit(side) for side in SIDES]
    shares = [
        result.lateral_over_vertical(side) / limit if result.flange_touches(side) else None
        for side, limit in zip(SIDES, limits, strict=True)
    ]
    return RollingSummary(
        speed_km_h=3.6 * motion.speed_m_s,
        rate_rad_per_s=rolled.rate_rad_s,
        yaw_mrad=1e3 * rolled.yaw_rad,
        yaw_moment_kNm=rolled.yaw_moment_Nmm / 1e6,
        torque_kNm=-rolled.torque_Nmm / 1e6,
        traction_kN=sum(float(each.creep_force_on_wheel_N[2]) for each in result.rolling) / 1e3,
        t_gamma_N=sum(each.t_gamma_N for each in result.rolling),
        power_W=sum(each.power_W for each in result.rolling),
        nadal_limits=limits,
        shares_of_nadal_limits=shares,
        nadal_criterion_exceeded=any(share is not None and share > 1.0 for share in shares),
        kinematic_wavelength_m=None if length is None else length / 1e3,
        kinematic_frequency_Hz=None if length is None else 1e3 * motion.speed_m_s / length,
    )
