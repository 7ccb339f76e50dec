"""Cook's membrane (Moherdaui 2021, 5.2.2) with numbers of Artioli et al. (2017), and a nearly incompressible one."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.post import displacements_at
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space

ENERGY, MIDDLE, CORNER = 1542.159, 30.7494, 32.3007
METHODS = {"fem": Lagrange, "vem": Virtual}
REFERENCE = 2652.36  # work of the load for nu = 0.4999: orders 3 and 4 on finer meshes agree on it


def membrane(n: int, method: str) -> PolyMesh:
    """Cook's trapezium in n by n halved quadrilaterals, or their dual polygons.

    They are drawn towards the left and right sides and the top, since stresses grow without limit at the corner (0, 44)
    and the shear on the right does not fit the free top at (48, 60).
    """
    grid = rectangle_grid(1.0, 1.0, n, n)
    s, t = grid.points.T
    s, t = (1.0 - np.cos(np.pi * s)) / 2.0, np.sin(np.pi * t / 2.0)
    points = np.stack((48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s)), axis=1)
    mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)
    return dual(mesh) if method == "vem" else mesh


def cook(n: int, method: str, order: int, poisson: float) -> ElasticitySolution:
    """The membrane held on the left, with a force of 6.25 per length upwards on the right."""
    space = Space(membrane(n, method), METHODS[method](order))
    material = Elastic(70.0, poisson)
    return solve_elasticity(
        Elasticity(space, material, loads=[Traction("right", (0.0, 6.25))], supports=[fixed("left")])
    )


def vertical(solution: ElasticitySolution, y: float) -> float:
    """Vertical displacement on the right edge."""
    return float(displacements_at(solution, [(48.0, y)])[0, 1])


@pytest.mark.parametrize("method", sorted(METHODS))
def test_order_2_reaches_the_published_numbers(method: str) -> None:
    """Energy and both displacements come within 0.1 % on the finest mesh, and every refinement makes them better."""
    errors = []
    for n in (8, 16, 32, 64):
        solution = cook(n, method, 2, 1.0 / 3.0)
        computed = np.array([solution.energy, vertical(solution, 52.0), vertical(solution, 60.0)])
        errors.append(np.abs(computed / np.array([ENERGY, MIDDLE, CORNER]) - 1.0))
    assert (errors[-1] < 1e-3).all()
    assert (np.diff(np.array(errors), axis=0) < 0.0).all()


@pytest.mark.parametrize("method", sorted(METHODS))
def test_order_1_converges_to_the_same(method: str) -> None:
    """Linear elements have a larger error than quadratic ones of a quarter of the cells, and it falls, below 3 %."""
    errors = [abs(cook(n, method, 1, 1.0 / 3.0).energy / ENERGY - 1.0) for n in (16, 32, 64)]
    assert abs(cook(16, method, 2, 1.0 / 3.0).energy / ENERGY - 1.0) < errors[1]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.03


def test_twice_the_energy_is_the_work_of_the_load() -> None:
    """The published 1542.159 is the strain energy: half of the load times the displacement."""
    solution = cook(16, "fem", 2, 1.0 / 3.0)
    assert solution.load_work == pytest.approx(2.0 * solution.energy, rel=1e-9)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_order_2_does_not_lock(method: str) -> None:
    """With nu = 0.4999, order 2 is within 1 % of a fine reference of order 3."""
    assert cook(32, method, 2, 0.4999).load_work == pytest.approx(REFERENCE, rel=0.01)


def test_the_reference_is_one() -> None:
    """Order 3 on polygons and on triangles gives the reference within 0.05 %."""
    for method in METHODS:
        assert cook(32, method, 3, 0.4999).load_work == pytest.approx(REFERENCE, rel=5e-4)


def test_linear_triangles_lock_and_polygons_do_not() -> None:
    """With nu = 0.4999 and order 1, triangles give less than half of the reference, polygons 90 % of it or more."""
    assert cook(32, "fem", 1, 0.4999).load_work < 0.5 * REFERENCE
    assert cook(32, "vem", 1, 0.4999).load_work > 0.9 * REFERENCE
