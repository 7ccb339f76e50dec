"""Figure and chapter of node-to-node contact with inserted nodes."""

import numpy as np
from matplotlib.figure import Figure

from flangeway.report.figures.drawing import INK, SERIES, new_figure
from flangeway.report.page.tables import SummaryTable
from studies.published_numbers import digits, share
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.vem_contact.vem_contact_reproduced import (
    PAIRINGS,
    RMS_LIMITS,
    SHORT_LEVEL,
    VemContactReproduction,
    hertz_rows,
    reproduce_vem_contact,
)

MARKS = ("v", "s", "o")
CASES = {f"VVO1M{SHORT_LEVEL}": "polygons of order 1", f"VVO2M{SHORT_LEVEL}": "polygons of order 2"}


def pressures_figure(found: VemContactReproduction) -> Figure:
    """Draw the pressures of polygons of order 1 and 2 by each pairing beside Hertz's."""
    figure = new_figure(10.5, 4.4)
    for axes, (code, title) in zip(figure.subplots(1, 2, sharey=True), CASES.items(), strict=True):
        for pairing, mark, colour in zip(PAIRINGS, MARKS, SERIES[: len(MARKS)], strict=True):
            (row,) = (each for each in found.rows if (each.code, each.pairing) == (code, pairing))
            axes.plot(row.x, row.pressures, mark, color=colour, ms=3.5, mfc="white", label=pairing)
        x = np.linspace(-1.05, 1.05, 400) * row.theory.half_width
        axes.plot(x, row.theory.pressure(x), color=INK, lw=1.2, label="Hertz")
        axes.set_title(title, fontsize=10, color=INK)
        axes.set_xlabel("position, cm", fontsize=9)
        axes.grid(color="#e4e4e4", linewidth=0.5)
    figure.axes[0].set_ylabel("pressure, kN/cm$^2$", fontsize=9)
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, fontsize=9
    )
    return figure


def _tables(found: VemContactReproduction) -> list[SummaryTable]:
    head = ("elements and mesh", "pairing", "unknowns", "constraints", "maximum pressure", "rms error", "oscillation")
    rows = [
        (
            row.code, row.pairing, str(row.n_unknowns), str(row.n_constraints), share(row.peak - 1.0), share(row.rms),
            share(row.oscillation),
        )
        for row in found.rows
    ]  # fmt: skip
    short = [
        (
            row.code,
            f"{row.ratio:g}" if row.ratio else "none",
            str(row.n_constraints),
            digits(row.force, 5),
            share(row.rms),
        )
        for row in found.short
    ]
    return [
        SummaryTable(
            "Hertz's problem by three pairings, all else equal: difference of the maximum pressure from Hertz's, root "
            "mean square difference over p0, and change of the pressure from node to node",
            head,
            tuple(rows),
        ),
        SummaryTable(
            "Node-to-node with short edges, by their lengths over those beside them",
            ("elements and mesh", "short edges", "constraints", "force, kN", "rms error"),
            tuple(short),
        ),
    ]


VEM_CONTACT = Reproduction(
    reproduce_vem_contact,
    Chapter(
        "Node-to-node contact with inserted nodes",
        f"""Two boundaries in contact get each other's nodes, and nodes opposite each other are paired. The contact
        patch test of blocks with different meshes (Moherdaui 2021, 6.2.1) must be exact to round-off for
        polygons of orders 1 and 2 with every enforcement, rotated too. Hertz's problem on the published meshes
        (6.2.2) is computed with multipliers between the circles by three pairings and the same elements:
        node-to-segment, segment-to-segment (dual weights) and node-to-node. The root mean square error of the
        pressure must be smaller node-to-node than node-to-segment on every mesh, and on M2 and M3 at most
        {100.0 * RMS_LIMITS[2]:g} % of p0 at order 2. Edges down to a millionth of those beside them, one at
        every edge of the upper disc, must not change the force, and the error by less than a third. The limits
        were chosen after the first computation. Times are in hertz.csv.""",
        (
            PagePicture(
                "vem-contact-pressures",
                "Pressures of Hertz's problem on polygons of order 1 and 2: node-to-segment contact oscillates, "
                "segment-to-segment and node-to-node contact with inserted nodes lie on Hertz's curve at order 2",
                pressures_figure,
            ),
        ),
        _tables,
    ),
    {"pressures.png": pressures_figure},
    {"hertz.csv": hertz_rows},
    brief=True,
)
