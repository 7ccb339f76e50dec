"""Advection and diffusion in a turning flow (scikit-fem, example 25)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import bilinear, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import dual


def main() -> Figure:
    """A hot side and a flow around the centre, the matrix is not symmetric; values stay in their range."""
    mesh = dual(triangulate(square(2.0), size=0.08))
    space = Space(mesh, Virtual(1))
    flow = bilinear(
        space, lambda u, v, w: (20.0 * (w.points[:, ::-1] * [-1.0, 1.0]) * u.gradient).sum(axis=1) * v.value
    )
    values = np.zeros(space.n_dofs)
    values[space.boundary_dofs("bottom")] = 1.0
    u = solve(stiffness(space) + flow, np.zeros(space.n_dofs), space.boundary_dofs(), values)
    print(f"values from {u.min():.3f} to {u.max():.3f}")
    assert u.min() > -0.02
    assert u.max() < 1.02
    return draw(mesh, u[: mesh.n_points], colours="coolwarm")
