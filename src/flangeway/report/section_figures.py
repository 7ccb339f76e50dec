"""Pictures of a cross-section: mesh with its centres, warping, Prandtl's function, shear stress."""

import textwrap
from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from flangeway.cases.section_run import SectionRun
from flangeway.geometry.arrays import extent, framed, norms
from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.post import corner_shear_stresses, shear_stresses
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    Style,
    cells_path,
    colour_bar,
    draw_lines,
    equal_axes,
    fill_triangles,
    legend_below,
    new_figure,
    shade_of,
)
from flangeway.report.page.record import Picture
from flangeway.report.scenes import part_numbers, warping_about_shear_centre
from flangeway.types import Floats, Ints

WIDTH_IN, MIN_HEIGHT_IN, MAX_HEIGHT_IN = 7.2, 2.4, 4.2
N_ARROWS, N_LEVELS = 18, 12
TITLE_LETTERS = 60
MIN_ARROW = 0.03  # length of the shortest arrow relative to that of the longest
SHADES = ("#f2f2f2", "#c9c9c9", "#e0e0e0", "#b4b4b4")
STRESS_UNITS = {
    "mm": (1e6, "MPa/kNm"),
    "cm": (1e3, "MPa/kNm"),
    "m": (1e-3, "MPa/kNm"),
    "in": (1e3, "psi per kip in"),
    "ft": (1.0, "1/ft³"),
}
"""Factor and unit of shear stress per torque in pictures, by unit of length."""


def mesh_figure(run: SectionRun) -> Figure:
    """Draw the mesh, the centroid, the shear centre and the principal axes."""
    mesh, constants = run.space.mesh, run.constants
    figure, axes = _new(run)
    for number, (name, cells) in enumerate(mesh.cell_sets.items()):
        part = cells_path(mesh, mesh.points, cells)
        shade = SHADES[number % len(SHADES)]
        axes.add_artist(PathPatch(part, facecolor=shade, edgecolor="#8a8a8a", linewidth=0.2, label=name))
    _outline(axes, mesh)
    centroid, shear_centre = np.array(constants.centroid), np.array(constants.shear_centre)
    size = extent(_frame(axes, run, shear_centre))
    for number, turn in ((1, 0.0), (2, 0.5 * np.pi)):
        angle = constants.principal_angle + turn
        x, y = (centroid + 0.15 * size * np.array([np.cos(angle), np.sin(angle)])).tolist()
        axes.axline(constants.centroid, (x, y), color=INK, lw=0.8, ls=(0, (8, 3, 2, 3)))
        circle: Style = {"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6}
        axes.text(x, y, f"{number}", ha="center", va="center", fontsize=9, bbox=circle)
    axes.plot(*centroid, "o", ms=7, mfc="white", mec=INK, mew=1.4, ls="none", label="centroid")
    axes.plot(*shear_centre, "X", ms=9, mfc=INK, mec="white", mew=0.8, ls="none", label="shear centre")
    title = textwrap.shorten(run.drawn.title, TITLE_LETTERS, placeholder=" ...")
    axes.set_title(f"{title}\n{mesh.n_cells} elements, principal axes 1 and 2", fontsize=9)
    legend_below(figure, 4)
    return figure


def warping_figure(run: SectionRun) -> Figure:
    """Draw the warping about Trefftz's shear centre, for a rate of twist of one."""
    values = warping_about_shear_centre(run)
    return _contours(run, values, "Warping about the shear centre / rate of twist")


def prandtl_figure(run: SectionRun) -> Figure:
    """Draw Prandtl's function for ``G theta' = 1``."""
    prandtl = run.constants.prandtl
    values = prandtl.function[: run.space.mesh.n_points] / prandtl.problem.mean_modulus
    return _contours(run, values, "Prandtl's function / Gθ′, with lines of shear flow")


def shear_figure(run: SectionRun) -> Figure:
    """Draw the size and direction of the shear stress for a torque of one, in each element as it is."""
    mesh, solution = run.space.mesh, run.constants.prandtl
    factor, unit = STRESS_UNITS[run.drawn.unit]
    factor /= solution.torsional_rigidity
    sizes = factor * norms(corner_shear_stresses(solution))
    figure, axes = _new(run)
    shade = shade_of(sizes, (0.0, float(sizes.max())))
    fill_triangles(axes, mesh.points[mesh.cell_points], _fans(mesh), sizes, shade)
    _outline(axes, mesh)
    arrows = shear_stresses(solution)[shown := _spread(mesh)]
    lengths = norms(arrows)
    long = lengths > MIN_ARROW * lengths.max()
    span = extent(mesh.points) / N_ARROWS
    style: Style = {"color": "white", "edgecolor": INK, "linewidth": 0.4, "width": 0.004, "zorder": 4, "pivot": "mid"}
    scale: Style = {"angles": "xy", "scale_units": "xy", "scale": float(lengths.max()) / (1.3 * span)}
    axes.quiver(*mesh.cell_centroids[shown[long]].T, *arrows[long].T, **style, **scale)
    _frame(axes, run)
    axes.set_title("Shear stress per torque", fontsize=9)
    colour_bar(shade, axes, "shear stress per torque", unit, shrink=0.85)
    return figure


def stress_figure(run: SectionRun) -> Figure:
    """Draw the von Mises stress under the forces of the case."""
    return _contours(run, run.von_mises, "von Mises stress under all forces", run.stress_unit)


def _fans(mesh: PolyMesh) -> Ints:
    """Cells as fans of triangles about their first corner: numbers of corners of cells, shape (n, 3)."""
    fans = [
        mesh.cell_offsets[cells].astype(np.int64)[:, None] + [0, corner, corner + 1]
        for n_vertices, cells in mesh.batches()
        for corner in range(1, n_vertices - 1)
    ]
    return np.vstack(fans)


def _contours(run: SectionRun, values: Floats, title: str, unit: str | None = None) -> Figure:
    """Draw values at the points of the mesh (n_points,) with lines of equal value; dashed ones are negative."""
    mesh = run.space.mesh
    figure, axes = _new(run)
    shade, triangles = shade_of(values), mesh.cell_points[_fans(mesh)].astype(np.int64)
    fill_triangles(axes, mesh.points, triangles, values, shade)
    grid = Triangulation(mesh.points[:, 0], mesh.points[:, 1], triangles)
    axes.tricontour(
        grid, values, MaxNLocator(N_LEVELS).tick_values(values.min(), values.max()), colors=INK, linewidths=0.5
    )
    _outline(axes, mesh)
    _frame(axes, run)
    axes.set_title(title, fontsize=9)
    colour_bar(shade, axes, title.partition(",")[0], unit or f"{run.drawn.unit}²", shrink=0.85)
    return figure


def _new(run: SectionRun) -> tuple[Figure, Axes]:
    width, height = np.ptp(run.space.mesh.points, axis=0)
    height_in = float(np.clip(0.8 * WIDTH_IN * height / width + 0.9, MIN_HEIGHT_IN, MAX_HEIGHT_IN))
    figure = new_figure(WIDTH_IN, height_in, run.case.units, compressed=True)
    return figure, figure.subplots()


def _frame(axes: Axes, run: SectionRun, *more: Floats) -> Floats:
    """Show the section, and further points (2,), with one scale and the unit; return the corners (2, 2) of the view."""
    points = np.vstack([run.space.mesh.points, *more])
    corners = framed(points, 0.06)
    equal_axes(axes, corners, run.drawn.unit)
    return corners


def _outline(axes: Axes, mesh: PolyMesh) -> None:
    """Draw the boundary with its curves, and the edges between parts."""
    rim = as_polylines(mesh)
    draw_lines(axes, rim.points[rim.boundary_edges], INK, 0.9)
    sides = part_numbers(mesh)[mesh.edge_cells]
    between = (mesh.edge_cells.min(axis=1) >= 0) & (sides[:, 0] != sides[:, 1])
    draw_lines(axes, mesh.points[mesh.edges[between]], GREY, 1.2)


def _spread(mesh: PolyMesh) -> Ints:
    """Return cells of which one lies in each square of a grid."""
    step = extent(mesh.points) / N_ARROWS
    _, first = np.unique(np.floor(mesh.cell_centroids / step), axis=0, return_index=True)
    return first.astype(np.int64)


PICTURES: dict[str, tuple[Callable[[SectionRun], Figure], str]] = {
    "mesh.png": (mesh_figure, "The mesh, with the centroid, the shear centre and the principal axes"),
    "warping.png": (warping_figure, "Warping about the shear centre per rate of twist, with contour lines"),
    "shear_stress.png": (shear_figure, "Shear stress for a unit torque, with arrows in its direction"),
    "prandtl.png": (prandtl_figure, "Prandtl's function, whose contour lines are lines of shear flow"),
}
"""Functions that draw the pictures, the most important first, and what they show, by the files' names."""
STRESS_PICTURE = {"stress.png": (stress_figure, "The von Mises stress under the prescribed forces")}
"""The same of a section under forces, before the others."""


def section_pictures(run: SectionRun) -> list[Picture]:
    """Pictures of a section, the most important first."""
    draws = (STRESS_PICTURE if run.case.has_forces else {}) | PICTURES
    return [Picture(name, partial(draw, run), f"{words}.") for name, (draw, words) in draws.items()]
