"""Squares with hanging nodes around an interface."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual
from flangeway.forms import interpolate, solve, stiffness
from flangeway.mesh import quadtree


def main() -> Figure:
    """A jump of the conductivity at a circle: squares with hanging points are polygons with a few points more."""
    mesh = quadtree(1.0, 1.0, 4, 4, finer=lambda c, s: np.abs(np.hypot(*(c - 0.5).T) - 0.3) < 0.8 * s, levels=4)
    inside = np.hypot(*(mesh.cell_centroids - 0.5).T) < 0.3
    space = Space(mesh, Virtual(1))
    values = interpolate(space, lambda p: p[:, 0])
    held = np.union1d(space.boundary_dofs("left"), space.boundary_dofs("right"))
    u = solve(stiffness(space, np.where(inside, 10.0, 1.0)), 0.0 * values, held, values)
    flux = float(u @ (stiffness(space, np.where(inside, 10.0, 1.0)) @ u))
    print(f"{mesh.n_cells} cells, conductance {flux:.4f}")
    assert 1.0 < flux < 2.0
    return draw(mesh, u[: mesh.n_points])
