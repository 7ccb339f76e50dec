"""Files and terminal summary of the run of any case: the kind of its run decides which writer is taken."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from flangeway.cases import CaseRun, write_summary
from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.case import Case, Run
from flangeway.cases.section.torsion_case import TorsionCase, TorsionRun
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.report.bodies.bodies_figures import pressure_figure, stress_figure
from flangeway.report.bodies.bodies_page import bodies_page
from flangeway.report.bodies.bodies_text import case_rows
from flangeway.report.bodies.body_fields import bodies_fields
from flangeway.report.bodies.body_steps import body_steps
from flangeway.report.figures.drawing import png
from flangeway.report.figures.newton_history import newton_figure
from flangeway.report.figures.series import write_collection
from flangeway.report.page.command import command_line
from flangeway.report.page.console import print_files, print_notices, print_rows, print_status
from flangeway.report.page.html_page import Picture, report_page
from flangeway.report.section.section_outputs import NAMES as SECTION_NAMES
from flangeway.report.section.section_outputs import print_section, section_writers
from flangeway.report.wheelset.terminal import print_summary
from flangeway.report.wheelset.wheelset_outputs import NAMES as WHEELSET_NAMES
from flangeway.report.wheelset.wheelset_outputs import write_outputs
from flangeway.system.output_folder import Writer, bytes_writer, text_writer, write_together

SUMMARY, REPORT, COLLECTION = "summary.json", "report.html", "bodies.pvd"
STEPS = "steps"
"""Folder of the earlier load steps."""
STRESSES, PRESSURE, CONVERGENCE = "stresses.png", "pressure.png", "convergence.png"


def case_files(case: Case) -> tuple[str, ...]:
    """Names of the files that a run of a case leaves, but those of bodies, which are called after them."""
    if isinstance(case, WheelsetCase):
        return WHEELSET_NAMES
    if isinstance(case, TorsionCase):
        return (*SECTION_NAMES, SUMMARY)
    return SUMMARY, REPORT, COLLECTION, STRESSES, PRESSURE, CONVERGENCE


def write_case(run: Run, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write all files of a run, ``summary.json`` last, together or not at all.

    Parameters
    ----------
    run
        The run.
    folder
        Where the files go; made if needed.
    progress
        Called with a sentence at each stage.

    Raises
    ------
    InputError
        If the folder cannot be written.

    """
    if isinstance(run, CaseRun):
        return write_outputs(run, folder, progress)
    progress("drawing the pictures and writing the files")
    if isinstance(run, TorsionRun):
        writers = section_writers(run.section, run.case, command=command_line(run.case), summary_file=SUMMARY)
    else:
        assert isinstance(run, BodiesRun)
        writers = _body_writers(run)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return write_together(folder, writers)


def _body_writers(run: BodiesRun) -> dict[str, Writer]:
    pictures = _pictures(run)
    steps = body_steps(run, list(bodies_fields(run)))
    writers = {name: bytes_writer(picture.png) for name, picture in pictures.items()}
    entries = []
    for number, fields in zip(steps.numbers, steps.fields, strict=True):
        for place, body in enumerate(fields, 1):
            # names are the user's and may not do as those of files
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
    """Pictures by the names of their files, the most telling first."""
    near = ", and near the contact" if run.patches else ""
    pictures = {
        STRESSES: Picture(
            png(stress_figure(run)),
            f"The bodies as deformed, with their cells, coloured by von Mises stress{near}.",
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
            "Relative errors over the iterations of Newton's method in all load steps, on a logarithmic axis.",
            "Convergence: imbalance of the forces and change of the displacements in each iteration.",
        )
    return pictures


def print_case(console: Console, run: Run, files: list[Path]) -> None:
    """Print what a run found, in a table, and the files."""
    if isinstance(run, CaseRun):
        print_summary(console, run.summary, files)
        return
    if isinstance(run, TorsionRun):
        print_section(console, run.summary, files)
        return
    summary = run.summary
    print_status(console, run.case.name, summary["status"])
    print_rows(console, case_rows(summary))
    print_notices(console, summary["notices"])
    folder = files[-1].parent
    print_files(console, [file for file in files if file.parent == folder], summary["timings_s"]["total"])
    n_earlier = sum(file.parent != folder for file in files)
    if n_earlier:
        console.print(f"  {folder / STEPS}: {n_earlier} files of earlier load steps", markup=False, soft_wrap=True)
