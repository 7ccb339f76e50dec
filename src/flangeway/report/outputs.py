"""All files that a run leaves, by name."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from flangeway.report.contact_figure import contact_figure
from flangeway.report.drawing import png
from flangeway.report.fields import PartFields, part_fields
from flangeway.report.files import bytes_writer
from flangeway.report.html import Picture, report_page
from flangeway.report.paraview import write_part
from flangeway.report.pressure_figure import pressure_figure
from flangeway.report.series import write_collection
from flangeway.report.wheelset_figure import wheelset_figure
from flangeway.study import CaseRun, refuse_unwritable, write_summary, write_together

PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
SUMMARY, REPORT, PICTURE, COLLECTION = "summary.json", "report.html", "wheelset.png", "wheelset.pvd"
NAMES = (*(f"{part}.vtu" for part in PARTS), COLLECTION, PICTURE, REPORT, SUMMARY)


def check_folder(folder: Path) -> None:
    """Refuse a folder that cannot take the files of a run; see `flangeway.study.refuse_unwritable`."""
    refuse_unwritable(folder, NAMES)


def write_outputs(run: CaseRun, folder: Path, progress: Callable[[str], None] = lambda _: None) -> list[Path]:
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
    progress("drawing the pictures")
    fields = list(part_fields(run.result))
    pictures = _pictures(run, fields)
    progress("writing the files")
    writers: dict[str, Callable[[Path], None]] = {
        f"{part.name}.vtu": partial(write_part, fields=part) for part in fields
    }
    vtu_files = [(0.0, part, f"{part}.vtu") for part in PARTS]
    page = report_page(run, pictures)
    writers[COLLECTION] = lambda path: write_collection(path, vtu_files)
    writers[PICTURE] = bytes_writer(pictures[0].png)
    writers[REPORT] = lambda path: _write_text(path, page)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    return write_together(folder, writers)


def _pictures(run: CaseRun, fields: list[PartFields]) -> list[Picture]:
    return [
        Picture(
            png(wheelset_figure(run, fields)),
            "Left and right wheel on their rails, deformed and coloured by von Mises stress, with a sketch of the "
            "wheelset, its load and its dimensions between them.",
            "The wheelset on its rails: von Mises stress on the deformed parts. Dark is most loaded; numbers on the "
            "lines are MPa.",
        ),
        Picture(
            png(contact_figure(run, fields)),
            "The zones about both contacts, coloured by the minimum principal stress, with the contact forces on the "
            "wheels as arrows.",
            "The contact zones in true shape: minimum principal stress, and the contact forces on the wheels.",
        ),
        Picture(
            png(pressure_figure(run)),
            "Contact pressure along the surface of both sides: nodes of the mesh and Hertz's ellipse.",
            "Contact pressure along the surface: the nodes' forces over their areas, and Hertz's theory for the same "
            "force and the profiles' radii at the contact.",
        ),
    ]


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
