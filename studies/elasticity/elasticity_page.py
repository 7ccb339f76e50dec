"""Figures and chapter of plane elasticity: patch test, Cook's membrane, adaptive refinement."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from flangeway.cases.bodies.cook import CookRow
from flangeway.mesh import PolyMesh
from flangeway.post import recovered_stresses
from flangeway.post.adaptive import RefinementRow
from flangeway.report.figures.display import shaded
from flangeway.report.figures.drawing import GREY, INK, cell_corners, new_figure
from flangeway.report.figures.plots import COLOURS, plot_mesh, plot_stress
from flangeway.report.page.tables import SummaryTable
from flangeway.solve import ElasticitySolution
from studies.elasticity.elasticity_reproduced import (
    COOK_VALUES,
    FEWER_UNKNOWNS,
    INCOMPRESSIBLE_LIMIT,
    ElasticityReproduction,
    RefinementCase,
    incompressible_rows,
    refinement_rows,
    reproduce_elasticity,
)
from studies.published_numbers import digits, percent, published_rows, relative
from studies.reproduction import Chapter, PagePicture, Reproduction

METHODS = {
    "F": ("Lagrange triangles", "^", "solid"),
    "V": ("virtual polygons", "o", (0, (2, 1.5))),
    "H": ("triangles, virtual at the boundary", "s", (0, (6, 2))),
}
"""Name, marker and line by the first letter of a code, to be distinguished in grey too."""

PATCH_SHOWN = ("FDPTO1", "VVPTO1", "HEPTO2")
STRESS_SHARE = 0.995
"""Fraction of the finest mesh's points whose stress is within the colour range: at a corner stresses are singular."""

EDGES_UP_TO = 2
"""Refinements of the membrane whose elements are drawn over the stresses; those of the others are too small."""

SINGULAR = {"Cook": (0.0, 44.0), "L-shape": (0.0, 0.0)}  # corner of each body at which stresses are singular

NAMES = {"Cook": "Cook's membrane", "L-shape": "L-shaped body"}
CELLS_SHOWN = 900
ZOOM = 0.05  # half width of the picture at the corner over the size of the body


def patch_figure(found: ElasticityReproduction) -> Figure:
    """Draw the stress along the tension on three patches (as Figure 56), with the nodes of their boundaries."""
    figure = new_figure(12.5, 3.9)
    rows = {str(row.code): row for row in found.patch}
    for axes, name in zip(figure.subplots(1, len(PATCH_SHOWN)), PATCH_SHOWN, strict=True):
        row = rows[name]
        plot_stress(row.solution, "xx", axes, unit="kN/cm²", length_unit="cm", limits=(0.9, 1.1))
        mesh = row.solution.problem.space.mesh
        axes.plot(*mesh.points[mesh.boundary_edges[:, 0]].T, color=INK, marker="o", ms=3, ls="none", clip_on=False)
        axes.set_title(f"{name}\nmaximum stress error {row.stress_error:.0e} of the tension", fontsize=10)
    return figure


def cook_convergence_figure(found: ElasticityReproduction) -> Figure:
    """Draw the errors of the strain energy and of both displacements over unknowns."""
    figure = new_figure(12.0, 5.0)
    every = figure.subplots(1, 3, sharex=True, sharey=True)
    for axes, given, name in zip(every, published_rows("cook_membrane.csv"), COOK_VALUES, strict=True):
        errors = [abs(getattr(row, name) / float(given["value"]) - 1.0) for row in found.cook]
        _draw_series(axes, found.cook, errors)
        axes.set_yscale("log")
        axes.axhline(1e-3, color=GREY, lw=0.8, ls="dotted")
        axes.set_title(f"{given['quantity'].replace(';', ',')}: {given['value']}", fontsize=10)
    every[0].set_ylabel("relative error")
    every[0].annotate("0.1 %", (0.98, 1e-3), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=8)
    _legend(figure, n_columns=5)
    return figure


def incompressible_figure(found: ElasticityReproduction) -> Figure:
    """Draw the work of the load on the nearly incompressible membrane over the reference, over unknowns."""
    figure = new_figure(7.5, 5.0)
    axes = figure.subplots()
    _draw_series(axes, found.cook, [1.0 + row.relative_difference for row in found.incompressible])
    axes.axhline(1.0, color=GREY, lw=0.8, ls="dotted")
    axes.set_ylabel("work of the load / reference")
    axes.set_title("Cook's membrane with Poisson's ratio 0.4999: linear triangles lock", fontsize=10)
    _legend(figure, n_columns=3)
    return figure


def _draw_series(axes: Axes, rows: Sequence[CookRow], values: Sequence[float]) -> None:
    for order, colour in ((1, GREY), (2, INK)):
        for method, (_, marker, line) in METHODS.items():
            group = [
                (row.n_unknowns, value)
                for row, value in zip(rows, values, strict=True)
                if (row.code.method, row.code.order) == (method, order)
            ]
            if group:
                axes.plot(*zip(*group, strict=True), color=colour, marker=marker, ls=line, lw=1.1, ms=5)
    _log_axes(axes)


def _log_axes(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.grid(which="both", color="#e4e4e4", linewidth=0.5)
    axes.set_xlabel("number of unknowns")


def _legend(figure: Figure, n_columns: int) -> None:
    handles = [
        *(Line2D([], [], color=INK, marker=mark, ls=line, ms=5, label=name) for name, mark, line in METHODS.values()),
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
    triangles, stresses = shaded(solution, 2 * space.order if space.mesh.n_cells < 2000 else space.order)
    return triangles, stresses.von_mises


def cook_deformed_figure(found: ElasticityReproduction) -> Figure:
    """Draw the deformed membrane with its stresses, on triangles and on polygons."""
    figure = new_figure(11.0, 5.5)
    rows = {str(row.code): row for row in found.cook}
    limit = float(np.quantile(_von_mises(rows["FCM2O2"].solution)[1], STRESS_SHARE))
    for axes, name in zip(figure.subplots(1, 2), ("FCM2O2", "VCM2O2"), strict=True):
        plot_stress(rows[name].solution, "von_mises", axes, factor="auto", limits=(0.0, limit))
        axes.set_title(f"{name}, {axes.get_title()}", fontsize=10)
    return figure


def hanging_nodes(mesh: PolyMesh) -> NDArray[np.int64]:
    """Indices of the nodes that lie on a straight side of an element inside the body."""
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
    """Draw the estimated error of each element of the membrane, on a uniform and an adaptive mesh of similar size."""
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
            f"{row.refinement}, {row.mesh.n_cells} elements: estimated error {100.0 * row.estimated_error:.1f} %",
            fontsize=10,
        )
    figure.colorbar(cells, ax=every.tolist(), label="estimated error of an element in the energy norm", extend="min")
    return figure


def adaptive_meshes_figure(found: ElasticityReproduction) -> Figure:
    """Draw adaptive meshes of both bodies, and at the corner their hanging nodes."""
    figure = new_figure(12.0, 8.0)
    for line, body in zip(figure.subplots(2, 3), SINGULAR, strict=True):
        case = _case(found, body, 2)
        early, late = _about(case.adaptive, CELLS_SHOWN // 4), _about(case.adaptive, 2 * CELLS_SHOWN)
        for axes, row in zip(line, (early, late, late), strict=True):
            plot_mesh(row.mesh, axes, edge_sets=False)
            axes.set_title(f"{NAMES[body]}: {row.mesh.n_cells} elements, {row.n_unknowns:,} unknowns", fontsize=9)
        _draw_corner(line[2], late.mesh, SINGULAR[body])
    return figure


def _draw_corner(axes: Axes, mesh: PolyMesh, corner: tuple[float, float]) -> None:
    hanging = hanging_nodes(mesh)
    axes.plot(*mesh.points[hanging].T, color=INK, marker="o", ms=3.0, ls="none")
    half = ZOOM * float(np.ptp(mesh.points, axis=0).max())
    axes.set(xlim=(corner[0] - half, corner[0] + half), ylim=(corner[1] - half, corner[1] + half))
    axes.set_title(f"at the corner; {len(hanging):,} hanging nodes in all", fontsize=9)


def refinement_convergence_figure(found: ElasticityReproduction) -> Figure:
    """Draw the error over unknowns for uniform and adaptive refinement of both bodies."""
    figure = new_figure(11.0, 5.4)
    for axes, body in zip(figure.subplots(1, 2), SINGULAR, strict=True):
        for order, marker in ((1, "^"), (2, "o")):
            case = _case(found, body, order)
            for rows, line in ((case.uniform, (0, (4, 2))), (case.adaptive, "solid")):
                unknowns, errors = [row.n_unknowns for row in rows], [row.error for row in rows]
                axes.plot(unknowns, errors, color=INK, marker=marker, ms=4, lw=1.1, ls=line)
        _log_axes(axes)
        axes.set_yscale("log")
        axes.set_title(NAMES[body], fontsize=10)
        axes.set_ylabel("relative error of the stresses in the energy norm")
    handles = [
        Line2D([], [], color=INK, marker="^", ls="none", ms=5, label="order 1"),
        Line2D([], [], color=INK, marker="o", ls="none", ms=5, label="order 2"),
        Line2D([], [], color=INK, ls=(0, (4, 2)), label="uniform"),
        Line2D([], [], color=INK, ls="solid", label="adaptive, hanging nodes"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return figure


def _case(found: ElasticityReproduction, body: str, order: int) -> RefinementCase:
    return next(case for case in found.refinements if case.body == body and case.order == order)


def _about(rows: Sequence[RefinementRow], n_cells: int) -> RefinementRow:
    return min(rows, key=lambda row: abs(np.log(row.mesh.n_cells / n_cells)))


def _tables(found: ElasticityReproduction) -> list[SummaryTable]:
    """Nearly incompressible material, and the savings by adaptive refinement."""
    soft = tuple((row.code, str(row.n_unknowns), relative(row.relative_difference)) for row in found.incompressible)
    saved = tuple(
        (
            case.body,
            f"{case.order}",
            f"{case.uniform[-1].n_unknowns}",
            digits(case.uniform[-1].error, 2),
            digits(case.saving, 2) if case.saving > 0.0 else "**not reached**",
        )
        for case in found.refinements
    )
    return [
        SummaryTable(
            "Cook's membrane with Poisson's ratio 0.4999: work of the load compared with a reference of orders 3 and 4 "
            f"on fine meshes. Order 2 must be within {percent(INCOMPRESSIBLE_LIMIT)} on every mesh; triangles of order "
            "1 lock",
            ("code", "unknowns", "difference"),
            soft,
        ),
        SummaryTable(
            "Ratio of the unknowns of uniform refinement to those of adaptive refinement by virtual elements with the "
            f"same error in energy; on the L-shaped body it must be at least {FEWER_UNKNOWNS:g}",
            ("body", "order", "unknowns of uniform refinement", "its error", "ratio"),
            saved,
        ),
    ]


ELASTICITY = Reproduction(
    reproduce_elasticity,
    Chapter(
        "Plane elasticity",
        """A body under uniform tension (Moherdaui's Figure 56, page 149), which every element must reproduce exactly.
        Cook's membrane of Moherdaui's section 5.3.2, which shows pictures only: energy and displacements are those of
        Artioli, Beirão da Veiga, Lovadina and Sacco (2017), the source of the problem; order 2 on the finest mesh must
        agree with them, and the error must decrease with each refinement. The plate with a hole (Kirsch 1898) and the
        thick cylinder under pressure (Lamé 1852) in closed form. Codes such as VCM3O2: F, V or H, finite elements,
        virtual ones, or virtual ones at the boundary alone; the mesh; the order.""",
        (
            PagePicture(
                "elasticity-cook",
                "Errors of energy and of two displacements of Cook's membrane over the number of unknowns: all fall "
                "with each mesh, those of order 2 on the finest mesh to below 0.1 %",
                cook_convergence_figure,
            ),
            PagePicture(
                "elasticity-refinement",
                "Error in energy of Cook's membrane and of the L-shaped body over the number of unknowns: adaptive "
                "refinement falls faster than uniform refinement, most so on the L-shaped body with order 2",
                refinement_convergence_figure,
            ),
        ),
        _tables,
    ),
    {
        "patch_test.png": patch_figure,
        "cook_convergence.png": cook_convergence_figure,
        "cook_stresses.png": cook_stress_figure,
        "cook_deformed.png": cook_deformed_figure,
        "nearly_incompressible.png": incompressible_figure,
        "error_estimate.png": estimate_figure,
        "adaptive_meshes.png": adaptive_meshes_figure,
        "refinement.png": refinement_convergence_figure,
    },
    {"nearly_incompressible.csv": incompressible_rows, "refinement.csv": refinement_rows},
    brief=True,
)
