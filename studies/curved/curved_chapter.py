"""Figure and chapter of curved edges."""

from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from flangeway.report.figures.drawing import INK, SERIES, new_figure
from flangeway.report.page.tables import SummaryTable
from studies.curved.curved_reproduced import (
    ELEMENTS,
    CurvedReproduction,
    error_rows,
    levels,
    pressure_rows,
    reproduce_curved,
)
from studies.published_numbers import digits
from studies.reproduction import Chapter, PagePicture, Reproduction

TITLES = {"Lamé": "Lamé's tube", "torsion": "ring in torsion", "Kirsch": "Kirsch's hole"}


def errors_figure(found: CurvedReproduction) -> Figure:
    """Draw the errors in energy of polygons over the number of cells across, on curved edges and on chords."""
    figure = new_figure(10.5, 4.2)
    for axes, (body, title) in zip(figure.subplots(1, 3), TITLES.items(), strict=True):
        for order, colour in enumerate(SERIES[:4], start=1):
            for bent, style in ((True, "o-"), (False, "s--")):
                errors = found.errors(body, f"V{order}", curved=bent)
                label = f"order {order}, {'curved edges' if bent else 'chords'}"
                cells = levels(body, ELEMENTS[f"V{order}"])
                axes.loglog(cells, errors, style, color=colour, ms=4, mfc="white", lw=1.2, label=label)
        axes.set_title(title, fontsize=10, color=INK)
        cells = levels(body, ELEMENTS["V2"])
        axes.set_xticks(cells, [str(n) for n in cells])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("cells across", fontsize=9)
        axes.grid(color="#e4e4e4", linewidth=0.5)
    figure.axes[0].set_ylabel("relative error in energy", fontsize=9)
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, fontsize=9
    )
    return figure


def _tables(found: CurvedReproduction) -> list[SummaryTable]:
    rows = [
        (row.element, digits(100.0 * (row.peak / 3.0 - 1.0), 2), str(row.n_unknowns))
        for row in found.rows
        if row.peak == row.peak and row.curved
    ]
    head = ("element", "error, %", "unknowns of one field")
    return [
        SummaryTable("Stress above Kirsch's hole on curved edges, mean of the cells at the point", head, tuple(rows)),
        _pressure_table(found),
    ]


def _pressure_table(found: CurvedReproduction) -> SummaryTable:
    of = {(row.order, row.level, row.curved): row for row in found.pressures}
    rows = []
    for order, level, curved in of:
        if curved:
            both = of[order, level, True], of[order, level, False]
            values = [*(row.difference for row in both), *(row.oscillation for row in both)]
            rows.append((f"V{order}", str(level), *(digits(100.0 * value, 2) for value in values)))
    head = ("element", "triangles to the half width", "difference, %", "on chords", "oscillation, %", "on chords")
    caption = "Pressure of a half disc on a block beside Hertz's, root mean square over the maximum, on curved edges"
    return SummaryTable(caption, head, tuple(rows))


CURVED = Reproduction(
    reproduce_curved,
    Chapter(
        "Curved edges: orders of convergence",
        """Lamé's tube under internal pressure, a ring in torsion (Prandtl's function, which is quadratic) and Kirsch's
        plate with a hole, with polygons of orders 1 to 4 (V) and isoparametric triangles of orders 2 and 3 (F), on
        curved edges and on chords. The error in energy must decrease with the order of the element on curved edges;
        what chords add to it (the root of the difference of both errors' squares) decreases with order 1.5. Quadratic
        triangles on the chords of a pressed or free boundary are an exception: the shear stress that the exact solution
        has on a chord is odd about its middle and does no work on a quadratic edge, so that they add order 2. Exact
        solutions: Lamé (1852), Kirsch (1898). The meshes of Kirsch's plate grow with the distance from the hole's
        centre. The mean stress of the cells above the hole must improve with every order of the polygons. A half disc
        is pressed onto a block, segment-to-segment with multipliers: on curved edges pressures must oscillate by less
        than half of what they do on chords, whose corners press into the block. On the finest meshes 0.3 % are left,
        which stay with twice as many elements: Hertz's bodies are half spaces.""",
        (
            PagePicture(
                "curved-errors",
                "Relative errors in energy over the cells across for three bodies: on curved edges lines are as steep "
                "as the order of the polygons, on chords orders above 2 are on lines of slope 1.5",
                errors_figure,
            ),
        ),
        _tables,
    ),
    {"errors.png": errors_figure},
    {"errors.csv": error_rows, "pressures.csv": pressure_rows},
    brief=True,
)
