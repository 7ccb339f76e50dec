"""Picture of the whole wheelset: both sides deformed, with von Mises stress, about a sketch of the whole."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon, Rectangle
from numpy.typing import NDArray

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.railway.track.placements import SIDES, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    ColourSteps,
    Room,
    alike,
    box,
    cells_path,
    draw_contours,
    draw_outline,
    draw_title,
    equal_axes,
    figure_with_room,
    fill_cells,
)
from flangeway.report.figures.fields import PartFields

DEFORMATION_SHARE = 0.025
ROOM = Room(left=0.72, right=0.75, bottom=1.3, top=0.68, across=0.15)
FACTORS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def wheelset_figure(run: WheelsetRun, parts: list[PartFields]) -> Figure:
    """Draw the left side at the left, the right side at the right, and the sketch between them."""
    figure, ((left, middle, right),) = figure_with_room(13.0, 7.0, ROOM, n_columns=3, width_ratios=(1.0, 1.25, 1.0))
    colours = ColourSteps(np.concatenate([part.stresses.von_mises[_valid(part)] for part in parts]), from_zero=True)
    factor = deformation_factor(parts)
    windows = alike([box([part.points(factor) for part in parts if part.side == side], 6.0) for side in SIDES])
    for axes, side, window in zip((left, right), SIDES, windows, strict=True):
        equal_axes(axes, window)
        _draw_side(axes, [part for part in parts if part.side == side], factor, colours)
        draw_title(axes, f"{side} wheel and rail".capitalize())
    right.yaxis.set_label_position("right")
    right.yaxis.tick_right()
    draw_sketch(middle, run.plane.model.problem, run.plane.equilibrium.position)
    draw_title(middle, _title(run), 11.0)
    below = figure.add_axes((0.12, 0.063, 0.76, 0.027))
    bar = figure.colorbar(colours.mappable(), cax=below, orientation="horizontal")
    bar.set_label(
        f"von Mises stress in MPa, element averages ({_cells(run)}); hatched: web and foot of the slice, not valid; "
        f"deformation x{factor} since first touch (dashed)"
    )
    return figure


def deformation_factor(parts: list[PartFields]) -> int:
    """Round factor by which the maximum displacement becomes a fortieth of a part or less."""
    maximum = max(float(np.abs(part.points() - part.touch_points).max()) for part in parts)
    size = max(float(np.ptp(part.touch_points, axis=0).max()) for part in parts)
    if not maximum > 0.0:
        return 1
    wanted = DEFORMATION_SHARE * size / maximum
    return max((f for f in FACTORS if f <= wanted), default=1)


def _draw_side(axes: Axes, parts: list[PartFields], factor: float, colours: ColourSteps) -> None:
    for part in parts:
        points, values = part.points(factor), part.stresses.von_mises
        chosen = _valid(part)
        fill_cells(axes, part.mesh, points, values, colours, chosen=chosen)
        draw_contours(axes, part, points, values, colours, chosen)
        if not chosen.all():
            web = cells_path(part.mesh, points, np.flatnonzero(~chosen))
            axes.add_artist(PathPatch(web, facecolor="none", edgecolor=STEEL, hatch="////", lw=0.0))
        draw_outline(axes, part.mesh, points)
        draw_outline(axes, part.mesh, part.touch_points, dashed=True)


def _valid(part: PartFields) -> NDArray[np.bool_]:
    return np.ones(part.mesh.n_cells, dtype=np.bool_) if part.above_web is None else part.above_web


def _title(run: WheelsetRun) -> str:
    problem = run.plane.model.problem
    track = problem.track
    inclination = f"rail inclination 1:{1.0 / track.rail_inclination:g}" if track.rail_inclination else "upright"
    return (
        f"{problem.wheelset.wheel.title}\non {track.rail.title}, {inclination}\n"
        f"{problem.load.vertical_N / 1e3:g} kN on {problem.thickness_mm:g} mm of length"
    )


def _cells(run: WheelsetRun) -> str:
    return "triangles" if run.plane.problem.discretisation.method == "fem" else "polygons"


RIM_WIDTH_MM = 140.0
AXLE_RADIUS_MM = 85.0
STEEL = "#c9ced6"


def draw_sketch(axes: Axes, problem: WheelsetProblem, motion: WheelsetPosition) -> None:
    """Draw wheels, axle, rails, load and dimensions; what is not modelled is only outlined."""
    wheelset, track = problem.wheelset, problem.track
    axle = wheelset.tape_radius_mm
    inner, half_gauge = wheelset.back_to_back_mm / 2.0, track.gauge_mm / 2.0
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        _draw_wheel(axes, sign, inner, axle, wheelset.radius_mm)
        for outline, placement in (
            (wheelset.wheel_of(side).outline, motion.placement(wheelset, side)),
            (track.rail_of(side).outline, track.placement(side)),
        ):
            points = placement.points(outline.sampled(max_deviation=0.2))
            axes.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.7))
    axes.add_patch(
        Rectangle(
            (-inner, axle - AXLE_RADIUS_MM), 2 * inner, 2 * AXLE_RADIUS_MM,
            facecolor="none", edgecolor=GREY, lw=0.8, ls="--",
        )
    )  # fmt: skip
    axes.plot([-inner - 200, inner + 200], [axle, axle], color=GREY, lw=0.6, ls="-.")
    _draw_load(axes, problem, axle)
    for x in (-half_gauge, half_gauge):
        axes.plot([x, x], [-300, -10], color=INK, lw=0.5)
    _dimension(axes, (-half_gauge, -275), (half_gauge, -275), f"gauge {track.gauge_mm:g} mm")
    high = axle + 0.6 * wheelset.radius_mm
    _dimension(axes, (-inner, high), (inner, high), f"back to back {wheelset.back_to_back_mm:g} mm", 0.75)
    beside, tread = inner - 110, inner + wheelset.wheel.flange_back_mm
    axes.plot([beside - 30, tread], [0.0, 0.0], color=INK, lw=0.5)
    _dimension(axes, (beside, axle), (beside, 0.0), f"radius {axle:.5g} mm")
    top = axle + wheelset.centre_of_gravity_height_mm
    axes.set(xlim=(-half_gauge - 160, half_gauge + 160), ylim=(-320, max(top + 340, axle + wheelset.radius_mm) + 20))
    axes.set_aspect("equal", anchor="S")
    axes.set_axis_off()


def _draw_wheel(axes: Axes, sign: float, inner: float, axle: float, radius: float) -> None:
    left = sign * inner if sign > 0 else -inner - RIM_WIDTH_MM
    axes.add_patch(
        Rectangle(
            (left, axle - radius), RIM_WIDTH_MM, 2 * radius,
            facecolor="none", edgecolor=GREY, lw=0.8, ls="--",
        )
    )  # fmt: skip


def _draw_load(axes: Axes, problem: WheelsetProblem, axle: float) -> None:
    wheelset, load = problem.wheelset, problem.load
    x, y = WheelsetPosition().centre_of_gravity(wheelset)
    axes.plot([x], [y], marker="o", color=INK, ms=4)
    axes.annotate("", (x, y), (x, y + 330), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4})
    along = load.in_track[0]
    if along:
        start = x - 330 if along > 0.0 else x + 330
        axes.annotate("", (x, y), (start, y), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4})
        # beside the dimension of the height, which is left of the centre of gravity
        axes.text(
            x - 115 if along > 0.0 else start,
            y - 60,
            f"{abs(along) / 1e3:.4g} kN lateral,\nin the track's plane",
            fontsize=8,
            ha="right" if along > 0.0 else "center",
            va="top",
        )
    axes.text(x + 45, y + 250, f"{load.in_track[1] / 1e3:.4g} kN", fontsize=8, va="center")
    axes.text(x + 45, y, "centre of gravity of the car", fontsize=7, va="center")
    _dimension(axes, (x - 90, axle), (x - 90, y), f"{wheelset.centre_of_gravity_height_mm:g} mm above the axle")


def _dimension(axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, at: float = 0.5) -> None:
    """Draw an arrow between two points with a text beside it, part `at` of the way."""
    axes.annotate(
        "", start, end, arrowprops={"arrowstyle": "<|-|>", "color": INK, "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    )
    middle = (1.0 - at) * np.array(start) + at * np.array(end)
    vertical = start[0] == end[0]
    axes.text(
        middle[0] - (25 if vertical else 0),
        middle[1] + (0 if vertical else 25),
        text,
        fontsize=7,
        rotation=90 if vertical else 0,
        ha="right" if vertical else "center",
        va="center" if vertical else "bottom",
    )
