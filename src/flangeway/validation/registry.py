"""What ``flangeway reproduce`` can compute, write and print, by name."""

from flangeway.validation.contact_patch import contact_patch_chapter
from flangeway.validation.contact_patch import contact_patch_files as contact_patch
from flangeway.validation.contact_patch.contact_patch_reproduced import reproduce_contact_patch
from flangeway.validation.elasticity import elasticity_chapter
from flangeway.validation.elasticity import elasticity_files as elasticity
from flangeway.validation.elasticity.elasticity_reproduced import reproduce_elasticity
from flangeway.validation.hertz import hertz_chapter
from flangeway.validation.hertz import hertz_files as hertz
from flangeway.validation.hertz.hertz_reproduced import reproduce_hertz
from flangeway.validation.reproduction import Reproduction, find_reproductions, print_verdicts
from flangeway.validation.torsion import torsion_chapter
from flangeway.validation.torsion import torsion_files as torsion
from flangeway.validation.torsion.torsion_reproduced import reproduce_torsion
from flangeway.validation.wheel_rail import wheel_rail_chapter
from flangeway.validation.wheel_rail import wheel_rail_files as wheel_rail
from flangeway.validation.wheel_rail.wheel_rail_reproduced import reproduce_wheel_rail

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
