"""Orders of convergence of plane elasticity with a smooth solution: H1 order k, L2 order k + 1."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, quadtree, rectangle_grid, triangulate
from flangeway.post import error_norms
from flangeway.space import Space
from tests.given_displacement import solved

MATERIAL = Elastic(1.0, 0.3)
A, B = 2.0, 1.5


def exact(points):
    """A smooth displacement (n, 2)."""
    x, y = points.T
    return np.stack((np.sin(A * x) * np.cos(B * y), np.cos(A * x + y)), axis=1)


def gradient(points):
    x, y = points.T
    first = np.stack((A * np.cos(A * x) * np.cos(B * y), -B * np.sin(A * x) * np.sin(B * y)), axis=1)
    second = -np.sin(A * x + y)[:, None] * np.array([A, 1.0])
    return np.stack((first, second), axis=1)


def body_force(points):
    """Minus the divergence of the stress."""
    x, y = points.T
    u, v = exact(points).T
    mixed = -A * B * np.cos(A * x) * np.sin(B * y)
    second = np.empty((len(points), 2, 2, 2))
    second[:, 0] = np.moveaxis(np.array([[-A * A * u, mixed], [mixed, -B * B * u]]), 2, 0)
    second[:, 1] = -v[:, None, None] * np.array([[A * A, A], [A, 1.0]])
    return -np.einsum("ijkl,nklj->ni", MATERIAL.stiffness, second)


def hanging(n):
    """Squares of which every other one is cut into four, so that its neighbours have hanging nodes."""
    return quadtree(1.0, 1.0, n, n, finer=lambda c, _: np.floor(c * n).sum(axis=1) % 2 == 0, levels=1)


def mixed(n):
    """Squares on the left, triangles on the right."""
    grid = rectangle_grid(1.0, 1.0, n, n, cells="quadrilaterals")
    corners = grid.cell_points.reshape(-1, 4)
    right = grid.cell_centroids[:, 0] > 0.5
    halves = corners[right][:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    sizes = np.concatenate((np.full((~right).sum(), 4), np.full(len(halves), 3)))
    return PolyMesh(
        grid.points,
        np.concatenate(([0], np.cumsum(sizes))),
        np.concatenate((corners[~right].ravel(), halves.ravel())),
        cell_sets={"polygons": np.flatnonzero(sizes == 4), "triangles": np.flatnonzero(sizes == 3)},
    )


def delaunay(n):
    return triangulate(square(1.0, (0.5, 0.5)), size=1.0 / n)


FAMILIES = {
    "Lagrange triangles": (delaunay, Lagrange),
    "virtual triangles": (delaunay, Virtual),
    "dual polygons": (lambda n: dual(delaunay(n)), Virtual),
    "hanging nodes": (hanging, Virtual),
    "mixed": (mixed, lambda k: {"polygons": Virtual(k), "triangles": Lagrange(k) if k < 4 else Virtual(k)}),
}
CASES = [(f, k) for f in FAMILIES for k in (1, 2, 3, 4) if (f, k) != ("Lagrange triangles", 4)]  # there is none


def errors(family, order, n):
    make, element = FAMILIES[family]
    mesh = make(n)
    solution = solved(Space(mesh, element(order)), MATERIAL, exact, body_force)
    space = solution.problem.space
    norms = [
        error_norms(
            space, solution.displacements[:, i], lambda p, i=i: exact(p)[:, i], lambda p, i=i: gradient(p)[:, i]
        )
        for i in range(2)
    ]
    return np.hypot(norms[0].h1, norms[1].h1), np.hypot(norms[0].l2, norms[1].l2), 1.0 / np.sqrt(mesh.n_cells)


@pytest.mark.parametrize(("family", "order"), CASES)
def test_errors_fall_with_the_order_of_the_element(family, order):
    """The H1 error falls like h^k and the L2 error like h^(k + 1), within 0.35 in the exponent or faster."""
    coarse, fine = errors(family, order, 6), errors(family, order, 16)
    rate_h1, rate_l2 = (np.log(coarse[i] / fine[i]) / np.log(coarse[2] / fine[2]) for i in range(2))
    assert order - 0.35 < rate_h1 < order + 1.0
    assert order + 1 - 0.35 < rate_l2 < order + 2.0
