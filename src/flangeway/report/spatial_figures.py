"""Pictures of two bodies in contact in three dimensions."""

from collections.abc import Callable
from functools import partial

from matplotlib.figure import Figure

from flangeway.cases.spatial_case import SpatialRun
from flangeway.report.figures.drawing import PAGE_IN, legend_below, name_axes, panels
from flangeway.report.page.record import Picture
from flangeway.report.patch_figures import draw_depths, maps_figure
from flangeway.report.patch_maps import PatchMap


def patch_figure(run: SpatialRun) -> Figure:
    """Draw the pressures from above, y towards the reader, with the outline of the patches and Hertz's ellipses."""
    return maps_figure([_map(run)], "length along the surface, across z", "z", run.case.units)[0]


def depth_figure(run: SpatialRun) -> Figure:
    """Draw the stresses below the centre of the first patch in both bodies over the depth."""
    figure, (both,) = panels(PAGE_IN, 3.6, 1, 2, run.case.units)
    pair = run.contact.pair
    for axes, body, profile in zip(both, (pair.first, pair.second), run.profiles, strict=True):
        draw_depths(axes, profile)
        axes.set_title(body.name, fontsize=9)
        axes.set_ylim(float(run.profiles[0].depths[-1]), 0.0)
    name_axes(both[0], y=("depth", "mm"))
    legend_below(figure, 5)
    return figure


def _map(run: SpatialRun) -> PatchMap:
    """Patches with the first one's centre at zero."""
    contact = run.contact
    return PatchMap(contact.cells, contact.patches, contact.patches[0].station)


PICTURES: dict[str, tuple[Callable[[SpatialRun], Figure], str]] = {
    "patch.png": (patch_figure, "The pressure from above, with the outline of the patch and Hertz's ellipse"),
    "depth.png": (depth_figure, "Stresses below the centre of the patch in both bodies"),
}


def spatial_pictures(run: SpatialRun) -> list[Picture]:
    """Pictures of a run."""
    return [Picture(name, partial(draw, run), f"{words}.") for name, (draw, words) in PICTURES.items()]
