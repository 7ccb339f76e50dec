"""Pictures of meshes, fields, deformed shapes and stresses on cells of any shape and order."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, singledispatch
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from flangeway.contact import ContactSolution
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry.arrays import norms
from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.post import AdaptiveRun, PressurePatch, Stresses, StressLine
from flangeway.problems import ElasticField
from flangeway.quantities import measured
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.records import require_known
from flangeway.report.figures.display import (
    Display,
    display,
    displayed_stresses,
    edge_weights,
)
from flangeway.report.figures.drawing import (
    GREY,
    HERTZ,
    INK,
    NODES,
    PAGE_IN,
    SERIES,
    Style,
    colour_bar,
    draw_lines,
    equal_axes,
    fill_triangles,
    legend_below,
    name_axes,
    new_figure,
    panels,
    shade_of,
    with_unit,
)
from flangeway.report.page.record import marked, named
from flangeway.results import Result, Shown
from flangeway.solve import TorsionSolution
from flangeway.space import Space
from flangeway.types import Bools, Floats, floats
from flangeway.units import Units

# --- Deformed bodies with stresses in colours, as all pictures of fields draw them: inside the elements as they are.


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """A body as it is drawn.

    - `field`: displacements in the frame of the body.
    - `place`: function of points (n, 2) and displacements (n, 2) of the body that returns where they are drawn.
    - `pieces`: into how many pieces the sides of cells are cut, see `display`.
    """

    field: ElasticField
    place: Callable[[Floats, Floats], Floats]
    pieces: int | None = None

    @property
    def space(self) -> Space:
        """Space of the displacements."""
        return self.field.space

    @cached_property
    def shown(self) -> Display:
        """Triangles of its cells."""
        return display(self.space, self.pieces)

    @cached_property
    def stresses(self) -> Stresses:
        """Stresses at the points of the triangles."""
        return displayed_stresses(self.field, self.shown)

    @cached_property
    def points(self) -> Floats:
        """Where these points are drawn, shape (n, 2)."""
        return self.place(self.shown.points, self.shown.function(self.field.displacements))

    @property
    def edges(self) -> Floats:
        """Lines (n_edges, n, 2) where the edges of the cells are drawn; those of order 2 and more are curved."""
        return edge_lines(self.space, self.place, self.field.displacements)

    def within(self, window: Floats) -> Bools:
        """Whether a cell has a point in a window (2, 2), shape (n_cells,)."""
        inside = ((self.points >= window[0]) & (self.points <= window[1])).all(axis=1)
        among = np.zeros(self.space.mesh.n_cells, dtype=np.bool_)
        among[self.shown.cells[inside]] = True
        return among

    def draw(self, axes: Axes, values: Floats, shade: ScalarMappable, cells: Bools | None = None) -> None:
        """Draw values at the points of the triangles, edges of cells, and the outline.

        - `cells`: cells that have colours, (n_cells,); all if left out.
        """
        triangles = self.shown.triangles
        if cells is not None:
            triangles = triangles[cells[self.shown.cells[triangles[:, 0]]]]
        if len(triangles):
            fill_triangles(axes, self.points, triangles, values, shade)
        lines, mesh = self.edges, self.space.mesh
        draw_lines(axes, lines, GREY, line_width(mesh), 0.7)
        draw_lines(axes, lines[mesh.edge_cells[:, 1] < 0], INK, 0.9)


def edge_lines(space: Space, place: Callable[[Floats, Floats], Floats], displacements: Floats | None = None) -> Floats:
    """Lines (n_edges, n, 2) along the edges, with as many pieces as their order and curves need.

    - `place`: as in `DrawnBody`.
    - `displacements`: unknowns of the displacements; none if left out.
    """
    order, n = space.order, space.n_nodes
    moves = displacements is not None
    weights = edge_weights(order, 1 if order == 1 or not (moves or space.mesh.curves) else 4 * order)
    nodes = space.edge_nodes(space.mesh.edges)
    moved = place(space.nodes, displacements[:n] if displacements is not None else np.zeros((n, 2)))
    return np.einsum("pn,eni->epi", weights, moved[nodes])


def line_width(mesh: PolyMesh) -> float:
    """Width of the lines between cells: thinner for more cells."""
    return float(np.clip(12.0 / np.sqrt(mesh.n_cells), 0.1, 0.6))


COLOUR_QUANTILE = 0.999
"""Fraction of the values within the range of colours: stresses at sharp corners are singular."""
MAX_HEIGHT_IN, MIN_HEIGHT_IN, MAX_WIDTH_IN = 3.4, 1.2, 5.0
"""Of panels: height, least height of all, width of all."""
LABELS_IN, BAR_IN = 0.75, 0.8
"""For the labels of a panel and its title, and for the bar of colours."""


def stress_panels(
    bodies: Sequence[DrawnBody], windows: Sequence[Floats], units: Units = "metric"
) -> tuple[Figure, Sequence[Axes]]:
    """Draw the von Mises stress on deformed bodies, from zero, in windows (2, 2) beside each other, in one scale."""
    values = [body.stresses.von_mises for body in bodies]
    inside = [[body.within(window) for window in windows] for body in bodies]
    shown = zip(bodies, values, inside, strict=True)
    every = np.concatenate([stress[np.any(cells, axis=0)[body.shown.cells]] for body, stress, cells in shown])
    maximum = float(np.quantile(every, COLOUR_QUANTILE)) or float(every.max()) or 1.0
    shade = shade_of(every, (0.0, maximum))
    widths = [float(np.divide(*np.ptp(window, axis=0))) for window in windows]  # of panels one inch high
    height = min(MAX_HEIGHT_IN, MAX_WIDTH_IN / sum(widths))
    width = height * sum(widths) + LABELS_IN * len(windows) + BAR_IN
    figure = new_figure(width, max(height, MIN_HEIGHT_IN) + LABELS_IN, units, compressed=True)
    every_axes = figure.subplots(1, len(windows), squeeze=False, width_ratios=widths)[0]
    for number, (axes, window) in enumerate(zip(every_axes, windows, strict=True)):
        for body, stress, cells in zip(bodies, values, inside, strict=True):
            if cells[number].any():
                body.draw(axes, stress, shade, cells[number])
        equal_axes(axes, window)
    extend = "max" if float(every.max()) > maximum else "neither"
    colour_bar(shade, list(every_axes), "von Mises stress", "MPa", extend=extend)
    return figure, every_axes


def pressure_curves(
    patches: Iterable[tuple[str, PressurePatch, LineContact | None]], units: Units = "metric"
) -> Figure:
    """Draw the pressures of the nodes along named regions of contact, with Hertz's where there are."""
    figure, ((axes,),) = panels(PAGE_IN, 3.6, units=units)
    for number, (name, patch, hertz) in enumerate(patches):
        colour = SERIES[number % len(SERIES)]
        maximum = marked(measured(float(patch.pressures.max()), "MPa", units), patch.remark)
        style: Style = NODES | {"marker": "osD^"[number % 4], "color": colour}
        axes.plot(patch.along, patch.pressures, label=f"{name}: maximum {maximum}", **style)
        if hertz is not None:
            label = f"Hertz, same force: maximum {measured(hertz.max_pressure, 'MPa', units)}"
            axes.plot(*hertz.curve, color=colour, alpha=0.6, label=label, **HERTZ)
    axes.set_ylim(0.0, 1.05 * float(axes.dataLim.y1))
    words = "length along the surface from the centre of pressure"
    name_axes(axes, (words, "mm"), ("contact pressure", "MPa"))
    legend_below(figure, 2)
    return figure


def drawn_parts(result: WheelsetResult) -> dict[str, DrawnBody]:
    """Deformed wheels and rails by their names, where they are in the track."""

    def placed(name: str, points: Floats, moved: Floats) -> Floats:
        return result.placements[name].points(points + moved)

    return {
        name: DrawnBody(ElasticField(part.body.elasticity, result.displacements[name]), partial(placed, name))
        for name, part in result.model.parts.items()
    }


# --- Pictures of meshes, fields, deformed shapes and stresses on cells of any shape and order.


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
    require_known("component", component, get_args(Component))
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
    require_known("quantity", quantity, get_args(Quantity))
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
def plot_result(result: Shown, **options: Any) -> Figure:
    """Draw what a result is about, and return the figure.

    Elastic fields are drawn by `plot_stress`, functions of torsion by `plot_function`, stresses along lines and
    pressures over the length, adaptive runs as error over cells, runs of cases as the first picture of their report,
    meshes by their cells or outer faces, profiles by outline and running surface, patches by their pressures.

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
    figure = new_figure(PAGE_IN, 4.2)
    for axes, part in zip(figure.subplots(1, len(parts), squeeze=False)[0], parts, strict=True):
        plot_stress(result.field(part), axes=axes, **options)
        axes.set_title(part.name, fontsize=9)
    return figure


@plot_result.register(StressLine)
@plot_result.register(PressurePatch)
@plot_result.register(AdaptiveRun)
def _(result: Result) -> Figure:
    """Curves of the last columns of the table over the one of the length, or of the cells."""
    columns = result.table.columns
    over = next(name for name in ("distance", "along", "cells") if name in columns)
    curves = ("xx", "yy", "xy", "zz", "von_mises") if over == "distance" else list(columns)[-1:]
    figure, ((axes,),) = panels(PAGE_IN, 3.6)
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
    axes = axes or new_figure(PAGE_IN, 4.2, compressed=True).subplots()
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
        axes.set_title(f"deformation x{scale:.3g}", fontsize=9)
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
