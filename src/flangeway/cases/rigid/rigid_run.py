"""The geometry of contact of a rigid wheelset on rigid rails: what ``flangeway geometry`` computes."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.cases.case import Progress
from flangeway.cases.rigid.conicities import Conicities, conicities_of
from flangeway.cases.rigid.rigid_case import GEOMETRY_CASES, GeometryCase
from flangeway.cases.wheelset.wheelset_profiles import profile_notes, worn_field_sides
from flangeway.errors import InputError
from flangeway.exact import contact_modulus
from flangeway.materials import Elastic
from flangeway.railway.profiles.curvature import conforming
from flangeway.railway.rigid.rigid_contact import (
    ContactJump,
    RigidWheelset,
    contact_jumps,
    contact_locus,
    lateral_limits,
    locus_of,
    path_of_contact,
    unrolled_limits,
)
from flangeway.railway.rigid.rigid_equilibrium import (
    RigidContactPoint,
    RigidEquilibrium,
    RigidPosition,
    held_ratios,
    rigid_equilibrium,
)
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.railway.rigid.rolling_radii import RollingRadiusDifference
from flangeway.railway.track.placements import SIDES, Track, Wheelset
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions
from flangeway.types import Floats

FLANGE_ROOT_RADII_MM = (10.0, 12.0, 14.2875, 17.4625, 20.0)
"""Radii of the flange root's narrow arc that the figure compares."""

WIDE_FLANGE_ROOT_RADII_MM = (30.0, 34.0, 38.1, 44.0, 50.0)
"""Radii of the flange root's wide arc that the figure compares."""

_FURTHER_MM = 4.0  # beyond the maximum amplitude: an asymmetric wheelset swings about another place


@dataclass(frozen=True, eq=False)
class FlangeRootEffect:
    """Lateral motion in balance over the radii of the flange root.

    Parameters
    ----------
    narrow_mm, wide_mm
        Radii of the narrow and of the wide arc, (n,) and (m,).
    lateral_narrow_mm, lateral_wide_mm
        Lateral motion in balance for each, the other radius as it is; nan where there is no balance.
    ratios, laterals_mm
        For each narrow radius: lateral force over weight that is in balance at a lateral motion.

    """

    narrow_mm: Floats
    lateral_narrow_mm: Floats
    wide_mm: Floats
    lateral_wide_mm: Floats
    ratios: tuple[Floats, ...]
    laterals_mm: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class GeometryRun:
    """Contact geometry of a case.

    Parameters
    ----------
    name, case
        What was computed.
    wheelset
        Rigid curves.
    locus
        Points of contact over the lateral motion.
    jumps
        Where they jump.
    conicities
        Equivalent conicity over the amplitude.
    equilibrium
        RelativeResiduals under the load.
    flange root
        Effect of the flange root's radii on the balance; None for wheels without that parameter, without lateral
        force or without balance.
    summary
        What ``geometry.json`` holds.

    """

    name: str
    case: GeometryCase
    wheelset: RigidWheelset
    locus: ContactLocus
    jumps: tuple[ContactJump, ...]
    conicities: Conicities
    equilibrium: RigidEquilibrium
    flange_root: FlangeRootEffect | None
    summary: dict[str, Any]

    @property
    def amplitudes_mm(self) -> Floats:
        """Amplitudes of the conicity, (n,); empty if the wheelset does not steer."""
        return self.conicities.amplitudes_mm

    @property
    def conicity(self) -> Floats:
        """Equivalent conicity by integration, (n,)."""
        return self.conicities.integration

    @property
    def regression(self) -> Floats:
        """Equivalent conicity by linear regression, (n,)."""
        return self.conicities.regression


def run_geometry(
    name: str, case: GeometryCase, progress: Progress = lambda _: None, notices: Sequence[str] = ()
) -> GeometryRun:
    """Compute the contact geometry of a case.

    Parameters
    ----------
    name
        Name to show.
    case
        The case.
    progress
        Called with a sentence at each stage.
    notices
        Sentences about the inputs, to be shown with those about the results.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails.

    """
    start = time.perf_counter()
    track, axle = case.track(), case.wheelset()
    wheelset = RigidWheelset.of(track, axle, case.yaw_rad)
    said = list(notices)
    progress("lowering the wheelset on the rails")
    reach = max(case.maximum_lateral_mm, case.maximum_amplitude_mm + _FURTHER_MM)
    whole = _scanned(wheelset, case, reach)
    wanted = math.floor(case.maximum_lateral_mm / case.step_mm + 1e-9) * case.step_mm
    shown = np.abs(whole.lateral_mm) < wanted + 0.5 * case.step_mm
    first, last = np.flatnonzero(shown)[[0, -1]]
    locus = whole.part(slice(first, last + 1))
    if min(-locus.lateral_mm[0], locus.lateral_mm[-1]) < wanted - 0.5 * case.step_mm:
        said.append(
            f"the scan of {case.maximum_lateral_mm:g} mm stops at lateral motions of {locus.lateral_mm[0]:.2f} and "
            f"{locus.lateral_mm[-1]:.2f} mm: beyond, a flange climbs or a running surface ends"
        )
    progress("narrowing the jumps of the points of contact")
    jumps = contact_jumps(wheelset, float(np.abs(locus.lateral_mm).max())) if case.roll == "free" else ()
    progress("integrating the wave motion")
    conicities = conicities_of(RollingRadiusDifference.of(whole), case.maximum_amplitude_mm)
    said += conicities.notices
    progress("seeking the balance under the load")
    equilibrium = rigid_equilibrium(wheelset, case.load())
    flange_root = None
    if case.wheel == "AAR-1B" and case.lateral_force_kN != 0.0 and equilibrium.position is not None:
        progress("varying the radii of the flange root")
        flange_root = flange_root_effect(case)
    said += [*worn_field_sides(track), *case.derived(), *profile_notes(track, axle)]
    summary = _summary(name, case, jumps, conicities, equilibrium, said)
    _leave_out_conforming(summary, track, axle)
    summary["timings_s"] = {"total": time.perf_counter() - start}
    summary["peak_memory_MB"] = peak_memory_bytes() / 1e6
    return GeometryRun(name, case, wheelset, locus, jumps, conicities, equilibrium, flange_root, summary)


def _leave_out_conforming(summary: dict[str, Any], track: Track, axle: Wheelset) -> None:
    """Leave out Hertz's estimates of contacts that conform, see `flangeway.railway.profiles.curvature.conforming`."""
    for row in (summary["equilibrium"] or {"contacts": ()})["contacts"]:
        wheel, rail, width = axle.wheel_of(row["side"]), track.rail_of(row["side"]), row["hertz_half_width_mm"]
        if width is not None and conforming(wheel, row["wheel_point_mm"], rail, row["rail_point_mm"], width):
            row["hertz_half_width_mm"] = row["hertz_max_pressure_MPa"] = None


def _scanned(wheelset: RigidWheelset, case: GeometryCase, reach: float) -> ContactLocus:
    """Positions to both sides as far as the wheels stand on the rails and no flange has turned the axle back."""
    rolls = case.roll == "free"
    low, high = lateral_limits(wheelset, reach) if rolls else unrolled_limits(wheelset, reach)
    numbers = np.arange(math.ceil(max(low, -reach) / case.step_mm), math.floor(min(high, reach) / case.step_mm) + 1)
    return contact_locus(wheelset, numbers * case.step_mm, roll=rolls)


def flange_root_effect(case: GeometryCase) -> FlangeRootEffect:
    """Lateral motion in balance for several radii of the AAR-1B's flange root.

    Raises
    ------
    InputError
        If the case's wheel is another one.

    """
    if case.wheel != "AAR-1B":
        raise InputError(f"flange root radii of {case.wheel}", "AAR-1B", "choose the wheel with this parameter")
    load = case.load()

    def lateral(**changes: float) -> tuple[RigidWheelset, float]:
        wheelset = case.model_copy(update=changes).curves()
        position = rigid_equilibrium(wheelset, load, reached_only=True).position
        return wheelset, math.nan if position is None else position.motion_in_space.lateral_mm

    narrow = [lateral(flange_root_radius_mm=radius) for radius in FLANGE_ROOT_RADII_MM]
    wide = [lateral(wide_flange_root_radius_mm=radius)[1] for radius in WIDE_FLANGE_ROOT_RADII_MM]
    ratios, laterals = [], []
    for wheelset, _ in narrow:
        path = path_of_contact(wheelset, 25.0)
        locus = locus_of(wheelset, path)
        outward = (path.rail_level >= 0.0) & (np.arange(len(path.rail_level)) <= int(np.argmax(locus.lateral_mm)))
        ratios.append(held_ratios(wheelset, path)[outward])
        laterals.append(locus.lateral_mm[outward])
    return FlangeRootEffect(
        np.array(FLANGE_ROOT_RADII_MM),
        np.array([value for _, value in narrow]),
        np.array(WIDE_FLANGE_ROOT_RADII_MM),
        np.array(wide),
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
    """Return what the case is, and which of its inputs are changed."""
    if name not in GEOMETRY_CASES:
        return name
    title, values = GEOMETRY_CASES[name]
    usual = GeometryCase.from_values(values).model_dump()
    changed = [f"{key} = {value}" for key, value in case.model_dump().items() if value != usual[key]]
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
