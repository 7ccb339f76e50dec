"""Pictures of a case of bodies: stresses on the deformed bodies, and the contact pressure."""

from functools import partial
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult
from flangeway.post import contact_lines
from flangeway.quantities import measured
from flangeway.report.figures.drawing import (
    GREY,
    HERTZ,
    INK,
    NODES,
    SERIES,
    Style,
    box,
    colour_bar,
    equal_axes,
    name_axes,
    new_figure,
    panels,
)
from flangeway.report.figures.stress_picture import DrawnBody, stress_shade
from flangeway.report.page.tables import marked
from flangeway.types import Floats

MAX_HEIGHT_IN, MIN_HEIGHT_IN, MAX_WIDTH_IN = 5.0, 1.6, 11.0  # of panels: height, least height of all, width of all
LETTERS_PER_IN = 13  # of the title
LABELS_IN, BAR_IN = 0.8, 1.0  # for the labels of a panel and its title, for the bar of colours
MARGIN = 0.04


def stress_figure(run: BodiesRun) -> Figure:
    """Draw von Mises stress on the deformed bodies; where they touch, once more near the contact."""
    bodies = [DrawnBody(body.field, partial(_moved, body)) for body in run.bodies.values()]
    values = [body.stresses.von_mises for body in bodies]
    shade, extend = stress_shade(values)
    points = np.vstack([body.points for body in bodies])
    size = float(np.ptp(points, axis=0).max())
    windows = [box([points], MARGIN * size)]
    if run.patches:
        touched = np.vstack([patch.points for patch in run.patches])
        width = 3.0 * max(float(np.ptp(touched, axis=0).max()), 1e-3 * size)
        if width < 0.7 * size:
            windows.append(box([touched.mean(axis=0, keepdims=True)], width / 2.0))
    widths = [float(np.divide(*np.ptp(window, axis=0))) for window in windows]  # of panels one inch high
    height = min(MAX_HEIGHT_IN, MAX_WIDTH_IN / sum(widths))
    width_in = height * sum(widths) + LABELS_IN * len(windows) + BAR_IN
    figure = new_figure(width_in, max(height, MIN_HEIGHT_IN) + LABELS_IN, run.case.units, compressed=True)
    both = figure.subplots(1, len(windows), squeeze=False, width_ratios=widths)[0]
    for axes, window in zip(both, windows, strict=True):
        for body, stress in zip(bodies, values, strict=True):
            body.draw(axes, stress, shade, body.within(window))
        equal_axes(axes, window)
    colour_bar(shade, list(both), "von Mises stress", "MPa", extend=extend)
    word = "" if run.status.converged else ", not converged"
    figure.suptitle(fill(f"{run.case.title}: as deformed{word}", int(LETTERS_PER_IN * width_in)), fontsize=10)
    return figure


def _moved(body: BodyResult, points: Floats, displacements: Floats) -> Floats:
    return points + body.moved(points, displacements)


def pressure_figure(run: BodiesRun) -> Figure:
    """Draw the pressures along each region of contact, with Hertz's where the case has it."""
    units = run.case.units
    figure, ((axes,),) = panels(8.0, 4.5, units=units)
    for number, patch in enumerate(run.patches):
        maximum = marked(measured(float(patch.pressures.max()), "MPa", units), patch.remark)
        style: Style = NODES | {"marker": "osD^"[number % 4], "color": SERIES[number % len(SERIES)]}
        label = f"{run.pairs[patch.contact].name}: maximum {maximum}"
        axes.plot(patch.along, patch.pressures, label=label, **style)
    if run.theory is not None:
        label = f"Hertz, same force: maximum {measured(run.theory.max_pressure, 'MPa', units)}"
        axes.plot(*run.theory.curve, color=GREY, label=label, **HERTZ)
    axes.set_ylim(0.0, 1.05 * float(axes.dataLim.y1))
    words = "length along the surface from the centre of pressure"
    name_axes(axes, (words, "mm"), ("contact pressure", "MPa"))
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    return figure


def traction_figure(run: BodiesRun) -> Figure:
    """Draw the tangential tractions of the contacts with friction between their limits, one contact below another."""
    assert run.contact is not None
    lines = contact_lines(run.contact.system, run.contact.state)
    lines = [line for line in lines if line.contact.friction_coefficient and line.pressures.any()]
    figure, rows = panels(8.0, 2.2 * len(lines) + 0.6, len(lines), 1, run.case.units)
    for axes, line in zip(rows[:, 0], lines, strict=True):
        loaded = np.flatnonzero(line.pressures)
        near = np.arange(max(loaded[0] - 1, 0), min(loaded[-1] + 2, len(line.nodes)))
        way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line.positions[near], axis=0), axis=1))))
        limits = line.contact.friction_coefficient * line.pressures[near]
        for sign in (1.0, -1.0):
            axes.plot(way, sign * limits, color=GREY, lw=1.2, ls="--")
        axes.plot(way, line.tractions[near], color=INK, **NODES)
        axes.set_title(f"{line.contact.secondary.part.name} on {line.contact.primary.part.name}", fontsize=9)
        name_axes(axes, ("length along the surface" if axes is rows[-1, 0] else "", "mm"), ("traction", "MPa"))
    return figure
