"""Flow around an obstacle in a channel."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import load, stokes
from flangeway.geometry import circle, rectangle
from flangeway.mesh import dual
from flangeway.types import Floats


def inflow(p: Floats) -> Floats:
    """A parabola at both ends, zero at walls and obstacle."""
    speed = np.where(np.abs(p[:, 0]) > 1.999, 1.0 - p[:, 1] ** 2, 0.0)
    return np.stack((speed, np.zeros_like(speed)), axis=1)


def main() -> Figure:
    """As much flows past the obstacle as comes in: 4/3."""
    mesh = dual(triangulate(rectangle(4.0, 2.0), size=0.15, holes=[circle(0.35, (-0.4, 0.1))]))
    space = Space(mesh, Virtual(2))
    held = space.boundary_dofs(lambda p: (p[:, 0] < 2.0 - 1e-9) | (np.abs(p[:, 1]) > 1.0 - 1e-9))
    flow = stokes(mesh, 2, velocity=inflow, held=held)
    through = float(load(space, 1.0, on="right")[: space.n_nodes] @ flow.velocity[:, 0])
    print(f"flow through the outlet {through:.6f}, through the inlet {4.0 / 3.0:.6f}")
    assert abs(through - 4.0 / 3.0) < 1e-8
    return draw(mesh, np.hypot(*flow.velocity[: mesh.n_points].T))
