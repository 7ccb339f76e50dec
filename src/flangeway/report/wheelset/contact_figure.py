"""Pictures of the contacts of a plane wheelset: stresses and forces on the deformed mesh, and pressures."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.post import Stresses
from flangeway.quantities import measured
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.report.figures.drawing import (
    HALO,
    HERTZ,
    INK,
    NODES,
    SERIES,
    box,
    colour_bar,
    equal_axes,
    name_axes,
    new_figure,
    panels,
    shade_of,
    units_of,
)
from flangeway.report.figures.fields import drawn_parts
from flangeway.report.page.tables import marked
from flangeway.types import Floats

WINDOW = 2.2  # in half widths of the contact
MAX_ARROWS = 25
ARROW = 0.9  # longest arrow, in half widths
PANEL_IN = 4.3

COLUMNS: tuple[tuple[str, Callable[[Stresses], Floats]], ...] = (
    ("von Mises stress", lambda stresses: stresses.von_mises),
    ("minimum principal stress", lambda stresses: stresses.principal[:, 2].clip(max=0.0)),
    ("maximum in-plane shear stress", lambda stresses: stresses.in_plane_shear),
)
"""What is shown, from left to right."""


def contact_figure(run: WheelsetRun, side: Side) -> Figure:
    """Draw each contact zone of a side in true shape and scale, in a row of its own, and the forces on the wheel.

    Both sides have the same colours. A side without contact is shown whole.
    """
    bodies = {each: drawn_parts(run.plane, each).values() for each in SIDES}
    patches = [patch for patch in run.plane.patches if patch.side == side]
    windows = [_window(patch) for patch in patches] or [box([body.points for body in bodies[side]], 6.0)]
    zones = [(_window(patch), body) for patch in run.plane.patches for body in bodies[patch.side]]
    shown = [(body, body.within(window)[body.shown.cells]) for window, body in zones]
    figure = new_figure(3.0 * PANEL_IN, 0.9 + (PANEL_IN - 0.2) * len(windows), run.case.units, compressed=True)
    rows = figure.subplots(len(windows), len(COLUMNS), squeeze=False)
    for column, (words, values) in zip(rows.T, COLUMNS, strict=True):
        inside = [values(body.stresses)[points] for body, points in shown]
        every = np.concatenate([np.zeros(1), *inside])
        shade = shade_of(every)
        for axes, window in zip(column, windows, strict=True):
            equal_axes(axes, window)
            for body in bodies[side]:
                body.draw(axes, values(body.stresses), shade, body.within(window))
        colour_bar(shade, list(column), words, "MPa", location="bottom", aspect=40)
    most = max((len(patch.pressure.normal_forces) for patch in run.plane.patches), default=1)
    stride = -(-most // MAX_ARROWS)
    for row, patch in zip(rows, patches, strict=False):
        _draw_forces(row[1], patch, stride)
        # one sentence over the row, set above its middle panel
        where = f", {patch.region}" if len(patches) > 1 else ""
        size, *parts = (
            measured(force / 1e3, "kN", run.case.units, form)
            for force, form in zip(
                (np.hypot(*patch.force_on_wheel_N), *patch.force_on_wheel_N), (".2f", "+.2f", "+.2f"), strict=True
            )
        )
        nodes = "" if stride == 1 else f", one node of {stride}"
        row[1].set_title(
            f"{side.capitalize()} contact{where}: {size} on the wheel ({parts[0]} lateral, {parts[1]} vertical); "
            f"arrows: nodal forces{nodes}",
            fontsize=10,
        )
    if not patches:
        rows[0, 1].set_title(f"the {side} wheel does not touch its rail", fontsize=10)
    return figure


def _window(patch: WheelRailPatch) -> Floats:
    return box([np.atleast_2d(patch.pressure.centre)], WINDOW * patch.pressure.half_width)


def _draw_forces(axes: Axes, patch: WheelRailPatch, stride: int) -> None:
    """Draw the nodal forces on the wheel, those on the secondary side or their reactions, and one for the scale."""
    sign = 1.0 if patch.force_on_wheel_N @ patch.pressure.force > 0.0 else -1.0
    points, forces = patch.pressure.points, sign * patch.pressure.forces / 1e3
    maximum = float(np.linalg.norm(forces, axis=1).max())
    (low, high), bottom = axes.get_xlim(), axes.get_ylim()[0]
    shown, place = float(f"{0.5 * maximum:.1g}"), np.array([low, bottom]) + 0.06 * (high - low)
    axes.quiver(
        *np.vstack((points[::stride], place)).T, *np.vstack((forces[::stride], [0.0, shown])).T,
        angles="xy", scale_units="xy", scale=maximum / (ARROW * patch.pressure.half_width), width=0.004,
        headwidth=3.5, headlength=4.5, facecolor="white", edgecolor=INK, linewidth=0.4, zorder=4,
    )  # fmt: skip
    text = measured(shown, "kN", units_of(axes), ".3g")
    axes.text(place[0] + 0.02 * (high - low), place[1], text, fontsize=9, va="bottom", path_effects=[HALO], zorder=5)


def pressure_figure(run: WheelsetRun) -> Figure:
    """Draw the nodes' pressures (Moherdaui 2021, Figure 63) where they act in the track, side by side."""
    figure, (both,) = panels(13.0, 5.0, 1, 2, run.case.units, sharey=True)
    for axes, side in zip(both, SIDES, strict=True):
        patches = [patch for patch in run.plane.patches if patch.side == side]
        for patch, colour in zip(patches, (INK, *SERIES), strict=False):
            _draw_patch(axes, patch, colour, patch.region if len(patches) > 1 else "nodes")
        outwards = "left: field side, right: gauge side" if side == "left" else "left: gauge side, right: field side"
        axes.set_title(f"{side} contact ({outwards})".capitalize(), fontsize=10)
        name_axes(axes, ("x in the track", "mm"))
        if axes.has_data():
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=1, fontsize=8, frameon=False)
    both[0].set_ylim(bottom=0.0)  # once both are drawn: the axis is shared
    name_axes(both[0], y=("contact pressure", "MPa"))
    return figure


def _draw_patch(axes: Axes, patch: WheelRailPatch, colour: str, name: str) -> None:
    pressure, hertz = patch.pressure, patch.hertz
    label = f"{name}: {_extremes(axes, float(pressure.pressures.max()), pressure.half_width, pressure.remark)}"
    axes.plot(pressure.points[:, 0], pressure.pressures, color=colour, label=label, **NODES)
    if hertz is None:
        return
    along, pressures = hertz.curve
    # lengths along the surface, which is normal to the force, as lengths across the track
    force = patch.force_on_wheel_N / np.linalg.norm(patch.force_on_wheel_N)
    label = f"Hertz, same force: {_extremes(axes, hertz.max_pressure, hertz.half_width)}"
    axes.plot(pressure.centre[0] + along * force[1], pressures, color=colour, alpha=0.6, label=label, **HERTZ)


def _extremes(axes: Axes, pressure: float, half_width: float, remark: str | None = None) -> str:
    units = units_of(axes)
    most, half = measured(pressure, "MPa", units, ".0f"), measured(half_width, "mm", units, ".2f")
    return f"maximum {marked(most, remark)}, half width {half}"
