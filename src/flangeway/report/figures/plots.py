"""Pictures of meshes, fields, deformed shapes and stresses on cells of any shape and order."""

from functools import singledispatch
from typing import Any, Literal, TypeAlias, cast, get_args

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from flangeway.contact import ContactSolution
from flangeway.errors import InputError, short
from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.post import AdaptiveRun, PressurePatch, Stresses, StressLine
from flangeway.problems import ElasticField
from flangeway.report.figures.display import Display, display, displayed_stresses, edge_weights
from flangeway.report.figures.drawing import GREY, INK, SERIES, SIGNED, draw_outline, named, new_figure
from flangeway.results import Result
from flangeway.solve import TorsionSolution
from flangeway.space import Space
from flangeway.types import Floats

Factor: TypeAlias = float | Literal["auto"]
"""Factor on the displacements in the figure; ``"auto"`` makes the maximum a twentieth of the body's size."""

Quantity = Literal["von_mises", "xx", "yy", "xy", "zz", "in_plane_shear", "principal_1", "principal_2", "principal_3"]
Component = Literal["magnitude", "x", "y"]

MANY_TRIANGLES = 60_000
"""Small triangles up to which sides are cut into more pieces than the order needs, for smooth colours."""

MAX_PIECES = 6
DEFORMATION_SHARE = 0.05
SET_LINES = ("solid", (0, (4, 1.5)), (0, (1, 1)))
COLOURS: Colormap = ListedColormap(mpl.colormaps["magma_r"](np.linspace(0.02, 0.92, 256)))
"""From light, the minimum, to dark, the maximum, in grey too."""


def plot_mesh(
    mesh: PolyMesh,
    axes: Axes | None = None,
    *,
    edge_sets: bool = True,
    cell_sets: bool = False,
    length_unit: str | None = None,
) -> Axes:
    """Draw the cells of a mesh.

    Parameters
    ----------
    axes
        Where to draw; a new figure by default, ``axes.figure``.
    edge_sets
        Whether named edge sets are drawn in colours, with their names.
    cell_sets
        Whether the cells of named sets are tinted, with their names.
    length_unit
        Unit of the coordinates, for the labels.

    """
    axes, mesh = _prepared(axes, length_unit), as_polylines(mesh)
    handles = []
    if cell_sets:
        for number, (name, cells) in enumerate(mesh.cell_sets.items()):
            corners = [mesh.points[mesh.cell_points[mesh.cell_offsets[c] : mesh.cell_offsets[c + 1]]] for c in cells]
            tint = SERIES[number % len(SERIES)]
            patches = PolyCollection(corners, facecolors=tint, alpha=0.25, linewidths=0.0, label=name)
            handles.append(axes.add_collection(patches))
    axes.add_collection(LineCollection(list(mesh.points[mesh.edges]), colors=GREY, linewidths=_line_width(mesh)))
    _draw_rim(axes, mesh)
    if edge_sets:
        for number, (name, pairs) in enumerate(mesh.edge_sets.items()):
            style = SET_LINES[number // len(SERIES) % len(SET_LINES)]
            colour = SERIES[number % len(SERIES)]
            lines = LineCollection(
                list(mesh.points[pairs]), colors=colour, linewidths=2.2, linestyles=[style], label=name, zorder=3
            )
            handles.append(axes.add_collection(lines))
    if handles:
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=9)
    _fit(axes, mesh.points)
    return axes


def plot_function(
    space: Space,
    dofs: Floats,
    axes: Axes | None = None,
    *,
    label: str,
    unit: str | None = None,
    limits: tuple[float, float] | None = None,
    edges: bool = True,
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
    edges
        Whether the cells' edges are drawn.
    length_unit
        Unit of the coordinates.

    """
    shown = _fine_display(space)
    values = shown.function(np.asarray(dofs, dtype=np.float64)[:, None])[:, 0]
    axes, mesh = _prepared(axes, length_unit), as_polylines(space.mesh)
    _fill(axes, shown, shown.points, values, _with_unit(label, unit), limits)
    if edges:
        _draw_edges(axes, mesh.points[mesh.edges], mesh)
    _draw_rim(axes, mesh)
    _fit(axes, shown.points)
    return axes


def plot_displacement(
    solution: ElasticField,
    component: Component = "magnitude",
    axes: Axes | None = None,
    *,
    factor: Factor = 0.0,
    unit: str | None = None,
    limits: tuple[float, float] | None = None,
    edges: bool = True,
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
    axes, limits, edges
        As in `plot_function`.

    """
    if component not in get_args(Component):
        raise InputError(f"component = {short(component)}", ", ".join(get_args(Component)), "choose one of them")
    shown = _fine_display(solution.problem.space)
    moved = shown.function(solution.displacements)
    values = np.hypot(*moved.T) if component == "magnitude" else moved[:, "xy".index(component)]
    label = "displacement" if component == "magnitude" else f"displacement in {component}"
    return _drawn(solution, shown, values, _with_unit(label, unit), axes, factor, limits, edges, unit)


def plot_stress(
    solution: ElasticField,
    quantity: Quantity = "von_mises",
    axes: Axes | None = None,
    *,
    factor: Factor = 0.0,
    unit: str | None = None,
    length_unit: str | None = None,
    limits: tuple[float, float] | None = None,
    edges: bool = True,
) -> Axes:
    """Draw stresses in colours, from the reconstruction inside each cell, with the jumps that it has between cells.

    Parameters
    ----------
    quantity
        A component, ``"von_mises"``, ``"in_plane_shear"``, or ``"principal_1"`` (maximum) to ``"principal_3"``, the
        normal stress out of the plane among them.
    unit, length_unit
        Units of stresses and lengths.
    axes, factor, limits, edges
        As in `plot_displacement`; limits help where stresses are singular at a corner.

    """
    if quantity not in get_args(Quantity):
        raise InputError(f"quantity = {short(quantity)}", ", ".join(get_args(Quantity)), "choose one of them")
    shown = _fine_display(solution.problem.space)
    stresses = displayed_stresses(solution, shown)
    label = _with_unit(_stress_name(quantity), unit)
    values = stress_quantity(stresses, quantity)
    return _drawn(solution, shown, values, label, axes, factor, limits, edges, length_unit)


def plot_deformed(
    solution: ElasticField, axes: Axes | None = None, *, factor: Factor = "auto", length_unit: str | None = None
) -> Axes:
    """Draw the deformed cells over the dashed outline of the undeformed body; edges of order 2 and more are curved."""
    axes = _prepared(axes, length_unit)
    scale = _factor(solution, factor)
    mesh = solution.problem.space.mesh
    lines = _moved_edges(solution, scale)
    _draw_edges(axes, lines, mesh)
    outer = mesh.edge_cells[:, 1] < 0
    axes.add_collection(LineCollection(list(lines[outer]), colors=INK, linewidths=1.0))
    draw_outline(axes, mesh, dashed=True)
    _fit(axes, np.vstack([lines.reshape(-1, 2), mesh.points]))
    axes.set_title(_drawn_as(scale), fontsize=10)
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
    axes = figure.subplots(1, len(parts))
    for each, part in zip(np.atleast_1d(axes), parts, strict=True):
        plot_stress(result.field(part), axes=each, **options)
        each.set_title(part.name, fontsize=10)
    return figure


@plot_result.register(StressLine)
@plot_result.register(PressurePatch)
@plot_result.register(AdaptiveRun)
def _(result: Result) -> Figure:
    """Curves of the last columns of the table over the one of the length, or of the cells."""
    columns = result.table.columns
    over = next(name for name in ("distance", "along", "cells") if name in columns)
    curves = ("xx", "yy", "xy", "zz", "von_mises") if over == "distance" else list(columns)[-1:]
    figure = new_figure(8.0, 4.5)
    axes = figure.subplots()
    for number, name in enumerate(curves):
        marker = "" if over == "distance" else "o"
        label, colour = named(name)[0], SERIES[number]
        axes.plot(columns[over], columns[name], color=colour, lw=1.4, marker=marker, ms=3.0, label=label)
    axes.set(xlabel=over, ylabel="stress" if len(curves) > 1 else curves[0].replace("_", " "))
    if over == "cells":
        axes.set(xscale="log", yscale="log")
    if len(curves) > 1:
        axes.legend(fontsize=8)
    axes.grid(color="#dddddd", linewidth=0.6)
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


def _with_unit(label: str, unit: str | None) -> str:
    return label if unit is None else f"{label} in {unit}"


def _drawn_as(scale: float) -> str:
    return f"deformation x{scale:.3g}"


def _prepared(axes: Axes | None, length_unit: str | None) -> Axes:
    if axes is None:
        figure = new_figure(8.0, 5.5)
        figure.set_layout_engine("compressed")  # the colour bar is as high as what is drawn
        axes = figure.subplots()
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel=_with_unit("x", length_unit), ylabel=_with_unit("y", length_unit))
    return axes


def _fit(axes: Axes, points: Floats) -> None:
    """Show all points, and what earlier calls have shown."""
    axes.update_datalim(points)
    axes.margins(0.03)
    axes.autoscale_view()


def _fine_display(space: Space) -> Display:
    """A display with about as many triangles as a picture can show."""
    room = np.sqrt(MANY_TRIANGLES / len(space.mesh.cell_points))
    return display(space, int(max(space.order, min(MAX_PIECES, room))))


def _fill(
    axes: Axes, shown: Display, points: Floats, values: Floats, label: str, limits: tuple[float, float] | None
) -> None:
    low, high = (float(values.min()), float(values.max())) if limits is None else limits
    if not low <= high:
        raise InputError(f"limits = {limits}", "the lesser value first", "exchange them")
    if not high - low > 1e-12 * max(abs(low), abs(high)):
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    signed = low < 0.0 < high
    if signed:
        low, high = -max(-low, high), max(-low, high)
    colours = axes.tripcolor(
        Triangulation(points[:, 0], points[:, 1], shown.triangles),
        values,
        shading="gouraud",
        cmap=SIGNED if signed else COLOURS,
        norm=Normalize(low, high),
        rasterized=True,
    )
    below, above = values.min() < low, values.max() > high
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}.get((below, above), "both")
    figure = cast(Figure, axes.get_figure(root=True))
    figure.colorbar(colours, ax=axes, label=label, extend=extend, shrink=0.9)


def _drawn(
    solution: ElasticField,
    shown: Display,
    values: Floats,
    label: str,
    axes: Axes | None,
    factor: Factor,
    limits: tuple[float, float] | None,
    edges: bool,
    length_unit: str | None,
) -> Axes:
    axes = _prepared(axes, length_unit)
    scale = _factor(solution, factor)
    mesh = shown.mesh
    points = shown.points
    if scale:
        points = points + scale * shown.function(solution.displacements)
        axes.set_title(_drawn_as(scale), fontsize=10)
        draw_outline(axes, mesh, dashed=True)
    _fill(axes, shown, points, values, label, limits)
    lines = _moved_edges(solution, scale)
    if edges:
        _draw_edges(axes, lines, mesh)
    axes.add_collection(LineCollection(list(lines[mesh.edge_cells[:, 1] < 0]), colors=INK, linewidths=0.9))
    _fit(axes, np.vstack([points, mesh.points]))
    return axes


def _factor(solution: ElasticField, factor: Factor) -> float:
    if factor != "auto":
        if not np.isfinite(factor):
            raise InputError(f"factor = {factor}", "a finite number or 'auto'", "leave it out")
        return float(factor)
    maximum = float(np.hypot(*solution.displacements[: solution.problem.space.n_nodes].T).max())
    if not maximum > 0.0:
        return 1.0
    wanted = DEFORMATION_SHARE * solution.problem.size / maximum
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(digit for digit in (1, 2, 5) if digit * power <= wanted * (1.0 + 1e-9)))


def _moved_edges(solution: ElasticField, scale: float) -> Floats:
    """Lines (n_edges, n, 2) along the edges, with as many pieces as their order needs."""
    space = solution.problem.space
    order = space.order
    weights = edge_weights(order, 1 if order == 1 or not (scale or space.mesh.curves) else 4 * order)
    nodes = space.edge_nodes(space.mesh.edges)
    moved = space.nodes + scale * solution.displacements[: space.n_nodes]
    return np.einsum("pn,eni->epi", weights, moved[nodes])


def _draw_edges(axes: Axes, lines: Floats, mesh: PolyMesh) -> None:
    axes.add_collection(LineCollection(list(lines), colors=GREY, linewidths=_line_width(mesh), alpha=0.7))


def _line_width(mesh: PolyMesh) -> float:
    return float(np.clip(12.0 / np.sqrt(mesh.n_cells), 0.1, 0.6))


def _draw_rim(axes: Axes, mesh: PolyMesh) -> None:
    axes.add_collection(LineCollection(list(mesh.points[mesh.boundary_edges]), colors=INK, linewidths=0.9))
