"""Torsion on the page of validation."""

from flangeway.validation.published_numbers import percent
from flangeway.validation.torsion.torsion_figures import convergence_figure
from flangeway.validation.torsion.torsion_reproduced import (
    LEAST_WITHIN,
    LIMITS,
    MAX_RATE_DIFFERENCE,
    TorsionReproduction,
)
from flangeway.validation.validation_page import Chapter, PagePicture
from flangeway.validation.validation_tables import PageTable


def _tables(found: TorsionReproduction) -> list[PageTable]:
    """Rates of convergence, if there are."""
    rows = tuple(
        (
            f"Table {rate.table}",
            rate.code,
            f"{rate.expected}",
            f"{rate.published:.2f}",
            f"{rate.computed:.2f}",
            "yes" if rate.within else "**no**",
        )
        for rate in found.rates
    )
    caption = (
        "Rates of convergence over the root of the number of unknowns, twice the order in theory; within are those "
        f"that differ from the published ones by {MAX_RATE_DIFFERENCE:g} at most"
    )
    return [PageTable(caption, ("table", "code", "theory", "published", "computed", "within"), rows)] if rows else []


CHAPTER = Chapter(
    "Torsion of a square and a triangle",
    f"""Torsion constants of a square and of an equilateral triangle of area one, on the meshes of Moherdaui's Table 3:
    Tables 4 and 5 by the warping function (pages 136 and 137), Tables 6 and 7 by Prandtl's function (pages 138 and
    139). What counts is the relative error of the constant, against the exact one: it must be the published one to
    {percent(LIMITS["relative_error"])}, in {100.0 * LEAST_WITHIN:.0f} % of the rows at least, because the published
    meshes are known by their numbers of unknowns alone. Codes such as VVSM3O2: F or V, finite or virtual elements; D
    or V, triangles or polygons; S or T, square or triangle; the mesh; the order.""",
    (
        PagePicture(
            "torsion",
            "Error of the torsion constant over the number of unknowns for Tables 4 to 7, published and computed: the "
            "computed marks lie in the published ones, and fall along lines of the slopes 1 and 2",
            lambda found: convergence_figure(found, "n_dof"),
        ),
    ),
    _tables,
)
