"""What ``flangeway reproduce`` can compute, write and print, by name."""

from flangeway.report.chapters import contact_patch as contact_patch_chapter
from flangeway.report.chapters import elasticity as elasticity_chapter
from flangeway.report.chapters import hertz as hertz_chapter
from flangeway.report.chapters import torsion as torsion_chapter
from flangeway.report.chapters import wheel_rail as wheel_rail_chapter
from flangeway.report.reproductions import contact_patch, elasticity, hertz, torsion, wheel_rail
from flangeway.report.reproductions.reproduction import Reproduction, find_reproductions, print_verdicts
from flangeway.study.reproductions.contact_patch import reproduce_contact_patch
from flangeway.study.reproductions.elasticity import reproduce_elasticity
from flangeway.study.reproductions.hertz import reproduce_hertz
from flangeway.study.reproductions.torsion import reproduce_torsion
from flangeway.study.reproductions.wheel_rail import reproduce_wheel_rail

REPRODUCTIONS: dict[str, Reproduction] = {
    "torsion": Reproduction(
        reproduce_torsion, torsion.write, torsion.print_summary, torsion.FILES, torsion_chapter.CHAPTER, brief=True
    ),
    "elasticity": Reproduction(
        reproduce_elasticity, elasticity.write, elasticity.print_summary, elasticity.FILES, elasticity_chapter.CHAPTER,
        brief=True,
    ),
    "hertz": Reproduction(reproduce_hertz, hertz.write, hertz.print_summary, hertz.FILES, hertz_chapter.CHAPTER),
    "contact-patch": Reproduction(
        reproduce_contact_patch, contact_patch.write, contact_patch.print_summary, contact_patch.FILES,
        contact_patch_chapter.CHAPTER, brief=True,
    ),
    "wheel-rail": Reproduction(
        reproduce_wheel_rail, wheel_rail.write, wheel_rail.print_summary, wheel_rail.FILES, wheel_rail_chapter.CHAPTER
    ),
}  # fmt: skip
"""One line for each: how it is computed, written and printed, the names of its files, and its part of the page."""

__all__ = ["REPRODUCTIONS", "Reproduction", "find_reproductions", "print_verdicts"]
