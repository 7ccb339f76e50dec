"""All files of ``flangeway section``, and its summary on the terminal."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.mesh import write_vtu
from flangeway.post import shear_stresses
from flangeway.report.files import picture_writers, print_files
from flangeway.report.section_figures import (
    mesh_figure,
    prandtl_figure,
    shear_figure,
    warping_about_shear_centre,
    warping_figure,
)
from flangeway.study import refuse_unwritable, write_summary, write_together
from flangeway.study.section import SectionRun

PICTURES = {
    "mesh.png": mesh_figure,
    "warping.png": warping_figure,
    "prandtl.png": prandtl_figure,
    "shear_stress.png": shear_figure,
}
SUMMARY, FIELDS = "section.json", "section.vtu"
NAMES = (*PICTURES, FIELDS, SUMMARY)


def check_section_folder(folder: Path) -> None:
    """Refuse a folder that cannot take the files; see `flangeway.study.refuse_unwritable`."""
    refuse_unwritable(folder, NAMES)


def write_section(run: SectionRun, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write the pictures, the fields and ``section.json``, together or not at all.

    Parameters
    ----------
    run
        The section.
    folder
        Where the files go; made if needed.
    progress
        Called with a sentence at each stage.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    progress("drawing the pictures and writing the files")
    return write_together(folder, section_writers(run))


def section_writers(run: SectionRun) -> dict[str, Callable[[Path], None]]:
    """Return functions that write the files of a section, by the files' names."""
    writers = picture_writers({name: draw(run) for name, draw in PICTURES.items()})
    writers[FIELDS] = lambda path: _write_fields(run, path)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return writers


def _write_fields(run: SectionRun, path: Path) -> None:
    """Write warping about the shear centre, Prandtl's function, and shear stress per torque, unit in the names."""
    mesh, unit, prandtl = run.space.mesh, run.drawn.unit, run.constants.prandtl
    part = np.zeros(mesh.n_cells, dtype=np.int32)
    for number, cells in enumerate(mesh.cell_sets.values()):
        part[cells] = number
    write_vtu(
        path,
        mesh,
        {
            f"warping_{unit}2": warping_about_shear_centre(run),
            f"prandtl_{unit}2": prandtl.function[: mesh.n_points] / prandtl.problem.mean_modulus,
        },
        {f"shear_stress_per_torque_per_{unit}3": shear_stresses(prandtl) / prandtl.torsional_rigidity, "part": part},
    )


def print_section(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print the constants with their units, what was mended or is uncertain, and the files."""
    console.print(summary["title"], style="bold", markup=False)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column(justify="right")
    for row in section_rows(summary):
        table.add_row(*row)
    console.print(table)
    for notice in summary["notices"]:
        console.print(f"Note: {notice}", style="yellow", markup=False, soft_wrap=True)
    if summary["certainty"]:
        console.print(f"Outline: {summary['certainty']}", markup=False, soft_wrap=True)
    if "weights" in summary:
        weights = summary["weights"]
        console.print(
            f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, "
            f"G = {weights['reference_shear_modulus_MPa']:.6g} MPa.",
            markup=False,
            soft_wrap=True,
        )
    print_files(console, files, summary["timings_s"]["total"])


def section_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Name with unit and value of every constant, as shown."""
    unit, mesh = summary["unit"], summary["mesh"]

    def point(key: str) -> str:
        size = summary[f"boundary_length_{unit}"]
        # noise of rounding would look like a result
        x, y = (0.0 if abs(value) < 1e-7 * size else value for value in summary[key])
        return f"({x:.6g}, {y:.6g})"

    moments = summary[f"second_moments_{unit}4"]
    noise = 1e-9 * math.sqrt(moments["xx"] * moments["yy"])
    product = 0.0 if abs(moments["xy"]) < noise else moments["xy"]
    bounds = [summary[f"torsion_constant_{kind}_{unit}4"] for kind in ("prandtl", "warping")]
    half_gap = 0.5 * abs(bounds[1] - bounds[0]) / summary[f"torsion_constant_{unit}4"]
    certain = "bounds of the meshed polygon's" if summary["torsion_bounds_certain"] else "both formulations"
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
        (f"torsion constant J, {unit}⁴", f"{summary[f'torsion_constant_{unit}4']:.7g}"),
        (f"  {certain}: from Prandtl's function", f"{bounds[0]:.7g}"),
        ("  from the warping function", f"{bounds[1]:.7g}"),
        ("  half of the gap, relative", f"{half_gap:.1e}"),
        (f"shear centre (x, y), {unit}", point(f"shear_centre_{unit}")),
    ]
    if summary["poisson"]:
        rows[-1] = (f"shear centre for ν = {summary['poisson']:g} (x, y), {unit}", point(f"shear_centre_{unit}"))
        rows.append((f"shear centre by Trefftz (x, y), {unit}", point(f"shear_centre_trefftz_{unit}")))
    rows.append((f"warping constant, {unit}⁶", f"{summary[f'warping_constant_{unit}6']:.7g}"))
    largest = summary[f"max_shear_stress_per_torque_per_{unit}3"]
    if largest is not None:
        rows.append((f"largest shear stress per torque, {unit}⁻³", f"{largest:.5g}"))
    rows.append(
        (
            f"{mesh['cells']} {'triangles' if mesh['method'] == 'fem' else 'polygons'} of order {mesh['order']}, "
            f"size {mesh[f'size_{unit}']:.4g} {unit}",
            f"{mesh['unknowns']} unknowns",
        )
    )
    return rows
