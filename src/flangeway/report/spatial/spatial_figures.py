"""Pictures of a contact in three dimensions: patches from above, pressure along both axes, stresses below."""

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.spatial.spatial_case import SpatialRun
from flangeway.report.figures.drawing import name_axes, panels
from flangeway.report.spatial.patch_map import PatchMap, draw_depths, draw_sections, maps_figure


def patch_figure(run: SpatialRun) -> Figure:
    """Draw the pressures from above, y towards the reader, with the outline of the patches and Hertz's ellipses."""
    return maps_figure([_map(run)], "length along the surface, across z", "z", run.case.units)[0]


def pressure_figure(run: SpatialRun) -> Figure:
    """Draw the pressure across and along z through the cell of the maximum pressure, beside Hertz's."""
    figure, ((across, along),) = panels(9.0, 3.6, 1, 2, run.case.units, sharey=True)
    draw_sections(across, along, _map(run), 0)
    name_axes(across, ("length across z", "mm"), ("contact pressure", "MPa"))
    name_axes(along, ("length along z", "mm"))
    across.legend(loc="lower center", fontsize=8)
    return figure


def depth_figure(run: SpatialRun) -> Figure:
    """Draw the stresses below the centre of the first patch in both bodies over the depth."""
    figure, (both,) = panels(9.0, 4.6, 1, 2, run.case.units)
    pair = run.contact.pair
    for axes, body, profile in zip(both, (pair.first, pair.second), run.profiles, strict=True):
        draw_depths(axes, profile)
        axes.set_title(body.name, fontsize=10)
        axes.set_ylim(float(run.profiles[0].depths[-1]), 0.0)
    both[0].legend(loc="lower left", fontsize=8)
    return figure


def _map(run: SpatialRun) -> PatchMap:
    """Patches with the first one's centre at zero."""
    contact = run.contact
    forces = np.where(contact.patches[0].inside, contact.cells.forces, 0.0).sum(axis=1)
    origin = float(forces @ contact.cells.across / forces.sum())
    return PatchMap(contact.cells, [(patch, contact.hertz(patch)) for patch in contact.patches], origin)
