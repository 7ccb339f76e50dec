"""Columns of a campaign's results: the numbers of one run, with units in their names."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from flangeway.cases.summary import Summary
from flangeway.exact import LineContact
from flangeway.railway.positions.positions_patches import PositionPatch
from flangeway.railway.track.discretisation import ROLES
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

Value = float | int | str | None
Patch = tuple[PositionPatch, LineContact | None]
"""A region of contact, and Hertz's contact there, None where the profiles conform."""

POSITION_KEYS = (
    *("lateral_mm", "vertical_mm", "roll_rad", "axle_load_kN", "car_mass_t", "n_axles", "lateral_force_kN"),
    *("speed_km_h", "curve_radius_m", "superelevation_mm", "cant_deficiency_mm", "superelevation_base_mm"),
)
"""Inputs of a wheelset that leave its bodies as they are."""

_MOTION = ("lateral_mm", "vertical_mm", "roll_rad")
_SIDE = (
    *("n_patches", "normal_force_N", "lateral_force_N", "vertical_force_N", "lateral_over_vertical"),
    *("max_pressure_MPa", "max_pressure_remark", "half_width_mm", "contact_angle_deg"),
    *("wheel_x_mm", "wheel_y_mm", "rail_x_mm", "rail_y_mm"),
)
WHEELSET_COLUMNS = (*_MOTION, *(f"{side}_{name}" for side in SIDES for name in _SIDE))
"""Results of a wheelset: its motion; of each side the sums over its patches, and the most loaded patch."""

PATCH_COLUMNS = (
    *("row", "side", "number", "region", "normal_force_N", "lateral_force_N", "vertical_force_N", "max_pressure_MPa"),
    *("max_pressure_remark", "half_width_mm", "hertz_pressure_MPa", "hertz_half_width_mm", "contact_angle_deg"),
    *("wheel_x_mm", "wheel_y_mm", "rail_x_mm", "rail_y_mm"),
)
"""Columns of the table of patches; they are numbered on each side from the field to the gauge."""

_SHEAR = {role: (f"{role}_max_in_plane_shear_MPa", f"{role}_max_in_plane_shear_depth_mm") for role in ROLES}
PATCH_SHEAR_COLUMNS = tuple(name for names in _SHEAR.values() for name in names)
"""Further columns of patches where the maximum shear stress below the surface is asked for."""

WHEELSET_SHEAR_COLUMNS = tuple(f"{side}_{name}" for side in SIDES for name in PATCH_SHEAR_COLUMNS)
"""Further results of wheelsets then: the maximum of each side's patches, in the wheel and in the rail."""

_SKIPPED = ("timings_s", "case", "versions", "published", "status")


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


def wheelset_row(result: WheelsetResult, seconds: float, *, shear: bool = False) -> RowResult:
    """Return the numbers of a wheelset in equilibrium, with the maximum shear stresses below its patches or without."""
    if not result.status.converged:
        return RowResult("not converged", result.status.message, result.warnings, seconds=seconds)
    patches = []
    for patch in result.patches:
        below = {role: maximum_shear(result, patch, role) for role in ROLES} if shear else None
        patches.append((replace(PositionPatch.of(patch), shear=below), patch.hertz))
    values, rows = numbers_of(result.equilibrium.position.components, patches)
    return RowResult("converged", result.status.message, result.warnings, values, rows, seconds)


def numbers_of(
    motion: tuple[float, float, float], patches: list[Patch]
) -> tuple[dict[str, Value], tuple[dict[str, Value], ...]]:
    """Return the columns of a row, and of its patches."""
    values: dict[str, Value] = dict(zip(_MOTION, motion, strict=True))
    rows: list[dict[str, Value]] = []
    for side in SIDES:
        mine = sorted((each for each in patches if each[0].side == side), key=lambda each: -each[0].rail_point_mm[0])
        numbered = [_patch(*each, number) for number, each in enumerate(mine, 1)]
        values |= _side(side, numbered)
        rows += numbered
    return {name: _plain(value) for name, value in values.items()}, tuple(rows)


def _side(side: Side, patches: list[dict[str, Value]]) -> dict[str, Value]:
    """Sums over the patches of a side, and the most loaded of them."""
    sums = {
        name: math.fsum(float(patch[name] or 0.0) for patch in patches)
        for name in ("normal_force_N", "lateral_force_N", "vertical_force_N")
    }
    lateral, vertical = sums["lateral_force_N"], sums["vertical_force_N"]
    ratio = (lateral if side == "left" else -lateral) / vertical if vertical > 0.0 else None
    values: dict[str, Value] = {"n_patches": len(patches), **sums, "lateral_over_vertical": ratio}
    if patches:
        highest = max(patches, key=lambda patch: float(patch["max_pressure_MPa"] or 0.0))
        values |= {name: highest[name] for name in ("max_pressure_MPa", "max_pressure_remark")}
        most = max(patches, key=lambda patch: float(patch["normal_force_N"] or 0.0))
        values |= {name: most[name] for name in _SIDE if name not in values}
        for value, depth in _SHEAR.values():
            if value in most:
                worst = max(patches, key=lambda patch: float(patch[value] or 0.0))
                values |= {value: worst[value], depth: worst[depth]}
    return {f"{side}_{name}": value for name, value in (dict.fromkeys(_SIDE) | values).items()}


def _patch(patch: PositionPatch, hertz: LineContact | None, number: int) -> dict[str, Value]:
    lateral, vertical = patch.force_on_wheel_N
    inward = -lateral if patch.side == "right" else lateral
    values: dict[str, Value] = {
        "side": patch.side,
        "number": number,
        "region": patch.region,
        "normal_force_N": math.hypot(lateral, vertical),
        "lateral_force_N": lateral,
        "vertical_force_N": vertical,
        "max_pressure_MPa": patch.max_pressure_MPa,
        "max_pressure_remark": patch.remark,
        "half_width_mm": patch.half_width_mm,
        "hertz_pressure_MPa": hertz.max_pressure if hertz else None,
        "hertz_half_width_mm": hertz.half_width if hertz else None,
        "contact_angle_deg": math.degrees(math.atan2(inward, vertical)),
    }
    for name, (x, y) in (("wheel", patch.wheel_point_mm), ("rail", patch.rail_point_mm)):
        values |= {f"{name}_x_mm": x, f"{name}_y_mm": y}
    if patch.shear is not None:
        for role, (value, depth) in _SHEAR.items():
            values |= {value: patch.shear[role].value_MPa, depth: patch.shear[role].depth_mm}
    return {name: _plain(value) for name, value in values.items()}


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
