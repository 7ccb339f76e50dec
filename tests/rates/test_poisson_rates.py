"""Orders of convergence on Poisson's equation with a smooth solution: H1 order k, L2 order k + 1."""

import numpy as np
import pytest

from flangeway._core import Cholesky
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, check, dual, rectangle_grid, triangulate
from flangeway.post import error_norms
from flangeway.problems import Torsion
from flangeway.space import Space, load_vector


def solution(points):
    x, y = points.T
    return np.sin(np.pi * x) * np.sin(np.pi * y)


def gradient(points):
    x, y = np.pi * points.T
    return np.pi * np.column_stack((np.cos(x) * np.sin(y), np.sin(x) * np.cos(y)))


def bent_grid(n):
    """Unit square of n by n squares, every other one cut by a bent line: its neighbours get hanging nodes."""
    numbers = {}

    def number(x, y):
        return numbers.setdefault((round(x, 9), round(y, 9)), len(numbers))

    cells = []
    for i in range(n):
        for j in range(n):
            west, middle, east = i / n, (i + 0.5) / n, (i + 1) / n
            south, north = j / n, (j + 1) / n
            cut = (i + j) % 2 == 0
            below = j > 0 or cut
            above = j < n - 1 or cut
            if cut:
                inner = number((i + 0.75) / n, (j + 0.4) / n)
                bottom, top = number(middle, south), number(middle, north)
                cells.append([number(west, south), bottom, inner, top, number(west, north)])
                cells.append([bottom, number(east, south), number(east, north), top, inner])
            else:
                corners = [(west, south), (middle, south), (east, south), (east, north), (middle, north), (west, north)]
                keep = [True, below, True, True, above, True]
                cells.append([number(*c) for c, k in zip(corners, keep, strict=True) if k])
    offsets = np.cumsum([0] + [len(cell) for cell in cells])
    return PolyMesh(np.array(list(numbers)), offsets, np.concatenate(cells))


def delaunay(n):
    return triangulate(square(1.0, (0.5, 0.5)), size=1.0 / n)


FAMILIES = {
    "dual polygons": (lambda n: dual(delaunay(n)), Virtual),
    "virtual triangles": (delaunay, Virtual),
    "bent cells with hanging nodes": (bent_grid, Virtual),
    "Lagrange triangles": (delaunay, Lagrange),
}
LAGRANGE_4 = ("Lagrange triangles", 4)  # there is none


def solve(space):
    problem = Torsion(space, formulation="prandtl")
    load = load_vector(space, lambda points: 2.0 * np.pi**2 * solution(points))
    free = np.ones(space.n_dofs, dtype=np.bool_)
    free[space.edge_nodes(problem.boundary.outer)] = False
    matrix = problem.stiffness().restricted(free)
    groups = np.arange(matrix.n, dtype=np.int32)
    factor = Cholesky(matrix.indptr, matrix.indices, matrix.values, groups, np.empty(0, dtype=np.int32))
    dofs = np.zeros(space.n_dofs)
    dofs[free] = factor.solve(load[free])
    return dofs


def errors(family, order, n):
    make, element = FAMILIES[family]
    space = Space(make(n), element(order))
    norms = error_norms(space, solve(space), solution, gradient)
    return norms.h1, norms.l2, 1.0 / np.sqrt(space.mesh.n_cells)


@pytest.mark.parametrize(
    ("family", "order"),
    [(family, order) for family in sorted(FAMILIES) for order in (1, 4) if (family, order) != LAGRANGE_4],
)
def test_errors_fall_with_the_order_of_the_element(family, order):
    """The H1 error falls like h^k and the L2 error like h^(k + 1), within 0.3 in the exponent or faster."""
    coarse, fine = errors(family, order, 8), errors(family, order, 20)
    rate_h1, rate_l2 = (np.log(coarse[i] / fine[i]) / np.log(coarse[2] / fine[2]) for i in range(2))
    assert order - 0.3 < rate_h1 < order + 0.7
    assert order + 1 - 0.3 < rate_l2 < order + 1 + 0.7


def test_bent_grid_is_a_sound_mesh_with_cells_that_are_not_convex():
    """The mesh with hanging nodes covers the unit square and has cells with a reentrant corner and straight corners."""
    mesh = bent_grid(4)
    check(mesh)
    assert mesh.cell_areas.sum() == pytest.approx(1.0)
    turns = []
    for cell in range(mesh.n_cells):
        p = mesh.points[mesh.cell_points[mesh.cell_offsets[cell] : mesh.cell_offsets[cell + 1]]]
        a, b = p - np.roll(p, 1, axis=0), np.roll(p, -1, axis=0) - p
        turns.append(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    turns = np.concatenate(turns)
    assert np.sum(turns < -1e-6) == 8
    assert np.sum(np.abs(turns) < 1e-12) > 8


@pytest.mark.parametrize("order", [1, 2, 3])
def test_mixed_triangles_and_polygons_converge_too(order):
    """Lagrange triangles beside virtual quadrilaterals in one space keep the orders."""
    results = []
    for n in (8, 16):
        left = rectangle_grid(0.5, 1.0, n // 2, n)
        right = rectangle_grid(0.5, 1.0, n // 2, n, cells="quadrilaterals", origin=(0.5, 0.0))
        mesh = glued(left, right)
        space = Space(mesh, {"left": Lagrange(order), "right": Virtual(order)})
        norms = error_norms(space, solve(space), solution, gradient)
        results.append((norms.h1, norms.l2))
    rate_h1, rate_l2 = np.log2(np.divide(*results))
    assert rate_h1 > order - 0.25
    assert rate_l2 > order + 1 - 0.25


def glued(left, right):
    """One mesh of two, with points at the same place made one."""
    points = np.vstack((left.points, right.points))
    unique, number = np.unique(np.round(points, 12), axis=0, return_inverse=True)
    cells = number.ravel()[np.concatenate((left.cell_points, right.cell_points + left.n_points))]
    offsets = np.concatenate((left.cell_offsets, right.cell_offsets[1:] + left.cell_offsets[-1]))
    sets = {"left": np.arange(left.n_cells), "right": left.n_cells + np.arange(right.n_cells)}
    return PolyMesh(unique, offsets, cells, sets)
