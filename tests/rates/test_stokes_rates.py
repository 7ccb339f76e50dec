"""The divergence-free virtual element: patch test, order k + 1 in L2, inf-sup constants, incompressible elasticity."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.forms import stokes, stokes_matrix
from flangeway.mesh import rectangle_grid
from flangeway.space import Space
from studies.forms import KINDS, flow, flow_force, mapped, membrane, square_of


def pressure(p):
    return np.cos(2.0 * p[:, 0]) * p[:, 1] - np.sin(2.0) / 4.0


@pytest.mark.parametrize(("kind", "order"), [("triangles", 3), ("duals", 4), ("not convex", 2)])
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
