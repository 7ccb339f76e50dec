"""Report, files and terminal summary of a section under torsion."""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases import write_summary
from flangeway.cases.section.section_run import SectionRun, TorsionCase
from flangeway.formats import write_vtu
from flangeway.post import corner_shear_stresses
from flangeway.report.figures.drawing import png
from flangeway.report.page.case_text import case_text, inputs_tables, section_command
from flangeway.report.page.html_page import Again, Page, Picture, report_page
from flangeway.report.page.tables import SummaryTable, print_notices, print_rows, timings_table
from flangeway.report.scenes import section_arrays, section_scene
from flangeway.report.section.section_figures import mesh_figure, prandtl_figure, shear_figure, warping_figure
from flangeway.system.output_folder import Writer, bytes_writer, text_writer, write_together

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


PICTURES: dict[str, tuple[Callable[[SectionRun], Figure], str]] = {
    "warping.png": (warping_figure, "Warping about the shear centre over the rate of twist, with contour lines"),
    "shear_stress.png": (shear_figure, "Shear stress for a unit torque, with arrows in its direction"),
    "prandtl.png": (prandtl_figure, "Prandtl's function, whose contour lines are lines of shear flow"),
    "mesh.png": (mesh_figure, "The mesh, with the centroid, the shear centre and the principal axes"),
}
"""Functions that draw the pictures, the most important first, and what they show, by the files' names."""
SUMMARY, FIELDS, REPORT = "section.json", "section.vtu", "report.html"
NAMES = (*PICTURES, FIELDS, REPORT, SUMMARY)


def write_section(
    run: SectionRun, case: TorsionCase, folder: Path, progress: Callable[[str], None] = lambda _: None
) -> list[Path]:
    """Write figures, fields, report and ``section.json`` of a section and its inputs, together or not at all."""
    progress("drawing the pictures and writing the files")
    writers = section_writers(run, case, command=section_command(case), summary_file=SUMMARY)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return write_together(folder, writers)


def section_writers(run: SectionRun, case: TorsionCase, *, command: str, summary_file: str) -> dict[str, Writer]:
    """Functions that write the figures, the fields and the report of a section, by file name."""
    pictures = [
        Picture(png(draw(run)), f"{words}: {run.drawn.title}.", f"{words}.") for draw, words in PICTURES.values()
    ]
    page = report_page(section_page(run, case, pictures, command=command, summary_file=summary_file))
    writers = {name: bytes_writer(each.png) for name, each in zip(PICTURES, pictures, strict=True)}
    writers[FIELDS] = lambda path: _write_fields(run, path)
    writers[REPORT] = text_writer(page)
    return writers


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


def print_section(console: Console, summary: dict[str, Any]) -> None:
    """Print the constants with their units, notices and uncertainty."""
    console.print(summary["title"], style="bold", markup=False)
    print_rows(console, section_rows(summary))
    print_notices(console, summary["notices"])
    if summary["certainty"]:
        console.print(f"Outline: {summary['certainty']}", markup=False, soft_wrap=True)
    for sentence in weights_sentences(summary):
        console.print(sentence, markup=False, soft_wrap=True)
