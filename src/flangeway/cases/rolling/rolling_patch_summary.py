"""What a case of one patch that rolls leaves for programs to read."""

from collections.abc import Sequence
from dataclasses import dataclass

from flangeway.cases.summary import Summary, SummaryPart

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True, kw_only=True)
class TheoryForces(SummaryPart):
    """Creepages, and creep forces on the upper body by one theory; forces ahead and to the right."""

    theory: str
    longitudinal_creepage: float
    lateral_creepage: float
    spin_creepage_per_m: float
    longitudinal_force_kN: float
    lateral_force_kN: float
    spin_moment_Nm: float
    t_gamma_N: float
    t_gamma_without_spin_N: float
    t_gamma_with_spin_N: float


@dataclass(frozen=True, kw_only=True)
class ShiftSummary(SummaryPart):
    """Shift of the upper body ahead and to the right, its rotation, maximum slip, and the work of friction."""

    longitudinal_mm: float
    lateral_mm: float
    rotation_mrad: float
    max_slip_mm: float
    dissipated_N_mm: float


@dataclass(frozen=True, kw_only=True)
class RollingPatchSummary(Summary):
    """What ``summary.json`` of such a case holds.

    Semi-axes are those along and across of the ellipse with the second moments of the pressures. `rolling` is what the
    chosen theory gives and None for a shift, `shift` is None for rolling. What only fields of tractions have is None
    for theories without them; residuals are those of `flangeway.contact.rolling.rolling_result.Rolling.residuals`, and
    `energy_error` is the difference of frictional power from forces times creepages, over the power.
    """

    theory: str
    force_kN: float
    semi_axis_along_mm: float
    semi_axis_across_mm: float
    max_pressure_MPa: float
    cells: Sequence[int]
    longitudinal_force_kN: float
    lateral_force_kN: float
    spin_moment_Nm: float
    traction_coefficient: float
    rolling: TheoryForces | None
    shift: ShiftSummary | None
    frictional_power_W: float | None
    slipping_share: float | None
    max_traction_MPa: float | None
    max_slip_velocity_m_s: float | None
    max_power_density_W_mm2: float | None
    residuals: dict[str, float]
    energy_error: float | None
    theories: Sequence[TheoryForces]
    notices: Sequence[str]
