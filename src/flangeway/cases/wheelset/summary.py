"""What a run found, as plain numbers with their units in the keys: the contents of ``summary.json``."""

import json
import math
from pathlib import Path
from typing import Any

from flangeway.cases.wheelset.summary_rows import (
    bending_rows,
    contact_row,
    motion_row,
    other_rows,
    rigid_rows,
    support_rows,
)
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.cases.wheelset.wheelset_curve import PUBLISHED_CM, WheelsetCurveCase
from flangeway.cases.wheelset.wheelset_profiles import profile_notes, worn_field_sides
from flangeway.post import cell_stresses
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.residual import RelativeResiduals
from flangeway.railway.wheelset.validity import SLICE, below_contacts
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions

REFERENCE = (
    "Motion from the reference position, in which the axle is level, in the middle of the track, and the wheels' tape "
    "lines are at the height of the rails' tops (y = 0), in the track's axes; beside it along horizontal and vertical. "
    "The approach is the descent from the position in which rigid wheels touch (in a curve: come to rest)."
)
PUBLISHED_REASON = (
    "Published position of the curve (Moherdaui 2021, Table 16, along horizontal and vertical): its vertical "
    "displacement counts from a reference that is not given, with a gap of about 2.6 mm; its lateral displacement is "
    "decided by where the wheel's flange root meets the rail. The root of the AAR-1B is assumed here, which makes the "
    "lateral displacement 1 to 3 mm larger. `flangeway reproduce wheel-rail` compares with a root that one of the "
    "published numbers identifies."
)
CONFORMING = (
    "Hertz's theory is left out where wheel and rail conform: where its half width is above half of a radius of either "
    "profile, or the gap of the profiles at an end of it is 1.5 times that of constant curvature, or less than 1 / 1.5."
)
AXES = {
    "space": (
        "The track's axes: x across the track to the right, y up from its plane; origin in the middle of the track at "
        "the top of the rails; roll counter-clockwise about the axle's middle. Superelevation turns them in space."
    ),
    "rail": (
        "The right rail's profile: x from the middle of its base away from the middle of the track, y up "
        "from its base, before cant. The left rail is its mirror image."
    ),
    "wheel": (
        "The right wheel's profile: x from the tape line away from the middle of the track, y up to the "
        "axle. The left wheel is its mirror image."
    ),
    "bending": (
        "Motions of a rail's head are those of its top against the fixed base, the track's axes; stresses along the "
        "free surface between head and base, tension positive, places in the rail's profile."
    ),
    "support": (
        "What base or axle do to rail or wheel, the track's axes; moments counter-clockwise about the middle of the "
        "base or of the axle, in kN mm; the eccentricity of a base's force counts away from the track."
    ),
    "forces": "Of the rail on the wheel, the track's axes: a positive lateral force pushes the wheel to the right.",
}


def summarise(case: WheelsetCase, result: WheelsetResult, total_s: float) -> dict[str, Any]:
    """Return the summary of a solved case.

    Parameters
    ----------
    case
        The inputs.
    result
        The solution.
    total_s
        Wall-clock time of the computation in seconds.

    Returns
    -------
    dict
        Strings, booleans, ints, floats, lists and dicts; a number that is not finite becomes None.

    """
    motion = result.equilibrium.motion
    timings = {name.replace("-", "_"): seconds for name, seconds in result.timings_s.items()}
    summary = {
        "status": {"converged": result.status.converged, "message": result.status.message},
        "motion": {
            **motion_row(motion),
            "approach_mm": result.approach_mm,
            "horizontal_in_space_mm": result.motion_in_space.lateral_mm,
            "vertical_in_space_mm": result.motion_in_space.vertical_mm,
            "stable": result.equilibrium.stable,
            "reference": REFERENCE,
        },
        "other_equilibria": other_rows(result),
        "load": _load(result),
        "balance": _balance(result.equilibrium.balance),
        "sides": [_side(result, side) for side in SIDES],
        "contacts": [contact_row(result, patch) for patch in result.patches],
        "rigid": rigid_rows(result),
        "stresses": _stresses(result),
        "bending": bending_rows(result),
        "support": support_rows(result),
        "bodies": _bodies(result),
        "timings_s": timings | {"total": total_s},
        "peak_memory_MB": peak_memory_bytes() / 1e6,
        "case": {"name": case.name, **case.model_dump()},
        "axes": AXES,
        "assumptions": _assumptions(case, result),
        "published": published_position(case),
        "warnings": [*result.warnings, *worn_field_sides(result.model.problem.track)],
        "versions": versions(),
    }
    plain: dict[str, Any] = plain_numbers(summary)
    return plain


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write a summary as JSON."""
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _load(result: WheelsetResult) -> dict[str, float]:
    load = result.model.problem.load
    along, onto = load.in_track
    return {
        "vertical_kN": load.vertical_N / 1e3,
        "lateral_kN": load.lateral_N / 1e3,
        "tilt_rad": load.tilt_rad,
        "lateral_in_track_kN": along / 1e3,
        "onto_track_kN": onto / 1e3,
    }


def _side(result: WheelsetResult, side: Side) -> dict[str, Any]:
    """Total force on a wheel and its L/V."""
    lateral, vertical = result.force_on_wheel_N(side) / 1e3
    return {
        "side": side,
        "lateral_force_kN": lateral,
        "vertical_force_kN": vertical,
        "lateral_over_vertical": result.lateral_over_vertical(side),
    }


def published_position(case: WheelsetCase) -> dict[str, Any]:
    """Published position of the curve, with why it differs; nothing for other cases or other inputs."""
    if not isinstance(case, WheelsetCurveCase) or not _is_as_published(case):
        return {}
    vertical, horizontal, roll = PUBLISHED_CM[case.method, case.order]
    return {
        "vertical_mm": 10.0 * vertical,
        "horizontal_mm": 10.0 * horizontal,
        "roll_rad": roll,
        "reason": PUBLISHED_REASON,
    }


def _is_as_published(case: WheelsetCase) -> bool:
    """Whether all inputs but method and order are the defaults, which are those of Moherdaui (2021)."""
    fields = type(case).model_fields
    return all(
        getattr(case, key) == field.get_default(call_default_factory=True)
        for key, field in fields.items()
        if key not in ("method", "order")
    )


def _balance(balance: RelativeResiduals) -> dict[str, float]:
    return {
        "vertical_residual": balance.vertical_residual,
        "lateral_residual": balance.lateral_residual,
        "moment_residual": balance.moment_residual,
        "equilibrium_residual": balance.equilibrium_residual,
    }


def _stresses(result: WheelsetResult) -> list[dict[str, Any]]:
    """Extremes of the cells' mean stresses, part by part: below the contacts, and anywhere in the slice."""
    rows = []
    for name, displacement in result.displacements.items():
        stresses = cell_stresses(result.model.parts[name].body.elasticity, displacement)
        near = below_contacts(result.model, result.patches, name)
        rows.append(
            {
                "part": name,
                "max_von_mises_below_contacts_MPa": stresses.von_mises[near].max() if near.any() else None,
                "max_von_mises_MPa": stresses.von_mises.max(),
                "min_principal_MPa": stresses.principal[:, 2].min(),
                "max_in_plane_shear_MPa": stresses.in_plane_shear.max(),
            }
        )
    return sorted(rows, key=lambda row: row["part"])


def _bodies(result: WheelsetResult) -> list[dict[str, Any]]:
    model = result.model
    return [
        {
            "name": body.name,
            "unknowns": body.stiffness.n,
            "cells": body.mesh.n_cells,
            "points": body.mesh.n_points,
            "parts": sorted(name for name, part in model.parts.items() if part.body is body),
        }
        for body in model.bodies
    ]


def _assumptions(case: WheelsetCase, result: WheelsetResult) -> list[str]:
    problem = result.model.problem
    wheelset, track = problem.wheelset, problem.track
    role, reason = problem.primary
    alike = wheelset.is_symmetric and track.is_symmetric
    materials = {"wheels": problem.material_of("wheel"), "rails": problem.material_of("rail")}
    if materials["wheels"] == materials["rails"]:
        materials = {"steel": problem.material}
    return [
        "Plane strain: the bodies do not stretch along the track.",
        SLICE.format(case.thickness_mm),
        f"Thickness {case.thickness_mm:g} mm: this length of wheel and rail bears the whole load.",
        *case.derived(),
        *profile_notes(track, wheelset),
        *(
            f"Linear elastic, isotropic {name}: Young's modulus {each.young:g} MPa, Poisson's ratio "
            f"{each.poisson:g}; no yielding, however high the stress."
            for name, each in materials.items()
        ),
        "Contact without friction.",
        *([CONFORMING] if any(patch.hertz is None for patch in result.patches) else []),
        f"The {role}s give the segments of contact: {reason}.",
        "The rails are fixed along their whole base.",
        "The wheels' cuts and the axle are rigid; the load acts at the car's centre of gravity and stays vertical"
        + (", its lateral force horizontal." if problem.load.lateral_N else "."),
        *(["The left side is the mirror image of the right side, mesh included."] if alike else []),
    ]


def plain_numbers(value: Any) -> Any:
    """Turn arrays and numpy numbers into lists and Python's own; what is not finite into None."""
    if isinstance(value, dict):
        return {key: plain_numbers(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain_numbers(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
