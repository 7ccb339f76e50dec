"""Phases that separate: an equation of Allen and Cahn, implicit in the diffusion (dune-vem's phase field)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual
from flangeway.forms import Factor, Field, linear, mass, stiffness
from flangeway.geometry import square
from flangeway.mesh import voronoi

WIDTH, STEP = 0.03, 0.002


def main() -> Figure:
    """Each step has one kept factor; the free energy never grows."""
    mesh = voronoi(square(1.0), 900, iterations=5)
    space = Space(mesh, Virtual(1))
    K, M = WIDTH**2 * stiffness(space), mass(space)
    factor = Factor(M + 20.0 * STEP * K + 40.0 * STEP * M)
    u, energies = 0.1 * np.random.default_rng(3).standard_normal(space.n_dofs), []
    for _ in range(60):
        field = Field(space, u)
        reaction = linear(space, lambda v, w: (w.u.value - w.u.value**3) * v.value, fields={"u": field})
        u = factor.solve(M @ u + 20.0 * STEP * (reaction + 2.0 * (M @ u)))
        _, weights, values = Field(space, u).at_quadrature()
        energies.append(float(u @ (K @ u)) / 2.0 + weights @ (1.0 - values.value**2) ** 2 / 4.0)
    print(f"free energy from {energies[0]:.4f} to {energies[-1]:.4f}")
    assert (np.diff(energies) < 1e-12).all()
    return draw(mesh, u[: mesh.n_points], colours="coolwarm")
