"""Columns of a campaign's results: the numbers of one run, with units in their names."""

import json
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from flangeway.cases.summary import Summary
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.rolling.patch_rolling import RollingPatch
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

Value = float | int | str | None
Model = Literal["plane", "spatial", "rolling"]
"""Of wheelsets; ``"rolling"`` in addition where they roll with friction."""

POSITION_KEYS = (
    *("lateral_mm", "vertical_mm", "roll_rad", "axle_load_kN", "car_mass_t", "n_axles", "lateral_force_kN"),
    *("speed_km_h", "curve_radius_m", "superelevation_mm", "cant_deficiency_mm", "superelevation_base_mm"),
    "yaw_mrad",
)
"""Inputs of a wheelset that leave its bodies as they are."""

_MOTION = ("lateral_mm", "vertical_mm", "roll_rad")
_FORCES = ("normal_force_N", "lateral_force_N", "vertical_force_N")
_PRESSURE = ("max_pressure_MPa", "max_pressure_remark")
_POINTS = ("contact_angle_deg", "wheel_x_mm", "wheel_y_mm", "rail_x_mm", "rail_y_mm")
_SIZE = {
    "plane": ("half_width_mm",),
    "spatial": ("long_semi_axis_mm", "short_semi_axis_mm", "patch_angle_deg", "ahead_mm", "rolling_radius_mm"),
}
_HERTZ = {
    "plane": ("hertz_pressure_MPa", "hertz_half_width_mm"),
    "spatial": ("hertz_pressure_MPa", "hertz_long_semi_axis_mm", "hertz_short_semi_axis_mm"),
}
_HEAD = ("head_lateral_mm", "head_vertical_mm", "head_roll_rad", "gauge_outward_mm")
"""Motion of a rail's head in three dimensions."""
_CREEPAGES = ("longitudinal_creepage", "lateral_creepage", "spin_creepage_per_m", "traction_coefficient")
_CREEP = ("longitudinal_creep_force_N", "lateral_creep_force_N", "t_gamma_N", "frictional_power_W")
"""Of patches that roll: a side has the creepages of the most loaded one, and the sums of the others."""
_NADAL = "share_of_nadal_limit"


def wheelset_columns(models: Collection[str | None]) -> tuple[str, ...]:
    """Results of wheelsets: their motion; of each side the sums over its patches, and the most loaded patch."""
    sizes = (name for model in _SIZE if model in models for name in _SIZE[model])
    names = ("n_patches", *_FORCES, "lateral_over_vertical", *_PRESSURE, *sizes, *_POINTS)
    head = _HEAD if "spatial" in models else ()
    rolling = (*_CREEPAGES, *_CREEP, _NADAL) if "rolling" in models else ()
    return (*_MOTION, *(f"{side}_{name}" for side in SIDES for name in (*names, *head, *rolling)))


def patch_columns(models: Collection[str | None]) -> tuple[str, ...]:
    """Columns of the table of patches; they are numbered on each side from the field to the gauge."""
    own = dict.fromkeys(name for model in _SIZE if model in models for name in (*_SIZE[model], *_HERTZ[model]))
    rolling = (*_CREEPAGES, *_CREEP) if "rolling" in models else ()
    return ("row", "side", "number", "region", *_FORCES, *_PRESSURE, *own, *_POINTS, *rolling)


WHEELSET_COLUMNS, PATCH_COLUMNS = wheelset_columns(("plane",)), patch_columns(("plane",))
"""Of plane wheelsets, and of other cases."""

_SKIPPED = ("timings_s", "peak_memory_MB", "case", "versions", "published", "status")
"""Parts of summaries that are no result of a row, or depend on the machine and on what it computed before."""


@dataclass(frozen=True)
class RowResult:
    """What one run gave.

    - `status`: ``converged``, ``not converged`` or ``failed``.
    - `message`: how it ended, in a sentence.
    - `warnings`: what limits it.
    - `values`: results by column, empty unless converged.
    - `patches`: patches by column, without the number of the row.
    - `seconds`: time that it took, its share of what is computed for several rows at once.
    """

    status: str
    message: str
    warnings: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    patches: tuple[Mapping[str, Value], ...] = ()
    seconds: float = 0.0


def wheelset_row(result: WheelsetResult, seconds: float) -> RowResult:
    """Return the numbers of a wheelset in equilibrium."""
    if not result.status.converged:
        return RowResult("not converged", result.status.message, result.warnings, seconds=seconds)
    patches = [_plane_patch(patch) for patch in result.patches]
    values, rows = numbers_of(result.equilibrium.position.components, patches)
    return RowResult("converged", result.status.message, result.warnings, values, rows, seconds)


def spatial_row(result: SpatialResult, seconds: float) -> RowResult:
    """Return the numbers of a wheelset in three dimensions."""
    if not result.status.converged:
        return RowResult("not converged", result.status.message, result.warnings, seconds=seconds)
    patches = [_spatial_patch(patch, result.rolling_of(patch)) for patch in result.patches]
    values, rows = numbers_of(result.equilibrium.position.components, patches, "spatial")
    for side in SIDES:
        motion = result.head_motion(side)
        values |= {f"{side}_{name}": value for name, value in zip(_HEAD, motion, strict=True)}
        if result.rolling:
            share = result.lateral_over_vertical(side) / result.nadal_limit(side)
            values[f"{side}_{_NADAL}"] = _plain(share) if result.flange_touches(side) else None
    return RowResult("converged", result.status.message, result.warnings, values, rows, seconds)


def numbers_of(
    motion: tuple[float, float, float], patches: list[dict[str, Value]], model: Model = "plane"
) -> tuple[dict[str, Value], tuple[dict[str, Value], ...]]:
    """Return the columns of a row, and of its patches."""
    values: dict[str, Value] = {name: float(value) for name, value in zip(_MOTION, motion, strict=True)}
    rows: list[dict[str, Value]] = []
    for side in SIDES:
        mine = sorted(
            (each for each in patches if each["side"] == side), key=lambda each: -float(each["rail_x_mm"] or 0)
        )
        numbered = [{"side": side, "number": number} | each for number, each in enumerate(mine, 1)]
        values |= _side(side, numbered, model)
        rows += numbered
    return {name: _plain(value) for name, value in values.items()}, tuple(rows)


def _side(side: Side, patches: list[dict[str, Value]], model: Model) -> dict[str, Value]:
    """Sums over the patches of a side, and the most loaded of them."""
    sums = {name: math.fsum(float(patch[name] or 0.0) for patch in patches) for name in _FORCES}
    lateral, vertical = sums["lateral_force_N"], sums["vertical_force_N"]
    ratio = (lateral if side == "left" else -lateral) / vertical if vertical > 0.0 else None
    values: dict[str, Value] = {"n_patches": len(patches), **sums, "lateral_over_vertical": ratio}
    values |= dict.fromkeys((*_PRESSURE, *_SIZE[model], *_POINTS))
    if patches:
        highest = max(patches, key=lambda patch: float(patch["max_pressure_MPa"] or 0.0))
        values |= {name: highest[name] for name in _PRESSURE}
        most = max(patches, key=lambda patch: float(patch["normal_force_N"] or 0.0))
        values |= {name: most[name] for name in (*_SIZE[model], *_POINTS)}
        if _CREEPAGES[0] in most:
            values |= {name: most[name] for name in _CREEPAGES}
            values |= {name: math.fsum(float(patch[name] or 0.0) for patch in patches) for name in _CREEP}
    return {f"{side}_{name}": value for name, value in values.items()}


def _plane_patch(patch: WheelRailPatch) -> dict[str, Value]:
    """Return the columns of a region of contact, without its number; Hertz's are None where the profiles conform."""
    (lateral, vertical), hertz, pressure = patch.force_on_wheel_N, patch.hertz, patch.pressure
    values = _patch(patch) | {
        "contact_angle_deg": math.degrees(math.atan2(lateral if patch.side == "left" else -lateral, vertical)),
        "max_pressure_MPa": float(pressure.pressures.max()),
        "max_pressure_remark": pressure.remark,
        "half_width_mm": pressure.half_width,
        "hertz_pressure_MPa": hertz.max_pressure if hertz else None,
        "hertz_half_width_mm": hertz.half_width if hertz else None,
    }
    return {name: _plain(value) for name, value in values.items()}


def _spatial_patch(patch: SpatialPatch, rolling: RollingPatch | None) -> dict[str, Value]:
    """Return the columns of a patch; with friction lateral and vertical force have the creep forces."""
    hertz, ellipse = patch.hertz, patch.ellipse
    axes = hertz.semi_axes if hertz else (None, None)
    values = _patch(patch) | {
        "contact_angle_deg": math.degrees(patch.contact_angle_rad),
        "max_pressure_MPa": ellipse.max_pressure,
        "max_pressure_remark": patch.remark or None,
        "hertz_pressure_MPa": hertz.max_pressure if hertz else None,
        "patch_angle_deg": math.degrees(ellipse.angle_rad),
        "ahead_mm": float(patch.centre_mm[2]),
        "rolling_radius_mm": patch.rolling_radius_mm,
    }
    for place, name in enumerate(("long_semi_axis_mm", "short_semi_axis_mm")):
        values |= {name: ellipse.semi_axes[place], f"hertz_{name}": axes[place]}
    if rolling is not None:
        lateral, vertical, along = (float(force) for force in rolling.force_on_wheel_N)
        values |= {"lateral_force_N": lateral, "vertical_force_N": vertical}
        creepages = (rolling.longitudinal_creepage, rolling.lateral_creepage, rolling.spin_creepage_per_m)
        values |= dict(zip(_CREEPAGES, (*creepages, rolling.used_friction), strict=True))
        values |= dict(
            zip(_CREEP, (along, rolling.lateral_creep_force_N, rolling.t_gamma_N, rolling.power_W), strict=True)
        )
    return {name: _plain(value) for name, value in values.items()}


def _patch(patch: WheelRailPatch | SpatialPatch) -> dict[str, Value]:
    """Return what both models have."""
    lateral, vertical = (float(force) for force in patch.force_on_wheel_N)
    values: dict[str, Value] = {"side": patch.side, "region": patch.region}
    values |= dict(zip(_FORCES, (math.hypot(lateral, vertical), lateral, vertical), strict=True))
    for name, (x, y) in (("wheel", patch.wheel_point_mm), ("rail", patch.rail_point_mm)):
        values |= {f"{name}_x_mm": float(x), f"{name}_y_mm": float(y)}
    return values


def summary_row(summary: Summary, seconds: float) -> RowResult:
    """Return all single numbers of a summary, and remarks on them, named by their paths with underscores."""
    content = summary.to_dict()
    message, warnings = summary.status.message, tuple(content.get("warnings", ()) or content.get("notices", ()))
    if not summary.status.converged:
        return RowResult("not converged", message, warnings, seconds=seconds)
    values = {name: _plain(value) for name, value in _numbers(content, "") if value is not None}
    return RowResult("converged", message, warnings, values, seconds=seconds)


def _numbers(value: Any, path: str) -> Iterable[tuple[str, Value]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if path or key not in _SKIPPED:
                yield from _numbers(inner, f"{path}_{key}" if path else str(key))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value, 1):
            yield from _numbers(inner, f"{path}_{number}")
    elif isinstance(value, float | int) or (value is not None and path.endswith("_remark")):
        yield path, value


def _plain(value: Value) -> Value:
    """None for what is not finite; SQLite knows neither."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def as_cell(value: Any) -> Value:
    """Return an input as it is stored: numbers and text as they are, tables and lists as JSON."""
    if isinstance(value, bool):
        return int(value)
    if value is None or isinstance(value, float | int | str):
        return value
    return json.dumps(value, ensure_ascii=False)
