"""Cells of large meshes in steps of colour, quickly: a region for each step, not a patch for each cell."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.report.figures.drawing import StressColours
from flangeway.types import Floats, Ints

Colour = tuple[float, float, float, float]

LINE_WIDTH = 0.2
NOT_SHOWN = -1


def fill_cells(
    axes: Axes,
    mesh: PolyMesh,
    points: Floats,
    values: Floats,
    colours: StressColours,
    *,
    chosen: NDArray[np.bool_] | None = None,
    lines: Colour | None = None,
) -> None:
    """Fill cells by their values.

    All cells of the first step of colour or a later one are filled as one region, then over it all of the second or a
    later one, and so on: no gap opens between cells, and only the edges at which the colour changes are drawn.

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
        Colour of the cells' edges; they are not drawn if it is left out.

    """
    levels = colours.levels
    steps = np.clip(np.searchsorted(levels, values, side="right") - 1, 0, len(levels) - 2)
    if chosen is not None:
        steps = np.where(chosen, steps, NOT_SHOWN)
    found = _regions(mesh, points, steps)
    shades = colours.map(colours.norm([0.5 * (levels[step] + levels[step + 1]) for step in found]))
    regions = PathCollection(list(found.values()), facecolors=shades, linewidths=0.0)
    regions.set_snap(False)
    axes.add_collection(regions, autolim=False)
    if lines is not None:
        pairs = mesh.edges[np.unique(mesh.cell_edges[_corners(mesh, steps)[0]])]
        draw_lines(axes, points[pairs], lines, LINE_WIDTH)


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


def _corners(mesh: PolyMesh, steps: Ints) -> tuple[Ints, Ints]:
    """Corners of the cells that are shown, as places in `PolyMesh.cell_points`, and their cells."""
    owners = np.repeat(np.arange(mesh.n_cells), mesh.cell_sizes)
    corners = np.flatnonzero((steps != NOT_SHOWN)[owners])
    return corners, owners[corners]


def _regions(mesh: PolyMesh, points: Floats, steps: Ints) -> dict[int, Path]:
    """Region of all cells of a step or a later one, by the steps that there are; `NOT_SHOWN` is outside of all."""
    corners, owners = _corners(mesh, steps)
    pairs = mesh.edge_cells[mesh.cell_edges[corners]]
    others = np.where(pairs[:, 0] == owners, pairs[:, 1], pairs[:, 0])
    mine, beyond = steps[owners], np.where(others < 0, NOT_SHOWN, steps[others])
    present = np.unique(mine).tolist()
    rim = np.flatnonzero(mine > beyond)
    mine, beyond, corners, owners = mine[rim], beyond[rim], corners[rim], owners[rim]
    last = corners + 1 == mesh.cell_offsets[owners + 1]
    starts, ends = mesh.cell_points[corners], mesh.cell_points[np.where(last, mesh.cell_offsets[owners], corners + 1)]
    regions = {}
    for step in present:
        here = (mine >= step) & (beyond < step)
        order, first = _loops(starts[here], ends[here])
        codes = np.where(first, Path.MOVETO, Path.LINETO).astype(Path.code_type)
        regions[step] = Path(points[starts[here][order]], codes)
    return regions


def _loops(starts: NDArray[np.integer], ends: NDArray[np.integer]) -> tuple[list[int], list[bool]]:
    """Order of directed edges along closed loops, and whether each is the first of its loop.

    Each point starts as many edges as it ends, so that the edges sorted by their starts follow those sorted by ends.
    """
    following = np.empty(len(starts), dtype=np.int64)
    following[np.argsort(ends, kind="stable")] = np.argsort(starts, kind="stable")
    left = following.tolist()
    order, first = [], []
    for edge in range(len(left)):
        new, at = True, edge
        while left[at] >= 0:
            order.append(at)
            first.append(new)
            new, left[at], at = False, -1, left[at]
    return order, first
