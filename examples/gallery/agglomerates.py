"""Cells that are not convex: triangles are joined, and refined again (mVEM)."""

from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Space, Virtual, triangulate
from flangeway.forms import interpolate, solve, stiffness
from flangeway.geometry import circle
from flangeway.mesh import agglomerated, refined


def main() -> Figure:
    """A quadratic polynomial without source is exact on them."""
    coarse = agglomerated(triangulate(circle(1.0), size=0.08), 60)
    mesh = refined(coarse, coarse.cell_centroids[:, 0] > 0.2)
    space = Space(mesh, Virtual(2))
    values = interpolate(space, lambda p: p[:, 0] ** 2 - p[:, 1] ** 2)
    u = solve(stiffness(space), 0.0 * values, space.boundary_dofs(), values)
    print(f"{mesh.n_cells} cells of up to {mesh.cell_sizes.max()} points, error {abs(u - values).max():.1e}")
    assert abs(u - values).max() < 1e-9
    return draw(mesh)
