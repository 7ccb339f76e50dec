"""Patches in the shakedown diagram: maximum pressure over shear strength, and traction coefficient."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure

from flangeway.exact.shakedown import shakedown_limits
from flangeway.quantities import measured
from flangeway.report.figures.drawing import GREY, HALO, INK, PURPLE, Style, legend_below, name_axes, panels
from flangeway.types import Floats
from flangeway.units import Units

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
APART, SHIFT = 0.05, 0.03
"""Least distance of labels over the height of the axes, and their distance from the points over the width."""


def shakedown_figure(patches: Sequence[tuple[str, float, float]], yield_MPa: float, units: Units = "metric") -> Figure:
    """Draw named patches with their traction coefficients and maximum pressures in MPa among the limits."""
    used, pressures = np.array([numbers for _, *numbers in patches]).reshape(-1, 2).T
    heights = pressures / (yield_MPa / np.sqrt(3.0))
    highest, widest = max(MIN_HEIGHT, *(1.15 * heights)), min(1.0, max(MIN_WIDTH, *(1.15 * used)))
    figure, ((axes,),) = panels(7.6, 5.2, units=units)
    traction = np.linspace(0.0, widest, 301)
    for kind, style, label in KINDS:
        for name, (words, colour) in LIMITS.items():
            limit = getattr(shakedown_limits(kind, traction), name)
            axes.plot(traction, limit, color=colour, ls=style, lw=1.4, label=words if kind == "point" else None)
        axes.plot([], [], color=GREY, ls=style, label=label)
    axes.plot(used, heights, "o", color=INK, ms=7.0, zorder=5)
    for (name, _, pressure), x, y, label in zip(patches, used, heights, _apart(heights, APART * highest), strict=True):
        shift, side = (-SHIFT, "right") if x > 0.7 * widest else (SHIFT, "left")
        line: Style = {"arrowstyle": "-", "color": INK, "lw": 0.7, "shrinkB": 3.0}
        place: Style = {"xytext": (x + shift * widest, label), "ha": side, "va": "center", "arrowprops": line}
        text = f"{name}: {measured(pressure, 'MPa', units, '.0f')}"
        axes.annotate(text, (x, y), fontsize=9.0, path_effects=[HALO], zorder=6, **place)
    axes.set(xlim=(0.0, widest), ylim=(0.0, highest))
    strength = f"maximum pressure over shear strength k = {measured(yield_MPa, 'MPa', units)} / √3"
    name_axes(axes, "traction coefficient: creep force over normal force", strength)
    legend_below(figure, 2, fontsize=9)
    return figure


def _apart(heights: Floats, least: float) -> Floats:
    """Heights of labels, in the order of their points, at least so far apart."""
    labels = heights.copy()
    order = np.argsort(heights)
    for before, after in pairwise(order):
        labels[after] = max(labels[after], labels[before] + least)
    return labels
