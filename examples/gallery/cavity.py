"""Flow in a driven cavity, without divergence at any point (scikit-fem, example 18; PolyDiM's Stokes)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import triangulate
from flangeway.forms import stokes
from flangeway.geometry import square
from flangeway.mesh import dual
from flangeway.types import Floats


def lid(p: Floats) -> Floats:
    """Velocity on the boundary."""
    along = np.where(p[:, 1] > 1.0 - 1e-9, 16.0 * (p[:, 0] * (1.0 - p[:, 0])) ** 2, 0.0)
    return np.stack((along, np.zeros_like(along)), axis=1)


def main() -> Figure:
    """The lid moves as ``16 x^2 (1 - x)^2``; the velocity's divergence is round-off."""
    mesh = dual(triangulate(square(1.0, (0.5, 0.5)), size=0.06))
    flow = stokes(mesh, 2, velocity=lid)
    _, weights, _, gradient, _ = flow.at_quadrature(4)
    divergence = np.sqrt(weights @ np.einsum("nii->n", gradient) ** 2)
    print(f"divergence {divergence:.1e}, largest speed {np.hypot(*flow.velocity.T).max():.3f}")
    assert divergence < 1e-10
    return draw(mesh, np.hypot(*flow.velocity[: mesh.n_points].T))
