"""Contours of a field of any sign in steps of colour that stay apart in grey."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from flangeway.mesh import PolyMesh
from flangeway.report.figures.drawing import INK, boundary_loops, triangles
from flangeway.types import Floats

N_LEVELS = 12


class Shades:
    """Steps from light, the least value, to dark, the greatest.

    Parameters
    ----------
    values
        All values to be shown.

    """

    def __init__(self, values: Floats) -> None:
        low, high = float(values.min()), float(values.max())
        if not high - low > 1e-12 * max(abs(low), abs(high)):
            low, high = low - 0.5, high + 0.5
        locator = MaxNLocator(nbins=N_LEVELS, steps=[1, 2, 2.5, 5, 10])
        self.levels: Floats = np.asarray(locator.tick_values(low, high))
        self.map = ListedColormap(mpl.colormaps["magma_r"](np.linspace(0.02, 0.9, 256)))
        self.norm = BoundaryNorm(self.levels.tolist(), self.map.N)

    def mappable(self) -> ScalarMappable:
        """For the colour bar."""
        return ScalarMappable(self.norm, self.map)


def draw_field(axes: Axes, mesh: PolyMesh, values: Floats, shades: Shades, *, lines: bool = True) -> None:
    """Fill between contour lines of values at a mesh's points (n_points,); dashed lines are negative."""
    surface = Triangulation(mesh.points[:, 0], mesh.points[:, 1], triangles(mesh))
    # rounding below the first level would leave a hole
    values = np.clip(values, shades.levels[0], shades.levels[-1])
    axes.tricontourf(surface, values, levels=shades.levels, cmap=shades.map, norm=shades.norm)
    if lines:
        styles = ["dashed" if level < 0.0 else "solid" for level in shades.levels]
        axes.tricontour(surface, values, levels=shades.levels, colors=INK, linewidths=0.5, linestyles=styles)


def draw_boundary(axes: Axes, mesh: PolyMesh) -> None:
    """Draw the outer boundary and the holes'."""
    for loop in boundary_loops(mesh):
        axes.plot(*mesh.points[loop].T, color=INK, linewidth=0.9)
