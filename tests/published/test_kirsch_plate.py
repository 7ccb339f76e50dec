"""Kirsch's plate with a hole: a quarter of it with the exact tractions on its outer sides."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, TraceStabilisation, Virtual
from flangeway.exact import PlateWithHole
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.post import recovered_stresses, stresses_along
from flangeway.problems import Elasticity, PrescribedDisplacement, Traction
from flangeway.solve import solve_elasticity
from flangeway.space import Space

EXACT = PlateWithHole(radius=1.0, tension=5.0)
SIDE = 4.0


def plate(n: int) -> PolyMesh:
    """A quarter of a square with a hole, in 2 n^2 triangles that grow outwards; the arc is named left."""
    grid = rectangle_grid(1.0, 1.0, n, n)
    share, angle = grid.points[:, 0] ** 1.5, grid.points[:, 1] * np.pi / 2.0
    direction = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    outer = SIDE / direction.max(axis=1)
    points = (1.0 + share * (outer - 1.0))[:, None] * direction
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)


def traction(points: np.ndarray) -> np.ndarray:
    """Exact tractions on the right and on the upper side."""
    stress = EXACT.stresses(points)
    on_right = np.isclose(points[:, 0], SIDE)
    return np.where(on_right[:, None], stress[:, [0, 2]], stress[:, [2, 1]])


@pytest.mark.parametrize(("method", "n"), [("fem", 32), ("vem", 64)])
def test_stress_concentration(method: str, n: int) -> None:
    """The peak at the hole is three times the tension, and stresses above it and displacements Kirsch's, to 0.5 %."""
    mesh = plate(n) if method == "fem" else dual(plate(n))
    element = Lagrange(2) if method == "fem" else Virtual(2, TraceStabilisation())
    material = Elastic(1000.0, 0.3)
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    problem = Elasticity(Space(mesh, element), material, loads=[Traction("right", traction)], supports=supports)
    solution = solve_elasticity(problem)
    top = problem.node_at((0.0, 1.0))
    assert recovered_stresses(solution).nodal.components[top, 0] == pytest.approx(15.0, rel=5e-3)
    line = stresses_along(solution, (1e-6, 1.1), (1e-6, SIDE), 30)
    assert line.stresses.components[:, 0] == pytest.approx(EXACT.stresses(line.points)[:, 0], rel=5e-3)
    exact = EXACT.displacements(problem.space.nodes, material.shear_modulus, 3.0 - 4.0 * 0.3)
    error = solution.displacements[: problem.space.n_nodes] - exact
    assert np.abs(error).max() < 5e-3 * np.abs(exact).max()
