"""Poisson's equation on triangles (scikit-fem, example 1)."""

from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Lagrange, Space, triangulate
from flangeway.forms import load, solve, stiffness
from flangeway.geometry import square


def main() -> Figure:
    """Solve ``-div grad u = 1`` in the unit square, u = 0 on its boundary; the largest value is 0.07367."""
    mesh = triangulate(square(1.0), size=0.06)
    space = Space(mesh, Lagrange(2))
    u = solve(stiffness(space), load(space, 1.0), space.boundary_dofs())
    print(f"largest value {u.max():.5f}")
    assert abs(u.max() - 0.07367) < 1e-4
    return draw(mesh, u[: mesh.n_points])
