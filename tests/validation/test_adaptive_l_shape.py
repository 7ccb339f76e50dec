"""Adaptive refinement of an L-shaped body against its exact solution, and the loop that drives it."""

import numpy as np
import pytest

from flangeway.elements import Element, Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, check, dual, rectangle_grid, refined
from flangeway.post.recovery import adapt, recovered_stresses, stress_errors
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.validation.notch import EXPONENT, Notch

MATERIAL = Elastic(1.0, 0.3)
EXACT = Notch(shear_modulus=1.0 / 2.6, kolosov=3.0 - 4.0 * 0.3)


def l_shape(n: int, cells: str = "quadrilaterals") -> PolyMesh:
    """The square from (-1, -1) to (1, 1) without its lower left quarter, with the edge sets ``outer`` and ``notch``.

    - `n`: number of squares along a length of one.
    - `cells`: ``"quadrilaterals"``, ``"triangles"``, or ``"polygons"``, the dual of these.
    """
    grid = rectangle_grid(
        2.0,
        2.0,
        2 * n,
        2 * n,
        cells="quadrilaterals" if cells == "quadrilaterals" else "triangles",
        origin=(-1.0, -1.0),
    )
    kept = (grid.cell_centroids > 0.0).any(axis=1)
    size = int(grid.cell_sizes[0])
    used, corners = np.unique(grid.cell_points.reshape(-1, size)[kept], return_inverse=True)
    offsets = np.arange(kept.sum() + 1, dtype=np.int32) * size
    mesh = PolyMesh(grid.points[used], offsets, corners.astype(np.int32).ravel())
    if cells == "polygons":
        mesh = dual(mesh)
    middles = np.abs(mesh.points[mesh.boundary_edges].mean(axis=1))
    outer = (middles > 1.0 - 1e-9).any(axis=1)
    return mesh.with_edge_set("outer", mesh.boundary_edges[outer]).with_edge_set("notch", mesh.boundary_edges[~outer])


def solver(element: Element):
    """Plane strain with the exact displacements along ``outer`` and a free notch."""
    held = PrescribedDisplacement(
        "outer", x=lambda p: EXACT.displacements(p)[:, 0], y=lambda p: EXACT.displacements(p)[:, 1]
    )
    return lambda mesh: solve_elasticity(Elasticity(Space(mesh, element), MATERIAL, supports=[held]))


def measured(found):
    """Unknowns and relative error in energy; the degree is high because the exact stresses are no polynomials."""
    error, size = stress_errors(found, EXACT.stresses, degree=12)
    return 2 * found.problem.space.n_nodes, error / size


def uniform(element, mesh, n_levels):
    """Unknowns and errors on a mesh and its uniform refinements."""
    rows = []
    for level in range(n_levels):
        mesh = refined(mesh) if level else mesh
        rows.append(measured(solver(element)(mesh)))
    return rows


def adaptive(element, mesh, **limits):
    """Steps of a refinement by the recovered stresses."""
    return adapt(solver(element), mesh, lambda found: recovered_stresses(found).cell_errors, **limits).steps


@pytest.fixture(scope="module")
def quadratic():
    """Steps of order 2, and unknowns and error of each."""
    steps = adaptive(Virtual(2), l_shape(2), tolerance=1e-2)
    return steps, [measured(step.solution) for step in steps]


def test_the_exact_stresses_are_those_of_the_exact_displacements():
    """Stresses agree with Hooke's law on differences of displacements, are in equilibrium, and leave the notch free."""
    rng = np.random.default_rng(5)
    points, h = rng.uniform(0.1, 0.9, size=(20, 2)), 1e-5
    steps = np.array([[h, 0.0], [0.0, h]])
    slope = [(EXACT.displacements(points + s) - EXACT.displacements(points - s)) / (2 * h) for s in steps]
    strain = np.stack((slope[0][:, 0], slope[1][:, 1], slope[0][:, 1] + slope[1][:, 0]), axis=1)
    np.testing.assert_allclose(strain @ MATERIAL.matrix[:3, :3].T, EXACT.stresses(points), rtol=1e-6, atol=1e-8)
    by_x, by_y = ((EXACT.stresses(points + s) - EXACT.stresses(points - s)) / (2 * h) for s in steps)
    np.testing.assert_allclose(by_x[:, 0] + by_y[:, 2], 0.0, atol=1e-7)
    np.testing.assert_allclose(by_x[:, 2] + by_y[:, 1], 0.0, atol=1e-7)
    down, left = EXACT.stresses([[0.0, -0.3]])[0], EXACT.stresses([[-0.3, 0.0]])[0]
    np.testing.assert_allclose([down[0], down[2], left[1], left[2]], 0.0, atol=1e-12)
    assert np.sin(1.5 * np.pi * EXPONENT) + EXPONENT * np.sin(1.5 * np.pi) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.ci
def test_adaptive_reaches_the_error_of_uniform_with_a_tenth_of_the_unknowns():
    """From polygons (quadrilaterals: `reproduce elasticity`): ten times fewer unknowns for the finest mesh's error."""
    element, mesh = Virtual(1), l_shape(4, "polygons")
    n_finest, finest = uniform(element, mesh, 5)[-1]
    steps = adaptive(element, mesh, tolerance=1e-9, most_steps=12)
    first = next(n for n, error in (measured(step.solution) for step in steps) if error <= finest)
    assert n_finest > 10 * first
    check(steps[-1].mesh, region_area=3.0)


@pytest.mark.ci
def test_rates_are_those_of_theory(quadratic):
    """Over unknowns N uniform errors fall as N to minus half the exponent, adaptive ones of order 2 as 1 / N."""
    coarse = uniform(Virtual(2), l_shape(2), 4)

    def rate(rows):
        return -np.polyfit(*np.log(rows).T, 1)[0]

    assert rate(coarse[-3:]) == pytest.approx(EXPONENT / 2, abs=0.02)
    assert rate([row for row in quadratic[1] if row[0] > 1000]) == pytest.approx(1.0, abs=0.15)


def estimates(steps):
    """Estimated over true errors of the steps from 500 unknowns on."""
    fine = [step for step in steps if step.solution.problem.space.n_nodes > 250]
    assert len(fine) > 2
    return np.array([step.error / stress_errors(step.solution, EXACT.stresses, degree=12)[0] for step in fine])


def test_the_estimate_is_near_the_true_error():
    """From 500 unknowns on it is 0.8 to 1.25 times the true error."""
    found = estimates(adaptive(Virtual(1), l_shape(2), tolerance=0.06))
    assert ((found > 0.8) & (found < 1.25)).all()


@pytest.mark.ci
def test_the_estimate_of_order_2_errs_on_the_safe_side(quadratic):
    """From 500 unknowns on it is 0.8 to 1.7 times the true error."""
    found = estimates(quadratic[0][:-2])
    assert ((found > 0.8) & (found < 1.7)).all()


def side_errors(mesh):
    """An error that sits at the left side: there the cells' widths."""
    return np.where(mesh.cell_centroids[:, 0] < mesh.cell_diameters, mesh.cell_diameters, 0.0)


def test_the_loop_ends_at_the_tolerance_or_tells_why_not():
    """With enough steps and cells the status is converged; with too few of either it says which."""
    mesh = rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals")

    def run(**limits):
        return adapt(lambda mesh: mesh, mesh, lambda mesh: side_errors(mesh) ** 2, **limits)

    done = run(tolerance=0.02)
    assert done.status.converged
    assert done.last.error <= 0.02 < done.steps[-2].error
    assert done.steps[0].mesh is mesh
    assert done.last.solution is done.last.mesh
    few = run(tolerance=0.02, most_steps=2)
    assert not few.status.converged
    assert len(few.steps) == 2
    assert "2 solutions" in few.status.message
    small = run(tolerance=0.02, most_cells=30)
    assert not small.status.converged
    assert small.last.mesh.n_cells <= 30
    assert "the next mesh has" in small.status.message


@pytest.mark.parametrize(
    ("options", "errors", "word"),
    [
        ({"tolerance": 0.0}, side_errors, "positive tolerance"),
        ({"tolerance": 0.1}, lambda _: np.ones(3), "one for each cell"),
        ({"tolerance": 0.1}, lambda mesh: -np.ones(mesh.n_cells), "zero or more"),
        ({"tolerance": 0.1, "share": 2.0}, side_errors, "share"),
    ],
)
def test_wrong_runs_are_refused(options, errors, word):
    """Tolerances and limits out of range, and estimates of another shape or below zero, are refused."""
    mesh = rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals")
    with pytest.raises(InputError, match=word):
        adapt(lambda mesh: mesh, mesh, errors, **options)
