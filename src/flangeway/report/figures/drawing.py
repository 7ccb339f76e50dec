"""What all pictures share, and the convergence of Newton's method as a figure."""

import io
from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure, FigureBase
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import AutoLocator, Formatter, MaxNLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray
from PIL import Image

from flangeway.contact import ContactState
from flangeway.mesh import PolyMesh
from flangeway.types import Floats, Ints
from flangeway.units import Units, UsUnit, us_unit

# --- What all pictures share: figures, colours that stay apart in grey, labels with units, colour bars, legends,
# fields.
#
# A figure has a system of units. What it draws is metric; `name_axis`, `name_axes` and `colour_bar` set labels and
# ticks of its system from the unit of the data, and `units_of` returns the system for numbers in texts, see
# `flangeway.quantities.measured`.


PAGE_IN, HALF_IN = 7.25, 4.6
"""Largest picture: A4 has room for its width between the margins, and sheets are at least half full before it."""
DPI = 240
INK, GREY, LIGHT, PURPLE = "#1a1a1a", "#777777", "#dddddd", "#8b1a8b"
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours of lines and points one after the other: those of Okabe and Ito (2008), which the colour-blind can tell."""
SIDE_COLOURS = {"left": SERIES[1], "right": SERIES[0]}
SIGNED: Colormap = ListedColormap(mpl.colormaps["RdBu_r"](np.linspace(0.04, 0.96, 256)))
"""For values on both sides of zero, which is white: blue below, red above, equally dark at equal distances."""
COLOURS: Colormap = ListedColormap(mpl.colormaps["magma_r"](np.linspace(0.02, 0.92, 256)))
"""From light, the minimum, to dark, the maximum, in grey too."""
Style = dict[str, Any]
"""Options of functions of matplotlib that draw."""
NODES: Style = {"lw": 1.0, "marker": "o", "ms": 3.0, "mfc": "white"}
HERTZ: Style = {"lw": 1.6, "ls": "--", "zorder": 1}
"""NODES, HERTZ: lines of computed values at nodes or cells, and of Hertz's theory."""
HALO = withStroke(linewidth=2.0, foreground="white")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class ShownFigure(Figure):
    """A figure that notebooks show without a global state of matplotlib; what it draws has the colours of `SERIES`."""

    units: Units = "metric"

    def add_subplot(self, *args: Any, **kwargs: Any) -> Axes:
        """Add axes as matplotlib does, which adds all axes of `Figure.subplots` by this method."""
        axes = super().add_subplot(*args, **kwargs)
        axes.set_prop_cycle(color=SERIES)
        return axes

    def _repr_png_(self) -> bytes:
        return png(self)


def new_figure(width_in: float, height_in: float, units: Units = "metric", *, compressed: bool = False) -> Figure:
    """Return an empty figure, apart from any global state of matplotlib, which makes room for all labels.

    - `compressed`: whether axes of one scale stand close together, and colour bars are as high as what is drawn.
    """
    size = min(1.0, PAGE_IN / width_in, HALF_IN / height_in) * np.array([width_in, height_in])
    figure = ShownFigure(figsize=size.tolist(), dpi=DPI, facecolor="white")
    figure.units = units
    figure.set_layout_engine("compressed" if compressed else "constrained")
    FigureCanvasAgg(figure)
    return figure


def panels(
    width_in: float, height_in: float, n_rows: int = 1, n_columns: int = 1, units: Units = "metric", **options: Any
) -> tuple[Figure, NDArray[Any]]:
    """Return a figure and its axes with a grid, shape (n_rows, n_columns).

    - `options`: those of `matplotlib.figure.Figure.subplots`.
    """
    figure = new_figure(width_in, height_in, units)
    axes = figure.subplots(n_rows, n_columns, squeeze=False, **options)
    for panel in axes.flat:
        panel.grid(color=LIGHT, linewidth=0.6)
    return figure, axes


def units_of(axes: Axes) -> Units:
    """Return the system of units of the figure of some axes."""
    return getattr(axes.get_figure(root=True), "units", "metric")


class UsLocator(AutoLocator):
    """Ticks at round numbers of a unit, on an axis in the metric one."""

    def __init__(self, unit: UsUnit) -> None:
        super().__init__()
        self.metric = float(unit.metric)

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Return places on the axis."""
        values = np.asarray(super().tick_values(vmin / self.metric, vmax / self.metric)) * self.metric
        return [float(value) for value in values]


class UsFormatter(Formatter):
    """Numbers of a unit beside ticks in the metric one, all with as many decimals as the finest needs."""

    def __init__(self, unit: UsUnit) -> None:
        self.metric = float(unit.metric)

    def __call__(self, x: float, pos: int | None = None) -> str:  # noqa: ARG002 (matplotlib's)
        """Return the number of one place, for the cursor of windows."""
        return f"{x / self.metric:.6g}"

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        """Return the numbers at the ticks."""
        numbers = np.asarray(values) / self.metric
        if not len(numbers) or not 1e-4 <= abs(numbers).max() < 1e6:
            return [f"{number:.4g}" for number in numbers]
        off = 1e-9 * float(abs(numbers).max())
        decimals = next((n for n in range(8) if np.allclose(numbers, numbers.round(n), rtol=0.0, atol=off)), 8)
        return [f"{number:z.{decimals}f}" for number in numbers]


def name_axis(axis: Axis, words: str, unit: str = "") -> None:
    """Label an axis whose data is in a metric unit, and set its ticks, both in the units of its figure.

    - `words`: what the data is; empty where another axis in the same direction says it, and only ticks are set.
    """
    axis.set_tick_params(labelsize=8.0)
    other = us_unit(unit) if unit and units_of(axis.axes) == "us" else None
    if other is not None and axis.get_scale() == "linear":
        axis.set_major_locator(UsLocator(other))
        axis.set_major_formatter(UsFormatter(other))
    if words:
        axis.set_label_text(with_unit(words, other.name if other else unit), fontsize=8.5)


def name_axes(axes: Axes, x: tuple[str, str] | str = "", y: tuple[str, str] | str = "") -> None:
    """Label both axes: words, or words and metric unit of the data; see `name_axis`."""
    for axis, name in ((axes.xaxis, x), (axes.yaxis, y)):
        if name:
            name_axis(axis, *((name,) if isinstance(name, str) else name))


def with_unit(words: str, unit: str | None) -> str:
    """Return the words of a label with the unit behind."""
    return f"{words}, {unit}" if unit else words


def colour_bar(
    drawn: ScalarMappable, axes: Axes | Sequence[Axes], words: str, unit: str = "", **options: Any
) -> Colorbar:
    """Add a bar of colours, labelled in the units of the figure, to axes that it takes its room from.

    - `options`: those of `matplotlib.figure.Figure.colorbar`.
    """
    first = axes if isinstance(axes, Axes) else axes[0]
    figure: FigureBase = first.get_figure(root=True)  # type: ignore[assignment]
    bar = figure.colorbar(drawn, ax=axes, **{"shrink": 0.9} | options)
    name_axis(bar.long_axis, words, unit)
    return bar


def legend_below(figure: Figure, n_columns: int, **options: Any) -> None:
    """Add one legend of all axes below them, each name once.

    - `options`: those of `matplotlib.figure.Figure.legend`.
    """
    entries = [axes.get_legend_handles_labels() for axes in figure.axes]
    known = {label: handle for handles, labels in entries for handle, label in zip(handles, labels, strict=True)}
    if known:
        style: Style = {"loc": "outside lower center", "frameon": False, "fontsize": 8} | options
        figure.legend(list(known.values()), list(known), ncols=n_columns, **style)


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


def sequence_colours(number: int) -> NDArray[np.float64]:
    """Colours (number, 4) of lines in an order, apart in grey too; the first is dark."""
    return np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.88, max(number, 2))[:number]))


def shade_of(values: Floats, limits: tuple[float, float] | None = None) -> ScalarMappable:
    """Return the colours of values: dark where they are largest in size, blue to red where they change their sign.

    - `limits`: values of the first and last colour; those of the values by default.
    """
    low, high = (float(values.min()), float(values.max())) if limits is None else limits
    if not high - low > 1e-12 * max(abs(low), abs(high)):
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    signed = low < 0.0 < high
    if signed:
        low, high = -max(-low, high), max(-low, high)
    return ScalarMappable(Normalize(low, high), SIGNED if signed else COLOURS.reversed() if high <= 0.0 else COLOURS)


def fill_triangles(axes: Axes, points: Floats, triangles: Ints, values: Floats, shade: ScalarMappable) -> None:
    """Fill triangles (m, 3) of points (n, 2) with the colours of values at the points (n,), smooth within each."""
    grid = Triangulation(points[:, 0], points[:, 1], triangles)
    style: Style = {"cmap": shade.cmap, "norm": shade.norm, "rasterized": True}
    axes.tripcolor(grid, values, shading="gouraud", **style)


def draw_lines(
    axes: Axes, lines: Iterable[Floats], colour: str, width: float, alpha: float | None = None, ls: Any = "solid"
) -> None:
    """Draw lines of points (n, 2) each."""
    axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=width, alpha=alpha, linestyles=[ls]))


def equal_axes(axes: Axes, corners: Floats, unit: str = "mm") -> None:
    """Show the box (2, 2) with one scale for both axes, labelled with the unit."""
    axes.set(xlim=(corners[0, 0], corners[1, 0]), ylim=(corners[0, 1], corners[1, 1]))
    axes.set_aspect("equal", adjustable="box")
    name_axes(axes, ("x", unit), ("y", unit))


def cells_path(mesh: PolyMesh, points: Floats, cells: NDArray[np.integer]) -> Path:
    """One path about each of some cells (n,), the points of the mesh being drawn at `points` (n_points, 2)."""
    polygons = [points[mesh.corners(cell)] for cell in cells]
    return Path.make_compound_path(*(Path(polygon, closed=False) for polygon in polygons))


# --- Convergence: the Newton iterations of load steps as a figure.


MIN_ERROR = 1e-17  # value for errors of exactly zero on the logarithmic axis
ERRORS = {"residual": "residual relative to the total force", "change": "change relative to the maximum displacement"}


def newton_figure(steps: Sequence[tuple[str, ContactState]]) -> Figure:
    """Draw residual and change of all iterations, load step by load step."""
    figure, ((axes,),) = panels(PAGE_IN, 2.8)
    start = 1
    for history in (state.history for _, state in steps):
        at = np.arange(start, start + len(history))
        for key, colour, line, marker in (("residual", INK, "-", "o"), ("change", GREY, "--", "s")):
            errors = np.maximum([getattr(iteration, key) for iteration in history], MIN_ERROR)
            axes.plot(at, errors, **NODES | {"color": colour, "ls": line, "marker": marker}, label=ERRORS[key])
        start += len(history)
        axes.axvline(start - 0.5, color=GREY, lw=0.6)
    axes.set(yscale="log", xlim=(0.5, start - 0.5))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    name_axes(axes, "Newton iterations" + (", load step by load step" if len(steps) > 1 else ""), "relative error")
    axes.yaxis.set_major_formatter(power_of_ten)
    legend_below(figure, 2)
    return figure
