"""Orders of the variants of virtual elements on families of polygons, and around a refined singularity."""

import numpy as np
import pytest

from flangeway.elements import Serendipity, StabilisationFree, Virtual
from flangeway.errors import InputError
from flangeway.forms import convergence, error_norms, interpolate, load, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, agglomerated, dual, rectangle_grid, triangulate, voronoi
from flangeway.problems import Elasticity
from flangeway.space import Space
from flangeway_studies.forms import LAST, OPTIMAL, corner_errors
from tests.given_displacement import solved
from tests.rates import test_elasticity_rates as elastic


def stars(n):
    """Unit square of n by n squares, each with a star that is not convex and four kites in its corners."""
    numbers, cells = {}, []

    def number(x, y):
        return numbers.setdefault((round(x / n, 12), round(y / n, 12)), len(numbers))

    for i in range(n):
        for j in range(n):
            tips = [number(i + a, j + b) for a, b in ((0.5, 0.0), (1.0, 0.5), (0.5, 1.0), (0.0, 0.5))]
            corners = [number(i + a, j + b) for a, b in ((1, 0), (1, 1), (0, 1), (0, 0))]
            dents = [number(i + a, j + b) for a, b in ((0.65, 0.35), (0.65, 0.65), (0.35, 0.65), (0.35, 0.35))]
            cells.append([point for pair in zip(tips, dents, strict=True) for point in pair])
            cells += [[tips[q], corners[q], tips[(q + 1) % 4], dents[q]] for q in range(4)]
    return PolyMesh.from_cells(list(numbers), cells)


def triangles(size):
    return triangulate(square(1.0, (0.5, 0.5)), size=size)


@pytest.fixture(scope="module")
def families():
    return {
        "dual": [dual(triangles(size)) for size in (0.1, 0.055)],
        "voronoi": [voronoi(square(1.0, (0.5, 0.5)), n) for n in (40, 160)],
        "stars": [stars(n) for n in (3, 6)],
        "agglomerated": [agglomerated(triangles(0.5 / n), n * n) for n in (6, 14)],
    }


ORDERS = {"dual": (1, 2, 3), "voronoi": (1, 2, 3), "stars": (1, 2, 3), "agglomerated": (1, 2, 3)}
VARIANTS = {
    "virtual": (Virtual, ORDERS),
    "serendipity": (Serendipity, ORDERS),
    "serendipity, four lines": (lambda k: Serendipity(k, lines=4), ORDERS | {"stars": (2, 3), "agglomerated": (3,)}),
    "stabilisation-free": (StabilisationFree, ORDERS),
}
"""Elements, and the orders that they have on each family; the energy converges like h^k."""

CASES = [
    (variant, name, order)
    for variant, (_, orders) in VARIANTS.items()
    for name, order in (("voronoi", 1), ("dual", 2), ("stars", 3), ("agglomerated", 1))
    if order in orders[name]
]


def poisson_error(space):
    def exact(p):
        return np.sin(2.0 * p[:, 0] + 0.3) * np.exp(p[:, 1])

    def gradient(p):
        x, y = p.T
        return np.exp(y)[:, None] * np.stack((2.0 * np.cos(2.0 * x + 0.3), np.sin(2.0 * x + 0.3)), axis=1)

    matrix, forces = stiffness(space), load(space, lambda p: 3.0 * exact(p))
    return error_norms(space, solve(matrix, forces, space.boundary_dofs(), interpolate(space, exact)), exact, gradient)


def elastic_error(space):
    material = elastic.MATERIAL
    matrix, forces = Elasticity(space, material).stiffness().full(), load(space, elastic.body_force)
    found = solve(matrix, forces, space.boundary_dofs(), interpolate(space, elastic.exact))
    return error_norms(space, found, elastic.exact, elastic.gradient, coefficient=material.stiffness)


@pytest.mark.parametrize(("variant", "name", "order"), CASES)
def test_the_energy_converges_with_the_order(families, variant, name, order):
    """The rate of the energy's error is k within 0.25, for one field and for a displacement."""
    element = VARIANTS[variant][0](order)
    rates = convergence(lambda mesh: {"error": poisson_error(Space(mesh, element)).h1}, families[name])
    assert rates.columns["error rate"][1] == pytest.approx(order, abs=0.25)
    rates = convergence(lambda mesh: {"error": elastic_error(Space(mesh, element)).energy}, families[name])
    assert rates.columns["error rate"][1] == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("element", [Serendipity(2), Serendipity(3), StabilisationFree(1), StabilisationFree(3)])
def test_elastic_bodies_pass_the_patch_test(families, element):
    """A displacement of degree k, prescribed on the boundary without forces, is found to round-off, on stars too."""

    def exact(p):
        return p @ np.array([[0.1, 0.3], [0.2, -0.2]]) + [1.0, 2.0]

    for name in ("voronoi", "stars"):
        space = Space(families[name][0], element)
        found = solved(space, elastic.MATERIAL, exact).displacements
        np.testing.assert_allclose(found, interpolate(space, exact), atol=1e-10)


def test_serendipity_has_fewer_unknowns_and_on_triangles_those_of_lagrange():
    """Per cell: dimension of the polynomials of degree k - lines; order 3 on triangles has the ten of Lagrange."""
    assert [Serendipity(k).n_interior() for k in (1, 2, 3, 4, 5)] == [0, 0, 1, 3, 6]
    assert [Serendipity(k, lines=4).n_interior() for k in (3, 4, 5)] == [0, 1, 3]
    space = Space(rectangle_grid(1.0, 1.0, 1, 1, cells="triangles"), Serendipity(3))
    assert [len(batch.dofs) for batch in space.batches()] == [10]
    reconstruction = Serendipity(4, lines=4).reconstruct(np.array([[0, 0], [2, 0], [2.5, 1], [0, 1.0]])[:, :, None])
    identity = np.einsum("aie,ibe->abe", reconstruction.value, reconstruction.monomial_dofs)[:, :, 0]
    np.testing.assert_allclose(identity, np.eye(15), atol=1e-12)


DART = [[0.0, 0.0], [2.0, -1.0], [np.sqrt(5.0) - 1.0, 0.0], [2.0, 1.0]]
"""The product of its four lines has the mean zero, so that a multiple of it escapes boundary values and the mean."""
HANGING = [[0.0, 0.0], [0.3, 0.0], [0.5, 0.0], [0.7, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]

TURN = np.arange(32) * np.pi / 16.0
OCTAGON = np.column_stack((np.cos(TURN[::4]), np.sin(TURN[::4])))


def one_cell(points, element):
    return Space(PolyMesh.from_cells(points, [range(len(points))]), element)


WRONG = {
    r"Serendipity\(order=0\)": lambda: Serendipity(0),
    r"Serendipity\(order=11\)": lambda: Serendipity(11),
    r"Serendipity\(lines=2\)": lambda: Serendipity(2, lines=2),
    r"StabilisationFree\(order=4\)": lambda: StabilisationFree(4),
    r"StabilisationFree\(degree=0\)": lambda: StabilisationFree(2, degree=0),
    "a cell with 3 vertices": lambda: one_cell([[0, 0], [1, 0], [0, 1]], Serendipity(3, lines=4)),
    "on 4 different lines": lambda: stiffness(one_cell(HANGING, Serendipity(3, lines=5))),
    "1 motions without energy besides the 1": lambda: stiffness(one_cell(OCTAGON, StabilisationFree(1, degree=2))),
    "besides the 3 rigid ones": lambda: stiffness(one_cell(HANGING, StabilisationFree(1, degree=1)), np.eye(3)),
    "takes degree 15": lambda: one_cell(np.column_stack((np.cos(TURN), np.sin(TURN))), StabilisationFree(1)),
    "determine the polynomials": lambda: stiffness(one_cell(DART, Serendipity(4, lines=4))),
}


@pytest.mark.parametrize("words", WRONG)
def test_what_a_variant_does_not_have_is_refused(words):
    """Orders, lines and degrees that do not exist, or do not suffice for a cell, are errors that name them."""
    with pytest.raises(InputError, match=words):
        WRONG[words]()


@pytest.mark.parametrize(
    ("domain", "order"),
    [
        ("L-shape, not convex", 1),
        *(pytest.param(*case, marks=pytest.mark.ci) for case in (("L-shape, duals", 4), ("slit, not convex", 3))),
    ],
)
def test_errors_fall_with_the_unknowns_to_minus_half_the_order(domain, order):
    """``r^a sin(a phi)``: the error of the gradient falls like ``n^(-k / 2)`` (order 2: `reproduce forms`)."""
    sizes, errors = corner_errors(domain, order)
    rate = np.polyfit(np.log(sizes[-LAST:]), np.log(errors[-LAST:]), 1)[0]
    assert rate < -OPTIMAL * order / 2.0
