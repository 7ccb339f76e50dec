"""What all pictures share: sizes, colours that stay apart in grey, cells, contour lines, outlines."""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PathCollection
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray
from PIL import Image

from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.report.figures.fields import PartFields
from flangeway.types import Floats

DPI = 160
INK = "#1a1a1a"
GREY = "#777777"
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours of lines and points one after the other: those of Okabe and Ito (2008), which the colour-blind can tell."""
SIDE_COLOURS = {"left": SERIES[1], "right": SERIES[0]}
SIGNED: Colormap = ListedColormap(mpl.colormaps["RdBu_r"](np.linspace(0.04, 0.96, 256)))
"""For values on both sides of zero, which is white: blue below, red above, equally dark at equal distances."""
POWERS = str.maketrans("23", "²³")
HALO = withStroke(linewidth=2.0, foreground="white")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
CONTOUR = "MPa"  # `gid` of the numbers on lines of equal stress: their unit
LABELS_APART = 0.11  # of the width of the axes


class ShownFigure(Figure):
    """A figure that notebooks show without a global state of matplotlib; what it draws has the colours of `SERIES`."""

    def add_subplot(self, *args: Any, **kwargs: Any) -> Axes:
        """Add axes as matplotlib does, which adds all axes of `Figure.subplots` by this method."""
        axes = super().add_subplot(*args, **kwargs)
        axes.set_prop_cycle(color=SERIES)
        return axes

    def _repr_png_(self) -> bytes:
        return png(self)


def new_figure(width_in: float, height_in: float, *, measured: bool = True) -> Figure:
    """Return an empty figure, apart from any global state of matplotlib.

    If it is measured, it makes room for all labels by itself when it is drawn.
    """
    figure = ShownFigure(figsize=(width_in, height_in), dpi=DPI, facecolor="white")
    figure.set_layout_engine("constrained" if measured else "none")
    FigureCanvasAgg(figure)
    return figure


@dataclass(frozen=True)
class Room:
    """Room about panels for labels, titles and legends, in inches."""

    left: float = 0.75
    right: float = 0.2
    bottom: float = 0.55
    top: float = 0.35  # left, right, bottom, top: beyond the outermost panels
    across: float = 0.8
    between: float = 0.8  # across, between: between panels beside each other, and between rows


def figure_with_room(
    width_in: float,
    height_in: float,
    room: Room,
    n_rows: int = 1,
    n_columns: int = 1,
    *,
    width_ratios: Sequence[float] | None = None,
    sharex: bool = False,
    sharey: bool = False,
) -> tuple[Figure, NDArray[Any]]:
    """Return a figure and its panels, shape (n_rows, n_columns), with given room about them.

    For pictures whose labels are known beforehand: to measure them all, several times, takes as long as to draw.
    """
    figure = new_figure(width_in, height_in, measured=False)
    width = (width_in - room.left - room.right - (n_columns - 1) * room.across) / n_columns
    height = (height_in - room.bottom - room.top - (n_rows - 1) * room.between) / n_rows
    panels = figure.subplots(
        n_rows,
        n_columns,
        squeeze=False,
        sharex=sharex,
        sharey=sharey,
        width_ratios=width_ratios,
        gridspec_kw={
            "left": room.left / width_in,
            "right": 1.0 - room.right / width_in,
            "bottom": room.bottom / height_in,
            "top": 1.0 - room.top / height_in,
            "wspace": room.across / width,
            "hspace": room.between / height,
        },
    )
    return figure, panels


def draw_title(axes: Axes, text: str, size: float = 10.0) -> None:
    """Set the title right above the axes; if it has to find a place, matplotlib measures all labels once more."""
    axes.set_title(text, fontsize=size, y=1.0)


def power_of_ten(value: float, _position: int | None = None) -> str:
    """Label of a power of ten; matplotlib's own of logarithmic axes are formulas, which take a tenth of a second."""
    return "10" + f"{round(np.log10(value))}".translate(SUPERSCRIPTS)


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """Return a figure as the contents of a PNG file of 256 colours: less than half the size of one of all colours."""
    canvas: Any = FigureCanvasAgg(figure)
    figure.set_dpi(dpi)
    canvas.draw()
    pixels = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    buffer = io.BytesIO()
    pixels.quantize(method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(buffer, "PNG")
    return buffer.getvalue()


QUANTITIES = {
    "head_lateral_mm": "railhead lateral displacement",
    "head_vertical_mm": "top of the head, up",
    "head_roll_mrad": "roll of the head",
    "gauge_outward_mm": "gauge-face deflection (outwards)",
    "lateral_mm": "lateral displacement to the right",
    "lateral_over_vertical": "L/V",
    "semi_axes_a_mm": "semi-axis a",
    "semi_axes_b_mm": "semi-axis b",
    "max_pressure_MPa": "maximum pressure",
    "n_patches": "number of patches",
    "angle_deg": "orientation of the major axis",
    "rail_position_x_mm": "x on the rail",
    "rail_position_y_mm": "y on the rail",
    "wheel_position_x_mm": "x on the wheel",
    "wheel_position_y_mm": "y on the wheel",
    "vertical_mm": "vertical displacement, up",
    "car_mass_t": "mass of the car",
    "n_axles": "number of axles",
    "size_scale": "factor on the sizes of the elements",
}
"""What keys mean whose words are not enough."""
NAMES = {"von mises": "von Mises", "hertz": "Hertz", "lame ": "Lamé's ", "max ": "maximum "}
UNIT = re.compile(r"_(km_h|mph|kip|lbf|ksi|ft|N_mm\d|N_mm|N_m|MPa|GPa|mm\d?|mrad|rad|deg|kN|N|m|t|s|in)$")


def spelled(key: str) -> str:
    """Words of a key, names with their capitals."""
    words = key.replace("_", " ")
    for letters, name in NAMES.items():
        words = words.replace(letters, name)
    return words


def named(key: str) -> tuple[str, str]:
    """Words for a key of inputs or results, and its unit, empty without one."""
    found = UNIT.search(key)
    words = QUANTITIES.get(key) or spelled(key[: found.start()] if found else key)
    return words, found[1].replace("_", "/").translate(POWERS) if found else ""


def axis_name(key: str) -> str:
    """Label of an axis for a key: words, and the unit in which its values are."""
    words, unit = named(key)
    return f"{words} in {unit}" if unit else words


class ColourSteps:
    """Steps of colour from light to dark, in grey too; of values on both sides of zero from blue by white to red.

    - `values`: all values to be shown.
    - `from_zero`: for values none of which is below zero, or none above: from light at zero to dark at the extreme.
    """

    def __init__(self, values: Floats, *, from_zero: bool = False) -> None:
        values = np.append(values, 0.0) if from_zero else values
        low, high = float(values.min()), float(values.max())
        self.compressive = from_zero and -low > high
        if from_zero:
            low, high = (low, 0.0) if self.compressive else (0.0, max(high, 1e-6))
        elif not high - low > 1e-12 * max(abs(low), abs(high)):
            low, high = low - 0.5, high + 0.5
        self.signed = low < 0.0 < high
        if self.signed:
            low, high = -max(-low, high), max(-low, high)
        locator = MaxNLocator(nbins=10 if from_zero else 12, steps=[1, 2, 2.5, 5, 10], symmetric=self.signed)
        self.levels: Floats = np.asarray(locator.tick_values(low, high))
        shades = mpl.colormaps["magma_r"](np.linspace(0.0, 0.9, 256))
        self.map = SIGNED if self.signed else ListedColormap(shades[::-1] if self.compressive else shades)
        self.norm = BoundaryNorm(self.levels.tolist(), self.map.N)

    def mappable(self) -> ScalarMappable:
        """For the colour bar."""
        return ScalarMappable(self.norm, self.map)

    @property
    def lines(self) -> Floats:
        """Levels with a contour line: every second one, without zero."""
        levels = self.levels[::-1] if self.compressive else self.levels
        return np.sort(levels[2:-1:2])


def draw_contours(
    axes: Axes,
    part: PartFields,
    points: Floats,
    values: Floats,
    colours: ColourSteps,
    chosen: NDArray[np.bool_] | None = None,
) -> None:
    """Draw lines of equal value, from means about the points, with numbers that keep apart; set the axes first.

    `chosen` are the cells that are drawn, (n_cells,); all if left out.
    """
    smooth = part.at_points(values)
    levels = [v for v in colours.lines.tolist() if smooth.min() < v < smooth.max()]
    if not levels:
        return
    grid = Triangulation(points[:, 0], points[:, 1], triangles(part.mesh))
    if chosen is not None:
        inside = np.zeros(part.mesh.n_points, dtype=np.bool_)
        inside[part.mesh.cell_points[np.repeat(chosen, part.mesh.cell_sizes)]] = True
        grid.set_mask(~inside[grid.triangles].all(axis=1))
    lines = axes.tricontour(grid, smooth, levels=levels, colors=INK, linewidths=0.5, linestyles="solid")
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


def draw_outline(axes: Axes, mesh: PolyMesh, points: Floats | None = None, *, dashed: bool = False) -> None:
    """Draw the outer boundary of a mesh and the holes', its points being at `points`."""
    mesh = as_polylines(mesh) if points is None else mesh
    places = mesh.points if points is None else points
    style = {"color": GREY, "linestyle": (0, (4, 2))} if dashed else {"color": INK, "linestyle": "solid"}
    for loop in boundary_loops(mesh):
        axes.plot(*places[loop].T, linewidth=0.9, **style)


def equal_axes(axes: Axes, corners: Floats) -> None:
    """Show the box (2, 2) with one scale for both axes, labelled in mm."""
    axes.set(xlim=(corners[0, 0], corners[1, 0]), ylim=(corners[0, 1], corners[1, 1]))
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel="x in mm", ylabel="y in mm")


def box(points: Sequence[Floats], margin: float) -> Floats:
    """Return the corners (2, 2) of the box about all points, widened."""
    every = np.vstack(points)
    return np.array([every.min(axis=0) - margin, every.max(axis=0) + margin])


def alike(boxes: Sequence[Floats]) -> list[Floats]:
    """Return boxes (2, 2) beside each other with one size and one range of heights, each about its own middle."""
    every = np.array(boxes)
    low, high = every[:, 0, 1].min(), every[:, 1, 1].max()
    half = np.ptp(every[:, :, 0], axis=1).max() / 2.0
    return [np.array([[x - half, low], [x + half, high]]) for x in every[:, :, 0].mean(axis=1)]


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


def triangles(mesh: PolyMesh) -> NDArray[np.int32]:
    """Polygons as fans of triangles about their first corner, shape (n, 3)."""
    fans = []
    for n_vertices, cells in mesh.batches():
        corners = mesh.batch_points(n_vertices, cells)
        fans += [corners[:, [0, i, i + 1]] for i in range(1, n_vertices - 1)]
    return np.vstack(fans)


def draw_field(axes: Axes, mesh: PolyMesh, values: Floats, shades: ColourSteps, *, lines: bool = True) -> None:
    """Fill between contour lines of values at a mesh's points (n_points,); dashed lines are negative."""
    surface = Triangulation(mesh.points[:, 0], mesh.points[:, 1], triangles(mesh))
    # rounding below the first level would leave a hole
    values = np.clip(values, shades.levels[0], shades.levels[-1])
    axes.tricontourf(surface, values, levels=shades.levels, cmap=shades.map, norm=shades.norm)
    if lines:
        styles = ["dashed" if level < 0.0 else "solid" for level in shades.levels]
        axes.tricontour(surface, values, levels=shades.levels, colors=INK, linewidths=0.5, linestyles=styles)


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
