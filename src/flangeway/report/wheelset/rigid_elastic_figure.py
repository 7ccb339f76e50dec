"""Picture of the elastic wheelset over the rigid one: outlines, contact points, forces (Moherdaui 2021, Figure 101)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from flangeway.cases import CaseRun
from flangeway.cases.wheelset.wheelset_summary import ContactSummary, RigidContactSummary
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.report.figures.drawing import Room, alike, boundary_loops, draw_title, equal_axes, figure_with_room
from flangeway.report.figures.fields import PartFields
from flangeway.types import Floats

RIGID, ELASTIC, STEEL = "#c05800", "#0b3d78", "#dfe5ec"
LEAST_WINDOW_MM = 7.0
AROUND_MM = 4.0  # what is shown beyond the points of contact

ARROW = 0.32  # length of the longest arrow over the height of the picture

ROOM = Room(bottom=0.85, top=0.65, between=0.8)
OVERVIEW_MM = np.array([[-62.0, -62.0], [62.0, 56.0]])  # about the middle of the points of contact


@dataclass(frozen=True, eq=False)
class _Forces:
    """Points of contact of a side in the track's axes and forces on the wheel in kN, both (n, 2)."""

    points: Floats
    forces: Floats

    @classmethod
    def of(cls, rows: Sequence[ContactSummary] | Sequence[RigidContactSummary], side: Side) -> "_Forces":
        mine = sorted((row for row in rows if row.side == side), key=lambda row: row.space_position_mm[0])
        points = np.array([row.space_position_mm for row in mine], dtype=np.float64).reshape(-1, 2)
        forces = [(row.lateral_force_kN or 0.0, row.vertical_force_kN or 0.0) for row in mine]
        return cls(points, np.array(forces, dtype=np.float64).reshape(-1, 2))


def rigid_elastic_figure(run: CaseRun, parts: Sequence[PartFields]) -> Figure:
    """Draw both sides in true shape, the rigid outlines dashed, and below them the zones of contact enlarged."""
    figure, rows = figure_with_room(12.0, 11.0, ROOM, 2, 2)
    forces = [row.force_kN for row in run.summary.contacts]
    maximum = max((*forces, *(row.force_kN or 0.0 for row in run.summary.rigid.contacts)), default=0.0)
    found = [
        tuple(_Forces.of(rows, side) for rows in (run.summary.contacts, run.summary.rigid.contacts)) for side in SIDES
    ]
    shown = [np.vstack((elastic.points, rigid.points)) for elastic, rigid in found]
    shown = [points if len(points) else _top_of_rail(run, side) for points, side in zip(shown, SIDES, strict=True)]
    middles = [(points.min(axis=0) + points.max(axis=0)) / 2.0 for points in shown]
    reach = max(LEAST_WINDOW_MM, *(float(np.ptp(points, axis=0).max()) / 2.0 + AROUND_MM for points in shown))
    for column, (side, (elastic, rigid)) in enumerate(zip(SIDES, found, strict=True)):
        outlines = _rigid_outlines(run, side)
        mine = [part for part in parts if part.side == side]
        for axes, window in ((rows[0, column], OVERVIEW_MM), (rows[1, column], np.array([[-reach] * 2, [reach] * 2]))):
            equal_axes(axes, alike([middle + window for middle in middles])[column])
            _draw_bodies(axes, mine, outlines)
            length = ARROW * float(np.ptp(window[:, 1]))
            _draw_forces(axes, rigid, RIGID, length, maximum, marker="D")
            _draw_forces(axes, elastic, ELASTIC, length, maximum, marker="o")
        draw_title(rows[0, column], _title(side, elastic, rigid))
        draw_title(rows[1, column], f"{side} zone of contact, enlarged".capitalize())
    figure.legend(handles=_legend(), loc="lower center", ncols=4, fontsize=9, frameon=False)
    return figure


def _top_of_rail(run: CaseRun, side: Side) -> Floats:
    """Highest point of a rail, shape (1, 2): what is shown of a side without contact."""
    rail = _rigid_outlines(run, side)[1]
    return rail[np.argmax(rail[:, 1])][None]


def _rigid_outlines(run: CaseRun, side: Side) -> list[Floats]:
    """Wheel at the rigid position and undeformed rail, points (n, 2) in the track's axes."""
    problem, rigid = run.result.model.problem, run.summary.rigid
    motion = WheelsetPosition(rigid.lateral_mm, rigid.vertical_mm, rigid.roll_rad)
    bodies = (
        (problem.wheelset.wheel_of(side).outline, motion.placement(problem.wheelset, side)),
        (problem.track.rail_of(side).outline, problem.track.placement(side)),
    )
    return [placement.points(outline.sampled(max_deviation=0.002, spacing=2.0)) for outline, placement in bodies]


def _draw_bodies(axes: Axes, parts: Sequence[PartFields], outlines: list[Floats]) -> None:
    for part in parts:
        points = part.points()
        for loop in boundary_loops(part.mesh):
            axes.add_artist(Polygon(points[loop], closed=True, facecolor=STEEL, edgecolor=ELASTIC, lw=1.1, alpha=0.85))
    for outline in outlines:
        axes.add_artist(Polygon(outline, closed=True, facecolor="none", edgecolor=RIGID, lw=1.1, ls=(0, (5, 2.5))))


def _draw_forces(axes: Axes, forces: _Forces, colour: str, length: float, maximum: float, marker: str) -> None:
    """Draw points of contact, and forces on the wheel as arrows, the maximum of both computations `length` long."""
    for point, force in zip(forces.points, forces.forces, strict=True):
        if force.any():
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", point + force * (length / maximum), point, arrowprops=arrow, zorder=5)
        axes.plot(*point, marker=marker, ms=6, mfc="white", mec=colour, mew=1.4, zorder=6)


def _title(side: Side, elastic: _Forces, rigid: _Forces) -> str:
    lines = [f"{side} side, forces on the wheel".capitalize()]
    for name, found in (("elastic", elastic), ("rigid", rigid)):
        texts = [
            f"{np.hypot(*force):.2f} kN at {np.degrees(np.arctan2(abs(force[0]), force[1])):.2f}°"
            for force in found.forces
            if force.any()
        ]
        lines.append(f"{name}: {' and '.join(texts)} from the track's normal" if texts else f"{name}: no force")
    return "\n".join(lines)


def _legend() -> list[Patch | Line2D]:
    return [
        Patch(facecolor=STEEL, edgecolor=ELASTIC, label="elastic equilibrium, deformed"),
        Line2D([], [], color=RIGID, ls=(0, (5, 2.5)), label="rigid equilibrium"),
        Line2D([], [], ls="none", marker="o", mfc="white", mec=ELASTIC, label="elastic: centre of pressure, force"),
        Line2D([], [], ls="none", marker="D", mfc="white", mec=RIGID, label="rigid: point of contact, force"),
    ]
