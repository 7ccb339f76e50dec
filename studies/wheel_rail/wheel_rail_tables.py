"""Tables 15 and 16: the published kind of computation, the flange root that one number identifies, and comparisons."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.wheelset_case import WheelsetCase, WheelsetCurveCase, WheelsetTangentCase
from flangeway.elements import TraceStabilisation
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import WheelProfile, wheel
from flangeway.railway.profiles.flange_root import (
    IDENTIFIED,
    IDENTIFIED_RADIUS_MM,
    with_flange_root,
    with_wide_flange_root,
)
from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from studies.study import Limit, Row, Run, published_rows

CASES: dict[str, type[WheelsetCase]] = {"tangent": WheelsetTangentCase, "curve": WheelsetCurveCase}
TABLES = {"tangent": 15, "curve": 16}
METHODS = {"F": "fem", "V": "vem"}
CODES = ("FO1", "VO1", "FO2", "VO2")

FITTED_CODE = "VO2"  # row of Table 16 whose lateral translation identifies the flange root
NODAL_PENALTY_N_PER_MM = {"F": 1e7, "V": 5e6}
"""Penalty of triangles and polygons (Moherdaui 2021, Table 10, mesh 1: 1e5 and 5e4 kN/cm)."""
RAIL_MM, WHEEL_MM, BODY_MM = 0.6, 0.5, 5.0
"""Sizes of triangles where rail and wheel touch, and elsewhere (Moherdaui 2021, Table 9, mesh 1; none in chapter 7)."""

MAX_RESIDUAL = 1e-9  # maximum equilibrium residual
FIT = 1e-3  # maximum relative difference of the fitted lateral translation
PREDICTED = 0.05  # maximum relative difference of predicted numbers
SYMMETRIC_CM, SYMMETRIC_RAD = 1e-4, 1e-6
"""Maximum lateral translation and rotation on tangent track, where they vanish by symmetry."""
SAME_CM = 3e-4
"""Maximum error of a difference of two vertical translations on tangent track: they are published to 1e-4, and the size
of elements away from contact, which is not given, changes it by another 2e-4."""
FOUND_MM = 0.05  # maximum difference of the radius found again from the bundled one

Results = dict[tuple[str, str], WheelsetResult]  # by situation and code

FAMILIES = {"arcs moved": with_flange_root, "narrow arc in place": with_wide_flange_root}
MEMBERS_MM = {"arcs moved": (54.0, 44.0), "narrow arc in place": (68.0, 80.0, 56.0)}
"""Radii of the wide arc that are computed beside the identified one, the last of each only without ``quick``."""
MEMBER_CODE = "FO1"
COARSE_MM = 10.0  # another size of triangles away from contact, to show its influence on the differences of the rows
BY_HAND = "the published equilibrium was found by hand"


def published_case(situation: str, code: str, body_mm: float = BODY_MM) -> WheelsetCase:
    """Return the case of a row: identified wheel, node-to-segment, penalty per node, one mesh for both orders."""
    order = int(code[2])
    return CASES[situation].from_values(
        {
            "wheel": IDENTIFIED,
            "method": METHODS[code[0]],
            "order": order,
            "pairing": "node-to-segment",
            "nodal_penalty_N_per_mm": NODAL_PENALTY_N_PER_MM[code[0]],
            # sizes of order 2 are doubled by the case
            "rail_contact_size_mm": RAIL_MM / order,
            "wheel_contact_size_mm": WHEEL_MM / order,
            "body_size_mm": body_mm / order,
        }
    )


def published_problem(case: WheelsetCase) -> WheelsetProblem:
    """Return the problem of such a case with the published stabilisation of polygons (Moherdaui 2021, 3.96)."""
    problem = case.problem()
    return replace(problem, discretisation=replace(problem.discretisation, stabilisation=TraceStabilisation()))


def run_published(situation: str, code: str, body_mm: float = BODY_MM) -> WheelsetResult:
    """Solve a row from a cold start."""
    return solve_wheelset(published_problem(published_case(situation, code, body_mm)), cold=True)


def curve_with(profile: WheelProfile, code: str) -> WheelsetResult:
    """Solve the curve of a row with another wheel."""
    case = published_case("curve", code)
    problem = replace(published_problem(case), wheelset=replace(case.wheelset(), wheel=profile))
    found = solve_wheelset(problem, cold=True)
    if not found.status.converged:
        raise InputError(
            f"the curve with {profile.title}", "a wheel with an equilibrium position", found.status.message
        )
    return found


def identified_radius(known_mm: float, progress: Progress) -> float:
    """Find the radius in mm with which VO2 has the published lateral translation, by secants from the bundled one."""
    wanted = 10.0 * printed("curve", FITTED_CODE)["horizontal_translation_cm"]
    radii, laterals = [IDENTIFIED_RADIUS_MM], [known_mm]
    step = 2.0
    for _ in range(4):
        radii.append(radii[-1] + step)
        progress(f"flange root of {radii[-1]:.3f} mm")
        profile = with_flange_root(wheel("AAR-1B"), radii[-1])
        laterals.append(curve_with(profile, FITTED_CODE).position_in_space.lateral_mm)
        step = (wanted - laterals[-1]) * (radii[-1] - radii[-2]) / (laterals[-1] - laterals[-2])
        if abs(step) < 0.02 * FOUND_MM:
            break
    return radii[-1] + step


def root_rows(run: Run, results: Results) -> Iterator[Row]:
    """Radius found again (not if quick), and each family at the published lateral translation."""
    if not run.quick:
        found_mm = identified_radius(results["curve", FITTED_CODE].position_in_space.lateral_mm, run.progress)
        note = "identified again; reference: the bundled radius"
        quantity = "radius of the wide arc"
        limit = f"{FOUND_MM:g} mm"
        yield Row("flange root", FITTED_CODE, quantity, "mm", found_mm, IDENTIFIED_RADIUS_MM, limit, note)
    row, tangent = printed("curve", MEMBER_CODE), results["tangent", MEMBER_CODE].position_in_space
    lateral = row["horizontal_translation_cm"]
    sunk = _sunk(MEMBER_CODE)
    for family, make in FAMILIES.items():
        moved = {radius: make(wheel("AAR-1B"), radius) for radius in MEMBERS_MM[family][: -1 if run.quick else None]}
        positions = {}
        for radius, profile in moved.items():
            run.progress(f"flange root of {radius:g} mm, {family}")
            positions[radius] = curve_with(profile, MEMBER_CODE).position_in_space
        if family == "arcs moved":
            positions[IDENTIFIED_RADIUS_MM] = results["curve", MEMBER_CODE].position_in_space
        # on tangent track the root is not touched
        members = sorted(
            (at.lateral_mm / 10.0, at.roll_rad, (at.vertical_mm - tangent.vertical_mm) / 10.0, radius)
            for radius, at in positions.items()
        )
        laterals, *others = np.transpose(members)
        rotation, vertical, radius = (np.interp(lateral, laterals, values) for values in others)
        note = f"interpolated to the published lateral translation, at a wide arc of {radius:.1f} mm"
        code = f"{MEMBER_CODE}, {family}"
        yield Row("flange root", code, "rotation", "rad", rotation, row["rotation_rad"], None, note)
        quantity = "vertical translation, curve less tangent"
        yield Row("flange root", code, quantity, "cm", vertical, sunk, None, note)


@cache
def printed(situation: str, code: str) -> dict[str, float]:
    """Numbers of a row of Tables 15 and 16 by their columns."""
    rows = published_rows("wheel_rail_tables_15_16.csv")
    (row,) = (row for row in rows if (row.pop("situation"), row.pop("config")) == (situation, code))
    return {name: float(number) for name, number in row.items()}


def _sunk(code: str) -> float:
    """How much higher the wheelset is printed in the curve than on tangent track."""
    return printed("curve", code)["vertical_translation_cm"] - printed("tangent", code)["vertical_translation_cm"]


def table_rows(results: Results) -> Iterator[Row]:
    """Positions, their differences, and equilibrium residuals beside the published ones."""
    motions = {key: result.position_in_space for key, result in results.items()}
    for (situation, code), result in results.items():
        yield from (_tangent if situation == "tangent" else _curve)(code, motions)
        residuals = result.equilibrium.residuals
        for column, quantity, value in (
            ("vertical_force_error", "vertical residual", residuals.vertical_residual),
            ("horizontal_force_error", "lateral residual", residuals.lateral_residual),
            ("moment_error", "moment residual", residuals.moment_residual),
            ("resulting_error", "equilibrium residual", residuals.equilibrium_residual),
        ):
            limit = Limit(f"below {MAX_RESIDUAL:g}", abs(value) < MAX_RESIDUAL)
            published = printed(situation, code)[column]
            yield Row(TABLES[situation], f"{situation} {code}", quantity, "", value, published, limit, BY_HAND)


Motions = dict[tuple[str, str], WheelsetPosition]


def _shown_vertical(situation: str, code: str, motions: Motions) -> Row:
    published, value = printed(situation, code)["vertical_translation_cm"], motions[situation, code].vertical_mm / 10.0
    note = "the published reference position is not given; the same difference in all eight rows"
    return Row(TABLES[situation], f"{situation} {code}", "vertical translation", "cm", value, published, None, note)


def _tangent(code: str, motions: Motions) -> Iterator[Row]:
    motion, row, name = motions["tangent", code], printed("tangent", code), f"tangent {code}"
    yield _shown_vertical("tangent", code, motions)
    if code != FITTED_CODE:
        published = row["vertical_translation_cm"] - printed("tangent", FITTED_CODE)["vertical_translation_cm"]
        value = (motion.vertical_mm - motions["tangent", FITTED_CODE].vertical_mm) / 10.0
        quantity = f"vertical translation less that of {FITTED_CODE}"
        yield Row(15, name, quantity, "cm", value, published, f"{SAME_CM:g} cm", "predicted")
    note = "predicted: zero by symmetry; the published value comes from the asymmetry of its meshes"
    lateral, roll = motion.lateral_mm / 10.0, motion.roll_rad
    limit = Limit(f"{SYMMETRIC_CM:g} cm", abs(lateral) <= SYMMETRIC_CM)
    published = row["horizontal_translation_cm"]
    yield Row(15, name, "horizontal translation", "cm", lateral, published, limit, note)
    limit = Limit(f"{1e3 * SYMMETRIC_RAD:g} mrad", abs(roll) <= SYMMETRIC_RAD)
    yield Row(15, name, "rotation", "rad", roll, row["rotation_rad"], limit, note)


def _curve(code: str, motions: Motions) -> Iterator[Row]:
    motion, row, name = motions["curve", code], printed("curve", code), f"curve {code}"
    yield _shown_vertical("curve", code, motions)
    sunk = (motion.vertical_mm - motions["tangent", code].vertical_mm) / 10.0
    yield Row(16, name, "vertical translation, curve less tangent", "cm", sunk, _sunk(code), PREDICTED, "predicted")
    limit, note = PREDICTED, "predicted"
    if code == FITTED_CODE:
        limit, note = FIT, "fitted: the radius of the wheel's wide arc is chosen for it"
    published = row["horizontal_translation_cm"]
    yield Row(16, name, "horizontal translation", "cm", motion.lateral_mm / 10.0, published, limit, note)
    yield Row(16, name, "rotation", "rad", motion.roll_rad, row["rotation_rad"], PREDICTED, "predicted")
    if code != FITTED_CODE:
        yield from _apart(code, name, BODY_MM, motions)


def coarse_rows(run: Run) -> Iterator[Row]:
    """Differences of the rows of the curve with larger elements away from contact; of one row if quick."""
    motions = {}
    codes = (MEMBER_CODE, FITTED_CODE) if run.quick else CODES
    for code in codes:
        run.progress(f"curve, {code}, {COARSE_MM:g} mm away from contact")
        motions["curve", code] = run_published("curve", code, COARSE_MM).position_in_space
    for code in codes:
        if code != FITTED_CODE:
            yield from _apart(code, f"curve {code}, {COARSE_MM:g} mm away from contact", COARSE_MM, motions)


def _apart(code: str, name: str, body_mm: float, motions: Motions) -> Iterator[Row]:
    """How far a row of the curve is from the fitted one."""
    row, motion = printed("curve", code), motions["curve", code]
    base, first = printed("curve", FITTED_CODE), motions["curve", FITTED_CODE]
    note = "the element size away from contact is not given and determines these differences"
    for quantity, unit, column, value in (
        ("horizontal translation", "cm", "horizontal_translation_cm", (motion.lateral_mm - first.lateral_mm) / 10.0),
        ("rotation", "rad", "rotation_rad", motion.roll_rad - first.roll_rad),
    ):
        published = row[column] - base[column]
        limit, text = None, note
        if body_mm == BODY_MM:
            limit, text = Limit("same sign", published * value > 0.0), f"predicted, its sign: {note}"
        yield Row(16, name, f"{quantity} less that of {FITTED_CODE}", unit, value, published, limit, text)
