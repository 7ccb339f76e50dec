"""Files and terminal summary of the run of any case: the kind of its run decides which writer is taken."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from flangeway.mesh import write_vtu
from flangeway.post import Stresses
from flangeway.report.bodies_figures import pressure_figure, stress_figure
from flangeway.report.fields import placed_stresses
from flangeway.report.files import picture_writers, print_files
from flangeway.report.outputs import NAMES as WHEELSET_NAMES
from flangeway.report.outputs import write_outputs
from flangeway.report.section_outputs import NAMES as SECTION_NAMES
from flangeway.report.section_outputs import SUMMARY as SECTION_SUMMARY
from flangeway.report.section_outputs import print_section, section_writers
from flangeway.report.series import solution_frame, write_collection
from flangeway.report.terminal import print_summary
from flangeway.study import CaseRun, refuse_unwritable, write_summary, write_together
from flangeway.study.bodies_run import BodiesRun, BodyResult
from flangeway.study.case import Case, Run
from flangeway.study.output import Writer
from flangeway.study.torsion_case import TorsionCase, TorsionRun
from flangeway.study.wheelset_case import WheelsetCase

SUMMARY, STRESSES, PRESSURE, COLLECTION = "summary.json", "stresses.png", "pressure.png", "bodies.pvd"


def check_case_folder(case: Case, folder: Path) -> None:
    """Refuse a folder that cannot take the files of a case; see `flangeway.study.refuse_unwritable`."""
    names: tuple[str, ...] = (SUMMARY, STRESSES, PRESSURE, COLLECTION)
    if isinstance(case, WheelsetCase):
        names = WHEELSET_NAMES
    elif isinstance(case, TorsionCase):
        names = (*SECTION_NAMES, SUMMARY)
    refuse_unwritable(folder, names)


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
        writers = section_writers(run.section)
        writers.pop(SECTION_SUMMARY)
    else:
        assert isinstance(run, BodiesRun)
        writers = _body_writers(run)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return write_together(folder, writers)


def _body_writers(run: BodiesRun) -> dict[str, Writer]:
    figures = {STRESSES: stress_figure(run)}
    if run.patches:
        figures[PRESSURE] = pressure_figure(run)
    writers = picture_writers(figures)
    names = {}
    for number, (name, body) in enumerate(run.bodies.items(), 1):
        # names are the user's and may not do as those of files
        plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name)
        names[name] = f"{number}-{plain}.vtu" if len(run.bodies) > 1 else f"{plain}.vtu"
        writers[names[name]] = partial(_write_body, body=body)
    if len(names) > 1:
        entries = [(0.0, name, file) for name, file in names.items()]
        writers[COLLECTION] = lambda path: write_collection(path, entries)
    return writers


def _write_body(path: Path, body: BodyResult) -> None:
    """Write a body at its first place; ``displacement_mm`` is its whole motion, stresses have the axes of space."""
    frame = solution_frame(body.field)
    points, data = frame.mesh.points, dict(frame.point_data)
    motion = body.moved(points, np.asarray(data.pop("displacement"), dtype=np.float64))
    at_corners = dict(frame.corner_data)
    write_vtu(
        path,
        frame.mesh,
        {"displacement_mm": motion, **_in_space(data, body)},
        frame.cell_data,
        _in_space(at_corners, body),
    )


def _in_space(arrays: dict[str, Any], body: BodyResult) -> dict[str, Any]:
    """Stress arrays turned with the body, with their unit."""
    if not arrays:
        return {}
    names = [f"stress_{name}" for name in ("xx", "yy", "xy", "zz")]
    stresses = Stresses(np.stack([arrays[name] for name in names], axis=1))
    components = placed_stresses(stresses, body.placement).components
    found = {f"{name}_MPa": components[:, i] for i, name in enumerate(names)}
    return {**found, "von_mises_MPa": arrays["von_mises"]}


def print_case(console: Console, run: Run, files: list[Path]) -> None:
    """Print what a run found, in a table, and the files."""
    if isinstance(run, CaseRun):
        print_summary(console, run.summary, files)
        return
    if isinstance(run, TorsionRun):
        print_section(console, run.summary, files)
        return
    summary = run.summary
    word, style = ("Converged", "bold green") if run.status.converged else ("NOT converged", "bold red")
    console.print(f"{run.case.name}: ", end="", markup=False)
    console.print(word, style=style, end="")
    console.print(f", {run.status.message}", markup=False, soft_wrap=True)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column(justify="right")
    for name, value in case_rows(summary):
        table.add_row(name, value)
    console.print(table)
    for notice in summary["notices"]:
        console.print(f"Note: {notice}", style="yellow", markup=False, soft_wrap=True)
    print_files(console, files, summary["timings_s"]["total"])


def case_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Names with units and values of what a case of bodies found, as shown."""
    rows = [(_spaced(key), _number(value)) for key, value in summary["results"].items() if key != "forces"]
    for each in summary["contacts"]:
        name = f"{each['secondary']} on {each['primary']}"
        rows.append((f"{name}: force on {each['secondary']} (x, y), N", _number(each["force_on_secondary_N"])))
        rows.append((f"{name}: largest pressure, MPa", _number(each["max_pressure_MPa"])))
        widths = ", ".join(_number(patch["half_width_mm"]) for patch in each["patches"])
        rows.append((f"{name}: half width of contact, mm", widths or "no contact"))
    for body in summary["bodies"]:
        rows.append((f"{body['name']}: largest displacement, mm", _number(body["max_displacement_mm"])))
        rows.append((f"{body['name']}: largest von Mises stress, MPa", _number(body["max_von_mises_MPa"])))
        rows.append((f"{body['name']}: cells, unknowns", f"{body['cells']}, {body['unknowns']}"))
    return rows


UNITS = {"_N_mm_per_mm": "N mm per mm", "_MPa": "MPa", "_mm": "mm", "_N": "N", "_rad": "rad", "_deg": "degrees"}


def _spaced(key: str) -> str:
    """A key as words, its unit behind a comma."""
    for ending, unit in UNITS.items():
        if key.endswith(ending):
            return f"{key[: -len(ending)].replace('_', ' ')}, {unit}"
    return key.replace("_", " ")


def _number(value: Any) -> str:
    if isinstance(value, list):
        return f"({', '.join(_number(each) for each in value)})"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
