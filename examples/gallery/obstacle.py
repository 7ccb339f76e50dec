"""A membrane over an obstacle: a variational inequality (mVEM)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import load, solve, stiffness
from flangeway.geometry import circle
from flangeway.mesh import dual


def main() -> Figure:
    """Pressed down on a flat floor, the membrane lies on it inside a radius with a closed form."""
    mesh, floor, pressure = dual(triangulate(circle(1.0), size=0.08)), -0.1, -1.0
    space = Space(mesh, Virtual(1))
    K, f, rim = stiffness(space), load(space, pressure), space.boundary_dofs()
    touching = np.zeros(space.n_dofs, dtype=bool)
    for _ in range(30):  # primal-dual active set
        fixed = np.union1d(rim, np.flatnonzero(touching))
        u = solve(K, f, fixed, np.where(touching, floor, 0.0))
        reaction = K @ u - f
        before, touching = touching, (u < floor - 1e-12) | (touching & (reaction > 0.0))
        touching[rim] = False
        if (before == touching).all():
            break
    radius = float(np.hypot(*space.nodes[touching].T).max())
    # u = p r^2 / 4 + c ln r outside of the contact: value and slope vanish against the floor there
    exact = next(r for r in np.linspace(0.01, 0.99, 2000) if (1.0 - r**2) / 4.0 + r**2 / 2.0 * np.log(r) <= -floor)
    print(f"contact up to radius {radius:.3f}, closed form {exact:.3f}")
    assert abs(radius - exact) < 0.06
    return draw(mesh, u[: mesh.n_points])
