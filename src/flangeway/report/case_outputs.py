"""Files and terminal summary of the run of any case: one table says what writes them for each kind of case."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.cases import BodiesRun, CaseRun, write_summary
from flangeway.cases.bodies.bodies_run import BodiesCase
from flangeway.cases.case import Case, Progress, Run
from flangeway.cases.rigid.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.section.section_run import SectionRun, TorsionCase, TorsionRun
from flangeway.cases.spatial.spatial_case import SpatialRun, SpatialRunCase
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase, SpatialWheelsetRun
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.report.bodies import bodies_page
from flangeway.report.bodies.bodies_figures import stress_figure
from flangeway.report.figures.fields import part_fields
from flangeway.report.figures.plots import plot_result
from flangeway.report.page.case_text import command_line
from flangeway.report.page.tables import print_files
from flangeway.report.rigid.rigid_figures import conicity_figure, locus_figure
from flangeway.report.section import section_page
from flangeway.report.section.section_figures import warping_figure
from flangeway.report.spatial import spatial_page
from flangeway.report.spatial.spatial_figures import patch_figure
from flangeway.report.spatial_wheelset import spatial_wheelset_page
from flangeway.report.spatial_wheelset.wheelset_patches import section_figure
from flangeway.report.wheelset import wheelset_page
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.results import Result
from flangeway.system.output_folder import Writer, write_together

SUMMARY = "summary.json"


@dataclass(frozen=True)
class CaseOutputs:
    """What writes the outputs of a kind of case."""

    names: tuple[str, ...]  # names of the files, except ``summary.json``
    writers: Callable[[Any, Progress], dict[str, Writer]]
    """From a run to functions that write these files, by their names."""
    print_run: Callable[[Console, Any], None]  # prints what a run found


def _torsion_writers(run: TorsionRun, progress: Progress) -> dict[str, Writer]:
    progress("drawing the pictures and writing the files")
    command = command_line(run.case)
    return section_page.section_writers(run.section, run.case, command=command, summary_file=SUMMARY)


OUTPUTS: dict[type[Case], CaseOutputs] = {
    WheelsetCase: CaseOutputs(wheelset_page.NAMES, wheelset_page.wheelset_writers, wheelset_page.print_summary),
    SpatialWheelsetCase: CaseOutputs(
        spatial_wheelset_page.NAMES,
        spatial_wheelset_page.wheelset_writers,
        spatial_wheelset_page.print_spatial_wheelset,
    ),
    BodiesCase: CaseOutputs(bodies_page.NAMES, bodies_page.bodies_writers, bodies_page.print_bodies),
    SpatialRunCase: CaseOutputs(spatial_page.NAMES, spatial_page.spatial_writers, spatial_page.print_spatial),
    TorsionCase: CaseOutputs(
        section_page.NAMES,
        _torsion_writers,
        lambda console, run: section_page.print_section(console, run.section.summary),
    ),
}
"""Outputs by the kind of case; a new kind adds its line."""


PLOTS: dict[type[Result], Callable[[Any], Figure]] = {
    CaseRun: lambda run: wheelset_figure(run, list(part_fields(run.result))),
    SpatialWheelsetRun: section_figure,
    BodiesRun: stress_figure,
    SpatialRun: patch_figure,
    SectionRun: warping_figure,
    TorsionRun: lambda run: warping_figure(run.section),
    GeometryRun: locus_figure,
    ConicityRun: conicity_figure,
}
for _kind, _draw in PLOTS.items():
    plot_result.register(_kind, _draw)


def _outputs(case: Case) -> CaseOutputs:
    return next(OUTPUTS[kind] for kind in type(case).__mro__ if kind in OUTPUTS)


def case_files(case: Case) -> tuple[str, ...]:
    """Names of the files that a run of a case leaves, except fields that have the names of bodies."""
    return *_outputs(case).names, SUMMARY


def write_case(run: Run, folder: Path, progress: Progress = lambda _: None) -> list[Path]:
    """Write all files of a run, ``summary.json`` last, together or not at all.

    It is an `InputError` if the folder cannot be written.
    """
    writers = _outputs(run.case).writers(run, progress)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return write_together(folder, writers)


def print_case(console: Console, run: Run) -> None:
    """Print what a run found; its files may be written afterwards."""
    _outputs(run.case).print_run(console, run)


def print_case_files(console: Console, run: Run, files: list[Path]) -> None:
    """Print the time of a run and its files; those in folders of their own are counted."""
    folder = files[-1].parent
    print_files(console, [file for file in files if file.parent == folder], run.summary.timings_s["total"])
    for name, count in Counter(file.parent for file in files if file.parent != folder).items():
        console.print(f"  {name}: {count} files of earlier load steps", markup=False, soft_wrap=True)
