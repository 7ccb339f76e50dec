"""Patches on the cells of a surface: pressures from above, along both axes, stresses below; the surface as a mesh."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from flangeway.contact.patch.contact_ellipse import CellForces, ContactEllipse
from flangeway.exact import PointContact
from flangeway.mesh import PolyMesh
from flangeway.post.patch_stresses import DepthProfile
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    INK,
    LIGHT,
    PURPLE,
    Style,
    colour_bar,
    framed,
    name_axes,
    new_figure,
)
from flangeway.types import Floats
from flangeway.units import Units

CURVES = (
    ("across, x", "#0b5394", "-"), ("normal, y", INK, "-"), ("along, z", "#9a6a00", "-"),
    ("von Mises", PURPLE, "--"), ("Tresca", "#2e7d32", "-."),
)  # fmt: skip
MIN_RATIO = 0.6
"""Width of what is shown of a surface from above over its height, at least."""
MAX_WIDTH_IN, MAX_HEIGHT_IN, MIN_WIDTH_IN, MIN_HEIGHT_IN = 9.0, 6.0, 5.0, 3.0
"""Size of the picture of surfaces from above: without labels at most, with them at least."""
MARGIN = 0.08
"""About what is under pressure, over its longer side."""


@dataclass(frozen=True, eq=False)
class PatchMap:
    """Pressures on cells, to be drawn with lengths along the surface to the right and z up.

    - `cells`: forces on the cells.
    - `patches`: each with Hertz's contact, None where it has no meaning.
    - `origin`: length along the surface that is drawn at zero.
    - `sign`: 1 where rising lengths along the surface run to the left, else -1.
    """

    cells: CellForces
    patches: Sequence[tuple[ContactEllipse, PointContact | None]]
    origin: float
    sign: float = 1.0

    def across(self, stations: Floats) -> Floats:
        """Places to the right of lengths along the surface."""
        return self.sign * (self.origin - stations)

    def centre(self, patch: ContactEllipse) -> Floats:
        """Centre of pressure of a patch as it is drawn, shape (2,)."""
        return np.array([self.across(station_of(self.cells, patch)), patch.centre[2]])

    def tilt(self, patch: ContactEllipse) -> float:
        """Angle in radians from the right to the longer semi-axis as it is drawn."""
        # in a patch from z towards rising lengths, which run to the left
        return np.pi / 2.0 + self.sign * patch.angle_rad

    @property
    def box(self) -> Floats:
        """Corners (2, 2) of what is under pressure, with a margin; of all cells without pressure."""
        cells, loaded = self.cells, self.cells.forces > 0.0
        rows, strips = (np.flatnonzero(loaded.any(axis=1 - axis)) if loaded.any() else [0, -1] for axis in (0, 1))
        ends = np.sort(self.across(cells.grid.cells[[rows[0], rows[-1]], [0, 1]]))
        return framed(np.column_stack((ends, cells.grid.along[[strips[0], strips[-1]]])), MARGIN)


def station_of(cells: CellForces, patch: ContactEllipse) -> Floats:
    """Length along the surface of the centre of pressure of a patch."""
    forces = np.where(patch.inside, cells.forces, 0.0).sum(axis=1)
    return np.asarray(forces @ cells.grid.stations / forces.sum())


def draw_pressures(axes: Axes, shown: PatchMap, highest: float) -> ScalarMappable:
    """Draw pressures from above, outlines of the patches, and Hertz's ellipses; return the colours, from 0 MPa."""
    grid, pressures, scale = shown.cells.grid, shown.cells.pressures, Normalize(0.0, highest)
    drawn = np.where(pressures > 0.0, pressures, np.nan)
    axes.pcolormesh(shown.across(grid.bounds), grid.strip_bounds, drawn.T, cmap=COLOURS, norm=scale, rasterized=True)
    if min(pressures.shape) > 1 and (pressures > 0.0).any():
        middles = shown.across(grid.stations)
        axes.contour(middles, grid.along, pressures.T > 0.0, levels=[0.5], colors=[INK], linewidths=1.0)
    for patch, hertz in shown.patches:
        if hertz is not None:
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


def strip_mesh(nodes: Floats, z: Floats) -> PolyMesh:
    """Mesh of k times m points (length, z), with cells between neighbours."""
    points = np.stack(np.meshgrid(nodes, z, indexing="ij"), axis=-1).reshape(-1, 2)
    first = np.arange(len(nodes) - 1)[:, None] * len(z) + np.arange(len(z) - 1)
    last = first + len(z)
    return PolyMesh.from_cells(points, np.stack((first, last, last + 1, first + 1), axis=-1).reshape(-1, 4))


def at_corners(cells: Mapping[str, Floats]) -> dict[str, Floats]:
    """Arrays of a mesh of quadrilaterals at the corners of its cells, from those of the cells (n, n_z, ...)."""
    return {name: np.repeat(each.reshape(-1, *each.shape[2:]), 4, axis=0) for name, each in cells.items()}
