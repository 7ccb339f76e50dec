"""Poisson's equation on Voronoi cells (mVEM and dune-vem, first example)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual
from flangeway.forms import error_norms, interpolate, load, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import voronoi
from flangeway.types import Floats


def exact(p: Floats) -> Floats:
    """The solution at points (n, 2)."""
    return np.asarray(np.cos(np.pi * p).prod(axis=1))


def gradient(p: Floats) -> Floats:
    """Its gradient, (n, 2)."""
    return -np.pi * np.sin(np.pi * p) * np.cos(np.pi * p[:, ::-1])


def main() -> Figure:
    """Solve with virtual elements of order 2, and compare with the exact solution."""
    mesh = voronoi(square(1.0), 200)
    space = Space(mesh, Virtual(2))
    rhs = load(space, lambda p: 2.0 * np.pi**2 * exact(p))
    u = solve(stiffness(space), rhs, space.boundary_dofs(), interpolate(space, exact))
    errors = error_norms(space, u, exact, gradient)
    print(f"relative errors: L2 {errors.relative_l2:.1e}, H1 {errors.relative_h1:.1e}")
    assert errors.relative_l2 < 2e-3
    return draw(mesh, u[: mesh.n_points])
