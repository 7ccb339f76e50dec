"""Heat that flows out of a plate, step by step (scikit-fem, example 19)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import interpolate, mass, stiffness, theta_steps
from flangeway.geometry import square
from flangeway.mesh import dual


def main() -> Figure:
    """Crank and Nicolson's method with one factor for all steps; the mode decays as ``exp(-2 pi^2 t)``."""
    mesh = dual(triangulate(square(1.0), size=0.08))
    space = Space(mesh, Virtual(2))
    start = interpolate(space, lambda p: np.cos(np.pi * p).prod(axis=1))
    steps = theta_steps(mass(space), stiffness(space), start, 0.002, 50, fixed=space.boundary_dofs())
    *_, (time, u) = steps
    decay = u.max() / start.max()
    print(f"after {time:.2f}: {decay:.5f}, exact {np.exp(-2.0 * np.pi**2 * time):.5f}")
    assert abs(decay / np.exp(-2.0 * np.pi**2 * time) - 1.0) < 2e-3
    return draw(mesh, u[: mesh.n_points], colours="inferno")
