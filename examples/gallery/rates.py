"""Orders of convergence of virtual elements (PolyDiM's elliptic example)."""

from functools import partial

import numpy as np
from gallery_drawing import curves
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import convergence, error_norms, interpolate, load, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual
from flangeway.post import ErrorNorms
from flangeway.types import Floats


def exact(p: Floats) -> Floats:
    """The solution at points (n, 2)."""
    return np.asarray(np.sin(2.0 * p[:, 0]) * np.exp(p[:, 1]))


def gradient(p: Floats) -> Floats:
    """Its gradient, (n, 2)."""
    return np.exp(p[:, 1])[:, None] * np.stack((2.0 * np.cos(2.0 * p[:, 0]), np.sin(2.0 * p[:, 0])), axis=1)


def error(order: int, mesh: PolyMesh) -> ErrorNorms:
    """Errors of ``-div grad u = 3 u_exact``."""
    space = Space(mesh, Virtual(order))
    rhs = load(space, lambda p: 3.0 * exact(p))
    return error_norms(
        space, solve(stiffness(space), rhs, space.boundary_dofs(), interpolate(space, exact)), exact, gradient
    )


def main() -> Figure:
    """The H1 error on dual polygons falls like h^k for orders 1 to 4."""
    meshes, lines = [dual(triangulate(square(1.0), size=size)) for size in (0.2, 0.1, 0.05)], []
    for order in (1, 2, 3, 4):
        table = convergence(partial(error, order), meshes).columns
        print(f"order {order}: rate {table['h1 rate'][-1]}")
        assert table["h1 rate"][-1] > order - 0.2
        lines.append((table["h"], table["h1"], f"order {order}"))
    return curves(*lines, logarithmic=True, axes=("h", "H1 error"))
