"""Static condensation loses no digits near nu = 1/2 and at high order, on convex and other cells."""

import math

import numpy as np
import pytest
import scipy.sparse.linalg as sla

from flangeway.cases.bodies.cook import cook_grid, solve_cook
from flangeway.elements import Virtual
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.problems import BodyForce, Elasticity, PrescribedDisplacement
from flangeway.solve import solve_elasticity
from flangeway.space import Space


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


def star_mesh() -> PolyMesh:
    """Two by two squares, each of them a star with four tips and the four triangles between these."""
    cells: list[np.ndarray] = []
    for corner in np.ndindex(2, 2):
        low = np.array(corner) / 2.0
        tips = low + np.array([(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)])
        dents = low + 0.25 + 0.1 * np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])
        cells.append(np.stack((tips, dents), axis=1).reshape(-1, 2))
        cells += [np.array([tips[i], tips[(i + 1) % 4], dents[i]]) for i in range(4)]
    points, number = np.unique(np.round(np.vstack(cells), 12), axis=0, return_inverse=True)
    return PolyMesh(points, np.cumsum([0, *map(len, cells)]), number.ravel())


MESHES = {
    "squares": lambda: rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals"),
    "zigzag": zigzag_mesh,
    "stars": star_mesh,
}


def polynomial(order: int):
    """A displacement of a degree, and a function of points for each of its derivatives."""
    powers = [(total - j, j) for total in range(order + 1) for j in range(total + 1)]
    coefficients = np.random.default_rng(order).normal(size=(2, len(powers)))

    def derivative(points: np.ndarray, dx: int, dy: int) -> np.ndarray:
        x, y = 2.0 * points.T - 1.0
        result = np.zeros((len(points), 2))
        for column, (a, b) in zip(coefficients.T, powers, strict=True):
            if a >= dx and b >= dy:
                factor = 2.0 ** (dx + dy) * math.perm(a, dx) * math.perm(b, dy)
                result += factor * (x ** (a - dx) * y ** (b - dy))[:, None] * column
        return result

    return derivative


def patch(mesh: PolyMesh, order: int, poisson: float) -> tuple[Elasticity, np.ndarray]:
    """The problem of a polynomial of the order, given on the boundary, and its values at the nodes."""
    derivative = polynomial(order)
    material = Elastic(1.0, poisson)

    def force(points: np.ndarray) -> np.ndarray:
        mixed = derivative(points, 1, 1)
        second = np.array([[derivative(points, 2, 0), mixed], [mixed, derivative(points, 0, 2)]])
        return -np.einsum("ijkl,ljnk->ni", material.stiffness, second)

    space = Space(mesh.with_edge_set("boundary", mesh.boundary_edges), Virtual(order))
    support = PrescribedDisplacement(
        "boundary", lambda points: derivative(points, 0, 0)[:, 0], lambda points: derivative(points, 0, 0)[:, 1]
    )
    problem = Elasticity(space, material, loads=[BodyForce(force)], supports=[support])
    return problem, derivative(space.nodes, 0, 0)


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


@pytest.mark.parametrize(("order", "allowed"), [(8, 1e-6), (10, 2e-3)])
@pytest.mark.parametrize("name", ["zigzag", "stars"])
def test_high_orders_pass_the_patch_test(name: str, order: int, allowed: float) -> None:
    """What the docstring of `Virtual` states for high orders holds on convex and other cells."""
    problem, exact = patch(MESHES[name](), order, 0.3)
    found = solve_elasticity(problem).displacements[: len(exact)]
    assert np.abs(found - exact).max() < allowed * np.abs(exact).max()
