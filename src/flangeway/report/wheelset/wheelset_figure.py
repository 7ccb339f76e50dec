"""Picture of the whole wheelset: both sides deformed, with von Mises stress, about a sketch of the whole."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from numpy.typing import NDArray

from flangeway.cases import CaseRun
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.cell_patches import cells_path, fill_cells
from flangeway.report.figures.drawing import (
    Room,
    StressColours,
    box,
    draw_contours,
    draw_outline,
    draw_title,
    equal_axes,
    figure_with_room,
)
from flangeway.report.figures.fields import PartFields
from flangeway.report.wheelset.sketch import STEEL, draw_sketch

DEFORMATION_SHARE = 0.025
ROOM = Room(left=0.72, right=0.75, bottom=1.3, top=0.68, across=0.15)
FACTORS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def wheelset_figure(run: CaseRun, parts: list[PartFields]) -> Figure:
    """Draw the left side at the left, the right side at the right, and the sketch between them."""
    figure, ((left, middle, right),) = figure_with_room(13.0, 7.0, ROOM, n_columns=3, width_ratios=(1.0, 1.25, 1.0))
    colours = StressColours(np.concatenate([part.stresses.von_mises[_believed(part)] for part in parts]))
    factor = deformation_factor(parts)
    for axes, side in ((left, SIDES[0]), (right, SIDES[1])):
        _draw_side(axes, [part for part in parts if part.side == side], factor, colours)
        draw_title(axes, f"{side} wheel and rail".capitalize())
    right.yaxis.set_label_position("right")
    right.yaxis.tick_right()
    draw_sketch(middle, run.result)
    draw_title(middle, _title(run), 11.0)
    below = figure.add_axes((0.12, 0.063, 0.76, 0.027))
    bar = figure.colorbar(colours.mappable(), cax=below, orientation="horizontal")
    bar.set_label(
        f"von Mises stress in MPa, means of cells ({_cells(run)}); hatched: web and foot of the slice, not to be "
        f"believed; motion since first touch drawn {factor} times as large, first touch dashed"
    )
    return figure


def deformation_factor(parts: list[PartFields]) -> int:
    """Round factor by which the maximum motion becomes a fortieth of a part or less."""
    maximum = max(float(np.abs(part.points() - part.touch_points).max()) for part in parts)
    size = max(float(np.ptp(part.touch_points, axis=0).max()) for part in parts)
    if not maximum > 0.0:
        return 1
    wanted = DEFORMATION_SHARE * size / maximum
    return max((f for f in FACTORS if f <= wanted), default=1)


def _draw_side(axes: Axes, parts: list[PartFields], factor: float, colours: StressColours) -> None:
    equal_axes(axes, box([part.points(factor) for part in parts], 6.0))
    for part in parts:
        points, values = part.points(factor), part.stresses.von_mises
        chosen = _believed(part)
        fill_cells(axes, part.mesh, points, values, colours, chosen=chosen)
        draw_contours(axes, part, points, values, colours, chosen)
        if not chosen.all():
            web = cells_path(part.mesh, points, np.flatnonzero(~chosen))
            axes.add_patch(PathPatch(web, facecolor="none", edgecolor=STEEL, hatch="////", lw=0.0))
        draw_outline(axes, part.mesh, points)
        draw_outline(axes, part.mesh, part.touch_points, dashed=True)


def _believed(part: PartFields) -> NDArray[np.bool_]:
    return np.ones(part.mesh.n_cells, dtype=np.bool_) if part.above_web is None else part.above_web


def _title(run: CaseRun) -> str:
    problem = run.result.model.problem
    track = problem.track
    cant = f"canted 1:{1.0 / track.cant:g}" if track.cant else "upright"
    return (
        f"{problem.wheelset.wheel.title}\non {track.rail.title}, {cant}\n"
        f"{problem.load.vertical_N / 1e3:g} kN on {problem.thickness_mm:g} mm of length; lengths in mm"
    )


def _cells(run: CaseRun) -> str:
    return "triangles" if run.case.method == "fem" else "polygons"
