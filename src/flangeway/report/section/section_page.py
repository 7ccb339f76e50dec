"""The report of a section under torsion."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from flangeway.cases.section.section_run import SectionRun
from flangeway.cases.section.torsion_case import TorsionCase
from flangeway.report.page.case_text import case_text, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture
from flangeway.report.page.page_tables import SummaryTable, timings_table
from flangeway.report.scenes import section_scene

SOLVED = "both formulations of torsion were solved"
AXES = {
    "x, y": "those of the outline's coordinates, to the right and up",
    "principal axes": "1 has the larger second moment; angles are counter-clockwise from x",
    "shear stress": "of a positive torque, which turns from x to y",
}


def section_page(
    run: SectionRun, case: TorsionCase, pictures: Sequence[Picture], *, command: str, summary_file: str
) -> Page:
    """Return the report of a section; ``command`` computes it again, ``summary_file`` has its numbers."""
    summary = run.summary
    mesh = summary["mesh"]
    kind = "triangles" if mesh["method"] == "fem" else "polygons, virtual elements"
    return Page(
        title=run.drawn.title,
        subtitle=f"A section under torsion; {mesh['cells']:,} {kind} of order {mesh['order']}, lengths in "
        f"{run.drawn.unit}",
        converged=True,
        message=SOLVED,
        facts=_facts(summary),
        again=Again(
            command,
            case_text(case),
            files=f"The same numbers, for programs, are in `{summary_file}`; the fields are in `section.vtu`, for "
            "ParaView.",
        ),
        versions=summary["versions"],
        sentences=weights_sentences(summary),
        warnings=summary["notices"],
        assumptions=_assumptions(summary),
        scene=section_scene(run),
        pictures=pictures,
        tables=[
            SummaryTable("Constants of the section", ("", "value"), tuple(section_rows(summary))),
            timings_table(summary["timings_s"]),
        ],
        axes=AXES,
        inputs=inputs_tables(case),
    )


def _facts(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    rows = [
        (f"area_{unit}2", f"{unit}²", "area"),
        (f"torsion_constant_{unit}4", f"{unit}⁴", "torsion constant J"),
        (f"warping_constant_{unit}6", f"{unit}⁶", "warping constant"),
        (f"max_shear_stress_per_torque_per_{unit}3", f"{unit}⁻³", "maximum shear stress per torque"),
    ]
    return [(f"{summary[key]:.5g} {power}", name) for key, power, name in rows if summary[key] is not None]


def _assumptions(summary: Mapping[str, Any]) -> list[str]:
    sentences = [
        "Saint-Venant torsion of a straight bar: the section rotates without distortion and warps freely.",
        "Linear elastic, isotropic material; parts that share edges are joined there.",
        "Area, centroid and second moments are those of the outline's lines and arcs; torsion is that of the meshed "
        "polygon.",
    ]
    if summary["certainty"]:
        sentences.append(f"Outline: {summary['certainty']}")
    return sentences


def section_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Name with unit and value of every constant, as shown."""
    unit, mesh = summary["unit"], summary["mesh"]

    def point(key: str) -> str:
        size = summary[f"boundary_length_{unit}"]
        # round-off would look like a result
        x, y = (0.0 if abs(value) < 1e-7 * size else value for value in summary[key])
        return f"({x:.6g}, {y:.6g})"

    moments = summary[f"second_moments_{unit}4"]
    noise = 1e-9 * math.sqrt(moments["xx"] * moments["yy"])
    product = 0.0 if abs(moments["xy"]) < noise else moments["xy"]
    bounds = [summary[f"torsion_constant_{kind}_{unit}4"] for kind in ("prandtl", "warping")]
    half_gap = 0.5 * abs(bounds[1] - bounds[0]) / summary[f"torsion_constant_{unit}4"]
    lower, upper = ("lower bound (Prandtl)", "upper bound (warping)")
    if not summary["torsion_bounds_certain"]:
        lower, upper = "from Prandtl's function", "from the warping function"
    angle = summary["principal_angle_deg"]
    rows = [
        (f"area, {unit}²", f"{summary[f'area_{unit}2']:.7g}"),
        (f"centroid (x, y), {unit}", point(f"centroid_{unit}")),
        *(
            (f"second moment {name} about the centroid, {unit}⁴", f"{value:.7g}")
            for name, value in (("Ixx", moments["xx"]), ("Iyy", moments["yy"]), ("Ixy", product))
        ),
        *(
            (f"principal moment I{number}, {unit}⁴", f"{value:.7g}")
            for number, value in enumerate(summary[f"principal_moments_{unit}4"], 1)
        ),
        ("angle of principal axis 1 from x, degrees", f"{0.0 if abs(angle) < 1e-7 else angle:.5g}"),
        *_bending_rows(summary),
        (f"torsion constant J, {unit}⁴", f"{summary[f'torsion_constant_{unit}4']:.7g}"),
        (f"  {lower}", f"{bounds[0]:.7g}"),
        (f"  {upper}", f"{bounds[1]:.7g}"),
        ("  half their difference, relative", f"{half_gap:.1e}"),
        (f"shear centre (x, y), {unit}", point(f"shear_centre_{unit}")),
    ]
    if summary["poisson"]:
        rows[-1] = (f"shear centre for ν = {summary['poisson']:g} (x, y), {unit}", point(f"shear_centre_{unit}"))
        rows.append((f"shear centre by Trefftz (x, y), {unit}", point(f"shear_centre_trefftz_{unit}")))
    rows.append((f"warping constant, {unit}⁶", f"{summary[f'warping_constant_{unit}6']:.7g}"))
    maximum = summary[f"max_shear_stress_per_torque_per_{unit}3"]
    if maximum is not None:
        rows.append((f"maximum shear stress per torque, {unit}⁻³", f"{maximum:.5g}"))
    rows.append(
        (
            f"{mesh['cells']} {'triangles' if mesh['method'] == 'fem' else 'polygons'} of order {mesh['order']}, "
            f"size {mesh[f'size_{unit}']:.4g} {unit}",
            f"{mesh['unknowns']} unknowns",
        )
    )
    return rows


def _bending_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    radii = summary[f"radii_of_gyration_{unit}"]
    rows = [(f"radii of gyration (about x, about y), {unit}", f"({radii['xx']:.6g}, {radii['yy']:.6g})")]
    moduli = summary.get(f"section_moduli_{unit}3")
    if moduli is not None:
        rows += [
            (f"section moduli ({one}, {other}), {unit}³", f"({moduli[one]:.6g}, {moduli[other]:.6g})")
            for one, other in (("top", "bottom"), ("left", "right"))
        ]
    return rows


def weights_sentences(summary: dict[str, Any]) -> list[str]:
    """Return what several materials mean for the constants, nothing for one material."""
    if "weights" not in summary:
        return []
    weights = summary["weights"]
    return [
        f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, "
        f"G = {weights['reference_shear_modulus_MPa']:.6g} MPa."
    ]
