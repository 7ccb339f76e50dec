"""Patches that roll with friction from above: stick and slip with tractions, slip velocity, frictional power."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import NO_CONTACT, SLIPS, STICKS, Rolling
from flangeway.quantities import measured
from flangeway.report.figures.drawing import COLOURS, INK, Style, colour_bar, framed, name_axes, new_figure, units_of
from flangeway.report.viewer import ShownField
from flangeway.types import Floats
from flangeway.units import Units

STICK, SLIP = "#d3e3f3", "#f2b482"
ARROWS = 14
"""Arrows along the longer side of a patch, about."""
PANEL_IN, MAX_HEIGHT_IN = 2.6, 3.6
"""Width of a panel, and the most of its height."""
MARGIN = 0.06
FIELDS = {
    "pressure_MPa": ("contact pressure", "MPa"),
    "traction_MPa": ("traction", "MPa"),
    "slip_velocity_m_s": ("slip velocity", "m/s"),
    "slip_mm": ("slip", "mm"),
    "flash_temperature_K": ("flash temperature", "K"),
    "frictional_power_W_mm2": ("frictional power density", "W/mm²"),
    "frictional_work_N_mm": ("frictional work density", "N/mm"),
}
"""Words and units of fields of cells by the names of their arrays, for the viewer."""
LENGTH = 1.7
"""Longest arrow over the distance of arrows."""


@dataclass(frozen=True, eq=False)
class ShownRolling:
    """One patch that rolls, drawn with a direction across to the right and z up.

    - `name`: of the patch.
    - `forces`: creep forces with tractions, slip and states of its cells.
    - `speed_m_s`: speed of rolling.
    - `origin`: length along the first body's surface that is drawn at zero.
    - `sign`: 1 where rising lengths run to the left, else -1, as `flangeway.report.spatial.patch_map.PatchMap`.
    """

    name: str
    forces: Rolling | SimplifiedRolling
    speed_m_s: float
    origin: float
    sign: float = 1.0

    @property
    def edges(self) -> tuple[Floats, Floats]:
        """Ends of the cells, to the right and up."""
        grid = self.forces.contact.grid
        return self.sign * (self.origin - grid.bounds), grid.strip_bounds

    @property
    def box(self) -> Floats:
        """Corners (2, 2) of the cells under pressure, with a margin."""
        both = zip(self.edges, self.forces.contact.box, strict=True)
        found = np.stack([np.sort(edges[[cells.start, cells.stop]]) for edges, cells in both], axis=1)
        return framed(found, MARGIN)

    @property
    def tractions(self) -> Floats:
        """Tractions on the second body to the right and up, shape (n_cells, n_strips, 2)."""
        return self.forces.tractions * (-self.sign, 1.0)


def cell_fields(forces: Rolling | SimplifiedRolling, speed_m_s: float) -> dict[str, Floats]:
    """Arrays on the cells (n_cells, n_strips[, 2]) by their names in files; vectors t, z are those of the second body.

    Of a shift they are slip and work in the place of velocity and power.
    """
    rolls = forces.motion.rolls
    scale = speed_m_s / abs(forces.motion.speed) if rolls else 1.0
    slip, power = ("slip_velocity_m_s", "frictional_power_W_mm2") if rolls else ("slip_mm", "frictional_work_N_mm")
    found = {
        "traction_MPa": forces.tractions,
        slip: scale * forces.slip_velocities,
        power: scale * forces.power_density,
    }
    if forces.flash_temperatures is not None:
        found["flash_temperature_K"] = forces.flash_temperatures
    return found | {"stick_slip_state": forces.states.astype(np.float64)}


def shown_fields(fields: Mapping[str, Floats]) -> tuple[list[ShownField], dict[str, Floats]]:
    """Fields of cells (n_cells, n_strips[, 3]) for the viewer, which shows vectors by their sizes, and their arrays."""
    known = {name: each for name, each in fields.items() if name in FIELDS}
    arrays = {name: np.linalg.norm(each, axis=2) if each.ndim > 2 else each for name, each in known.items()}
    return [ShownField(name, *FIELDS[name], "Contact", name, "value") for name in arrays], arrays


def rolling_figure(patches: Sequence[ShownRolling], units: Units = "metric") -> Figure:
    """Draw a row for each patch: where it sticks and slips with its tractions, slip velocity, frictional power."""
    boxes, count = [shown.box for shown in patches], max(len(patches), 1)
    width, heights = (np.array([np.ptp(box, axis=0)[axis] for box in boxes] or [1.0]) for axis in (0, 1))
    scale = min(PANEL_IN / float(width.max()), MAX_HEIGHT_IN / float(heights.max()))
    size = 3.0 * (scale * float(width.max()) + 1.0), scale * float(heights.sum()) + 0.55 * count + 0.7
    figure = new_figure(*size, units)
    rows = figure.subplots(count, 3, squeeze=False, height_ratios=heights.tolist())
    for row, shown, box in zip(rows, patches, boxes, strict=False):
        _draw_states(row[0], shown)
        arrays = cell_fields(shown.forces, shown.speed_m_s)
        drawn, found = shown_fields({name: arrays[name] for name in arrays if name.startswith(("slip", "frictional"))})
        for axes, field in zip(row[1:], drawn, strict=True):
            _draw_values(axes, shown, found[field.array], field.name, field.unit)
        ends = box[:, 0].mean() + np.array([-0.5, 0.5]) * float(width.max())
        for axes in row:
            axes.set(xlim=ends, ylim=box[:, 1])
            axes.set_aspect("equal", adjustable="box")
            name_axes(axes, ("to the right", "mm"))
            axes.locator_params(axis="x", nbins=4)
            axes.locator_params(axis="y", nbins=6)
        name_axes(row[0], y=("z ahead", "mm"))
    fills = {"sticks": STICK, "slips": SLIP}
    handles = [Patch(fc=fill, ec=INK, lw=0.5, label=name) for name, fill in fills.items()]
    figure.legend(handles=handles, loc="outside lower left", ncols=2, frameon=False, fontsize=9)
    return figure


def _draw_states(axes: Axes, shown: ShownRolling) -> None:
    """Areas of stick and slip, with arrows of the tractions on the second body."""
    states, edges = shown.forces.states, shown.edges
    drawn = np.ma.masked_equal(states, NO_CONTACT).T
    colours = ListedColormap([STICK, SLIP])
    axes.pcolormesh(*edges, drawn, cmap=colours, norm=Normalize(STICKS - 0.5, SLIPS + 0.5), rasterized=True)
    spacing = max(np.ptp(shown.box, axis=0)) / ARROWS
    chosen = []
    for ends, cells in zip(edges, shown.forces.contact.box, strict=True):
        step = max(round(spacing / abs(float(np.diff(ends).mean()))), 1)
        chosen.append(np.arange(cells.start, cells.stop)[(cells.stop - cells.start - 1) % step // 2 :: step])
    rows, strips = (each.ravel() for each in np.meshgrid(*chosen, indexing="ij"))
    rows, strips = rows[states[rows, strips] != NO_CONTACT], strips[states[rows, strips] != NO_CONTACT]
    x, z = ((ends[1:] + ends[:-1])[which] / 2.0 for ends, which in zip(edges, (rows, strips), strict=True))
    arrows, longest = shown.tractions[rows, strips], float(np.linalg.norm(shown.tractions, axis=2).max())
    if longest > 0.0:
        style: Style = {"angles": "xy", "scale_units": "xy", "pivot": "mid", "color": INK, "width": 0.007}
        axes.quiver(x, z, *arrows.T, scale=longest / (LENGTH * spacing), **style)
    slips = (states == SLIPS).sum() / max((states != NO_CONTACT).sum(), 1)
    most = measured(longest, "MPa", units_of(axes), ".0f")
    axes.set_title(f"{shown.name}: {100.0 * slips:.0f} % slips,\ntractions up to {most}", fontsize=9)


def _draw_values(axes: Axes, shown: ShownRolling, values: Floats, name: str, unit: str) -> None:
    drawn = np.where(shown.forces.states != NO_CONTACT, values, np.nan)
    scale = Normalize(0.0, max(float(np.nanmax(drawn)), np.finfo(float).tiny))
    mesh = axes.pcolormesh(*shown.edges, drawn.T, cmap=COLOURS, norm=scale, rasterized=True)
    colour_bar(mesh, axes, name, unit, aspect=18, pad=0.02)
