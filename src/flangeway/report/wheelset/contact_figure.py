"""Picture of the contact zones of one side: stresses on the deformed mesh and the forces of contact."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.post import Stresses
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.report.figures.drawing import (
    HALO,
    INK,
    SERIES,
    ColourSteps,
    Room,
    box,
    draw_outline,
    draw_title,
    equal_axes,
    figure_with_room,
    fill_cells,
)
from flangeway.report.figures.fields import PartFields
from flangeway.report.page.tables import marked
from flangeway.types import Floats

WINDOW = 2.2  # in half widths of the contact
MOST_ARROWS = 25
ARROW = 0.9  # longest arrow, in half widths
MESH_LINES = (1.0, 1.0, 1.0, 0.5)
PANEL_IN = 4.3
"""Of patches beside each other, dark enough to be read in grey."""
ROOM = Room(bottom=1.2, top=0.3, across=0.7, between=0.75)
BAR_IN = (0.45, 0.1)  # bottom and height of a bar of colours

COLUMNS: tuple[tuple[str, Callable[[Stresses], Floats]], ...] = (
    ("von Mises stress in MPa", lambda stresses: stresses.von_mises),
    ("minimum principal stress in MPa", lambda stresses: stresses.principal[:, 2].clip(max=0.0)),
    ("maximum in-plane shear stress in MPa", lambda stresses: stresses.in_plane_shear),
)
"""What is shown, from left to right."""


@dataclass(frozen=True, eq=False)
class _Zone:
    """Cells of one part inside of a window, shape (n_cells,), and their stresses."""

    part: PartFields
    inside: NDArray[np.bool_]
    stresses: Stresses


def contact_figure(run: WheelsetRun, parts: Sequence[PartFields], side: Side) -> Figure:
    """Draw each contact zone of a side in true shape and scale, in a row of its own, and the forces on the wheel.

    Both sides have the same colours. A side without contact is shown whole.
    """
    patches = [patch for patch in run.plane.patches if patch.side == side]
    windows = [_window([patch]) for patch in patches] or [box([p.points() for p in parts if p.side == side], 6.0)]
    zones = [_zones(parts, side, window) for window in windows]
    shown = [*zones, *(_zones(parts, patch.side, _window([patch])) for patch in run.plane.patches)]
    height = 1.1 + (PANEL_IN - 0.2) * len(windows)
    figure, rows = figure_with_room(3.0 * PANEL_IN, height, ROOM, len(windows), len(COLUMNS))
    for column, (label, values) in enumerate(COLUMNS):
        colours = ColourSteps(np.concatenate([values(zone.stresses) for row in shown for zone in row]), from_zero=True)
        for number, (window, row) in enumerate(zip(windows, zones, strict=True)):
            axes = rows[number, column]
            equal_axes(axes, window)
            for zone in row:
                _draw(axes, zone, values, colours)
            if column:
                axes.set_ylabel("")
        place = rows[0, column].get_position()
        below = figure.add_axes((place.x0, BAR_IN[0] / height, place.width, BAR_IN[1] / height))
        bar = figure.colorbar(colours.mappable(), cax=below, orientation="horizontal")
        bar.set_label(f"{label}, element averages", fontsize=9)
        bar.ax.tick_params(labelsize=8)
    stride = _stride(run.plane.patches)
    for row, patch in zip(rows, patches, strict=False):
        _draw_forces(row[1], patch, stride)
        # one sentence over the row, set above its middle panel
        draw_title(row[1], f"{_name(patch, patches)}: {_force_text(patch)}; arrows: nodal forces{_at_nodes(stride)}")
    if not patches:
        draw_title(rows[0, 1], f"the {side} wheel does not touch its rail")
    return figure


def _window(patches: Sequence[WheelRailPatch]) -> Floats:
    reach = WINDOW * max(patch.pressure.half_width for patch in patches)
    return box([np.atleast_2d(patch.pressure.centre) for patch in patches], reach)


def _zones(parts: Sequence[PartFields], side: Side, window: Floats) -> list[_Zone]:
    zones = []
    for part in parts:
        if part.side != side:
            continue
        points, mesh = part.points(), part.mesh
        # cells reach beyond the window by their size at most
        in_window = ((points >= window[0]) & (points <= window[1])).all(axis=1)
        inside = np.logical_or.reduceat(in_window[mesh.cell_points], mesh.cell_offsets[:-1])
        zones.append(_Zone(part, inside, Stresses(part.stresses.components[inside])))
    return zones


def _draw(axes: Axes, zone: _Zone, values: Callable[[Stresses], Floats], colours: ColourSteps) -> None:
    part, points = zone.part, zone.part.points()
    fill_cells(axes, part.mesh, points, values(part.stresses), colours, chosen=zone.inside, lines=MESH_LINES)
    draw_outline(axes, part.mesh, points)


def _stride(patches: Sequence[WheelRailPatch]) -> int:
    """Step from one node with an arrow to the next, so that arrows stay apart."""
    most = max((len(patch.pressure.normal_forces) for patch in patches), default=1)
    return -(-most // MOST_ARROWS)


def _draw_forces(axes: Axes, patch: WheelRailPatch, stride: int) -> None:
    points, forces = patch.pressure.points, _on_wheel(patch) / 1e3
    maximum = float(np.linalg.norm(forces, axis=1).max())
    scale = maximum / (ARROW * patch.pressure.half_width)
    _arrows(axes, points[::stride], forces[::stride], scale)
    shown = float(f"{0.5 * maximum:.1g}")
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
        angles="xy", scale_units="xy", scale=scale, width=0.004,
        headwidth=3.5, headlength=4.5, facecolor="white", edgecolor=INK, linewidth=0.4, zorder=4,
    )  # fmt: skip


def _name(patch: WheelRailPatch, patches: Sequence[WheelRailPatch]) -> str:
    where = f", {patch.region}" if len(patches) > 1 else ""
    return f"{patch.side} contact{where}".capitalize()


def _force_text(patch: WheelRailPatch) -> str:
    lateral, vertical = patch.force_on_wheel_N / 1e3
    return f"{np.hypot(lateral, vertical):.2f} kN on the wheel ({lateral:+.2f} kN lateral, {vertical:+.2f} kN vertical)"


def _at_nodes(stride: int) -> str:
    return "" if stride == 1 else f", one node of {stride}"


def _on_wheel(patch: WheelRailPatch) -> Floats:
    """Forces on the wheel: those on the secondary side, or their reactions."""
    sign = 1.0 if patch.force_on_wheel_N @ patch.pressure.force > 0.0 else -1.0
    return sign * patch.pressure.forces


def pressure_figure(run: WheelsetRun) -> Figure:
    """Draw the nodes' pressures (Moherdaui 2021, Figure 63) where they act in the track, side by side."""
    most = max((sum(patch.side == side for patch in run.plane.patches) for side in SIDES), default=1)
    room = Room(across=0.3, bottom=0.65 + 0.4 * max(most, 1))
    figure, ((*both,),) = figure_with_room(13.0, 4.2 + 0.4 * max(most, 1), room, n_columns=2, sharey=True)
    for axes, side in zip(both, SIDES, strict=True):
        mine = [patch for patch in run.plane.patches if patch.side == side]
        for patch, colour in zip(mine, (INK, *SERIES), strict=False):
            _draw_patch(axes, patch, colour, patch.region if len(mine) > 1 else "nodes")
        outwards = "left: field side, right: gauge side" if side == "left" else "left: gauge side, right: field side"
        draw_title(axes, f"{side} contact ({outwards})".capitalize())
        axes.set_xlabel("x in the track in mm")
        axes.grid(color="#dddddd", linewidth=0.6)
        if axes.has_data():
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=1, fontsize=8, frameon=False)
    both[0].set_ylim(bottom=0.0)  # once both are drawn: the axis is shared
    both[0].set_ylabel("contact pressure in MPa")
    return figure


def _draw_patch(axes: Axes, patch: WheelRailPatch, colour: str, name: str) -> None:
    pressure = patch.pressure
    axes.plot(
        pressure.points[:, 0], pressure.pressures, color=colour, lw=1.0, marker="o", ms=3.5, mfc="white",
        label=f"{name}: maximum {marked(f'{pressure.pressures.max():.0f} MPa', pressure.remark)}, half width "
        f"{pressure.half_width:.2f} mm",
    )  # fmt: skip
    if patch.hertz is None:
        return
    hertz = patch.hertz
    along = hertz.half_width * np.sin(np.linspace(-np.pi / 2.0, np.pi / 2.0, 181))
    # lengths along the surface, which is normal to the force, as lengths across the track
    force = patch.force_on_wheel_N / np.linalg.norm(patch.force_on_wheel_N)
    axes.plot(
        pressure.centre[0] + along * force[1], hertz.pressure(along), color=colour, lw=1.6, ls="--", alpha=0.6,
        label=f"Hertz, same force: maximum {hertz.max_pressure:.0f} MPa, half width {hertz.half_width:.2f} mm",
    )  # fmt: skip
