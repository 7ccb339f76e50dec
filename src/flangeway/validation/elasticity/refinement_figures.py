"""Pictures of refinement: where the error is, meshes with hanging points, errors over unknowns."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.post import recovered_stresses
from flangeway.post.refinement import RefinementRow
from flangeway.report.figures.drawing import GREY, INK, cell_corners, new_figure
from flangeway.report.figures.plots import COLOURS, plot_mesh
from flangeway.validation.elasticity.elasticity_reproduced import ElasticityReproduction, RefinementCase

SINGULAR = {"Cook": (0.0, 44.0), "L-shape": (0.0, 0.0)}
"""Corner of each body at which stresses grow without limit."""

NAMES = {"Cook": "Cook's membrane", "L-shape": "L-shaped body"}
CELLS_SHOWN = 900
SAVING_SHOWN = 1.5
ZOOM = 0.05
"""Half width of the picture about the corner over the size of the body."""


def hanging_points(mesh: PolyMesh) -> NDArray[np.int64]:
    """Numbers of the points that lie on a straight side of a cell inside the body."""
    ends = mesh.cell_offsets[1:] - 1
    following, before = np.arange(1, len(mesh.cell_points) + 1), np.arange(-1, len(mesh.cell_points) - 1)
    following[ends] = mesh.cell_offsets[:-1]
    before[mesh.cell_offsets[:-1]] = ends
    corners = mesh.points[mesh.cell_points]
    (ax, ay), (bx, by) = (corners - corners[before]).T, (corners[following] - corners).T
    straight = np.abs(ax * by - ay * bx) < 1e-9 * np.hypot(ax, ay) * np.hypot(bx, by)
    inside = np.setdiff1d(mesh.cell_points[straight], mesh.boundary_edges)
    return inside.astype(np.int64)


def estimate_figure(found: ElasticityReproduction) -> Figure:
    """Draw the estimated error of each cell of the membrane, on a uniform and on an adaptive mesh of like size."""
    case = _case(found, "Cook", 2)
    uniform = _about(case.uniform, CELLS_SHOWN)
    adaptive = _about(case.adaptive, uniform.mesh.n_cells)
    errors = [recovered_stresses(row.solution).cell_errors for row in (uniform, adaptive)]
    maximum = max(float(each.max()) for each in errors)
    norm = LogNorm(1e-4 * maximum, maximum)
    figure = new_figure(11.0, 5.2)
    every = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, row, values in zip(every, (uniform, adaptive), errors, strict=True):
        cells = PolyCollection(cell_corners(row.mesh, row.mesh.points), cmap=COLOURS, norm=norm, linewidths=0.3)
        cells.set_array(values)
        cells.set_edgecolor(GREY)
        axes.add_collection(cells)
        axes.autoscale_view()
        axes.set(aspect="equal", xlabel="x", ylabel="y")
        axes.set_title(
            f"{row.refinement}, {row.mesh.n_cells} cells: estimated error {100.0 * row.estimated_error:.1f} %",
            fontsize=10,
        )
    figure.colorbar(cells, ax=every.tolist(), label="estimated error of a cell in the energy norm", extend="min")
    return figure


def adaptive_meshes_figure(found: ElasticityReproduction) -> Figure:
    """Draw adaptive meshes of both bodies, and about the corner their hanging points."""
    figure = new_figure(12.0, 8.0)
    for line, body in zip(figure.subplots(2, 3), SINGULAR, strict=True):
        case = _case(found, body, 2)
        early, late = _about(case.adaptive, CELLS_SHOWN // 4), _about(case.adaptive, 2 * CELLS_SHOWN)
        for axes, row in zip(line, (early, late, late), strict=True):
            plot_mesh(row.mesh, axes, edge_sets=False)
            axes.set_title(f"{NAMES[body]}: {row.mesh.n_cells} cells, {row.n_unknowns:,} unknowns", fontsize=9)
        _draw_corner(line[2], late.mesh, SINGULAR[body])
    return figure


def _draw_corner(axes: Axes, mesh: PolyMesh, corner: tuple[float, float]) -> None:
    hanging = hanging_points(mesh)
    axes.plot(*mesh.points[hanging].T, color=INK, marker="o", ms=3.0, ls="none")
    half = ZOOM * float(np.ptp(mesh.points, axis=0).max())
    axes.set_xlim(corner[0] - half, corner[0] + half)
    axes.set_ylim(corner[1] - half, corner[1] + half)
    axes.set_title(f"about the corner; {len(hanging):,} hanging points in all", fontsize=9)


def refinement_convergence_figure(found: ElasticityReproduction) -> Figure:
    """Draw the error over unknowns for uniform and adaptive refinement of both bodies."""
    figure = new_figure(11.0, 5.4)
    for axes, body in zip(figure.subplots(1, 2), SINGULAR, strict=True):
        for order, marker in ((1, "^"), (2, "o")):
            case = _case(found, body, order)
            for rows, line in ((case.uniform, (0, (4, 2))), (case.adaptive, "solid")):
                unknowns, errors = [row.n_unknowns for row in rows], [row.error for row in rows]
                axes.plot(unknowns, errors, color=INK, marker=marker, ms=4, lw=1.1, ls=line)
            if case.saving >= SAVING_SHOWN:
                _draw_saving(axes, case)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.grid(which="both", color="#e4e4e4", linewidth=0.5)
        axes.set_title(NAMES[body], fontsize=10)
        axes.set_xlabel("number of unknowns")
        axes.set_ylabel("relative error of the stresses in the energy norm")
    handles = [
        Line2D([], [], color=INK, marker="^", ls="none", ms=5, label="order 1"),
        Line2D([], [], color=INK, marker="o", ls="none", ms=5, label="order 2"),
        Line2D([], [], color=INK, ls=(0, (4, 2)), label="uniform"),
        Line2D([], [], color=INK, ls="solid", label="adaptive, hanging points"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return figure


def _draw_saving(axes: Axes, case: RefinementCase) -> None:
    """Draw an arrow from the finest uniform mesh to the adaptive one that is as good."""
    finest = case.uniform[-1]
    reached = next(row for row in case.adaptive if row.error <= finest.error)
    axes.annotate(
        "",
        (reached.n_unknowns, finest.error),
        (finest.n_unknowns, finest.error),
        arrowprops={"arrowstyle": "->", "color": GREY},
    )
    middle = np.sqrt(reached.n_unknowns * finest.n_unknowns)
    axes.annotate(
        f"{case.saving:.0f} times fewer",
        (middle, finest.error), xytext=(0, 3), textcoords="offset points", ha="center", fontsize=8, color=GREY,
    )  # fmt: skip


def _case(found: ElasticityReproduction, body: str, order: int) -> RefinementCase:
    return next(case for case in found.refinements if case.body == body and case.order == order)


def _about(rows: Sequence[RefinementRow], n_cells: int) -> RefinementRow:
    return min(rows, key=lambda row: abs(np.log(row.mesh.n_cells / n_cells)))
