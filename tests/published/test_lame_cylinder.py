"""Lame's thick cylinder under internal pressure, as a quarter in plane strain and as a body of revolution."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.exact import ThickCylinder
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.post import recovered_stresses, stresses_at
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space

EXACT = ThickCylinder(inner_radius=1.0, outer_radius=2.0, inner_pressure=10.0)
YOUNG, POISSON = 1000.0, 0.3
ELEMENTS = {"fem": Lagrange(2), "vem": Virtual(2)}


def quarter(n: int, method: str) -> ElasticitySolution:
    """A quarter in plane strain with n cells across the wall and 3 n around."""
    grid = rectangle_grid(1.0, 1.0, n, 3 * n)
    radius, angle = 1.0 + grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)
    mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)
    mesh = dual(mesh) if method == "vem" else mesh
    symmetry = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    material = Elastic(YOUNG, POISSON)
    space = Space(mesh, ELEMENTS[method])
    return solve_elasticity(Elasticity(space, material, loads=[Pressure("left", 10.0)], supports=symmetry))


def ring(n: int, method: str) -> ElasticitySolution:
    """A slice of the body of revolution that cannot lengthen."""
    mesh = rectangle_grid(1.0, 0.5, n, n // 2, origin=(1.0, 0.0))
    mesh = dual(mesh) if method == "vem" else mesh
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", y=0.0)]
    material = Elastic(YOUNG, POISSON, "axisymmetric")
    space = Space(mesh, ELEMENTS[method])
    return solve_elasticity(Elasticity(space, material, loads=[Pressure("left", 10.0)], supports=held))


@pytest.mark.parametrize("method", sorted(ELEMENTS))
@pytest.mark.parametrize(("make", "n"), [(quarter, 16), (ring, 16)])
def test_lame(make, n: int, method: str) -> None:
    """Displacements of both walls, stresses in the middle, and recovered ones inside are Lame's within 0.1 %."""
    solution = make(n, method)
    radii = np.array([1.0, 2.0])
    computed = [solution.displacement_at_node((r, 0.0))[0] for r in radii]
    assert computed == pytest.approx(EXACT.radial_displacement(radii, YOUNG, POISSON), rel=1e-3)
    hoop = 3 if solution.problem.axisymmetric else 1
    recovered = recovered_stresses(solution).nodal.components
    inside = recovered[solution.problem.node_at((1.0, 0.0))]
    assert inside[hoop] == pytest.approx(EXACT.hoop_stress(1.0), rel=1e-3)
    middle = stresses_at(solution, [(1.5, 0.01)]).components[0]
    assert middle[hoop] == pytest.approx(EXACT.hoop_stress(1.5), rel=1e-3)
    assert inside[0] == pytest.approx(-10.0, rel=2e-3)


def test_nearly_incompressible_cylinder() -> None:
    """With nu = 0.4999 order 2 still gives the inner wall's displacement within 0.1 %."""
    mesh = dual(rectangle_grid(1.0, 0.5, 16, 8, origin=(1.0, 0.0)))
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", y=0.0)]
    material = Elastic(YOUNG, 0.4999, "axisymmetric")
    problem = Elasticity(Space(mesh, Virtual(2)), material, loads=[Pressure("left", 10.0)], supports=held)
    computed = solve_elasticity(problem).displacement_at_node((1.0, 0.0))[0]
    assert computed == pytest.approx(EXACT.radial_displacement(np.array(1.0), YOUNG, 0.4999), rel=1e-3)
