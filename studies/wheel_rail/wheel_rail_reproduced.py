"""The published wheelset (chapter 7, Tables 15 and 16) on tangent track and in a curve, computed again from cold.

One number of the tables, the lateral translation of VO2 in the curve, identifies the flange root of the wheel; the
other positions are predicted. Checked as well: equilibrium, agreement of the methods, contact regions, the rigid limit,
and refinement in contact.
"""

import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.wheelset_case import WheelsetCurveCase
from flangeway.materials import Elastic
from flangeway.railway.profiles.flange_root import IDENTIFIED
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare
from studies.wheel_rail.variations import (
    DIVISORS,
    FACTORS,
    OneArcContact,
    RefinedContact,
    StiffenedWheelset,
    approach_curvature,
    contact_name,
    extrapolated_differences_mm,
    one_arc_contacts,
    refine_contact,
    rigid_limit,
)
from studies.wheel_rail.wheel_rail_tables import (
    CASES,
    CODES,
    FITTED_CODE,
    RootMember,
    WheelRailRow,
    coarse_numbers,
    identified_radius,
    root_members,
    root_numbers,
    run_published,
    table_numbers,
)

AGREEMENT = {"VO2": (0.01, 0.05), "FO1": (0.04, 0.5), "VO1": (0.04, 0.5)}
"""Maximum relative difference of a patch's force, and difference of the lateral displacement in mm, from FO2."""
REGIONS = ("left tread", "right flange root", "right tread")
"""Contacts of the curve: one on the inner rail, tread and flange root on the outer one."""
RIGID_MM, RIGID_POINT_MM = 0.01, 0.5
"""Maximum distance of the position, extrapolated to rigid bodies, and of the contact points from the rigid ones."""
REQUIRED_FACTOR = 100.0  # factor on Young's modulus from which the contact points must be the rigid ones
ONE_ARC = 0.01  # maximum relative difference of one arc on one arc from Hertz's theory
ONE_ARC_MESH = Discretisation(order=2, contact_size_mm=0.1, body_size_mm=4.0, enforcement="multiplier")
REFINED = {
    "force": 0.005,
    "maximum pressure": 0.03,
    "maximum shear in the rail": 0.03,
    "maximum shear in the wheel": 0.03,
}
"""Maximum relative change by one more halving of the elements in contact."""

FO2_NOTE = "reference: FO2"


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelRailReproduction(Reproduced):
    """Tables 15 and 16 computed again."""

    rows: tuple[WheelRailRow, ...]  # the eight rows
    members: tuple[RootMember, ...]
    """Flange roots of two families, and the position of the wheelset of the curve with them."""
    limit: tuple[StiffenedWheelset, ...]  # the curve with raised Young's modulus
    refined: tuple[RefinedContact, ...]  # the curve with finer meshes in contact
    one_arc: tuple[OneArcContact, ...]  # a wheel of one arc on a rail of one arc under two loads

    @property
    def failures(self) -> tuple[str, ...]:
        """Solutions that did not converge."""
        named = [(f"{row.situation} {row.code}", row.result) for row in self.rows]
        named += [(f"Young's modulus x {each.factor:g}", each.result) for each in self.limit]
        named += [(f"element size / {each.divisor}", each.result) for each in self.refined]
        named += [(f"one arc on one arc, {each.load_N:g} N", each.result) for each in self.one_arc]
        return tuple(f"{name}: {result.status.message}" for name, result in named if not result.status.converged)


def patch_forces(result: WheelsetResult) -> dict[str, float]:
    """Force on the wheel in N by side and region."""
    forces: dict[str, float] = {}
    for patch in result.patches:
        name = contact_name(result, patch)
        forces[name] = forces.get(name, 0.0) + float(np.hypot(*patch.force_on_wheel_N))
    return forces


def reproduce_wheel_rail(*, quick: bool = False, progress: Progress = lambda _: None) -> WheelRailReproduction:
    """Compute Tables 15 and 16 from a cold start, other crowns, the rigid limit, refinement, and one arc on one arc.

    The rows are of the published kind: node-to-segment with a penalty per node, one mesh for both orders. The others
    are segment-to-segment on flangeway's usual mesh, with the same wheel. If `quick`, the flange root is not identified
    again, and there are fewer roots, two values of Young's modulus, one refinement, and no other crowns.
    """
    start = time.perf_counter()
    rows = []
    for situation, code in itertools.product(CASES, CODES):
        progress(f"{situation}, {code}")
        rows.append(WheelRailRow(situation, code, run_published(situation, code)))
    fitted, finite = (
        next(row for row in rows if (row.situation, row.code) == ("curve", code)) for code in (FITTED_CODE, "FO2")
    )
    radius = None if quick else identified_radius(fitted.motion.lateral_mm, progress)
    members = root_members(rows, progress, quick=quick)
    crowns = {10.0: finite.result}
    for crown in () if quick else (8.0, 14.0):
        progress(f"crown radius {crown:g} in")
        case = WheelsetCurveCase.from_values({"crown_radius_in": crown, "order": 2, "wheel": IDENTIFIED})
        crowns[crown] = case.run(cold=True).plane
    curve = WheelsetCurveCase.from_values({"wheel": IDENTIFIED})
    limit = tuple(rigid_limit(curve, (10.0, 100.0) if quick else FACTORS, progress))
    refined = tuple(refine_contact(curve, (1, 2) if quick else DIVISORS, progress))
    progress("one arc on one arc")
    one_arc = one_arc_contacts(ONE_ARC_MESH, Elastic(curve.young_MPa, curve.poisson))
    numbers = (
        *table_numbers(rows),
        *coarse_numbers(progress, quick=quick),
        *root_numbers(members, radius),
        *_agreement(rows),
        *_regions(crowns),
        *_limit(limit),
        *_refined(refined),
        *_one_arc(one_arc),
    )
    return WheelRailReproduction(
        rows=tuple(rows), members=members, limit=limit, refined=refined, one_arc=one_arc, numbers=numbers,
        seconds=time.perf_counter() - start,
    )  # fmt: skip


def _agreement(rows: list[WheelRailRow]) -> Iterator[ReproducedNumber]:
    """Each row against FO2 of its situation."""
    for row in rows:
        if row.code not in AGREEMENT:
            continue
        reference = next(each.result for each in rows if each.situation == row.situation and each.code == "FO2")
        expected, forces = patch_forces(reference), patch_forces(row.result)
        limit, lateral_offset = AGREEMENT[row.code]
        code = f"{row.situation} {row.code}"
        for name in sorted(expected.keys() | forces.keys()):
            values = expected.get(name, 0.0) / 1e3, forces.get(name, 0.0) / 1e3
            within = None if values[0] else False
            yield compare("agreement", code, f"force, {name}", "kN", values, limit, FO2_NOTE, within=within)
        if row.situation == "tangent":
            continue  # zero, as is compared with the published
        lateral, moved = reference.position_in_space.lateral_mm, row.motion.lateral_mm
        yield compare(
            "agreement", code, "lateral displacement", "mm", (lateral, moved), lateral_offset, FO2_NOTE,
            words=f"{lateral_offset:g} mm", within=abs(moved - lateral) <= lateral_offset,
        )  # fmt: skip


def _limit(limit: tuple[StiffenedWheelset, ...]) -> Iterator[ReproducedNumber]:
    names = ("lateral displacement", "vertical displacement", "roll x 750 mm")
    for each in limit:
        code = f"curve FO1, E x {each.factor:g}"
        note = "elastic minus rigid; the elastic displacement remains, which falls as 1/E"
        for name, value in zip(names, each.position_differences_mm.tolist(), strict=True):
            yield compare("rigid limit", code, name, "mm", (0.0, value), RIGID_MM, note, words="")
        words = f"{RIGID_POINT_MM:g} mm" if each.factor >= REQUIRED_FACTOR else ""
        values, note = (0.0, each.point_distances_mm.max()), "maximum distance on the rail"
        yield compare("rigid limit", code, "contact points", "mm", values, RIGID_POINT_MM, note, words=words)
    note, words = "elastic minus rigid, extrapolated from the last two as 1/E", f"{RIGID_MM:g} mm"
    for name, value in zip(names, extrapolated_differences_mm(limit).tolist(), strict=True):
        values = (0.0, value)
        yield compare("rigid limit", "curve FO1, E to infinity", name, "mm", values, RIGID_MM, note, words=words)


def _refined(refined: tuple[RefinedContact, ...]) -> Iterator[ReproducedNumber]:
    for coarse, fine in itertools.pairwise(refined):
        before = coarse.quantities
        for (name, quantity), value in fine.quantities.items():
            values, unit = (before.get((name, quantity), math.nan), value), "N" if quantity == "force" else "MPa"
            yield compare(
                "refinement", f"curve, size over {fine.divisor}", f"{quantity}, {name}", unit, values,
                REFINED[quantity], "reference: the coarser mesh",
            )  # fmt: skip


def _regions(results: dict[float, WheelsetResult]) -> Iterator[ReproducedNumber]:
    for crown, result in results.items():
        regions = sorted(contact_name(result, patch) for patch in result.patches)
        order = result.model.problem.discretisation.order
        code, values = f"curve FO{order}, crown {crown:g} in", (3.0, float(len(regions)))
        within = regions == sorted(REGIONS) and result.status.converged
        note = ", ".join(regions) + "; inner rail one contact, outer rail two"
        yield compare("regions", code, "contacts", "", values, 0.0, note, words="these three", within=within)


def _one_arc(contacts: tuple[OneArcContact, ...]) -> Iterator[ReproducedNumber]:
    """Pressure, half width and approach against Hertz."""
    last = contacts[-1]
    bend, exact = approach_curvature(contacts)
    quantities = (
        ("maximum pressure", "MPa", last.theory.max_pressure, last.pressure_MPa),
        ("half width", "mm", last.theory.half_width, last.half_width_mm),
        ("approach under twice the load less twice the approach", "mm", exact, bend),
    )
    for quantity, unit, theory, computed in quantities:
        note = "reference: Hertz's line contact"
        yield compare("Hertz", "one arc on one arc", quantity, unit, (theory, computed), ONE_ARC, note)


def patch_rows(found: WheelRailReproduction) -> list[Row]:
    """Rows of ``patches.csv``: one contact of one row of the tables; angles of the force from the track's vertical."""
    rows: list[Row] = []
    for row, patch in ((each, patch) for each in found.rows for patch in each.result.patches):
        shear = maximum_shear(row.result, patch, "rail")
        lateral, vertical = patch.force_on_wheel_N.tolist()
        (rail_x, rail_y), (wheel_x, wheel_y) = patch.rail_point_mm.tolist(), patch.wheel_point_mm.tolist()
        rows.append(
            {
                "situation": row.situation,
                "code": row.code,
                "contact": contact_name(row.result, patch),
                "region": patch.region,
                "angle_deg": math.degrees(math.atan2(abs(lateral), vertical)),
                "force_kN": float(np.hypot(*patch.force_on_wheel_N)) / 1e3,
                "max_pressure_MPa": float(patch.pressure.pressures.max()),
                "half_width_mm": patch.pressure.half_width,
                "rail_x_mm": rail_x,
                "rail_y_mm": rail_y,
                "wheel_x_mm": wheel_x,
                "wheel_y_mm": wheel_y,
                "max_shear_rail_MPa": shear.value_MPa,
                "shear_depth_mm": shear.depth_mm,
            }
        )
    return rows
