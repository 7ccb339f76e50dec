"""The patches of a wheelset that rolls: pictures and numbers of friction."""

from collections.abc import Callable

from matplotlib.figure import Figure

from flangeway.cases.wheelset.rolling_summary import RollingSummary
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetRun
from flangeway.cases.wheelset.spatial_wheelset_summary import SpatialWheelsetSummary, WheelPatchSummary
from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.contact.rolling.theories import WITH_TRACTIONS, Theory
from flangeway.railway.track.placements import SIDE_SIGN, SIDES
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report.page.record import Picture
from flangeway.report.page.tables import Column, SummaryTable, number, table_across
from flangeway.report.rolling.creep_curves import curves_figure
from flangeway.report.rolling.rolling_maps import ShownRolling, rolling_figure
from flangeway.report.rolling.shakedown_figure import shakedown_figure
from flangeway.report.spatial_wheelset.wheelset_patches import patch_map, patch_name

MAPS, CURVES, SHAKEDOWN = "rolling.png", "creep-curves.png", "shakedown.png"
CAPTIONS = {
    MAPS: "Each patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the wheel; "
    "slip velocity; frictional power over the area.",
    CURVES: "Creep force on the wheel over the creepage in the same direction, from zero to beyond the working point; "
    "the other creepages are those of the working point. Spin gives a lateral force without lateral creepage.",
    SHAKEDOWN: "Maximum pressure over the shear strength and traction coefficient of each patch, among the limits of "
    "a circular patch and of a line contact. Above the highest limit steel yields under each wheel.",
}
AXES = {
    "creepage": "and creep force: of the wheel on the rail: ahead, and along the rail's surface to the right; spin "
    "and its moment counter-clockwise seen from above",
    "T-gamma": "energy that friction dissipates over the distance rolled: its power over the speed; N is J/m. Without "
    "and with spin: creep forces times creepages at the centre of the patch, and spin moment times spin",
}


def rolling_names(theory: Theory) -> tuple[str, ...]:
    """Names of the pictures of patches that roll by a theory."""
    return (*((MAPS,) if theory in WITH_TRACTIONS else ()), CURVES, SHAKEDOWN)


def shown_patches(result: SpatialResult) -> list[ShownRolling]:
    """Patches as they are drawn: right of the track to the right, lengths from the middle of the rail's profile."""
    return [
        ShownRolling(
            patch_name(each.patch, result.patches),
            each.forces,
            each.forces.contact if isinstance(each.forces, Rolling | SimplifiedRolling) else each.contact,
            each.speed_m_s,
            patch_map(result, each.patch.side).origin,
            SIDE_SIGN[each.patch.side],
        )
        for each in result.rolling
    ]


def rolling_pictures(run: SpatialWheelsetRun) -> list[Picture]:
    """Pictures of the patches that roll; none without friction."""
    result, strength = run.result, run.result.yield_MPa
    shown = shown_patches(result)
    with_fields = [each for each in shown if isinstance(each.found, Rolling | SimplifiedRolling)]
    figures: dict[str, Callable[[], Figure]] = {}
    if with_fields:
        figures[MAPS] = lambda: rolling_figure(with_fields)
    if shown:
        figures[CURVES] = lambda: curves_figure(shown)
    if shown and strength is not None:
        points = [
            (each.name, rolling.used_friction, rolling.patch.ellipse.max_pressure)
            for each, rolling in zip(shown, result.rolling, strict=True)
        ]
        figures[SHAKEDOWN] = lambda: shakedown_figure(points, strength)
    return [Picture(name, draw, CAPTIONS[name], chapter="Rolling") for name, draw in figures.items()]


def _of(name: str, factor: float = 1.0) -> Callable[[WheelPatchSummary], float | None]:
    def value(patch: WheelPatchSummary) -> float | None:
        found = getattr(patch.rolling, name)
        return None if found is None else factor * found

    return value


ROLLING: tuple[Column, ...] = (
    ("longitudinal creepage, %", _of("longitudinal_creepage", 100.0), "z.4f"),
    ("lateral creepage, %", _of("lateral_creepage", 100.0), "z.4f"),
    ("spin creepage, 1/m", _of("spin_creepage_per_m"), "z.4f"),
    ("longitudinal creep force, kN", _of("longitudinal_creep_force_kN"), "z.3f"),
    ("lateral creep force, kN", _of("lateral_creep_force_kN"), "z.3f"),
    ("traction coefficient", _of("traction_coefficient"), ".3f"),
    ("T-gamma, N", _of("t_gamma_N"), ".2f"),
)
FURTHER_ROLLING: tuple[Column, ...] = (
    ("T-gamma without spin, N", _of("t_gamma_without_spin_N"), "z.2f"),
    ("T-gamma with spin, N", _of("t_gamma_with_spin_N"), "z.2f"),
    ("spin moment, N m", _of("spin_moment_Nm"), "z.2f"),
    ("frictional power, W", _of("frictional_power_W"), ".1f"),
    ("  maximum power density, W/mm²", _of("max_power_density_W_mm2"), ".2f"),
    ("slip area, %", _of("slipping_share", 100.0), ".0f"),
    ("maximum traction, MPa", _of("max_traction_MPa"), ".0f"),
    ("maximum slip velocity, m/s", _of("max_slip_velocity_m_s"), ".4f"),
)
"""ROLLING, FURTHER_ROLLING: numbers of a patch that rolls, those of the table of results and further ones."""


def rolling_table(summary: SpatialWheelsetSummary) -> SummaryTable:
    """Creep forces and power of the patches, one column a patch."""
    patches = summary.patches
    theory = patches[0].rolling.theory if patches[0].rolling else ""
    caption = f"Rolling: creep forces of the {theory} theory; the stresses below the patches include their tractions"
    names = [f"{p.side} {p.region}" for p in patches]
    return table_across(caption, names, patches, (*ROLLING, *FURTHER_ROLLING))


def _nadal_words(rolling: RollingSummary) -> str:
    """Nadal's criterion for the wheels whose flanges touch, in words."""
    shares = zip(SIDES, rolling.shares_of_nadal_limits, strict=True)
    words = [
        f"{side} wheel {'exceeded' if share > 1.0 else 'not exceeded'} ({100.0 * share:.0f} %)"
        for side, share in shares
        if share is not None
    ]
    return ", ".join(words) or "no flange contact"


def motion_tables(summary: SpatialWheelsetSummary) -> list[SummaryTable]:
    """How the whole wheelset rolls, if creep forces are part of its equilibrium."""
    found = summary.rolling
    if found is None:
        return []
    rows = (
        ("speed, km/h", f"{found.speed_km_h:g}"),
        ("rotation, rad/s", number(found.rate_rad_per_s, 4)),
        ("yaw, mrad", f"{found.yaw_mrad:z.3f}"),
        ("yaw moment from contact forces, kN m", f"{found.yaw_moment_kNm:z.3f}"),
        ("torque on the axle, kN m", f"{found.torque_kNm:z.3f}"),
        ("traction, kN", f"{found.traction_kN:z.3f}"),
        ("T-gamma of all patches, N", number(found.t_gamma_N, 1)),
        ("frictional power, W", number(found.power_W, 0)),
        ("Nadal's criterion", _nadal_words(found)),
        ("kinematic wave (Klingel): length, m", number(found.kinematic_wavelength_m, 2)),
        ("  frequency, Hz", number(found.kinematic_frequency_Hz, 2)),
    )
    return [SummaryTable("Motion of the wheelset", ("", "value"), rows)]
