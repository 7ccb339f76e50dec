"""Pictures of meshes, fields, deformed shapes and stresses on cells of any shape and order."""

from functools import singledispatch
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from flangeway.contact import ContactSolution
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import norms
from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.post import AdaptiveRun, PressurePatch, Stresses, StressLine
from flangeway.problems import ElasticField
from flangeway.report.figures.display import display
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    NODES,
    SERIES,
    Style,
    draw_lines,
    fill_triangles,
    name_axes,
    named,
    new_figure,
    panels,
    shade_of,
    with_unit,
)
from flangeway.report.figures.stress_picture import DrawnBody, edge_lines, line_width
from flangeway.results import Result
from flangeway.solve import TorsionSolution
from flangeway.space import Space
from flangeway.types import Floats, floats

Factor: TypeAlias = float | Literal["auto"]
"""Factor on the displacements in the figure; ``"auto"`` makes the maximum a twentieth of the body's size."""

Quantity = Literal["von_mises", "xx", "yy", "xy", "zz", "in_plane_shear", "principal_1", "principal_2", "principal_3"]
Component = Literal["magnitude", "x", "y"]
Limits: TypeAlias = tuple[float, float] | None

MANY_TRIANGLES = 60_000
"""Small triangles up to which sides are cut into more pieces than the order needs, for smooth colours."""

MAX_PIECES = 6
DEFORMATION_SHARE = 0.05
SET_LINES = ("solid", (0, (4, 1.5)), (0, (1, 1)))


def plot_mesh(mesh: PolyMesh, axes: Axes | None = None, *, length_unit: str | None = None) -> Axes:
    """Draw the cells of a mesh, and named edge sets in colours with their names.

    Parameters
    ----------
    axes
        Where to draw; a new figure by default, ``axes.figure``.
    length_unit
        Unit of the coordinates, for the labels.

    """
    axes, mesh = _prepared(axes, length_unit), as_polylines(mesh)
    draw_lines(axes, mesh.points[mesh.edges], GREY, line_width(mesh))
    draw_lines(axes, mesh.points[mesh.boundary_edges], INK, 0.9)
    for number, (name, pairs) in enumerate(mesh.edge_sets.items()):
        style: Style = {"colors": SERIES[number % len(SERIES)], "linestyles": [SET_LINES[number // len(SERIES) % 3]]}
        axes.add_collection(LineCollection(list(mesh.points[pairs]), linewidths=2.2, label=name, zorder=3, **style))
    if mesh.edge_sets:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=9)
    _fit(axes, mesh.points)
    return axes


def plot_function(
    space: Space,
    dofs: Floats,
    axes: Axes | None = None,
    *,
    label: str,
    unit: str | None = None,
    limits: Limits = None,
    length_unit: str | None = None,
) -> Axes:
    """Draw a scalar function of a space: on edges as it is, inside cells by its projection.

    Parameters
    ----------
    dofs
        Unknowns, shape (n_dofs,).
    axes
        Where to draw; a new figure by default.
    label, unit
        Label of the colour bar, and its unit.
    limits
        Values of the first and last colour; those of the function by default.
    length_unit
        Unit of the coordinates.

    """
    shown, axes = display(space, _pieces(space)), _prepared(axes, length_unit)
    values = shown.function(floats(dofs)[:, None])[:, 0]
    shade = shade_of(values, _checked(limits))
    fill_triangles(axes, shown.points, shown.triangles, values, shade)
    _bar(axes, shade, values, with_unit(label, unit))
    lines = edge_lines(space, lambda points, _: points)
    draw_lines(axes, lines, GREY, line_width(space.mesh), 0.7)
    draw_lines(axes, lines[space.mesh.edge_cells[:, 1] < 0], INK, 0.9)
    _fit(axes, shown.points)
    return axes


def plot_displacement(
    solution: ElasticField,
    component: Component = "magnitude",
    axes: Axes | None = None,
    *,
    factor: Factor = 0.0,
    unit: str | None = None,
    limits: Limits = None,
) -> Axes:
    """Draw displacements in colours, on the undeformed or the deformed body.

    Parameters
    ----------
    component
        ``"magnitude"``, ``"x"`` or ``"y"``.
    factor
        Factor on the displacements: 0 for the undeformed body, or ``"auto"``.
    unit
        Unit of lengths.
    axes, limits
        As in `plot_function`.

    """
    if component not in get_args(Component):
        raise InputError(f"component = {short(component)}", ", ".join(get_args(Component)), "choose one of them")
    body, axes = _deformed(solution, axes, factor, unit)
    moved = body.shown.function(solution.displacements)
    values = norms(moved) if component == "magnitude" else moved[:, "xy".index(component)]
    label = "displacement" if component == "magnitude" else f"displacement in {component}"
    return _drawn(body, values, with_unit(label, unit), axes, limits)


def plot_stress(
    solution: ElasticField,
    quantity: Quantity = "von_mises",
    axes: Axes | None = None,
    *,
    factor: Factor = 0.0,
    unit: str | None = None,
    length_unit: str | None = None,
    limits: Limits = None,
) -> Axes:
    """Draw stresses in colours, from the reconstruction inside each cell, with the jumps that it has between cells.

    Parameters
    ----------
    quantity
        A component, ``"von_mises"``, ``"in_plane_shear"``, or ``"principal_1"`` (maximum) to ``"principal_3"``, the
        normal stress out of the plane among them.
    unit, length_unit
        Units of stresses and lengths.
    axes, factor, limits
        As in `plot_displacement`; limits help where stresses are singular at a corner.

    """
    if quantity not in get_args(Quantity):
        raise InputError(f"quantity = {short(quantity)}", ", ".join(get_args(Quantity)), "choose one of them")
    body, axes = _deformed(solution, axes, factor, length_unit)
    return _drawn(body, stress_quantity(body.stresses, quantity), with_unit(_stress_name(quantity), unit), axes, limits)


def plot_deformed(
    solution: ElasticField, axes: Axes | None = None, *, factor: Factor = "auto", length_unit: str | None = None
) -> Axes:
    """Draw the deformed cells over the dashed outline of the undeformed body; edges of order 2 and more are curved."""
    body, axes = _deformed(solution, axes, factor, length_unit)
    mesh, lines = body.space.mesh, body.edges
    draw_lines(axes, lines, GREY, line_width(mesh), 0.7)
    draw_lines(axes, lines[mesh.edge_cells[:, 1] < 0], INK, 1.0)
    _fit(axes, np.vstack([lines.reshape(-1, 2), mesh.points]))
    return axes


@singledispatch
def plot_result(result: Result, **options: Any) -> Figure:
    """Draw what a result is about, and return the figure.

    Elastic fields are drawn by `plot_stress`, functions of torsion by `plot_function`, stresses along lines and
    pressures over the length, adaptive runs as error over cells, runs of cases as the first picture of their report.

    Parameters
    ----------
    result
        What a computation returned.
    **options
        Those of `plot_stress` or `plot_function`; the others have none.

    Raises
    ------
    InputError
        If there is no picture of such a result.

    """
    words = f" with {', '.join(options)}" if options else ""
    raise InputError(f"a picture of {type(result).__name__}{words}", "results with a picture", "draw its table")


@plot_result.register
def _(result: ElasticField, **options: Any) -> Figure:
    return cast(Figure, plot_stress(result, **options).figure)


@plot_result.register
def _(result: TorsionSolution, **options: Any) -> Figure:
    label = "warping function" if result.problem.formulation == "warping" else "Prandtl's function"
    return cast(Figure, plot_function(result.problem.space, result.function, **{"label": label} | options).figure)


@plot_result.register
def _(result: ContactSolution, **options: Any) -> Figure:
    parts = result.system.parts
    figure = new_figure(8.0, 5.5)
    for axes, part in zip(figure.subplots(1, len(parts), squeeze=False)[0], parts, strict=True):
        plot_stress(result.field(part), axes=axes, **options)
        axes.set_title(part.name, fontsize=10)
    return figure


@plot_result.register(StressLine)
@plot_result.register(PressurePatch)
@plot_result.register(AdaptiveRun)
def _(result: Result) -> Figure:
    """Curves of the last columns of the table over the one of the length, or of the cells."""
    columns = result.table.columns
    over = next(name for name in ("distance", "along", "cells") if name in columns)
    curves = ("xx", "yy", "xy", "zz", "von_mises") if over == "distance" else list(columns)[-1:]
    figure, ((axes,),) = panels(8.0, 4.5)
    for name in curves:
        axes.plot(columns[over], columns[name], label=named(name)[0], **({"lw": 1.4} if over == "distance" else NODES))
    name_axes(axes, over, "stress" if len(curves) > 1 else named(curves[0])[0])
    if over == "cells":
        axes.set(xscale="log", yscale="log")
    if len(curves) > 1:
        axes.legend(fontsize=8)
    return figure


def stress_quantity(stresses: Stresses, quantity: Quantity) -> Floats:
    """Values (n,) of one quantity."""
    if quantity in ("xx", "yy", "xy", "zz"):
        component: Floats = stresses.components[:, ("xx", "yy", "xy", "zz").index(quantity)]
        return component
    if quantity.startswith("principal"):
        principal: Floats = stresses.principal[:, int(quantity[-1]) - 1]
        return principal
    return stresses.von_mises if quantity == "von_mises" else stresses.in_plane_shear


def _stress_name(quantity: Quantity) -> str:
    if quantity.startswith("principal"):
        return f"principal stress {quantity[-1]}"
    names = {"von_mises": "von Mises stress", "in_plane_shear": "maximum shear stress in the plane"}
    return names.get(quantity, f"stress {quantity}")


def _prepared(axes: Axes | None, length_unit: str | None) -> Axes:
    axes = axes or new_figure(8.0, 5.5, compressed=True).subplots()
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel=with_unit("x", length_unit), ylabel=with_unit("y", length_unit))
    return axes


def _fit(axes: Axes, points: Floats) -> None:
    """Show all points, and what earlier calls have shown."""
    axes.update_datalim(points)
    axes.margins(0.03)
    axes.autoscale_view()


def _pieces(space: Space) -> int:
    """Pieces of each side with about as many triangles as a picture can show."""
    room = np.sqrt(MANY_TRIANGLES / len(space.mesh.cell_points))
    return int(max(space.order, min(MAX_PIECES, room)))


def _checked(limits: Limits) -> Limits:
    if limits is not None and not limits[0] <= limits[1]:
        raise InputError(f"limits = {limits}", "the lesser value first", "exchange them")
    return limits


def _bar(axes: Axes, shade: Any, values: Floats, label: str) -> None:
    """Add a bar of colours, whose ends say where values are beyond them."""
    ends = values.min() < shade.norm.vmin, values.max() > shade.norm.vmax
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}.get(ends, "both")
    cast(Figure, axes.get_figure(root=True)).colorbar(shade, ax=axes, label=label, extend=extend, shrink=0.9)


def _deformed(
    solution: ElasticField, axes: Axes | None, factor: Factor, length_unit: str | None
) -> tuple[DrawnBody, Axes]:
    """Return a body with its displacements multiplied, and axes with the dashed outline before, if it moves."""
    axes, scale, space = _prepared(axes, length_unit), _factor(solution, factor), solution.space
    if scale:
        axes.set_title(f"deformation x{scale:.3g}", fontsize=10)
        rim = as_polylines(space.mesh)
        draw_lines(axes, rim.points[rim.boundary_edges], GREY, 0.9, ls=(0, (4, 2)))
    return DrawnBody(solution, lambda points, moved: points + scale * moved, _pieces(space)), axes


def _drawn(body: DrawnBody, values: Floats, label: str, axes: Axes, limits: Limits) -> Axes:
    shade = shade_of(values, _checked(limits))
    body.draw(axes, values, shade)
    _bar(axes, shade, values, label)
    _fit(axes, np.vstack([body.points, body.space.mesh.points]))
    return axes


def _factor(solution: ElasticField, factor: Factor) -> float:
    if factor != "auto":
        if not np.isfinite(factor):
            raise InputError(f"factor = {factor}", "a finite number or 'auto'", "leave it out")
        return float(factor)
    maximum = float(norms(solution.displacements[: solution.space.n_nodes]).max())
    return round_factor(DEFORMATION_SHARE * solution.problem.size / maximum) if maximum > 0.0 else 1.0


def round_factor(wanted: float) -> float:
    """Return the largest of 1, 2, 5, 10, 20, 50, ... and their tenths that is not above a number."""
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(digit for digit in (1, 2, 5) if digit * power <= wanted * (1.0 + 1e-9)))
