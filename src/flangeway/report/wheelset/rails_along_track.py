"""Rails along the track: picture, table and CSV file."""

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.rail_along_track import REGIONS, RailAlongTrack
from flangeway.report.figures.drawing import GREY, INK, SIDE_COLOURS, new_figure
from flangeway.report.page.tables import Column, SummaryTable, table_across
from flangeway.results import ResultTable
from flangeway.types import Floats

STYLES = {"left": "-", "right": "--"}  # of symmetric wheelsets both are one line


def _foot(rail: RailAlongTrack) -> Floats:
    """Normal stress along the track in the middle of the base, MPa, shape (n_z,)."""
    points = rail.stresses.points_mm
    foot = np.flatnonzero(rail.stresses.regions == "foot")
    lowest = foot[points[foot, 1] <= points[foot, 1].min() + 1e-6]
    middle = lowest[np.argmin(np.abs(points[lowest, 0] - points[lowest, 0].mean()))]
    found: Floats = rail.stresses.along_MPa[:, middle]
    return found


LINES: tuple[tuple[str, Callable[[RailAlongTrack], Floats]], ...] = (
    ("top of the rail down, mm", lambda rail: -rail.head[:, 1]),
    ("gauge face outwards, mm", lambda rail: rail.gauge_outward_mm),
    ("stress under the foot, MPa", _foot),
)
"""What is drawn along the track, one panel each."""


def rails_figure(run: WheelsetRun) -> Figure:
    """Draw deflection, gauge face and stress under the foot of both rails along the track, and sleepers with forces."""
    rails = run.space.rails
    figure = new_figure(9.0, 7.0)
    panels = figure.subplots(len(LINES), 1, sharex=True)
    for axes, (label, values) in zip(panels, LINES, strict=True):
        for side, rail in rails.items():
            axes.plot(
                rail.z_mm / 1e3, values(rail), color=SIDE_COLOURS[side], ls=STYLES[side], lw=1.5, label=f"{side} rail"
            )
        axes.axhline(0.0, color=GREY, lw=0.8)
        axes.set_ylabel(label)
        axes.grid(color="#dddddd", linewidth=0.6)
    panels[0].invert_yaxis()
    _draw_sleepers(panels[0], rails)
    panels[0].legend(loc="lower right", fontsize=8)
    panels[-1].set_xlabel("z ahead of the axle in m")
    return figure


def _draw_sleepers(axes: Axes, rails: dict[Side, RailAlongTrack]) -> None:
    """Mark the sleepers, each with the upward forces of both rail seats."""
    first = next(iter(rails.values()))
    reach = np.abs(first.z_mm).max()
    for number, z in enumerate(first.sleepers_mm):
        if abs(z) > reach:
            continue
        axes.axvline(z / 1e3, color=GREY, lw=0.6, ls=":")
        forces = " / ".join(f"{rail.reactions[number, 1] / 1e3:.0f}" for rail in rails.values())
        axes.annotate(
            forces, (z / 1e3, 1.02), xycoords=("data", "axes fraction"), ha="center", fontsize=7, color=INK, gid="kN"
        )
    if len(first.sleepers_mm):
        axes.set_title("forces of the sleepers on the left / right rail, kN", fontsize=9, pad=16, loc="left")


def rails_table(run: WheelsetRun) -> SummaryTable:
    """Return maxima of both rails, with the places of the stresses."""
    rails = run.space.rails
    quantities: list[Column] = [
        ("top of the rail down, mm", lambda rail: -rail.head[:, 1].min(), ".3f"),
        ("gauge-face deflection, mm", lambda rail: rail.gauge_outward_mm.max(), ".3f"),
    ]
    if len(next(iter(rails.values())).sleepers_mm):
        quantities.append(("maximum force of a sleeper, kN", lambda rail: rail.reactions[:, 1].max() / 1e3, ".2f"))
    for region in REGIONS:
        for name, kind in (("stress along the track", "along_MPa"), ("von Mises stress", "von_mises_MPa")):
            peaks = f"{region}: {name}{{, MPa|: x, mm|: y, mm|: z, mm}}"
            quantities.append((peaks, partial(_peak, region, kind), ".1f|.0f|.0f|.0f"))
    return table_across("Rails along the track: maximum values", rails, list(rails.values()), quantities)


def _peak(region: str, kind: str, rail: RailAlongTrack) -> tuple[float, ...]:
    value, place = rail.stresses.peak(region, getattr(rail.stresses, kind))
    return value, *place


def rails_csv(run: WheelsetRun) -> str:
    """Return both rails along the track as a CSV file, a row for each place."""
    names = "side,z_mm,base_x_mm,base_y_mm,base_roll_rad,head_x_mm,head_y_mm,head_roll_rad,gauge_outward_mm,foot_MPa"
    rows = []
    for side, rail in run.space.rails.items():
        table = np.column_stack((rail.z_mm, rail.base, rail.head, rail.gauge_outward_mm, _foot(rail)))
        rows += [(side, *row) for row in table.tolist()]
    return ResultTable(dict(zip(names.split(","), zip(*rows, strict=True), strict=True))).csv(6)
