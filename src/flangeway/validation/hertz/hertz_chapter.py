"""Hertz's problem on the page of validation."""

from flangeway.validation.hertz.hertz_figures import pressure_figure
from flangeway.validation.hertz.hertz_reproduced import (
    FINE,
    FORCE_LIMITS,
    REFERENCE_FORCE,
    STRESS_LIMIT,
    VARIANTS,
    HertzReproduction,
)
from flangeway.validation.published_numbers import percent
from flangeway.validation.validation_page import Chapter, PagePicture
from flangeway.validation.validation_tables import PageTable, digits, share


def _tables(found: HertzReproduction) -> list[PageTable]:
    """Oscillation of the pressures on the finest mesh."""
    finest = max(row.level for row in found.rows)
    rows = tuple(
        (
            VARIANTS[row.variant],
            row.name,
            f"{row.n_unknowns}",
            digits(row.force),
            share(row.pressure.oscillation),
            share(row.pressure_difference),
        )
        for row in found.rows
        if row.level == finest
    )
    caption = (
        f"Pressures on M{finest} against Hertz's of the same force, over its maximum pressure: oscillation (root of "
        "the mean square) and maximum difference without the element at each end of the contact"
    )
    return [PageTable(caption, ("contact", "code", "unknowns", "force (kN)", "oscillation", "difference"), rows)]


CHAPTER = Chapter(
    "Hertz's problem",
    f"""Two half discs pressed together: Moherdaui's section 6.2.2 with Tables 9 to 14 (pages 162 to 179). Its reference
    force of {REFERENCE_FORCE} kN (Table 11) must be met to {percent(FORCE_LIMITS[1])}, by order 2 from M{FINE} on to
    {percent(FORCE_LIMITS[2])}, with the penalty as Table 10 prints it. Extreme stresses of Tables 12 to 14 come out
    with that penalty halved at each refinement: those of polygons, VVO1 and VVO2, must be met to
    {percent(STRESS_LIMIT)}; the others are single values of elements that oscillate, and are shown only. In the rows
    "Hertz", segment-to-segment contact with multipliers is compared with Hertz's theory (1882), from M{FINE} on with
    limits: there the oscillations of the published pictures are gone. Codes such as VVO2M3: F, V or H, finite
    elements, virtual ones, or virtual ones at the arc alone; D, V or E, triangles, polygons or refined edges; the
    order; the mesh.""",
    (
        PagePicture(
            "hertz-node-to-segment",
            "Pressures of node-to-segment contact for six kinds of elements beside Hertz's curve: they oscillate, most "
            "for triangles and for virtual triangles of order 2",
            lambda found: pressure_figure(found, "halved"),
        ),
        PagePicture(
            "hertz-segment-to-segment",
            "Pressures of segment-to-segment contact for four kinds of elements of order 2: they lie on Hertz's curve",
            lambda found: pressure_figure(found, "segments"),
        ),
    ),
    _tables,
)
