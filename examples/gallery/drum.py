"""The L-shaped drum: eigenvalues of a membrane (C. Moler's logo)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Lagrange, Space, triangulate
from flangeway.forms import mass, modes, stiffness
from flangeway.geometry import polygon
from flangeway.mesh import Refinement


def main() -> Figure:
    """The lowest eigenvalue is 9.639724 (Trefethen and Betcke, 2006)."""
    corner = Refinement(np.array([[0.0, 0.0]]), 0.004, 0.2)
    outline = polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)])
    mesh = triangulate(outline, size=0.1, refinements=[corner])
    space = Space(mesh, Lagrange(2))
    values, shapes = modes(space, stiffness(space), mass(space), 3, space.boundary_dofs())
    print(f"lowest eigenvalue {values[0]:.4f}, third {values[2]:.4f}")
    assert abs(values[0] - 9.639724) < 2e-3
    return draw(mesh, shapes[0][: mesh.n_points], colours="plasma")
