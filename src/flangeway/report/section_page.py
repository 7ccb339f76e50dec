"""Report, files and terminal summary of a section under torsion."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from flangeway.cases.case_file import write_case_file
from flangeway.cases.section_run import STEEL_KG_M3, SectionRun, stress_key
from flangeway.formats import write_vtu
from flangeway.post import corner_shear_stresses
from flangeway.quantities import Quantity, measured, present
from flangeway.report.page.html_page import inputs_tables
from flangeway.report.page.record import Again, Picture, Report, SummaryTable, fact, rows_of
from flangeway.report.scenes import part_numbers, section_arrays, section_scene
from flangeway.units import Units

SUMMARY, FIELDS = "section.json", "section.vtu"
ASSUMPTIONS = (
    "Saint-Venant torsion of a straight bar: the section rotates without distortion and warps freely.",
    "Linear elastic, isotropic material; parts that share edges are joined there.",
    "Area, centroid and second moments are those of the outline's lines and arcs; torsion is that of the meshed "
    "polygon.",
)
AXES = {
    "x, y": "those of the outline's coordinates, to the right and up",
    "principal axes": "1 has the larger second moment; angles are counter-clockwise from x",
    "shear stress": "of a positive torque, which turns from x to y",
}


def section_record(run: SectionRun, command: str, summary_file: str = SUMMARY) -> Report:
    """Return what was found of a section; its first page is one to pass on.

    - `command`: computes it again.
    - `summary_file`: file of the numbers for programs.
    """
    numbers, case, units, unit = run.summary, run.case, run.case.units, run.drawn.unit
    kind = "triangles" if case.method == "fem" else "polygons, virtual elements"
    quantities = section_quantities(run, units)
    return Report(
        name=run.drawn.title,
        title=run.drawn.title,
        subtitle=f"Constants of a section; {run.space.mesh.n_cells:,} {kind} of order {case.order}, size "
        f"{run.size:.4g} {unit}, {run.space.n_dofs:,} unknowns",
        converged=True,
        success="solved",
        message="by both formulations of torsion",
        facts=[fact(replace(of, form=".5g"), run, units) for of in present(quantities, run) if of.key in FACTS],
        results=SummaryTable(
            "Constants of the section", ("", "value"), tuple(rows_of(present(quantities, run), run, units))
        ),
        summary=numbers,
        summary_file=summary_file,
        again=Again(
            command,
            write_case_file(case),
            files=f"The same numbers, for programs, are in `{summary_file}`; the fields are in `section.vtu`, for "
            "ParaView.",
        ),
        units=units,
        notes=[
            *numbers["notices"],
            *weights_sentences(numbers),
            *([f"Outline: {numbers['certainty']}"] if numbers["certainty"] else []),
        ],
        assumptions=ASSUMPTIONS,
        scene=lambda: section_scene(run),
        pictures=lambda: _pictures(run),
        axes=AXES,
        inputs=inputs_tables(case),
        timings_s=numbers["timings_s"],
        files=lambda: {FIELDS: partial(_write_fields, run)},
    )


def _pictures(run: SectionRun) -> Sequence[Picture]:
    from flangeway.report.section_figures import section_pictures  # noqa: PLC0415 (it loads Matplotlib)

    return section_pictures(run)


MIN_CM_AREA_MM2 = 1000.0
"""Area from which a section drawn in mm has its constants in cm², cm³, cm⁴, cm⁶, as tables of profiles have them."""
FACTS = (
    *("area_{u}2", "second_moments_{u}4 xx", "second_moments_{u}4 yy", "mass_per_metre_kg_m"),
    *("torsion_constant_{u}4", "warping_constant_{u}6", "max_shear_stress_per_torque_per_{u}3"),
)
"""Keys of the numbers at the top of the page."""


def section_quantities(run: SectionRun, units: Units) -> list[Quantity[SectionRun]]:
    """Return the constants of a section, in its unit of length; round-off, which looks like a result, is zero."""
    unit, constants, poisson = run.drawn.unit, run.constants, run.poisson
    steel = f"steel of {measured(STEEL_KG_M3, 'kg/m³', units)}"
    bounds = ("lower bound (Prandtl)", "upper bound (warping)")
    if not constants.bounds_certain:
        bounds = ("from Prandtl's function", "from the warping function")
    keyed, stress = stress_key(run), run.stress_unit
    torque_unit = "MPa/kNm" if unit == "mm" else "{u}⁻³"
    shown = (
        ("area_{u}2", "area", "{u}²", ".7g"),
        ("mass_per_metre_kg_m", f"mass per length, {steel}", "kg/m", ".4g"),
        ("centroid_{u}", "centroid {}", "{u}", ".6g"),
        ("second_moments_{u}4", "second moment I{} about the centroid", "{u}⁴", ".7g"),
        ("principal_moments_{u}4", "principal moment I{}", "{u}⁴", ".7g"),
        ("principal_angle_deg", "angle of principal axis 1 from x, degrees", "", ".5g"),
        ("radii_of_gyration_{u}", "radius of gyration about {:.1}", "{u}", ".6g"),
        ("section_moduli_{u}3", "section modulus, {}", "{u}³", ".6g"),
        ("plastic_moduli_{u}3", "plastic modulus about {:.1}", "{u}³", ".6g"),
        ("shape_factors", "shape factor about {:.1}", "", ".4g"),
        ("shear_areas_{u}2", "shear area along {}", "{u}²", ".6g"),
        ("torsion_constant_{u}4", "torsion constant J", "{u}⁴", ".7g"),
        ("torsion_constant_prandtl_{u}4", f"  {bounds[0]}", "{u}⁴", ".7g"),
        ("torsion_constant_warping_{u}4", f"  {bounds[1]}", "{u}⁴", ".7g"),
        ("half_gap", "  half their difference, relative", "", ".1e"),
        ("shear_centre_{u}", f"shear centre{f' for ν = {poisson:g}' * bool(poisson)} {{}}", "{u}", ".6g"),
        *([("shear_centre_trefftz_{u}", "shear centre by Trefftz {}", "{u}", ".6g")] if poisson else []),
        ("warping_constant_{u}6", "warping constant", "{u}⁶", ".7g"),
        ("max_shear_stress_per_torque_per_{u}3", "maximum shear stress per torque", torque_unit, ".5g"),
        (f"normal_stress_{keyed}", "normal stress, {}", stress, ".5g"),
        (f"max_shear_stress_{keyed}", "maximum shear stress", stress, ".5g"),
        (f"max_von_mises_{keyed}", "maximum von Mises stress", stress, ".5g"),
        ("max_von_mises_position_{u}", "  at {}", "{u}", ".6g"),
    )
    (ixx, iyy, _), (low, high) = constants.second_moments, constants.torsion_bounds
    length, scale = ("cm", 0.1) if unit == "mm" and constants.area >= MIN_CM_AREA_MM2 else (unit, 1.0)
    numbers = run.summary | {
        "principal_angle_deg": round(run.summary["principal_angle_deg"], 7),
        "half_gap": 0.5 * abs(high - low) / constants.torsion_constant,
    }
    least = {"{u}": 1e-7 * numbers[f"boundary_length_{unit}"], "{u}⁴": 1e-9 * math.sqrt(ixx * iyy)}
    factors = {"MPa/kNm": 1e6} | {
        f"{{u}}{sign}": scale**power for power, sign in {2: "²", 3: "³", 4: "⁴", 6: "⁶"}.items()
    }
    quantities: list[Quantity[SectionRun]] = []
    for key, label, of, form in shown:
        value = numbers.get(key.format(u=unit))
        if isinstance(value, list):
            names = {"principal_moments_{u}4": "12", f"normal_stress_{keyed}": ("minimum", "maximum")}
            value = dict(zip(names.get(key, "xy"), value, strict=True))
        for part, number in value.items() if isinstance(value, dict) else (("", value),):
            shown_value = None if number is None else number * (abs(number) >= least.get(of, 0.0))
            words, name = label.format(part), f"{key} {part}".strip()
            shown_unit = of.format(u=length if of in factors else unit)
            quantities.append(
                Quantity(name, words, partial(_same, shown_value), shown_unit, form, factor=factors.get(of, 1.0))
            )
    return quantities


def _same(value: float | None, _: SectionRun) -> float | None:
    return value


def weights_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return what several materials mean for the constants, nothing for one material."""
    if "weights" not in summary:
        return []
    weights = summary["weights"]
    return [
        (
            f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, G = "
            f"{weights['reference_shear_modulus_MPa']:.6g} MPa."
        )
    ]


def _write_fields(run: SectionRun, path: Path) -> None:
    """Write warping about the shear centre, Prandtl's function, and shear stress per torque, unit in the names."""
    mesh = run.space.mesh
    points, (shear,) = section_arrays(run)
    prandtl = run.constants.prandtl
    corners = {shear: corner_shear_stresses(prandtl) / prandtl.torsional_rigidity}
    write_vtu(path, mesh, points, {"part": part_numbers(mesh)}, corners)
