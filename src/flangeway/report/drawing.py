"""What all pictures share: sizes, colours that stay apart in grey, cells, contour lines, outlines."""

import io
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray
from PIL import Image

from flangeway.mesh import PolyMesh
from flangeway.report.fields import PartFields

Floats = NDArray[np.float64]

DPI = 160
N_COLOURS = 256
INK = "#1a1a1a"
GREY = "#777777"
HALO = withStroke(linewidth=2.0, foreground="white")
N_LEVELS = 10
CONTOUR = "contour"
LABELS_APART = 0.11  # of the width of the axes


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure, apart from any global state of matplotlib."""
    figure = Figure(figsize=(width_in, height_in), dpi=DPI, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """Return a figure as the contents of a PNG file with at most 256 colours of its own.

    Figures have few, and shades hardly change: a third of the size, and drawn and packed once for file and report.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format="rgba", dpi=dpi)
    width, height = (int(side * dpi) for side in figure.get_size_inches())
    picture = Image.frombytes("RGBA", (width, height), drawn.getvalue()).convert("RGB")
    few = picture.quantize(N_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, "PNG")
    return buffer.getvalue()


class StressColours:
    """Steps of colour from light, unloaded, to dark, most loaded: in grey too.

    Parameters
    ----------
    values
        All values to be shown in MPa: none below zero, or none above.

    """

    def __init__(self, values: Floats) -> None:
        low, high = float(values.min(initial=0.0)), float(values.max(initial=0.0))
        self.compressive = -low > high
        span = (low, 0.0) if self.compressive else (0.0, max(high, 1e-6))
        self.levels: Floats = np.asarray(MaxNLocator(nbins=N_LEVELS, steps=[1, 2, 2.5, 5, 10]).tick_values(*span))
        shades = mpl.colormaps["magma_r"](np.linspace(0.0, 0.9, 256))
        self.map = ListedColormap(shades[::-1] if self.compressive else shades)
        self.norm = BoundaryNorm(self.levels.tolist(), self.map.N)

    def mappable(self) -> ScalarMappable:
        """For the colour bar."""
        return ScalarMappable(self.norm, self.map)

    @property
    def lines(self) -> Floats:
        """Levels worth a contour line: every second one, without zero."""
        levels = self.levels[::-1] if self.compressive else self.levels
        return np.sort(levels[2:-1:2])


def draw_contours(axes: Axes, part: PartFields, points: Floats, values: Floats, colours: StressColours) -> None:
    """Draw lines of equal value, from means about the points, with numbers that keep apart; set the axes first."""
    smooth = part.at_points(values)
    levels = [v for v in colours.lines.tolist() if smooth.min() < v < smooth.max()]
    if not levels:
        return
    lines = axes.tricontour(
        Triangulation(points[:, 0], points[:, 1], triangles(part.mesh)),
        smooth,
        levels=levels,
        colors=INK,
        linewidths=0.5,
        linestyles="solid",
    )
    apart = LABELS_APART * abs(np.subtract(*axes.get_xlim()))
    places = [text.get_position() for text in axes.texts if text.get_gid() == CONTOUR]
    for label in axes.clabel(lines, fmt="%g", fontsize=6.5, inline=False):
        x, y = label.get_position()
        if not _well_inside(axes, x, y) or any(
            np.hypot(x - other_x, y - other_y) < apart for other_x, other_y in places
        ):
            label.remove()
            continue
        label.set(path_effects=[HALO], zorder=6, gid=CONTOUR)
        places.append((x, y))


def _well_inside(axes: Axes, x: float, y: float) -> bool:
    """Whether a label at a place would not be cut by the axes."""
    places = axes.transAxes.inverted().transform(axes.transData.transform((x, y)))
    return bool((np.abs(places - 0.5) < 0.47).all())


def draw_outline(axes: Axes, mesh: PolyMesh, points: Floats, *, dashed: bool = False) -> None:
    """Draw the boundary of a part at `points`."""
    for loop in boundary_loops(mesh):
        axes.plot(
            points[loop, 0],
            points[loop, 1],
            color=GREY if dashed else INK,
            linewidth=0.9,
            linestyle=(0, (4, 2)) if dashed else "solid",
        )


def equal_axes(axes: Axes, corners: Floats) -> None:
    """Show the box (2, 2) with one scale for both axes, labelled in mm."""
    axes.set_xlim(corners[0, 0], corners[1, 0])
    axes.set_ylim(corners[0, 1], corners[1, 1])
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x in mm")
    axes.set_ylabel("y in mm")


def box(points: Sequence[Floats], margin: float) -> Floats:
    """Return the corners (2, 2) of the box about all points, widened."""
    every = np.vstack(points)
    return np.array([every.min(axis=0) - margin, every.max(axis=0) + margin])


def boundary_loops(mesh: PolyMesh) -> list[NDArray[np.int64]]:
    """Points along each closed boundary, the first repeated at the end."""
    after = dict(mesh.boundary_edges.tolist())
    loops = []
    while after:
        loop = [next(iter(after))]
        while loop[-1] in after:
            loop.append(after.pop(loop[-1]))
        loops.append(np.array(loop))
    return loops


def cell_corners(mesh: PolyMesh, points: Floats) -> list[Floats]:
    """Corners of each cell at the given positions of the mesh's points, each (n_vertices, 2)."""
    return np.split(points[mesh.cell_points], mesh.cell_offsets[1:-1])


def triangles(mesh: PolyMesh) -> NDArray[np.int32]:
    """Polygons as fans of triangles about their first corner, shape (n, 3)."""
    fans = []
    for n_vertices, cells in mesh.batches():
        corners = mesh.batch_points(n_vertices, cells)
        fans += [corners[:, [0, i, i + 1]] for i in range(1, n_vertices - 1)]
    return np.vstack(fans)
