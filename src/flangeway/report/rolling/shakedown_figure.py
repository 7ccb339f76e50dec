"""Patches in the shakedown diagram: maximum pressure over shear strength, and traction coefficient."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flangeway.exact.shakedown import shakedown_limits
from flangeway.report.figures.drawing import GREY, HALO, INK, new_figure
from flangeway.types import Floats

LIMITS = {
    "first_yield": ("first yield", "#2166ac"),
    "shakedown": ("elastic after shakedown, no hardening", "#b35806"),
    "hardening": ("elastic after shakedown, kinematic hardening", "#8b1a8b"),
}
DASHED = (0, (4, 2))
HIGHEST, WIDEST = 6.0, 0.6
"""Least extent of the axes."""
APART, SHIFT = 0.05, 0.03
"""Least distance of labels over the height of the axes, and their distance from the points over the width."""


def shakedown_figure(patches: Sequence[tuple[str, float, float]], yield_MPa: float) -> Figure:
    """Draw named patches with their traction coefficients and maximum pressures in MPa among the limits."""
    strength = yield_MPa / np.sqrt(3.0)
    used, pressures = np.array([each[1:] for each in patches]).reshape(-1, 2).T
    heights = pressures / strength
    highest, widest = max(HIGHEST, *(1.15 * heights)), min(1.0, max(WIDEST, *(1.15 * used)))
    figure = new_figure(7.6, 5.2)
    axes = figure.subplots()
    traction = np.linspace(0.0, widest, 301)
    for limits, style in ((shakedown_limits("point", traction), "solid"), (shakedown_limits("line", traction), DASHED)):
        for name, (_, colour) in LIMITS.items():
            axes.plot(traction, getattr(limits, name), color=colour, ls=style, lw=1.4)
    axes.plot(used, heights, "o", color=INK, ms=7.0, zorder=5)
    for (name, _, pressure), x, y, label in zip(patches, used, heights, _apart(heights, APART * highest), strict=True):
        left = x > 0.7 * widest
        axes.annotate(
            f"{name}: {pressure:.0f} MPa", (x, y), (x + (-SHIFT if left else SHIFT) * widest, label), fontsize=9.0,
            ha="right" if left else "left", va="center", path_effects=[HALO], zorder=6,
            arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.7, "shrinkB": 3.0},
        )  # fmt: skip
    axes.set(xlim=(0.0, widest), ylim=(0.0, highest))
    axes.set_xlabel("traction coefficient: creep force over normal force")
    axes.set_ylabel(f"maximum pressure over shear strength k = {yield_MPa:g} MPa / √3")
    axes.grid(color="#e4e4e4", linewidth=0.5)
    lines = [Line2D([], [], color=colour, label=label) for label, colour in LIMITS.values()]
    lines += [Line2D([], [], color=GREY, ls="solid", label="under a circular patch")]
    lines += [Line2D([], [], color=GREY, ls=DASHED, label="under a line contact")]
    figure.legend(handles=lines, loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    return figure


def _apart(heights: Floats, least: float) -> Floats:
    """Heights of labels, in the order of their points, at least so far apart."""
    labels = heights.copy()
    order = np.argsort(heights)
    for before, after in pairwise(order):
        labels[after] = max(labels[after], labels[before] + least)
    return labels
