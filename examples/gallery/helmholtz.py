"""Waves of a source that leave through an absorbing boundary: a complex matrix."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import load, mass, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import dual

WAVE_NUMBER = 12.0


def main() -> Figure:
    """``-div grad u - k^2 u = f`` with ``du/dn = i k u``: what the source gives leaves through the boundary."""
    mesh = dual(triangulate(square(2.0), size=0.07))
    space = Space(mesh, Virtual(2))
    rim = sum(mass(space, on=name) for name in mesh.edge_sets)
    source = load(space, lambda p: np.exp(-100.0 * ((p - [-0.4, 0.2]) ** 2).sum(axis=1)))
    u = solve(stiffness(space) - WAVE_NUMBER**2 * mass(space) - 1j * WAVE_NUMBER * rim, source)
    radiated, given = WAVE_NUMBER * np.vdot(u, rim @ u).real, np.vdot(source, u).imag
    print(f"power of the source {given:.4e}, through the boundary {radiated:.4e}")
    assert abs(radiated / given - 1.0) < 1e-9
    return draw(mesh, u.real[: mesh.n_points], colours="RdBu")
