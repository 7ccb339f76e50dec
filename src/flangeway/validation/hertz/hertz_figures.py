"""Pictures of the Hertz problem: contact forces, pressures, stresses on the line of symmetry, fields, extremes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from flangeway.exact import LineContact
from flangeway.post import Stresses
from flangeway.problems import ElasticField
from flangeway.report.figures.display import display, displayed_stresses
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.types import Floats
from flangeway.validation.hertz.hertz_reproduced import (
    CODES,
    EXTREMES,
    LEVELS,
    REFERENCE_FORCE,
    VARIANTS,
    HertzReproduction,
    HertzRow,
    Variant,
    published_problem,
    published_value,
)

NAMES = {
    "FDO1": "triangles, order 1",
    "VVO1": "virtual polygons, order 1",
    "FDO2": "triangles, order 2",
    "VVO2": "virtual polygons, order 2",
    "VDO2": "virtual triangles, order 2",
    "HEO2": "triangles, virtual on the arc, order 2",
}
LEVEL_STYLES = (("#56b4e9", "o"), ("#e69f00", "s"), ("#009e73", "^"), ("#0072b2", "."))
CODE_STYLES = (
    ("#777777", "o"),
    ("#e69f00", "s"),
    ("#d55e00", "^"),
    ("#0072b2", "D"),
    ("#cc79a7", "v"),
    ("#009e73", "P"),
)
GRID = {"color": "#dddddd", "linewidth": 0.6}
ZOOM = 1.35  # in half widths
STRESSES = {
    "principal_3": "least principal stress",
    "von_mises": "von Mises stress",
    "in_plane_shear": "maximum shear stress in the plane",
}


def forces_figure(found: HertzReproduction) -> Figure:
    """Contact forces on the nodes of the secondary disc, each code on its finest mesh."""
    figure = new_figure(13.0, 6.0)
    for axes, row in zip(figure.subplots(2, 3).ravel(), _finest(found, "halved"), strict=True):
        points, forces = row.points, row.nodal_forces
        maximum = float(np.linalg.norm(forces, axis=1).max())
        reach = ZOOM * row.theory.half_width
        few = len(points) < 60
        axes.quiver(
            points[:, 0], points[:, 1], forces[:, 0], forces[:, 1],
            angles="xy", scale_units="xy", scale=maximum / reach, color=INK, width=0.003 if few else 0.0015,
            headwidth=3.0 if few else 1.0, headlength=4.0 if few else 0.0, headaxislength=4.0 if few else 0.0,
        )  # fmt: skip
        axes.plot(*points[np.argsort(points[:, 0])].T, color="#d55e00", linewidth=1.2)
        axes.set_xlim(-reach, reach)
        axes.set_ylim(points[:, 1].min() - 0.1 * reach, points[:, 1].max() + 1.1 * reach)
        axes.set_aspect("equal", adjustable="box")
        axes.set_title(f"{row.name}: largest {maximum:.3g} kN, sum {row.force:.2f} kN", fontsize=9)
        axes.set_xlabel("x in cm")
        axes.set_ylabel("y in cm")
    figure.suptitle(f"Contact forces on the nodes of the secondary disc: {VARIANTS['halved']}", fontsize=11)
    return figure


def pressure_figure(found: HertzReproduction, variant: Variant) -> Figure:
    """Pressure over x of every code against Hertz's curve for the same force."""
    rows = found.of(variant)
    codes = [code for code in CODES if any(row.code == code for row in rows)]
    n_lines = -(-len(codes) // 3) if len(codes) > 4 else 2
    figure = new_figure(13.0, 4.0 * n_lines)
    panels = figure.subplots(n_lines, -(-len(codes) // n_lines), sharex=True, sharey=True, squeeze=False)
    for axes, code in zip(panels.ravel(), codes, strict=True):
        mine = [row for row in rows if row.code == code]
        for row in mine:
            colour, marker = LEVEL_STYLES[row.level - 1]
            axes.plot(
                row.pressure.x, row.pressure.values, color=colour, marker=marker, markersize=3.0, linewidth=0.8,
                label=f"M{row.level}: oscillation {100.0 * row.pressure.oscillation:.1f} %",
            )  # fmt: skip
        _hertz_pressure(axes, mine[-1].theory)
        axes.set_title(f"{code}: {NAMES[code]}", fontsize=10)
        axes.grid(**GRID)
        axes.legend(fontsize=8, loc="lower center")
    for axes in panels[-1]:
        axes.set_xlabel("x in cm, before the deformation")
    for axes in panels[:, 0]:
        axes.set_ylabel("contact pressure in kN/cm$^2$")
    how = "" if variant == "segments" else "; node forces over influence widths"
    figure.suptitle(f"Contact pressure: {VARIANTS[variant]}{how}", fontsize=11)
    return figure


def _hertz_pressure(axes: Axes, theory: LineContact) -> None:
    a = theory.half_width
    x = a * np.sin(np.linspace(-np.pi / 2.0, np.pi / 2.0, 181))
    x = np.concatenate(([-ZOOM * a], x, [ZOOM * a]))
    axes.plot(
        x, theory.pressure(x), color=INK, linewidth=1.3, linestyle=(0, (5, 2)), label="Hertz, same force", zorder=5
    )
    axes.set_xlim(-ZOOM * a, ZOOM * a)


def symmetry_figure(found: HertzReproduction) -> Figure:
    """Stresses down the line of symmetry of every code on its finest mesh against Hertz's."""
    figure = new_figure(13.0, 5.2)
    shown: tuple[tuple[str, Callable[[Stresses], Floats], Callable[[Floats], Floats]], ...] = (
        ("normal stress in y", lambda s: s.components[:, 1], lambda t: t[:, 1]),
        ("normal stress in x", lambda s: s.components[:, 0], lambda t: t[:, 0]),
        ("maximum shear stress in the plane", lambda s: s.in_plane_shear, lambda t: np.abs(t[:, 0] - t[:, 1]) / 2.0),
    )
    smooth = [row for row in _finest(found, "segments") if row.code == "VVO2"]
    rows = [*_finest(found, "halved"), *smooth]
    for axes, (label, of, exact) in zip(figure.subplots(1, 3), shown, strict=True):
        for number, row in enumerate(rows):
            colour = CODE_STYLES[number][0] if number < len(CODE_STYLES) else INK
            name = row.name if row.variant == "halved" else f"{row.name}, segment-to-segment"
            style = "solid" if row.variant == "halved" else (0, (1, 1))
            axes.plot(-row.line.points[:, 1], of(row.line.stresses), color=colour, linewidth=1.1, ls=style, label=name)
        depth = np.linspace(0.0, 1.0, 301)
        problem = published_problem("FDO2", 1)
        theory = problem.theory(REFERENCE_FORCE)
        in_disc = exact(theory.axis_stresses_in_disc(depth, problem.primary.radius))
        half_plane = exact(theory.stresses(0.0, depth))
        axes.plot(depth, half_plane, color=INK, linewidth=1.3, linestyle=(0, (5, 2)), label="Hertz, half plane")
        axes.plot(depth, in_disc, color=GREY, linewidth=1.3, linestyle=(0, (5, 2)), label="Hertz, disc (Johnson, 5.6)")
        axes.set_xlabel("depth below the contact in cm")
        axes.set_ylabel(f"{label} in kN/cm$^2$")
        axes.grid(**GRID)
    figure.axes[0].legend(fontsize=8)
    return figure


def extremes_figure(found: HertzReproduction) -> Figure:
    """Extreme stresses over refinement, published and computed."""
    figure = new_figure(13.0, 5.6)
    levels = sorted({row.level for row in found.rows})
    for axes, (table, (name, _)) in zip(figure.subplots(1, 3), EXTREMES.items(), strict=True):
        for code, (colour, marker) in zip(CODES, CODE_STYLES, strict=True):
            computed = [row.extremes[name] for row in found.of("halved") if row.code == code]
            published = [published_value(str(table), code, level) for level in levels]
            common = {"color": colour, "marker": marker, "markersize": 5.0}
            axes.plot(levels, computed, linewidth=1.3, label=f"{code} computed", **common)
            axes.plot(levels, published, linewidth=0.9, linestyle=(0, (2, 2)), mfc="white", label="published", **common)
        for row in found.of("printed"):
            colour = CODE_STYLES[CODES.index(row.code)][0]
            axes.plot(row.level, row.extremes[name], color=colour, marker="_", markersize=9.0, linestyle="none")
        for row in found.of("segments"):
            axes.plot(row.level, row.extremes[name], color=INK, marker="x", linestyle="none")
        reference = published_value(str(table), "ABAQUS", 1)
        axes.axhline(reference, color=INK, linewidth=0.9, linestyle=(0, (6, 3)), label="published reference")
        axes.plot([], [], color=GREY, marker="_", markersize=9.0, linestyle="none", label="penalty as printed")
        axes.plot([], [], color=INK, marker="x", linestyle="none", label="order 2, segment-to-segment")
        axes.set_xticks(list(LEVELS), [f"M{level}" for level in LEVELS])
        axes.set_title(f"Table {table}", fontsize=10)
        axes.set_ylabel(f"extreme of the {STRESSES[name]} in kN/cm$^2$", fontsize=9)
        axes.grid(**GRID)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=8, fontsize=8, frameon=False)
    return figure


@dataclass(frozen=True, eq=False)
class _Window:
    """Box of a panel: its half width, and its name."""

    half_width: float
    name: str


def fields_figure(row: HertzRow) -> Figure:
    """Stress fields of one configuration: both discs, and the zone of contact twice nearer."""
    figure = new_figure(13.0, 11.0)
    panels = figure.subplots(3, 3)
    a = row.theory.half_width
    windows = (_Window(4.1, "whole"), _Window(3.0 * a, "3 a to each side"), _Window(1.0 * a, "a to each side"))
    shown = [_triangles(field) for field in row.fields]
    for line, (name, label) in zip(panels, STRESSES.items(), strict=True):
        values = [_values(stresses, name) for _, stresses in shown]
        norm = Normalize(min(float(v.min()) for v in values), max(float(v.max()) for v in values))
        colours = COLOURS.reversed() if name == "principal_3" else COLOURS
        for axes, window in zip(line, windows, strict=True):
            for (grid, _), value in zip(shown, values, strict=True):
                seen = _within(grid, window.half_width)
                part = Triangulation(grid.x, grid.y, grid.triangles[seen])
                axes.tripcolor(part, value, shading="gouraud", cmap=colours, norm=norm, rasterized=True)
            axes.set_xlim(-window.half_width, window.half_width)
            axes.set_ylim(-window.half_width, window.half_width)
            axes.set_aspect("equal", adjustable="box")
            axes.set_title(window.name, fontsize=9)
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(line), shrink=0.9)
        bar.set_label(f"{label} in kN/cm$^2$\nextreme {row.extremes[name]:.1f}", fontsize=9)
    figure.suptitle(
        f"{row.name}: {NAMES[row.code]}, {VARIANTS[row.variant]}\nvalues of each cell, not averaged, undeformed; cm",
        fontsize=11,
    )
    return figure


def _triangles(field: ElasticField) -> tuple[Triangulation, Stresses]:
    shown = display(field.problem.space, 1)
    grid = Triangulation(shown.points[:, 0], shown.points[:, 1], shown.triangles)
    return grid, displayed_stresses(field, shown)


def _values(stresses: Stresses, name: str) -> Floats:
    if name == "principal_3":
        least: Floats = stresses.principal[:, 2]
        return least
    return stresses.von_mises if name == "von_mises" else stresses.in_plane_shear


def _within(grid: Triangulation, half_width: float) -> NDArray[np.bool_]:
    """Triangles that reach into a window about the origin."""
    x, y = grid.x[grid.triangles], grid.y[grid.triangles]
    near = (np.abs(x).min(axis=1) < half_width) & (np.abs(y).min(axis=1) < half_width)
    result: NDArray[np.bool_] = near
    return result


def _finest(found: HertzReproduction, variant: Variant) -> Sequence[HertzRow]:
    """Finest mesh of each code."""
    best: dict[str, HertzRow] = {}
    for row in found.of(variant):
        if row.code not in best or row.level > best[row.code].level:
            best[row.code] = row
    return list(best.values())


def finest_rows(found: HertzReproduction) -> Sequence[HertzRow]:
    """Rows whose fields are drawn: each published code on its finest mesh, and segment-to-segment polygons."""
    smooth = [row for row in _finest(found, "segments") if row.code == "VVO2"]
    return [*_finest(found, "halved"), *smooth]
