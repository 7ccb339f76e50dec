"""The published wheelset (chapter 7, Tables 15 and 16) on tangent track and in a curve, computed again from cold.

One number of the tables, the lateral translation of VO2 in the curve, identifies the flange root of the wheel; the
other positions are predicted. Beside them there must hold the equilibrium, the agreement of the methods, where the
rails are touched, the rigid limit, and that a finer mesh in contact changes little.
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
from flangeway.validation.published_numbers import ReproducedNumber, percent
from flangeway.validation.wheel_rail.contact_refinement import DIVISORS, RefinedContact, contact_name, refine_contact
from flangeway.validation.wheel_rail.one_arc import OneArcContact, approach_curvature, one_arc_contacts
from flangeway.validation.wheel_rail.rigid_limit import (
    FACTORS,
    StiffenedWheelset,
    extrapolated_differences_mm,
    rigid_limit,
)
from flangeway.validation.wheel_rail.wheel_rail_tables import (
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
"""Largest relative difference of a patch's force, and of the lateral motion in mm, from FO2."""
REGIONS = ("left tread", "right flange root", "right tread")
"""Contacts of the curve: one on the inner rail, tread and flange root on the outer one."""
RIGID_MM, RIGID_POINT_MM = 0.01, 0.5
"""Maximum distance of the position, extrapolated to rigid bodies, and of the contact points from the rigid ones."""
REQUIRED_FACTOR = 100.0
"""Factor on Young's modulus from which the contact points must be the rigid ones."""
ONE_ARC = 0.01
"""Largest relative difference of one arc on one arc from Hertz's theory."""
ONE_ARC_MESH = Discretisation(order=2, contact_size_mm=0.1, body_size_mm=4.0, enforcement="multiplier")
REFINED = {
    "force": 0.005,
    "maximum pressure": 0.03,
    "maximum shear in the rail": 0.03,
    "maximum shear in the wheel": 0.03,
}
"""Largest relative change by one more halving of the elements in contact."""

FO2_NOTE = "computed with FO2 in place of published"


@dataclass(frozen=True, eq=False)
class WheelRailReproduction:
    """Tables 15 and 16 computed again.

    Parameters
    ----------
    rows
        The eight rows.
    members
        Flange roots of two families, and where the wheelset of the curve stands with them.
    limit
        The curve with raised Young's modulus.
    refined
        The curve with finer meshes in contact.
    one_arc
        A wheel of one arc on a rail of one arc under two loads.
    numbers
        Published, or required, and computed numbers side by side.
    seconds
        Wall-clock time.

    """

    rows: tuple[WheelRailRow, ...]
    members: tuple[RootMember, ...]
    limit: tuple[StiffenedWheelset, ...]
    refined: tuple[RefinedContact, ...]
    one_arc: tuple[OneArcContact, ...]
    numbers: tuple[ReproducedNumber, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether all converged and all that has a limit is within."""
        results = [row.result for row in self.rows] + [each.result for each in self.limit]
        results += [each.result for each in self.refined] + [each.result for each in self.one_arc]
        return all(result.status.converged for result in results) and all(
            number.within for number in self.numbers if number.required
        )


def n_predicted(found: WheelRailReproduction) -> int:
    """How many numbers of the tables are predicted, with a limit."""
    return sum(number.note.startswith("predicted") for number in found.numbers)


def patch_forces(result: WheelsetResult) -> dict[str, float]:
    """Force on the wheel in N by side and region."""
    forces: dict[str, float] = {}
    for patch in result.patches:
        name = contact_name(result, patch)
        forces[name] = forces.get(name, 0.0) + float(np.hypot(*patch.force_on_wheel_N))
    return forces


def reproduce_wheel_rail(*, quick: bool = False, progress: Progress = lambda _: None) -> WheelRailReproduction:
    """Compute Tables 15 and 16 from a cold start, other crowns, the rigid limit, refinement, and one arc on one arc.

    The rows are of the published kind: node-to-segment with a penalty per node, one mesh for both orders. What follows
    is segment-to-segment on flangeway's usual mesh, with the same wheel.

    Parameters
    ----------
    quick
        The flange root is not searched for again; fewer roots beside it, two values of Young's modulus, one
        refinement, no other crowns.
    progress
        Called with a sentence at each stage.

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
        crowns[crown] = case.run(cold=True).result
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
    return WheelRailReproduction(tuple(rows), members, limit, refined, one_arc, numbers, time.perf_counter() - start)


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
            one, other = expected.get(name, 0.0) / 1e3, forces.get(name, 0.0) / 1e3
            difference = other / one - 1.0 if one else float("inf")
            within = abs(difference) <= limit
            yield ReproducedNumber(
                "agreement", code, f"force, {name}", "kN", one, other, difference, percent(limit), within, FO2_NOTE
            )
        if row.situation == "tangent":
            continue  # zero, as is compared with the published
        lateral, moved = reference.position_in_space.lateral_mm, row.motion.lateral_mm
        within, words = bool(abs(moved - lateral) <= lateral_offset), f"{lateral_offset:g} mm"
        difference = moved / lateral - 1.0
        yield ReproducedNumber(
            "agreement", code, "lateral motion", "mm", lateral, moved, difference, words, within, FO2_NOTE
        )


def _limit(limit: tuple[StiffenedWheelset, ...]) -> Iterator[ReproducedNumber]:
    names = ("lateral motion", "vertical motion", "roll x 750 mm")
    for each in limit:
        code = f"curve FO1, E x {each.factor:g}"
        for name, value in zip(names, each.position_differences_mm.tolist(), strict=True):
            note = "elastic less rigid, of which the elastic motion is left, which falls as 1/E"
            within = abs(value) <= RIGID_MM
            yield ReproducedNumber("rigid limit", code, name, "mm", 0.0, value, value, "", within, note)
        value, note = float(each.point_distances_mm.max()), "maximum distance on the rail"
        words = f"{RIGID_POINT_MM:g} mm" if each.factor >= REQUIRED_FACTOR else ""
        within = value <= RIGID_POINT_MM
        yield ReproducedNumber("rigid limit", code, "contact points", "mm", 0.0, value, value, words, within, note)
    for name, value in zip(names, extrapolated_differences_mm(limit).tolist(), strict=True):
        note, code = "elastic less rigid, extrapolated from the last two as 1/E", "curve FO1, E to infinity"
        words, within = f"{RIGID_MM:g} mm", abs(value) <= RIGID_MM
        yield ReproducedNumber("rigid limit", code, name, "mm", 0.0, value, value, words, within, note)


def _refined(refined: tuple[RefinedContact, ...]) -> Iterator[ReproducedNumber]:
    for coarse, fine in itertools.pairwise(refined):
        before, after = coarse.quantities, fine.quantities
        for (name, quantity), value in after.items():
            old = before.get((name, quantity), float("nan"))
            change = value / old - 1.0
            limit, unit = REFINED[quantity], "N" if quantity == "force" else "MPa"
            yield ReproducedNumber(
                "refinement", f"curve, size over {fine.divisor}", f"{quantity}, {name}", unit, old, value, change,
                percent(limit), bool(abs(change) <= limit), "coarser mesh in place of published",
            )  # fmt: skip


def _regions(results: dict[float, WheelsetResult]) -> Iterator[ReproducedNumber]:
    for crown, result in results.items():
        regions = sorted(contact_name(result, patch) for patch in result.patches)
        order = result.model.problem.discretisation.order
        n_found, code = float(len(regions)), f"curve FO{order}, crown {crown:g} in"
        within = regions == sorted(REGIONS) and result.status.converged
        note = ", ".join(regions) + "; inner rail one contact, outer rail two"
        change = n_found / 3.0 - 1.0
        yield ReproducedNumber("regions", code, "contacts", "", 3.0, n_found, change, "these three", within, note)


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
        difference = computed / theory - 1.0
        yield ReproducedNumber(
            "Hertz", "one arc on one arc", quantity, unit, theory, computed, difference, percent(ONE_ARC),
            abs(difference) <= ONE_ARC, "Hertz's line contact in place of published",
        )  # fmt: skip


@dataclass(frozen=True)
class WheelRailPatchRow:
    """A row of ``patches.csv``: one contact of one row of the tables.

    Parameters
    ----------
    situation, code
        As `WheelRailRow`.
    contact, region
        Side and part of the wheel, and part of the rail.
    angle_deg
        Angle of the force from the track's vertical, in degrees.
    force_kN, max_pressure_MPa, half_width_mm
        Its force, maximum pressure and half width.
    rail_x_mm, rail_y_mm, wheel_x_mm, wheel_y_mm
        Centre of pressure in the frames of the profiles.
    max_shear_rail_MPa, shear_depth_mm
        Maximum in-plane shear stress in the rail below it, and its depth.

    """

    situation: str
    code: str
    contact: str
    region: str
    angle_deg: float
    force_kN: float  # noqa: N815 (units)
    max_pressure_MPa: float  # noqa: N815
    half_width_mm: float
    rail_x_mm: float
    rail_y_mm: float
    wheel_x_mm: float
    wheel_y_mm: float
    max_shear_rail_MPa: float  # noqa: N815
    shear_depth_mm: float


def patch_rows(rows: tuple[WheelRailRow, ...]) -> list[WheelRailPatchRow]:
    """Contacts of all rows."""
    found = []
    for row in rows:
        for patch in row.result.patches:
            shear = maximum_shear(row.result, patch, "rail")
            lateral, vertical = patch.force_on_wheel_N.tolist()
            (rail_x, rail_y), (wheel_x, wheel_y) = patch.rail_point_mm.tolist(), patch.wheel_point_mm.tolist()
            found.append(
                WheelRailPatchRow(
                    row.situation,
                    row.code,
                    contact_name(row.result, patch),
                    patch.region,
                    math.degrees(math.atan2(abs(lateral), vertical)),
                    float(np.hypot(*patch.force_on_wheel_N)) / 1e3,
                    float(patch.pressure.pressures.max()),
                    patch.pressure.half_width,
                    rail_x,
                    rail_y,
                    wheel_x,
                    wheel_y,
                    shear.value_MPa,
                    shear.depth_mm,
                )
            )
    return found
