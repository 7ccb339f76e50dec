"""Picture of the contact pressure along the surface, with Hertz's beside it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases import CaseRun
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.wheel_rail_patch import WheelRailPatch
from flangeway.report.figures.drawing import GREY, INK, Room, draw_title, figure_with_room
from flangeway.report.page.page_tables import marked


def pressure_figure(run: CaseRun) -> Figure:
    """Draw the nodes' pressures (Moherdaui 2021, Figure 63) against the length along the surface, side by side."""
    figure, ((*both,),) = figure_with_room(13.0, 4.6, Room(across=0.3), n_columns=2, sharey=True)
    for axes, side in zip(both, SIDES, strict=True):
        mine = [patch for patch in run.result.patches if patch.side == side]
        for patch, line in zip(mine, ("-", "-.", ":", "--"), strict=False):
            _draw_patch(axes, patch, line, patch.region if len(mine) > 1 else "nodes")
        outwards = "left: field side, right: gauge side" if side == "left" else "left: gauge side, right: field side"
        draw_title(axes, f"{side} contact ({outwards})".capitalize())
        axes.set_xlabel("length along the surface from the centre of pressure in mm")
        axes.grid(color="#dddddd", linewidth=0.6)
        if axes.has_data():
            axes.legend(loc="lower center", fontsize=8, framealpha=1.0)
    both[0].set_ylim(bottom=0.0)  # once both are drawn: the axis is shared
    both[0].set_ylabel("contact pressure in MPa")
    return figure


def _draw_patch(axes: Axes, patch: WheelRailPatch, line: str, name: str) -> None:
    pressure = patch.pressure
    along = np.copysign(1.0, pressure.points[-1, 0] - pressure.points[0, 0]) * pressure.along
    axes.plot(
        along, pressure.pressures, color=INK, lw=1.0, ls=line, marker="o", ms=3.5, mfc="white",
        label=f"{name}: largest {marked(f'{pressure.pressures.max():.0f} MPa', pressure.remark)}, half width "
        f"{pressure.half_width:.2f} mm",
    )  # fmt: skip
    if patch.hertz is None:
        return
    hertz = patch.hertz
    x = hertz.half_width * np.sin(np.linspace(-np.pi / 2.0, np.pi / 2.0, 181))
    axes.plot(
        x, hertz.pressure(x), color=GREY, lw=1.8, ls="--", zorder=1,
        label=f"Hertz, same force: largest {hertz.max_pressure:.0f} MPa, half width {hertz.half_width:.2f} mm",
    )  # fmt: skip
