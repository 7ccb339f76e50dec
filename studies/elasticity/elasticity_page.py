"""Figures and chapter of plane elasticity: patch test, Cook's membrane, adaptive refinement."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flangeway.cases.bodies.cook import CookRow
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import plot_stress
from flangeway.report.page.tables import SummaryTable
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
SINGULAR = {"Cook": (0.0, 44.0), "L-shape": (0.0, 0.0)}  # corner of each body at which stresses are singular

NAMES = {"Cook": "Cook's membrane", "L-shape": "L-shaped body"}
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
        "nearly_incompressible.png": incompressible_figure,
        "refinement.png": refinement_convergence_figure,
    },
    {"nearly_incompressible.csv": incompressible_rows, "refinement.csv": refinement_rows},
    brief=True,
)
