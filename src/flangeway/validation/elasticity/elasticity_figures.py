"""Pictures of the patch test and of Cook's membrane: meshes, stresses, convergence, nearly incompressible material."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.tri import Triangulation

from flangeway.cases.bodies.cook import CookRow
from flangeway.report.figures.display import display, displayed_stresses
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS, plot_mesh, plot_stress
from flangeway.solve import ElasticitySolution
from flangeway.validation.elasticity.elasticity_reproduced import ElasticityReproduction
from flangeway.validation.elasticity.patch_test import PatchRow
from flangeway.validation.published_numbers import published_rows

METHODS = {
    "F": ("Lagrange triangles", "^", "solid"),
    "V": ("virtual polygons", "o", (0, (2, 1.5))),
    "H": ("triangles, virtual at the boundary", "s", (0, (6, 2))),
}
"""Name, marker and line by the first letter of a code: they stay apart in grey."""

PATCH_SHOWN = ("FDPTO1", "VVPTO1", "HEPTO2")
STRESS_SHARE = 0.995
"""Share of the finest mesh's places whose stress is within the colours: at a corner stresses grow without limit."""

EDGES_UP_TO = 2
"""Levels of the membrane whose cells are drawn over the stresses; the others' are too small."""


def patch_figure(found: ElasticityReproduction) -> Figure:
    """Draw the stress along the tension on three patches (as Figure 56), with the points of their boundaries."""
    figure = new_figure(12.5, 3.9)
    rows = {str(row.code): row for row in found.patch}
    for axes, name in zip(figure.subplots(1, len(PATCH_SHOWN)), PATCH_SHOWN, strict=True):
        row: PatchRow = rows[name]
        plot_stress(row.solution, "xx", axes, unit="kN/cm²", length_unit="cm", limits=(0.9, 1.1))
        mesh = row.solution.problem.space.mesh
        axes.plot(*mesh.points[mesh.boundary_edges[:, 0]].T, color=INK, marker="o", ms=3, ls="none", clip_on=False)
        axes.set_title(f"{name}\nstresses wrong by {row.stress_error:.0e} of the tension", fontsize=10)
    return figure


def cook_convergence_figure(found: ElasticityReproduction) -> Figure:
    """Draw the errors of the strain energy and of both displacements over unknowns."""
    figure = new_figure(12.0, 5.0)
    values: tuple[Callable[[CookRow], float], ...] = (
        lambda row: row.energy,
        lambda row: row.middle,
        lambda row: row.corner,
    )
    every = figure.subplots(1, 3, sharex=True, sharey=True)
    for axes, given, value in zip(every, published_rows("cook_membrane.csv"), values, strict=True):
        _draw_series(axes, found.cook, _error(value, float(given["value"])))
        axes.set_yscale("log")
        axes.axhline(1e-3, color=GREY, lw=0.8, ls="dotted")
        axes.set_title(f"{given['quantity'].replace(';', ',')}: {given['value']}", fontsize=10)
    every[0].set_ylabel("relative error")
    every[0].annotate("0.1 %", (0.98, 1e-3), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=8)
    _legend(figure, n_columns=5)
    return figure


def _error(value: Callable[[CookRow], float], wanted: float) -> Callable[[CookRow], float]:
    return lambda row: abs(value(row) / wanted - 1.0)


def incompressible_figure(found: ElasticityReproduction) -> Figure:
    """Draw the work of the load on the nearly incompressible membrane over the reference, over unknowns."""
    figure = new_figure(7.5, 5.0)
    axes = figure.subplots()
    shares = {row.code: 1.0 + row.relative_difference for row in found.incompressible_rows}
    _draw_series(axes, found.incompressible, lambda row: shares[str(row.code)])
    axes.axhline(1.0, color=GREY, lw=0.8, ls="dotted")
    axes.set_ylabel("work of the load over the reference")
    axes.set_title("Cook's membrane with Poisson's ratio 0.4999: linear triangles lock", fontsize=10)
    _legend(figure, n_columns=3)
    return figure


def _draw_series(axes: Axes, rows: Sequence[CookRow], value: Callable[[CookRow], float]) -> None:
    for order, colour in ((1, GREY), (2, INK)):
        for method, (_, marker, line) in METHODS.items():
            group = [row for row in rows if row.code.method == method and row.code.order == order]
            if group:
                unknowns = [row.n_unknowns for row in group]
                axes.plot(unknowns, list(map(value, group)), color=colour, marker=marker, ls=line, lw=1.1, ms=5)
    axes.set_xscale("log")
    axes.grid(which="both", color="#e4e4e4", linewidth=0.5)
    axes.set_xlabel("number of unknowns")


def _legend(figure: Figure, n_columns: int) -> None:
    handles = [
        *(
            Line2D([], [], color=INK, marker=marker, ls=line, ms=5, label=name)
            for name, marker, line in METHODS.values()
        ),
        Line2D([], [], color=GREY, lw=2.5, label="order 1"),
        Line2D([], [], color=INK, lw=2.5, label="order 2"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=n_columns, fontsize=9, frameon=False)


def cook_stress_figure(found: ElasticityReproduction) -> Figure:
    """Draw von Mises stresses for both methods, both orders and all meshes (as Figures 57 to 60)."""
    levels = sorted({row.code.level for row in found.cook})
    pairs = [(method, order) for method in "FV" for order in (1, 2)]
    rows = {(row.code.method, row.code.order, row.code.level): row for row in found.cook}
    finest = rows["F", 2, levels[-1]].solution
    norm = Normalize(0.0, float(np.quantile(_von_mises(finest)[1], STRESS_SHARE)))
    figure = new_figure(2.5 * len(levels) + 1.0, 11.5)
    every = figure.subplots(len(pairs), len(levels), sharex=True, sharey=True)
    for line, (method, order) in zip(every, pairs, strict=True):
        for axes, level in zip(line, levels, strict=True):
            row = rows[method, order, level]
            triangulation, values = _von_mises(row.solution)
            axes.tripcolor(triangulation, values, shading="gouraud", cmap=COLOURS, norm=norm, rasterized=True)
            if level <= EDGES_UP_TO:
                plot_mesh(row.solution.problem.space.mesh, axes, edge_sets=False)
            axes.set(aspect="equal", xlabel="", ylabel="")
            axes.set_title(f"{row.code}: {row.n_unknowns:,} unknowns", fontsize=9)
            axes.tick_params(labelsize=7)
    figure.colorbar(
        ScalarMappable(norm, COLOURS), ax=every.ravel().tolist(), label="von Mises stress", extend="max", shrink=0.5
    )
    return figure


def _von_mises(solution: ElasticitySolution) -> tuple[Triangulation, np.ndarray]:
    space = solution.problem.space
    shown = display(space, 2 * space.order if space.mesh.n_cells < 2000 else space.order)
    x, y = shown.points.T
    return Triangulation(x, y, shown.triangles), displayed_stresses(solution, shown).von_mises


def cook_deformed_figure(found: ElasticityReproduction) -> Figure:
    """Draw the deformed membrane with its stresses, on triangles and on polygons."""
    figure = new_figure(11.0, 5.5)
    rows = {str(row.code): row for row in found.cook}
    limit = float(np.quantile(_von_mises(rows["FCM2O2"].solution)[1], STRESS_SHARE))
    for axes, name in zip(figure.subplots(1, 2), ("FCM2O2", "VCM2O2"), strict=True):
        plot_stress(rows[name].solution, "von_mises", axes, factor="auto", limits=(0.0, limit))
        axes.set_title(f"{name}, {axes.get_title()}", fontsize=10)
    return figure
