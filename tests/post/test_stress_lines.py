"""Stresses and displacements at points, along lines and through cuts, and what is derived from stresses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import (
    Stresses,
    cell_stresses,
    displacements_at,
    force_through_cut,
    locate,
    nodal_stresses,
    stresses_along,
    stresses_at,
)
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.given_displacement import solved

MATERIAL = Elastic(100.0, 0.3)
POLYGONS = dual(triangulate(square(1.0), size=0.15))


def quadratic(points: np.ndarray) -> np.ndarray:
    """A displacement whose stress is in equilibrium without a body force."""
    x, y = points.T
    return 1e-2 * np.stack((x * y, -0.5 * x**2 - 0.5 * y**2 * 0.3 / 0.7), axis=1)


def bending_stress(points: np.ndarray) -> np.ndarray:
    """Pure bending: xx is linear in y, yy and xy are none."""
    y = points[:, 1]
    xx = 100.0 / (1.0 - 0.09) * 1e-2 * y
    return np.stack((xx, 0.0 * y, 0.0 * y, 0.3 * xx), axis=1)


@given(st.lists(st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)), min_size=1, max_size=20))
def test_points_are_found_in_their_cells(points: list) -> None:
    """A located cell holds its point on the left of all its edges, and exactly the points outside have none."""
    given_points = np.array(points)
    cells = locate(POLYGONS, given_points)
    outside = (np.abs(given_points) > 0.5).any(axis=1)
    assert np.array_equal(cells < 0, outside)
    for point, cell in zip(given_points[~outside], cells[~outside], strict=True):
        corners = POLYGONS.points[POLYGONS.cell_points[POLYGONS.cell_offsets[cell] : POLYGONS.cell_offsets[cell + 1]]]
        a, b = corners - point, np.roll(corners, -1, axis=0) - point
        areas = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        assert areas.min() > -1e-9


def test_cells_that_are_not_convex_are_told_apart() -> None:
    """A point in the notch of an L belongs to the square that fills it."""
    points = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [2, 2]], dtype=np.float64)
    mesh = PolyMesh(points, np.array([0, 6, 10]), np.array([0, 1, 2, 3, 4, 5, 3, 2, 6, 4]))
    assert locate(mesh, [[1.5, 1.5], [0.5, 1.5], [1.5, 0.5], [2.5, 0.5]]).tolist() == [1, 0, 0, -1]


@pytest.mark.parametrize(
    ("mesh", "element"), [(triangulate(square(1.0), size=0.3), Lagrange(2)), (POLYGONS, Virtual(2))]
)
def test_pure_bending_everywhere(mesh: PolyMesh, element) -> None:
    """Order 2 has the stresses and displacements of pure bending at points, on a line, at nodes, and cells' means."""
    solution = solved(Space(mesh, element), MATERIAL, quadratic)
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (50, 2))
    assert stresses_at(solution, points).components == pytest.approx(bending_stress(points), abs=1e-9)
    assert displacements_at(solution, points) == pytest.approx(quadratic(points), abs=1e-12)
    means = cell_stresses(solution.problem, solution.displacements).components
    assert means == pytest.approx(bending_stress(mesh.cell_centroids), abs=1e-9)
    line = stresses_along(solution, (0.1, -0.5), (0.1, 0.7), 13)
    inside = line.points[:, 1] < 0.5 + 1e-12
    assert line.distances == pytest.approx(np.linspace(0.0, 1.2, 13))
    assert line.stresses.components[inside] == pytest.approx(bending_stress(line.points[inside]), abs=1e-9)
    assert np.isnan(line.stresses.components[~inside]).all()
    assert inside.sum() == 11
    used = np.unique(mesh.cell_points)
    assert nodal_stresses(solution).components[used] == pytest.approx(bending_stress(mesh.points[used]), abs=1e-9)


def test_a_cut_carries_the_bending_moment() -> None:
    """The force through any straight cut of pure bending has the moment of the linear stress, oblique or not."""
    solution = solved(Space(POLYGONS, Virtual(2)), MATERIAL, quadratic)
    moment = -100.0 / 0.91 * 1e-2 / 12.0
    for top in (0.1, 0.35):
        cut = force_through_cut(solution, (0.1, -0.6), (top, 0.6))
        assert cut.force == pytest.approx([0.0, 0.0], abs=1e-9)
        assert cut.moment == pytest.approx(moment)
    straight, back = (
        force_through_cut(solution, *ends) for ends in (((0.1, 0.0), (0.1, 0.6)), ((0.1, 0.6), (0.1, 0.0)))
    )
    assert straight.length == pytest.approx(0.5)
    assert straight.force[0] == pytest.approx(100.0 / 0.91 * 1e-2 * 0.125)
    assert back.force == pytest.approx(-straight.force)


def test_a_cut_of_a_ring_counts_the_circumference() -> None:
    """A horizontal cut of a pressed tube carries the pressure times its area, seen from below."""
    problem = Elasticity(
        Space(dual(rectangle_grid(1.0, 1.0, 6, 6, origin=(1.0, 0.0))), Virtual(2)),
        Elastic(100.0, 0.3, "axisymmetric"),
        loads=[Pressure("top", 2.0)],
        supports=[PrescribedDisplacement("bottom", y=0.0)],
    )
    cut = force_through_cut(solve_elasticity(problem), (3.0, 0.4), (0.0, 0.4))
    assert cut.force[1] == pytest.approx(-2.0 * np.pi * 3.0)


def test_invariants_of_known_states() -> None:
    """Uniaxial tension, pure shear and hydrostatic pressure have the textbook's invariants."""
    states = Stresses(np.array([[100.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0, 0.0], [-7.0, -7.0, 0.0, -7.0]]))
    assert states.von_mises == pytest.approx([100.0, 40.0 * np.sqrt(3.0), 0.0])
    assert states.in_plane_shear == pytest.approx([50.0, 40.0, 0.0])
    assert states.principal == pytest.approx(np.array([[100.0, 0.0, 0.0], [40.0, 0.0, -40.0], [-7.0, -7.0, -7.0]]))


def test_principal_stresses_are_eigenvalues() -> None:
    """For random states the principal stresses are the eigenvalues of the tensor, zz included."""
    components = np.random.default_rng(0).normal(size=(50, 4))
    for row, principal in zip(components, Stresses(components).principal, strict=True):
        tensor = np.array([[row[0], row[2], 0.0], [row[2], row[1], 0.0], [0.0, 0.0, row[3]]])
        assert np.linalg.eigvalsh(tensor)[::-1] == pytest.approx(principal)
