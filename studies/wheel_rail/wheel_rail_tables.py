"""Tables 15 and 16: the published kind of computation, the flange root that one number identifies, and comparisons."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.wheelset_case import WheelsetCase, WheelsetCurveCase, WheelsetTangentCase
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
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
from studies.published_numbers import ReproducedNumber, compare, percent, published_rows

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

FAMILIES = {"arcs moved": with_flange_root, "narrow arc in place": with_wide_flange_root}
MEMBERS_MM = {"arcs moved": (54.0, 44.0), "narrow arc in place": (68.0, 80.0, 56.0)}
"""Radii of the wide arc that are computed beside the identified one, the last of each only without ``quick``."""
MEMBER_CODE = "FO1"
COARSE_MM = 10.0  # another size of triangles away from contact, to show its influence on the differences of the rows
BY_HAND = "the published equilibrium was found by hand"


@dataclass(frozen=True, eq=False)
class WheelRailRow:
    """One row of Tables 15 and 16."""

    situation: str  # ``"tangent"`` or ``"curve"``
    code: str  # ``"FO1"``, ``"VO1"``, ``"FO2"`` or ``"VO2"``
    run: WheelsetRun  # the case and its result

    @property
    def result(self) -> WheelsetResult:
        """The solution."""
        return self.run.plane

    @property
    def motion(self) -> WheelsetPosition:
        """Displacement along horizontal and vertical."""
        return self.result.position_in_space

    @property
    def seconds(self) -> float:
        """Wall-clock time, meshing included."""
        return sum(self.result.timings_s.values())


@dataclass(frozen=True)
class RootMember:
    """A flange root of a family and the position of the wheelset of the curve with it."""

    family: str  # a key of `FAMILIES`
    radius_mm: float  # radius of the wide arc
    lateral_cm: float
    rotation_rad: float
    vertical_difference_cm: float
    """lateral_cm, rotation_rad, vertical_difference_cm: lateral translation, rotation, and vertical translation less
    that on tangent track, of FO1."""


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


def run_published(situation: str, code: str, body_mm: float = BODY_MM) -> WheelsetRun:
    """Solve a row from a cold start."""
    start = time.perf_counter()
    case = published_case(situation, code, body_mm)
    result = solve_wheelset(published_problem(case), cold=True)
    return WheelsetRun(case, result, time.perf_counter() - start)


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
    wanted = 10.0 * float(_printed()["curve", FITTED_CODE]["horizontal_translation_cm"])
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


def root_members(rows: Sequence[WheelRailRow], progress: Progress, *, quick: bool) -> tuple[RootMember, ...]:
    """Solve the curve with other members of both families; the identified one is among the rows."""
    at = {row.situation: row.motion for row in rows if row.code == MEMBER_CODE}
    members = []
    for family, make in FAMILIES.items():
        if family == "arcs moved":
            members.append(_member(family, IDENTIFIED_RADIUS_MM, at["curve"], at["tangent"]))
        for radius in MEMBERS_MM[family][: -1 if quick else None]:
            progress(f"flange root of {radius:g} mm, {family}")
            motion = curve_with(make(wheel("AAR-1B"), radius), MEMBER_CODE).position_in_space
            members.append(_member(family, radius, motion, at["tangent"]))
    return tuple(sorted(members, key=lambda each: (each.family, each.radius_mm)))


def _member(family: str, radius: float, curve: WheelsetPosition, tangent: WheelsetPosition) -> RootMember:
    # on tangent track the root is not touched
    sunk = (curve.vertical_mm - tangent.vertical_mm) / 10.0
    return RootMember(family, radius, curve.lateral_mm / 10.0, curve.roll_rad, sunk)


def root_numbers(members: Sequence[RootMember], found_mm: float | None) -> Iterator[ReproducedNumber]:
    """Radius found again, and each family at the published lateral translation."""
    if found_mm is not None:
        yield compare(
            "flange root", FITTED_CODE, "radius of the wide arc", "mm", (IDENTIFIED_RADIUS_MM, found_mm), FOUND_MM,
            "identified again; reference: the bundled radius", words=f"{FOUND_MM:g} mm",
            within=abs(found_mm - IDENTIFIED_RADIUS_MM) <= FOUND_MM,
        )  # fmt: skip
    printed = _printed()
    row = printed["curve", MEMBER_CODE]
    lateral = float(row["horizontal_translation_cm"])
    sunk = _vertical(printed, "curve", MEMBER_CODE) - _vertical(printed, "tangent", MEMBER_CODE)
    for family in FAMILIES:
        mine = sorted((each for each in members if each.family == family), key=lambda each: each.lateral_cm)
        places = np.array([(m.lateral_cm, m.rotation_rad, m.vertical_difference_cm, m.radius_mm) for m in mine]).T
        rotation, vertical, radius = (float(np.interp(lateral, places[0], values)) for values in places[1:])
        note = f"interpolated to the published lateral translation, at a wide arc of {radius:.1f} mm"
        for quantity, unit, values in (
            ("rotation", "rad", (float(row["rotation_rad"]), rotation)),
            ("vertical translation, curve less tangent", "cm", (sunk, vertical)),
        ):
            yield compare("flange root", f"{MEMBER_CODE}, {family}", quantity, unit, values, PREDICTED, note, words="")


def _printed() -> dict[tuple[str, str], dict[str, str]]:
    rows = published_rows("wheel_rail_tables_15_16.csv")
    return {(row["situation"], row["config"]): row for row in rows}


def _vertical(printed: dict[tuple[str, str], dict[str, str]], situation: str, code: str) -> float:
    return float(printed[situation, code]["vertical_translation_cm"])


def table_numbers(rows: Sequence[WheelRailRow]) -> Iterator[ReproducedNumber]:
    """Positions, their differences, and equilibrium residuals beside the published ones."""
    printed = _printed()
    motions = {(row.situation, row.code): row.motion for row in rows}
    for row in rows:
        key = (row.situation, row.code)
        yield from (_tangent if row.situation == "tangent" else _curve)(row.code, motions, printed)
        yield from _residuals(row, printed[key])


def _number(
    situation: str,
    code: str,
    quantity: str,
    unit: str,
    values: tuple[float, float],
    limit: str,
    note: str,
    *,
    within: bool | None = None,
) -> ReproducedNumber:
    """Row of the tables; without ``within`` the limit is `PREDICTED`."""
    name = f"{situation} {code}"
    return compare(TABLES[situation], name, quantity, unit, values, PREDICTED, note, words=limit, within=within)


Motions = dict[tuple[str, str], WheelsetPosition]
Printed = dict[tuple[str, str], dict[str, str]]


def _shown_vertical(situation: str, code: str, motions: Motions, printed: Printed) -> ReproducedNumber:
    values = (_vertical(printed, situation, code), motions[situation, code].vertical_mm / 10.0)
    apart = 10.0 * (values[1] - values[0])
    note = (
        f"difference {apart:.3f} mm: the published reference position is not given; the same difference in all eight "
        "rows"
    )
    return _number(situation, code, "vertical translation", "cm", values, "", note)


def _tangent(code: str, motions: Motions, printed: Printed) -> Iterator[ReproducedNumber]:
    motion, row = motions["tangent", code], printed["tangent", code]
    yield _shown_vertical("tangent", code, motions, printed)
    if code != FITTED_CODE:
        first = motions["tangent", FITTED_CODE].vertical_mm
        published = _vertical(printed, "tangent", code) - _vertical(printed, "tangent", FITTED_CODE)
        values = (published, (motion.vertical_mm - first) / 10.0)
        yield _number(
            "tangent", code, f"vertical translation less that of {FITTED_CODE}", "cm", values, f"{SAME_CM:g} cm",
            "predicted", within=abs(values[1] - values[0]) <= SAME_CM,
        )  # fmt: skip
    lateral, roll = motion.lateral_mm / 10.0, motion.roll_rad
    note = "predicted: zero by symmetry; the published value comes from the asymmetry of its meshes"
    yield _number(
        "tangent", code, "horizontal translation", "cm", (float(row["horizontal_translation_cm"]), lateral),
        f"{SYMMETRIC_CM:g} cm", note, within=abs(lateral) <= SYMMETRIC_CM,
    )  # fmt: skip
    yield _number(
        "tangent", code, "rotation", "rad", (float(row["rotation_rad"]), roll), f"{1e3 * SYMMETRIC_RAD:g} mrad", note,
        within=abs(roll) <= SYMMETRIC_RAD,
    )  # fmt: skip


def _curve(code: str, motions: Motions, printed: Printed) -> Iterator[ReproducedNumber]:
    motion, row = motions["curve", code], printed["curve", code]
    yield _shown_vertical("curve", code, motions, printed)
    sunk = (motion.vertical_mm - motions["tangent", code].vertical_mm) / 10.0
    published = _vertical(printed, "curve", code) - _vertical(printed, "tangent", code)
    limit = percent(PREDICTED)
    yield _number(
        "curve", code, "vertical translation, curve less tangent", "cm", (published, sunk), limit, "predicted"
    )
    lateral = (float(row["horizontal_translation_cm"]), motion.lateral_mm / 10.0)
    if code == FITTED_CODE:
        close = abs(lateral[1] / lateral[0] - 1.0) <= FIT
        note = "fitted: the radius of the wheel's wide arc is chosen for it"
        yield _number("curve", code, "horizontal translation", "cm", lateral, percent(FIT), note, within=close)
    else:
        yield _number("curve", code, "horizontal translation", "cm", lateral, limit, "predicted")
    rotation = (float(row["rotation_rad"]), motion.roll_rad)
    yield _number("curve", code, "rotation", "rad", rotation, limit, "predicted")
    if code == FITTED_CODE:
        return
    yield from _apart(code, code, BODY_MM, motions, printed)


def coarse_numbers(progress: Progress, *, quick: bool) -> Iterator[ReproducedNumber]:
    """Differences of the rows of the curve with larger elements away from contact; of one row if ``quick``."""
    motions, printed = {}, _printed()
    codes = (MEMBER_CODE, FITTED_CODE) if quick else CODES
    for code in codes:
        progress(f"curve, {code}, {COARSE_MM:g} mm away from contact")
        motions["curve", code] = run_published("curve", code, COARSE_MM).result.position_in_space
    for code in codes:
        if code != FITTED_CODE:
            yield from _apart(code, f"{code}, {COARSE_MM:g} mm away from contact", COARSE_MM, motions, printed)


def _apart(code: str, name: str, body_mm: float, motions: Motions, printed: Printed) -> Iterator[ReproducedNumber]:
    """How far a row of the curve is from the fitted one."""
    row, motion = printed["curve", code], motions["curve", code]
    base, first = printed["curve", FITTED_CODE], motions["curve", FITTED_CODE]
    given = body_mm == BODY_MM
    note = "the element size away from contact is not given and determines these differences"
    for quantity, unit, column, computed in (
        ("horizontal translation", "cm", "horizontal_translation_cm", (motion.lateral_mm - first.lateral_mm) / 10.0),
        ("rotation", "rad", "rotation_rad", motion.roll_rad - first.roll_rad),
    ):
        values = (float(row[column]) - float(base[column]), computed)
        yield _number(
            "curve", name, f"{quantity} less that of {FITTED_CODE}", unit, values, "same sign" if given else "",
            f"predicted, its sign: {note}" if given else note, within=values[0] * computed > 0.0,
        )  # fmt: skip


def _residuals(row: WheelRailRow, printed: dict[str, str]) -> Iterator[ReproducedNumber]:
    residuals = row.result.equilibrium.residuals
    for column, quantity, value in (
        ("vertical_force_error", "vertical residual", residuals.vertical_residual),
        ("horizontal_force_error", "lateral residual", residuals.lateral_residual),
        ("moment_error", "moment residual", residuals.moment_residual),
        ("resulting_error", "equilibrium residual", residuals.equilibrium_residual),
    ):
        yield _number(
            row.situation, row.code, quantity, "", (float(printed[column]), value), f"below {MAX_RESIDUAL:g}", BY_HAND,
            within=abs(value) < MAX_RESIDUAL,
        )  # fmt: skip
