"""Tangent and curve by finite and virtual elements of both orders, and patches beside those of a fine direct mesh."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_case import WheelsetTangentCase
from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import spatial_patch
from flangeway.railway.wheelset.wheelset_model import build_model
from studies.study import Limit, Row, Run, percent
from studies.wheelset3d.one_wheel import FIXED, pressed_wheel

SITUATIONS: Mapping[str, Mapping[str, float]] = {
    "tangent": {},
    "curve": {"curve_radius_m": 500.0, "speed_km_h": 80.0, "superelevation_mm": 60.0},
}
METHODS = (("fem", 2), ("vem", 2), ("fem", 1), ("vem", 1))
"""The first is the reference of the others."""
FORCE_LIMIT, PRESSURE_LIMIT = 1e-3, 0.01


def method_rows(run: Run) -> Iterator[Row]:
    """Forces and pressures of both situations by each kind of elements beside those of the first; order 2 if quick."""
    base: dict[str, SpatialResult] = {}
    for method, order in METHODS[: 2 if run.quick else None]:
        code = f"{method} {order}"
        cases = {
            name: SpatialWheelsetCase.from_values({"method": method, "order": order, **values})
            for name, values in SITUATIONS.items()
        }
        run.progress(code)
        model = cases["tangent"].spatial_model()
        surfaces = running_surfaces(cases["tangent"].problem(), model, progress=run.progress)
        for name, case in cases.items():
            result = solve_position(SpatialWheelset(case.problem(), surfaces, model), {})
            run.check(f"{name}, {code}", result.status)
            if (method, order) == METHODS[0]:
                base[name] = result
            else:
                yield from _beside(name, code, base[name], result)


def _beside(table: str, code: str, base: SpatialResult, result: SpatialResult) -> Iterator[Row]:
    for side in SIDES:
        known, found = (each.force_on_wheel_N(side) for each in (base, result))
        allowed = FORCE_LIMIT * np.hypot(*known)
        for name, wanted, value in zip(("lateral", "vertical"), known.tolist(), found.tolist(), strict=True):
            limit = Limit(f"{percent(FORCE_LIMIT)} of the contact force", abs(value - wanted) <= allowed)
            yield Row(table, code, f"{name} force, {side} wheel", "N", value, wanted, limit)
        known_patches, patches = ([each for each in one.patches if each.side == side] for one in (base, result))
        for known_patch, patch in zip(known_patches, patches, strict=True):
            name = f"maximum pressure, {side} wheel, {known_patch.region}"
            value, wanted = patch.ellipse.max_pressure, known_patch.ellipse.max_pressure
            yield Row(table, code, name, "MPa", value, wanted, PRESSURE_LIMIT)


@dataclass(frozen=True)
class DirectMesh:
    """A wheel on a rail: the case, the vertical force in N, and cells and window of the direct mesh in mm."""

    case: Mapping[str, Any]
    force: float
    cell: float
    window: tuple[float, float]


WIDE = {
    "rail": "136RE",
    "wheel": "AAR-1B",
    "gauge_mm": 1600.0,
    "wheel_radius_mm": 500.0,
    "wheel_radius_at": "flange-tip",
}
EUROPE = {
    "rail": "60E1",
    "wheel": "S1002",
    "gauge_mm": 1435.0,
    "wheel_radius_mm": 460.0,
    "wheel_radius_at": "tape-line",
}
DIRECT = {
    "AAR-1B on 136RE": DirectMesh(WIDE, 150e3, 0.4, (15.0, 22.0)),
    "S1002 on 60E1": DirectMesh(EUROPE, 100e3, 0.4, (30.0, 17.0)),
}
DIRECT_LIMIT = 5e-3


def direct_numbers(name: str) -> Iterator[Row]:
    """Maximum pressure and semi-axes of a tabulated compliance beside those of a mesh that is fine in the patch."""
    given = DIRECT[name]
    case = {**given.case, "axle_load_kN": 2e-3 * given.force}
    fine = {**case, "contact_size_mm": given.cell / 2.0, "body_size_mm": 12.0}
    model = build_model(WheelsetTangentCase.from_values(fine).problem())
    (direct,) = spatial_patch(model, "right", given.force, cell_mm=given.cell, window_mm=given.window).patches
    problem = SpatialWheelsetCase.from_values(case).problem()
    wheelset = SpatialWheelset(problem, running_surfaces(problem, FIXED), FIXED)
    (found,) = pressed_wheel(wheelset, "right", given.force).patches
    for (quantity, unit, known), (_, _, value) in zip(_measures(direct), _measures(found), strict=True):
        yield Row(name, f"{given.force / 1e3:g} kN", quantity, unit, value, known, DIRECT_LIMIT)


def _measures(patch: ContactEllipse) -> tuple[tuple[str, str, float], ...]:
    longer, shorter = patch.semi_axes
    return (
        ("maximum pressure", "MPa", patch.max_pressure),
        ("longer semi-axis", "mm", longer),
        ("shorter semi-axis", "mm", shorter),
    )
