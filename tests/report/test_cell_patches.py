"""Cells in steps of colour: each has its own, whatever the shape of the regions."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from flangeway.mesh import dual, rectangle_grid
from flangeway.report.figures.drawing import ColourSteps, cells_path, draw_lines, fill_cells

SIDE = 400
VALUES = np.array([0.0, 900.0])


def empty() -> Axes:
    """Axes that fill a picture of 400 x 400 pixels and show the unit square."""
    axes = Figure(figsize=(4.0, 4.0), dpi=SIDE / 4.0).add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.0)
    return axes


def drawn(axes):
    """Colours (400, 400, 3) from 0 to 1, the first row at the bottom."""
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[::-1, :, :3] / 255.0


def at(pixels, points):
    """Colours of pixels at points (n, 2)."""
    column, row = (points * SIDE).astype(int).T
    return pixels[row, column]


@pytest.fixture(scope="module", params=["triangles", "polygons", "quadrilaterals"])
def mesh(request):
    """Meshes of the unit square with cells of three, four, and many corners."""
    if request.param == "quadrilaterals":
        return rectangle_grid(1.0, 1.0, 9, 7, cells="quadrilaterals")
    triangles = rectangle_grid(1.0, 1.0, 8, 8)
    return triangles if request.param == "triangles" else dual(triangles)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_each_cell_has_its_colour(mesh, seed):
    """Of values that jump at random from cell to cell, each shows its step of colour, with no gap between cells."""
    values = np.random.default_rng(seed).choice([50.0, 250.0, 450.0, 850.0], mesh.n_cells)
    colours = ColourSteps(VALUES, from_zero=True)
    axes = empty()
    fill_cells(axes, mesh, mesh.points, values, colours)
    pixels = drawn(axes)
    wanted = colours.map(colours.norm(values))[:, :3]
    assert np.abs(at(pixels, mesh.cell_centroids) - wanted).max() < 0.01
    light = colours.map(colours.norm([50.0]))[0, :3]
    assert (pixels <= light + 0.01).all()


def test_checkerboard_and_hole(mesh):
    """Cells that meet in a point only, and one that all others enclose, have their colours."""
    axes, colours = empty(), ColourSteps(VALUES, from_zero=True)
    middle = mesh.cell_centroids
    values = np.where((np.floor(middle * 5.0).sum(axis=1) % 2).astype(bool), 850.0, 150.0)
    values[np.argmin(np.hypot(*(middle - 0.5).T))] = 450.0
    fill_cells(axes, mesh, mesh.points, values, colours)
    assert np.abs(at(drawn(axes), middle) - colours.map(colours.norm(values))[:, :3]).max() < 0.01


def test_only_chosen_cells_are_drawn(mesh):
    """Cells that are not chosen stay white; with lines, edges of the chosen ones are drawn over them."""
    chosen = mesh.cell_centroids[:, 0] < 0.6
    values, colours = np.full(mesh.n_cells, 850.0), ColourSteps(VALUES, from_zero=True)
    axes = empty()
    fill_cells(axes, mesh, mesh.points, values, colours, chosen=chosen)
    plain = drawn(axes)
    found = at(plain, mesh.cell_centroids)
    assert (found[~chosen] == 1.0).all()
    assert np.abs(found[chosen] - colours.map(colours.norm([850.0]))[0, :3]).max() < 0.01
    axes = empty()
    fill_cells(axes, mesh, mesh.points, values, colours, chosen=chosen, lines=(1.0, 1.0, 1.0, 1.0))
    pairs = mesh.edge_cells
    inner = (pairs[:, 1] >= 0) & chosen[pairs].all(axis=1)
    middles = mesh.points[mesh.edges[inner]].mean(axis=1)
    assert (at(drawn(axes), middles).sum(axis=1) > at(plain, middles).sum(axis=1)).mean() > 0.5


def test_no_chosen_cell_draws_nothing(mesh):
    """A window in which a body has no cell stays white."""
    axes, nothing = empty(), np.zeros(mesh.n_cells, dtype=bool)
    values = np.full(mesh.n_cells, 850.0)
    fill_cells(
        axes, mesh, mesh.points, values, ColourSteps(VALUES, from_zero=True), chosen=nothing, lines=(0.0, 0.0, 0.0, 1.0)
    )
    assert (drawn(axes) == 1.0).all()


def test_paths_of_cells_and_lines(mesh):
    """A path about some cells covers just these, and lines lie where they are given."""
    cells = np.flatnonzero(mesh.cell_centroids[:, 1] > 0.5)
    axes = empty()
    axes.add_artist(PathPatch(cells_path(mesh, mesh.points, cells), facecolor="black", linewidth=0.0))
    covered = at(drawn(axes), mesh.cell_centroids).sum(axis=1) == 0.0
    assert np.array_equal(np.flatnonzero(covered), cells)
    axes = empty()
    draw_lines(
        axes, np.array([[[0.1, 0.2], [0.5, 0.2], [0.5, 0.9]], [[0.8, 0.1], [0.8, 0.5], [0.9, 0.5]]]), "black", 3.0
    )
    pixels = drawn(axes)
    assert (at(pixels, np.array([[0.3, 0.2], [0.5, 0.6], [0.8, 0.3], [0.85, 0.5]])) < 0.1).all()
    assert (at(pixels, np.array([[0.3, 0.5], [0.65, 0.5], [0.7, 0.15]])) == 1.0).all()
