"""Contact geometry and conicity of a rigid wheelset on rigid rails, as ``flangeway geometry`` computes them."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.case import Case, Progress
from flangeway.cases.rigid.rigid_case import GEOMETRY_CASES, GeometryCase
from flangeway.cases.wheelset.wheelset_profiles import profile_notes, side_warnings
from flangeway.errors import InputError
from flangeway.exact import contact_modulus
from flangeway.materials import Elastic
from flangeway.railway.profiles.measures import conforming
from flangeway.railway.rigid.conicity import (
    REFERENCE_AMPLITUDE_MM,
    RollingRadiusDifference,
    conicity_by_regression,
    equivalent_conicity,
    motion_middles,
    read_rolling_radius_difference,
)
from flangeway.railway.rigid.rigid_equilibrium import (
    RigidContactPoint,
    RigidEquilibrium,
    RigidPosition,
    held_ratios,
    rigid_equilibrium,
)
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.rigid.rigid_locus import ContactJump, ContactLocus
from flangeway.railway.track.placements import SIDES, Track, Wheelset
from flangeway.results import Result, ResultTable
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions
from flangeway.types import Floats

STEP_MM = 0.1
FIRST_MM = 0.5


@dataclass(frozen=True, eq=False)
class Conicities(Result):
    """Equivalent conicity over the amplitude."""

    amplitudes_mm: Floats
    integration: Floats
    regression: Floats
    """amplitudes_mm, integration, regression: amplitudes, and conicity by integration and by linear regression, (n,);
    empty if the wheelset does not steer."""
    notices: tuple[str, ...]  # sentences on amplitudes without a conicity

    @property
    def table(self) -> ResultTable:
        """Conicity over the amplitude."""
        columns = (self.amplitudes_mm, self.integration, self.regression)
        return ResultTable(
            dict(zip(("amplitude_mm", "conicity_integration", "conicity_regression"), columns, strict=True))
        )

    def at_reference(self) -> dict[str, float] | None:
        """Conicity at the reference amplitude; None where it is not computed."""
        at = np.flatnonzero(np.abs(self.amplitudes_mm - REFERENCE_AMPLITUDE_MM) < 1e-6)
        if not len(at):
            return None
        found = (float(each[at[0]]) for each in (self.amplitudes_mm, self.integration, self.regression))
        return dict(zip(("amplitude_mm", "integration", "regression"), found, strict=True))


def conicities_of(difference: RollingRadiusDifference, maximum_mm: float | None) -> Conicities:
    """Conicity at amplitudes 0.1 mm apart, as far as the difference is given.

    - `maximum_mm`: maximum amplitude; None: as far as the difference goes.
    """
    none: Floats = np.zeros(0)
    try:
        middle = difference.centred_mm
    except InputError as error:
        return Conicities(none, none, none, (f"no equivalent conicity: {error.given}",))
    room = min(middle - float(difference.lateral_mm[0]), float(difference.lateral_mm[-1]) - middle)
    maximum = room if maximum_mm is None else min(maximum_mm, room)
    amplitudes = np.arange(round(FIRST_MM / STEP_MM), math.floor(maximum / STEP_MM + 1e-9) + 1.0) * STEP_MM
    outside = np.isnan(motion_middles(difference, amplitudes))
    amplitudes = amplitudes[: np.argmax(outside)] if outside.any() else amplitudes
    notices = []
    reached = float(amplitudes[-1]) if len(amplitudes) else 0.0
    if maximum_mm is not None and reached < math.floor(maximum_mm / STEP_MM + 1e-9) * STEP_MM - 1e-6:
        notices.append(f"conicity only up to an amplitude of {reached:.1f} mm")
    found = equivalent_conicity(difference, amplitudes) if len(amplitudes) else none
    pushed = amplitudes[np.isnan(found)]
    if len(pushed):
        notices.append(
            f"no equivalent conicity by integration at {len(pushed)} amplitudes from {pushed[0]:.1f} to "
            f"{pushed[-1]:.1f} mm: the rolling radius difference pushes the wheelset away from the middle"
        )
    regression = conicity_by_regression(difference, amplitudes) if len(amplitudes) else none
    return Conicities(amplitudes, found, regression, tuple(notices))


@dataclass(frozen=True, eq=False)
class ConicityRun(Result):
    """Equivalent conicity from a file."""

    difference: RollingRadiusDifference  # content of the file
    conicities: Conicities  # conicity over the amplitude
    summary: dict[str, Any]  # content of ``geometry.json``

    @property
    def table(self) -> ResultTable:
        """Conicity over the amplitude."""
        return self.conicities.table


class ConicityCase(Case):
    """Inputs for the conicity of a rolling radius difference."""

    name: ClassVar[str] = "conicity"
    title: ClassVar[str] = "Equivalent conicity of a rolling radius difference"

    unit: Literal["mm", "cm", "m", "in", "ft"] | None = Field(
        None, description="unit of both columns; that of the file if left out"
    )
    maximum_amplitude_mm: float | None = Field(
        None, ge=FIRST_MM, le=30.0, description="maximum amplitude; as far as the difference is given if left out"
    )


def run_conicity(file: Path, values: Mapping[str, Any]) -> ConicityRun:
    """Read a rolling radius difference and compute its conicity.

    It is an `InputError` if the file cannot be read as a rolling radius difference, or an input is wrong.
    - `file`: see `flangeway.railway.rigid.conicity.read_rolling_radius_difference`.
    - `values`: inputs of a `ConicityCase`.
    """
    start = time.perf_counter()
    case = ConicityCase.from_values(values)
    difference = read_rolling_radius_difference(file, case.unit)
    conicities = conicities_of(difference, case.maximum_amplitude_mm)
    summary = {
        "case": file.stem,
        "title": f"Equivalent conicity of the rolling radius difference in {file.name}",
        "inputs": {"file": str(file), **case.model_dump()},
        "lateral_without_difference_mm": difference.centred_mm if len(conicities.amplitudes_mm) else None,
        "equivalent_conicity": conicities.at_reference(),
        "notices": list(conicities.notices),
        "versions": versions(),
        "timings_s": {"total": time.perf_counter() - start},
    }
    return ConicityRun(difference, conicities, summary)


FLANGE_ROOT_RADII_MM = (10.0, 12.0, 14.2875, 17.4625, 20.0)
"""Radii of the narrow arc of the flange root that the figure compares."""

WIDE_FLANGE_ROOT_RADII_MM = (30.0, 34.0, 38.1, 44.0, 50.0)
"""Radii of the wide arc of the flange root that the figure compares."""

_FURTHER_MM = 4.0  # beyond the maximum amplitude: an asymmetric wheelset oscillates about another position


@dataclass(frozen=True, eq=False)
class FlangeRootEffect:
    """Lateral displacement in equilibrium over the radii of the flange root."""

    narrow_mm: Floats
    lateral_narrow_mm: Floats
    wide_mm: Floats  # narrow_mm, wide_mm: radii of the narrow and of the wide arc, (n,) and (m,)
    lateral_wide_mm: Floats
    """lateral_narrow_mm, lateral_wide_mm: lateral displacement in equilibrium for each, the other radius as it is; nan
    without equilibrium."""
    ratios: tuple[Floats, ...]
    laterals_mm: tuple[Floats, ...]
    """ratios, laterals_mm: for each narrow radius: lateral force over weight, and the lateral displacement in
    equilibrium under it."""


@dataclass(frozen=True, eq=False)
class GeometryRun(Result):
    """Contact geometry of a case."""

    name: str
    case: GeometryCase  # name, case: name to show, and inputs
    geometry: RigidGeometry  # rigid geometry of the pair
    locus: ContactLocus  # points of contact over the lateral displacement
    jumps: tuple[ContactJump, ...]  # where they jump
    conicities: Conicities  # equivalent conicity over the amplitude
    equilibrium: RigidEquilibrium  # equilibria under the load
    flange_root: FlangeRootEffect | None
    """Effect of the flange root's radii on the equilibrium; None for wheels without that parameter, without lateral
    force or without equilibrium."""
    summary: dict[str, Any]  # content of ``geometry.json``

    @property
    def table(self) -> ResultTable:
        """Positions and their points of contact, a row a position."""
        locus = self.locus
        columns = {
            "lateral_mm": locus.lateral_mm,
            "vertical_mm": locus.vertical_mm,
            "roll_mrad": 1e3 * locus.roll_rad,
            "rolling_radius_difference_mm": locus.rolling_radius_difference_mm,
        }
        for side in SIDES:
            at = locus.side(side)
            columns |= {
                f"{side}_wheel_x_mm": at.wheel_points_mm[:, 0, 0],
                f"{side}_wheel_y_mm": at.wheel_points_mm[:, 0, 1],
                f"{side}_rail_x_mm": at.rail_points_mm[:, 0, 0],
                f"{side}_rail_y_mm": at.rail_points_mm[:, 0, 1],
                f"{side}_contact_angle_deg": np.degrees(at.contact_angles_rad[:, 0]),
                f"{side}_rolling_radius_mm": at.rolling_radii_mm[:, 0],
                f"{side}_ahead_mm": at.ahead_mm[:, 0],
                f"{side}_relative_curvature_per_m": 1e3 * at.relative_curvatures_per_mm[:, 0],
                f"{side}_next_gap_mm": at.gaps_mm[:, 1],
                f"{side}_next_wheel_x_mm": at.wheel_points_mm[:, 1, 0],
            }
        return ResultTable(columns)


def run_geometry(
    name: str, case: GeometryCase, progress: Progress = lambda _: None, notices: Sequence[str] = ()
) -> GeometryRun:
    """Compute the contact geometry of a case.

    It is an `InputError` if gauge and wheels do not fit.
    - `notices`: sentences about the inputs, to be shown with those about the results.
    """
    start = time.perf_counter()
    track, axle = case.track(), case.wheelset()
    geometry = RigidGeometry.of(track, axle, case.yaw_rad)
    remarks = list(notices)
    progress("lowering the wheelset on the rails")
    reach = max(case.maximum_lateral_mm, case.maximum_amplitude_mm + _FURTHER_MM)
    whole = _scanned(geometry, case, reach)
    wanted = math.floor(case.maximum_lateral_mm / case.step_mm + 1e-9) * case.step_mm
    shown = np.abs(whole.lateral_mm) < wanted + 0.5 * case.step_mm
    first, last = np.flatnonzero(shown)[[0, -1]]
    locus = whole.part(slice(first, last + 1))
    if min(-locus.lateral_mm[0], locus.lateral_mm[-1]) < wanted - 0.5 * case.step_mm:
        remarks.append(
            f"the scan of {case.maximum_lateral_mm:g} mm stops at lateral displacements of {locus.lateral_mm[0]:.2f} "
            f"and {locus.lateral_mm[-1]:.2f} mm: beyond, a flange climbs or a running surface ends"
        )
    progress("narrowing the jumps of the points of contact")
    jumps = geometry.jumps(float(np.abs(locus.lateral_mm).max())) if case.roll == "free" else ()
    progress("integrating the kinematic motion")
    conicities = conicities_of(RollingRadiusDifference.of(whole), case.maximum_amplitude_mm)
    remarks += conicities.notices
    progress("finding the equilibrium under the load")
    equilibrium = rigid_equilibrium(geometry, case.load())
    flange_root = None
    if case.wheel == "AAR-1B" and case.lateral_force_kN != 0.0 and equilibrium.position is not None:
        progress("varying the radii of the flange root")
        flange_root = flange_root_effect(case)
    remarks += [*side_warnings(track), *case.derived(), *profile_notes(track, axle)]
    summary = _summary(name, case, jumps, conicities, equilibrium, remarks)
    _leave_out_conforming(summary, track, axle)
    summary["timings_s"] = {"total": time.perf_counter() - start}
    summary["peak_memory_MB"] = peak_memory_bytes() / 1e6
    return GeometryRun(name, case, geometry, locus, jumps, conicities, equilibrium, flange_root, summary)


def _leave_out_conforming(summary: dict[str, Any], track: Track, axle: Wheelset) -> None:
    """Leave out Hertz's estimates of contacts that conform, see `flangeway.railway.profiles.measures.conforming`."""
    for row in (summary["equilibrium"] or {"contacts": ()})["contacts"]:
        wheel, rail, width = axle.wheel_of(row["side"]), track.rail_of(row["side"]), row["hertz_half_width_mm"]
        if width is not None and conforming(wheel, row["wheel_point_mm"], rail, row["rail_point_mm"], width):
            row["hertz_half_width_mm"] = row["hertz_max_pressure_MPa"] = None


def _scanned(geometry: RigidGeometry, case: GeometryCase, reach: float) -> ContactLocus:
    """Positions to both sides as far as the wheels touch inside the running surfaces and no flange climbs."""
    rolls = case.roll == "free"
    low, high = geometry.limits(reach, roll=rolls)
    numbers = np.arange(math.ceil(max(low, -reach) / case.step_mm), math.floor(min(high, reach) / case.step_mm) + 1)
    return geometry.locus(numbers * case.step_mm, roll=rolls)


def flange_root_effect(case: GeometryCase) -> FlangeRootEffect:
    """Lateral displacement in equilibrium for several radii of the AAR-1B's flange root.

    It is an `InputError` if the case's wheel is another one.
    """
    if case.wheel != "AAR-1B":
        raise InputError(f"flange root radii of {case.wheel}", "AAR-1B", "choose the wheel with this parameter")
    load = case.load()

    def varied(name: str, radii: tuple[float, ...]) -> tuple[list[RigidGeometry], Floats]:
        found = [case.model_copy(update={name: radius}).geometry() for radius in radii]
        positions = [rigid_equilibrium(each, load, reached_only=True).position for each in found]
        laterals = [math.nan if each is None else each.motion_in_space.lateral_mm for each in positions]
        return found, np.array(laterals)

    geometries, lateral_narrow = varied("flange_root_radius_mm", FLANGE_ROOT_RADII_MM)
    lateral_wide = varied("wide_flange_root_radius_mm", WIDE_FLANGE_ROOT_RADII_MM)[1]
    ratios, laterals = [], []
    for each in geometries:
        path = each.path(25.0)
        lateral = each.axle_lateral(path)
        outward = (path.rail_level >= 0.0) & (np.arange(len(lateral)) <= int(np.argmax(lateral)))
        ratios.append(held_ratios(each, path)[outward])
        laterals.append(lateral[outward])
    return FlangeRootEffect(
        np.array(FLANGE_ROOT_RADII_MM),
        lateral_narrow,
        np.array(WIDE_FLANGE_ROOT_RADII_MM),
        lateral_wide,
        tuple(ratios),
        tuple(laterals),
    )


def _summary(
    name: str,
    case: GeometryCase,
    jumps: tuple[ContactJump, ...],
    conicities: Conicities,
    equilibrium: RigidEquilibrium,
    notices: list[str],
) -> dict[str, Any]:
    status, position = equilibrium.status, equilibrium.position
    return {
        "case": name,
        "title": _title(name, case),
        "status": {"converged": status.converged, "message": status.message},
        "inputs": case.model_dump(),
        "load_lateral_over_vertical": equilibrium.load_ratio,
        "equilibrium": None if position is None else _position_rows(position, case),
        "number_of_equilibria": len(equilibrium.positions),
        "all_equilibria": [
            {
                "lateral_mm": each.motion_in_space.lateral_mm,
                "stable": each.stable,
                "neutral_between_mm": each.neutral_mm,
            }
            for each in equilibrium.positions
        ],
        "jumps": [
            {
                "side": jump.side,
                "lateral_mm": jump.motion.lateral_mm,
                "wheel_points_mm": jump.wheel_points_mm,
                "rail_points_mm": jump.rail_points_mm,
            }
            for jump in jumps
        ],
        "equivalent_conicity": conicities.at_reference(),
        "notices": notices,
        "versions": versions(),
    }


def _title(name: str, case: GeometryCase) -> str:
    """Return the title of a case with the inputs that are changed."""
    if name not in GEOMETRY_CASES:
        return name
    title, values = GEOMETRY_CASES[name]
    usual = GeometryCase.from_values(values).model_dump()
    changed = [f"{key} = {value}" for key, value in case.model_dump(exclude={"units"}).items() if value != usual[key]]
    return f"{title}; changed: {', '.join(changed)}" if changed else title


def _position_rows(position: RigidPosition, case: GeometryCase) -> dict[str, Any]:
    steel = Elastic(case.young_MPa, case.poisson).plane_modulus
    modulus = contact_modulus(steel, steel)
    return {
        "lateral_mm": position.motion_in_space.lateral_mm,
        "vertical_mm": position.motion_in_space.vertical_mm,
        "roll_rad": position.motion_in_space.roll_rad,
        "stable": position.stable,
        "neutral_between_mm": position.neutral_mm,
        "residual": position.residual,
        "lateral_over_vertical": {side: position.lateral_over_vertical(side) for side in SIDES},
        "contacts": [_contact_row(point, case.thickness_mm, modulus) for point in position.contacts],
    }


def _contact_row(point: RigidContactPoint, thickness_mm: float, modulus: float) -> dict[str, Any]:
    hertz = point.hertz(thickness_mm, modulus)
    return {
        "side": point.side,
        "normal_force_kN": 1e-3 * point.normal_force_N,
        "contact_angle_deg": math.degrees(point.contact_angle_rad),
        "rolling_radius_mm": point.rolling_radius_mm,
        "ahead_of_axle_mm": point.ahead_mm,
        "wheel_point_mm": point.wheel_point_mm,
        "rail_point_mm": point.rail_point_mm,
        "relative_curvature_per_mm": point.relative_curvature_per_mm,
        "hertz_half_width_mm": None if hertz is None else hertz.half_width,
        "hertz_max_pressure_MPa": None if hertz is None else hertz.max_pressure,
    }
