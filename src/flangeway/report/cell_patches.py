"""Cells of large meshes as patches of colour, quickly."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.report.drawing import StressColours

Floats = NDArray[np.float64]


def fill_cells(
    axes: Axes,
    mesh: PolyMesh,
    points: Floats,
    values: Floats,
    colours: StressColours,
    *,
    chosen: NDArray[np.bool_] | None = None,
    lines: Any = "face",
) -> None:
    """Fill cells by their values: one collection for each number of corners, which needs no path for each cell.

    Parameters
    ----------
    axes
        Where to draw; its limits stay.
    mesh, points
        The mesh, and where its points are drawn, shape (n_points, 2).
    values
        Of all cells, shape (n_cells,).
    colours
        Steps of colour.
    chosen
        Cells that are drawn, shape (n_cells,); all if left out.
    lines
        Colour of the cells' edges; ``"face"``: that of the cell.

    """
    for n_vertices, cells in mesh.batches():
        mine = cells if chosen is None else cells[chosen[cells]]
        if len(mine) == 0:
            continue
        corners: Any = points[mesh.batch_points(n_vertices, mine)]
        patches = PolyCollection(corners, cmap=colours.map, norm=colours.norm, linewidths=0.2)
        patches.set_array(values[mine])
        patches.set_edgecolor(lines)
        axes.add_collection(patches, autolim=False)
