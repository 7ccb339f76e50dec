"""The picture of each kind of result, see `flangeway.report.plot_result`."""

from collections.abc import Callable, Sequence
from typing import Any, cast

from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from flangeway.campaign import CampaignTable
from flangeway.cases.profile_run import ProfileRun
from flangeway.cases.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.summary import RunResult
from flangeway.contact.patch.patch_contact import SpatialPatch
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.problems import Elasticity
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report.campaign_figures import campaign_figures
from flangeway.report.case_outputs import case_record
from flangeway.report.figures.drawing import INK, name_axes, new_figure
from flangeway.report.figures.plots import plot_mesh, plot_result
from flangeway.report.profile_outputs import profile_figure, shape_figure
from flangeway.report.rigid_outputs import conicity_figure, locus_figure
from flangeway.report.wheelset.wheelset_figures import pressures_figure
from flangeway.results import Shown

__all__ = ["plot_result"]


def _first_picture(run: RunResult) -> Figure:
    """Draw the first picture of the report of a run."""
    return _first([picture.draw for picture in case_record(run).pictures()], run.case.name)


def _first_of_campaign(table: CampaignTable) -> Figure:
    return _first([*campaign_figures(table).values()], f"the campaign {table.name}")


def _first(draws: Sequence[Callable[[], Figure]], name: str) -> Figure:
    if not draws:
        raise InputError(f"a picture of {name}", "inputs that vary, or results that have one", "draw its table")
    return draws[0]()


def cells_figure(patch: SpatialPatch) -> Figure:
    """Draw the pressures of one patch from above, lengths along the surface to the right."""
    figure = new_figure(6.0, 5.0, compressed=True)
    axes, grid = figure.subplots(), patch.cells.grid
    shade = axes.pcolormesh(grid.bounds, grid.strip_bounds, patch.cells.pressures.T, cmap="magma_r")
    figure.colorbar(shade, label="pressure, MPa")
    axes.set_aspect("equal")
    name_axes(axes, ("along the surface", "mm"), ("z", "mm"))
    return figure


def surface_figure(mesh: PolyhedralMesh) -> Figure:
    """Draw the outer faces of a mesh in space."""
    figure = new_figure(6.0, 5.5)
    axes: Any = figure.add_subplot(projection="3d")
    loops = [mesh.points[mesh.loop(face)] for face in mesh.boundary_faces]
    axes.add_collection3d(Poly3DCollection(loops, facecolors="#dde3ea", edgecolors=INK, linewidths=0.4))
    axes.auto_scale_xyz(*mesh.points.T)
    axes.set_aspect("equal")
    axes.set(xlabel="x", ylabel="y", zlabel="z")
    return figure


PLOTS: dict[type[Shown], Callable[[Any], Figure]] = {
    RunResult: _first_picture,
    GeometryRun: locus_figure,
    ConicityRun: conicity_figure,
    ProfileRun: shape_figure,
    CampaignTable: _first_of_campaign,
    RailProfile: profile_figure,
    WheelProfile: profile_figure,
    SpatialResult: pressures_figure,
    SpatialPatch: cells_figure,
    PolyMesh: lambda mesh: cast(Figure, plot_mesh(mesh).figure),
    PolyhedralMesh: surface_figure,
    Elasticity: lambda problem: problem.space.mesh.plot(),
}
for _kind, _draw in PLOTS.items():
    plot_result.register(_kind, _draw)
