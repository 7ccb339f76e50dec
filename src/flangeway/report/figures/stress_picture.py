"""Deformed bodies with stresses in colours, as all pictures of fields draw them: inside the elements as they are."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from flangeway.mesh import PolyMesh
from flangeway.post import Stresses
from flangeway.problems import ElasticField
from flangeway.report.figures.display import Display, display, displayed_stresses, edge_weights
from flangeway.report.figures.drawing import GREY, INK, draw_lines, fill_triangles, shade_of
from flangeway.space import Space
from flangeway.types import Bools, Floats


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
        return self.field.problem.space

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

    def draw(
        self, axes: Axes, values: Floats, shade: ScalarMappable, cells: Bools | None = None, *, edges: bool = True
    ) -> None:
        """Draw values at the points of the triangles, edges of cells, and the outline.

        - `cells`: cells that have colours, (n_cells,); all if left out.
        - `edges`: whether edges inside are drawn.
        """
        triangles = self.shown.triangles
        if cells is not None:
            triangles = triangles[cells[self.shown.cells[triangles[:, 0]]]]
        if len(triangles):
            fill_triangles(axes, self.points, triangles, values, shade)
        lines, mesh = self.edges, self.space.mesh
        if edges:
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


def stress_shade(values: Sequence[Floats]) -> tuple[ScalarMappable, str]:
    """Return the colours of equivalent stresses from zero, and which end of their bar is open."""
    every = np.concatenate(values)
    maximum = float(np.quantile(every, COLOUR_QUANTILE)) or float(every.max()) or 1.0
    return shade_of(every, (0.0, maximum)), "max" if float(every.max()) > maximum else "neither"
