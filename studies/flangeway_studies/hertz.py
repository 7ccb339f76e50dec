"""The published Hertz problem (Moherdaui 2021, 6.2.2, Tables 9 to 14), and the same without its oscillations.

As published: node-to-segment, a penalty per node, straight edges, ten load steps. The penalty is taken as Table 10
prints it, and halved with each refinement, so that it falls with the elements' size (by 2 on M1 to 16 on M4): with that
reading the extremes of Tables 12 to 14 come out, and the pressures of Figure 76. Beside it: segment-to-segment with
multipliers weighted by biorthogonal functions, the gap measured between the circles.
"""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import ContactSolution
from flangeway.exact import LineContact
from flangeway.post import pressure_patches
from flangeway.post.pressure import PressurePatch
from flangeway.types import Floats
from flangeway_studies.study import Row, Run, published_rows

CODES = ("FDO1", "VVO1", "FDO2", "VVO2", "VDO2", "HEO2")
"""Method, cells and order: finite, virtual, hybrid; Delaunay, Voronoi, edge-refined (Table 8)."""
LEVELS = (1, 2, 3, 4)
FINE = 3  # level from which the tighter limits hold
REFERENCE_FORCE = 251.84
"""Force in kN of the published reference solution, from which its p0 = 671.51 kN/cm^2 and a = 0.239 cm follow."""
EXTREMES = {12: "min minimum principal stress", 13: "max maximum shear stress", 14: "max von Mises stress"}
STRESS_LIMIT = 0.03
STRESS_CODES = ("VVO1", "VVO2")
"""Rows whose extremes have a limit; those of the others depend on the mesh through their oscillations."""
FORCE_LIMITS = {1: 0.01, 2: 0.005}
"""Of the force by order; of order 2 at M1 and M2 it is that of order 1."""
VARIANTS = {
    "printed": "node-to-segment, penalty as printed",
    "halved": "node-to-segment, penalty halved with each refinement",
    "segments": "segment-to-segment with multipliers between the circles",
}
SUFFIXES = {"printed": ("", " (penalty as printed)"), "halved": (" (penalty halved with each refinement)", "")}
"""Of the force and of the extremes."""
SLACK = 0.02  # nodes keep the edge that they faced within this fraction of it; otherwise some configurations cycle
METHODS = {"FD": "fem", "VD": "vem-triangles", "VV": "vem", "HE": "fem"}
PUBLISHED_DISCS: dict[str, Any] = {
    "radius_mm": 4.0,
    "lower_radius_mm": 4.0,
    "indentation_mm": 0.05,
    "thickness_mm": 1.0,
    "young_MPa": 20e3,
    "fine_arc_deg": 360.0 / 11.0,
    "body_size_mm": 0.5,
    "n_steps": 10,
}
"""Half discs that are fine along an arc about their apex (Moherdaui 2021, Figure 66)."""


@cache
def _published() -> dict[tuple[str, str], dict[str, str]]:
    rows = published_rows("hertz_tables_9_to_14.csv")
    return {(row["table"] if row["code"] else row["quantity"], row["code"]): row for row in rows}


def published_value(key: str, code: str, level: int) -> float:
    """Published number by table and code, or by the quantity of Tables 9 and 10 without a code."""
    return float(_published()[key, code][f"M{level}"])


def published_case(code: str, level: int, variant: str = "printed") -> HertzCase:
    """Return one of `CODES` on a mesh, 1 to 4, in one of `VARIANTS`.

    The keys' mm, N and MPa stand for cm, kN and kN/cm^2. With ``"segments"`` virtual elements have their default
    stabilisation: the published one, half of the trace, is many times too stiff for the shapes of edges that
    polynomials miss, and multipliers answer to it.
    """
    upper, lower = (published_value(f"element size Delaunay {side}", "", level) for side in ("slave", "master"))
    values: dict[str, Any] = {
        **PUBLISHED_DISCS,
        "method": METHODS[code[:2]],
        "order": int(code[3]),
        "halved_edges": code[1] == "E",
        "size_mm": upper,
        "lower_size_mm": lower,
    }
    if variant == "segments":
        values |= {"enforcement": "multiplier", "pairing": {"kind": "segment-to-segment", "weighting": "dual"}}
    else:
        penalty = published_value(f"penalty {'Voronoi' if code[1] == 'V' else 'Delaunay'}", "", level)
        penalty /= 2.0 ** (level * (variant == "halved"))
        values |= {"pairing": {"kind": "node-to-segment", "slack": SLACK}, "stabilisation": "trace", "curved": False}
        values |= {"enforcement": {"kind": "penalty", "nodal_penalty_N_per_mm": penalty}}
    return HertzCase.from_values(values)


def largest_patch(solution: ContactSolution) -> tuple[Floats, PressurePatch]:
    """Positions x of the loaded nodes before the deformation, shape (n,), and their pressures.

    By a second-order effect that Hertz's theory leaves out, the surface moves towards the middle (here by 1.1 %).
    """
    patch = max(pressure_patches(solution.system, solution.state), key=lambda patch: float(patch.normal_forces.sum()))
    secondary = solution.system.contacts[0].secondary
    return secondary.part.body.nodes[secondary.nodes[patch.nodes], 0], patch


def rms_from_hertz(
    x: Floats, pressures: Floats, theory: LineContact, within: float, weights: Floats | None = None
) -> float:
    """Root mean square difference of pressures from Hertz's, over its maximum, at nodes nearer than ``within``.

    - `x`, `pressures`: positions of the nodes from the middle before the deformation, and their pressures, (n,).
    - `weights`: those of the nodes, (n,); left out: all alike.
    """
    inside = np.abs(x) < within
    apart = (pressures - theory.pressure(x))[inside] / theory.max_pressure
    return np.sqrt(np.average(apart**2, weights=None if weights is None else weights[inside]))


def oscillation(pressures: Floats) -> float:
    """Root mean square difference between a node and the mean of its neighbours, over the maximum pressure.

    The two nodes at each end are left out, where the pressure falls steeply.
    """
    apart = pressures[1:-1] - (pressures[:-2] + pressures[2:]) / 2.0
    return np.sqrt(np.mean(apart[1:-1] ** 2)) / pressures.max()


def rows(run: Run) -> Iterator[Row]:
    """Rows of all configurations, and of those of order 2 with segment-to-segment contact; without M4 if quick."""
    levels = LEVELS[:-1] if run.quick else LEVELS
    for variant in VARIANTS:
        for code in CODES:
            for level in levels if variant != "segments" or code.endswith("2") else ():
                yield from _rows(run, code, level, variant)


def _rows(run: Run, code: str, level: int, variant: str) -> Iterator[Row]:
    case, name = published_case(code, level, variant), f"{code}M{level}"
    hertz_run = case.run()
    assert hertz_run.contact is not None
    run.check(f"{name}, {VARIANTS[variant]}", hertz_run.contact.status)
    force, stresses = hertz_run.contact.forces[0, 1], [body.stresses for body in hertz_run.bodies.values()]
    extremes = (
        min(stress.principal[:, 2].min() for stress in stresses),
        max(stress.in_plane_shear.max() for stress in stresses),
        max(stress.von_mises.max() for stress in stresses),
    )
    x, patch = largest_patch(hertz_run.contact)
    theory = case.theory(force)
    if level == FINE and variant != "printed" and code[3] == "2":
        # of node-to-segment contact over influence widths, half of the way to either neighbour (Figures 24 and 63)
        pressures = patch.pressures if variant == "segments" else patch.normal_forces / np.gradient(x)
        run.curve("pressures", code, VARIANTS[variant], x, pressures, ".-")
        if variant == "segments":
            run.curve("pressures", code, "Hertz", *theory.curve)
    if variant != "segments":
        of_force, of_stress = SUFFIXES[variant]
        limit = FORCE_LIMITS[int(code[3])] if level >= FINE else FORCE_LIMITS[1]
        yield Row("6.2.2", name, f"force{of_force}", "kN", force, REFERENCE_FORCE, None if of_force else limit)
        for (table, quantity), value in zip(EXTREMES.items(), extremes, strict=True):
            required = variant == "halved" and code in STRESS_CODES
            published = published_value(str(table), code, level)
            yield Row(
                table, name, quantity + of_stress, "kN/cm^2", value, published, STRESS_LIMIT if required else None
            )
        return
    exact = case.theory(REFERENCE_FORCE)
    inside = np.abs(np.abs(x) - theory.half_width) > case.size_mm  # without the element at each end of the contact
    apart = np.abs(patch.pressures - theory.pressure(x))[inside].max() / theory.max_pressure
    for quantity, unit, value, published, limit in (
        ("force", "kN", force, REFERENCE_FORCE, 0.005),
        ("min minimum principal stress", "kN/cm^2", extremes[0], -exact.max_pressure, 0.01),
        ("half width", "cm", patch.half_width, exact.half_width, 0.02),
        ("maximum difference from Hertz's pressure", "over p0", apart, 0.0, 0.015),
        ("oscillation of the pressure", "over p0", oscillation(patch.pressures), 0.0, 0.005),
    ):
        yield Row("Hertz", name, quantity, unit, value, published, limit if level >= FINE else None)
