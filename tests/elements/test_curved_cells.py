"""Integrals over polygons and over cells with curved edges, and what their elements reproduce."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual, monomials, polygon_quadrature
from flangeway.elements.projection import CurvedPolygons, outline_frame
from flangeway.elements.quadrature import gauss_lobatto


def sector(order: int, opening: float = 0.7, inner: float = 0.0) -> np.ndarray:
    """Outline (n, order, 2, 1) of a sector of the unit disc, or of a ring: one of its arcs bends inwards."""
    places = gauss_lobatto(order + 1)[0][:-1, None]

    def arc(radius: float, start: float, end: float) -> np.ndarray:
        angle = start + places * (end - start)
        return radius * np.hstack((np.cos(angle), np.sin(angle)))

    a, b = np.array([1.0, 0.0]), np.array([np.cos(opening), np.sin(opening)])
    sides = [inner * a + places * (1.0 - inner) * a, arc(1.0, 0.0, opening), b - places * (1.0 - inner) * b]
    if inner:
        sides.append(arc(inner, opening, 0.0))
    return np.stack(sides)[..., None]


@pytest.mark.parametrize("inner", [0.0, 0.5])
@pytest.mark.parametrize("degree", [0, 3, 8])
def test_polynomials_are_integrated_exactly_on_sectors(degree: int, inner: float) -> None:
    """On arcs of 40 degrees as polynomials of degree 10, integrals of x^a y^b are those of the true sector to 1e-13."""
    points, weights = polygon_quadrature(sector(10, inner=inner), degree)
    phi, phi_weights = np.polynomial.legendre.leggauss(30)
    phi, phi_weights = 0.35 * (phi + 1.0), 0.35 * phi_weights
    for a in range(degree + 1):
        b = degree - a
        exact = np.sum(phi_weights * np.cos(phi) ** a * np.sin(phi) ** b) * (1.0 - inner ** (degree + 2)) / (degree + 2)
        found = np.sum(weights * points[:, 0] ** a * points[:, 1] ** b)
        assert abs(found - exact) < 1e-13
    assert weights.min() > 0.0


def test_a_cell_with_a_deep_arc_is_integrated_with_points_beside_its_polygon() -> None:
    """Where triangles about the middle fold over, the area is still exact: a ring's sector that is nearly a half."""
    outline = sector(10, opening=2.8, inner=0.8)
    _, weights = polygon_quadrature(outline, 2)
    assert weights.min() < 0.0
    assert abs(weights.sum() - 1.4 * 0.36) < 1e-6


@pytest.mark.parametrize(
    "element", [Virtual(2), Virtual(3), Virtual(4), Virtual(5), Virtual(6), Lagrange(2), Lagrange(3)]
)
def test_linear_functions_are_their_own_projections(element) -> None:
    """Value, L2 projection and gradient of x and y are exact to round-off, and moments are those of the quadrature."""
    outline = sector(element.order, inner=0.0 if isinstance(element, Lagrange) else 0.5)
    cell = element.reconstruct(outline)
    linear = cell.monomial_dofs[:, :3]
    wanted = np.eye(cell.value.shape[0])[:, :3, None]
    for projection in (cell.value, cell.projected_value):
        assert np.abs(np.einsum("ame,mbe->abe", projection, linear) - wanted).max() < 1e-10
    slopes = np.einsum("aime,mbe->aibe", cell.gradient, linear)
    assert np.abs(slopes[1:]).max(initial=0.0) < 1e-9
    assert np.abs(slopes[0, :, 1:, 0] - cell.frame.map[..., 0].T).max() < 1e-10 * np.abs(cell.frame.map).max()
    points, weights = polygon_quadrature(outline, 2 * element.order)
    moments = np.einsum("aqe,qe->ae", monomials.evaluate(2 * element.order, cell.frame.local(points)), weights)
    assert np.abs(moments - cell.moments).max() < 1e-12 * np.abs(moments).max()


@pytest.mark.parametrize("order", [2, 3, 4])
def test_straight_edges_give_the_straight_element(order: int) -> None:
    """An outline whose points are on straight edges has the matrices of the polygon."""
    vertices = np.array([[0.0, 0.0], [2.0, 0.1], [2.2, 1.4], [0.9, 1.1], [-0.3, 1.7]])[:, :, None]
    places = gauss_lobatto(order + 1)[0][:-1, None, None]
    outline = (1.0 - places) * vertices[:, None] + places * np.roll(vertices, -1, axis=0)[:, None]
    straight, bent = Virtual(order).reconstruct(vertices), Virtual(order).reconstruct(outline)
    ones = np.ones(1)
    energy = straight.gradient_energy(straight.gradient, ones)
    assert np.abs(bent.gradient_energy(bent.gradient, ones) - energy).max() < 1e-10 * np.abs(energy).max()
    assert np.abs(CurvedPolygons.of_outline(outline, outline_frame(outline)).moments[0] - straight.areas).max() < 1e-13


@pytest.mark.parametrize("order", [2, 3])
def test_isoparametric_triangles_miss_little_and_no_constant_gradient(order: int) -> None:
    """What the projected gradient misses costs no negative energy, none for linear functions, and some for others."""
    cell = Lagrange(order).reconstruct(sector(order))
    missed = cell.missed[..., 0]
    values = np.linalg.eigvalsh(missed)
    assert values.min() > -1e-12
    assert np.abs(missed @ cell.monomial_dofs[:, :3, 0]).max() < 1e-12
    whole = np.linalg.eigvalsh(cell.gradient_energy(cell.gradient, np.ones(1))[..., 0] + missed)
    assert 1e-6 < values.max() < 0.2 * whole.max()


@pytest.mark.parametrize("degree", [0, 1, 4, 7])
def test_polynomials_are_integrated_exactly_with_positive_weights_inside(ugly, degree):
    """Monomials up to the degree are exact; every weight is positive or of an empty triangle, every point inside."""
    points, weights = polygon_quadrature(ugly[:, :, None], degree)
    exact = monomials.integrals(degree, ugly[:, :, None], np.ones(1))
    values = monomials.evaluate(degree, points)
    scale = np.abs(values).max(axis=(1, 2)) * weights.sum()
    assert np.einsum("aqe,qe->a", values, weights) / scale == pytest.approx(exact[:, 0] / scale, abs=1e-13)
    assert weights.min() >= 0.0
    assert all(inside(ugly, p) for p in points[weights[:, 0] > 0.0, :, 0])


def inside(polygon, point):
    """Crossing number of a ray to the right."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    straddles = (start[:, 1] > point[1]) != (end[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = start[:, 0] + (point[1] - start[:, 1]) / (end[:, 1] - start[:, 1]) * (end[:, 0] - start[:, 0])
    return np.sum(straddles & (x > point[0])) % 2 == 1


def test_cells_of_a_batch_do_not_disturb_each_other():
    """A convex and a non-convex cell in one batch each get their own integral."""
    convex = np.array([(0, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2)], dtype=float)
    angle = np.array([(0, 0), (2, 0), (2, 1), (0.2, 1), (0.2, 2), (0, 2)], dtype=float)
    _, weights = polygon_quadrature(np.stack((convex, angle), axis=-1), 2)
    assert weights.sum(axis=0) == pytest.approx([4.0, 2.2], abs=1e-14)


def test_derivatives_agree_with_differences():
    """The derivative matrices give central differences of the values."""
    point, step = np.array([0.3, -0.7])[:, None], 1e-6
    for axis in range(2):
        shift = step * np.eye(2)[axis][:, None]
        slope = (monomials.evaluate(4, point + shift) - monomials.evaluate(4, point - shift)) / (2.0 * step)
        exact = monomials.derivatives(4)[axis].T @ monomials.evaluate(3, point)
        assert slope == pytest.approx(exact, abs=1e-9)


def test_integrals_over_the_unit_square_are_known():
    """The integral of x^a y^b over the unit square is 1 / ((a + 1)(b + 1))."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[:, :, None]
    powers = monomials.exponents(9)
    exact = 1.0 / ((powers[:, 0] + 1.0) * (powers[:, 1] + 1.0))
    assert monomials.integrals(9, square, np.ones(1))[:, 0] == pytest.approx(exact, rel=1e-13)
