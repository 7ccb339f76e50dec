"""Nonlinear virtual elements: the converged solution does not depend on the first guess."""

import numpy as np
import pytest

from benchmarks.first_guesses import TOLERANCE, metal, rubber
from flangeway.elements import Virtual
from flangeway.forms import error_norms, interpolate, newton
from flangeway.geometry import square
from flangeway.mesh import agglomerated, rectangle_grid, triangulate, voronoi
from flangeway.space import Space

UNIT = square(1.0, (0.5, 0.5))
MESHES = {
    "voronoi": lambda: voronoi(UNIT, 20, iterations=3),
    "squares": lambda: rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals"),
    "not convex": lambda: agglomerated(triangulate(UNIT, size=0.15), 15),
}


def exact(p):
    return np.cbrt(1.2 + p[:, 0] ** 2 - p[:, 1] ** 2)


def gradient(p):
    return np.stack((2.0 * p[:, 0], -2.0 * p[:, 1]), axis=1) / 3.0 / exact(p)[:, None] ** 2


@pytest.mark.parametrize(("name", "order"), [("voronoi", 1), ("squares", 1), ("not convex", 2)])
def test_the_solution_of_a_degenerate_diffusion_is_that_of_every_guess(name, order):
    """``div(u^2 grad u) = 0`` from 0.5, 1 and 30: the same to 1e-7, and near the exact root of a harmonic function."""
    space = Space(MESHES[name](), Virtual(order))
    fixed, prescribed = space.boundary_dofs(), interpolate(space, exact)
    solutions = []
    for guess in (0.5, 1.0, 30.0):
        start = guess * interpolate(space, lambda p: np.ones(len(p)))
        start[fixed] = prescribed[fixed]
        solution = newton(space, lambda u, v, _: u.value**2 * (u.gradient * v.gradient).sum(axis=1), start, fixed=fixed)
        if solution.status.converged:
            solutions.append(solution.dofs)
            assert 0.0 < solution.status.stabilisation < 0.3
    assert len(solutions) == 3
    assert np.ptp(solutions, axis=0).max() < 1e-7
    assert error_norms(space, solutions[0], exact, gradient).l2 < (0.02 if order == 1 else 0.003)


@pytest.mark.parametrize("guess", [-30.0, -10.0, 10.0])
def test_steps_to_where_a_law_overflows_are_halved(guess):
    """``div(exp(u) grad u) = 0``, from where full steps overflow: near the logarithm of a harmonic function."""
    space = Space(MESHES["voronoi"](), Virtual(1))
    fixed, prescribed = space.boundary_dofs(), interpolate(space, lambda p: 3.0 * np.log(exact(p)))
    start = guess * interpolate(space, lambda p: np.ones(len(p)))
    start[fixed] = prescribed[fixed]
    with np.errstate(all="ignore"):
        solution = newton(
            space, lambda u, v, _: np.exp(u.value) * (u.gradient * v.gradient).sum(axis=1), start, fixed=fixed
        )
    assert solution.status.converged
    np.testing.assert_allclose(solution.dofs, prescribed, atol=0.05)


@pytest.mark.parametrize(("problem", "name"), [(rubber, "squares"), (metal, "squares"), (metal, "not convex")])
def test_loads_along_other_paths_and_repeated_loads_have_the_same_solution(problem, name):
    """Neo-Hooke along five paths, and hardening J2 unloaded in part and loaded again: the displacements to 1e-6."""
    _, solutions = problem(Space(MESHES[name](), Virtual(1)), np.random.default_rng(1))
    assert len(solutions) > 3
    assert np.ptp(solutions, axis=0).max() < TOLERANCE * np.abs(solutions[0]).max()
