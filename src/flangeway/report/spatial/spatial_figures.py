"""Pictures of a contact in three dimensions: patches from above, pressure along both axes, stresses below."""

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.spatial.spatial_case import SpatialRun
from flangeway.report.figures.drawing import new_figure
from flangeway.report.spatial.patch_map import PatchMap, draw_depths, draw_pressures, draw_sections

HIGHEST, LOWEST, WIDE = 1.6, 0.45, 0.8
"""Height over width of the picture from above, at most and at least, and where the scale is below it."""


def patch_figure(run: SpatialRun) -> Figure:
    """Draw the pressures from above, y towards the reader, with the outline of the patches and Hertz's ellipses."""
    shown = _map(run)
    width, height = np.ptp(shown.box, axis=0)
    ratio = float(np.clip(height / width, LOWEST, HIGHEST))
    figure = new_figure(7.0, 1.2 + 5.0 * ratio)
    axes = figure.subplots()
    drawn = draw_pressures(axes, shown, float(shown.cells.pressures.max()))
    axes.set(xlim=shown.box[:, 0], ylim=shown.box[:, 1])
    axes.set_xlabel("length along the surface, across z, in mm")
    axes.set_ylabel("z in mm")
    side = "bottom" if ratio < WIDE else "right"
    figure.colorbar(drawn, ax=axes, label="contact pressure in MPa", shrink=0.9, location=side)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize=8)
    return figure


def pressure_figure(run: SpatialRun) -> Figure:
    """Draw the pressure across and along z through the cell of the maximum pressure, beside Hertz's."""
    figure = new_figure(9.0, 3.6)
    across, along = figure.subplots(1, 2, sharey=True)
    draw_sections(across, along, _map(run), 0)
    across.set(xlabel="length across z in mm", ylabel="contact pressure in MPa")
    along.set_xlabel("length along z in mm")
    across.legend(loc="lower center", fontsize=8)
    return figure


def depth_figure(run: SpatialRun) -> Figure:
    """Draw the stresses below the centre of the first patch in both bodies over the depth."""
    figure = new_figure(9.0, 4.6)
    pair = run.contact.pair
    names = (pair.first.name, pair.second.name)
    for axes, name, profile in zip(figure.subplots(1, 2, sharey=True), names, run.profiles, strict=True):
        draw_depths(axes, profile)
        axes.set_title(name, fontsize=10)
        axes.set_xlabel("stress in MPa")
    figure.axes[0].set_ylabel("depth in mm")
    figure.axes[0].set_ylim(float(run.profiles[0].depths[-1]), 0.0)
    figure.axes[0].legend(loc="lower left", fontsize=8)
    return figure


def _map(run: SpatialRun) -> PatchMap:
    """Patches with the first one's centre at zero."""
    found = run.contact
    forces = np.where(found.patches[0].inside, found.cells.forces, 0.0).sum(axis=1)
    origin = float(forces @ found.cells.across / forces.sum())
    return PatchMap(found.cells, [(patch, found.hertz(patch)) for patch in found.patches], origin)
