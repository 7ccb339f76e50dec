"""A thick cylinder yields from inside (Hill 1950): plasticity with radial return."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.materials import J2Plasticity
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import solve_nonlinear


def main() -> Figure:
    """At a pressure of 0.17 the steel is plastic up to the radius at which Hill's formula gives this pressure."""
    grid, steel = rectangle_grid(1.0, 1.0, 12, 24), J2Plasticity(fw.Elastic(210.0, 0.3), 0.24)
    radius, angle = 1.0 + grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)
    mesh = dual(PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets))
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    problem = Elasticity(fw.Space(mesh, fw.Virtual(2)), steel.elastic, loads=[Pressure("left", 1.0)], supports=supports)
    *_, last = solve_nonlinear(problem, steel, [0.13, 0.17])
    plastic = np.linalg.norm(last.points[last.history[:, 4] > 0.0], axis=1).max()
    pressure = 0.24 / np.sqrt(3.0) * (1.0 - plastic**2 / 4.0 + 2.0 * np.log(plastic))
    print(f"plastic up to radius {plastic:.3f}, where Hill's pressure is {pressure:.4f}")
    assert abs(pressure - 0.17) < 3e-3
    return draw(mesh, np.hypot(*last.displacements[: mesh.n_points].T), colours="inferno")
