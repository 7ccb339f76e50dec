"""Picture of the contact zones: minimum principal stress and the forces of contact."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flangeway.railway.result import WheelRailPatch
from flangeway.railway.track import SIDES
from flangeway.report.drawing import (
    HALO,
    INK,
    StressColours,
    box,
    draw_cells,
    draw_contours,
    draw_outline,
    equal_axes,
    new_figure,
)
from flangeway.report.fields import PartFields
from flangeway.study import CaseRun

Floats = NDArray[np.float64]

WINDOW = 2.6  # in half widths of the contact
MOST_ARROWS = 30
ARROW = 0.9  # longest arrow, in half widths


def contact_figure(run: CaseRun, parts: list[PartFields]) -> Figure:
    """Draw both contact zones in true shape and scale, forces on the wheels as arrows."""
    figure = new_figure(13.0, 7.6)
    both = figure.subplots(1, 2)
    colours = StressColours(np.concatenate([part.stresses.principal[:, 2] for part in parts]).clip(max=0.0))
    for axes, side in zip(both, SIDES, strict=True):
        patches = [patch for patch in run.result.patches if patch.side == side]
        mine = [part for part in parts if part.side == side]
        _draw_zone(axes, mine, patches, colours)
        if patches:
            _draw_forces(axes, patches, _stride(run.result.patches))
        axes.set_title(f"{side} contact: ".capitalize() + _force_text(patches), fontsize=10)
    bar = figure.colorbar(colours.mappable(), ax=list(both), location="bottom", aspect=60, shrink=0.85)
    stride = _stride(run.result.patches)
    nodes = "each node" if stride == 1 else f"one node of {stride}"
    bar.set_label(
        "minimum principal stress in MPa, means of cells, compression negative; true shape; "
        f"arrows: contact forces on the wheel at {nodes}"
    )
    return figure


def _draw_zone(axes: Axes, parts: list[PartFields], patches: list[WheelRailPatch], colours: StressColours) -> None:
    if not patches:
        equal_axes(axes, box([part.points() for part in parts], 6.0))
    else:
        reach = WINDOW * max(patch.pressure.half_width for patch in patches)
        equal_axes(axes, box([patch.pressure.centre for patch in patches], reach))
    for part in parts:
        points, values = part.points(), part.stresses.principal[:, 2]
        draw_cells(axes, part, points, values, colours)
        draw_contours(axes, part, points, values, colours)
        draw_outline(axes, part.mesh, points)


def _stride(patches: Sequence[WheelRailPatch]) -> int:
    """Step from one node with an arrow to the next, so that arrows stay apart."""
    most = max((len(patch.pressure.normal_forces) for patch in patches), default=1)
    return -(-most // MOST_ARROWS)


def _draw_forces(axes: Axes, patches: list[WheelRailPatch], stride: int) -> None:
    points = np.vstack([patch.pressure.points for patch in patches])
    forces = np.vstack([_on_wheel(patch) for patch in patches]) / 1e3
    largest = float(np.linalg.norm(forces, axis=1).max())
    scale = largest / (ARROW * max(patch.pressure.half_width for patch in patches))
    _arrows(axes, points[::stride], forces[::stride], scale)
    shown = float(f"{0.5 * largest:.1g}")
    (low, high), bottom = axes.get_xlim(), axes.get_ylim()[0]
    place = np.array([[low + 0.06 * (high - low), bottom + 0.06 * (high - low)]])
    _arrows(axes, place, np.array([[0.0, shown]]), scale)
    axes.text(
        place[0, 0] + 0.02 * (high - low), place[0, 1], f"{shown:g} kN", fontsize=9,
        va="bottom", path_effects=[HALO], zorder=5,
    )  # fmt: skip


def _arrows(axes: Axes, points: Floats, forces: Floats, scale: float) -> None:
    """Draw forces in kN as arrows of length force / scale in mm."""
    axes.quiver(
        points[:, 0], points[:, 1], forces[:, 0], forces[:, 1],
        angles="xy", scale_units="xy", scale=scale, width=0.0028,
        headwidth=3.5, headlength=4.5, facecolor="white", edgecolor=INK, linewidth=0.35, zorder=4,
    )  # fmt: skip


def _force_text(patches: list[WheelRailPatch]) -> str:
    if not patches:
        return "none"
    force = np.sum([patch.force_on_wheel_N for patch in patches], axis=0) / 1e3
    return f"{np.hypot(*force):.2f} kN on the wheel ({force[0]:+.2f} lateral, {force[1]:+.2f} vertical)"


def _on_wheel(patch: WheelRailPatch) -> Floats:
    """Forces on the wheel: those on the secondary side, or their reactions."""
    sign = 1.0 if patch.force_on_wheel_N @ patch.pressure.force > 0.0 else -1.0
    return sign * patch.pressure.forces
