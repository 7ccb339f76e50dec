"""Figures and chapter of the Hertz problem: forces, pressures, stresses on the line of symmetry, fields, extremes."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from flangeway.exact import LineContact
from flangeway.post import Stresses
from flangeway.report.figures.display import shaded
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS, Quantity, stress_quantity
from flangeway.report.page.tables import SummaryTable
from flangeway.types import Floats
from studies.hertz.hertz_reproduced import (
    CODES,
    FINE,
    FORCE_LIMITS,
    REFERENCE_FORCE,
    STRESS_LIMIT,
    VARIANTS,
    HertzReproduction,
    HertzRow,
    Variant,
    published_case,
    reproduce_hertz,
)
from studies.published_numbers import digits, percent, share
from studies.reproduction import Chapter, PagePicture, Reproduction

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
STRESSES: dict[Quantity, str] = {
    "principal_3": "minimum principal stress",
    "von_mises": "von Mises stress",
    "in_plane_shear": "maximum shear stress in the plane",
}


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
        axes.set_xlabel("x in cm, undeformed")
    for axes in panels[:, 0]:
        axes.set_ylabel("contact pressure in kN/cm$^2$")
    how = "" if variant == "segments" else "; nodal forces over influence widths"
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
        case = published_case("FDO2", 1)
        theory = case.theory(REFERENCE_FORCE)
        in_disc = exact(theory.axis_stresses_in_disc(depth, case.lower_radius_mm))
        half_plane = exact(theory.stresses(0.0, depth))
        axes.plot(depth, half_plane, color=INK, linewidth=1.3, linestyle=(0, (5, 2)), label="Hertz, half plane")
        axes.plot(depth, in_disc, color=GREY, linewidth=1.3, linestyle=(0, (5, 2)), label="Hertz, disc (Johnson, 5.6)")
        axes.set(xlabel="depth below the contact in cm", ylabel=f"{label} in kN/cm$^2$")
        axes.grid(**GRID)
    figure.axes[0].legend(fontsize=8)
    return figure


def fields_figure(found: HertzReproduction, code: str, variant: Variant = "halved") -> Figure:
    """Stress fields of one code on its finest mesh: both discs, and the zone of contact in two enlargements."""
    row = next(row for row in _finest(found, variant) if row.code == code)
    figure = new_figure(13.0, 11.0)
    panels = figure.subplots(3, 3)
    a = row.theory.half_width
    windows = ((4.1, "whole"), (3.0 * a, "±3 a"), (a, "±a"))
    shown = [shaded(field, 1) for field in row.fields]
    for line, (name, label) in zip(panels, STRESSES.items(), strict=True):
        values = [stress_quantity(stresses, name) for _, stresses in shown]
        norm = Normalize(min(float(v.min()) for v in values), max(float(v.max()) for v in values))
        colours = COLOURS.reversed() if name == "principal_3" else COLOURS
        for axes, (half_width, title) in zip(line, windows, strict=True):
            for (grid, _), value in zip(shown, values, strict=True):
                seen = _within(grid, half_width)
                part = Triangulation(grid.x, grid.y, grid.triangles[seen])
                axes.tripcolor(part, value, shading="gouraud", cmap=colours, norm=norm, rasterized=True)
            axes.set(xlim=(-half_width, half_width), ylim=(-half_width, half_width))
            axes.set_aspect("equal", adjustable="box")
            axes.set_title(title, fontsize=9)
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(line), shrink=0.9)
        bar.set_label(f"{label} in kN/cm$^2$\nextreme {row.extremes[name]:.1f}", fontsize=9)
    figure.suptitle(
        f"{row.name}: {NAMES[row.code]}, {VARIANTS[row.variant]}\nelement values, not averaged, undeformed; cm",
        fontsize=11,
    )
    return figure


def _within(grid: Triangulation, half_width: float) -> NDArray[np.bool_]:
    """Triangles that reach into a window about the origin."""
    x, y = np.abs(grid.x[grid.triangles]), np.abs(grid.y[grid.triangles])
    return np.asarray((x.min(axis=1) < half_width) & (y.min(axis=1) < half_width))


def _finest(found: HertzReproduction, variant: Variant) -> Sequence[HertzRow]:
    """Finest mesh of each code."""
    best: dict[str, HertzRow] = {}
    for row in found.of(variant):
        if row.code not in best or row.level > best[row.code].level:
            best[row.code] = row
    return list(best.values())


def _tables(found: HertzReproduction) -> list[SummaryTable]:
    """Pressure oscillation on the finest mesh."""
    finest = max(row.level for row in found.rows)
    rows = tuple(
        (
            VARIANTS[row.variant],
            row.name,
            f"{row.n_unknowns}",
            digits(row.force),
            share(row.pressure.oscillation),
            share(row.pressure_difference),
        )
        for row in found.rows
        if row.level == finest
    )
    caption = (
        f"Pressures on M{finest} compared with Hertz's pressure of the same force, relative to its maximum: root mean "
        "square oscillation, and maximum difference except in the element at each end of the contact"
    )
    return [SummaryTable(caption, ("contact", "code", "unknowns", "force (kN)", "oscillation", "difference"), rows)]


HERTZ = Reproduction(
    reproduce_hertz,
    Chapter(
        "Hertz's problem",
        f"""Two half discs pressed together: Moherdaui's section 6.2.2 with Tables 9 to 14 (pages 162 to 179). Its
        reference force of {REFERENCE_FORCE} kN (Table 11) must be reproduced to {percent(FORCE_LIMITS[1])}, by order 2
        from M{FINE} on to {percent(FORCE_LIMITS[2])}, with the penalty as Table 10 prints it. Extreme stresses of
        Tables 12 to 14 are reproduced with this penalty halved at each refinement: those of polygons, VVO1 and VVO2,
        must agree to {percent(STRESS_LIMIT)}; the others are single values of elements that oscillate, and are shown
        only. In the rows "Hertz", segment-to-segment contact with multipliers is compared with Hertz's theory (1882),
        with limits from M{FINE} on: it removes the oscillations of the published pictures. Codes such as VVO2M3: F, V
        or H, finite elements, virtual ones, or virtual ones at the arc alone; D, V or E, triangles, polygons or refined
        edges; the order; the mesh.""",
        (
            PagePicture(
                "hertz-node-to-segment",
                "Pressures of node-to-segment contact for six kinds of elements beside Hertz's curve: they oscillate, "
                "most for triangles and for virtual triangles of order 2",
                partial(pressure_figure, variant="halved"),
            ),
            PagePicture(
                "hertz-segment-to-segment",
                "Pressures of segment-to-segment contact for four kinds of elements of order 2: they lie on Hertz's "
                "curve",
                partial(pressure_figure, variant="segments"),
            ),
        ),
        _tables,
    ),
    {
        "pressure_node_to_segment.png": partial(pressure_figure, variant="halved"),
        "pressure_penalty_as_printed.png": partial(pressure_figure, variant="printed"),
        "pressure_segment_to_segment.png": partial(pressure_figure, variant="segments"),
        "symmetry_line.png": symmetry_figure,
        **{f"stresses_{code}.png": partial(fields_figure, code=code) for code in CODES},
        "stresses_VVO2_segment_to_segment.png": partial(fields_figure, code="VVO2", variant="segments"),
    },
)
