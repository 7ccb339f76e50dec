"""The contact patch test on the page of validation."""

from flangeway.validation.contact_patch.contact_patch_figures import comparison_figure, pressures_figure
from flangeway.validation.contact_patch.contact_patch_reproduced import (
    LAWS,
    OFF,
    PASSED,
    PUBLISHED,
    SAME_STRESS,
    ContactPatchReproduction,
    PatchRun,
)
from flangeway.validation.published_numbers import percent
from flangeway.validation.validation_page import Chapter, PagePicture
from flangeway.validation.validation_tables import PageTable, digits, share


def _tables(found: ContactPatchReproduction) -> list[PageTable]:
    """How far node-to-segment is off, and in how many cases segment-to-segment passes, by elements."""
    off = tuple((run.code, share(run.stress_error), share(run.stress_oscillation)) for run in found.published)
    kinds: dict[str, list[PatchRun]] = {}
    for run in found.proper:
        kinds.setdefault(run.code.partition(" M")[0], []).append(run)
    return [
        PageTable(
            "Node-to-segment: maximum difference of a stress from the uniform one, and root of the mean square over "
            "both boxes. Moherdaui (2021) says of its pictures that oscillations are less on finer meshes and for "
            "polygons; in the mean square they are",
            ("code", "maximum", "mean square"),
            off,
        ),
        PageTable(
            f"Segment-to-segment: in how many cases pressures and stresses are uniform to {digits(PASSED, 1)}. Cases "
            "are meshes, matching and not, turned by 30 degrees, with standard and dual weights",
            ("elements above on below", *LAWS),
            tuple((kind, *(_passing(runs, law) for law in LAWS)) for kind, runs in kinds.items()),
        ),
    ]


def _passing(runs: list[PatchRun], law: str) -> str:
    mine = [run.passes for run in runs if run.law == law]
    counted = f"{sum(mine)} of {len(mine)}"
    return counted if all(mine) else f"**{counted}**"


CHAPTER = Chapter(
    "Contact patch test",
    f"""Two boxes pressed together must have one uniform stress: {PUBLISHED:g} kN/cm² by Moherdaui's equation (6.1),
    section 6.2.1. Its node-to-segment results fail the test, in pictures without numbers (Figures 70 to 75, pages 165
    to 170): in no case is the stress exact. The same must come out here: a mean stress within {percent(SAME_STRESS)},
    and stresses that are off by more than {percent(OFF)}. Segment-to-segment contact passes the test, and must do so
    in every case. Codes such as VPTM3O2: F or V, finite or virtual elements; the mesh; the order.""",
    (
        PagePicture(
            "contact-patch-pressures",
            "Pressures over the interface by node-to-segment contact for four kinds of elements: they oscillate about "
            "the uniform pressure, which segment-to-segment contact meets",
            pressures_figure,
        ),
        PagePicture(
            "contact-patch-stresses",
            "Vertical stresses in both boxes for four kinds of elements: uneven above with node-to-segment contact, "
            "uniform below with segment-to-segment contact",
            comparison_figure,
        ),
    ),
    _tables,
)
