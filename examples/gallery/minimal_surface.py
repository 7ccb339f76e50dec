"""A soap film on a wavy rim: Newton's method for a form of one's own (scikit-fem, example 10)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import newton
from flangeway.geometry import circle
from flangeway.mesh import dual


def main() -> Figure:
    """The tangent comes from the form itself, by complex steps."""
    mesh = dual(triangulate(circle(1.0), size=0.12))
    space = Space(mesh, Virtual(2))
    rim, start = space.boundary_dofs(), np.zeros(space.n_dofs)
    x, y = space.nodes[rim].T
    start[rim] = 0.4 * np.cos(3.0 * np.arctan2(y, x))
    film = newton(
        space,
        lambda u, v, _: (u.gradient * v.gradient).sum(axis=1) / np.sqrt(1.0 + (u.gradient**2).sum(axis=1)),
        start,
        fixed=rim,
    )
    print(film.status.message, "in", film.status.iterations, "iterations")
    assert film.status.converged
    return draw(mesh, film.dofs[: mesh.n_points], colours="RdBu")
