"""Pictures of one contact patch that rolls with friction."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.patch_quantities import CREEPAGES, FORCES, SPIN_MOMENT
from flangeway.cases.rolling_patch_case import COMPONENTS, RollingPatchRun
from flangeway.contact.rolling.fast_theories import TITLES, Theory
from flangeway.quantities import numbers
from flangeway.report.figures.drawing import GREY, INK, PAGE_IN, PURPLE, SERIES, legend_below, name_axes, panels
from flangeway.report.page.record import Figures, Picture
from flangeway.report.patch_figures import rolling_figure
from flangeway.report.patch_maps import ShownRolling

MAPS, SECTION, CURVE = "rolling.png", "tractions.png", "creep-curve.png"
CAPTIONS = {
    MAPS: "The patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the upper "
    "body; slip; frictional power per area.",
    SECTION: "Tractions on the upper body in the middle of the patch, along and across, below their limit, friction "
    "times pressure. Where the magnitude reaches it the surfaces slip. Steps across are those of the leading edge on "
    "the cells: more cells make them smaller.",
    CURVE: "Creep forces on the upper body and spin moment over one creepage by all theories; the others are those of "
    "the case.",
}
STYLES: dict[Theory, tuple[str, Any]] = {
    "exact": (INK, "-"), "fastsim": (SERIES[0], (0, (5, 2))), "fastrip": (SERIES[2], "--"),
    "polach": (SERIES[1], "dashdot"), "linear": (GREY, (0, (1, 1.5))),
}  # fmt: skip
CREEPAGE_OF = dict(zip(COMPONENTS, CREEPAGES, strict=True))
MAX_DRAWN_FORCE = 1.3
"""Highest force that is drawn relative to the limit of friction: linear theory goes on."""
WIDE_IN = 7.5
"""Width of a picture with room for all names beside each other."""
ROUND_OFF = 1e-6
"""Force relative to the limit of friction, and moment over this times the semi-axis along, that is none and not
drawn."""


def rolling_patch_pictures(run: RollingPatchRun) -> list[Picture]:
    """Pictures of a run: of the cells where the theory has some, and of a creep curve."""
    return [Picture(name, draw, CAPTIONS[name]) for name, draw in _figures(run).items()]


def _shown(run: RollingPatchRun) -> ShownRolling:
    # t of the patch is drawn to the right
    forces = run.state.cells
    assert forces is not None
    return ShownRolling("patch", forces, abs(forces.motion.speed), 0.0, -1.0)


def _figures(run: RollingPatchRun) -> Figures:
    figures: Figures = {}
    if run.state.cells is not None:
        figures[MAPS] = lambda: rolling_figure([_shown(run)], run.case.units)
        figures[SECTION] = lambda: section_figure(run)
    if run.curve:
        figures[CURVE] = lambda: creep_curve_figure(run)
    return figures


def section_figure(run: RollingPatchRun) -> Figure:
    """Draw tractions and their limit through the middle of the patch, along and across."""
    assert run.state.cells is not None
    contact, tractions = run.contact, run.state.cells.tractions
    across, along = contact.places
    limit = contact.friction.limits[0][:, None] * contact.pressures
    row, strip = (int(np.abs(centres).argmin()) for centres in (across, along))
    figure, (both,) = panels(PAGE_IN, 3.0, 1, 2, run.case.units, sharey=True)
    lines = (
        (along, limit[row], tractions[row], "z ahead"),
        (across, limit[:, strip], tractions[:, strip], "to the right"),
    )
    for axes, (positions, most, cut, words) in zip(both, lines, strict=True):
        axes.fill_between(positions, most, color="#e8edf3", lw=0.0, label="up to the limit")
        axes.plot(positions, np.linalg.norm(cut, axis=-1), color=INK, lw=1.4, label="magnitude")
        axes.plot(positions, cut[:, 1], color=SERIES[0], lw=1.2, ls="--", label="ahead")
        axes.plot(positions, cut[:, 0], color=SERIES[1], lw=1.2, ls="dashdot", label="to the right")
        axes.axhline(0.0, color=GREY, lw=0.6)
        name_axes(axes, (words, "mm"))
    name_axes(both[0], y=("traction on the upper body", "MPa"))
    legend_below(figure, 7, fontsize=9)
    return figure


def creep_curve_figure(run: RollingPatchRun) -> Figure:
    """Draw forces and spin moment over the creepage of the curve by all theories."""
    spin = run.case.motion.curve == "spin"
    creepage = CREEPAGE_OF[run.case.motion.curve]
    scale = np.array([1.0 if spin else 100.0, 1.0])
    limit = run.contact.friction.limits[0][0] * run.contact.force / 1e3
    least = {"kN": ROUND_OFF * limit, "Nm": ROUND_OFF * limit * run.semi_axes[0]}
    every = [point for points in run.curve.values() for point in points]
    drawn = [force for force in FORCES if max(abs(force.value(point)) for point in every) > least[force.unit]]
    width = max(2.4 * len(drawn), 6.5)
    figure, (row,) = panels(width, 3.3, 1, len(drawn), run.case.units)
    for axes, force in zip(row, drawn, strict=True):
        both = (creepage, force)
        curves = {theory: scale * [numbers(both, point) for point in points] for theory, points in run.curve.items()}
        here = scale * numbers(both, run.state)
        for theory, line in curves.items():
            colour, style = STYLES[theory]
            axes.plot(*line.T, color=colour, ls=style, lw=1.3, label=TITLES[theory])
        axes.plot(*here, "D", color=PURPLE, ms=6.0, label="working point", zorder=5)
        axes.axhline(0.0, color=GREY, lw=0.6)
        low, high = axes.get_ylim()
        # linear theory goes on beyond the limit of friction, and its moment beyond the others'
        others = [np.abs(line[:, 1]).max() for theory, line in curves.items() if theory != "linear"]
        top = MAX_DRAWN_FORCE * (max(others, default=0.0) if force is SPIN_MOMENT else limit) or max(-low, high)
        axes.set_ylim(max(low, -top), min(high, top))
        for level in () if force is SPIN_MOMENT else (-limit, limit):
            if low < level < high:
                axes.axhline(level, color=GREY, lw=0.8, ls=(0, (10, 4)), label="limit of friction")
        name_axes(axes, (creepage.label, creepage.unit if spin else "%"), (force.label, force.unit))
    legend_below(figure, 7 if width > WIDE_IN else 4, fontsize=9)
    return figure
