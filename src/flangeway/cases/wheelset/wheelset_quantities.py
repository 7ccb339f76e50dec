"""Numbers of a wheelset on its rails, in three dimensions or in the plane: position, wheels, patches, rolling."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from flangeway.cases.patch_quantities import (
    ANGLE,
    AREA,
    AXES,
    CELLS,
    CREEPAGES,
    FIELDS,
    HERTZ_AXES,
    HERTZ_PRESSURE,
    LATERAL_FORCE,
    LONGITUDINAL_FORCE,
    SPIN_MOMENT,
    T_GAMMAS,
    TRACTION,
)
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.post.patch_stresses import StressField, StressMaximum
from flangeway.problems import LinearBody
from flangeway.quantities import Quantities, Quantity, column_names, of_part
from flangeway.railway.track.placements import SIDES, RigidTrack, Side
from flangeway.railway.track.wheelset_loads import WheelsetLoad
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.equilibrium import RelativeResiduals
from flangeway.railway.wheelset.plane_patch import WheelRailPatch
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheel_patch import WheelPatch
from flangeway.railway.wheelset.wheelset_newton import RolledWheelset
from flangeway.types import Floats

AnyResult = SpatialResult | WheelsetResult
REFERENCE = (
    "Position relative to the reference position, in which the axle is level, in the middle of the track, and the "
    "wheels' tape lines are at the height of the rails' tops (y = 0), in the track's axes; that of the line through "
    "the journals of an axle that bends. The approach is the descent from the position in which rigid wheels touch (in "
    "a curve: from the rigid equilibrium)."
)
XY, XYZ = ("x", "y"), ("x", "y", "z")


AnyPatch = WheelPatch | WheelRailPatch


def patch_name(patch: AnyPatch) -> str:
    """Side of a patch, and the part of the rail in contact."""
    return f"{patch.side} {patch.region}"


@dataclass(frozen=True, eq=False)
class WheelResult:
    """One wheel on its rail."""

    result: AnyResult
    side: Side
    patches: list[AnyPatch]

    @property
    def highest(self) -> AnyPatch | None:
        """Patch with the maximum pressure."""
        return max(self.patches, key=lambda patch: patch.max_pressure, default=None)

    @property
    def most_loaded(self) -> AnyPatch | None:
        """Patch with the maximum normal force."""
        return max(self.patches, key=lambda patch: patch.normal_force_N, default=None)

    @property
    def lateral_over_vertical(self) -> float | None:
        """L/V; None without contact."""
        ratio = self.result.lateral_over_vertical(self.side)
        return ratio if math.isfinite(ratio) else None

    @property
    def nadal_words(self) -> str | None:
        """Nadal's criterion in words; None without friction."""
        return None

    def total(self, value: Callable[[Any], float | None]) -> float:
        """Sum of a number over the patches."""
        return math.fsum(value(patch) or 0.0 for patch in self.patches)


@dataclass(frozen=True, eq=False)
class SpatialWheelResult(WheelResult):
    """One wheel on its rail in three dimensions."""

    result: SpatialResult

    @cached_property
    def head(self) -> tuple[float, float, float, float]:
        """Motion of the rail's head, lateral, vertical and roll, and of its gauge face outwards."""
        return self.result.head_motion(self.side)

    @property
    def nadal_limit(self) -> float | None:
        """Nadal's limit of L/V; None without friction."""
        return self.result.nadal_limit(self.side) if self.result.rolling else None

    @property
    def nadal_fraction(self) -> float | None:
        """L/V over Nadal's limit; None for a wheel whose flange does not touch."""
        limit, ratio = self.nadal_limit, self.lateral_over_vertical
        if limit is None or ratio is None:
            return None
        return ratio / limit if self.result.flange_touches(self.side) else None

    @property
    def nadal_words(self) -> str | None:
        """Nadal's criterion in words, for the wheel whose flange touches."""
        fraction = self.nadal_fraction
        if fraction is None:
            return None
        return f"{'exceeded' if fraction > 1.0 else 'not exceeded'} ({100.0 * fraction:.0f} %)"


# Position, load and residuals


MAX_UNCERTAINTY_MM = 0.02
"""Uncertainty of the lateral position above which it has a remark."""
ACCURACY_OF_CELLS = "friction balances here within the accuracy of the cells"

LATERAL: Quantity[AnyResult] = Quantity(
    "lateral", "lateral position of the axle", lambda result: result.equilibrium.position.lateral_mm, "mm", ".3f"
)
APPROACH: Quantity[AnyResult] = Quantity(
    "approach", "approach after first touch", lambda result: result.approach_mm, "mm", ".4f"
)
MOTION: Quantities[AnyResult] = (
    LATERAL,
    Quantity("vertical", "vertical position", lambda result: result.equilibrium.position.vertical_mm, "mm", ".4f"),
    Quantity("roll", "roll", lambda result: result.equilibrium.position.roll_rad, "mrad", ".3f", factor=1e3),
)
POSITION: Quantities[AnyResult] = (
    *MOTION,
    APPROACH,
    Quantity("horizontal_in_space", "", lambda result: result.position_in_space.lateral_mm, "mm"),
    Quantity("vertical_in_space", "", lambda result: result.position_in_space.vertical_mm, "mm"),
    Quantity(
        "stable", "", lambda result: result.equilibrium.stable, meaning="whether it comes back after a small push"
    ),
    Quantity("reference", "", lambda _: REFERENCE),
)
TRACK: Quantities[RigidTrack] = (
    Quantity("gauge", "track gauge", lambda track: track.gauge_mm, "mm", ".2f"),
    Quantity(
        "measured_gauge",
        "  of the heads as they are",
        lambda track: track.measured_gauge_mm,
        "mm",
        ".2f",
        meaning="smallest distance down to the input gauge_depth_mm below the tops; none where a head ends above it",
    ),
)
LOAD: Quantities[WheelsetLoad] = (
    Quantity("vertical", "", lambda load: load.vertical_N, "kN", factor=1e-3, meaning="weight in space"),
    Quantity("lateral", "", lambda load: load.lateral_N, "kN", factor=1e-3, meaning="horizontal force in space"),
    Quantity("tilt", "", lambda load: load.tilt_rad, "rad", meaning="tilt of the track"),
    Quantity("onto_track", "load normal to the track plane", lambda load: load.in_track[1], "kN", ".3f", factor=1e-3),
    Quantity(
        "lateral_in_track", "load parallel to the track plane", lambda load: load.in_track[0], "kN", ".3f", factor=1e-3
    ),
)
RESIDUAL: Quantities[RelativeResiduals] = (
    Quantity("equilibrium", "equilibrium residual", lambda residual: residual.equilibrium_residual, form=".1e"),
    Quantity("vertical", "  vertical", lambda residual: residual.vertical_residual, form=".1e"),
    Quantity("lateral", "  lateral", lambda residual: residual.lateral_residual, form=".1e"),
    Quantity("moment", "  moment", lambda residual: residual.moment_residual, form=".1e"),
)

# Patches


def _forces_on_wheel(of: Callable[[Any], Floats]) -> Quantities[Any]:
    """Lateral and vertical force that the rail exerts on the wheel, from the function of its components, N."""
    return (
        Quantity("lateral_force", "lateral force on the wheel", lambda it: of(it)[0], "kN", ".3f", factor=1e-3),
        Quantity("vertical_force", "vertical force on the wheel", lambda it: of(it)[1], "kN", ".3f", factor=1e-3),
    )


SIDE: Quantity[AnyPatch] = Quantity("side", "", lambda patch: patch.side)
REGION: Quantity[AnyPatch] = Quantity("region", "", lambda patch: patch.region)
NORMAL: Quantity[AnyPatch] = Quantity(
    "normal_force", "normal force", lambda patch: patch.normal_force_N, "kN", ".2f", factor=1e-3
)
FORCES: Quantities[AnyPatch] = (
    NORMAL,
    *_forces_on_wheel(lambda patch: patch.force_on_wheel_N),
)
CONTACT_ANGLE: Quantity[AnyPatch] = Quantity(
    "contact_angle", "contact angle", lambda patch: math.degrees(patch.contact_angle_rad), "deg", ".2f"
)
ON_RAIL: Quantity[AnyPatch] = Quantity(
    "rail_position", "position on the rail", lambda patch: patch.rail_point_mm, "mm", ".2f", XY
)
ON_WHEEL: Quantity[AnyPatch] = Quantity(
    "wheel_position", "position on the wheel", lambda patch: patch.wheel_point_mm, "mm", ".2f", XY
)
REMARK: Quantity[AnyPatch] = Quantity(
    "max_pressure_remark", "", lambda patch: patch.remark, meaning="why it is approximate"
)
PRESSURE: Quantity[AnyPatch] = Quantity(
    "max_pressure", "maximum pressure", lambda patch: patch.max_pressure, "MPa", ".1f", remark=lambda p: p.remark
)
HALF_WIDTH: Quantity[WheelRailPatch] = Quantity("half_width", "half width", lambda patch: patch.half_width, "mm", ".3f")


def _line(role: Role, name: str, label: str, number: int) -> Quantities[WheelRailPatch]:
    """A stress on the normal below a plane contact, and its depth."""
    key = f"in_{role}_{name}"
    return (
        Quantity(key, f"{label} in the {role}", lambda patch: patch.below[role][number].value_MPa, "MPa", ".0f"),
        Quantity(f"{key}_depth", "  at the depth", lambda patch: patch.below[role][number].depth_mm, "mm", ".2f"),
    )


PLANE_MAIN: Quantities[WheelRailPatch] = (
    *FORCES,
    PRESSURE,
    Quantity("hertz_pressure", "  Hertz", lambda p: p.hertz and p.hertz.max_pressure, "MPa", ".1f"),
    HALF_WIDTH,
    Quantity("hertz_half_width", "  Hertz", lambda p: p.hertz and p.hertz.half_width, "mm", ".3f"),
    CONTACT_ANGLE,
    ON_RAIL,
    ON_WHEEL,
)
PLANE_FURTHER: Quantities[WheelRailPatch] = (
    Quantity("track_position", "position in the track", lambda patch: patch.centre, "mm", ".2f", XY),
    Quantity("pressure_oscillation", "pressure oscillation", lambda patch: patch.oscillation, form=".2%"),
    Quantity("nodes", "nodes in contact", lambda p: len(p.normal_forces), form="d"),
    *(
        quantity
        for role in ROLES
        for number, (name, label) in enumerate(
            (("max_in_plane_shear", "in-plane shear stress"), ("max_von_mises", "von Mises stress"))
        )
        for quantity in _line(role, name, label, number)
    ),
)
"""PLANE_MAIN, PLANE_FURTHER: numbers of a contact of a plane wheelset; the first ones for the table of results."""


MAXIMA: dict[str, Callable[[StressField], StressMaximum]] = {
    "max_von_mises": lambda field: field.max_von_mises,
    "max_tresca": lambda field: field.max_tresca,
    "max_tension": lambda field: field.max_tension,
}
"""Maxima of stresses in the volume below a patch."""


def _volume(role: Role, key: str, of: Callable[[StressField], StressMaximum]) -> Quantities[WheelPatch]:
    """A maximum stress in the volume below a patch, its depth and its point in the track's axes, for programs."""

    def point(patch: WheelPatch) -> Floats:
        return patch.points_below(role, *np.reshape(of(patch.stress_fields[role]).position, (3, 1)))[0]

    return (
        Quantity(f"in_{role}_{key}", "", lambda patch: of(patch.stress_fields[role]).value, "MPa"),
        Quantity(f"in_{role}_{key}_depth", "", lambda patch: of(patch.stress_fields[role]).position[1], "mm"),
        Quantity(f"in_{role}_{key}_position", "", point, "mm", parts=XYZ),
    )


def _greater(key: str, label: str, of: Callable[[WheelPatch, Role], tuple[float, float]]) -> Quantities[WheelPatch]:
    """The greater of a stress in rail and wheel, and its depth."""

    def most(patch: WheelPatch) -> tuple[float, float]:
        return max((of(patch, role) for role in ROLES), key=lambda pair: pair[0])

    return (
        Quantity(key, label, lambda patch: most(patch)[0], "MPa", ".0f"),
        Quantity(f"{key}_depth", "  at the depth", lambda patch: most(patch)[1], "mm", ".2f"),
    )


def _maximum(key: str, label: str) -> Quantities[WheelPatch]:
    def of(patch: WheelPatch, role: Role) -> tuple[float, float]:
        maximum = MAXIMA[key](patch.stress_fields[role])
        return maximum.value, maximum.position[1]

    return _greater(key, label, of)


def _below_centre(patch: WheelPatch, role: Role) -> tuple[float, float]:
    line = patch.lines[role]
    return line.maximum(line.stresses.von_mises)


def _creep(*quantities: Quantity[CreepState]) -> Quantities[WheelPatch]:
    return of_part(lambda patch: patch.creep, *quantities)


POSITION_ALONG: Quantity[WheelPatch] = Quantity(
    "track_position", "position in the track", lambda patch: patch.centre_mm, "mm", ".2f", XYZ
)
LONGITUDINAL: Quantity[WheelPatch] = Quantity(
    "longitudinal_position", "longitudinal position", lambda patch: patch.centre_mm[2], "mm", ".2f"
)
LOAD_FACTOR: Quantity[WheelPatch] = Quantity(
    "pressure_over_shear_strength", "p0/k (load factor)", lambda patch: patch.load_factor, form=".2f"
)
SHAKEDOWN: Quantity[WheelPatch] = Quantity("shakedown_state", "  shakedown state", lambda patch: patch.shakedown_state)
ROLLING_RADIUS: Quantity[WheelPatch] = Quantity(
    "rolling_radius", "rolling radius", lambda patch: patch.rolling_radius_mm, "mm", ".3f"
)
CREEP_MAIN: Quantities[WheelPatch] = _creep(
    *CREEPAGES,
    replace(LONGITUDINAL_FORCE, key="longitudinal_creep_force", label="longitudinal creep force"),
    replace(LATERAL_FORCE, key="lateral_creep_force", label="lateral creep force"),
    TRACTION,
    T_GAMMAS[0],
)
CREEP_FURTHER: Quantities[WheelPatch] = (
    *_creep(SPIN_MOMENT, *T_GAMMAS[1:]),
    Quantity("frictional_power", "frictional power", lambda patch: patch.creep and patch.creep.power_W, "W", ".1f"),
    *_creep(*FIELDS),
)
"""CREEP_MAIN, CREEP_FURTHER: numbers of a patch that rolls, those of the table of results and further ones."""
MAX_VON_MISES, MAX_VON_MISES_DEPTH = _maximum("max_von_mises", "maximum von Mises stress")
SPATIAL_MAIN: Quantities[WheelPatch] = (
    NORMAL,
    PRESSURE,
    HERTZ_PRESSURE,
    LOAD_FACTOR,
    SHAKEDOWN,
    AXES,
    CONTACT_ANGLE,
    ON_RAIL,
    ON_WHEEL,
    LONGITUDINAL,
    MAX_VON_MISES,
    MAX_VON_MISES_DEPTH,
)
SPATIAL_FURTHER: Quantities[WheelPatch] = (
    *FORCES[1:],
    POSITION_ALONG,
    *_greater("von_mises_below_centre", "von Mises stress below the centre", _below_centre),
    *_maximum("max_tresca", "maximum Tresca stress"),
    *_maximum("max_tension", "maximum tension"),
    HERTZ_AXES,
    ANGLE,
    AREA,
    Quantity(
        "conformity",
        "change of contact normal across the patch",
        lambda patch: patch.conformity_deg,
        "deg",
        ".1f",
    ),
    ROLLING_RADIUS,
    CELLS,
    *(quantity for role in ROLES for key, of in MAXIMA.items() for quantity in _volume(role, key, of)),
)
"""SPATIAL_MAIN, SPATIAL_FURTHER: numbers of a patch, those of the table of results and further ones."""
PATCH: Quantities[WheelPatch] = (
    SIDE, REGION, *SPATIAL_MAIN, REMARK, *SPATIAL_FURTHER, *CREEP_MAIN, *CREEP_FURTHER,
)  # fmt: skip
PLANE_PATCH: Quantities[WheelRailPatch] = (SIDE, REGION, *PLANE_MAIN, REMARK, *PLANE_FURTHER)

# Wheels

GAUGE_DEPTH: Quantity[WheelResult] = Quantity(
    "gauge_depth",
    "gauge point below the top",
    lambda w: w.result.problem.track.gauge_point(w.side).depth_mm,
    "mm",
    ".2f",
)
RATIO: Quantity[WheelResult] = Quantity(
    "lateral_over_vertical", "L/V", lambda wheel: wheel.lateral_over_vertical, form=".4f"
)
WHEEL: Quantities[WheelResult] = (
    Quantity("n_patches", "patches", lambda w: len(w.patches), form="d"),
    Quantity("normal_force", "normal force", lambda w: w.total(lambda p: p.normal_force_N), "kN", ".3f", factor=1e-3),
    *_forces_on_wheel(lambda wheel: wheel.result.force_on_wheel_N(wheel.side)),
    RATIO,
    GAUGE_DEPTH,
)
GAUGE: Quantity[SpatialWheelResult] = Quantity(
    "gauge_outward", "gauge-face deflection", lambda wheel: wheel.head[3], "mm", ".3f"
)
HEAD: Quantities[SpatialWheelResult] = (
    Quantity("head_lateral", "railhead lateral displacement", lambda wheel: wheel.head[0], "mm", ".3f"),
    Quantity("head_vertical", "  up", lambda wheel: wheel.head[1], "mm", ".3f"),
    Quantity("head_roll", "  roll", lambda wheel: wheel.head[2], "mrad", ".3f", factor=1e3),
    GAUGE,
)
NADAL_FRACTION: Quantity[SpatialWheelResult] = Quantity(
    "share_of_nadal_limit", "  fraction of the limit", lambda wheel: wheel.nadal_fraction, form=".0%"
)
NADAL: Quantities[SpatialWheelResult] = (
    Quantity("nadal_limit", "  Nadal's limit", lambda wheel: wheel.nadal_limit, form=".3f"),
    NADAL_FRACTION,
)
NADAL_WORDS: Quantity[SpatialWheelResult] = Quantity("nadal", "Nadal's criterion", lambda wheel: wheel.nadal_words)


def _most_loaded(*quantities: Quantity[Any]) -> Quantities[WheelResult]:
    return of_part(lambda wheel: wheel.most_loaded, *quantities)


def _sum(quantity: Quantity[Any]) -> Quantity[WheelResult]:
    return replace(quantity, of=lambda wheel: wheel.total(quantity.value), factor=1.0)


_ELLIPSE: Quantities[WheelPatch] = (AXES, ANGLE, LONGITUDINAL, ROLLING_RADIUS)
_POINTS: Quantities[AnyPatch] = (CONTACT_ANGLE, ON_RAIL, ON_WHEEL)
_HIGHEST: Quantities[WheelResult] = of_part(lambda wheel: wheel.highest, PRESSURE, REMARK)
PLANE_ROW: Quantities[WheelResult] = (
    *WHEEL,
    *_HIGHEST,
    *_most_loaded(HALF_WIDTH, *_POINTS),
)
SPATIAL_ROW: Quantities[SpatialWheelResult] = (
    *WHEEL,
    *_HIGHEST,
    *_most_loaded(*_ELLIPSE, *_POINTS),
    *HEAD,
)
ROLLING_ROW: Quantities[SpatialWheelResult] = (
    *SPATIAL_ROW,
    *_most_loaded(*CREEP_MAIN[:3], CREEP_MAIN[5]),
    *map(_sum, (*CREEP_MAIN[3:5], CREEP_MAIN[6], CREEP_FURTHER[3])),
    NADAL_FRACTION,
)
"""PLANE_ROW, SPATIAL_ROW, ROLLING_ROW: numbers of a wheel in a row of a campaign: sums and the most loaded patch."""
PLANE_PATCH_ROW: Quantities[WheelRailPatch] = (SIDE, REGION, *PLANE_MAIN, REMARK)
SPATIAL_PATCH_ROW: Quantities[WheelPatch] = (
    SIDE, REGION, *FORCES, PRESSURE, REMARK, HERTZ_PRESSURE, HERTZ_AXES, LOAD_FACTOR, *_ELLIPSE, *_POINTS,
)  # fmt: skip
ROLLING_PATCH_ROW = (*SPATIAL_PATCH_ROW, *CREEP_MAIN, CREEP_FURTHER[3])
"""PLANE_PATCH_ROW, SPATIAL_PATCH_ROW, ROLLING_PATCH_ROW: numbers of its patches, without stresses below."""


def row_columns(quantities: Sequence[Quantity[Any]]) -> tuple[str, ...]:
    """Columns of a row of a campaign: position, and the numbers of both wheels."""
    names = column_names(quantities)
    return (*column_names(MOTION), *(f"{side}_{name}" for side in SIDES for name in names))


def _frequency(result: SpatialResult) -> float | None:
    length, rolling = result.kinematic_wavelength_mm, result.problem.friction
    return None if length is None or rolling is None else 1e3 * result.problem.speed_m_s / length


def _rolled(result: SpatialResult) -> RolledWheelset | None:
    return result.equilibrium.state.rolled


def _lateral_remark(result: SpatialResult) -> str | None:
    uncertainty = result.lateral_uncertainty_mm
    return ACCURACY_OF_CELLS if uncertainty is not None and uncertainty > MAX_UNCERTAINTY_MM else None


LATERAL_UNCERTAINTY: Quantity[SpatialResult] = Quantity(
    "lateral_uncertainty",
    "uncertainty of the lateral position",
    lambda result: result.lateral_uncertainty_mm,
    "mm",
    ".3f",
    meaning="change by cells shifted by half of their size; none where the lateral position is prescribed",
    remark=_lateral_remark,
)
ROLLING: Quantities[SpatialResult] = (
    LATERAL_UNCERTAINTY,
    *of_part(
        _rolled,
        Quantity("rate", "rotation", lambda rolled: rolled.rate_rad_s, "rad/s", ".4f"),
        Quantity(
            "rate_difference",
            "rotation of independent wheels, right less left",
            lambda rolled: rolled.rate_difference_rad_s,
            "rad/s",
            ".4f",
        ),
        Quantity("yaw", "yaw", lambda rolled: rolled.yaw_rad, "mrad", ".3f", factor=1e3),
        Quantity(
            "yaw_moment",
            "yaw moment from contact forces",
            lambda rolled: rolled.yaw_moment_Nmm,
            "kNm",
            ".3f",
            factor=1e-6,
            meaning="on the wheelset, counter-clockwise from above",
        ),
        Quantity(
            "torque",
            "torque on the axle",
            lambda rolled: rolled.torque_Nmm,
            "kNm",
            ".3f",
            factor=-1e-6,
        ),
    ),
    Quantity(
        "traction",
        "traction",
        lambda result: 1e-3 * sum(float(patch.creep_force_on_wheel_N[2]) for patch in result.patches),
        "kN",
        ".3f",
    ),
    Quantity("t_gamma", "T-gamma of all patches", lambda r: sum(creep.t_gamma_N for _, creep in r.rolling), "N", ".1f"),
    Quantity("power", "frictional power", lambda r: sum(creep.power_W for _, creep in r.rolling), "W", ".0f"),
    Quantity(
        "kinematic_wavelength",
        "kinematic wave (Klingel): length",
        lambda result: result.kinematic_wavelength_mm,
        "m",
        ".2f",
        meaning="of the equivalent conicity of rigid joined wheels at 3 mm; none where it is not positive",
        factor=1e-3,
    ),
    Quantity("kinematic_frequency", "  frequency", _frequency, "Hz", ".2f"),
)


MESH: Quantities[LinearBody] = (
    Quantity("name", "", lambda body: body.name),
    Quantity("unknowns", "unknowns", lambda body: body.stiffness.n, form=","),
    Quantity("elements", "elements", lambda body: body.space.mesh.n_cells, form=","),
    Quantity("nodes", "nodes", lambda body: body.space.n_nodes, form=","),
)
