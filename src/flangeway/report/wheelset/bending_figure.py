"""Picture of the rails' bending: deformed sections and stresses along their free surface."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon

from flangeway.cases import CaseRun
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.bending import FaceStresses, RailBending, rail_bending
from flangeway.report.figures.drawing import (
    GREY,
    HALO,
    INK,
    Room,
    boundary_loops,
    box,
    draw_title,
    equal_axes,
    figure_with_room,
)
from flangeway.report.figures.fields import PartFields
from flangeway.report.wheelset.wheelset_figure import FACTORS

DEFORMATION_SHARE = 0.06  # maximum displacement in the figure over the height of the rail

ORDINATE_MM = 18.0  # length of the maximum stress: less than the radius of the fillets, so that ordinates do not cross

TENSION, COMPRESSION, STEEL = "#c77700", "#7fa8d1", "#e4e7eb"
MARGIN_MM = 8.0
ROOM = Room(bottom=0.9, top=0.55)
WEB_MM = 15.0  # height above and below the web's narrowest place that belongs to no fillet

LEAST_LABEL = 0.08  # minimum ratio of an extreme to the maximum stress for a label


def bending_figure(run: CaseRun, parts: list[PartFields]) -> Figure:
    """Draw both rails: undeformed with the stresses along the surface as ordinates, and dashed the deformed outline."""
    figure, panels = figure_with_room(13.0, 7.2, ROOM, n_columns=2)
    rails = [rail_bending(run.result, side) for side in SIDES]
    fields = {part.name: part for part in parts}
    maximum = max(float(np.abs(face.stresses_MPa).max(initial=0.0)) for rail in rails for face in rail.faces)
    scale = ORDINATE_MM / maximum if maximum > 0.0 else 0.0
    factor = _factor([fields[f"rail-{side}"] for side in SIDES])
    for axes, rail in zip(panels[0], rails, strict=True):
        part = fields[f"rail-{rail.side}"]
        points = part.mesh.points
        for loop in boundary_loops(part.mesh):
            axes.add_artist(Polygon(points[loop], closed=True, facecolor=STEEL, edgecolor=INK, lw=1.0, zorder=2))
            axes.plot(*part.points(factor)[loop].T, color=GREY, lw=1.1, ls=(0, (4, 2)), zorder=3)
        equal_axes(axes, box([points], MARGIN_MM))
        for face in rail.faces:
            _draw_face(axes, run, rail, face, scale, maximum)
        draw_title(axes, _title(rail))
    figure.legend(
        handles=[
            Patch(facecolor=TENSION, edgecolor=INK, hatch="////", label="tension"),
            Patch(facecolor=COMPRESSION, edgecolor=INK, label="compression along the free surface, MPa"),
            Patch(facecolor="none", edgecolor=GREY, ls="--", label=f"deformation x{factor}"),
        ],
        loc="lower center", ncols=3, fontsize=9, frameon=False,
    )  # fmt: skip
    return figure


def _factor(parts: list[PartFields]) -> int:
    maximum = max(float(np.abs(part.displacement).max()) for part in parts)
    height = min(float(np.ptp(part.mesh.points[:, 1])) for part in parts)
    return max((f for f in FACTORS if f * maximum <= DEFORMATION_SHARE * height), default=1)


def _draw_face(axes: Axes, run: CaseRun, rail: RailBending, face: FaceStresses, scale: float, maximum: float) -> None:
    """Draw the stresses of a face as ordinates out of the rail, and numbers at extremes and at the web."""
    placement = run.result.placements[f"rail-{rail.side}"]
    feet, outwards = placement.points(face.points_mm), placement.vectors(face.outwards)
    for sign, colour, hatch in ((1.0, TENSION, "////"), (-1.0, COMPRESSION, "")):
        heads = feet + outwards * (scale * np.clip(sign * face.stresses_MPa, 0.0, None))[:, None]
        axes.add_artist(
            Polygon(np.vstack((feet, heads[::-1])), closed=True, facecolor=colour, edgecolor=INK, lw=0.4, hatch=hatch)
        )
    shown = [*_fillet_extremes(face, rail.web_height_mm, LEAST_LABEL * maximum)]
    if np.isfinite(face.web_MPa):
        shown.append((int(np.argmin(np.abs(face.points_mm[:, 1] - rail.web_height_mm))), face.web_MPa))
    middle = float(placement.points([(0.0, rail.web_height_mm)])[0, 0])
    for place, value in shown:
        tip = feet[place] + outwards[place] * scale * abs(face.stresses_MPa[place])
        right = tip[0] > middle
        axes.annotate(
            f"{value:.0f}", tip, (4 if right else -4, 0), textcoords="offset points", fontsize=9, va="center",
            ha="left" if right else "right", path_effects=[HALO], zorder=6, gid="MPa",
        )  # fmt: skip


def _fillet_extremes(face: FaceStresses, web_height_mm: float, least: float) -> Iterator[tuple[int, float]]:
    """Edges and stresses of the peaks in the fillets, away from the web's narrowest place."""
    heights, stresses = face.points_mm[:, 1], face.stresses_MPa
    for side in (heights > web_height_mm + WEB_MM, heights < web_height_mm - WEB_MM):
        places = np.flatnonzero(side)
        for sign in (1.0, -1.0):
            if len(places) == 0:
                continue
            place = int(places[np.argmax(sign * stresses[places])])
            # at the limit it is no peak, but the web's slope
            if place not in (places[0], places[-1]) and sign * stresses[place] > least:
                yield place, float(stresses[place])


def _title(rail: RailBending) -> str:
    motion = rail.head_motion
    lateral_offset = "right" if motion.lateral_mm > 0.0 else "left"
    upright = "up" if motion.vertical_mm > 0.0 else "down"
    turn = "counter-clockwise" if motion.roll_rad > 0.0 else "clockwise"
    return (
        f"{rail.side} rail: top of the head moves {abs(motion.lateral_mm):.2f} mm to the {lateral_offset} and "
        f"{abs(motion.vertical_mm):.2f} mm {upright},\nand rolls {1e3 * abs(motion.roll_rad):.1f} mrad {turn}"
    ).capitalize()
