"""Laplace's equation with prescribed values (scikit-fem, example 14)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import interpolate, solve, stiffness
from flangeway.geometry import circle
from flangeway.mesh import dual
from flangeway.types import Floats


def exact(p: Floats) -> Floats:
    """The real part of ``z^3``, which is harmonic."""
    return np.asarray(((p[:, 0] + 1j * p[:, 1]) ** 3).real)


def main() -> Figure:
    """The harmonic polynomial is found exactly by order 3 from its values on the boundary."""
    mesh = dual(triangulate(circle(1.0), size=0.12))
    space = Space(mesh, Virtual(3))
    values = interpolate(space, exact)
    u = solve(stiffness(space), np.zeros(space.n_dofs), space.boundary_dofs(), values)
    error = np.abs(u - values).max()
    print(f"largest error {error:.1e}")
    assert error < 1e-9
    return draw(mesh, u[: mesh.n_points], colours="RdBu")
