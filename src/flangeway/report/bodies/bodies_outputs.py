"""Files and terminal summary of a case of bodies."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.report.bodies.bodies_figures import pressure_figure, stress_figure
from flangeway.report.bodies.bodies_page import bodies_page, case_rows
from flangeway.report.bodies.body_fields import bodies_fields, body_steps
from flangeway.report.figures.drawing import png
from flangeway.report.figures.newton_history import newton_figure
from flangeway.report.figures.series import write_collection
from flangeway.report.page.console import print_files, print_notices, print_rows, print_status
from flangeway.report.page.html_page import Picture, report_page
from flangeway.system.output_folder import Writer, bytes_writer, text_writer

STEPS = "steps"
"""Folder of the earlier load steps."""
REPORT, COLLECTION = "report.html", "bodies.pvd"
STRESSES, PRESSURE, CONVERGENCE = "stresses.png", "pressure.png", "convergence.png"
NAMES = (REPORT, COLLECTION, STRESSES, PRESSURE, CONVERGENCE)
"""Names of the files, except the fields, which have the names of the bodies."""


def bodies_writers(run: BodiesRun, progress: Callable[[str], None]) -> dict[str, Writer]:
    """Return functions that write pictures, fields and report, by the files' names."""
    progress("drawing the pictures and writing the files")
    pictures = _pictures(run)
    steps = body_steps(run, list(bodies_fields(run)))
    writers = {name: bytes_writer(picture.png) for name, picture in pictures.items()}
    entries = []
    for number, fields in zip(steps.numbers, steps.fields, strict=True):
        for place, body in enumerate(fields, 1):
            # a name given by the user may not be allowed as that of a file
            plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in body.name)
            stem = f"{place}-{plain}" if len(fields) > 1 else plain
            file = f"{stem}.vtu" if number == steps.numbers[-1] else f"{STEPS}/{stem}-{number}.vtu"
            writers[file] = body.write
            entries.append((float(number), body.name, file))
    if len(entries) > 1:
        writers[COLLECTION] = lambda path: write_collection(path, entries)
    writers[REPORT] = text_writer(report_page(bodies_page(run, list(pictures.values()), steps)))
    return writers


def _pictures(run: BodiesRun) -> dict[str, Picture]:
    """Pictures by the names of their files, the most important first."""
    near = ", and near the contact" if run.patches else ""
    pictures = {
        STRESSES: Picture(
            png(stress_figure(run)),
            f"The bodies as deformed, with their elements, coloured by von Mises stress{near}.",
            f"Von Mises stress on the deformed bodies{near}.",
        )
    }
    if run.patches:
        theory = ", beside Hertz's theory for the same force" if run.theory is not None else ""
        pictures[PRESSURE] = Picture(
            png(pressure_figure(run)),
            f"Contact pressure along each region of contact, node by node{theory}.",
            f"Contact pressure along the surface{theory}.",
        )
    if run.contact is not None:
        pictures[CONVERGENCE] = Picture(
            png(newton_figure(run.contact)),
            "Relative residuals over the iterations of Newton's method in all load steps, on a logarithmic axis.",
            "Convergence: residual of the forces and change of the displacements in each iteration.",
        )
    return pictures


def print_bodies(console: Console, run: BodiesRun, files: list[Path]) -> None:
    """Print status, results, notices and the files."""
    print_status(console, run.case.name, run.status)
    print_rows(console, case_rows(run.summary))
    print_notices(console, run.summary.notices)
    folder = files[-1].parent
    print_files(console, [file for file in files if file.parent == folder], run.summary.timings_s["total"])
    n_earlier = sum(file.parent != folder for file in files)
    if n_earlier:
        console.print(f"  {folder / STEPS}: {n_earlier} files of earlier load steps", markup=False, soft_wrap=True)
