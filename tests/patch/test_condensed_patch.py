"""Static condensation loses no digits near nu = 1/2 and at high order, on convex and other cells."""

import numpy as np
import pytest
import scipy.sparse.linalg as sla

from flangeway.elements import Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.problems import Elasticity
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway_studies.cook import cook_grid, solve_cook
from tests.given_displacement import bounded
from tests.patch.test_elasticity_patch import polynomial
from tests.rates.test_virtual_variants import stars


def zigzag_mesh() -> PolyMesh:
    """Two by two cells of a square that meet along zigzag lines."""
    half = [(0.0, 0.0), (0.125, 0.09), (0.25, 0.0), (0.375, -0.09), (0.5, 0.0)]
    along = np.array([*half, *[(x + 0.5, y) for x, y in half[1:]]])
    lines = {"x": np.add(along, (0.0, 0.5)), "y": np.add(along[:, ::-1], (0.5, 0.0))}
    points = np.vstack([[(0, 0), (0.5, 0), (1, 0), (0, 1), (0.5, 1), (1, 1)], lines["x"], lines["y"]])
    points, number = np.unique(np.round(points, 12), axis=0, return_inverse=True)
    number = number.ravel()
    x, y = number[6:15], number[15:]
    a, b, c, d, e, f = number[:6]
    cells = [
        [a, b, *y[1:5], *x[3::-1]],
        [b, c, *x[:3:-1], *y[3:0:-1]],
        [*x[:5], *y[5:], d],
        [*x[4:], f, e, *y[7:4:-1]],
    ]
    assert e == y[-1]
    return PolyMesh(points, np.cumsum([0, *map(len, cells)]), np.concatenate(cells))


MESHES = {
    "squares": lambda: rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals"),
    "zigzag": zigzag_mesh,
    "stars": lambda: stars(2),
    "duals": lambda: dual(triangulate(square(1.0, (0.5, 0.5)), size=0.3)),
}


def patch(mesh: PolyMesh, order: int, poisson: float) -> tuple[Elasticity, np.ndarray]:
    """The problem of a polynomial of the order, given on the boundary, and its values at the nodes."""
    exact, _, second = polynomial(order, centre=0.5)
    material = Elastic(1.0, poisson)
    space = Space(mesh, Virtual(order))
    problem = bounded(space, material, exact, lambda p: -np.einsum("ijkl,nklj->ni", material.stiffness, second(p)))
    return problem, exact(space.nodes)


def uncondensed(problem: Elasticity, values: np.ndarray) -> np.ndarray:
    """Displacements of all unknowns by SuperLU, without condensation, from values at the nodes of the boundary."""
    stiffness = problem.stiffness().full().tocsc()
    held = np.unique(problem.space.edge_nodes(problem.space.mesh.edge_set("boundary")))
    free = np.ones(stiffness.shape[0], dtype=bool)
    free[2 * held] = free[2 * held + 1] = False
    u = np.zeros(len(free))
    u[: values.size] = values.ravel()
    u[free] = 0.0
    scale = 1.0 / np.sqrt(stiffness.diagonal()[free])
    matrix = (stiffness[free][:, free] * scale).T * scale
    rhs = problem.load_vector().ravel() - stiffness @ u
    u[free] = scale * sla.splu(matrix.tocsc()).solve(scale * rhs[free])
    return u.reshape(-1, 2)


@pytest.mark.parametrize("poisson", [0.499999, 0.499999999])
@pytest.mark.parametrize("order", [3, 4])
def test_cook_does_not_depend_on_how_near_a_half_is(order: int, poisson: float) -> None:
    """From nu = 0.4999 on, the energy of Cook's membrane hardly changes; it grew threefold."""
    energy = solve_cook(Space(cook_grid(8), Virtual(order)), poisson).energy
    limit = solve_cook(Space(cook_grid(8), Virtual(order)), 0.4999).energy
    assert energy == pytest.approx(limit, rel=2e-3)
    assert abs(energy - 1321.6) < 10.0


@pytest.mark.parametrize("poisson", [0.3, 0.499999999])
@pytest.mark.parametrize(("name", "order"), [("squares", 6), ("zigzag", 4), ("stars", 3), ("stars", 6)])
def test_condensed_and_full_solution_agree(name: str, order: int, poisson: float) -> None:
    """Both reproduce a polynomial with the same digits: 1e-9 at nu = 0.3, and one less for each decade to 1/2."""
    problem, exact = patch(MESHES[name](), order, poisson)
    condensed = solve_elasticity(problem).displacements
    full = uncondensed(problem, exact)
    scale = np.abs(exact).max()
    worst = [np.abs(u[: len(exact)] - exact).max() / scale for u in (condensed, full)]
    assert worst[0] < 3.0 * worst[1] + 1e-13
    assert worst[0] < (1e-13 if order < 6 else 1e-11) / (1.0 - 2.0 * poisson) * 20.0


@pytest.mark.parametrize(
    ("name", "order", "allowed"),
    [(name, *each) for name in ("zigzag", "stars") for each in ((8, 1e-6), (10, 2e-3))] + [("duals", 10, 1e-10)],
)
def test_high_orders_pass_the_patch_test(name: str, order: int, allowed: float) -> None:
    """What the docstring of `Virtual` states for high orders holds on any cells; dual polygons keep ten digits."""
    problem, exact = patch(MESHES[name](), order, 0.3)
    found = solve_elasticity(problem).displacements[: len(exact)]
    assert np.abs(found - exact).max() < allowed * np.abs(exact).max()
