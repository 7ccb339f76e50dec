"""Adaptive refinement at a reentrant corner (scikit-fem, example 22; mVEM)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import interpolate, solve, stiffness
from flangeway.geometry import polygon
from flangeway.mesh import doerfler_marking, dual, refined
from flangeway.types import Floats


def exact(p: Floats) -> Floats:
    """``r^(2/3) sin(2 phi / 3)``."""
    angle = np.mod(np.arctan2(p[:, 1], p[:, 0]), 2.0 * np.pi)
    return np.asarray(np.hypot(*p.T) ** (2.0 / 3.0) * np.sin(2.0 * angle / 3.0))


def main() -> Figure:
    """Polygons are refined where the solution differs most from the exact one: hanging points need nothing else."""
    mesh = dual(triangulate(polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)]), size=0.4))
    errors = []
    for _ in range(8):
        space = Space(mesh, Virtual(1))
        values = interpolate(space, exact)
        u = solve(stiffness(space), np.zeros(space.n_dofs), space.boundary_dofs(), values)
        of_points = np.abs(u - values)[mesh.cell_points]
        errors.append(float(of_points.max()))
        mesh = refined(mesh, doerfler_marking(np.maximum.reduceat(of_points, mesh.cell_offsets[:-1])), most_hanging=1)
    print(f"largest error {errors[0]:.1e}, at last {errors[-1]:.1e} on {mesh.n_cells} cells")
    assert errors[-1] < 0.2 * errors[0]
    return draw(mesh)
