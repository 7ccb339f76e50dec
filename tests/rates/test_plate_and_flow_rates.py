"""Kirchhoff's plate of class C1 and divergence-free flows: patch tests, published orders, locking, wrong input."""

import numpy as np
import pytest

from flangeway.elements import Virtual, monomials
from flangeway.errors import InputError
from flangeway.forms import Plate, modes, solve, stokes, stokes_matrix
from flangeway.geometry import circle
from flangeway.mesh import curved, rectangle_grid, triangulate
from flangeway.space import Space
from flangeway_studies.forms import (
    KINDS,
    flow,
    flow_force,
    mapped,
    membrane,
    plate_curvature,
    plate_pressure,
    square_of,
)

CLAMPED = 35.98519, 73.39377, 73.39377
"""Frequencies of the clamped unit square, by Ritz's method in `flangeway_studies.forms` with more polynomials."""


def deflection(p):
    return (1.0 - np.cos(2.0 * np.pi * p)).prod(axis=1) / 4.0


@pytest.mark.parametrize(
    ("kind", "order"), [("triangles", 3), ("duals", 2), pytest.param("not convex", 2, marks=pytest.mark.ci)]
)
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


def pressure(p):
    return np.cos(2.0 * p[:, 0]) * p[:, 1] - np.sin(2.0) / 4.0


@pytest.mark.parametrize(
    ("kind", "order"), [("triangles", 3), ("duals", 4), pytest.param("not convex", 2, marks=pytest.mark.ci)]
)
def test_velocity_and_pressure_have_their_order_and_nothing_flows_off(kind, order):
    """L2 errors fall like h^(k + 1) and h^k, within 10 % or 0.35; the divergence is round-off at every point."""
    errors, sizes = [], []
    for n in (3, 7) if order == 4 else (5, 12):
        mesh = square_of(kind, n)
        points, weights, u, gradient, p = stokes(mesh, order, flow_force, velocity=flow).at_quadrature(2 * order + 2)
        in_velocity = np.sqrt(weights @ ((u - flow(points)) ** 2).sum(axis=1))
        errors.append((in_velocity, np.sqrt(weights @ (p - pressure(points)) ** 2)))
        sizes.append(np.sqrt(mesh.cell_areas.mean()))
        assert np.abs(np.einsum("nii->n", gradient)).max() < 1e-10
    rates = np.diff(np.log(errors), axis=0)[0] / np.diff(np.log(sizes))
    assert rates[0] > order + 0.65
    assert rates[1] > 0.9 * order - 0.15


@pytest.mark.parametrize("kind", KINDS)
def test_a_polynomial_is_found_exactly_with_tractions_on_a_side(kind):
    """Quadratic velocity and linear pressure, one side under their traction: to 1e-9, mean of the pressure included."""
    mu = 2.5

    def exact(p):
        x, y = p.T
        return np.stack((x**2 + 2 * y**2 - x, -2 * x * y + y + 3.0 * x**2), axis=1)

    def stress_on_the_right(p):  # sigma . (1, 0) with pressure 3 x - y + 2
        x, y = p.T
        return np.stack((2 * mu * (2 * x - 1) - (3 * x - y + 2), mu * (4 * y - 2 * y + 6 * x)), axis=1)

    mesh = square_of(kind, 4)
    space = Space(mesh, Virtual(2))
    held = space.boundary_dofs(lambda p: p[:, 0] < 1.0 - 1e-9)
    held = np.union1d(
        held, space.boundary_dofs(lambda p: (p[:, 0] > 1 - 1e-9) & ((p[:, 1] < 1e-9) | (p[:, 1] > 1 - 1e-9)))
    )
    body = (3.0 - mu * 6.0, -1.0 - mu * 6.0)
    found = stokes(mesh, 2, body, viscosity=mu, velocity=exact, held=held, tractions={"right": stress_on_the_right})
    points, _, u, _, p = found.at_quadrature(4)
    np.testing.assert_allclose(u, exact(points), atol=1e-9)
    np.testing.assert_allclose(p, 3 * points[:, 0] - points[:, 1] + 2, atol=1e-8)


def test_a_pressure_that_balances_a_force_moves_nothing():
    """A force that is a gradient gives a pressure and no velocity, for any viscosity."""
    mesh = square_of("duals", 6)
    found = stokes(mesh, 2, lambda p: np.stack((3.0 * p[:, 0] ** 2, 1e3 * p[:, 1]), axis=1), viscosity=1e-6)
    _, _, u, _, p = found.at_quadrature(4)
    assert np.abs(u).max() < 1e-6
    assert np.ptp(p) > 400.0


def test_cooks_membrane_does_not_lock():
    """For nu = 0.4999 and 1/2 the work of the load is within 0.7 % of the reference for 0.4999, 2652.36."""
    mesh = mapped("duals", 16, 16, membrane)
    held = Space(mesh, Virtual(2)).boundary_dofs("left")
    for poisson in (0.4999, 0.5):
        shear = 70.0 / (2.0 * (1.0 + poisson))
        bulk = 2.0 * shear * poisson / (1.0 - 2.0 * poisson) if poisson < 0.5 else np.inf
        found = stokes(mesh, 2, viscosity=shear, bulk_modulus=bulk, held=held, tractions={"right": (0.0, 6.25)})
        matrix = stokes_matrix(found.space, shear, bulk)
        unknowns = np.concatenate((found.velocity.ravel(), found.inside.ravel(), found.pressure.ravel()))
        n_velocities = found.velocity.size + found.inside.size
        work = unknowns[:n_velocities] @ (matrix @ unknowns)[:n_velocities]
        assert work == pytest.approx(2652.36, rel=7e-3)


WRONG = {
    "order 4": lambda m: Plate(m, 4),
    "curved": lambda _: Plate(curved(triangulate(circle(1.0), size=0.5), circle(1.0))),
    "rigidity": lambda m: Plate(m, rigidity=0.0),
    "poisson": lambda m: Plate(m, poisson=1.0),
    "'clamped' or 'simple'": lambda m: Plate(m).boundary_dofs("hinged"),
    "singular": lambda m: solve(Plate(m).stiffness(), Plate(m).load(1.0)),
    "order": lambda m: stokes(m, 1),
    "viscosity": lambda m: stokes(m, 2, viscosity=0.0),
    "bulk_modulus": lambda m: stokes(m, 2, bulk_modulus=-1.0),
    "changes the volume": lambda m: stokes(m, 2, velocity=lambda p: p),
    "not numbers": lambda m: stokes(m, 2, "up"),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    with pytest.raises(InputError, match=words):
        WRONG[words](rectangle_grid(1.0, 1.0, 2, 2))
