"""Node-to-node contact of polygons with inserted nodes, beside other pairings of the same elements.

The contact patch test and Hertz's problem on the meshes of Moherdaui (2021, 6.2), each with elements that differ in
nothing but the pairing: nodes against segments, averages over segments, and nodes against inserted nodes.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToNode, Surface, press
from flangeway.contact.bodies_model import build_bodies
from flangeway.mesh import insert_nodes, match_boundaries
from flangeway.problems import Body, Part
from flangeway_studies.contact_patch import LAWS, ROTATION_DEG, patch_test
from flangeway_studies.hertz import SLACK, largest_patch, published_case, rms_from_hertz
from flangeway_studies.study import Row, Run

CODES = ("VVO1", "VVO2", "VDO2", "FDO2")
"""Polygons of order 1 and 2; triangles with virtual and with finite elements of order 2, those with inserted nodes
virtual in either case."""
PAIRINGS = ("node-to-segment", "segment-to-segment", "node-to-node")
RATIOS = (1e-2, 1e-4, 1e-6)  # lengths of short edges over those beside them
LEVELS, SHORT_LEVEL = (1, 2, 3), 2
PATCH_LIMIT = 1e-9  # of relative deviations from the uniform pressure and stress
PEAK_LIMITS = {"1": 0.05, "2": 0.005}  # relative difference of the maximum pressure, by order
RMS_LIMITS = {"1": 0.04, "2": 0.005}  # root mean square difference from Hertz's pressure over its maximum
SAME_FORCE, SAME_ERROR = 1e-4, 0.3
"""Relative change of the force and of the root mean square difference by short edges."""


def hertz_case(code: str, level: int, pairing: str) -> HertzCase:
    """The published discs with multipliers between the circles, in one step."""
    given = published_case(code, level, "segments")
    values: dict[str, Any] = {**given.written, "n_steps": 1}
    if pairing != "segment-to-segment":
        values["pairing"] = {"kind": pairing, **({"slack": SLACK} if pairing == "node-to-segment" else {})}
    return HertzCase.from_values(values)


def measured(case: HertzCase, solution: ContactSolution) -> tuple[float, float, float]:
    """Force, maximum pressure over Hertz's, and `rms_from_hertz` weighted by areas, without an element at both ends."""
    force = solution.forces[0, 1]
    theory, (x, patch) = case.theory(force), largest_patch(solution)
    within, areas = theory.half_width - case.size_mm, patch.normal_forces / patch.pressures
    rms = rms_from_hertz(x, patch.pressures, theory, within, areas)
    return force, patch.pressures.max() / theory.max_pressure, rms


def with_short_edges(code: str, level: int, ratio: float) -> tuple[HertzCase, ContactSolution]:
    """Node-to-node, with nodes beside the starts of the upper disc's edges that may touch, by a part of each edge."""
    case = hertz_case(code, level, "segment-to-segment")
    model = build_bodies(case.general())
    (contact,) = model.contacts
    sides = (contact.secondary, contact.primary)
    bodies = [side.part.body for side in sides if isinstance(side.part.body, Body)]
    meshes = [body.mesh.with_edge_set("touching", side.edges) for body, side in zip(bodies, sides, strict=True)]
    ends = meshes[0].points[sides[0].edges]
    meshes[0] = insert_nodes(meshes[0], "touching", (1.0 - ratio) * ends[:, 0] + ratio * ends[:, 1])
    meshes = list(match_boundaries(meshes[0], "touching", meshes[1], "touching"))
    surfaces = []
    for side, body, mesh in zip(sides, bodies, meshes, strict=True):
        part = Part(side.part.name, replace(body, mesh=mesh), side.part.placement)
        surfaces.append(Surface(part, mesh.edge_sets["touching"], side.curve))
    motion = {surfaces[0].part: model.motion[sides[0].part]}
    return case, press([Contact(surfaces[0], surfaces[1], NodeToNode(), Multiplier())], motion)


def rows(run: Run) -> Iterator[Row]:
    """Patch tests, and Hertz's problem by three pairings and with short edges."""
    for elements in ("VEM1", "VEM2"):
        for level, turn, laws in ((1, 0.0, tuple(LAWS)), (1, ROTATION_DEG, tuple(LAWS)), (2, 0.0, ("multiplier",))):
            for law in laws:
                code = f"{elements}M{level}{' rotated' if turn else ''}, {law}"
                changed = {**LAWS[law], "pairing": PAIRINGS[2], "rotation_deg": turn}
                test = patch_test((elements, elements), level, changed)
                run.check(code, test.solution.status)
                for quantity, value in (("pressure", test.pressure_error), ("stress", test.stress_error)):
                    name = f"contact patch test: deviation of the {quantity}"
                    yield Row("Figure 64", code, name, "1", value, 0.0, PATCH_LIMIT)
    plain = {}
    for code in CODES:
        for level in LEVELS:
            rms = {}
            for pairing in PAIRINGS:
                name = f"{code}M{level}"
                case = hertz_case(code, level, pairing)
                solution = case.run().contact
                assert solution is not None
                run.check(f"{name}, {pairing}", solution.status)
                force, peak, rms[pairing] = measured(case, solution)
                required = pairing == PAIRINGS[2] and level > 1
                peak_limit, rms_limit = PEAK_LIMITS[code[3]], RMS_LIMITS[code[3]]
                quantity = f"maximum pressure over Hertz's, {pairing}"
                yield Row("Hertz", name, quantity, "1", peak, 1.0, peak_limit if required else None)
                quantity = f"root mean square difference from Hertz's pressure, {pairing}"
                yield Row("Hertz", name, quantity, "over p0", rms[pairing], 0.0, rms_limit if required else None)
                if level == SHORT_LEVEL and code[:2] == "VV":
                    plain[code] = force, rms[pairing]
                    x, patch = largest_patch(solution)
                    run.curve("pressures", f"polygons of order {code[3]}", pairing, x, patch.pressures, "o")
                    if pairing == PAIRINGS[2]:
                        theory = case.theory(force)
                        run.curve("pressures", f"polygons of order {code[3]}", "Hertz", *theory.curve)
            sentence = (
                f"{name}: the error of the pressure is {rms[PAIRINGS[2]]:.2g} node-to-node, {rms[PAIRINGS[0]]:.2g} "
            )
            run.require(rms[PAIRINGS[2]] < rms[PAIRINGS[0]], f"{sentence}node-to-segment")
    for code, (plain_force, plain_rms) in plain.items():
        for ratio in RATIOS:
            name = f"{code}M{SHORT_LEVEL}, edges of {ratio:g}"
            case, solution = with_short_edges(code, SHORT_LEVEL, ratio)
            run.check(name, solution.status)
            force, _, rms_short = measured(case, solution)
            quantity = "force over that without short edges"
            yield Row("Hertz", name, quantity, "1", force / plain_force, 1.0, SAME_FORCE)
            quantity = "error of the pressure over that without short edges"
            yield Row("Hertz", name, quantity, "1", rms_short / plain_rms, 1.0, SAME_ERROR)
