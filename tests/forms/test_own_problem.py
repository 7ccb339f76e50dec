"""Forms on any space: their rates, the same matrices as those of the elastic body, modes, coefficients, wrong input."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.forms import (
    Factor,
    Plate,
    bilinear,
    buckling,
    convergence,
    error_norms,
    interpolate,
    load,
    mass,
    modes,
    newton,
    solve,
    stiffness,
    stokes,
    theta_steps,
)
from flangeway.geometry import circle, square
from flangeway.materials import Elastic
from flangeway.mesh import curved, dual, rectangle_grid, triangulate
from flangeway.problems import Elasticity
from flangeway.space import Space

A = np.array([[3.0, 1.0], [1.0, 2.0]])
MATERIAL = Elastic(2.0, 0.3)


def triangles(n):
    return triangulate(square(1.0, (0.5, 0.5)), size=1.0 / n)


@pytest.fixture(scope="module")
def polygons():
    mesh = dual(triangles(4))
    return mesh.with_cell_set("low", mesh.cell_centroids[:, 1] < 0.5).with_cell_set(
        "high", mesh.cell_centroids[:, 1] >= 0.5
    )


def exact(p):
    return np.sin(2.0 * p[:, 0]) * np.exp(p[:, 1])


def gradient(p):
    return np.exp(p[:, 1])[:, None] * np.stack((2.0 * np.cos(2.0 * p[:, 0]), np.sin(2.0 * p[:, 0])), axis=1)


def varying(p):
    return (1.0 + p[:, 0])[:, None, None] * A


def source(p):
    """``-div((1 + x) A grad u) + (1 + y) u``."""
    x, y = p.T
    cos, exp = np.cos(2.0 * x) * np.exp(y), exact(p)
    second = 3.0 * -4.0 * exp + 2.0 * 2.0 * cos + 2.0 * exp
    first = 3.0 * 2.0 * cos + exp
    return -(1.0 + x) * second - first + (1.0 + y) * exp


@pytest.mark.parametrize(
    ("make", "element"),
    [(dual, Virtual(1)), (dual, Virtual(2)), (dual, Virtual(3)), (dual, Virtual(4)), (None, Lagrange(2))],
)
def test_errors_of_an_anisotropic_problem_with_varying_coefficients_fall_with_the_order(make, element):
    """With a matrix and a reaction that vary: energy and H1 like h^k, L2 like h^(k + 1), within 0.3 or faster."""

    def problem(mesh):
        space = Space(mesh, element)
        matrix = stiffness(space, varying) + mass(space, lambda p: 1.0 + p[:, 1])
        found = solve(matrix, load(space, source), space.boundary_dofs(), interpolate(space, exact))
        return error_norms(space, found, exact, gradient, coefficient=varying)

    table = convergence(problem, [make(triangles(n)) if make else triangles(n) for n in (5, 12)]).columns
    assert element.order - 0.3 < table["h1 rate"][1] < element.order + 0.8
    assert element.order - 0.3 < table["energy rate"][1] < element.order + 0.8
    assert element.order + 0.7 < table["l2 rate"][1] < element.order + 2.0
    assert "energy rate" in repr(convergence(lambda mesh: {"energy": mesh.cell_areas[0]}, [triangles(2), triangles(4)]))


@pytest.mark.parametrize("element", [Virtual(1), Virtual(3)])
def test_the_form_of_elasticity_is_that_of_the_elastic_body(polygons, element):
    """A user's matrix for strains and a material's tensor give the stiffness of `Elasticity`, to round-off."""
    space = Space(polygons, element)
    wanted = Elasticity(space, MATERIAL).stiffness().full()
    for given in (MATERIAL.matrix[:3, :3], MATERIAL.stiffness):
        assert abs(stiffness(space, given) - wanted).max() < 1e-12 * abs(wanted).max()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_linear_displacement_with_reaction_tractions_and_springs_is_found_exactly(polygons, order):
    """No unknown is fixed: volume forces, tractions on all sides and springs on one give the displacement."""
    space = Space(polygons, Virtual(order))
    slope = np.array([[0.1, 0.2], [-0.3, 0.4]])
    stress = np.einsum("ijkl,kl->ij", MATERIAL.stiffness, slope)

    def wanted(p):
        return p @ slope.T + [0.5, 0.6]

    sides = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "bottom": (0.0, -1.0), "top": (0.0, 1.0)}
    matrix = stiffness(space, MATERIAL.stiffness) + mass(space, 3.0 * np.eye(2))
    for springs in (2.0 * np.eye(2), lambda p: np.tile(2.0 * np.eye(2), (len(p), 1, 1))):
        forces = load(space, lambda p: 3.0 * wanted(p)) + load(space, lambda p: 2.0 * wanted(p), on="right")
        forces += sum(load(space, stress @ normal, on=side) for side, normal in sides.items())
        found = solve(matrix + mass(space, springs, on="right"), forces)
        np.testing.assert_allclose(found, interpolate(space, wanted), atol=1e-11)


def test_a_coefficient_of_cells_of_sets_and_of_points_is_the_same(polygons):
    """Three ways to give one coefficient, for a number and for a matrix: one matrix, to round-off."""
    space = Space(polygons, Virtual(2))
    low = polygons.cell_centroids[:, 1] < 0.5
    for form, tensor in ((stiffness, A), (mass, np.array(2.0))):
        of_cells = np.where(low.reshape(-1, *[1] * tensor.ndim), tensor, 5.0 * tensor)
        by_sets = form(space, {"low": tensor, "high": 5.0 * tensor})
        assert abs(form(space, of_cells) - by_sets).max() < 1e-14
    everywhere = stiffness(space, lambda p: np.broadcast_to(A, (len(p), 2, 2)))
    assert abs(everywhere - stiffness(space, A)).max() < 1e-12
    assert abs(mass(space, lambda p: 2.0 + 0.0 * p[:, 0]) - mass(space, 2.0)).max() < 1e-14


@pytest.mark.parametrize(("element", "tolerance"), [(Virtual(1), 0.04), (Virtual(3), 2e-5), (Lagrange(3), 2e-5)])
def test_the_modes_of_a_membrane_are_the_known_ones(element, tolerance):
    """Eigenvalues of the fixed unit square are pi^2 (m^2 + n^2); modes have unit mass and vanish on the boundary."""
    mesh = triangles(8)
    space = Space(dual(mesh) if isinstance(element, Virtual) else mesh, element)
    weight = mass(space)
    values, found = modes(space, stiffness(space), weight, 4, space.boundary_dofs())
    np.testing.assert_allclose(values, np.pi**2 * np.array([2.0, 5.0, 5.0, 8.0]), rtol=tolerance)
    np.testing.assert_allclose(found @ (weight @ found.T), np.eye(4), atol=1e-10)
    assert not found[:, space.boundary_dofs()].any()


def test_the_boundary_is_found_by_name_and_by_place():
    """All boundary points, those of a side by name and by a function, corners included."""
    space = Space(rectangle_grid(1.0, 1.0, 3, 3), Lagrange(2))
    assert len(space.boundary_dofs()) == 24
    np.testing.assert_array_equal(space.boundary_dofs("left"), space.boundary_dofs(lambda p: p[:, 0] == 0.0))
    assert len(space.boundary_dofs("left")) == 7


def advection(space):
    """Not symmetric."""
    return bilinear(space, lambda u, v, w: 9.0 * u.gradient[:, 0] * v.value)


WRONG = {
    "not symmetric": lambda s: stiffness(s, [[1.0, 2.0], [0.0, 1.0]]),
    "not positive": lambda s: stiffness(s, [[1.0, 2.0], [2.0, 1.0]]),
    "coefficient of shape": lambda s: stiffness(s, np.eye(4)),
    "for 9 cells": lambda s: stiffness(s, np.ones(4)),
    "not finite": lambda s: mass(s, np.nan),
    "in 0 of the given cell sets": lambda s: mass(
        s.__class__(s.mesh.with_cell_set("a", [0, 1]), s.element), {"a": 1.0}
    ),
    "of cells along edges": lambda s: mass(s, np.ones(9), on="left"),
    "0 of 12 boundary points": lambda s: s.boundary_dofs(lambda p: p[:, 0] < -1.0),
    "singular": lambda s: solve(stiffness(s), load(s, 1.0)),
    "a matrix of shape": lambda s: solve(stiffness(s), load(s, [1.0, 0.0])),
    "fixed unknowns": lambda s: solve(stiffness(s), load(s, 1.0), [99]),
    "two or more": lambda s: convergence(lambda _: {"e": 1.0}, [s.mesh]),
    "other arguments": lambda s: stiffness(s, lambda x, y: x + y),
    "points: missing": lambda s: s.boundary_dofs(lambda x, y: x < y),
    "stokes: force": lambda s: stokes(s.mesh, 2, 0.0),
    "stokes: velocity": lambda s: stokes(s.mesh, 2, velocity=lambda p: p[:, 0]),
    "a pressure": lambda s: Plate(s.mesh).load((1.0, 2.0)),
    "complex": lambda s: load(s, lambda p: 1j * p[:, 0]),
    "gives shape": lambda s: load(s, lambda p: 1.0),
    "not real and symmetric": lambda s: modes(s, stiffness(s) + advection(s), mass(s), 2, s.boundary_dofs("left")),
    "mass is not positive": lambda s: modes(s, stiffness(s), -mass(s), 2, s.boundary_dofs("left")),
    "an eigenproblem": lambda s: buckling(s, stiffness(s) + advection(s), -mass(s), 2, s.boundary_dofs("left")),
    "a start of shape": lambda s: list(theta_steps(mass(s), stiffness(s), np.zeros(3), 0.1, 1)),
    "complex numbers": lambda s: newton(s, lambda u, v, w: u.value * v.value, 1j * np.ones(s.n_dofs)),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    space = Space(rectangle_grid(1.0, 1.0, 3, 3, cells="quadrilaterals"), Virtual(1))
    with pytest.raises(InputError, match=words):
        WRONG[words](space)


@pytest.mark.parametrize(
    ("element", "cells"),
    [(Lagrange(3), "triangles"), (Virtual(2), "duals"), (Virtual(3), "duals"), (Virtual(5), "duals")],
)
def test_digits_on_curved_edges(element, cells):
    """Stiffness and mass of a disc with curved edges keep ten digits, and reproduce a constant."""
    outline = circle(1.0)
    triangles = curved(triangulate(outline, size=0.4), outline)
    space = Space(triangles if cells == "triangles" else dual(triangles, outline=outline), element)
    np.testing.assert_allclose(space.constant, interpolate(space, lambda p: np.ones(len(p))), atol=1e-13)
    assert Factor(stiffness(space), space.boundary_dofs()).digits > 10.0
    products = Factor(mass(space))
    assert products.digits > 10.0
    np.testing.assert_allclose(products.solve(load(space, 1.0)), space.constant, atol=1e-10)
