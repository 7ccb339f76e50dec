"""The published wheelset (Moherdaui 2021, chapter 7): what ``flangeway reproduce wheel-rail`` computes."""

import itertools
import math
from collections.abc import Iterator
from functools import cache

import numpy as np

from flangeway.cases.case_file import load_case
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline
from flangeway.post import PressurePatch
from flangeway.railway.profiles.bundled import (
    IDENTIFIED,
    IDENTIFIED_RADIUS_MM,
    RailProfile,
    WheelProfile,
    wheel,
)
from flangeway.railway.track.placements import Track, WheelPair, WheelsetPosition
from flangeway.railway.track.wheelset_loads import Load, Position
from flangeway.railway.track.wheelset_problem import Mesh, Plane, WheelsetProblem
from flangeway.railway.wheelset.plane_patch import WheelRailPatch
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult, solve_wheelset
from flangeway.types import Floats, Progress
from flangeway_studies.flange_root import with_flange_root, with_wide_flange_root
from flangeway_studies.study import Limit, Published, Row, Run, published_rows

# --- Tables 15 and 16: the published kind of computation, the flange root that one number identifies, and comparisons.


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


@cache
def identified(situation: str) -> Wheelset:
    """Return the bundled case of a situation with the identified wheel."""
    case = load_case(f"wheelset-{situation}", wheel=IDENTIFIED)
    assert isinstance(case, Wheelset)
    return case


def published_case(situation: str, code: str, body_mm: float = BODY_MM) -> Wheelset:
    """Return the case of a row: identified wheel, node-to-segment, penalty per node, one mesh for both orders.

    Polygons have the published stabilisation (Moherdaui 2021, 3.96).
    """
    order = int(code[2])
    return identified(situation).replaced(
        mesh={"method": METHODS[code[0]], "order": order, "stabilisation": "trace"},
        contact={
            "pairing": "node-to-segment",
            "nodal_penalty_N_per_mm": NODAL_PENALTY_N_PER_MM[code[0]],
            # sizes of order 2 are doubled by the case
            "rail_mesh": {"contact_size_mm": RAIL_MM / order},
            "wheel_mesh": {"contact_size_mm": WHEEL_MM / order},
            "body_size_mm": body_mm / order,
        },
    )


def run_published(situation: str, code: str, body_mm: float = BODY_MM) -> WheelsetResult:
    """Solve a row from a cold start."""
    return solve_wheelset(published_case(situation, code, body_mm), cold=True)


def curve_with(profile: WheelProfile, code: str) -> WheelsetResult:
    """Solve the curve of a row with another wheel."""
    result = solve_wheelset(published_case("curve", code).replaced(wheelset={"wheel": profile}), cold=True)
    if not result.status.converged:
        raise InputError(
            f"the curve with {profile.title}", "a wheel with an equilibrium position", result.status.message
        )
    return result


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


# --- The wheelset varied: stiffer material beside the rigid one, finer meshes in contact, one arc on one arc.


FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # factors on Young's modulus
DIVISORS = (1, 2, 4)  # divisors of the element size in contact
ONE_ARC = 0.01  # maximum relative difference of one arc on one arc from Hertz's theory
ROLL_ARM_MM = 750.0  # half the distance of the contacts: turns a roll into a length


def rigid_differences_mm(result: WheelsetResult) -> tuple[Floats, float]:
    """Distances of a wheelset from the rigid equilibrium of the same inputs.

    Lateral and vertical displacement in the track's axes, and roll times `ROLL_ARM_MM`, elastic less rigid; and the
    maximum distance on the rail of a rigid contact point from the nearest elastic centre of pressure of its side.
    """
    equilibrium = result.model.rigid_start.equilibrium
    assert equilibrium is not None
    rigid, one = equilibrium.reached(), result.equilibrium.position
    other, points = rigid.motion, []
    for contact in rigid.contacts:
        rail_points = [patch.rail_point_mm for patch in result.patches if patch.side == contact.side]
        points.append(
            min((float(np.hypot(*(p - np.array(contact.rail_point_mm)))) for p in rail_points), default=np.inf)
        )
    differences = (
        one.lateral_mm - other.lateral_mm,
        one.vertical_mm - other.vertical_mm,
        ROLL_ARM_MM * (one.roll_rad - other.roll_rad),
    )
    return np.array(differences), max(points)


def contact_name(result: WheelsetResult, patch: WheelRailPatch) -> str:
    """Side of a contact and the part of the wheel that touches: ``tread`` or ``flange root``.

    The wheel is one whose tread is a segment of that name.
    """
    wheel = result.model.problem.wheelset.wheel_of(patch.side)
    tread = [name for name in wheel.running_names if name.startswith("tread")]
    in_root = patch.wheel_point_mm[0] < wheel.outline.bounds(tread)[0, 0]
    return f"{patch.side} {'flange root' if in_root else 'tread'}"


def contact_quantities(result: WheelsetResult) -> Published:
    """Force in N, maximum pressure and maximum shear stresses below in MPa, by patch and quantity."""
    numbers = {}
    for patch in result.patches:
        name = contact_name(result, patch)
        numbers[name, "force"] = np.hypot(*patch.force_on_wheel_N)
        numbers[name, "maximum pressure"] = patch.max_pressure
        numbers[name, "maximum shear in the rail"] = patch.below["rail"][0].value_MPa
        numbers[name, "maximum shear in the wheel"] = patch.below["wheel"][0].value_MPa
    return numbers


WHEEL_RADIUS_MM, RAIL_RADIUS_MM = 330.0, 254.0
WIDTH_MM, HEIGHT_MM = 140.0, 120.0
LOADS_N = (60e3, 120e3)  # loads of the wheelset, half of them on each side; the second twice the first

THICKNESS_MM = 10.0
SOURCE = "one arc between straight lines, to compare with Hertz's theory"


def one_arc_rail() -> RailProfile:
    """Return a block with a round top, the middle of its base at the origin."""
    half = 0.5 * WIDTH_MM
    low = HEIGHT_MM - _sagitta(RAIL_RADIUS_MM, half)
    outline = Outline.from_segments(
        [
            Line((-half, 0.0), (half, 0.0)),
            Line((half, 0.0), (half, low)),
            Arc((half, low), (-half, low), (0.0, HEIGHT_MM - RAIL_RADIUS_MM), counter_clockwise=True),
            Line((-half, low), (-half, 0.0)),
        ],
        ["base", "field", "head", "gauge"],
    )
    return RailProfile("block with a round top", outline, ("head",), ("base",), "exact", SOURCE)


def one_arc_wheel() -> WheelProfile:
    """Return a block with a round bottom, the lowest point on the tape line."""
    half = 0.5 * WIDTH_MM
    low = _sagitta(WHEEL_RADIUS_MM, half)
    outline = Outline.from_segments(
        [
            Arc((-half, low), (half, low), (0.0, WHEEL_RADIUS_MM), counter_clockwise=True),
            Line((half, low), (half, HEIGHT_MM)),
            Line((half, HEIGHT_MM), (-half, HEIGHT_MM)),
            Line((-half, HEIGHT_MM), (-half, low)),
        ],
        ["tread", "rim", "cut", "back"],
    )
    return WheelProfile("block with a round bottom", outline, ("tread",), 0.0, half, "exact", SOURCE)


def one_arc_rows(run: Run) -> Iterator[Row]:
    """Pressure, half width and approach of two arcs under two loads beside Hertz's."""
    run.progress("one arc on one arc")
    track = Track(rail=one_arc_rail(), gauge_mm=1500.0, inclination=0.0, gauge_at="narrowest")
    # the wheels stand over the middles of their rails
    wheels = WheelPair(wheel=one_arc_wheel(), back_to_back_mm=1500.0, radius_mm=500.0, radius_at="flange-tip")
    # round on round a wheelset is not stable sideways
    upright = Position(lateral_mm=0.0, roll_rad=0.0)
    problem = WheelsetProblem(
        track=track,
        wheelset=wheels,
        load=Load(centre_of_gravity_height_mm=0.0),
        position=upright,
        contact=ONE_ARC_CONTACT,
        mesh=Mesh(order=2),
    )
    approaches = []
    for load in LOADS_N:
        result = solve_wheelset(problem.replaced(load={"axle_load_kN": 1e-3 * load}), cold=True)
        run.check(f"one arc on one arc, {0.5 * load:g} N", result.status)
        approaches.append(result.approach_mm)
    patch = next(patch for patch in result.patches if patch.side == "right")
    modulus, curvature = result.model.hertz.modulus, 1.0 / WHEEL_RADIUS_MM + 1.0 / RAIL_RADIUS_MM
    theory, (pressure, half_width) = (
        LineContact(0.5 * load / THICKNESS_MM, curvature, modulus),
        _ellipse(patch),
    )
    bend = approaches[1] - 2.0 * approaches[0]
    exact = -math.log(2.0) * LOADS_N[0] / THICKNESS_MM / (math.pi * modulus)
    for quantity, unit, value, wanted in (
        ("maximum pressure", "MPa", pressure, theory.max_pressure),
        ("half width", "mm", half_width, theory.half_width),
        ("approach under twice the load less twice the approach", "mm", bend, exact),
    ):
        yield Row(
            "Hertz", "one arc on one arc", quantity, unit, value, wanted, ONE_ARC, "reference: Hertz's line contact"
        )


def _ellipse(patch: PressurePatch) -> tuple[float, float]:
    """Height and half width of ``p^2 = p0^2 (1 - x^2 / a^2)`` by least squares; nodes jump by elements."""
    bent, slope, level = np.polyfit(patch.along, patch.pressures**2, 2)
    top = level - slope**2 / (4.0 * bent)
    return math.sqrt(top), math.sqrt(-top / bent)


def _sagitta(radius: float, half: float) -> float:
    return radius - float(np.sqrt(radius**2 - half**2))


# --- The published wheelset (chapter 7, Tables 15 and 16) on tangent track and in a curve, computed again from cold.
#
# One number of the tables, the lateral translation of VO2 in the curve, identifies the flange root of the wheel; the
# other positions are predicted. Checked as well: equilibrium, agreement of the methods, contact regions, the rigid
# limit, and refinement in contact.


AGREEMENT = {"VO2": (0.01, 0.05), "FO1": (0.04, 0.5), "VO1": (0.04, 0.5)}
"""Maximum relative difference of a patch's force, and difference of the lateral displacement in mm, from FO2."""
REGIONS = ("left tread", "right flange root", "right tread")
"""Contacts of the curve: one on the inner rail, tread and flange root on the outer one."""
RIGID_MM, RIGID_POINT_MM = 0.01, 0.5
"""Maximum distance of the position, extrapolated to rigid bodies, and of the contact points from the rigid ones."""
REQUIRED_FACTOR = 100.0  # factor on Young's modulus from which the contact points must be the rigid ones
ONE_ARC_CONTACT = Plane(thickness_mm=THICKNESS_MM, contact_size_mm=0.1, body_size_mm=4.0, enforcement="multiplier")
REFINED = {
    "force": 0.005,
    "maximum pressure": 0.03,
    "maximum shear in the rail": 0.03,
    "maximum shear in the wheel": 0.03,
}
"""Maximum relative change by one more halving of the elements in contact."""

FO2_NOTE = "reference: FO2"


def patch_forces(result: WheelsetResult) -> dict[str, float]:
    """Force on the wheel in N by side and region."""
    forces: dict[str, float] = {}
    for patch in result.patches:
        name = contact_name(result, patch)
        forces[name] = forces.get(name, 0.0) + np.hypot(*patch.force_on_wheel_N)
    return forces


def rows(run: Run) -> Iterator[Row]:
    """Rows of Tables 15 and 16 from a cold start, other crowns, the rigid limit, refinement, and one arc on one arc.

    The rows are of the published kind: node-to-segment with a penalty per node, one mesh for both orders. The others
    are segment-to-segment on flangeway's usual mesh, with the same wheel. If quick, the flange root is not identified
    again, and there are fewer roots, two values of Young's modulus, one refinement, and no other crowns.
    """
    results: Results = {}
    for situation, code in itertools.product(TABLES, CODES):
        run.progress(f"{situation}, {code}")
        results[situation, code] = run_published(situation, code)
        run.check(f"{situation} {code}", results[situation, code].status)
    yield from table_rows(results)
    yield from coarse_rows(run)
    yield from root_rows(run, results)
    yield from _agreement(results)
    yield from _regions(run, results["curve", "FO2"])
    curve = identified("curve")
    yield from _rigid_limit(run, curve)
    yield from _refined(run, curve)
    yield from one_arc_rows(run)


def _agreement(results: Results) -> Iterator[Row]:
    """Each row against FO2 of its situation."""
    for (situation, code), result in results.items():
        if code not in AGREEMENT:
            continue
        reference, name = results[situation, "FO2"], f"{situation} {code}"
        expected, forces = patch_forces(reference), patch_forces(result)
        limit, lateral_offset = AGREEMENT[code]
        for contact in sorted(expected.keys() | forces.keys()):
            wanted, value = expected.get(contact, math.nan) / 1e3, forces.get(contact, 0.0) / 1e3
            yield Row("agreement", name, f"force, {contact}", "kN", value, wanted, limit, FO2_NOTE)
        if situation == "curve":  # on tangent track it is zero, as is compared with the published
            wanted, value = reference.position_in_space.lateral_mm, result.position_in_space.lateral_mm
            near = f"{lateral_offset:g} mm"
            yield Row("agreement", name, "lateral displacement", "mm", value, wanted, near, FO2_NOTE)


def _regions(run: Run, finite: WheelsetResult) -> Iterator[Row]:
    crowns = {10.0: finite}
    for crown in () if run.quick else (8.0, 14.0):
        run.progress(f"crown radius {crown:g} in")
        case = identified("curve").replaced(track={"rail": f"136RE-{crown:g}"}, mesh={"order": 2})
        crowns[crown] = solve_wheelset(case, cold=True)
    for crown, result in crowns.items():
        regions = sorted(contact_name(result, patch) for patch in result.patches)
        code, order = "curve FO{}, crown {:g} in", result.model.problem.mesh.order
        limit = Limit("these three", regions == sorted(REGIONS) and result.status.converged)
        note = ", ".join(regions) + "; inner rail one contact, outer rail two"
        yield Row("regions", code.format(order, crown), "contacts", "", float(len(regions)), 3.0, limit, note)


def _rigid_limit(run: Run, curve: Wheelset) -> Iterator[Row]:
    names = ("lateral displacement", "vertical displacement", "roll x 750 mm")
    factors, differences = (10.0, 100.0) if run.quick else FACTORS, []
    for factor in factors:
        run.progress(f"Young's modulus times {factor:g}")
        result = solve_wheelset(curve.replaced(material={"young_MPa": factor * curve.material.young_MPa}), cold=True)
        run.check(f"Young's modulus x {factor:g}", result.status)
        apart, points = rigid_differences_mm(result)
        differences.append(apart)
        code, note = f"curve FO1, E x {factor:g}", "elastic minus rigid; the elastic displacement falls as 1/E"
        for name, value in zip(names, apart.tolist(), strict=True):
            yield Row("rigid limit", code, name, "mm", value, 0.0, None, note)
        limit = f"{RIGID_POINT_MM:g} mm" if factor >= REQUIRED_FACTOR else None
        yield Row("rigid limit", code, "contact points", "mm", points, 0.0, limit, "maximum distance on the rail")
    for at, name in enumerate(names):
        run.curve("rigid_limit", name, "elastic less rigid", factors, [abs(apart[at]) for apart in differences], "o-")
    share = factors[-1] / (factors[-1] - factors[-2])
    extrapolated = share * differences[-1] + (1.0 - share) * differences[-2]
    note = "elastic minus rigid, extrapolated from the last two as 1/E"
    for name, value in zip(names, extrapolated.tolist(), strict=True):
        yield Row("rigid limit", "curve FO1, E to infinity", name, "mm", value, 0.0, f"{RIGID_MM:g} mm", note)


def _refined(run: Run, curve: Wheelset) -> Iterator[Row]:
    before: Published = {}
    for divisor in (1, 2) if run.quick else DIVISORS:
        run.progress(f"element size in contact over {divisor}")
        case = curve.replaced(contact={"contact_size_mm": curve.plane.contact_size_mm / divisor})
        result = solve_wheelset(case, cold=True)
        run.check(f"element size / {divisor}", result.status)
        numbers = contact_quantities(result)
        for (name, quantity), value in numbers.items() if before else ():
            unit, code = "N" if quantity == "force" else "MPa", f"curve, size over {divisor}"
            wanted, note = before.get((name, quantity), math.nan), "reference: the coarser mesh"
            yield Row("refinement", code, f"{quantity}, {name}", unit, value, wanted, REFINED[quantity], note)
        before = numbers
