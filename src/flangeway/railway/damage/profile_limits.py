"""Measures of worn profiles and the limits at which they are done."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from flangeway.checks import is_finite
from flangeway.errors import InputError
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.profiles.bundled import WheelProfile
from flangeway.railway.profiles.measures import GAUGE_DEPTH_MM, measures
from flangeway.railway.track.discretisation import Role
from flangeway.types import Floats


class LimitKind(NamedTuple):
    """Whose measure a limit is of, and whether it is reached above it (1) or below it (-1)."""

    role: Role
    measure: str
    sense: int = 1


LIMITS: dict[str, LimitKind] = {
    "min_flange_thickness_mm": LimitKind("wheel", "flange_thickness_mm", -1),
    "max_flange_height_mm": LimitKind("wheel", "flange_height_mm"),
    "min_flange_slope_mm": LimitKind("wheel", "flange_slope_mm", -1),
    "max_hollow_mm": LimitKind("wheel", "hollow_mm"),
    "max_tread_wear_mm": LimitKind("wheel", "tread_wear_mm"),
    "max_top_wear_mm": LimitKind("rail", "top_wear_mm"),
    "max_side_wear_mm": LimitKind("rail", "side_wear_mm"),
}
"""Limits of measures. EN 15313: flange thickness, height and slope qR of wheels."""
MAX_CUT_DEG = 75.0
"""Steepest slope of a running surface that a cut restores: flanges have 70 degrees, faces of rails stay as they are."""
HOLLOW_FROM_MM = -20.0
"""Position across the tread from which hollow wear is measured: beyond the flange root."""


def worn_measures(surface: WornSurface) -> dict[str, float]:
    """Measures of a worn profile in mm.

    Wheels: those of `flangeway.railway.profiles.measures.measures`; ``tread_wear_mm``, the loss of the radius at the
    tape line; ``hollow_mm``, how far the tread lies above its field side, towards the axle. Rails: ``top_wear_mm`` in
    the middle of the head and ``side_wear_mm`` of the gauge face at 14 mm below the new top. Both:
    ``restoring_cut_mm``, what turning takes off the radius, or grinding off the height, until the new shape is there
    again: the new surface moved down by it lies nowhere above the worn one, ``max(depth / cos(slope))``.
    """
    worn = surface.worn.running_surface.sampled(spacing=0.1, max_deviation=1e-4)
    if isinstance(surface.new, WheelProfile):
        found = measures(surface.from_tread, "wheel")
        tread = worn[worn[:, 0] > HOLLOW_FROM_MM]
        rim = np.minimum.accumulate(tread[::-1, 1])[::-1]
        hollow = float((tread[:, 1] - rim).max())
        return found | {"tread_wear_mm": surface.radius_loss_mm, "hollow_mm": hollow} | _cut(surface)
    new = surface.surface.sampled(spacing=0.1, max_deviation=1e-4)
    level = float(new[:, 1].max()) - GAUGE_DEPTH_MM
    heights, faces = ([_at(each, axis, at) for each in (new, worn)] for axis, at in ((0, 0.0), (1, level)))
    return {"top_wear_mm": heights[0] - heights[1], "side_wear_mm": faces[1] - faces[0]} | _cut(surface)


def _cut(surface: WornSurface) -> dict[str, float]:
    cosines = surface.slope_cosines
    restored = cosines >= np.cos(np.radians(MAX_CUT_DEG))
    return {"restoring_cut_mm": float((surface.depth[restored] / cosines[restored]).max())}


def _at(points: Floats, axis: int, value: float) -> float:
    """Height in the middle of a head (axis 0), or x of its gauge face at a height (axis 1)."""
    if axis == 1:
        points = points[points[:, 0] < 0.0]
    order = np.argsort(points[:, axis])
    return float(np.interp(value, points[order, axis], points[order, 1 - axis]))


def check_limits(limits: Mapping[str, float]) -> None:
    """Refuse limits that do not exist, as an `InputError`."""
    for name, value in limits.items():
        if name not in LIMITS or not (is_finite(value) and value > 0.0):
            raise InputError(f"limit {name} = {value}", f"{', '.join(LIMITS)}, in mm, > 0", "correct the name or value")


def reached(surface: WornSurface, limits: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the limits that a profile has reached; those of the other kind of profile do not count."""
    found, kinds = worn_measures(surface), [(name, LIMITS[name], limit) for name, limit in limits.items()]
    return tuple(
        name
        for name, kind, limit in kinds
        if kind.measure in found and (found[kind.measure] - limit) * kind.sense >= 0.0
    )
