"""An animation of a wheelset that moves through the rows of a campaign: both contacts, their pressures, L/V, forces."""

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from flangeway.campaign import Campaign, CampaignTable
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.report.campaign.campaign_figures import numeric_keys
from flangeway.report.figures.drawing import GREY, INK, SIDE_COLOURS, new_figure
from flangeway.report.page.tables import marked

NAME = "sweep.gif"
MOTION = ("lateral_mm", "vertical_mm", "roll_rad")
FEWEST_FRAMES = 5
MOST_FRAMES = 120
FRAMES_A_SECOND = 8
DPI = 80
WIDTH_MM, BELOW_MM, ABOVE_MM = 55.0, 22.0, 38.0
HIGHEST_MM = 18.0  # height at which the maximum pressure of all frames is drawn


@dataclass(frozen=True)
class SweepFrame:
    """One position of the animation."""

    label: str  # name of the frame
    problem: WheelsetProblem  # profiles and their positions
    motion: WheelsetPosition | None  # of the wheelset; None where there is no result
    patches: tuple[dict[str, Any], ...]
    """Regions of contact: ``side``, ``rail_x_mm``, ``rail_y_mm``, ``max_pressure_MPa``, ``half_width_mm``,
    ``lateral_force_N``, ``vertical_force_N``."""


def is_sweep(campaign: Campaign, table: CampaignTable) -> bool:
    """Whether exactly one input of a wheelset varies, a number, with enough values for an animation."""
    if not issubclass(campaign.case, WheelsetCase) or len(table.rows["row"]) < FEWEST_FRAMES:
        return False
    varying = [key for key in table.keys if len(set(table.rows[key])) > 1]
    return (
        len(varying) == 1
        and numeric_keys(table) == varying
        and set(MOTION) <= set(table.rows)
        and table.rows["status"].count("converged") >= FEWEST_FRAMES
    )


def sweep_frames(campaign: Campaign, table: CampaignTable) -> list[SweepFrame]:
    """Frames of a campaign along the one input that varies; of many rows some are left out evenly."""
    key = numeric_keys(table)[0]
    order = np.argsort(table.numbers(key), kind="stable")
    chosen = order[np.unique(np.linspace(0, len(order) - 1, min(len(order), MOST_FRAMES)).round().astype(int))]
    patches: dict[Any, list[dict[str, Any]]] = {}
    for place, row in enumerate(table.patches["row"]):
        patches.setdefault(row, []).append({name: values[place] for name, values in table.patches.items()})
    known: dict[str, WheelsetProblem] = {}
    frames = []
    for number in chosen:
        row = campaign.rows[number]
        if not isinstance(row.case, WheelsetCase):
            raise TypeError("a sweep is of a wheelset")
        if row.bodies not in known:
            known[row.bodies] = row.case.problem()
        motion = None
        if table.rows["status"][number] == "converged":
            motion = WheelsetPosition(
                *(table.numbers(name)[number] for name in ("lateral_mm", "vertical_mm", "roll_rad"))
            )
        label = f"{key} = {table.rows[key][number]:g}"
        frames.append(SweepFrame(label, known[row.bodies], motion, tuple(patches.get(row.number, ()))))
    return frames


def sweep_gif(frames: list[SweepFrame], title: str) -> bytes:
    """Draw an animation as the contents of a GIF file; at least one frame must have a result.

    Each frame shows both sides in the track's axes: the undeformed outlines of wheel and rail, and on the rail an
    ellipse with the maximum pressure and the width of each region of contact. Below are L/V and the vertical forces.
    """
    figure = new_figure(9.6, 6.4)
    grid = figure.add_gridspec(2, 2, height_ratios=(1.3, 1.0))
    sides = {side: figure.add_subplot(grid[0, column]) for column, side in enumerate(SIDES)}
    marks = [
        _draw_curves(figure.add_subplot(grid[1, column]), frames, kind)
        for column, kind in enumerate(("ratio", "vertical"))
    ]
    highest = max(patch["max_pressure_MPa"] for frame in frames for patch in frame.patches)
    figure.set_dpi(DPI)
    canvas: Any = FigureCanvasAgg(figure)  # its methods have no types
    pictures = []
    for number, frame in enumerate(frames):
        figure.suptitle(f"{title}: {frame.label}", fontsize=11)
        for side, axes in sides.items():
            _draw_side(axes, frame, side, highest)
        for mark in marks:
            mark.set_xdata([number, number])
        canvas.draw()
        if number == 0:
            figure.set_layout_engine("none")  # fixed panels
        pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE))
    buffer = io.BytesIO()
    pictures[0].save(buffer, "GIF", save_all=True, append_images=pictures[1:], duration=1000 // FRAMES_A_SECOND, loop=0)
    return buffer.getvalue()


def _draw_side(axes: Axes, frame: SweepFrame, side: Side, highest: float) -> None:
    axes.clear()
    problem = frame.problem
    on_rail = problem.track.placement(side)
    rail = on_rail.points(problem.track.rail_of(side).outline.sampled(max_deviation=0.1))
    axes.fill(rail[:, 0], rail[:, 1], facecolor="#dfe3e8", edgecolor=INK, lw=1.0)
    if frame.motion is None:
        axes.text(0.5, 0.9, "no result", transform=axes.transAxes, ha="center", color="#a00000")
    else:
        place = frame.motion.placement(problem.wheelset, side)
        wheel = place.points(problem.wheelset.wheel_of(side).outline.sampled(max_deviation=0.1))
        axes.fill(wheel[:, 0], wheel[:, 1], facecolor="#eef0f3", edgecolor=INK, lw=1.0, alpha=0.8)
    shown = []
    for patch in frame.patches:
        if patch["side"] == side:
            _draw_patch(axes, frame, side, patch, highest)
            shown.append(marked(f"{patch['max_pressure_MPa']:.0f} MPa", patch["max_pressure_remark"]))
    middle = float(on_rail.points(np.array([[0.0, 0.0]]))[0, 0])
    axes.set(xlim=(middle - WIDTH_MM, middle + WIDTH_MM), ylim=(-BELOW_MM, ABOVE_MM))
    axes.set_aspect("equal", adjustable="box")
    axes.set_title(f"{side}: {', '.join(shown) or 'no contact'}", fontsize=9)
    axes.set_xlabel("x in the track's axes, mm")


def _draw_patch(axes: Axes, frame: SweepFrame, side: Side, patch: dict[str, Any], highest: float) -> None:
    """Draw a region of contact as an ellipse of pressure along the force on the wheel."""
    point = frame.problem.track.placement(side).points(np.array([[patch["rail_x_mm"], patch["rail_y_mm"]]]))[0]
    force = np.array([patch["lateral_force_N"], patch["vertical_force_N"]])
    normal = force / np.linalg.norm(force)
    along = np.array([normal[1], -normal[0]])
    across = np.linspace(-1.0, 1.0, 41)
    height = HIGHEST_MM * patch["max_pressure_MPa"] / highest * np.sqrt(1.0 - across**2)
    curve = point + np.outer(patch["half_width_mm"] * across, along) + np.outer(height, normal)
    axes.fill(curve[:, 0], curve[:, 1], color=SIDE_COLOURS[side], alpha=0.75, lw=0, zorder=4)
    axes.plot(*point, "o", color="#a00000", ms=3, zorder=5)


def _draw_curves(axes: Axes, frames: list[SweepFrame], kind: str) -> Any:
    """Draw L/V or vertical forces of all frames; return the line that marks one."""
    for side in SIDES:
        forces = [_force(frame, side) for frame in frames]
        if kind == "ratio":
            sign = 1.0 if side == "left" else -1.0
            values = [sign * x / y if y > 0.0 else np.nan for x, y in forces]
        else:
            values = [y / 1e3 if y > 0.0 else np.nan for _, y in forces]
        axes.plot(values, color=SIDE_COLOURS[side], lw=1.4, label=side)
    places = np.unique(np.linspace(0, len(frames) - 1, 5).round().astype(int))
    axes.set_xticks(places, [frames[place].label.partition(" = ")[2] for place in places])
    axes.set(
        xlabel=frames[0].label.partition(" = ")[0],
        ylabel="L/V" if kind == "ratio" else "vertical force on the wheel, kN",
    )
    axes.grid(color="#dddddd", lw=0.5)
    axes.legend(frameon=False, fontsize=8)
    return axes.axvline(0.0, color=GREY, lw=1.0)


def _force(frame: SweepFrame, side: Side) -> tuple[float, float]:
    mine = [patch for patch in frame.patches if patch["side"] == side]
    return sum(patch["lateral_force_N"] for patch in mine), sum(patch["vertical_force_N"] for patch in mine)
