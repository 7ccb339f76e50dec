"""All files of ``flangeway section``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases import write_summary
from flangeway.cases.section.section_run import SectionRun
from flangeway.cases.section.torsion_case import TorsionCase
from flangeway.formats import write_vtu
from flangeway.report.figures.drawing import png
from flangeway.report.page.case_text import section_command
from flangeway.report.page.console import print_files, print_notices, print_rows
from flangeway.report.page.html_page import Picture, report_page
from flangeway.report.scenes import section_arrays
from flangeway.report.section.section_figures import mesh_figure, prandtl_figure, shear_figure, warping_figure
from flangeway.report.section.section_page import section_page, section_rows, weights_sentences
from flangeway.system.output_folder import Writer, bytes_writer, text_writer, write_together

PICTURES: dict[str, tuple[Callable[[SectionRun], Figure], str]] = {
    "warping.png": (warping_figure, "Warping about the shear centre over the rate of twist, with contour lines"),
    "shear_stress.png": (shear_figure, "Shear stress for a unit torque, with arrows in its direction"),
    "prandtl.png": (prandtl_figure, "Prandtl's function, whose contour lines are lines of shear flow"),
    "mesh.png": (mesh_figure, "The mesh, with the centroid, the shear centre and the principal axes"),
}
"""Functions that draw the pictures, the most telling first, and what they show, by the files' names."""
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
    points, means = section_arrays(run)
    write_vtu(path, mesh, points, {**means, "part": part})


def print_section(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print the constants with their units, notices and uncertainty, and the files."""
    console.print(summary["title"], style="bold", markup=False)
    print_rows(console, section_rows(summary))
    print_notices(console, summary["notices"])
    if summary["certainty"]:
        console.print(f"Outline: {summary['certainty']}", markup=False, soft_wrap=True)
    for sentence in weights_sentences(summary):
        console.print(sentence, markup=False, soft_wrap=True)
    print_files(console, files, summary["timings_s"]["total"])
