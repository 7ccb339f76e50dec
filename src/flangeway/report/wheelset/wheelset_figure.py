"""Picture of the whole wheelset: both sides deformed, with von Mises stress, about a sketch of the whole."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon, Rectangle

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.quantities import measured
from flangeway.railway.track.placements import SIDES, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.wheelset_checks import above_the_web
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    box,
    cells_path,
    colour_bar,
    draw_lines,
    equal_axes,
    new_figure,
    units_of,
)
from flangeway.report.figures.fields import drawn_parts
from flangeway.report.figures.plots import round_factor
from flangeway.report.figures.stress_picture import stress_shade
from flangeway.types import Floats

DEFORMATION_SHARE = 0.025


def sides_about_sketch(
    run: WheelsetRun, height_in: float, windows: Sequence[Floats], title: str
) -> tuple[Figure, tuple[Axes, Axes]]:
    """Return a figure with a sketch of the whole in the middle, and the axes of both sides beside it.

    - `windows`: corners (2, 2) of what is shown of each side.
    - `title`: text above the sketch.
    """
    figure = new_figure(13.0, height_in, run.case.units)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.0, 1.1, 1.0))
    for axes, side, window in zip((left, right), SIDES, windows, strict=True):
        equal_axes(axes, window)
        axes.set_title(f"{side} wheel and rail".capitalize(), fontsize=10)
    right.yaxis.set_label_position("right")
    right.yaxis.tick_right()
    draw_sketch(middle, run.problem, run.result.equilibrium.position)
    track = run.problem.track
    inclination = f"rail inclination 1:{1.0 / track.rail_inclination:g}" if track.rail_inclination else "upright"
    middle.set_title(f"{run.problem.wheelset.wheel.title}\non {track.rail.title}, {inclination}{title}", fontsize=10)
    return figure, (left, right)


def wheelset_figure(run: WheelsetRun) -> Figure:
    """Draw the left side at the left, the right side at the right, and the sketch between them."""
    result, units = run.plane, run.case.units
    factor = deformation_factor(result)
    parts = {side: drawn_parts(result, side, factor) for side in SIDES}
    boxes = np.array([box([body.points for body in parts[side].values()], 6.0) for side in SIDES])
    half = np.ptp(boxes[:, :, 0], axis=1).max() / 2.0
    bottom, top = boxes[:, 0, 1].min(), boxes[:, 1, 1].max()
    windows = [np.array([[x - half, bottom], [x + half, top]]) for x in boxes[:, :, 0].mean(axis=1)]
    load, length = run.problem.load.vertical_N / 1e3, run.problem.thickness_mm
    words = f"\n{measured(load, 'kN', units)} on {measured(length, 'mm', units)} of length"
    figure, axes = sides_about_sketch(run, 7.0, windows, words)
    valid = {name: above_the_web(result.model, name) for side in SIDES for name in parts[side]}
    bodies = {name: body for side in SIDES for name, body in parts[side].items()}
    shade, extend = stress_shade(
        [body.stresses.von_mises[valid[name][body.shown.cells]] for name, body in bodies.items()]
    )
    for panel, side in zip(axes, SIDES, strict=True):
        at_touch = drawn_parts(result, side, 0.0)
        for name, body in parts[side].items():
            mesh = body.space.mesh
            body.draw(panel, body.stresses.von_mises, shade, valid[name], edges=False)
            points = body.place(mesh.points, body.field.displacements[: mesh.n_points])
            web = cells_path(mesh, points, np.flatnonzero(~valid[name]))
            panel.add_artist(PathPatch(web, facecolor="none", edgecolor=STEEL, hatch="////", lw=0.0))
            draw_lines(panel, at_touch[name].edges[mesh.edge_cells[:, 1] < 0], GREY, 0.9, ls=(0, (4, 2)))
    words = f"von Mises stress (hatched: not valid); deformation x{factor:g} since first touch (dashed)"
    colour_bar(shade, figure.axes[:3], words, "MPa", location="bottom", aspect=60, extend=extend)
    return figure


def deformation_factor(result: WheelsetResult) -> float:
    """Round factor by which the maximum displacement becomes a fortieth of a part or less; at least 1."""
    motion, size = 0.0, 0.0
    for side in SIDES:
        at_touch = drawn_parts(result, side, 0.0)
        for name, body in drawn_parts(result, side).items():
            motion = max(motion, float(np.abs(body.edges - at_touch[name].edges).max()))
            size = max(size, float(np.ptp(at_touch[name].edges.reshape(-1, 2), axis=0).max()))
    return round_factor(max(DEFORMATION_SHARE * size / motion, 1.0)) if motion > 0.0 else 1.0


RIM_WIDTH_MM = 140.0
AXLE_RADIUS_MM = 85.0
STEEL = "#c9ced6"
NOT_MODELLED: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "lw": 0.8, "ls": "--"}


def draw_sketch(axes: Axes, problem: WheelsetProblem, motion: WheelsetPosition) -> None:
    """Draw wheels, axle, rails, load and dimensions; what is not modelled is only outlined."""
    wheelset, track, units = problem.wheelset, problem.track, units_of(axes)
    axle = wheelset.tape_radius_mm
    inner, half_gauge = wheelset.back_to_back_mm / 2.0, track.gauge_mm / 2.0
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        left, radius = (inner if sign > 0 else -inner - RIM_WIDTH_MM), wheelset.radius_mm
        axes.add_patch(Rectangle((left, axle - radius), RIM_WIDTH_MM, 2 * radius, **NOT_MODELLED))
        for outline, placement in (
            (wheelset.wheel_of(side).outline, motion.placement(wheelset, side)),
            (track.rail_of(side).outline, track.placement(side)),
        ):
            points = placement.points(outline.sampled(max_deviation=0.2))
            axes.add_patch(Polygon(points, closed=True, facecolor=STEEL, edgecolor=INK, lw=0.7))
    axes.add_patch(Rectangle((-inner, axle - AXLE_RADIUS_MM), 2 * inner, 2 * AXLE_RADIUS_MM, **NOT_MODELLED))
    axes.plot([-inner - 200, inner + 200], [axle, axle], color=GREY, lw=0.6, ls="-.")
    _draw_load(axes, problem, axle)
    for x in (-half_gauge, half_gauge):
        axes.plot([x, x], [-300, -10], color=INK, lw=0.5)
    _dimension(axes, (-half_gauge, -275), (half_gauge, -275), f"gauge {measured(track.gauge_mm, 'mm', units)}")
    high = axle + 0.6 * wheelset.radius_mm
    _dimension(
        axes, (-inner, high), (inner, high), f"back to back {measured(wheelset.back_to_back_mm, 'mm', units)}", 0.75
    )
    beside, tread = inner - 110, inner + wheelset.wheel.flange_back_mm
    axes.plot([beside - 30, tread], [0.0, 0.0], color=INK, lw=0.5)
    _dimension(axes, (beside, axle), (beside, 0.0), f"radius {measured(axle, 'mm', units, '.5g')}")
    top = axle + wheelset.centre_of_gravity_height_mm
    axes.set(xlim=(-half_gauge - 160, half_gauge + 160), ylim=(-320, max(top + 340, axle + wheelset.radius_mm) + 20))
    axes.set_aspect("equal", anchor="S")
    axes.set_axis_off()


def _draw_load(axes: Axes, problem: WheelsetProblem, axle: float) -> None:
    wheelset, load, units = problem.wheelset, problem.load, units_of(axes)
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
            f"{measured(abs(along) / 1e3, 'kN', units)} lateral,\nin the track's plane",
            fontsize=8,
            ha="right" if along > 0.0 else "center",
            va="top",
        )
    axes.text(x + 45, y + 250, measured(load.in_track[1] / 1e3, "kN", units), fontsize=8, va="center")
    axes.text(x + 45, y, "centre of gravity\nof the car", fontsize=7, va="center")
    _dimension(
        axes,
        (x - 90, axle),
        (x - 90, y),
        f"{measured(wheelset.centre_of_gravity_height_mm, 'mm', units, '.5g')} above the axle",
    )


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
