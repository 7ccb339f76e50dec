"""Kirchhoff's plate of class C1: patch test, published orders of errors and eigenvalues, supports, wrong input."""

import numpy as np
import pytest

from flangeway.elements import monomials
from flangeway.errors import InputError
from flangeway.forms import Plate, modes, solve
from flangeway.geometry import circle
from flangeway.mesh import curved, rectangle_grid, triangulate
from studies.forms import KINDS, plate_curvature, plate_pressure, square_of

CLAMPED = 35.98519, 73.39377, 73.39377
"""Frequencies of the clamped unit square, by Ritz's method in `studies.forms` with more polynomials."""


def deflection(p):
    return (1.0 - np.cos(2.0 * np.pi * p)).prod(axis=1) / 4.0


@pytest.mark.parametrize(("kind", "order"), [("triangles", 3), ("duals", 2), ("not convex", 2)])
def test_errors_and_eigenvalues_have_their_published_order(kind, order):
    """Second derivatives like h^(k - 1) within 0.3, deflection and eigenvalues like h^(2 k - 2) within 0.7."""
    errors, sizes = [], []
    for n in {"triangles": (16, 32), "duals": (8, 16), "not convex": (7, 13)}[kind]:
        mesh = square_of(kind, n)
        plate = Plate(mesh, order)
        stiffness, held = plate.stiffness(), plate.boundary_dofs()
        found = solve(stiffness, plate.load(plate_pressure), held)
        points, weights, value, second = plate.at_quadrature(found, 2 * order + 2)
        in_second = np.sqrt(weights @ ((second - plate_curvature(points)) ** 2).sum(axis=(1, 2)))
        in_value = np.sqrt(weights @ (value - deflection(points)) ** 2)
        clamped = np.sqrt(modes(plate, stiffness, plate.mass(), 3, held)[0])
        simple = np.sqrt(modes(plate, stiffness, plate.mass(), 1, plate.boundary_dofs("simple"))[0])
        errors.append((in_second, in_value, abs(clamped[0] / CLAMPED[0] - 1.0), abs(simple[0] / (2 * np.pi**2) - 1.0)))
        sizes.append(np.sqrt(mesh.cell_areas.mean()))
        np.testing.assert_allclose(clamped, CLAMPED, rtol=0.1)
    rates = np.diff(np.log(errors), axis=0)[0] / np.diff(np.log(sizes))
    np.testing.assert_array_less([order - 1.3, *[2 * order - 2.7] * 3], rates)
    assert (np.array(errors[-1][2:]) < (2e-2 if order == 2 else 4e-4)).all()


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_polynomials_are_exact_and_a_free_plate_has_three_motions(kind, order):
    """A polynomial of degree k given along the boundary is found inside; three eigenvalues of a free plate are zero."""
    plate = Plate(square_of(kind, 4), order, rigidity=3.0, poisson=0.2)
    stiffness = plate.stiffness()
    cubic = 0.0 if order == 2 else 1.0

    def polynomial(p):
        x, y = p.T
        return 1.0 + x - 2.0 * y + x**2 + 3.0 * x * y - y**2 + cubic * (x**3 - 2.0 * x * y**2)

    held = plate.boundary_dofs()
    # the unknowns of a polynomial, cell by cell, from its fit with monomials
    values = np.zeros(plate.n_dofs)
    for cells in plate.cells():
        points = cells.batch.vertices.mean(axis=0) + np.random.default_rng(1).uniform(-0.1, 0.1, (20, 2, 1))
        at = np.moveaxis(cells_monomials(cells, points, order), -1, 0)
        fitted = [
            np.linalg.lstsq(a.T, polynomial(p), rcond=None)[0]
            for a, p in zip(at, np.moveaxis(points, -1, 0), strict=True)
        ]
        values[cells.numbers] = np.einsum("iae,ea->ie", cells.dofs, np.array(fitted))
    load = plate.load(lambda p: 0.0 * p[:, 0])
    found = solve(stiffness, load, held, values)
    np.testing.assert_allclose(found, values, atol=1e-9)
    eigenvalues = np.linalg.eigvalsh(stiffness.toarray())
    assert np.abs(eigenvalues[:3]).max() < 1e-10 * eigenvalues[-1]
    assert eigenvalues[3] > 1e-7 * eigenvalues[-1]


def cells_monomials(cells, points, order):
    """Monomials at points (n, 2, e) in the frame of cells."""
    return monomials.evaluate(order, cells.frame.local(points))


WRONG = {
    "order 4": lambda m: Plate(m, 4),
    "curved": lambda _: Plate(curved(triangulate(circle(1.0), size=0.5), circle(1.0))),
    "rigidity": lambda m: Plate(m, rigidity=0.0),
    "poisson": lambda m: Plate(m, poisson=1.0),
    "'clamped' or 'simple'": lambda m: Plate(m).boundary_dofs("hinged"),
    "singular": lambda m: solve(Plate(m).stiffness(), Plate(m).load(1.0)),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    with pytest.raises(InputError, match=words):
        WRONG[words](rectangle_grid(1.0, 1.0, 2, 2))
