"""Report, files and terminal summary of a section under torsion."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.section.section_run import STEEL_KG_M3, SectionRun, TorsionCase
from flangeway.formats import write_vtu
from flangeway.post import corner_shear_stresses
from flangeway.report.page.case_text import case_text, inputs_tables
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import SummaryTable
from flangeway.report.scenes import section_arrays, section_scene
from flangeway.report.section.section_figures import mesh_figure, prandtl_figure, shear_figure, warping_figure

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


def section_record(
    run: SectionRun,
    case: TorsionCase,
    *,
    command: str,
    summary: Mapping[str, Any] | None = None,
    summary_file: str = SUMMARY,
) -> Record:
    """Return what was found of a section; its first page is one to pass on.

    - `command`: computes it again.
    - `summary`, `summary_file`: the numbers for programs, those of the section if left out, and their file.
    """
    found = run.summary
    mesh = found["mesh"]
    kind = "triangles" if mesh["method"] == "fem" else "polygons, virtual elements"
    return Record(
        name=run.drawn.title,
        title=run.drawn.title,
        subtitle=f"Constants of a section; {mesh['cells']:,} {kind} of order {mesh['order']}, size "
        f"{mesh[f'size_{run.drawn.unit}']:.4g} {run.drawn.unit}, {mesh['unknowns']:,} unknowns",
        converged=True,
        success="solved",
        message="by both formulations of torsion",
        facts=_facts(found),
        results=SummaryTable("Constants of the section", ("", "value"), tuple(section_rows(found))),
        summary=found if summary is None else summary,
        summary_file=summary_file,
        again=Again(
            command,
            case_text(case),
            files=f"The same numbers, for programs, are in `{summary_file}`; the fields are in `section.vtu`, for "
            "ParaView.",
        ),
        versions=found["versions"],
        notes=[
            *found["notices"],
            *weights_sentences(found),
            *([f"Outline: {found['certainty']}"] if found["certainty"] else []),
        ],
        assumptions=ASSUMPTIONS,
        scene=lambda: section_scene(run),
        pictures=[
            Picture(name, partial(draw, run), f"{words}: {run.drawn.title}.", f"{words}.")
            for name, (draw, words) in PICTURES.items()
        ],
        axes=AXES,
        inputs=inputs_tables(case),
        timings_s=found["timings_s"],
        files=lambda: {FIELDS: partial(_write_fields, run)},
    )


def _facts(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    moments = summary[f"second_moments_{unit}4"]
    found = {**summary, "Ixx": moments["xx"], "Iyy": moments["yy"]}
    rows = [
        (f"area_{unit}2", f"{unit}²", "area"),
        ("Ixx", f"{unit}⁴", "second moment Ixx"),
        ("Iyy", f"{unit}⁴", "second moment Iyy"),
        ("mass_per_metre_kg_m", "kg/m", "mass per length"),
        (f"torsion_constant_{unit}4", f"{unit}⁴", "torsion constant J"),
        (f"warping_constant_{unit}6", f"{unit}⁶", "warping constant"),
        (f"max_shear_stress_per_torque_per_{unit}3", f"{unit}⁻³", "maximum shear stress per torque"),
    ]
    return [(f"{found[key]:.5g} {power}", name) for key, power, name in rows if found[key] is not None]


def section_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Name with unit and value of every constant, as shown."""
    unit, kg_m = summary["unit"], summary["mass_per_metre_kg_m"]
    mass = [] if kg_m is None else [(f"mass per length, steel of {STEEL_KG_M3:g} kg/m³, kg/m", f"{kg_m:.4g}")]

    def point(name: str, key: str) -> list[tuple[str, str]]:
        size = summary[f"boundary_length_{unit}"]
        # round-off would look like a result
        values = (0.0 if abs(value) < 1e-7 * size else value for value in summary[key])
        return [(f"{name} {axis}, {unit}", f"{value:.6g}") for axis, value in zip("xy", values, strict=True)]

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
        *mass,
        *point("centroid", f"centroid_{unit}"),
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
        (f"  {lower}, {unit}⁴", f"{bounds[0]:.7g}"),
        (f"  {upper}, {unit}⁴", f"{bounds[1]:.7g}"),
        ("  half their difference, relative", f"{half_gap:.1e}"),
    ]
    poisson = summary["poisson"]
    rows += point(f"shear centre{f' for ν = {poisson:g}' if poisson else ''}", f"shear_centre_{unit}")
    if poisson:
        rows += point("shear centre by Trefftz", f"shear_centre_trefftz_{unit}")
    rows.append((f"warping constant, {unit}⁶", f"{summary[f'warping_constant_{unit}6']:.7g}"))
    maximum = summary[f"max_shear_stress_per_torque_per_{unit}3"]
    if maximum is not None:
        rows.append((f"maximum shear stress per torque, {unit}⁻³", f"{maximum:.5g}"))
    return rows


def _bending_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    rows = [
        (f"radius of gyration about {axis}, {unit}", f"{summary[f'radii_of_gyration_{unit}'][axis * 2]:.6g}")
        for axis in "xy"
    ]
    moduli = summary.get(f"section_moduli_{unit}3", {})
    return rows + [(f"section modulus, {side}, {unit}³", f"{value:.6g}") for side, value in moduli.items()]


def weights_sentences(summary: dict[str, Any]) -> list[str]:
    """Return what several materials mean for the constants, nothing for one material."""
    if "weights" not in summary:
        return []
    weights = summary["weights"]
    return [
        f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, "
        f"G = {weights['reference_shear_modulus_MPa']:.6g} MPa."
    ]


PICTURES: dict[str, tuple[Callable[[SectionRun], Figure], str]] = {
    "mesh.png": (mesh_figure, "The mesh, with the centroid, the shear centre and the principal axes"),
    "warping.png": (warping_figure, "Warping about the shear centre over the rate of twist, with contour lines"),
    "shear_stress.png": (shear_figure, "Shear stress for a unit torque, with arrows in its direction"),
    "prandtl.png": (prandtl_figure, "Prandtl's function, whose contour lines are lines of shear flow"),
}
"""Functions that draw the pictures, the most important first, and what they show, by the files' names."""
NAMES = (*PICTURES, FIELDS)


def _write_fields(run: SectionRun, path: Path) -> None:
    """Write warping about the shear centre, Prandtl's function, and shear stress per torque, unit in the names."""
    mesh = run.space.mesh
    part = np.zeros(mesh.n_cells, dtype=np.int32)
    for number, cells in enumerate(mesh.cell_sets.values()):
        part[cells] = number
    points, (shear,) = section_arrays(run)
    prandtl = run.constants.prandtl
    corners = {shear: corner_shear_stresses(prandtl) / prandtl.torsional_rigidity}
    write_vtu(path, mesh, points, {"part": part}, corners)
