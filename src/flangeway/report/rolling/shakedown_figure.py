"""Patches in the shakedown diagram: maximum pressure over shear strength, and traction coefficient."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure

from flangeway.exact.shakedown import shakedown_limits
from flangeway.quantities import measured
from flangeway.report.figures.drawing import GREY, INK, PURPLE, legend_below, name_axes, panels
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


def shakedown_figure(patches: Sequence[tuple[str, float, float]], yield_MPa: float, units: Units = "metric") -> Figure:
    """Draw named patches with their traction coefficients and maximum pressures in MPa among the limits."""
    strength = yield_MPa / np.sqrt(3.0)
    highest = max(MIN_HEIGHT, *(1.15 * pressure / strength for *_, pressure in patches))
    widest = min(1.0, max(MIN_WIDTH, *(1.15 * used for _, used, _ in patches)))
    figure, ((axes,),) = panels(7.6, 5.2, units=units)
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
    words = f"maximum pressure over shear strength k = {measured(yield_MPa, 'MPa', units)} / √3"
    name_axes(axes, "traction coefficient: creep force over normal force", words)
    legend_below(figure, 2, fontsize=9)
    return figure
