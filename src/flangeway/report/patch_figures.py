"""Pictures of contact patches: pressures and stresses, stick and slip, and the shakedown diagram."""

import textwrap
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Patch

from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, STICKS
from flangeway.exact.shakedown import shakedown_limits
from flangeway.post.patch_stresses import DepthProfile
from flangeway.quantities import measured
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    INK,
    LIGHT,
    PAGE_IN,
    PURPLE,
    Style,
    colour_bar,
    legend_below,
    name_axes,
    new_figure,
    panels,
    units_of,
)
from flangeway.report.patch_maps import DrawnCells, PatchMap, ShownRolling, cell_fields, shown_fields
from flangeway.types import Floats
from flangeway.units import Units

# --- Patches from above: pressures with outlines; stresses below.


CURVES = (
    ("across, x", "#0b5394", "-"), ("normal, y", INK, "-"), ("along, z", "#9a6a00", "-"),
    ("von Mises", PURPLE, "--"), ("Tresca", "#2e7d32", "-."),
)  # fmt: skip
MIN_RATIO = 0.6
"""Width of what is shown of a surface from above relative to its height, at least."""
MAX_WIDTH_IN, MAX_HEIGHT_IN, MIN_WIDTH_IN, MIN_HEIGHT_IN = 6.4, 2.5, 5.0, 2.6
"""Size of the picture of surfaces from above: without labels at most, with them at least."""


def draw_pressures(axes: Axes, shown: PatchMap, highest: float) -> ScalarMappable:
    """Draw pressures from above, outlines of the patches, and Hertz's ellipses; return the colours, from 0 MPa."""
    drawn, scale = shown.cells_drawn, Normalize(0.0, highest)
    _fill(axes, drawn, shown.cells.pressures, COLOURS, scale)
    axes.add_collection(LineCollection(list(drawn.outline), colors=INK, linewidths=1.0, capstyle="projecting"))
    for patch in shown.patches:
        if (hertz := patch.hertz) is not None:
            first = not axes.get_legend_handles_labels()[0]
            width, height = (2.0 * axis for axis in hertz.semi_axes)
            style: Style = {"fill": False, "ec": GREY, "ls": "--", "lw": 1.2, "label": "Hertz" if first else ""}
            middle, angle = tuple(shown.centre(patch).tolist()), float(np.rad2deg(shown.tilt(patch)))
            axes.add_patch(Ellipse(middle, width, height, angle=angle, **style))
    axes.set_aspect("equal", adjustable="box")
    return ScalarMappable(scale, COLOURS)


def maps_figure(
    maps: Sequence[PatchMap], across: str, along: str, units: Units = "metric"
) -> tuple[Figure, Sequence[Axes]]:
    """Draw the pressures of surfaces from above, beside each other in one scale, with outlines and Hertz's ellipses.

    - `across`, `along`: words for both axes.
    """
    boxes = [shown.box for shown in maps]
    ahead = np.array([box[:, 1] for box in boxes])
    least = MIN_RATIO * float(np.ptp(ahead))
    for box in boxes:
        box[:, 0] += np.array([-0.5, 0.5]) * max(least - float(np.ptp(box[:, 0])), 0.0)
    ends, widths = (ahead[:, 0].min(), ahead[:, 1].max()), [float(np.ptp(box[:, 0])) for box in boxes]
    scale = min(MAX_WIDTH_IN / sum(widths), MAX_HEIGHT_IN / (ends[1] - ends[0]))
    size = max(scale * sum(widths) + 0.8, MIN_WIDTH_IN), max(scale * (ends[1] - ends[0]) + 1.4, MIN_HEIGHT_IN)
    figure = new_figure(*size, units)
    both = figure.subplots(1, len(maps), sharey=True, squeeze=False, width_ratios=widths)[0]
    highest = max(float(shown.cells.pressures.max()) for shown in maps)
    for axes, shown, box in zip(both, maps, boxes, strict=True):
        drawn = draw_pressures(axes, shown, max(highest, 1.0))
        axes.set(xlim=box[:, 0], ylim=ends)
        axes.locator_params(axis="x", nbins=5)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="lower right", fontsize=8)
        name_axes(axes, (across, "mm"))
    name_axes(both[0], y=(along, "mm"))
    colour_bar(drawn, list(both), "contact pressure", "MPa", location="top", aspect=45)
    return figure, both


def draw_depths(axes: Axes, profile: DepthProfile) -> None:
    """Draw the stresses below a patch over the depth."""
    stresses = profile.stresses
    xx, yy, zz = stresses.components[:, :3].T
    curves = (xx, yy, zz, stresses.von_mises, stresses.tresca)
    for (label, colour, style), values in zip(CURVES, curves, strict=True):
        axes.plot(values, profile.depths, color=colour, ls=style, lw=1.3, label=label)
    axes.axvline(0.0, color=GREY, lw=0.8)
    axes.set_ylim(float(profile.depths[-1]), 0.0)
    axes.grid(color=LIGHT, linewidth=0.6)
    name_axes(axes, ("stress", "MPa"), ("", "mm"))


def _fill(axes: Axes, drawn: DrawnCells, values: Floats, colours: Any, scale: Normalize) -> ScalarMappable:
    """Fill cells by their values (n_cells, n_strips)."""
    style: Style = {"cmap": colours, "norm": scale, "antialiaseds": False, "linewidths": 0.0, "rasterized": True}
    filled = PolyCollection(list(drawn.polygons), array=values[drawn.chosen], **style)
    axes.add_collection(filled)
    return filled


# --- Patches that roll with friction from above: stick and slip with tractions, slip velocity, frictional power.


STICK, SLIP = "#d3e3f3", "#f2b482"
ARROWS = 14
TITLE_LETTERS = 20
"""Arrows along the longer side of a patch, about."""
PANEL_IN, ROWS_IN, ROW_IN = 1.6, 3.0, 2.0
"""Maximum width of a panel, height of all rows, and height of one."""
LENGTH = 1.7
"""Longest arrow relative to the distance of arrows."""


def rolling_figure(patches: Sequence[ShownRolling], units: Units = "metric") -> Figure:
    """Draw a row for each patch: where it sticks and slips with its tractions, slip velocity, frictional power."""
    boxes, count = [shown.box for shown in patches], max(len(patches), 1)
    width, heights = (np.array([np.ptp(box, axis=0)[axis] for box in boxes] or [1.0]) for axis in (0, 1))
    scale = min(PANEL_IN / float(width.max()), ROW_IN / float(heights.max()), ROWS_IN / float(heights.sum()))
    size = 3.0 * (scale * float(width.max()) + 0.9), scale * float(heights.sum()) + 0.36 * count + 0.7
    figure = new_figure(*size, units)
    rows = figure.subplots(count, 3, squeeze=False, height_ratios=heights.tolist())
    for row, shown, box in zip(rows, patches, boxes, strict=False):
        _draw_states(row[0], shown)
        arrays = cell_fields(shown.forces, shown.speed_m_s)
        drawn, frictional = shown_fields(
            {name: arrays[name] for name in arrays if name.startswith(("slip", "frictional"))}
        )
        for axes, field in zip(row[1:], drawn, strict=True):
            name = _draw_values(axes, shown, frictional[field.array], field.name, field.unit)
            if shown is patches[0]:
                axes.set_title(textwrap.fill(name, TITLE_LETTERS), fontsize=8)
        ends = box[:, 0].mean() + np.array([-0.5, 0.5]) * float(width.max())
        for axes in row:
            axes.set(xlim=ends, ylim=box[:, 1])
            axes.set_aspect("equal", adjustable="box")
            name_axes(axes, ("to the right" if shown is patches[-1] else "", "mm"))
            axes.locator_params(axis="x", nbins=4)
            axes.locator_params(axis="y", nbins=6)
        name_axes(row[0], y=(f"{shown.name}\nz ahead", "mm"))
    fills = {"sticks": STICK, "slips": SLIP}
    handles = [Patch(fc=fill, ec=INK, lw=0.5, label=name) for name, fill in fills.items()]
    figure.legend(handles=handles, loc="outside lower left", ncols=2, frameon=False, fontsize=9)
    return figure


def _draw_states(axes: Axes, shown: ShownRolling) -> None:
    """Areas of stick and slip, with arrows of the tractions on the second body."""
    states, edges = shown.forces.states, shown.edges
    colours, scale = ListedColormap([STICK, SLIP]), Normalize(STICKS - 0.5, SLIPS + 0.5)
    _fill(axes, shown.cells_drawn, states.astype(np.float64), colours, scale)
    spacing = max(np.ptp(shown.box, axis=0)) / ARROWS
    chosen = []
    for ends, cells in zip(edges, shown.forces.contact.box, strict=True):
        step = max(round(spacing / abs(float(np.diff(ends).mean()))), 1)
        chosen.append(np.arange(cells.start, cells.stop)[(cells.stop - cells.start - 1) % step // 2 :: step])
    rows, strips = (positions.ravel() for positions in np.meshgrid(*chosen, indexing="ij"))
    rows, strips = rows[states[rows, strips] != NO_CONTACT], strips[states[rows, strips] != NO_CONTACT]
    x, z = ((ends[1:] + ends[:-1])[which] / 2.0 for ends, which in zip(edges, (rows, strips), strict=True))
    arrows, longest = shown.tractions[rows, strips], float(np.linalg.norm(shown.tractions, axis=2).max())
    if longest > 0.0:
        style: Style = {"angles": "xy", "scale_units": "xy", "pivot": "mid", "color": INK, "width": 0.007}
        axes.quiver(x, z, *arrows.T, scale=longest / (LENGTH * spacing), **style)
    slips = (states == SLIPS).sum() / max((states != NO_CONTACT).sum(), 1)
    most = measured(longest, "MPa", units_of(axes), ".0f")
    axes.set_title(f"{100.0 * slips:.0f} % slips, up to {most}", fontsize=8)


def _draw_values(axes: Axes, shown: ShownRolling, values: Floats, name: str, unit: str) -> str:
    """Values of cells in colours; returns their name with the unit of the figure."""
    drawn = shown.cells_drawn
    scale = Normalize(0.0, max(float(values[drawn.chosen].max()), np.finfo(float).tiny))
    bar = colour_bar(_fill(axes, drawn, values, COLOURS, scale), axes, name, unit, aspect=18, pad=0.02)
    named = bar.ax.get_ylabel()
    bar.set_label("")
    return named


# --- Patches in the shakedown diagram: maximum pressure over shear strength, and traction coefficient.


LIMITS = {
    "first_yield": ("first yield", "#2166ac"),
    "shakedown": ("elastic after shakedown, no hardening", "#b35806"),
    "hardening": ("elastic after shakedown, kinematic hardening", PURPLE),
}
KINDS: tuple[tuple[Literal["point", "line"], Any, str], ...] = (
    ("point", "solid", "under a circular patch"),
    ("line", (0, (4, 2)), "under a line contact"),
)
MIN_HEIGHT, MIN_WIDTH = 6.0, 0.6
"""Least extent of the axes."""


def shakedown_figure(patches: Sequence[tuple[str, float, float]], yield_MPa: float, units: Units = "metric") -> Figure:
    """Draw named patches with their traction coefficients and maximum pressures in MPa among the limits."""
    strength = yield_MPa / np.sqrt(3.0)
    highest = max(MIN_HEIGHT, *(1.15 * pressure / strength for *_, pressure in patches))
    widest = min(1.0, max(MIN_WIDTH, *(1.15 * used for _, used, _ in patches)))
    figure, ((axes,),) = panels(PAGE_IN, 3.8, units=units)
    traction = np.linspace(0.0, widest, 301)
    for kind, style, label in KINDS:
        for name, (words, colour) in LIMITS.items():
            limit = getattr(shakedown_limits(kind, traction), name)
            axes.plot(traction, limit, color=colour, ls=style, lw=1.4, label=words if kind == "point" else None)
        axes.plot([], [], color=GREY, ls=style, label=label)
    for number, (name, used, pressure) in enumerate(patches):
        label = f"{name}: {measured(pressure, 'MPa', units, '.0f')}"
        axes.plot(used, pressure / strength, "oDs^v"[number % 5], color=INK, ms=7.0, zorder=5, label=label)
    axes.set(xlim=(0.0, widest), ylim=(0.0, highest))
    words = f"maximum pressure over\nshear strength k = {measured(yield_MPa, 'MPa', units)} / √3"
    name_axes(axes, "traction coefficient: creep force over normal force", words)
    legend_below(figure, 2, fontsize=9)
    return figure
