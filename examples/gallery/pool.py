"""A wave in a square pool: Newmark's method keeps its energy."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import interpolate, mass, newmark_steps, stiffness
from flangeway.geometry import square
from flangeway.mesh import agglomerated


def main() -> Figure:
    """A drop on cells that are not convex; after 60 steps the energy is what it was."""
    mesh = agglomerated(triangulate(square(1.0), size=0.03), 700)
    space = Space(mesh, Virtual(2))
    K, M = stiffness(space), mass(space)
    start = interpolate(space, lambda p: np.exp(-120.0 * ((p - 0.1) ** 2).sum(axis=1)))
    for _, u, v in newmark_steps(M, K, start, 0.0 * start, 0.01, 60):
        energy = (u @ (K @ u) + v @ (M @ v)) / (start @ (K @ start))
    print(f"energy over that of the start {energy:.12f}")
    assert abs(energy - 1.0) < 1e-10
    return draw(mesh, u[: mesh.n_points], colours="RdBu")
