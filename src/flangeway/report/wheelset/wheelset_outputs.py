"""All files of a run of a wheelset, except ``summary.json``."""

from collections.abc import Callable
from functools import partial

from flangeway.cases import CaseRun
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.drawing import png
from flangeway.report.figures.fields import PartFields, part_fields, write_part
from flangeway.report.figures.newton_history import convergence_figure
from flangeway.report.figures.series import write_collection
from flangeway.report.page.html_page import Picture, report_page
from flangeway.report.wheelset.bending_figure import bending_figure
from flangeway.report.wheelset.contact_figure import contact_figure, pressure_figure
from flangeway.report.wheelset.rigid_elastic_figure import rigid_elastic_figure
from flangeway.report.wheelset.subsurface_figure import (
    SubsurfaceLine,
    subsurface_figure,
    subsurface_lines,
    subsurface_table,
)
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.report.wheelset.wheelset_page import wheelset_page
from flangeway.system.output_folder import Writer, bytes_writer, text_writer

PARTS = ("wheel-left", "rail-left", "wheel-right", "rail-right")
REPORT, COLLECTION, SUBSURFACE = "report.html", "wheelset.pvd", "subsurface.csv"
PICTURES = (
    "wheelset.png", "rigid-and-elastic.png", "stresses-left.png", "stresses-right.png", "pressure.png",
    "convergence.png", "subsurface.png", "bending.png",
)  # fmt: skip
NAMES = (*(f"{part}.vtu" for part in PARTS), COLLECTION, *PICTURES, SUBSURFACE, REPORT)


def wheelset_writers(run: CaseRun, progress: Callable[[str], None]) -> dict[str, Writer]:
    """Return functions that write pictures, fields, stresses below the contacts and report, by the files' names."""
    progress("drawing the pictures")
    fields = list(part_fields(run.result))
    below = subsurface_lines(run.result)
    pictures = _pictures(run, fields, below)
    progress("writing the files")
    writers: dict[str, Writer] = {f"{part.name}.vtu": partial(write_part, fields=part) for part in fields}
    vtu_files = [(0.0, part, f"{part}.vtu") for part in PARTS]
    writers[COLLECTION] = lambda path: write_collection(path, vtu_files)
    writers |= {name: bytes_writer(picture.png) for name, picture in zip(PICTURES, pictures, strict=True)}
    writers[SUBSURFACE] = text_writer(subsurface_table(below))
    writers[REPORT] = text_writer(report_page(wheelset_page(run, pictures, fields)))
    return writers


def _pictures(run: CaseRun, fields: list[PartFields], below: list[SubsurfaceLine]) -> list[Picture]:
    """Return all pictures in the order of `PICTURES`."""
    return [
        Picture(
            png(wheelset_figure(run, fields)),
            "Left and right wheel on their rails, deformed and coloured by von Mises stress, with a sketch of the "
            "wheelset, its load and its dimensions between them.",
            "The wheelset on its rails: von Mises stress on the deformed parts. Dark is most loaded; numbers on the "
            "lines are MPa. Web and foot of the rails are hatched: their stresses are those of a slice that carries "
            "the load alone and are not valid for a rail.",
        ),
        Picture(
            png(rigid_elastic_figure(run, fields)),
            "Outlines of the elastic wheels and rails in equilibrium over those of the rigid ones, with contact points "
            "and forces of both, whole heads above and the contact zones enlarged below.",
            "Elastic and rigid equilibrium positions, true to scale.",
        ),
        *(
            Picture(
                png(contact_figure(run, fields, side)),
                f"The contact zones of the {side} side, deformed, with the mesh, coloured by von Mises stress, by the "
                "minimum principal stress with the contact forces on the wheel as arrows, and by the maximum in-plane "
                "shear stress.",
                f"Contact zones of the {side} side, deformed: von Mises stress, minimum principal stress and maximum "
                "in-plane shear stress of each element. Both sides have the same colours.",
            )
            for side in SIDES
        ),
        Picture(
            png(pressure_figure(run)),
            "Contact pressure along the surface of both sides: nodes of the mesh and Hertz's ellipse.",
            "Contact pressure along the surface: nodal forces over their areas, and Hertz's theory for the same force "
            "and the profiles' radii at the contact, where the profiles are not conforming.",
        ),
        Picture(
            png(convergence_figure(run)),
            "Relative residuals of the equilibrium over the iterations, on a logarithmic axis.",
            "Convergence: residuals of forces and moment at each position of the wheelset in the iteration.",
        ),
        Picture(
            png(subsurface_figure(below)),
            "Stresses in rail and wheel over the depth below each contact, solid, and those of Hertz's line contact, "
            "dashed.",
            "Stresses along the inward normal through each centre of pressure, and those of Hertz's theory in half "
            "planes; in the head of a rail and in a rim the force spreads less, and the stresses fall more slowly.",
        ),
        Picture(
            png(bending_figure(run, fields)),
            "Sections of both rails with the stresses along their free surface as ordinates, and their deformed "
            "outlines dashed.",
            "Bending of the rails, held along their bases: stresses along the surface of web and fillets in MPa, and "
            "the deformed outlines. The stresses are those of the slice: compare runs with each other, not with a rail "
            "in track.",
        ),
    ]
