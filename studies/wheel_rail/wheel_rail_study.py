"""The published wheelset (chapter 7, Tables 15 and 16) on tangent track and in a curve, computed again from cold.

One number of the tables, the lateral translation of VO2 in the curve, identifies the flange root of the wheel; the
other positions are predicted. Checked as well: equilibrium, agreement of the methods, contact regions, the rigid limit,
and refinement in contact.
"""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCurveCase
from flangeway.materials import Elastic
from flangeway.railway.profiles.flange_root import IDENTIFIED
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from studies.study import Limit, Published, Row, Run
from studies.wheel_rail.variations import (
    DIVISORS,
    FACTORS,
    contact_name,
    contact_quantities,
    one_arc_rows,
    rigid_differences_mm,
    solve_varied,
)
from studies.wheel_rail.wheel_rail_tables import (
    CASES,
    CODES,
    Results,
    coarse_rows,
    root_rows,
    run_published,
    table_rows,
)

AGREEMENT = {"VO2": (0.01, 0.05), "FO1": (0.04, 0.5), "VO1": (0.04, 0.5)}
"""Maximum relative difference of a patch's force, and difference of the lateral displacement in mm, from FO2."""
REGIONS = ("left tread", "right flange root", "right tread")
"""Contacts of the curve: one on the inner rail, tread and flange root on the outer one."""
RIGID_MM, RIGID_POINT_MM = 0.01, 0.5
"""Maximum distance of the position, extrapolated to rigid bodies, and of the contact points from the rigid ones."""
REQUIRED_FACTOR = 100.0  # factor on Young's modulus from which the contact points must be the rigid ones
ONE_ARC_MESH = Discretisation(order=2, contact_size_mm=0.1, body_size_mm=4.0, enforcement="multiplier")
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
    for situation, code in itertools.product(CASES, CODES):
        run.progress(f"{situation}, {code}")
        results[situation, code] = run_published(situation, code)
        run.check(f"{situation} {code}", results[situation, code].status)
    yield from table_rows(results)
    yield from coarse_rows(run)
    yield from root_rows(run, results)
    yield from _agreement(results)
    yield from _regions(run, results["curve", "FO2"])
    curve = WheelsetCurveCase.from_values({"wheel": IDENTIFIED})
    yield from _rigid_limit(run, curve)
    yield from _refined(run, curve)
    yield from one_arc_rows(run, ONE_ARC_MESH, Elastic(curve.young_MPa, curve.poisson))


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
        case = WheelsetCurveCase.from_values({"crown_radius_in": crown, "order": 2, "wheel": IDENTIFIED})
        crowns[crown] = case.run(cold=True).plane
    for crown, result in crowns.items():
        regions = sorted(contact_name(result, patch) for patch in result.patches)
        code, order = "curve FO{}, crown {:g} in", result.model.problem.discretisation.order
        limit = Limit("these three", regions == sorted(REGIONS) and result.status.converged)
        note = ", ".join(regions) + "; inner rail one contact, outer rail two"
        yield Row("regions", code.format(order, crown), "contacts", "", float(len(regions)), 3.0, limit, note)


def _rigid_limit(run: Run, curve: WheelsetCurveCase) -> Iterator[Row]:
    names = ("lateral displacement", "vertical displacement", "roll x 750 mm")
    factors, differences = (10.0, 100.0) if run.quick else FACTORS, []
    for factor in factors:
        run.progress(f"Young's modulus times {factor:g}")
        result = solve_varied(curve, {"young_MPa": factor * curve.young_MPa})
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


def _refined(run: Run, curve: WheelsetCurveCase) -> Iterator[Row]:
    before: Published = {}
    for divisor in (1, 2) if run.quick else DIVISORS:
        run.progress(f"element size in contact over {divisor}")
        result = solve_varied(curve, {"contact_size_mm": curve.contact_size_mm / divisor})
        run.check(f"element size / {divisor}", result.status)
        found = contact_quantities(result)
        for (name, quantity), value in found.items() if before else ():
            unit, code = "N" if quantity == "force" else "MPa", f"curve, size over {divisor}"
            wanted, note = before.get((name, quantity), math.nan), "reference: the coarser mesh"
            yield Row("refinement", code, f"{quantity}, {name}", unit, value, wanted, REFINED[quantity], note)
        before = found
