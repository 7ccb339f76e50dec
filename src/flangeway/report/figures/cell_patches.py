"""Cells of large meshes in steps of colour, quickly: a path for each step, not a patch for each cell."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.report.figures.drawing import ColourSteps
from flangeway.types import Floats

Colour = tuple[float, float, float, float]

LINE_WIDTH = 0.2
NOT_SHOWN = -1


def fill_cells(
    axes: Axes,
    mesh: PolyMesh,
    points: Floats,
    values: Floats,
    colours: ColourSteps,
    *,
    chosen: NDArray[np.bool_] | None = None,
    lines: Colour | None = None,
) -> None:
    """Fill cells by their values (n_cells,), the mesh's points being drawn at `points` (n_points, 2).

    All cells of the first step of colour or a later one are filled as one path, then over it all of the second or a
    later one, and so on: so there are no gaps between cells. `chosen` (n_cells,) are the cells that are drawn, by
    default all; `lines` is the colour of their edges, which are not drawn by default. The limits of the axes stay.
    """
    levels = colours.levels
    steps = np.clip(np.searchsorted(levels, values, side="right") - 1, 0, len(levels) - 2)
    if chosen is not None:
        steps = np.where(chosen, steps, NOT_SHOWN)
    present = [step for step in np.unique(steps).tolist() if step != NOT_SHOWN]
    paths = [cells_path(mesh, points, np.flatnonzero(steps >= step)) for step in present]
    shades = colours.map(colours.norm([0.5 * (levels[step] + levels[step + 1]) for step in present]))
    regions = PathCollection(paths, facecolors=shades, linewidths=0.0)
    regions.set_snap(False)
    axes.add_collection(regions, autolim=False)
    if lines is not None:
        edges = np.unique(mesh.cell_edges[np.repeat(steps != NOT_SHOWN, mesh.cell_sizes)])
        draw_lines(axes, points[mesh.edges[edges]], lines, LINE_WIDTH)


def draw_lines(axes: Axes, lines: Floats, colour: str | Colour, width: float, alpha: float | None = None) -> None:
    """Draw lines of equally many points, shape (n_lines, n, 2), as one path: much faster than a path for each."""
    codes = np.full(lines.shape[:2], Path.LINETO, dtype=Path.code_type)
    codes[:, 0] = Path.MOVETO
    path = Path(lines.reshape(-1, 2), codes.ravel())
    axes.add_artist(PathPatch(path, facecolor="none", edgecolor=colour, linewidth=width, alpha=alpha, zorder=2))


def cells_path(mesh: PolyMesh, points: Floats, cells: NDArray[np.integer]) -> Path:
    """One path about each of some cells (n,), the points of the mesh being drawn at `points` (n_points, 2)."""
    sizes = mesh.cell_sizes[cells].astype(np.int64)
    ends = np.cumsum(sizes + 1)
    place = np.arange(ends[-1]) - np.repeat(ends - sizes - 1, sizes + 1)
    last = place == np.repeat(sizes, sizes + 1)
    codes = np.full(len(place), Path.LINETO, dtype=Path.code_type)
    codes[place == 0], codes[last] = Path.MOVETO, Path.CLOSEPOLY
    corners = np.repeat(mesh.cell_offsets[cells], sizes + 1) + np.where(last, 0, place)
    return Path(points[mesh.cell_points[corners]], codes)
