"""Interpolation, loads and error norms of given functions."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.post import error_norms
from flangeway.space import Space, interpolate, load_vector

TRIANGLES = triangulate(square(1.0, (0.5, 0.5)), size=0.3)
ANGLE = PolyMesh([(0, 0), (2, 0), (2, 1), (0.3, 1), (0.3, 2), (0, 2)], [0, 6], [0, 1, 2, 3, 4, 5])
SPACES = [
    pytest.param(Space(mesh, element), id=f"{type(element).__name__}-{element.order}-{name}")
    for name, mesh, elements in (
        ("triangles", TRIANGLES, [Lagrange(1), Lagrange(2), Lagrange(3), Virtual(2)]),
        ("polygons", dual(TRIANGLES), [Virtual(1), Virtual(2), Virtual(3), Virtual(4)]),
        ("one cell that is not convex", ANGLE, [Virtual(1), Virtual(2), Virtual(4)]),
    )
    for element in elements
]


def power(order):
    """A polynomial of a degree and its gradient."""

    def value(points):
        x, y = points.T
        return (1.0 + x - 2.0 * y) ** order

    def slope(points):
        x, y = points.T
        return order * np.outer((1.0 + x - 2.0 * y) ** (order - 1), [1.0, -2.0])

    return value, slope


@pytest.mark.parametrize("space", SPACES)
def test_interpolation_of_polynomials_is_exact(space):
    """A polynomial of degree k is interpolated without error in L2 and H1."""
    value, slope = power(space.order)
    norms = error_norms(space, interpolate(space, value), value, slope)
    assert norms.relative_l2 < 1e-12
    assert norms.relative_h1 < 1e-12


@pytest.mark.parametrize("space", SPACES)
def test_load_times_a_polynomial_is_the_integral_of_the_product(space):
    """The load of a function, times the unknowns of a polynomial of degree k, is the integral of their product."""
    value, _ = power(space.order)
    unknowns = interpolate(space, value)
    load = load_vector(space, lambda points: points[:, 0] ** 2 + 1.0)
    zero = np.zeros(space.n_dofs)

    # |v|^2 through the norms: 4 (f, v) = |f + v|^2 - |f - v|^2
    def norm(sign):
        combined = lambda points: points[:, 0] ** 2 + 1.0 + sign * value(points)  # noqa: E731
        return error_norms(space, zero, combined, lambda points: points, degree=12).exact_l2 ** 2

    assert load @ unknowns == pytest.approx((norm(1.0) - norm(-1.0)) / 4.0, rel=1e-12)


def test_norms_of_the_exact_function_are_right():
    """The exact function's own norms: for x + y on the unit square L2 is sqrt(7/6), the gradient's sqrt(2)."""
    space = Space(dual(TRIANGLES), Virtual(1))
    norms = error_norms(space, np.zeros(space.n_dofs), lambda p: p.sum(axis=1), np.ones_like, coefficient=2.0)
    assert (norms.l2, norms.h1) == pytest.approx((np.sqrt(7.0 / 6.0), np.sqrt(2.0)), rel=1e-12)
    assert (norms.relative_l2, norms.relative_h1, norms.relative_energy) == pytest.approx((1.0, 1.0, 1.0))


def test_functions_of_wrong_shape_or_not_finite_are_refused():
    """A function with a wrong shape, or infinite somewhere, is refused with the place."""
    space = Space(TRIANGLES, Lagrange(1))
    with pytest.raises(InputError, match="shape"):
        interpolate(space, lambda points: points[:3, 0])
    with pytest.raises(InputError, match="not finite at"):
        interpolate(space, lambda points: np.where(points[:, 0] == 0.0, np.inf, 1.0))


def test_edge_unknowns_are_shared_by_neighbours():
    """Order 3: interpolation of a cubic on two cells agrees along their edge, whatever their direction."""
    space = Space(TRIANGLES, Virtual(3))
    value, _ = power(3)
    inner = np.argmax(space.mesh.edge_cells[:, 1] >= 0)
    pair = space.mesh.edges[inner : inner + 1]
    unknowns = interpolate(space, value)
    for ends in (pair, pair[:, ::-1]):
        nodes = space.edge_nodes(ends)[0]
        start, end = space.mesh.points[ends[0]]
        along = np.linalg.norm(space.nodes[nodes] - start, axis=1) / np.linalg.norm(end - start)
        assert np.all(np.diff(along) > 0.0)
        assert unknowns[nodes] == pytest.approx(value(space.nodes[nodes]))
