"""Figures and chapter of the reproduced torsion tables: convergence over h and unknowns, both functions."""

from collections.abc import Sequence
from functools import partial
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flangeway.report.figures.drawing import GREY, INK, ColourSteps, draw_field, draw_outline, new_figure
from flangeway.report.page.tables import SummaryTable
from studies.published_numbers import percent
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.torsion.torsion_reproduced import (
    LEAST_WITHIN,
    LIMITS,
    MAX_RATE_DIFFERENCE,
    TorsionReproduction,
    TorsionRow,
    published_reading,
    rate_rows,
    reproduce_torsion,
    torsion_section,
)

Over = Literal["h", "n_dof"]

TITLES = {
    4: "Square, warping function (Table 4)",
    5: "Triangle, warping function (Table 5)",
    6: "Square, Prandtl's function (Table 6)",
    7: "Triangle, Prandtl's function (Table 7)",
}
METHODS = {
    "FD": ("Lagrange triangles", "^", "solid"),
    "VD": ("virtual triangles", "s", (0, (6, 2))),
    "VV": ("virtual polygons", "o", (0, (2, 1.5))),
}
"""Name, marker and line by the first two letters of a code, to be distinguished in grey too."""


def convergence_figure(found: TorsionReproduction, over: Over) -> Figure:
    """Draw the error of the torsion constant over h or over unknowns, published and computed, table by table."""
    figure = new_figure(10.0, 9.2)
    for axes, table in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, TITLES, strict=True):
        _draw_table(axes, found, table, over)
    handles = [
        *(Line2D([], [], color=INK, marker=mark, ls=line, ms=6, label=name) for name, mark, line in METHODS.values()),
        Line2D([], [], color=INK, marker="D", ls="none", ms=6, label="computed"),
        Line2D([], [], color=GREY, marker="D", mfc="white", ls="none", ms=9, label="published"),
        Line2D([], [], color=GREY, marker="o", mfc=GREY, ls="dotted", ms=5, label="polygons, projected load (3.81)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return figure


def fields_figure(found: TorsionReproduction, formulation: Literal["warping", "prandtl"]) -> Figure:
    """Draw the function on both sections, by triangles and by polygons of order 2, with the exact one beside it."""
    figure = new_figure(10.5, 6.6)
    level = max(row.code.level for row in found.computed if row.code.level <= 3)
    rows = figure.subplots(2, 3)
    for section, line in zip("ST", rows, strict=True):
        pair = [_row(found.computed, f"{kind}{section}M{level}O2", formulation) for kind in ("FD", "VV")]
        exact = torsion_section(pair[0].code.section)[1]
        finest = pair[0].solution.problem.space.mesh
        given = exact.warping(finest.points) if formulation == "warping" else exact.stress_function(finest.points)
        shown = [(str(row.code), row.solution.problem.space.mesh, _values(row)) for row in pair]
        shown.append(("exact", finest, given))
        shades = ColourSteps(np.concatenate([values for _, _, values in shown]))
        for axes, (name, mesh, values) in zip(line, shown, strict=True):
            draw_field(axes, mesh, values, shades)
            draw_outline(axes, mesh)
            axes.set_aspect("equal")
            axes.set_title(name, fontsize=10)
            axes.set_xlabel("x / √area", fontsize=8)
            axes.tick_params(labelsize=8)
        line[0].set_ylabel("y / √area", fontsize=8)
        label = "warping / (θ′ area)" if formulation == "warping" else "Prandtl's function / (Gθ′ area)"
        bar = figure.colorbar(shades.mappable(), ax=line.tolist(), label=label, ticks=shades.levels.tolist())
        bar.ax.tick_params(labelsize=8)
    return figure


def _values(row: TorsionRow) -> np.ndarray:
    return row.solution.function[: row.solution.problem.space.mesh.n_points]


def _row(rows: Sequence[TorsionRow], code: str, formulation: str) -> TorsionRow:
    return next(row for row in rows if str(row.code) == code and row.formulation == formulation)


def _draw_table(axes: Axes, found: TorsionReproduction, table: int, over: Over) -> None:
    for kind, (_, marker, line) in METHODS.items():
        for order in (1, 2):
            group = [
                (row, published)
                for row, published in zip(found.computed, found.published, strict=True)
                if row.table == table and str(row.code)[:2] == kind and row.code.order == order
            ]
            main = [(row, published) for row, published in group if published_reading(row)]
            other = [row for row, _ in group if not published_reading(row)]
            axes.plot(
                [published[over] for _, published in main], [published["relative_error"] for _, published in main],
                color=GREY, marker=marker, mfc="white", ls="none", ms=9,
            )  # fmt: skip
            axes.plot(*_curve([row for row, _ in main], over), color=INK, marker=marker, ls=line, lw=1.0, ms=4)
            axes.plot(*_curve(other, over), color=GREY, marker=marker, ls="dotted", lw=1.0, ms=4)
    axes.set(xscale="log", yscale="log")
    axes.grid(which="both", color="#e4e4e4", linewidth=0.5)
    axes.set_title(TITLES[table], fontsize=10)
    axes.set(
        xlabel="maximum element diameter h" if over == "h" else "number of unknowns",
        ylabel="relative error of the torsion constant",
    )
    axes.label_outer()
    _draw_slopes(axes, over)


def _curve(rows: Sequence[TorsionRow], over: Over) -> tuple[list[float], list[float]]:
    sizes = [r.size if over == "h" else float(r.n_dofs if r.formulation == "warping" else r.n_free) for r in rows]
    return sizes, [abs(row.relative_error) for row in rows]


def _draw_slopes(axes: Axes, over: Over) -> None:
    """Draw reference lines of the rates 2 and 4."""
    start, factor = (0.05, 2.0) if over == "h" else (1500.0, 3.0)
    for order, error in ((1, 5e-4), (2, 1.2e-8)):
        rate = 2.0 * order if over == "h" else -float(order)
        x = np.array([start, start * factor])
        axes.plot(x, error * (x / start) ** rate, color=INK, lw=0.8)
        text = f"h{'²' if order == 1 else '⁴'}" if over == "h" else f"1/n{'' if order == 1 else '²'}"
        axes.annotate(text, (x[1], error * factor**rate), textcoords="offset points", xytext=(4, -4), fontsize=8)


def _tables(found: TorsionReproduction) -> list[SummaryTable]:
    """Rates of convergence, if all refinements were computed."""
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
        "Rates of convergence over the square root of the number of unknowns; the theoretical rate is twice the order. "
        f"Limit: a difference of {MAX_RATE_DIFFERENCE:g} from the published rate"
    )
    return [SummaryTable(caption, ("table", "code", "theory", "published", "computed", "within"), rows)] if rows else []


TORSION = Reproduction(
    reproduce_torsion,
    Chapter(
        "Torsion of a square and a triangle",
        f"""Torsion constants of a square and of an equilateral triangle of area one, on the meshes of Moherdaui's
        Table 3: Tables 4 and 5 by the warping function (pages 136 and 137), Tables 6 and 7 by Prandtl's function (pages
        138 and 139). The relative error of the constant against the exact one must be the published one to
        {percent(LIMITS["relative_error"])}, in at least {100.0 * LEAST_WITHIN:.0f} % of the rows, because only the
        numbers of unknowns of the published meshes are known. Codes such as VVSM3O2: F or V, finite or virtual
        elements; D or V, triangles or polygons; S or T, square or triangle; the mesh; the order.""",
        (
            PagePicture(
                "torsion",
                "Error of the torsion constant over the number of unknowns for Tables 4 to 7, published and computed: "
                "the computed marks lie in the published ones, and fall along lines of the slopes 1 and 2",
                partial(convergence_figure, over="n_dof"),
            ),
        ),
        _tables,
    ),
    {
        "convergence_h.png": partial(convergence_figure, over="h"),
        "convergence_unknowns.png": partial(convergence_figure, over="n_dof"),
        "warping.png": partial(fields_figure, formulation="warping"),
        "prandtl.png": partial(fields_figure, formulation="prandtl"),
    },
    {"rates.csv": rate_rows},
    brief=True,
)
