"""Euler's column: the load at which it buckles."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Elastic, Space, Virtual, triangulate
from flangeway.forms import bilinear, buckling, stiffness
from flangeway.geometry import rectangle
from flangeway.mesh import dual


def main() -> Figure:
    """A strip that is clamped at one end buckles under pi^2 E I / 4 L^2."""
    length, height = 10.0, 0.5
    mesh = dual(triangulate(rectangle(length, height), size=0.25))
    space = Space(mesh, Virtual(2))
    K = stiffness(space, Elastic(1.0, 0.0, "plane_stress").stiffness)
    # a stress of one, in pressure along the strip
    G = bilinear(
        space, lambda u, v, _: -(u.gradient[..., 0] * v.gradient[..., 0]).sum(axis=1), components=2, stabilise=False
    )
    factors, shapes = buckling(space, K, G, 1, space.boundary_dofs("left"))
    euler = np.pi**2 * height**2 / 12.0 / (4.0 * length**2)
    print(f"stress {factors[0]:.6f}, Euler {euler:.6f}")
    assert abs(factors[0] / euler - 1.0) < 0.01
    shape = shapes[0] / np.abs(shapes[0]).max()
    return draw(mesh, np.abs(shape[: mesh.n_points, 1]), moved=2.0 * shape)
