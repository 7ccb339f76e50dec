"""Pictures of a case of bodies: stresses on the deformed bodies, and the contact pressure."""

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult
from flangeway.post import contact_lines
from flangeway.report.figures.display import display, displayed_stresses
from flangeway.report.figures.drawing import GREY, INK, SERIES, draw_lines, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.report.page.tables import marked
from flangeway.types import Floats

COLOUR_QUANTILE = 0.999  # fraction of the values within the colour range: stresses at sharp corners are singular
MAX_HEIGHT_IN, MIN_HEIGHT_IN, MAX_WIDTH_IN = 5.0, 1.6, 11.0  # of panels: height, least height of all, width of all
LETTERS_PER_IN = 13  # of the title
LABELS_IN, BAR_IN = 0.8, 1.0  # for the labels of a panel and its title, for the bar of colours
MARGIN = 0.04


def stress_figure(run: BodiesRun) -> Figure:
    """Draw von Mises stress on the deformed bodies; where they touch, once more near the contact."""
    drawn = {name: _drawn(body) for name, body in run.bodies.items()}
    values = np.concatenate([stress for _, _, stress in drawn.values()])
    maximum = float(np.quantile(values, COLOUR_QUANTILE)) or float(values.max()) or 1.0
    norm = Normalize(0.0, maximum)
    points = np.vstack([place for place, _, _ in drawn.values()])
    windows = [_window(points)]
    if run.patches:
        touched = np.vstack([patch.points for patch in run.patches])
        width = 3.0 * max(float(np.ptp(touched, axis=0).max()), 1e-3 * float(np.ptp(points, axis=0).max()))
        middle = touched.mean(axis=0)
        if width < 0.7 * float(np.ptp(points, axis=0).max()):
            windows.append(np.array([middle - width / 2.0, middle + width / 2.0]))
    widths = [float(np.divide(*np.ptp(window, axis=0))) for window in windows]  # of panels one inch high
    height = min(MAX_HEIGHT_IN, MAX_WIDTH_IN / sum(widths))
    figure = new_figure(
        height * sum(widths) + LABELS_IN * len(windows) + BAR_IN, max(height, MIN_HEIGHT_IN) + LABELS_IN
    )
    figure.set_layout_engine("compressed")
    both = figure.subplots(1, len(windows), squeeze=False, width_ratios=widths)[0]
    for axes, window in zip(both, windows, strict=True):
        for name, body in run.bodies.items():
            _draw(axes, body, drawn[name], norm)
        axes.set_aspect("equal", adjustable="box")
        axes.set(
            xlim=(window[0, 0], window[1, 0]), ylim=(window[0, 1], window[1, 1]), xlabel="x in mm", ylabel="y in mm"
        )
    colours = both[0].collections[0]
    extend = "max" if float(values.max()) > maximum else "neither"
    figure.colorbar(colours, ax=list(both), label="von Mises stress in MPa", extend=extend, shrink=0.9)
    word = "" if run.status.converged else ", not converged"
    title = f"{run.case.title}: as deformed{word}"
    figure.suptitle(fill(title, int(LETTERS_PER_IN * figure.get_figwidth())), fontsize=10)
    return figure


def pressure_figure(run: BodiesRun) -> Figure:
    """Draw the pressures along each region of contact, with Hertz's where the case has it."""
    figure = new_figure(8.0, 4.5)
    axes = figure.subplots()
    assert run.contact is not None
    for number, patch in enumerate(run.patches):
        contact = run.contact.system.contacts[patch.contact]
        label = f"{contact.secondary.part.name} on {contact.primary.part.name}"
        axes.plot(
            patch.along, patch.pressures, color=SERIES[number % len(SERIES)], lw=1.0, marker="osD^"[number % 4], ms=3.0,
            mfc="white", label=f"{label}: maximum {marked(f'{patch.pressures.max():.4g} MPa', patch.remark)}",
        )  # fmt: skip
    if run.theory is not None:
        x = run.theory.half_width * np.sin(np.linspace(-np.pi / 2.0, np.pi / 2.0, 181))
        axes.plot(
            x, run.theory.pressure(x), color=GREY, lw=1.8, ls="--", zorder=1,
            label=f"Hertz, same force: maximum {run.theory.max_pressure:.4g} MPa",
        )  # fmt: skip
    axes.set(xlabel="length along the surface from the centre of pressure in mm", ylabel="contact pressure in MPa")
    axes.set_ylim(0.0, 1.05 * float(axes.dataLim.y1))
    axes.grid(color="#dddddd", linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    return figure


def traction_figure(run: BodiesRun) -> Figure:
    """Draw the tangential tractions of the contacts with friction between their limits, one contact below another."""
    assert run.contact is not None
    lines = [line for line in contact_lines(run.contact.system, run.contact.state) if line.contact.friction_coefficient]
    lines = [line for line in lines if line.pressures.any()]
    figure = new_figure(8.0, 2.2 * len(lines) + 0.6)
    for axes, line in zip(figure.subplots(len(lines), squeeze=False)[:, 0], lines, strict=True):
        loaded = np.flatnonzero(line.pressures)
        near = np.arange(max(loaded[0] - 1, 0), min(loaded[-1] + 2, len(line.nodes)))
        way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line.positions[near], axis=0), axis=1))))
        limits = line.contact.friction_coefficient * line.pressures[near]
        for sign in (1.0, -1.0):
            axes.plot(way, sign * limits, color=GREY, lw=1.2, ls="--")
        axes.plot(way, line.tractions[near], color=INK, lw=1.0, marker="o", ms=3.0, mfc="white")
        names = f"{line.contact.secondary.part.name} on {line.contact.primary.part.name}"
        axes.set_title(names, fontsize=9)
        axes.set(ylabel="traction in MPa")
        axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_xlabel("length along the surface in mm")
    return figure


def _drawn(body: BodyResult) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Deformed points, triangles, and von Mises stresses at the points."""
    shown = display(body.field.problem.space)
    points = shown.points + body.moved(shown.points, shown.function(body.field.displacements))
    return points, shown.triangles, displayed_stresses(body.field, shown).von_mises


def _draw(axes: Axes, body: BodyResult, drawn: tuple[Floats, NDArray[np.int64], Floats], norm: Normalize) -> None:
    points, triangles, stress = drawn
    axes.tripcolor(
        Triangulation(points[:, 0], points[:, 1], triangles), stress, shading="gouraud", cmap=COLOURS, norm=norm,
        rasterized=True,
    )  # fmt: skip
    mesh = body.field.problem.space.mesh
    moved = mesh.points + body.moved(mesh.points, body.field.displacements[: mesh.n_points])
    width = float(np.clip(12.0 / np.sqrt(mesh.n_cells), 0.1, 0.5))
    draw_lines(axes, moved[mesh.edges], GREY, width, alpha=0.6)
    draw_lines(axes, moved[mesh.boundary_edges], INK, 0.9)


def _window(points: Floats) -> Floats:
    low, high = points.min(axis=0), points.max(axis=0)
    margin = MARGIN * float((high - low).max())
    return np.array([low - margin, high + margin])
