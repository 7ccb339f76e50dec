"""Creep-force curves of patches about their working points, by the exact theory and by fast ones."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.fast_theories import polach
from flangeway.contact.rolling.fastsim import fastsim
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import CreepForces, Rolling
from flangeway.report.figures.drawing import GREY, INK, PURPLE, legend_below, name_axes, panels
from flangeway.report.rolling.rolling_maps import ShownRolling
from flangeway.types import Floats
from flangeway.units import Units

Theory = Callable[[RollingContact, Creepages], CreepForces]

THEORIES: dict[str, tuple[Theory, str, Any]] = {
    "FASTSIM": (fastsim, "#2166ac", (0, (5, 2))),
    "Polach": (polach, "#b35806", "dashdot"),
}
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


def curves_figure(patches: Sequence[ShownRolling], units: Units = "metric") -> Figure:
    """Draw for each patch the force ahead over its creepage and that across over its own, the others fixed."""
    count = max(len(patches), 1)
    figure, rows = panels(9.0, 2.6 * count + 1.0, count, 2, units)
    for row, shown in zip(rows, patches, strict=False):
        ways = (("along", 1.0, "ahead", "longitudinal"), ("across", -shown.sign, "to the right", "lateral"))
        for axes, (name, sign, way, words) in zip(row, ways, strict=True):
            _draw_curve(axes, shown, name, sign)
            axes.set_title(f"{shown.name}: {way}", fontsize=9.5)
            name_axes(axes, (f"{words} creepage" if row is rows[-1] else "", "%"))
            name_axes(axes, y=("creep force" if axes is row[0] else "", "kN"))
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

    def motion(value: float) -> Creepages:
        return replace(found.motion, **{name: getattr(found.motion, name) + (value - working)})

    fast: Floats = np.linspace(0.0, end, N_FAST)
    for label, (theory, colour, style) in THEORIES.items():
        forces = [getattr(theory(contact, motion(each)), name) for each in fast]
        axes.plot(100.0 * sign * fast, 1e-3 * sign * np.array(forces), color=colour, ls=style, lw=1.2, label=label)
    if isinstance(found, Rolling):
        points = np.array(_exact(found, name, working, end, motion))
        fine: Floats = np.linspace(points[0, 0], points[-1, 0], N_FAST)
        axes.plot(100.0 * sign * fine, 1e-3 * sign * PchipInterpolator(*points.T)(fine), color=INK, lw=1.0)
        axes.plot(*(sign * points * (100.0, 1e-3)).T, "o", color=INK, ms=3.5, mfc="white", label="exact theory")
    here = 100.0 * sign * working, 1e-3 * sign * getattr(found, name)
    axes.plot(*here, "D", color=PURPLE, ms=6.5, label="working point", zorder=5)
    at_limit = -np.sign(sign * end) * 1e-3 * limit
    axes.axhline(at_limit, color=GREY, lw=0.8, ls="dotted", label="limit of friction")
    axes.axhline(0.0, color=GREY, lw=0.6)


def _exact(
    found: Rolling, name: str, working: float, end: float, motion: Callable[[float], Creepages]
) -> list[tuple[float, float]]:
    """Creepages and forces by the exact theory, each started from its neighbour, from the working point both ways."""
    points = {working: float(getattr(found, name))}
    for outwards in (1.0, -1.0):
        state = found
        values = [share * end for share in EXACT if outwards * (abs(share * end) - abs(working)) > 0.0]
        for value in sorted(values, key=lambda each: outwards * abs(each)):
            state = roll(found.contact, motion(value), start=state, tolerance=TOLERANCE)
            points[value] = float(getattr(state, name))
    return sorted(points.items())
