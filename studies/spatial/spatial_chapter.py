"""Figures and chapter of bodies in three dimensions."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.report.page.tables import SummaryTable
from studies.published_numbers import digits, percent
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.spatial.cosine_loads import ELEMENTS
from studies.spatial.patches import BLOCK_LIMIT, LIMITS
from studies.spatial.point_loads import BEAM_LIMIT, SQUARE_LIMIT, STIFFNESS_LIMIT
from studies.spatial.spatial_reproduced import (
    SpatialReproduction,
    bar_table,
    rail_table,
    reproduce_spatial,
)

MARKS = dict(zip(ELEMENTS, (("^", "solid"), ("s", "dotted"), ("o", "dashed"), ("D", "dashdot")), strict=True))
SHOWN = (1.0, 5.0, 40.0)
"""Radius times wavenumber of the bars in the figure."""


def bar_figure(found: SpatialReproduction) -> Figure:
    """Draw the error of the bar's displacements over the number of sides."""
    figure = new_figure(10.5, 4.2)
    for axes, ka in zip(figure.subplots(1, len(SHOWN), sharey=True), SHOWN, strict=True):
        for element, (marker, line) in MARKS.items():
            rows = [row for row in found.bars if row.element == element and row.ka == ka]
            sides, errors = [row.n_sides for row in rows], [row.error for row in rows]
            axes.loglog(sides, errors, color=INK, marker=marker, ls=line, ms=4.5, lw=1.0, label=element)
        axes.axhline(1e-5, color=GREY, lw=0.8, ls="dotted")
        ticks = sorted({row.n_sides for row in found.bars if row.ka == ka})
        axes.set_xticks(ticks, [f"{each}" for each in ticks])
        axes.set_xticks([], minor=True)
        axes.grid(which="major", color="#e4e4e4", linewidth=0.5)
        axes.set_title(f"ka = {ka:g}", fontsize=10)
        axes.set_xlabel("sides of the polygon")
        axes.label_outer()
    figure.axes[0].set_ylabel("error over the exact displacement")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


def patches_figure(found: SpatialReproduction) -> Figure:
    """Draw the pressures of all contacts, with Hertz's ellipses."""
    figure = new_figure(10.5, 5.6)
    every = list(figure.subplots(2, 3).flat)
    for axes, each in zip(every, found.hertz, strict=False):
        _draw_patch(axes, each.found, each.code.replace("_", " "))
        width, height = (2.0 * axis for axis in each.exact.semi_axes[::-1])
        axes.add_patch(Ellipse((0.0, 0.0), width, height, fill=False, ec=INK, lw=1.2))
    _draw_patch(every[len(found.hertz)], found.block, "conforming blocks")
    for axes in every[len(found.hertz) + 1 :]:
        axes.set_axis_off()
    mappable = ScalarMappable(Normalize(0.0, 1.0), COLOURS)
    figure.colorbar(mappable, ax=every, label="pressure over its maximum", shrink=0.7)
    return figure


def _draw_patch(axes: Axes, contact: PatchContact, title: str) -> None:
    grid = contact.pair.grid
    across = grid.bounds - float((grid.bounds[0] + grid.bounds[-1]) / 2.0)
    along = grid.middle + grid.strip * (np.arange(grid.n_strips + 1) - grid.n_strips / 2.0)
    pressures = contact.pressures / contact.pressures.max()
    axes.pcolormesh(along, across, np.where(pressures > 0.0, pressures, np.nan), cmap=COLOURS, vmin=0.0, vmax=1.0)
    axes.set_aspect("equal")
    axes.set_xlabel("z in mm", fontsize=8)
    axes.set_ylabel("across in mm", fontsize=8, labelpad=0.0)
    axes.set_title(f"{title}: {contact.pressures.max():.0f} MPa", fontsize=10)
    axes.tick_params(labelsize=8)


def _tables(found: SpatialReproduction) -> Sequence[SummaryTable]:
    """The rail's deflections."""
    rows = tuple(
        (
            f"{row.foundation:g}",
            f"{abs(row.eccentricity):.1f}",
            *(digits(1e6 * value) for value in (row.deflection, row.beam_deflection, row.shear_deflection)),
            *(digits(value) for value in (row.moment, row.beam_moment)),
        )
        for row in found.rails
    )
    head = ("foundation, N/mm2", "eccentricity, mm", "deflection, nm/N", "beam", "with shear", "moment, mm", "beam")
    return [SummaryTable("136RE rail on a continuous foundation below a force of 1 N, beside beams", head, rows)]


SPATIAL = Reproduction(
    reproduce_spatial,
    Chapter(
        "Three dimensions from plane meshes",
        f"""Prisms and bodies of revolution at one wavenumber, and their sums. A round bar under a cosine pressure
        beside Love's stress function (best mesh to 0.001 %, rates of convergence), also as a body of revolution; a disc
        under two opposite forces beside Hertz (1883); a loaded square on a half-space beside Love (1929) and CONTACT
        ({percent(SQUARE_LIMIT)}); a rail on a foundation beside beams ({percent(BEAM_LIMIT)}), and its answer to long
        waves beside EA, EI and GJ of its section ({percent(STIFFNESS_LIMIT)}). Contact patches of crossed cylinders
        beside Hertz: semi-axes to {percent(LIMITS["a_mm"])}, maximum pressure to {percent(LIMITS["p0_MPa"])}, approach,
        less what the finite blocks add, to {percent(LIMITS["approach_mm"])}. A rail in a wheel of nearly its radius
        beside CONTACT (example conformal), and two conforming blocks beside C3D20 of CalculiX
        ({percent(BLOCK_LIMIT)}).""",
        (
            PagePicture(
                "spatial-bar",
                "Error of the displacements of a bar under a cosine pressure over the sides of its polygon for three "
                "wavenumbers: each element falls at its rate, virtual elements of order 3 below 1e-5",
                bar_figure,
            ),
            PagePicture(
                "spatial-patches",
                "Pressures of five contact patches from above: those of four pairs of crossed cylinders fill the "
                "ellipses of Hertz, that of the conforming blocks is longer across",
                patches_figure,
            ),
        ),
        _tables,
    ),
    {"bar_convergence.png": bar_figure, "patches.png": patches_figure},
    {"bar.csv": bar_table, "rail.csv": rail_table},
)
