"""Cook's membrane of an incompressible material: nothing locks."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual
from flangeway.forms import load, stokes
from flangeway.mesh import PolyMesh, dual, rectangle_grid


def main() -> Figure:
    """The divergence-free element, with displacements for velocities; the load's work is 2652.4 for nu = 0.4999."""
    grid = rectangle_grid(1.0, 1.0, 12, 12)
    s, t = grid.points.T
    points = np.stack((48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s)), axis=1)
    mesh = dual(PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets))
    held = Space(mesh, Virtual(2)).boundary_dofs("left")
    found = stokes(mesh, 2, viscosity=70.0 / 3.0, held=held, tractions={"right": (0.0, 6.25)})
    moved = found.velocity[: mesh.n_points]
    forces = load(found.space, (0.0, 6.25), on="right")[: found.space.n_nodes]
    work = float((forces * found.velocity).sum())
    print(f"work of the load {work:.1f}")
    assert abs(work / 2652.36 - 1.0) < 0.01
    _, weights, _, gradient, _ = found.at_quadrature(4)
    assert weights @ np.einsum("nii->n", gradient) ** 2 < 1e-12
    return draw(mesh, np.hypot(*moved.T), moved=moved)
