"""Deformed bodies with stresses in colours, as all pictures of fields draw them: inside the elements as they are."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from flangeway.exact import LineContact
from flangeway.mesh import PolyMesh
from flangeway.post import PressurePatch, Stresses
from flangeway.problems import ElasticField
from flangeway.quantities import measured
from flangeway.report.figures.display import Display, display, displayed_stresses, edge_weights
from flangeway.report.figures.drawing import (
    GREY,
    HERTZ,
    INK,
    NODES,
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
)
from flangeway.report.page.tables import marked
from flangeway.space import Space
from flangeway.types import Bools, Floats
from flangeway.units import Units


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
        found = np.zeros(self.space.mesh.n_cells, dtype=np.bool_)
        found[self.shown.cells[inside]] = True
        return found

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
MAX_HEIGHT_IN, MIN_HEIGHT_IN, MAX_WIDTH_IN = 5.0, 1.6, 11.0
"""Of panels: height, least height of all, width of all."""
LABELS_IN, BAR_IN = 0.8, 1.0
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
    figure, ((axes,),) = panels(8.0, 4.5, units=units)
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
