"""Pictures of a cross-section: mesh with its centres, warping, Prandtl's function, shear stress."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from numpy.typing import NDArray

from flangeway.cases.section.section_run import SectionRun
from flangeway.mesh import PolyMesh
from flangeway.post import corner_shear_stresses, shear_stresses
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    ColourSteps,
    cells_path,
    draw_field,
    draw_lines,
    draw_outline,
    new_figure,
)
from flangeway.types import Floats

WIDTH_IN, MIN_HEIGHT_IN, MAX_HEIGHT_IN = 7.2, 3.4, 9.0
N_ARROWS = 18
TITLE_LETTERS = 60
SHORTEST_ARROW = 0.03  # of the longest
STRESS_UNITS = {
    "mm": (1e6, "MPa per kN m"),
    "cm": (1e3, "MPa per kN m"),
    "m": (1e-3, "MPa per kN m"),
    "in": (1e3, "psi per kip in"),
    "ft": (1.0, "1/ft³"),
}
"""Factor and unit of shear stress per torque in pictures, by unit of length."""


def mesh_figure(run: SectionRun) -> Figure:
    """Draw the mesh, the centroid, the shear centre and the principal axes."""
    mesh, constants = run.space.mesh, run.constants
    figure, axes = _new(run)
    shades = ("#f2f2f2", "#c9c9c9", "#e0e0e0", "#b4b4b4")
    for number, (name, cells) in enumerate(mesh.cell_sets.items()):
        part = cells_path(mesh, mesh.points, cells)
        shade = shades[number % len(shades)]
        axes.add_artist(PathPatch(part, facecolor=shade, edgecolor="#8a8a8a", linewidth=0.2, label=name))
    _outline(axes, mesh)
    centroid, shear_centre = np.array(constants.centroid), np.array(constants.shear_centre)
    low, high = _frame(axes, run, shear_centre)
    for number, turn in ((1, 0.0), (2, 0.5 * np.pi)):
        angle = constants.principal_angle + turn
        ends = _across(centroid, np.array([np.cos(angle), np.sin(angle)]), low, high)
        axes.plot(*ends.T, color=INK, lw=0.8, ls=(0, (8, 3, 2, 3)))
        x, y = centroid + 0.93 * (ends[1] - centroid)
        axes.text(
            x, y, f"{number}", ha="center", va="center", fontsize=9,
            bbox={"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6},
        )  # fmt: skip
    axes.plot(*centroid, "o", ms=7, mfc="white", mec=INK, mew=1.4, ls="none", label="centroid")
    axes.plot(*shear_centre, "X", ms=9, mfc=INK, mec="white", mew=0.8, ls="none", label="shear centre")
    title = textwrap.shorten(run.drawn.title, TITLE_LETTERS, placeholder=" ...")
    axes.set_title(f"{title}\n{mesh.n_cells} elements, principal axes 1 and 2", fontsize=10)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure


def warping_figure(run: SectionRun) -> Figure:
    """Draw the warping about Trefftz's shear centre, for a rate of twist of one."""
    title = f"Warping about the shear centre / rate of twist, in {run.drawn.unit}²"
    return _contours(run, warping_about_shear_centre(run), title)


def prandtl_figure(run: SectionRun) -> Figure:
    """Draw Prandtl's function for ``G theta' = 1``."""
    problem = run.constants.prandtl.problem
    values = run.constants.prandtl.function[: run.space.mesh.n_points] / problem.mean_modulus
    return _contours(run, values, f"Prandtl's function / Gθ′, in {run.drawn.unit}², with lines of shear flow")


def shear_figure(run: SectionRun) -> Figure:
    """Draw the size and direction of the shear stress for a torque of one, averaged at points part by part."""
    mesh, solution = run.space.mesh, run.constants.prandtl
    factor, unit = STRESS_UNITS[run.drawn.unit]
    factor /= solution.torsional_rigidity
    corner_sizes = factor * np.hypot(*corner_shear_stresses(solution).T)
    figure, axes = _new(run)
    parts = [_point_means(mesh, cells, corner_sizes) for cells in mesh.cell_sets.values()]
    shades = ColourSteps(np.concatenate([[0.0], *(values[used] for used, values in parts)]))
    for cells, (_, values) in zip(mesh.cell_sets.values(), parts, strict=True):
        draw_field(axes, _part(mesh, cells), values, shades, lines=False)
    _outline(axes, mesh)
    shown = _spread(mesh)
    arrows = factor * shear_stresses(solution)
    sizes = np.hypot(*arrows.T)
    shown = shown[sizes[shown] > SHORTEST_ARROW * sizes.max()]
    places, arrows = mesh.cell_centroids[shown], arrows[shown]
    span = float(np.ptp(mesh.points, axis=0).max()) / N_ARROWS
    axes.quiver(
        *places.T, *arrows.T, color="white", edgecolor=INK, linewidth=0.4, angles="xy", pivot="mid",
        scale_units="xy", scale=float(np.hypot(*arrows.T).max()) / (1.3 * span), width=0.004, zorder=4,
    )  # fmt: skip
    _frame(axes, run)
    axes.set_title(f"Shear stress per torque, in {unit}", fontsize=10)
    figure.colorbar(shades.mappable(), ax=axes, shrink=0.85, label=unit, ticks=shades.levels.tolist())
    return figure


def _part(mesh: PolyMesh, cells: NDArray[np.int32]) -> PolyMesh:
    """Return the cells of a part, on all points of the mesh."""
    sizes = mesh.cell_sizes[cells]
    offsets = np.append(0, np.cumsum(sizes)).astype(np.int32)
    places = np.repeat(mesh.cell_offsets[cells] - offsets[:-1], sizes) + np.arange(offsets[-1])
    return PolyMesh(mesh.points, offsets, mesh.cell_points[places])


def _point_means(mesh: PolyMesh, cells: NDArray[np.int32], corner_values: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Return which points a part uses (n_points,), and the means of its corners' values there, zero elsewhere."""
    mine = np.zeros(mesh.n_cells, dtype=np.bool_)
    mine[cells] = True
    corners = np.repeat(mine, mesh.cell_sizes)
    points = mesh.cell_points[corners]
    counts = np.bincount(points, minlength=mesh.n_points)
    sums = np.bincount(points, corner_values[corners], minlength=mesh.n_points)
    return counts > 0, sums / np.maximum(counts, 1)


def warping_about_shear_centre(run: SectionRun) -> Floats:
    """Warping at the mesh's points about Trefftz's shear centre, per rate of twist, shape (n_points,)."""
    mesh, solution = run.space.mesh, run.constants.warping
    centre = solution.problem.centre
    ray = np.array(run.constants.shear_centre_trefftz) - centre
    x, y = (mesh.points - centre).T
    values: Floats = solution.function[: mesh.n_points] - ray[1] * x + ray[0] * y
    return values


def _contours(run: SectionRun, values: Floats, title: str) -> Figure:
    mesh = run.space.mesh
    figure, axes = _new(run)
    shades = ColourSteps(values)
    draw_field(axes, mesh, values, shades)
    _outline(axes, mesh)
    _frame(axes, run)
    axes.set_title(title, fontsize=10)
    unit = f"{run.drawn.unit}²"
    figure.colorbar(shades.mappable(), ax=axes, shrink=0.85, label=unit, ticks=shades.levels.tolist())
    return figure


def _new(run: SectionRun) -> tuple[Figure, Axes]:
    width, height = np.ptp(run.space.mesh.points, axis=0)
    figure = new_figure(WIDTH_IN, float(np.clip(0.8 * WIDTH_IN * height / width + 0.9, MIN_HEIGHT_IN, MAX_HEIGHT_IN)))
    figure.set_layout_engine("compressed")
    return figure, figure.subplots()


def _frame(axes: Axes, run: SectionRun, *more: Floats) -> tuple[Floats, Floats]:
    """Show the section, and further points (2,), with one scale and the unit; return the corners of the view."""
    points = np.vstack([run.space.mesh.points, *more])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.06 * float((high - low).max())
    low, high = low - margin, high + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel=f"x in {run.drawn.unit}", ylabel=f"y in {run.drawn.unit}")
    return low, high


def _across(point: Floats, direction: Floats, low: Floats, high: Floats) -> Floats:
    """Return both ends (2, 2) of a line through a point, cut off at a box."""
    slope = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
    steps = np.sort([(low - point) / slope, (high - point) / slope], axis=0)
    return point + np.array([steps[0].max(), steps[1].min()])[:, None] * direction


def _outline(axes: Axes, mesh: PolyMesh) -> None:
    draw_outline(axes, mesh)
    inner = mesh.edge_cells.min(axis=1) >= 0
    if len(mesh.cell_sets) > 1:
        part = np.zeros(mesh.n_cells, dtype=np.int64)
        for number, cells in enumerate(mesh.cell_sets.values()):
            part[cells] = number
        sides = part[mesh.edge_cells]
        draw_lines(axes, mesh.points[mesh.edges[inner & (sides[:, 0] != sides[:, 1])]], GREY, 1.2)


def _spread(mesh: PolyMesh) -> NDArray[np.int64]:
    """Return cells of which one lies near each point of a grid."""
    low = mesh.points.min(axis=0)
    step = float(np.ptp(mesh.points, axis=0).max()) / N_ARROWS
    boxes = np.floor((mesh.cell_centroids - low) / step).astype(np.int64)
    middles = low + (boxes + 0.5) * step
    order = np.argsort(np.hypot(*(mesh.cell_centroids - middles).T), kind="stable")
    _, first = np.unique(boxes[order], axis=0, return_index=True)
    chosen: NDArray[np.int64] = order[first]
    return chosen
