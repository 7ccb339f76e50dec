"""A rubber block is pulled to one and a half times its length (FElupe's first example)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.geometry import square
from flangeway.materials import NeoHooke
from flangeway.mesh import voronoi
from flangeway.problems import Elasticity, PrescribedDisplacement, fixed
from flangeway.solve import solve_nonlinear


def main() -> Figure:
    """Compressible neo-Hooke material at finite strain on Voronoi cells, in five steps."""
    mesh, rubber = voronoi(square(1.0), 150), NeoHooke(fw.Elastic(1.0, 0.4))
    supports = [fixed("left"), PrescribedDisplacement("right", x=0.5, y=0.0)]
    problem = Elasticity(fw.Space(mesh, fw.Virtual(2)), rubber.elastic, supports=supports)
    path = solve_nonlinear(problem, rubber, [0.2, 0.4, 0.6, 0.8, 1.0])
    forces = [step.nodal_forces[problem.space.boundary_dofs("right"), 0].sum() for step in path]
    print("force", *np.round(forces, 4))
    assert all(step.status.converged for step in path)
    assert forces[-1] > 0.4
    moved = path[-1].displacements[: mesh.n_points]
    return draw(mesh, np.hypot(*moved.T), moved=moved)
