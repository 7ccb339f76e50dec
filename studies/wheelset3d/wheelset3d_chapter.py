"""Figures and chapter of the wheelset in three dimensions."""

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.report.page.tables import SummaryTable
from studies.published_numbers import digits, percent
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.spatial.profile_blocks import LIMIT
from studies.wheelset3d.element_methods import DIRECT_LIMIT, FORCE_LIMIT, METHODS
from studies.wheelset3d.element_methods import PRESSURE_LIMIT as METHODS_LIMIT
from studies.wheelset3d.manchester import FORCE_LIMIT as BENCHMARK_FORCE_LIMIT
from studies.wheelset3d.manchester import POSITION_LIMIT_MM, PRESSURE_LIMIT, STEEPEST_RAD
from studies.wheelset3d.wheelset3d_reproduced import (
    Wheelset3dReproduction,
    patches_table,
    positions_table,
    reproduce_wheelset3d,
)


def manchester_figure(found: Wheelset3dReproduction) -> Figure:
    """Draw maximum pressure and contact point over the lateral position, and the deviation of the pressure."""
    figure = new_figure(10.5, 3.8)
    pressure, deviation, place = figure.subplots(1, 3)
    rows = positions_table(found)
    y, known = (np.array([row[name] for row in rows], dtype=float) for name in ("y_published", "p0_published"))
    real, half = (np.array([row[name] for row in rows], dtype=float) for name in ("p0", "p0_half_spaces"))
    pressure.plot(y, known, "o", color=GREY, ms=5, label="CONTACT")
    pressure.plot(y, real, color=INK, lw=1.0, label="flangeway")
    pressure.set_ylabel("maximum pressure in MPa")
    for values, line, label in (
        (real, "solid", "flangeway, rail and wheel"),
        (half, "dashed", "flangeway, half-spaces"),
    ):
        deviation.plot(y, 100.0 * (values / known - 1.0), color=INK, ls=line, lw=1.0, marker=".", label=label)
    deviation.axhline(0.0, color=GREY, lw=0.8)
    deviation.set_ylim(-100.0 * PRESSURE_LIMIT, 100.0 * PRESSURE_LIMIT)
    deviation.set_ylabel("deviation of the maximum pressure in %")
    place.plot(y, [row["wheel_y_published"] for row in rows], "o", color=GREY, ms=5, label="CONTACT")
    place.plot(y, [row["wheel_y"] for row in rows], color=INK, lw=1.0, label="flangeway, as CONTACT")
    place.plot(y, [row["wheel_y_pressure"] for row in rows], color=INK, ls="dashed", lw=1.0, label="centre of pressure")
    place.set_ylabel("position on the wheel in mm")
    for axes in (pressure, deviation, place):
        axes.set_xlabel("lateral position in mm")
        axes.grid(which="major", color="#e4e4e4", linewidth=0.5)
        axes.legend(frameon=False, fontsize=8)
    return figure


def curve_figure(found: Wheelset3dReproduction) -> Figure:
    """Draw the pressures on the right wheel in the curve by all kinds of elements."""
    runs = [run for run in found.runs if run.situation == "curve"]
    figure = new_figure(10.5, 2.7)
    every = list(np.atleast_1d(figure.subplots(1, len(runs), sharex=True, sharey=True)))
    maximum = max(each.ellipse.max_pressure for run in runs for each in run.result.patches if each.side == "right")
    for axes, run in zip(every, runs, strict=True):
        patches = [each for each in run.result.patches if each.side == "right"]
        grid = patches[0].state.grid.grid
        pressures = patches[0].state.cells.pressures
        along = grid.strip * np.append(grid.planes - 0.5, grid.planes[-1] + 0.5)
        for first in range(len(grid.cells)):
            row = pressures[first : first + 1]
            axes.pcolormesh(
                along, grid.cells[first], np.where(row > 0.0, row, np.nan), cmap=COLOURS, vmin=0.0, vmax=maximum
            )
        axes.set_aspect("equal")
        worst = max(each.ellipse.max_pressure for each in patches)
        axes.set_title(f"{run.method} {run.order}: {worst:.0f} MPa", fontsize=10)
        axes.set_xlabel("z in mm", fontsize=9)
        axes.set_ylabel("across the rail in mm", fontsize=9)
        axes.label_outer()
    figure.colorbar(ScalarMappable(Normalize(0.0, maximum), COLOURS), ax=every, label="pressure in MPa", shrink=0.8)
    return figure


def _tables(found: Wheelset3dReproduction) -> Sequence[SummaryTable]:
    """The patches of tangent and curve."""
    rows = tuple(
        (
            f"{row['situation']}, {row['method']} {row['order']}, {row['side']}",
            str(row["region"]),
            *(digits(float(str(row[name])), 5) for name in ("force", "p0", "longer_semi_axis", "shorter_semi_axis")),
        )
        for row in patches_table(found)
    )
    head = ("situation, elements, wheel", "region", "force, N", "p0, MPa", "semi-axes, mm", "")
    return [SummaryTable("Patches of S1002 on 60E1 at standard gauge", head, rows)]


WHEELSET3D = Reproduction(
    reproduce_wheelset3d,
    Chapter(
        "The wheelset in three dimensions",
        f"""Wheels on rails in three dimensions. The Manchester contact benchmark (Shackleton and Iwnicki 2008), case
        A-2.2, left wheel, S1002 on UIC60 under 10 kN with yaw and roll in 21 lateral positions, beside E. A. H.
        Vollebregt's CONTACT: maximum pressure to {percent(PRESSURE_LIMIT)}, normal force to
        {percent(BENCHMARK_FORCE_LIMIT)}, contact point on the wheel to {POSITION_LIMIT_MM:g} mm where the contact angle
        is below {STEEPEST_RAD:g} rad and the patch in one piece; with the elasticity of rail and wheel, and of
        half-spaces, which CONTACT's bodies are. Ours is without friction: CONTACT's creep forces of up to 3 kN change
        its normal force by up to 0.5 %. Its contact point is the centre of the squared overlap of the undeformed
        surfaces; ours is computed in the same way, and the centre of pressure is shown beside it. The rail is the
        bundled 60E1 (EN 13674-1): the arc of 300 mm on the head of the benchmark's rail is about 0.25 mm longer on
        each side. Tangent and curve (500 m, 80 km/h, 60 mm of superelevation) at standard gauge by finite and virtual
        elements of both orders: forces to {percent(FORCE_LIMIT)}, pressures to {percent(METHODS_LIMIT)} beside those of
        {METHODS[0][0]} {METHODS[0][1]}. Patches of a tabulated compliance beside those of a mesh that is fine in the
        patch, which is pressed directly: {percent(DIRECT_LIMIT)}. One position with true profiles, cut to blocks of
        60 mm, beside C3D20 of CalculiX: {percent(LIMIT)}.""",
        (
            PagePicture(
                "wheelset3d-manchester",
                "Maximum pressure, its deviation from CONTACT and the contact point on the wheel over the lateral "
                "position: all points of CONTACT lie on the curves of flangeway",
                manchester_figure,
            ),
            PagePicture(
                "wheelset3d-curve",
                "Pressures on the right rail in a curve by finite and virtual elements: the patches are the same",
                curve_figure,
            ),
        ),
        _tables,
    ),
    {"manchester.png": manchester_figure, "curve.png": curve_figure},
    {"manchester.csv": positions_table, "patches.csv": patches_table},
)
