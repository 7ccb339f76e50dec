"""The contact patch test (Moherdaui 2021, 6.2.1, Figures 64 and 70 to 75): a uniform pressure between two boxes.

The source gives one number, the uniform stress of (6.1). It shows the errors of its node-to-segment results in pictures
and in words: never exact, larger for triangles than for polygons, smaller on finer meshes. The boxes' height of 1
follows from (6.1); width, numbers of edges and the laterally held points are assumptions.

Everything may be rotated, the interface with it. An interface inclined to the load is no test of contact without
friction: the uniform state has a shear stress on it.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.cases import TwoBodiesCase
from flangeway.contact import ContactSolution
from flangeway.materials import Elastic
from flangeway.post import corner_stresses
from flangeway_studies.hertz import largest_patch
from flangeway_studies.study import Limit, Row, Run

PUBLISHED = -1125.0  # uniform vertical stress of (6.1) in kN/cm^2
WIDTH, HEIGHT, APPROACH = 2.0, 1.0, 0.1
STEEL = Elastic(20e3, 1.0 / 3.0)  # units are cm, kN and kN/cm^2, where the keys of the case have mm, N and MPa
PENALTY = 1e6  # published penalty in kN/cm at each secondary node; read as kN/cm^3 where it is per length
N_EDGES = {1: (9, 7), 2: (17, 13), 3: (33, 25)}
"""Triangles' edges along the upper and the lower box by refinement: no multiple of each other."""
ROTATION_DEG = 30.0
UNIFORM = 1e-8  # maximum relative deviation of pressures and stresses from the uniform state that passes the test
MIN_ERROR, MAX_ERROR = 1e-3, 0.5
"""Relative deviations of the stress between which node-to-segment contact fails the test as published."""
MEAN_LIMIT = 0.01  # of the mean stress by node-to-segment contact
LAWS: Mapping[str, Mapping[str, Any]] = {
    "penalty": {"enforcement": {"kind": "penalty", "penalty_MPa_mm": PENALTY}},
    "augmented": {
        "enforcement": {
            "kind": "augmented-lagrange",
            "penalty_MPa_mm": PENALTY,
            "penetration_mm": 1e-11 * APPROACH,
        }
    },
    "multiplier": {"enforcement": "multiplier"},
}
NODAL_PENALTY = {
    "pairing": "node-to-segment",
    "enforcement": {"kind": "penalty", "nodal_penalty_N_per_mm": PENALTY},
}
ELEMENTS = {"T3": ("fem", 1), "T6": ("fem", 2), "VEM1": ("vem", 1), "VEM2": ("vem", 2)}
MIXED = (("T6", "VEM1"), ("VEM2", "T3"), ("T3", "T6"), ("VEM1", "VEM2"))
NAMES = {
    "T3": "triangles, order 1",
    "VEM1": "polygons, order 1",
    "T6": "triangles, order 2",
    "VEM2": "polygons, order 2",
}
NOTE = "not exact, as published; the published pictures give no numbers"


@dataclass(frozen=True, eq=False)
class PatchTest:
    """One computation of the contact patch test."""

    solution: ContactSolution
    stress_range: tuple[float, float]  # minimum and maximum vertical stress at the corners of the elements, unaveraged
    pressure_error: float  # maximum relative deviation of a node's pressure; 1 where a constraint carries none
    stress_error: float  # maximum deviation of a stress from the uniform state, over the expected pressure


def boxes(
    width_mm: float = WIDTH,
    height_mm: float = HEIGHT,
    approach_mm: float = APPROACH,
    rotation_deg: float = 0.0,
    *,
    of_boxes: Mapping[str, Mapping[str, Any]],
    contact: Mapping[str, Any],
) -> TwoBodiesCase:
    """Return two equal boxes that are pressed together and free to spread.

    - `approach_mm`: of their far sides.
    - `rotation_deg`: of everything, counter-clockwise.
    - `of_boxes`: material, elements and mesh of the upper, secondary box and of the lower one.
    - `contact`: pairing and enforcement.
    """
    bodies: list[dict[str, Any]] = []
    supports: list[dict[str, Any]] = []
    for name, sign, far in (("upper", 1.0, "top"), ("lower", -1.0, "bottom")):
        centre = (0.5 * width_mm, 0.5 * sign * height_mm)
        shape = {"rectangle": {"width_mm": width_mm, "height_mm": height_mm, "centre_mm": centre}}
        bodies.append({"name": name, **shape, **of_boxes[name]})
        supports.append({"body": name, "edges": far, "hold": "y"})
        supports.append({"body": name, "point_mm": (0.0, sign * height_mm), "hold": "x"})
    turn = math.radians(rotation_deg)
    shift = (approach_mm * math.sin(turn), -approach_mm * math.cos(turn))
    motions: list[dict[str, Any]] = [{"body": "upper", "shift_mm": shift, "rotation_deg": rotation_deg}]
    if rotation_deg:
        motions.append({"body": "lower", "rotation_deg": rotation_deg})
    sides = {"secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top"}
    return TwoBodiesCase.from_values(
        {"bodies": bodies, "supports": supports, "motions": motions, "contacts": [{**sides, **contact}]}
    )


def patch_test(sides: tuple[str, str], level: int, keys: Mapping[str, Any], *, matching: bool = False) -> PatchTest:
    """Press one box on the other.

    - `sides`: keys of `ELEMENTS` of the upper, secondary, and of the lower box.
    - `level`: refinement, a key of `N_EDGES`.
    - `keys`: pairing and enforcement of the contact, and ``rotation_deg`` of everything.
    - `matching`: whether both boxes have the same mesh, mirrored.
    """
    n_upper, n_lower = N_EDGES[level]
    of_boxes = {}
    for box, elements, n_edges in zip(
        ("upper", "lower"), sides, (n_upper, n_upper if matching else n_lower), strict=True
    ):
        method, order = ELEMENTS[elements]
        # slightly larger than an exact part of the width, so that round-off does not add an edge
        size = WIDTH / n_edges * (1.0 + 1e-6)
        material = {"young_MPa": STEEL.young, "poisson": STEEL.poisson}
        of_boxes[box] = {**material, "method": method, "order": order, "size_mm": size}
    contact = {key: value for key, value in keys.items() if key != "rotation_deg"}
    case = boxes(rotation_deg=keys.get("rotation_deg", 0.0), of_boxes=of_boxes, contact=contact)
    run, table = case.run(), case.contacts[0]
    assert run.contact is not None
    compliance = 2.0 * HEIGHT / STEEL.plane_modulus
    if table.enforcement.kind == "penalty" and table.pairing.kind != "node-to-segment":
        compliance += 1.0 / PENALTY
    expected = APPROACH / compliance
    fields = [run.bodies[name].field for name in ("upper", "lower")]
    stresses = np.vstack([corner_stresses(field.problem, field.displacements).components[:, :3] for field in fields])
    vertical, pressures = stresses[:, 1], largest_patch(run.contact)[1].pressures / expected
    pair = run.contact.system.contacts[0]
    incomplete = len(pressures) < len(pair.pairing.key_nodes(pair.secondary))
    return PatchTest(
        run.contact,
        (vertical.min(), vertical.max()),
        max(float(np.abs(pressures - 1.0).max()), float(incomplete)),
        np.abs(stresses - [0.0, -expected, 0.0]).max() / expected,
    )


def rows(run: Run) -> Iterator[Row]:
    """Node-to-segment contact with the published penalty, and the worst of all cases of segment-to-segment contact."""
    for order in (1, 2):
        for method, elements in (("F", f"T{3 * order}"), ("V", f"VEM{order}")):
            for level in N_EDGES:
                code = f"{method}PTM{level}O{order}"
                test = patch_test((elements, elements), level, NODAL_PENALTY)
                run.check(code, test.solution.status)
                mean, error = -test.solution.forces[0, 1] / WIDTH, test.stress_error
                yield Row(
                    "Equation 6.1", code, "mean stress_yy over the surface", "kN/cm^2", mean, PUBLISHED, MEAN_LIMIT
                )
                limit = Limit(
                    f"error of {100.0 * MIN_ERROR:g} % to {100.0 * MAX_ERROR:g} %", MIN_ERROR < error < MAX_ERROR
                )
                for name, value in zip(("minimum", "maximum"), test.stress_range, strict=True):
                    yield Row("Equation 6.1", code, f"{name} stress_yy", "kN/cm^2", value, PUBLISHED, limit, NOTE)
                x, patch = largest_patch(test.solution)
                run.curve("pressures", NAMES[elements], f"node-to-segment, M{level}", x, patch.pressures, ".-")
    worst, n_cases = np.zeros(2), 0
    for sides, level, matching, changed in _cases():
        for law, keys in LAWS.items():
            code = f"{sides[0]} on {sides[1]} M{level}{' matching' * matching}, {law}"
            test = patch_test(sides, level, {**keys, **changed}, matching=matching)
            run.check(code, test.solution.status)
            worst = np.maximum(worst, (test.pressure_error, test.stress_error))
            n_cases += 1
            if sides[0] == sides[1] and law == "multiplier" and not changed and not matching and level == max(N_EDGES):
                x, patch = largest_patch(test.solution)
                run.curve("pressures", NAMES[sides[0]], "segment-to-segment, multipliers", x, patch.pressures)
    for name, value in zip(("pressure", "stress"), worst.tolist(), strict=True):
        code = f"segment-to-segment, worst of {n_cases}"
        yield Row("Equation 6.1", code, f"maximum deviation of the {name}", "1", value, 0.0, UNIFORM)


def _cases() -> Iterator[tuple[tuple[str, str], int, bool, dict[str, Any]]]:
    """Sides, refinement, matching, and further keys of the cases of segment-to-segment contact."""
    rotated = {"rotation_deg": ROTATION_DEG}
    for name in ELEMENTS:
        for level in N_EDGES:
            yield (name, name), level, False, {}
        yield (name, name), 1, True, {}
        yield (name, name), 1, False, rotated
        yield (name, name), 1, True, rotated
        yield (name, name), 1, False, {"pairing": {"kind": "segment-to-segment", "weighting": "dual"}}
    for sides in MIXED:
        yield sides, 1, False, {}
        yield sides, 1, False, rotated
