"""How the examples of this folder draw: cells of a mesh with colours, also moved by displacements."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from flangeway.mesh import PolyMesh


def draw(
    mesh: PolyMesh, values: ArrayLike | None = None, moved: ArrayLike | None = None, colours: str = "viridis"
) -> Figure:
    """Draw a mesh; values are at its points or in its cells, and points can be moved, (n_points, 2)."""
    points = mesh.points if moved is None else mesh.points + np.asarray(moved)[: mesh.n_points]
    cells = np.split(points[mesh.cell_points], mesh.cell_offsets[1:-1])
    figure = Figure(figsize=(3.2, 3.2), layout="constrained")
    axes = figure.add_subplot()
    width = min(0.6, 12.0 / mesh.n_cells**0.5)
    if values is None:
        axes.add_collection(PolyCollection(cells, facecolor="#e8eef5", edgecolor="#2b5c8a", linewidth=width))
    else:
        given: NDArray[np.float64] = np.asarray(values, dtype=np.float64)
        if len(given) != mesh.n_cells:  # means over the cells' points
            sums = np.add.reduceat(given[mesh.cell_points], mesh.cell_offsets[:-1])
            given = sums / mesh.cell_sizes
        shown = PolyCollection(cells, array=given, cmap=colours, edgecolor="face", linewidth=0.2)
        axes.add_collection(shown)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def curves(
    *lines: tuple[ArrayLike, ArrayLike, str], logarithmic: bool = False, axes: tuple[str, str] = ("", "")
) -> Figure:
    """Draw lines of x, y and a label."""
    figure = Figure(figsize=(3.2, 3.2), layout="constrained")
    panel = figure.add_subplot()
    for x, y, label in lines:
        panel.plot(x, y, "o-", ms=3, label=label)
    if logarithmic:
        panel.set(xscale="log", yscale="log")
    panel.set(xlabel=axes[0], ylabel=axes[1])
    panel.legend(frameon=False, fontsize=8)
    panel.grid(color="#e4e4e4")
    return figure
