"""A rubber block with a hole is squeezed by a seventh (FElupe: hole in a block)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.geometry import circle, square
from flangeway.materials import NeoHooke
from flangeway.mesh import dual, triangulate
from flangeway.problems import Elasticity, PrescribedDisplacement, fixed
from flangeway.solve import solve_nonlinear


def main() -> Figure:
    """The hole closes to an ellipse; the reaction pushes back."""
    mesh = dual(triangulate(square(2.0), size=0.16, holes=[circle(0.5)]))
    rubber = NeoHooke(fw.Elastic(1.0, 0.45))
    supports = [fixed("bottom"), PrescribedDisplacement("top", x=0.0, y=-0.3)]
    problem = Elasticity(fw.Space(mesh, fw.Virtual(2)), rubber.elastic, supports=supports)
    *_, last = solve_nonlinear(problem, rubber, np.linspace(0.1, 1.0, 10).tolist())
    assert last.status.converged
    force = last.nodal_forces[problem.space.boundary_dofs("top"), 1].sum()
    print(f"force {force:.4f}")
    assert force < -0.1
    moved = last.displacements[: mesh.n_points]
    return draw(mesh, np.hypot(*moved.T), moved=moved, colours="magma")
