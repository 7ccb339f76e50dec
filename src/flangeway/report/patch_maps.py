"""Pictures of contact patches: pressures and stresses, stick and slip, and the shakedown diagram."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Patch

from flangeway.contact.patch.patch_contact import CellForces, SpatialPatch
from flangeway.contact.patch.patch_grid import pairs_of
from flangeway.contact.rolling.fast_theories import SimplifiedRolling
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, STICKS, Rolling
from flangeway.exact.shakedown import shakedown_limits
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import DepthProfile
from flangeway.quantities import measured
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    INK,
    LIGHT,
    PURPLE,
    Style,
    colour_bar,
    framed,
    legend_below,
    name_axes,
    new_figure,
    panels,
    units_of,
)
from flangeway.report.viewer import ShownField
from flangeway.types import Bools, Floats, Ints
from flangeway.units import Units

# --- Patches on the cells of a surface: pressures from above, along both axes, stresses below; the surface as a mesh.


CURVES = (
    ("across, x", "#0b5394", "-"), ("normal, y", INK, "-"), ("along, z", "#9a6a00", "-"),
    ("von Mises", PURPLE, "--"), ("Tresca", "#2e7d32", "-."),
)  # fmt: skip
MIN_RATIO = 0.6
"""Width of what is shown of a surface from above relative to its height, at least."""
MAX_WIDTH_IN, MAX_HEIGHT_IN, MIN_WIDTH_IN, MIN_HEIGHT_IN = 9.0, 6.0, 5.0, 3.0
"""Size of the picture of surfaces from above: without labels at most, with them at least."""
MARGIN = 0.08
"""About what is under pressure, relative to its longer side."""


@dataclass(frozen=True, eq=False)
class PatchMap:
    """Pressures on cells, to be drawn with lengths along the surface to the right and z up.

    - `cells`: forces on the cells.
    - `patches`: on these cells.
    - `origin`: length along the surface that is drawn at zero.
    - `sign`: 1 where rising lengths along the surface run to the left, else -1.
    """

    cells: CellForces
    patches: Sequence[SpatialPatch]
    origin: float
    sign: float = 1.0

    def across(self, stations: Floats) -> Floats:
        """Places to the right of lengths along the surface."""
        return self.sign * (self.origin - stations)

    def centre(self, patch: SpatialPatch) -> Floats:
        """Centre of pressure of a patch as it is drawn, shape (2,)."""
        return np.array([self.across(np.array(patch.station)), patch.centre[2]])

    def tilt(self, patch: SpatialPatch) -> float:
        """Angle in radians from the right to the longer semi-axis as it is drawn."""
        # in a patch from z towards rising lengths, which run to the left
        return np.pi / 2.0 + self.sign * patch.angle_rad

    @property
    def box(self) -> Floats:
        """Corners (2, 2) of what is under pressure, with a margin; of all cells without pressure."""
        cells, loaded = self.cells, self.cells.forces > 0.0
        rows, strips = (np.flatnonzero(loaded.any(axis=1 - axis)) if loaded.any() else [0, -1] for axis in (0, 1))
        ends = np.sort(self.across(cells.grid.cells[[rows[0], rows[-1]], [0, 1]]))
        ahead = pairs_of(cells.grid.strip_bounds)[[strips[0], strips[-1]], [0, 1]]
        return framed(np.column_stack((ends, ahead)), MARGIN)

    @property
    def cells_drawn(self) -> "DrawnCells":
        """The cells under pressure as they are drawn."""
        grid = self.cells.grid
        return DrawnCells.between(self.across(grid.bounds), grid.strip_bounds, self.cells.forces > 0.0)


def draw_pressures(axes: Axes, shown: PatchMap, highest: float) -> ScalarMappable:
    """Draw pressures from above, outlines of the patches, and Hertz's ellipses; return the colours, from 0 MPa."""
    drawn, scale = shown.cells_drawn, Normalize(0.0, highest)
    _fill(axes, drawn, shown.cells.pressures, COLOURS, scale)
    axes.add_collection(LineCollection(list(drawn.outline), colors=INK, linewidths=1.0, capstyle="projecting"))
    for patch in shown.patches:
        if (hertz := patch.hertz) is not None:
            first = not axes.get_legend_handles_labels()[0]
            width, height = (2.0 * axis for axis in hertz.semi_axes)
            style: Style = {"fill": False, "ec": GREY, "ls": "--", "lw": 1.2, "label": "Hertz" if first else ""}
            middle, angle = tuple(shown.centre(patch).tolist()), float(np.rad2deg(shown.tilt(patch)))
            axes.add_patch(Ellipse(middle, width, height, angle=angle, **style))
    axes.set_aspect("equal", adjustable="box")
    return ScalarMappable(scale, COLOURS)


def maps_figure(
    maps: Sequence[PatchMap], across: str, along: str, units: Units = "metric"
) -> tuple[Figure, Sequence[Axes]]:
    """Draw the pressures of surfaces from above, beside each other in one scale, with outlines and Hertz's ellipses.

    - `across`, `along`: words for both axes.
    """
    boxes = [shown.box for shown in maps]
    ahead = np.array([box[:, 1] for box in boxes])
    least = MIN_RATIO * float(np.ptp(ahead))
    for box in boxes:
        box[:, 0] += np.array([-0.5, 0.5]) * max(least - float(np.ptp(box[:, 0])), 0.0)
    ends, widths = (ahead[:, 0].min(), ahead[:, 1].max()), [float(np.ptp(box[:, 0])) for box in boxes]
    scale = min(MAX_WIDTH_IN / sum(widths), MAX_HEIGHT_IN / (ends[1] - ends[0]))
    size = max(scale * sum(widths) + 1.0, MIN_WIDTH_IN), max(scale * (ends[1] - ends[0]) + 1.9, MIN_HEIGHT_IN)
    figure = new_figure(*size, units)
    both = figure.subplots(1, len(maps), sharey=True, squeeze=False, width_ratios=widths)[0]
    highest = max(float(shown.cells.pressures.max()) for shown in maps)
    for axes, shown, box in zip(both, maps, boxes, strict=True):
        drawn = draw_pressures(axes, shown, max(highest, 1.0))
        axes.set(xlim=box[:, 0], ylim=ends)
        axes.locator_params(axis="x", nbins=5)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="lower right", fontsize=8)
        name_axes(axes, (across, "mm"))
    name_axes(both[0], y=(along, "mm"))
    colour_bar(drawn, list(both), "contact pressure", "MPa", location="top", aspect=45)
    return figure, both


def draw_depths(axes: Axes, profile: DepthProfile) -> None:
    """Draw the stresses below a patch over the depth."""
    stresses = profile.stresses
    xx, yy, zz = stresses.components[:, :3].T
    curves = (xx, yy, zz, stresses.von_mises, stresses.tresca)
    for (label, colour, style), values in zip(CURVES, curves, strict=True):
        axes.plot(values, profile.depths, color=colour, ls=style, lw=1.3, label=label)
    axes.axvline(0.0, color=GREY, lw=0.8)
    axes.set_ylim(float(profile.depths[-1]), 0.0)
    axes.grid(color=LIGHT, linewidth=0.6)
    name_axes(axes, ("stress", "MPa"), ("depth", "mm"))


@dataclass(frozen=True, eq=False)
class DrawnCells:
    """Cells of a patch as polygons: what the live page, pictures and the viewer draw, and files hold.

    - `points`: corners of all cells, shape (n_points, 2).
    - `corners`: numbers of the points of the chosen cells, by rows and strips, shape (n_chosen, 4).
    - `chosen`: which of the cells these are, shape (n_cells, n_strips).
    """

    points: Floats
    corners: Ints
    chosen: Bools

    @classmethod
    def between(cls, across: Floats, ahead: Floats, chosen: Bools) -> "DrawnCells":
        """Cells between neighbouring ends (n_cells + 1,) across and (n_strips + 1,) ahead, which may be uneven."""
        points = np.stack(np.meshgrid(across, ahead, indexing="ij"), axis=-1).reshape(-1, 2)
        # point (i, j) has the number i * (n_strips + 1) + j
        first = np.arange(len(across) - 1)[:, None] * len(ahead) + np.arange(len(ahead) - 1)
        last = first + len(ahead)
        return cls(points, np.stack((first, last, last + 1, first + 1), axis=-1)[chosen], chosen)

    @property
    def polygons(self) -> Floats:
        """Corners of the chosen cells, shape (n_chosen, 4, 2)."""
        return self.points[self.corners]

    @property
    def outline(self) -> Floats:
        """Sides of chosen cells that border on no other one, shape (n_sides, 2, 2)."""
        sides = np.stack((self.corners, np.roll(self.corners, -1, axis=1)), axis=-1).reshape(-1, 2)
        unique, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
        return self.points[unique[count == 1]]


def _fill(axes: Axes, drawn: DrawnCells, values: Floats, colours: Any, scale: Normalize) -> ScalarMappable:
    """Fill cells by their values (n_cells, n_strips)."""
    style: Style = {"cmap": colours, "norm": scale, "antialiaseds": False, "linewidths": 0.0, "rasterized": True}
    filled = PolyCollection(list(drawn.polygons), array=values[drawn.chosen], **style)
    axes.add_collection(filled)
    return filled


def strip_mesh(nodes: Floats, z: Floats) -> PolyMesh:
    """Mesh of k times m points (length, z), with cells between neighbours."""
    drawn = DrawnCells.between(nodes, z, np.ones((len(nodes) - 1, len(z) - 1), dtype=np.bool_))
    return PolyMesh.from_cells(drawn.points, drawn.corners)


def at_corners(cells: Mapping[str, Floats]) -> dict[str, Floats]:
    """Arrays of a mesh of quadrilaterals at the corners of its cells, from those of the cells (n, n_z, ...)."""
    return {name: np.repeat(values.reshape(-1, *values.shape[2:]), 4, axis=0) for name, values in cells.items()}


# --- Patches that roll with friction from above: stick and slip with tractions, slip velocity, frictional power.


STICK, SLIP = "#d3e3f3", "#f2b482"
ARROWS = 14
"""Arrows along the longer side of a patch, about."""
PANEL_IN, MAX_ROLLING_HEIGHT_IN = 2.6, 3.6
"""Width of a panel, and the most of its height."""
ROLLING_MARGIN = 0.06
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
"""Longest arrow relative to the distance of arrows."""


@dataclass(frozen=True, eq=False)
class ShownRolling:
    """One patch that rolls, drawn with a direction across to the right and z up.

    - `name`: of the patch.
    - `forces`: creep forces with tractions, slip and states of its cells.
    - `speed_m_s`: speed of rolling.
    - `origin`: length along the first body's surface that is drawn at zero.
    - `sign`: 1 where rising lengths run to the left, else -1, as `flangeway.report.patch_maps.PatchMap`.
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
        corners = np.stack([np.sort(edges[[cells.start, cells.stop]]) for edges, cells in both], axis=1)
        return framed(corners, ROLLING_MARGIN)

    @property
    def cells_drawn(self) -> DrawnCells:
        """The cells in contact as they are drawn."""
        return DrawnCells.between(*self.edges, self.forces.states != NO_CONTACT)

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
    fields = {
        "traction_MPa": forces.tractions,
        slip: scale * forces.slip_velocities,
        power: scale * forces.power_density,
    }
    if forces.flash_temperatures is not None:
        fields["flash_temperature_K"] = forces.flash_temperatures
    return fields | {"stick_slip_state": forces.states.astype(np.float64)}


def shown_fields(fields: Mapping[str, Floats]) -> tuple[list[ShownField], dict[str, Floats]]:
    """Fields of cells (n_cells, n_strips[, 3]) for the viewer, which shows vectors by their sizes, and their arrays."""
    known = {name: values for name, values in fields.items() if name in FIELDS}
    arrays = {name: np.linalg.norm(values, axis=2) if values.ndim > 2 else values for name, values in known.items()}
    return [ShownField(name, *FIELDS[name], "Contact", name, "value") for name in arrays], arrays


def rolling_figure(patches: Sequence[ShownRolling], units: Units = "metric") -> Figure:
    """Draw a row for each patch: where it sticks and slips with its tractions, slip velocity, frictional power."""
    boxes, count = [shown.box for shown in patches], max(len(patches), 1)
    width, heights = (np.array([np.ptp(box, axis=0)[axis] for box in boxes] or [1.0]) for axis in (0, 1))
    scale = min(PANEL_IN / float(width.max()), MAX_ROLLING_HEIGHT_IN / float(heights.max()))
    size = 3.0 * (scale * float(width.max()) + 1.0), scale * float(heights.sum()) + 0.55 * count + 0.7
    figure = new_figure(*size, units)
    rows = figure.subplots(count, 3, squeeze=False, height_ratios=heights.tolist())
    for row, shown, box in zip(rows, patches, boxes, strict=False):
        _draw_states(row[0], shown)
        arrays = cell_fields(shown.forces, shown.speed_m_s)
        drawn, frictional = shown_fields(
            {name: arrays[name] for name in arrays if name.startswith(("slip", "frictional"))}
        )
        for axes, field in zip(row[1:], drawn, strict=True):
            _draw_values(axes, shown, frictional[field.array], field.name, field.unit)
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
    colours, scale = ListedColormap([STICK, SLIP]), Normalize(STICKS - 0.5, SLIPS + 0.5)
    _fill(axes, shown.cells_drawn, states.astype(np.float64), colours, scale)
    spacing = max(np.ptp(shown.box, axis=0)) / ARROWS
    chosen = []
    for ends, cells in zip(edges, shown.forces.contact.box, strict=True):
        step = max(round(spacing / abs(float(np.diff(ends).mean()))), 1)
        chosen.append(np.arange(cells.start, cells.stop)[(cells.stop - cells.start - 1) % step // 2 :: step])
    rows, strips = (positions.ravel() for positions in np.meshgrid(*chosen, indexing="ij"))
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
    drawn = shown.cells_drawn
    scale = Normalize(0.0, max(float(values[drawn.chosen].max()), np.finfo(float).tiny))
    colour_bar(_fill(axes, drawn, values, COLOURS, scale), axes, name, unit, aspect=18, pad=0.02)


# --- Patches in the shakedown diagram: maximum pressure over shear strength, and traction coefficient.


LIMITS = {
    "first_yield": ("first yield", "#2166ac"),
    "shakedown": ("elastic after shakedown, no hardening", "#b35806"),
    "hardening": ("elastic after shakedown, kinematic hardening", PURPLE),
}
KINDS: tuple[tuple[Literal["point", "line"], Any, str], ...] = (
    ("point", "solid", "under a circular patch"),
    ("line", (0, (4, 2)), "under a line contact"),
)
MIN_HEIGHT, MIN_WIDTH = 6.0, 0.6
"""Least extent of the axes."""


def shakedown_figure(patches: Sequence[tuple[str, float, float]], yield_MPa: float, units: Units = "metric") -> Figure:
    """Draw named patches with their traction coefficients and maximum pressures in MPa among the limits."""
    strength = yield_MPa / np.sqrt(3.0)
    highest = max(MIN_HEIGHT, *(1.15 * pressure / strength for *_, pressure in patches))
    widest = min(1.0, max(MIN_WIDTH, *(1.15 * used for _, used, _ in patches)))
    figure, ((axes,),) = panels(7.6, 5.2, units=units)
    traction = np.linspace(0.0, widest, 301)
    for kind, style, label in KINDS:
        for name, (words, colour) in LIMITS.items():
            limit = getattr(shakedown_limits(kind, traction), name)
            axes.plot(traction, limit, color=colour, ls=style, lw=1.4, label=words if kind == "point" else None)
        axes.plot([], [], color=GREY, ls=style, label=label)
    for number, (name, used, pressure) in enumerate(patches):
        label = f"{name}: {measured(pressure, 'MPa', units, '.0f')}"
        axes.plot(used, pressure / strength, "oDs^v"[number % 5], color=INK, ms=7.0, zorder=5, label=label)
    axes.set(xlim=(0.0, widest), ylim=(0.0, highest))
    words = f"maximum pressure over shear strength k = {measured(yield_MPa, 'MPa', units)} / √3"
    name_axes(axes, "traction coefficient: creep force over normal force", words)
    legend_below(figure, 2, fontsize=9)
    return figure
