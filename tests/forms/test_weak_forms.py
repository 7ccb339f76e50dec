"""Forms as functions of values and gradients: the same as ready-made ones, and problems with known solutions."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, StabilisationFree, Virtual
from flangeway.errors import InputError
from flangeway.forms import (
    Field,
    bilinear,
    buckling,
    interpolate,
    linear,
    load,
    mass,
    modes,
    newmark_steps,
    newton,
    stiffness,
    theta_steps,
)
from flangeway.geometry import rectangle, square
from flangeway.materials import Elastic
from flangeway.mesh import agglomerated, dual, triangulate
from flangeway.space import Space

TRIANGLES = triangulate(square(1.0, (0.5, 0.5)), size=0.2)
MESHES = {
    "triangles": TRIANGLES,
    "duals": dual(TRIANGLES),
    "agglomerates": agglomerated(triangulate(square(1.0, (0.5, 0.5)), size=0.1), 40),
}
SPACES = [
    pytest.param(Space(TRIANGLES, Lagrange(2)), id="lagrange-2"),
    pytest.param(Space(MESHES["duals"], Virtual(1)), id="virtual-1"),
    pytest.param(Space(MESHES["agglomerates"], Virtual(3)), id="virtual-3"),
    pytest.param(Space(MESHES["duals"], StabilisationFree(2)), id="stabilisation-free-2"),
]
TENSOR = Elastic(1.0, 0.3).stiffness


def dot(a, b):
    return (a * b).sum(axis=-1)


def laplace(u, v, w):
    return dot(u.gradient, v.gradient)


@pytest.mark.parametrize("space", SPACES)
def test_forms_at_points_are_the_ready_made_ones(space):
    """Stiffness, mass, elasticity, springs along an edge and loads agree with `stiffness`, `mass` and `load`."""

    def elastic(u, v, w):
        return np.einsum("ijkl,nkl,nij->n", TENSOR, u.gradient, v.gradient)

    def reaction(u, v, w):
        return u.value * v.value

    pairs = [
        (bilinear(space, laplace), stiffness(space)),
        (bilinear(space, reaction), mass(space)),
        (bilinear(space, elastic, components=2), stiffness(space, TENSOR)),
        (bilinear(space, reaction, on="right"), mass(space, on="right")),
    ]
    for general, special in pairs:
        assert abs(general - special).max() < 1e-12 * abs(special).max()
    for on in (None, "top"):
        vector = linear(space, lambda v, w: np.sin(w.points[:, 0]) * v.value, on=on)
        np.testing.assert_allclose(vector, load(space, lambda p: np.sin(p[:, 0]), on=on), atol=1e-15)


@pytest.mark.parametrize("space", SPACES)
def test_a_field_has_its_polynomial_at_any_point(space):
    """A complex polynomial of the order of the space and its gradient are exact at points and in integrals."""
    k = space.order
    factors = np.array([1.0, 2.0])

    def wanted(p):
        return np.stack(((0.3 + p @ factors) ** k, p[:, 0]), axis=1)

    field = Field(space, interpolate(space, wanted) * (1.0 + 2.0j))
    points = np.random.default_rng(0).random((50, 2))
    np.testing.assert_allclose(field.at(points), (1.0 + 2.0j) * wanted(points), atol=1e-11)
    slope = k * (0.3 + points @ factors) ** (k - 1)
    np.testing.assert_allclose(field.gradient_at(points)[:, 0], (1.0 + 2.0j) * slope[:, None] * factors, atol=1e-9)
    at, weights, values = field.at_quadrature()
    assert weights.sum() == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(values.value, (1.0 + 2.0j) * wanted(at), atol=1e-11)
    np.testing.assert_allclose(values.gradient[:, 1].real, np.broadcast_to([1.0, 0.0], (len(at), 2)), atol=1e-9)
    with pytest.raises(InputError, match="outside"):
        field.at([[2.0, 0.0]])


def quasilinear(u, v, w):
    """``-div((1 + u^2) grad u) = f`` with the solution ``1 + x + 2 y``."""
    exact = 1.0 + w.points @ np.array([1.0, 2.0])
    source = -2.0 * exact * 5.0
    return (1.0 + u.value**2) * dot(u.gradient, v.gradient) - source * v.value


@pytest.mark.parametrize("space", SPACES[:2])
def test_newtons_method_finds_the_exact_solution_and_converges_quadratically(space):
    """A quasilinear equation with a linear solution is solved exactly, with tangents by complex steps and by hand."""
    exact = interpolate(space, lambda p: 1.0 + p @ np.array([1.0, 2.0]))
    boundary = space.boundary_dofs()
    start = np.zeros(space.n_dofs)
    start[boundary] = exact[boundary]

    def tangent(d, v, w):
        u = w.u
        return (1.0 + u.value**2) * dot(d.gradient, v.gradient) + 2.0 * u.value * d.value * dot(u.gradient, v.gradient)

    for given in (None, tangent):
        solution = newton(space, quasilinear, start, fixed=boundary, tangent=given, tolerance=1e-12)
        assert solution.status.converged
        # constants are all that order 1 sees of the gradient of v, while 1 + u^2 varies
        tolerance = 0.05 if space.element == Virtual(1) else 1e-9
        np.testing.assert_allclose(solution.dofs, exact, atol=tolerance)
        a, b, c = solution.residuals[-4:-1]
        assert c < 100.0 * b * (b / a)  # at least as fast as a falling ratio


def test_a_wrong_tangent_and_a_form_that_is_not_analytic_are_refused():
    """A tangent without its second term, and ``abs`` of a complex number, differ from the differences."""
    space = Space(MESHES["duals"], Virtual(1))
    start = np.zeros(space.n_dofs)
    start[space.boundary_dofs()] = 1.0 + space.nodes[space.boundary_dofs(), 0]
    common = {"fixed": space.boundary_dofs(), "degree": 4}
    with pytest.raises(InputError, match="tangent"):
        newton(space, quasilinear, start, tangent=lambda d, v, w: (1.0 + w.u.value**2) * laplace(d, v, w), **common)
    with pytest.raises(InputError, match="by hand"):
        newton(space, lambda u, v, w: (1.0 + 3.0 * abs(u.value)) * laplace(u, v, w) - 40.0 * v.value, start, **common)


def test_radiation_along_an_edge_balances_the_source():
    """A boundary form in Newton's method: ``u^4`` integrated over the side is the source's integral."""
    space = Space(MESHES["duals"], Virtual(2))
    radiation = {"right": lambda u, v, w: u.value**4 * v.value}
    start = np.ones(space.n_dofs)
    start[space.n_nodes :] = interpolate(space, lambda p: np.ones(len(p)))[space.n_nodes :]
    solution = newton(space, laplace, start, load=load(space, 3.0), boundary=radiation)
    assert solution.status.converged
    field = {"u": Field(space, solution.dofs)}
    flow = linear(space, lambda v, w: w.u.value**4 * v.value, on="right", fields=field)
    assert flow.sum() == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_newmarks_method_keeps_the_energy_and_generalised_alpha_damps(space):
    """500 steps of a free wave: energy to 1e-10; with radius 0 and steps that do not resolve it, it decays."""
    K, M, fixed = stiffness(space), mass(space), space.boundary_dofs()
    start = interpolate(space, lambda p: np.exp(-30.0 * ((p - 0.4) ** 2).sum(axis=1)))
    start[fixed] = 0.0

    def energy(u, v):
        return 0.5 * (u @ (K @ u) + v @ (M @ v))

    first = energy(start, 0.0 * start)
    energies = [energy(u, v) for _, u, v in newmark_steps(M, K, start, 0.0 * start, 0.01, 500, fixed=fixed)]
    np.testing.assert_allclose(energies, first, rtol=1e-10)
    damped = [energy(u, v) for _, u, v in newmark_steps(M, K, start, 0.0 * start, 1.0, 30, radius=0.0, fixed=fixed)]
    assert damped[-1] < 1e-6 * first


@pytest.mark.parametrize("space", SPACES)
def test_schroedingers_equation_keeps_the_norm_of_complex_fields(space):
    """``u' = -i K u`` by Crank and Nicolson's method: its own factor of each mode, and the norm of any start."""
    K, M, fixed = stiffness(space), mass(space), space.boundary_dofs()
    (value,), (mode,) = modes(space, K, M, 1, fixed)
    *_, (end, u) = theta_steps(M, 1j * K, 1j * mode, 0.01, 20, fixed=fixed)
    assert end == pytest.approx(0.2)
    np.testing.assert_allclose(u, 1j * mode * ((1.0 - 0.005j * value) / (1.0 + 0.005j * value)) ** 20, atol=1e-11)
    start = interpolate(space, lambda p: np.exp(-30.0 * ((p - 0.4) ** 2).sum(axis=1))) * (1.0 + 2.0j)
    start[fixed] = 0.0
    *_, (_, u) = theta_steps(M, 1j * K, start, 0.01, 20, fixed=fixed)
    assert np.vdot(u, M @ u).real == pytest.approx(np.vdot(start, M @ start).real, rel=1e-11)
    *_, (_, wave, _) = newmark_steps(M, K, start, 0.0 * start, 0.01, 20, fixed=fixed)
    *_, (_, real, _) = newmark_steps(M, K, start.real, 0.0 * start.real, 0.01, 20, fixed=fixed)
    np.testing.assert_allclose(wave, (1.0 + 2.0j) * real, atol=1e-11)


def test_generalised_alpha_has_second_order():
    """One degree of freedom with damping and load: the error falls four times when the step is halved."""
    one = stiffness(Space(TRIANGLES, Lagrange(1)))[:1, :1]
    one = one / one.max()
    rate = np.sqrt(1.0 - 0.1**2)
    wanted = np.exp(-0.1 * 3.0) * (np.cos(rate * 3.0) + 0.1 / rate * np.sin(rate * 3.0))
    errors = []
    for number in (120, 240):
        steps = newmark_steps(one, one, np.ones(1), np.zeros(1), 3.0 / number, number, damping=0.2 * one, radius=0.5)
        errors.append(abs(list(steps)[-1][1][0] - wanted))
    assert 3.7 < errors[0] / errors[1] < 4.3


@pytest.mark.parametrize("order", [2, 4])
def test_a_column_buckles_at_eulers_load(order):
    """A cantilever of slenderness 20 under pressure at its end: ``pi^2 E I / (2 L)^2`` to 2 % (shear and width)."""
    length, height = 20.0, 1.0
    space = Space(dual(triangulate(rectangle(length, height), size=0.5)), Virtual(order))
    material = Elastic(1000.0, 0.0)
    fixed = space.boundary_dofs("left")

    def geometric(u, v, w):  # stress xx of -1
        return -dot(u.gradient[:, :, 0], v.gradient[:, :, 0])

    K = stiffness(space, material.stiffness)
    factors, shapes = buckling(space, K, bilinear(space, geometric, components=2, stabilise=False), 1, fixed)
    assert factors[0] * height == pytest.approx(np.pi**2 * 1000.0 / 12.0 / (2 * length) ** 2, rel=0.02)
    assert np.sqrt(shapes[0].ravel() @ (K @ shapes[0].ravel())) == pytest.approx(1.0, rel=1e-8)


def test_an_interface_form_joins_what_lies_on_both_sides():
    """Pairs of points inside of the mesh: the integral of 1 along them is their length."""
    mesh = MESHES["duals"]
    inner = mesh.edges[(mesh.edge_cells >= 0).all(axis=1)][:7]
    space = Space(mesh, Virtual(2))
    length = np.hypot(*(mesh.points[inner[:, 1]] - mesh.points[inner[:, 0]]).T).sum()
    ones = interpolate(space, lambda p: np.ones(len(p)))
    matrix = bilinear(space, lambda u, v, w: u.value * v.value, on=inner)
    assert ones @ (matrix @ ones) == pytest.approx(length, rel=1e-12)
    with pytest.raises(InputError, match="gradient"):
        bilinear(space, laplace, on=inner)


def test_wrong_forms_are_named():
    """An integrand of the wrong shape, unknowns of another space, and spaces of two meshes are refused."""
    space = Space(MESHES["duals"], Virtual(1))
    with pytest.raises(InputError, match="integrand"):
        bilinear(space, lambda u, v, w: u.gradient * v.gradient)
    with pytest.raises(InputError, match="unknowns"):
        Field(space, np.zeros(3))
    with pytest.raises(InputError, match="mesh"):
        bilinear(space, lambda u, v, w: u.value * v.value, test=Space(MESHES["agglomerates"], Virtual(1)))
