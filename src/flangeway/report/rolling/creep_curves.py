"""Creep-force curves: forces over a creepage by several theories, about the working point of a patch."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.contact.rolling.theories import FAST, TITLES, Theory
from flangeway.report.figures.drawing import GREY, INK, PURPLE, SERIES, legend_below, name_axes, panels
from flangeway.report.rolling.rolling_maps import ShownRolling
from flangeway.types import Floats
from flangeway.units import Units

STYLES: dict[Theory, tuple[str, Any]] = {
    "exact": (INK, "-"), "fastsim": (SERIES[0], (0, (5, 2))), "fastrip": (SERIES[2], "--"),
    "polach": (SERIES[1], "dashdot"), "linear": (GREY, (0, (1, 1.5))),
}  # fmt: skip
FAR = 1.3
"""Highest force that is drawn over the limit of friction: linear theory goes on."""
COMPARED: tuple[Theory, ...] = ("fastsim", "polach")
"""Fast theories in the curves of a wheelset."""
EXACT = (0.0, 0.2, 0.5, 1.0)
"""Creepages of the exact theory over the greatest one, beside that of the working point."""
N_FAST, TOLERANCE = 41, 3e-3
"""Creepages of the fast theories, and the tolerance of the exact one: forces within 1e-3 of the limit."""
BEYOND = 1.6
"""Greatest creepage over that of the working point, at least."""
SATURATED = 3.0
"""And over that at which linear theory reaches the limit of friction."""
UNLOADED = 1e-3
"""Greatest creepage where there is no friction and no creepage."""


def draw_curves(axes: Axes, curves: Mapping[Theory, Floats], here: tuple[float, float], limit: float | None) -> None:
    """Draw forces over creepages (n, 2) by theories, the working point, and the limit of friction if there is one."""
    for theory, line in curves.items():
        colour, style = STYLES[theory]
        axes.plot(*line.T, color=colour, ls=style, lw=1.3, label=TITLES[theory])
    axes.plot(*here, "D", color=PURPLE, ms=6.0, label="working point", zorder=5)
    axes.axhline(0.0, color=GREY, lw=0.6)
    low, high = axes.get_ylim()
    # linear theory goes on beyond the limit of friction, and its moment beyond the others'
    others = [np.abs(line[:, 1]).max() for theory, line in curves.items() if theory != "linear"]
    top = FAR * (max(others, default=0.0) if limit is None else limit) or max(-low, high)
    axes.set_ylim(max(low, -top), min(high, top))
    for level in () if limit is None else (-limit, limit):
        if low < level < high:
            axes.axhline(level, color=GREY, lw=0.8, ls=(0, (10, 4)), label="limit of friction")


def curves_figure(patches: Sequence[ShownRolling], units: Units = "metric") -> Figure:
    """Draw for each patch the force ahead over its creepage and that across over its own, the others fixed."""
    count = max(len(patches), 1)
    figure, rows = panels(9.0, 2.6 * count + 1.0, count, 2, units)
    for row, shown in zip(rows, patches, strict=False):
        ways = (("along", 1.0, "ahead", "longitudinal"), ("across", -shown.sign, "to the right", "lateral"))
        for axes, (name, sign, way, words) in zip(row, ways, strict=True):
            _draw_curve(axes, shown, name, sign)
            axes.set_title(f"{shown.name}: {way}", fontsize=9.5)
            name_axes(axes, (f"{words} creepage", "%"), ("creep force", "kN"))
    legend_below(figure, 5, fontsize=9)
    return figure


def _draw_curve(axes: Axes, shown: ShownRolling, name: str, sign: float) -> None:
    """Draw one force over its creepage, from zero to beyond the working point, in a direction that is drawn."""
    found, contact = shown.forces, shown.contact
    ellipse = EllipticContact.of(contact, found.motion)
    c = ellipse.coefficients
    stiffness = ellipse.unit * (c.c11 if name == "along" else c.c22)
    limit = ellipse.friction * ellipse.force
    share = contact.normal_forces.sum(axis=1) / contact.force
    working = float(np.broadcast_to(getattr(found.motion, name), share.shape) @ share)
    end = (max(BEYOND * abs(working), SATURATED * limit / stiffness) or UNLOADED) * (1.0 if working >= 0.0 else -1.0)

    def motion(creepage: float) -> Creepages:
        return replace(found.motion, **{name: getattr(found.motion, name) + (creepage - working)})

    drawn = sign * np.array([100.0, 1e-3])  # creepages in %, forces in kN
    fast: Floats = np.linspace(0.0, end, N_FAST)
    curves: dict[Theory, Floats] = {}
    for theory in COMPARED:
        forces = [getattr(FAST[theory](contact, motion(each)), name) for each in fast.tolist()]
        curves[theory] = drawn * np.column_stack((fast, forces))
    if isinstance(found, Rolling):
        exact = {working: found} | {
            part * end: roll(contact, motion(part * end), start=found, tolerance=TOLERANCE) for part in EXACT
        }
        points = np.array(sorted((creepage, getattr(state, name)) for creepage, state in exact.items()))
        axes.plot(*(drawn * points).T, "o", color=INK, ms=3.5, mfc="white")
        curves["exact"] = drawn * np.column_stack((fast, PchipInterpolator(*points.T)(fast)))
    here = drawn * [working, getattr(found, name)]
    draw_curves(axes, curves, (float(here[0]), float(here[1])), 1e-3 * limit)
