"""Sketch of the whole wheelset on its track, to scale, with its dimensions."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from flangeway.railway.track.placements import SIDES, WheelsetPosition
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.drawing import GREY, INK

RIM_WIDTH_MM = 140.0
AXLE_RADIUS_MM = 85.0
STEEL = "#c9ced6"


def draw_sketch(axes: Axes, result: WheelsetResult) -> None:
    """Draw wheels, axle, rails, load and dimensions; what is not modelled is only outlined."""
    problem = result.model.problem
    wheelset, track = problem.wheelset, problem.track
    motion = result.equilibrium.position
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
    _draw_load(axes, result, axle)
    for x in (-half_gauge, half_gauge):
        axes.plot([x, x], [-300, -10], color=INK, lw=0.5)
    _dimension(axes, (-half_gauge, -275), (half_gauge, -275), f"gauge {track.gauge_mm:g}")
    high = axle + 0.6 * wheelset.radius_mm
    _dimension(axes, (-inner, high), (inner, high), f"back to back {wheelset.back_to_back_mm:g}", 0.75)
    beside, tip = inner - 110, axle - wheelset.radius_mm
    axes.plot([beside - 30, inner], [tip, tip], color=INK, lw=0.5)
    _dimension(axes, (beside, axle), (beside, tip), f"radius {wheelset.radius_mm:g}")
    top = axle + wheelset.centre_of_gravity_height_mm
    axes.set_xlim(-half_gauge - 160, half_gauge + 160)
    axes.set_ylim(-320, max(top + 340, axle + wheelset.radius_mm) + 20)
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


def _draw_load(axes: Axes, result: WheelsetResult, axle: float) -> None:
    problem = result.model.problem
    wheelset, load = problem.wheelset, problem.load
    x, y = WheelsetPosition().centre_of_gravity(wheelset)
    axes.plot([x], [y], marker="o", color=INK, ms=4)
    axes.annotate("", (x, y), (x, y + 330), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4})
    along = load.in_track[0]
    if along:
        start = x - 330 if along > 0.0 else x + 330
        axes.annotate("", (x, y), (start, y), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4})
        axes.text(
            start,
            y - 60,
            f"{abs(along) / 1e3:.4g} kN lateral,\nin the track's plane",
            fontsize=8,
            ha="center",
            va="top",
        )
    axes.text(x + 45, y + 250, f"{load.in_track[1] / 1e3:.4g} kN", fontsize=8, va="center")
    axes.text(x + 45, y, "centre of gravity of the car", fontsize=7, va="center")
    _dimension(axes, (x - 90, axle), (x - 90, y), f"{wheelset.centre_of_gravity_height_mm:g} above the axle")


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
